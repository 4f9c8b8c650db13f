//! A planetary stage expanded into sun, ring, carrier and planets (Lin & Parker, J. Vib. Acoust. 121 (1999) 316, eqs. (1)–(3)).
//!
//! Rotational: `δ_s = s (z_s θ_s + z_p θ_p − (z_s + z_p) θ_c)`, `δ_r = s (z_r θ_r − z_p θ_p − (z_r − z_p) θ_c)`.
//! Lateral, planet n at ψ, x outwards and y along the turning sense in the carrier's frame:
//! `δ_s = y_s cos(ψ−α) − x_s sin(ψ−α) − x_n sin α − y_n cos α + r_s θ_s + r_p θ_p`,
//! `δ_r = y_r cos(ψ+α) − x_r sin(ψ+α) + x_n sin α − y_n cos α + r_r θ_r − r_p θ_p`,
//! bearing `x_c cos ψ + y_c sin ψ − x_n` and `−x_c sin ψ + y_c cos ψ + r_c θ_c − y_n`.

use std::f64::consts::PI;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::builder::{MachineBuilder, branch_law};
use crate::machine::components::{Gear, GyroscopicTerms, MeshGeometry, StageMember};
use crate::machine::direction::Direction;
use crate::scene::model::{Axis, BranchEnd, ContactParameters, Planetary, PlanetaryGeometry};

/// Node name of planet `n`, counted from 1.
pub fn planet(stage: &Planetary, n: usize) -> String {
    format!("{}.planet_{n}", stage.name.text)
}

/// Moment arms of a stage: numbers of teeth times a scale per mesh, or the given radii with a scale of 1.
struct MomentArms {
    /// Scale from arms to metres for the sun mesh and the ring mesh.
    scale: [f64; 2],
    sun: f64,
    planet: f64,
    ring: f64,
    /// Moment arm of the carrier in the sun mesh and the ring mesh.
    carrier: [f64; 2],
    /// Radius of the planet centres, m.
    centre: f64,
}

fn moment_arms(stage: &Planetary) -> MomentArms {
    let cos = stage.pressure_angles.map(f64::cos);
    match stage.size {
        PlanetaryGeometry::Teeth { teeth, modules } => {
            let half = modules.unwrap_or([2.0; 2]).map(|module| module / 2.0);
            let [sun, planet, ring] = teeth.map(f64::from);
            let carrier = [sun + planet, ring - planet];
            MomentArms {
                scale: [0, 1].map(|mesh| cos[mesh] * half[mesh]),
                sun,
                planet,
                ring,
                carrier,
                centre: half[0] * (sun + planet),
            }
        }
        PlanetaryGeometry::Radii {
            base: [sun, planet, ring],
            carrier,
        } => MomentArms {
            scale: [1.0; 2],
            sun,
            planet,
            ring,
            carrier: cos.map(|c| c * carrier),
            centre: carrier,
        },
    }
}

/// Members that have x and y degrees of freedom in a lateral stage.
pub fn members(stage: &Planetary) -> [&BranchEnd; 3] {
    [&stage.sun, &stage.ring, &stage.carrier]
}

/// Adds the planets, meshes and bearings of a stage to the machine.
pub fn add(builder: &mut MachineBuilder, element: usize, stage: &Planetary) -> Result<(), Error> {
    let arms = moment_arms(stage);
    let [sun, ring, carrier] = [&stage.sun, &stage.ring, &stage.carrier];
    let thetas = [
        builder.rotation_of_end(sun)?,
        builder.rotation_of_end(ring)?,
        builder.rotation_of_end(carrier)?,
    ];
    check_planet_bearing(stage)?;
    check_assembly(builder, stage);
    add_planet_inertia(builder, element, stage, &arms, thetas[2])?;
    let mut meshes = [Vec::new(), Vec::new()];
    for (index, &position) in stage.positions.iter().enumerate() {
        let name = planet(stage, index + 1);
        let theta = builder
            .dof_by_name(&name, Axis::Theta)
            .ok_or_else(|| missing_teeth_error(stage))?;
        builder.mass(element, theta, stage.planet_polar);
        let planet_xy = match stage.lateral {
            true => Some(lateral_planet(
                builder, element, stage, &arms, position, &name,
            )?),
            false => None,
        };
        for mesh in 0..2 {
            let (word, contact) =
                [("sun", &stage.sun_contact), ("ring", &stage.ring_contact)][mesh];
            let member = [sun, ring][mesh];
            let member_arm = [arms.sun, arms.ring][mesh];
            let planet_arm = [arms.planet, -arms.planet][mesh];
            let flank = |alpha: f64| -> Result<Direction, Error> {
                let mut terms = vec![(theta, planet_arm)];
                terms.extend(thetas[mesh].map(|i| (i, member_arm)));
                match planet_xy {
                    None => terms.extend(thetas[2].map(|i| (i, -arms.carrier[mesh]))),
                    Some([x, y]) => {
                        let tilt = [-alpha, alpha][mesh];
                        let (sin, cos) = (position + tilt).sin_cos();
                        let scale = arms.scale[mesh];
                        terms.extend([(x, tilt.sin() / scale), (y, -alpha.cos() / scale)]);
                        if let BranchEnd::Node(node) = member {
                            terms.extend(builder.dof(node, Axis::X)?.map(|i| (i, -sin / scale)));
                            terms.extend(builder.dof(node, Axis::Y)?.map(|i| (i, cos / scale)));
                        }
                    }
                }
                Ok(Direction::new(arms.scale[mesh], terms))
            };
            let (drive, coast) = (
                flank(stage.pressure_angles[mesh])?,
                flank(-stage.pressure_angles[mesh])?,
            );
            let coast = (coast != drive).then_some(coast);
            meshes[mesh].push(builder.machine.branches.len());
            let contact = &phase_shifted_contact(stage, contact, mesh, position);
            builder.contact(
                element,
                Some(format!("{word} to planet {}", index + 1)),
                drive,
                coast,
                contact,
            );
        }
    }
    if let PlanetaryGeometry::Teeth { teeth, .. } = stage.size {
        register_gears(builder, element, stage, teeth, thetas, meshes);
    }
    Ok(())
}

/// Registers sun, ring and planets as gears and members; a fixed sun or ring under a rotating carrier is a fixed member.
fn register_gears(
    builder: &mut MachineBuilder,
    element: usize,
    stage: &Planetary,
    teeth: [u32; 3],
    thetas: [Option<usize>; 3],
    meshes: [Vec<usize>; 2],
) {
    let name = &stage.name.text;
    for (mesh, word, z) in [(0, "sun", teeth[0]), (1, "ring", teeth[2])] {
        let seats = (stage.positions.iter()).map(|&at| mesh_geometry(stage, mesh, at, z));
        let gear = |turning, carrier| Gear {
            element,
            rotation_dof: turning,
            teeth: Some(z),
            carrier,
            branches: meshes[mesh].clone(),
            mesh_geometries: seats.collect(),
        };
        match (thetas[mesh], thetas[2]) {
            (Some(turning), carrier) => builder.machine.gears.push(gear(turning, carrier)),
            (None, Some(carrier)) => builder.machine.members.push(StageMember {
                name: format!("{name}.{word}"),
                gear: gear(carrier, None),
                is_fixed: true,
            }),
            (None, None) => {}
        }
    }
    let [suns, rings] = meshes;
    for (at, branches) in suns.into_iter().zip(rings).enumerate() {
        let name = planet(stage, at + 1);
        let Some(turning) = builder.dof_by_name(&name, Axis::Theta) else {
            continue;
        };
        let gear = Gear {
            element,
            rotation_dof: turning,
            teeth: Some(teeth[1]),
            carrier: thetas[2],
            branches: vec![branches.0, branches.1],
            mesh_geometries: vec![
                planet_seat(stage, 0, teeth[1]),
                planet_seat(stage, 1, teeth[1]),
            ],
        };
        builder.machine.members.push(StageMember {
            name,
            gear,
            is_fixed: false,
        });
    }
}

/// Geometry of the sun (mesh 0) or the ring (mesh 1) in the mesh with a planet at an angular position, rad.
fn mesh_geometry(stage: &Planetary, mesh: usize, position: f64, teeth: u32) -> MeshGeometry {
    let alpha = stage.pressure_angles[mesh];
    let across = [alpha, -alpha].map(|alpha| {
        let (sin, cos) = (position + [-alpha, alpha][mesh]).sin_cos();
        [-sin, cos]
    });
    MeshGeometry {
        angle: position,
        across,
        along: 0.0,
        lever: alpha.cos(),
        cylindrical: cylindrical(stage, mesh, teeth),
        has_module: has_module(stage),
    }
}

/// Geometry of a planet in the mesh with the sun (0) or the ring (1), with x outwards and y in the sense of carrier rotation. The ring
/// loads the flanks opposite to those loaded by the sun.
fn planet_seat(stage: &Planetary, mesh: usize, teeth: u32) -> MeshGeometry {
    let alpha = stage.pressure_angles[mesh];
    let outwards = [-1.0, 1.0][mesh];
    MeshGeometry {
        angle: [PI, 0.0][mesh],
        across: [alpha, -alpha].map(|alpha| [outwards * alpha.sin(), -alpha.cos()]),
        along: 0.0,
        lever: -outwards * alpha.cos(),
        cylindrical: cylindrical(stage, mesh, teeth),
        has_module: has_module(stage),
    }
}

fn has_module(stage: &Planetary) -> bool {
    !matches!(stage.size, PlanetaryGeometry::Teeth { modules: None, .. })
}

/// Module and pitch radius, m, of spur teeth; `None` without module.
fn cylindrical(stage: &Planetary, mesh: usize, teeth: u32) -> Option<[f64; 2]> {
    match stage.size {
        PlanetaryGeometry::Teeth { modules, .. } => {
            modules.map(|modules| [modules[mesh], modules[mesh] * f64::from(teeth) / 2.0])
        }
        PlanetaryGeometry::Radii { .. } => None,
    }
}

/// Contact of a planet at an angular position ψ: its mesh variation lags that of a planet at zero by `z ψ`, with z teeth on the
/// sun or ring. If this member is fixed and the carrier rotates, the variation leads by `z ψ`.
///
/// Source: Parker and Lin, J. Mech. Des. 126 (2004) 68, for the phases between planets; the phase between the sun and ring meshes of
/// one planet, which depends on the tooth thicknesses, is the `phase` of each variation.
fn phase_shifted_contact(
    stage: &Planetary,
    contact: &ContactParameters,
    mesh: usize,
    position: f64,
) -> ContactParameters {
    let mut contact = contact.clone();
    if let PlanetaryGeometry::Teeth { teeth, .. } = &stage.size {
        let is_fixed = matches!([&stage.sun, &stage.ring][mesh], BranchEnd::Ground);
        let lead = f64::from([teeth[0], teeth[2]][mesh]) * position;
        contact.shift_phase(if is_fixed { lead } else { -lead });
    }
    contact
}

/// Rejects a planet bearing stiffness in a stage without lateral planet motion.
fn check_planet_bearing(stage: &Planetary) -> Result<(), Error> {
    if stage.lateral || stage.planet_bearing.is_none() {
        return Ok(());
    }
    let message = format!(
        "`{}` states a stiffness of the planet bearings, but its planets have no lateral degrees of freedom",
        stage.name.text
    );
    Err(Error::new(Code::Conflict, message)
        .with_span(&stage.name.span)
        .with_hint("add `lateral = true`, or leave out `k_bearing`"))
}

/// Warns if equally spaced planets cannot mesh: `(z_s + z_r)/N` must be an integer (Müller, Die Umlaufgetriebe, 2nd ed. 1998, sec. 5.2).
fn check_assembly(builder: &mut MachineBuilder, stage: &Planetary) {
    let PlanetaryGeometry::Teeth {
        teeth: [sun, _, ring],
        ..
    } = stage.size
    else {
        return;
    };
    let n = stage.positions.len();
    let pitch = std::f64::consts::TAU / n as f64;
    let is_pitch = |pair: &[f64]| (pair[1] - pair[0] - pitch).abs() < 1e-6;
    if n > 1
        && stage.positions.windows(2).all(is_pitch)
        && !(u64::from(sun) + u64::from(ring)).is_multiple_of(n as u64)
    {
        let text = format!(
            "{}: {n} equally spaced planets do not fit sun {sun} and ring {ring}: (z_s + z_r)/{n} is not an integer",
            stage.name.text
        );
        builder.add_diagnostic("assembly", text);
    }
}

/// Adds the inertia `n m r²` of planets without lateral motion to the carrier rotation.
fn add_planet_inertia(
    builder: &mut MachineBuilder,
    element: usize,
    stage: &Planetary,
    arms: &MomentArms,
    carrier: Option<usize>,
) -> Result<(), Error> {
    let (Some(mass), Some(carrier), false) = (stage.planet_mass, carrier, stage.lateral) else {
        return Ok(());
    };
    if matches!(stage.size, PlanetaryGeometry::Teeth { modules: None, .. }) && mass > 0.0 {
        let message = format!(
            "`{}` states planet_mass without a module, so its orbit radius is unknown",
            stage.name.text
        );
        return Err(Error::new(Code::MissingKey, message)
            .with_span(&stage.name.span)
            .with_hint("add `module`"));
    }
    builder.mass(
        element,
        carrier,
        mass * stage.positions.len() as f64 * arms.centre * arms.centre,
    );
    Ok(())
}

/// Adds mass, bearing and gyroscopic terms of a planet with lateral motion and returns its degrees of freedom x and y.
fn lateral_planet(
    builder: &mut MachineBuilder,
    element: usize,
    stage: &Planetary,
    arms: &MomentArms,
    position: f64,
    name: &str,
) -> Result<[usize; 2], Error> {
    let [x, y] = [Axis::X, Axis::Y].map(|axis| builder.dof_by_name(name, axis));
    let (Some(x), Some(y)) = (x, y) else {
        return Err(missing_teeth_error(stage));
    };
    let mass = stage.planet_mass.unwrap_or(0.0);
    builder.mass(element, x, mass);
    builder.mass(element, y, mass);
    let (sin, cos) = position.sin_cos();
    let (mut radial, mut tangential) = (vec![(x, -1.0)], vec![(y, -1.0)]);
    if let BranchEnd::Node(carrier) = &stage.carrier {
        let theta = builder.theta(carrier)?;
        tangential.push((theta, arms.centre));
        if let (Some(cx), Some(cy)) = (
            builder.dof(carrier, Axis::X)?,
            builder.dof(carrier, Axis::Y)?,
        ) {
            radial.extend([(cx, cos), (cy, sin)]);
            tangential.extend([(cx, -sin), (cy, cos)]);
        }
        // The bearing load `m r Ω²` rotates with the carrier: only the motion relative to the carrier has a centripetal term.
        let relative = Direction::new(1.0, [(y, 1.0), (theta, -arms.centre)]);
        builder.machine.gyroscopic.push(GyroscopicTerms {
            centripetal: vec![(Direction::unit(x), mass), (relative, mass)],
            outwards: Some((x, mass * arms.centre)),
            across: None,
            ..rotating_frame_terms(element, theta, [x, y], mass)
        });
    }
    for (word, terms) in [("radial", radial), ("tangential", tangential)] {
        let part = Some(format!(
            "bearing of {}, {word}",
            name.rsplit('.').next().unwrap_or(name)
        ));
        builder.branch(
            element,
            part,
            Direction::new(1.0, terms),
            branch_law(stage.planet_bearing, stage.bearing_loss),
        );
    }
    Ok([x, y])
}

/// Gyroscopic terms of a mass in a frame rotating at Ω: `m (ẍ − 2Ωẏ − Ω²x)`, `m (ÿ + 2Ωẋ − Ω²y)`.
pub fn rotating_frame_terms(
    element: usize,
    turning: usize,
    [x, y]: [usize; 2],
    mass: f64,
) -> GyroscopicTerms {
    GyroscopicTerms {
        element,
        spin_dof: turning,
        gyroscopic: vec![(x, y, -2.0 * mass)],
        centripetal: [x, y].map(|i| (Direction::unit(i), mass)).to_vec(),
        outwards: None,
        across: Some([x, y]),
    }
}

fn missing_teeth_error(stage: &Planetary) -> Error {
    Error::new(
        Code::UnknownNode,
        format!("the planets of `{}` have no nodes", stage.name.text),
    )
    .with_span(&stage.name.span)
}
