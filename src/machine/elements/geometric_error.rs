//! Geometric errors along the line of action: `e_b = −gain · waveform(φ + phase)`.
//!
//! An eccentricity ε is a rotating vector: its component along the flank normal n is `ε (n_x cos φ + n_y sin φ)`, for
//! a spur gear ε along the line of action, `2ε/cos α` peak to peak on the pitch circle. An arc of the pitch circle has the factor
//! lever over radius, `cos α cos β`. A universal joint at an angle β has the rotation error `Σ tan²ᵏ(β/2)/k · sin 2kφ`; the first two
//! terms are used (Duditza, Kardangelenkgetriebe und ihre Anwendungen, 1973, for the series).

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::measurement::deviation::GearDeviation;
use crate::gear::measurement::iso1328::{Edition, GearSize};
use crate::machine::builder::MachineBuilder;
use crate::machine::components::{
    ErrorAction, FlankTransfer, Gear, GeometricError, Machine, MeshGeometry,
};
use crate::machine::mesh_cycle;
use crate::scene::laws::Waveform;
use crate::scene::model::{self, Belt, BranchEnd, ErrorCause, ErrorDefinition, Model};

/// Adds a declared geometric error to the branches of its element.
///
/// # Errors
/// An element without such an error; a length without a module to define the scale; a pitch table of a length other than the tooth
/// number.
pub fn add(
    builder: &mut MachineBuilder,
    model: &Model,
    spec: &model::DeclaredError,
) -> Result<(), Error> {
    let error = match spec.cause {
        ErrorCause::Misalignment => coupling_error(builder, model, spec)?,
        ErrorCause::BeltJoint => belt(builder, model, spec)?,
        ErrorCause::Lead => screw(builder, model, spec)?,
        _ => gear(builder, spec)?,
    };
    builder.machine.errors.push(error);
    Ok(())
}

/// Adds the transmission error of flanks from gear files along the line of action, with the period of the mesh cycle.
pub fn add_mesh_flanks(builder: &mut MachineBuilder) {
    let machine = &mut builder.machine;
    for (branch, flanks) in &builder.mesh_flanks {
        let Some(cycle) = mesh_cycle::cycles(machine, *branch).into_iter().next() else {
            continue;
        };
        let loaded = FlankTransfer {
            gain: if flanks.is_coast { -1.0 } else { 1.0 },
            phase: flanks.phase,
        };
        // A branch without a separate coast direction has the transfer of the drive flank.
        let contact = &machine.branches[*branch];
        let is_common = contact.backlash == 0.0 || contact.coast.is_none();
        let opposite = FlankTransfer {
            gain: if is_common { loaded.gain } else { 0.0 },
            ..loaded
        };
        let name = machine.branch_name(*branch);
        machine.errors.push(GeometricError {
            location: name.clone(),
            span: machine.elements[contact.element].span.clone(),
            element: name,
            cause: ErrorCause::Profile,
            rotation_dof: cycle.rotation,
            carrier: cycle.carrier,
            periods_per_rev: (cycle.teeth, 1),
            acts: vec![ErrorAction {
                branch: *branch,
                flanks: match flanks.is_coast {
                    false => [loaded, opposite],
                    true => [opposite, loaded],
                },
            }],
            waveform: flanks.unloaded_te.clone(),
            averaged: Some(flanks.averaged_te.clone()),
            phase_known: true,
            tolerance: 0.0,
            assumed: None,
        });
    }
}

fn gear(builder: &MachineBuilder, spec: &model::DeclaredError) -> Result<GeometricError, Error> {
    let machine = &builder.machine;
    let fixed_member = machine
        .members
        .iter()
        .find(|m| m.is_fixed && m.name == spec.on.text);
    let (turning, gears) = match fixed_member {
        Some(member) => (member.gear.rotation_dof, vec![&member.gear]),
        None => {
            let turning = builder.theta(&spec.on)?;
            (turning, gears(machine, spec, turning)?)
        }
    };
    let first = gears[0];
    let teeth = first.teeth.unwrap_or(1);
    let is_uniform = gears.iter().all(|g| g.teeth == Some(teeth));
    if spec.cause == ErrorCause::Axial && machine.elements[first.element].kind != "worm_pair" {
        let message = format!(
            "`{}` is not a worm, and cause = \"axial\" applies to worms only",
            spec.on.text
        );
        return Err(Error::new(Code::Conflict, message)
            .with_span(&spec.on.span)
            .with_hint("state its effect along the line of action as cause = \"form\""));
    }
    let needs_teeth = spec.cause.is_pitch() || matches!(spec.size, ErrorDefinition::Mesh(_));
    if needs_teeth && !is_uniform {
        let message = format!("`{}` has gears of different tooth numbers", spec.on.text);
        return Err(Error::new(Code::Conflict, message)
            .with_span(&spec.on.span)
            .with_hint("state with `mesh` the pair to which the error belongs"));
    }
    let grade = match spec.size {
        ErrorDefinition::Grade { grade, phase } => Some(from_grade(spec, first, grade, phase)?),
        _ => None,
    };
    let mut acts = Vec::new();
    let zero = first.mesh_geometries.first().map_or(0.0, |seat| seat.angle);
    for gear in &gears {
        for (&branch, seat) in gear.branches.iter().zip(&gear.mesh_geometries) {
            if !seat.has_module {
                return Err(unsized_pair(machine, spec, gear));
            }
            let mut flanks = [
                flank_transfer(spec.cause, seat, 0, zero),
                flank_transfer(spec.cause, seat, 1, zero),
            ];
            // Planets pass a fixed member in the sense of the carrier rotation.
            if fixed_member.is_some() {
                flanks
                    .iter_mut()
                    .for_each(|flank| flank.phase = -flank.phase);
            }
            acts.push(ErrorAction { branch, flanks });
        }
    }
    let location = match &spec.mesh {
        Some(mesh) => format!("{} in {}", spec.on.text, mesh.text),
        None => spec.on.text.clone(),
    };
    let waveform = match &grade {
        Some((waveform, _)) => waveform.clone(),
        None => shape(spec, teeth)?,
    };
    Ok(GeometricError {
        location,
        element: spec.on.text.clone(),
        span: spec.on.span.clone(),
        cause: spec.cause,
        rotation_dof: turning,
        carrier: first.carrier,
        periods_per_rev: (1, 1),
        acts,
        waveform,
        averaged: None,
        phase_known: spec.phase_known,
        tolerance: spec.tolerance,
        assumed: grade.map(|g| g.1),
    })
}

/// Toothed gears on a node, limited to the named pair if any.
fn gears<'a>(
    machine: &'a Machine,
    spec: &model::DeclaredError,
    turning: usize,
) -> Result<Vec<&'a Gear>, Error> {
    let planets = machine.members.iter().filter(|member| !member.is_fixed);
    let on_node = (machine.gears.iter())
        .chain(planets.map(|member| &member.gear))
        .filter(|g| g.rotation_dof == turning && g.teeth.is_some());
    let named = |element: usize| {
        (spec.mesh.as_ref()).is_none_or(|name| machine.elements[element].name == name.text)
    };
    let gears: Vec<&Gear> = on_node.filter(|g| named(g.element)).collect();
    if !gears.is_empty() {
        return Ok(gears);
    }
    let (message, place) = match &spec.mesh {
        Some(mesh) => (
            format!("`{}` has no teeth in `{}`", spec.on.text, mesh.text),
            &mesh.span,
        ),
        None => (
            format!("`{}` has no toothed gear", spec.on.text),
            &spec.on.span,
        ),
    };
    let hint = "an error is declared on the node of a gear, and `mesh` names one of its pairs; of a coupling (cause = \"misalignment\") or a belt (\"belt-joint\") on that element";
    Err(Error::new(Code::UnknownNode, message)
        .with_span(place)
        .with_hint(hint))
}

fn unsized_pair(machine: &Machine, spec: &model::DeclaredError, gear: &Gear) -> Error {
    let name = &machine.elements[gear.element].name;
    let message = format!(
        "`{name}` has no module, so a length on `{}` has no angle",
        spec.on.text
    );
    Error::new(Code::MissingKey, message)
        .with_span(&spec.on.span)
        .with_hint(format!("give `{name}` its `module`"))
}

/// Transfer of a gear's error to a flank: 0 drive, 1 coast.
fn flank_transfer(
    cause: ErrorCause,
    seat: &MeshGeometry,
    flank: usize,
    zero: f64,
) -> FlankTransfer {
    let [x, y] = seat.across[flank];
    let material = [1.0, -1.0][flank];
    match cause {
        _ if cause.is_offset() => FlankTransfer {
            gain: x.hypot(y),
            phase: -y.atan2(x),
        },
        ErrorCause::Axial => FlankTransfer {
            gain: seat.along,
            phase: 0.0,
        },
        _ => FlankTransfer {
            gain: if cause.is_pitch() {
                seat.lever
            } else {
                material
            },
            phase: -(seat.angle - zero),
        },
    }
}

/// Waveform of the error over one revolution.
fn shape(spec: &model::DeclaredError, teeth: u32) -> Result<Waveform, Error> {
    let orders = |terms: &[(u32, f64, f64)], factor: u32| Waveform::Fourier {
        mean: 0.0,
        terms: terms
            .iter()
            .map(|&(n, a, phase)| (n * factor, a, phase))
            .collect(),
    };
    Ok(match &spec.size {
        ErrorDefinition::Orders(terms) => orders(terms, 1),
        ErrorDefinition::Mesh(terms) => orders(terms, teeth),
        ErrorDefinition::Table(values) if spec.cause.is_pitch() => {
            if values.len() != teeth as usize {
                let message = format!(
                    "{} pitches are given, and `{}` has {teeth} teeth",
                    values.len(),
                    spec.on.text
                );
                return Err(Error::new(Code::OutOfRange, message)
                    .with_span(&spec.on.span)
                    .with_hint("a pitch table has one value per tooth"));
            }
            Waveform::Table(match spec.cause {
                ErrorCause::SinglePitch => cumulative_sum(values),
                _ => values.clone(),
            })
        }
        ErrorDefinition::Table(values) => Waveform::Table(values.clone()),
        ErrorDefinition::Travel { values, .. } => Waveform::Table(mirrored(values)),
        ErrorDefinition::Tilt { angle, phase } => {
            let t = (angle / 2.0).tan().powi(2);
            orders(
                &[
                    (2, t, 2.0 * phase - FRAC_PI_2),
                    (4, t * t / 2.0, 4.0 * phase - FRAC_PI_2),
                ],
                1,
            )
        }
        // Only gears have a grade; `gear` handles it.
        ErrorDefinition::Grade { .. } => orders(&[], 1),
        &ErrorDefinition::Joint {
            amplitude, phase, ..
        } => orders(&[(1, amplitude, phase)], 1),
    })
}

/// Waveform of the tolerance of a grade, with its assumption: F_r/2 as eccentricity, F_p/2 once per revolution, f_fα/4 at the mesh,
/// where two tooth pairs share the load, random single pitch deviations within ± f_pt.
fn from_grade(
    spec: &model::DeclaredError,
    gear: &Gear,
    grade: u32,
    phase: f64,
) -> Result<(Waveform, String), Error> {
    let out_of_range = |message: String| {
        let hint = "state an `amplitude`, and its source in a comment";
        Error::new(Code::OutOfRange, message)
            .with_span(&spec.on.span)
            .with_hint(hint)
    };
    let name = Edition::Y1995.name();
    let teeth = gear.teeth.unwrap_or(1);
    let Some([module, radius]) = gear
        .mesh_geometries
        .first()
        .and_then(|seat| seat.cylindrical)
    else {
        return Err(out_of_range(format!(
            "{name} applies to cylindrical gears, and `{}` is not one",
            spec.on.text
        )));
    };
    let (quantity, symbol, share, word, order) = match spec.cause {
        ErrorCause::Eccentricity => (GearDeviation::Runout, "F_r", 0.5, "half", 1),
        ErrorCause::CumulativePitch => (GearDeviation::CumulativePitch, "F_p", 0.5, "half", 1),
        ErrorCause::SinglePitch => (GearDeviation::SinglePitch, "f_pt", 1.0, "", 1),
        _ => (GearDeviation::ProfileForm, "f_fα", 0.25, "a quarter", teeth),
    };
    let size = GearSize {
        teeth,
        module,
        diameter: 2.0 * radius,
        face_width: 0.0,
        helix: 0.0,
        contact_ratio: None,
        designed_short_wave: None,
    };
    let limit = Edition::Y1995
        .unrounded_tolerance(quantity, &size, grade)
        .ok_or_else(|| {
            out_of_range(format!(
                "{name} has no {symbol} for a gear of {teeth} teeth and module {} mm",
                1e3 * module
            ))
        })?;
    if spec.cause == ErrorCause::SinglePitch {
        let assumption = format!(
            "{name} grade {grade}: random pitches within ± f_pt, {:.1} µm, added up to orders 1 to {RANDOM_PITCH_ORDERS}",
            1e6 * limit
        );
        return Ok((random_pitch_errors(limit, teeth, phase), assumption));
    }
    let amplitude = share * limit;
    let assumption = format!(
        "{name} grade {grade}: {word} of {symbol}, {:.1} µm",
        1e6 * amplitude
    );
    let waveform = Waveform::Fourier {
        mean: 0.0,
        terms: vec![(order, amplitude, phase)],
    };
    Ok((waveform, assumption))
}

/// Highest order per revolution of random pitch deviations.
const RANDOM_PITCH_ORDERS: u32 = 10;

/// Independent pitch deviations, uniform within ± `limit`, of variance `limit²/3`: each order has the rms amplitude
/// `2 limit/√(3z)`; cumulative deviations have the factor `1/(2 sin(πn/z))` at order n. Phases are `−π n(n−1)/N` (Schroeder, IEEE
/// Trans. Inf. Theory 16 (1970) 85).
fn random_pitch_errors(limit: f64, teeth: u32, phase: f64) -> Waveform {
    let z = f64::from(teeth);
    let last = RANDOM_PITCH_ORDERS.min((teeth / 2).max(1));
    let term = |n: u32| {
        let single = 2.0 * limit / (3.0 * z).sqrt();
        let phase_shift = -PI * f64::from(n * (n - 1)) / f64::from(last);
        let cumulative = single / (2.0 * (PI * f64::from(n) / z).sin());
        (n, cumulative, f64::from(n) * phase + phase_shift)
    };
    Waveform::Fourier {
        mean: 0.0,
        terms: (1..=last).map(term).collect(),
    }
}

/// Cumulative pitch deviations from single ones less their mean; the last is zero.
fn cumulative_sum(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let mut sum = 0.0;
    values
        .iter()
        .map(|v| {
            sum += v - mean;
            sum
        })
        .collect()
}

/// Misalignment error of a coupling.
fn coupling_error(
    builder: &MachineBuilder,
    model: &Model,
    spec: &model::DeclaredError,
) -> Result<GeometricError, Error> {
    let missing = || no_element(spec, "coupling", "misalignment");
    let coupling = (model.couplings.iter())
        .find(|c| c.name.text == spec.on.text)
        .ok_or_else(missing)?;
    let turning = coupling.between.iter().find_map(|end| match end {
        BranchEnd::Node(node) => Some(builder.theta(node)),
        BranchEnd::Ground => None,
    });
    let branch = first_branch(&builder.machine, &spec.on.text).ok_or_else(missing)?;
    // δ = θ₂ − θ₁ − e, where end 2 leads by e: hence the gain −1.
    Ok(single_branch_error(
        spec,
        turning.ok_or_else(missing)??,
        (1, 1),
        branch,
        -1.0,
        shape(spec, 1)?,
    ))
}

/// Error of a belt joint, one period per belt revolution.
fn belt(
    builder: &MachineBuilder,
    model: &Model,
    spec: &model::DeclaredError,
) -> Result<GeometricError, Error> {
    let missing = || no_element(spec, "belt", "belt-joint");
    let element: &Belt = (model.belts.iter())
        .find(|b| b.name.text == spec.on.text)
        .ok_or_else(missing)?;
    let branch = first_branch(&builder.machine, &spec.on.text).ok_or_else(missing)?;
    let turning = builder.theta(&element.between[0])?;
    let ErrorDefinition::Joint { length, .. } = spec.size else {
        return Err(missing());
    };
    let circle = TAU * element.radii[0];
    if length < circle {
        let message = format!(
            "a belt of {length} m is shorter than the circumference of its pulley, {circle} m"
        );
        return Err(Error::new(Code::OutOfRange, message).with_span(&spec.on.span));
    }
    let periods_per_rev = (nanometres(circle), nanometres(length));
    Ok(single_branch_error(
        spec,
        turning,
        periods_per_rev,
        branch,
        1.0,
        shape(spec, 1)?,
    ))
}

/// Lead error of a screw; a table over its travel is mirrored to a continuous periodic waveform.
fn screw(
    builder: &MachineBuilder,
    model: &Model,
    spec: &model::DeclaredError,
) -> Result<GeometricError, Error> {
    let missing = || no_element(spec, "screw", "lead");
    let element = (model.screws.iter())
        .find(|screw| screw.name.text == spec.on.text)
        .ok_or_else(missing)?;
    let branch = first_branch(&builder.machine, &spec.on.text).ok_or_else(missing)?;
    let turning = builder.theta(&element.between[0])?;
    let periods_per_rev = match spec.size {
        ErrorDefinition::Travel { travel, .. } => (element.lead as i64, nanometres(2.0 * travel)),
        _ => (1, 1),
    };
    Ok(single_branch_error(
        spec,
        turning,
        periods_per_rev,
        branch,
        1.0,
        shape(spec, 1)?,
    ))
}

/// Values of a table followed by their reverse without the end values.
fn mirrored(values: &[f64]) -> Vec<f64> {
    let back = values.iter().skip(1).rev().skip(1);
    values.iter().chain(back).copied().collect()
}

/// Length in whole nanometres, at least 1.
fn nanometres(length: f64) -> i64 {
    ((1e9 * length).round() as i64).max(1)
}

/// Geometric error that acts in a single branch.
fn single_branch_error(
    spec: &model::DeclaredError,
    turning: usize,
    periods_per_rev: (i64, i64),
    branch: usize,
    gain: f64,
    waveform: Waveform,
) -> GeometricError {
    let flanks = [FlankTransfer { gain, phase: 0.0 }; 2];
    GeometricError {
        location: spec.on.text.clone(),
        element: spec.on.text.clone(),
        span: spec.on.span.clone(),
        cause: spec.cause,
        rotation_dof: turning,
        carrier: None,
        periods_per_rev,
        acts: vec![ErrorAction { branch, flanks }],
        waveform,
        averaged: None,
        phase_known: spec.phase_known,
        tolerance: spec.tolerance,
        assumed: None,
    }
}

/// Error message for a cause declared on an element of another kind.
fn no_element(spec: &model::DeclaredError, kind: &str, cause: &str) -> Error {
    let message = format!("there is no {kind} `{}`", spec.on.text);
    Error::new(Code::UnknownNode, message)
        .with_span(&spec.on.span)
        .with_hint(format!(
            "cause = \"{cause}\" is declared by the name of a [[{kind}]]"
        ))
}

/// The first branch of an element.
fn first_branch(machine: &Machine, name: &str) -> Option<usize> {
    let is_of_element =
        |branch: &crate::machine::components::Branch| machine.elements[branch.element].name == name;
    machine.branches.iter().position(is_of_element)
}
