//! Geometric errors on their lines of action: `e_b = −gain · waveform(φ + phase)`.
//!
//! A gear off its axis by ε is a vector that turns with it: along the normal n of a flank it is worth `ε (n_x cos φ + n_y sin φ)`, of
//! a spur gear ε along the line of action, `2ε/cos α` from crest to trough on the pitch circle. An arc of the pitch circle is worth
//! its lever over the radius, `cos α cos β`. Axes of a joint at an angle β turn unevenly by `Σ tan²ᵏ(β/2)/k · sin 2kφ`, of which two
//! terms are kept (Duditza, Kardangelenkgetriebe und ihre Anwendungen, 1973, for the series).

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

/// Puts a declared error where it acts.
///
/// # Errors
/// Nothing there could have such an error; a length where no module gives the machine its size; a pitch table that does not go
/// with the teeth.
pub fn add(
    builder: &mut MachineBuilder,
    model: &Model,
    part: &model::DeclaredError,
) -> Result<(), Error> {
    let error = match part.cause {
        ErrorCause::Misalignment => coupling_error(builder, model, part)?,
        ErrorCause::BeltJoint => belt(builder, model, part)?,
        ErrorCause::Lead => screw(builder, model, part)?,
        _ => gear(builder, part)?,
    };
    builder.machine.errors.push(error);
    Ok(())
}

/// Puts the transmission error of flanks that a gear file describes on their lines of action, by the cycles of their meshes.
pub fn add_mesh_flanks(builder: &mut MachineBuilder) {
    let machine = &mut builder.machine;
    for (branch, flanks) in &builder.mesh_flanks {
        let Some(cycle) = mesh_cycle::cycles(machine, *branch).into_iter().next() else {
            continue;
        };
        let carries = FlankTransfer {
            gain: if flanks.is_coast { -1.0 } else { 1.0 },
            phase: flanks.phase,
        };
        // A branch without a coast direction of its own goes by its first flank.
        let part = &machine.branches[*branch];
        let one_law = part.backlash == 0.0 || part.coast.is_none();
        let other = FlankTransfer {
            gain: if one_law { carries.gain } else { 0.0 },
            ..carries
        };
        let name = machine.branch_name(*branch);
        machine.errors.push(GeometricError {
            location: name.clone(),
            span: machine.elements[part.element].span.clone(),
            element: name,
            cause: ErrorCause::Profile,
            rotation_dof: cycle.turning,
            carrier: cycle.carrier,
            periods_per_rev: (cycle.teeth, 1),
            acts: vec![ErrorAction {
                branch: *branch,
                flanks: match flanks.is_coast {
                    false => [carries, other],
                    true => [other, carries],
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

fn gear(builder: &MachineBuilder, part: &model::DeclaredError) -> Result<GeometricError, Error> {
    let machine = &builder.machine;
    let standing = machine
        .members
        .iter()
        .find(|m| m.is_fixed && m.name == part.on.text);
    let (turning, gears) = match standing {
        Some(member) => (member.gear.rotation_dof, vec![&member.gear]),
        None => {
            let turning = builder.theta(&part.on)?;
            (turning, gears(machine, part, turning)?)
        }
    };
    let first = gears[0];
    let teeth = first.teeth.unwrap_or(1);
    let alike = gears.iter().all(|g| g.teeth == Some(teeth));
    if part.cause == ErrorCause::Axial && machine.elements[first.element].kind != "worm_pair" {
        let message = format!(
            "`{}` is no worm, and cause = \"axial\" is of worms",
            part.on.text
        );
        return Err(Error::new(Code::Conflict, message)
            .with_span(&part.on.span)
            .with_hint("give what it does to the line of action as cause = \"form\""));
    }
    let counts = part.cause.is_pitch() || matches!(part.size, ErrorDefinition::Mesh(_));
    if counts && !alike {
        let message = format!(
            "`{}` carries gears of different tooth numbers",
            part.on.text
        );
        return Err(Error::new(Code::Conflict, message)
            .with_span(&part.on.span)
            .with_hint("state with `mesh` the pair to which the error belongs"));
    }
    let graded = match part.size {
        ErrorDefinition::Grade { grade, phase } => Some(graded(part, first, grade, phase)?),
        _ => None,
    };
    let mut acts = Vec::new();
    let zero = first.seats.first().map_or(0.0, |seat| seat.angle);
    for gear in &gears {
        for (&branch, seat) in gear.branches.iter().zip(&gear.seats) {
            if !seat.has_module {
                return Err(unsized_pair(machine, part, gear));
            }
            let mut flanks = [
                flank_transfer(part.cause, seat, 0, zero),
                flank_transfer(part.cause, seat, 1, zero),
            ];
            // The planets run through what stands in the sense of the carrier.
            if standing.is_some() {
                flanks
                    .iter_mut()
                    .for_each(|flank| flank.phase = -flank.phase);
            }
            acts.push(ErrorAction { branch, flanks });
        }
    }
    let on = match &part.mesh {
        Some(mesh) => format!("{} in {}", part.on.text, mesh.text),
        None => part.on.text.clone(),
    };
    let waveform = match &graded {
        Some((waveform, _)) => waveform.clone(),
        None => shape(part, teeth)?,
    };
    Ok(GeometricError {
        location: on,
        element: part.on.text.clone(),
        span: part.on.span.clone(),
        cause: part.cause,
        rotation_dof: turning,
        carrier: first.carrier,
        periods_per_rev: (1, 1),
        acts,
        waveform,
        averaged: None,
        phase_known: part.phase_known,
        tolerance: part.tolerance,
        assumed: graded.map(|g| g.1),
    })
}

/// The toothed gears on a node, or those of the pair that is named.
fn gears<'a>(
    machine: &'a Machine,
    part: &model::DeclaredError,
    turning: usize,
) -> Result<Vec<&'a Gear>, Error> {
    let planets = machine.members.iter().filter(|member| !member.is_fixed);
    let of_node = (machine.gears.iter())
        .chain(planets.map(|member| &member.gear))
        .filter(|g| g.rotation_dof == turning && g.teeth.is_some());
    let named = |element: usize| {
        (part.mesh.as_ref()).is_none_or(|name| machine.elements[element].name == name.text)
    };
    let gears: Vec<&Gear> = of_node.filter(|g| named(g.element)).collect();
    if !gears.is_empty() {
        return Ok(gears);
    }
    let (message, place) = match &part.mesh {
        Some(mesh) => (
            format!("`{}` has no teeth in `{}`", part.on.text, mesh.text),
            &mesh.span,
        ),
        None => (
            format!("`{}` carries no toothed gear", part.on.text),
            &part.on.span,
        ),
    };
    let hint = "an error is declared on the node of a gear, and `mesh` names one of its pairs; of a coupling (cause = \"misalignment\") or a belt (\"belt-joint\") on that element";
    Err(Error::new(Code::UnknownNode, message)
        .with_span(place)
        .with_hint(hint))
}

fn unsized_pair(machine: &Machine, part: &model::DeclaredError, gear: &Gear) -> Error {
    let name = &machine.elements[gear.element].name;
    let message = format!(
        "`{name}` has no module, so a length on `{}` is no angle",
        part.on.text
    );
    Error::new(Code::MissingKey, message)
        .with_span(&part.on.span)
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

/// The error over one turn.
fn shape(part: &model::DeclaredError, teeth: u32) -> Result<Waveform, Error> {
    let orders = |terms: &[(u32, f64, f64)], each: u32| Waveform::Fourier {
        mean: 0.0,
        terms: terms
            .iter()
            .map(|&(n, a, phase)| (n * each, a, phase))
            .collect(),
    };
    Ok(match &part.size {
        ErrorDefinition::Orders(terms) => orders(terms, 1),
        ErrorDefinition::Mesh(terms) => orders(terms, teeth),
        ErrorDefinition::Table(values) if part.cause.is_pitch() => {
            if values.len() != teeth as usize {
                let message = format!(
                    "{} pitches are given, and `{}` has {teeth} teeth",
                    values.len(),
                    part.on.text
                );
                return Err(Error::new(Code::OutOfRange, message)
                    .with_span(&part.on.span)
                    .with_hint("a pitch table has one value a tooth"));
            }
            Waveform::Table(match part.cause {
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
        // A grade says something of gears alone, and is taken before.
        ErrorDefinition::Grade { .. } => orders(&[], 1),
        &ErrorDefinition::Joint {
            amplitude, phase, ..
        } => orders(&[(1, amplitude, phase)], 1),
    })
}

/// Amplitude allowed by a grade, and its assumption: half of F_r as an offset, half of F_p once a turn, a quarter of f_fα at the mesh,
/// where two pairs of teeth share the load, pitches that differ from each other by chance within ± f_pt.
fn graded(
    part: &model::DeclaredError,
    gear: &Gear,
    grade: u32,
    phase: f64,
) -> Result<(Waveform, String), Error> {
    let refuse = |message: String| {
        let hint = "state an `amplitude`, and in a comment where it comes from";
        Error::new(Code::OutOfRange, message)
            .with_span(&part.on.span)
            .with_hint(hint)
    };
    let name = Edition::Y1995.name();
    let teeth = gear.teeth.unwrap_or(1);
    let Some([module, radius]) = gear.seats.first().and_then(|seat| seat.cylindrical) else {
        return Err(refuse(format!(
            "{name} is of cylindrical gears, and `{}` is none",
            part.on.text
        )));
    };
    let (quantity, symbol, share, word, order) = match part.cause {
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
            refuse(format!(
                "{name} has no {symbol} for a gear of {teeth} teeth and module {} mm",
                1e3 * module
            ))
        })?;
    if part.cause == ErrorCause::SinglePitch {
        let how = format!(
            "{name} grade {grade}: pitches by chance within ± f_pt, {:.1} µm, added up to orders 1 to {RANDOM_PITCH_ORDERS}",
            1e6 * limit
        );
        return Ok((random_pitch_errors(limit, teeth, phase), how));
    }
    let amplitude = share * limit;
    let how = format!(
        "{name} grade {grade}: {word} of {symbol}, {:.1} µm",
        1e6 * amplitude
    );
    let waveform = Waveform::Fourier {
        mean: 0.0,
        terms: vec![(order, amplitude, phase)],
    };
    Ok((waveform, how))
}

/// Highest order per turn of random pitch deviations.
const RANDOM_PITCH_ORDERS: u32 = 10;

/// Pitches that are independent of each other and even within ± `limit`, of variance `limit²/3`: each order of theirs has the rms amplitude
/// `2 limit/√(3z)`, and added up from tooth to tooth the n-th is `1/(2 sin(πn/z))` of that. Phases are spread, `−π n(n−1)/N` (Schroeder, IEEE
/// Trans. Inf. Theory 16 (1970) 85).
fn random_pitch_errors(limit: f64, teeth: u32, phase: f64) -> Waveform {
    let z = f64::from(teeth);
    let last = RANDOM_PITCH_ORDERS.min((teeth / 2).max(1));
    let term = |n: u32| {
        let single = 2.0 * limit / (3.0 * z).sqrt();
        let spread = -PI * f64::from(n * (n - 1)) / f64::from(last);
        let added = single / (2.0 * (PI * f64::from(n) / z).sin());
        (n, added, f64::from(n) * phase + spread)
    };
    Waveform::Fourier {
        mean: 0.0,
        terms: (1..=last).map(term).collect(),
    }
}

/// Cumulative deviations of single ones, whose mean is the size of the pitch and no error: the last is zero.
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

/// A misaligned coupling.
fn coupling_error(
    builder: &MachineBuilder,
    model: &Model,
    part: &model::DeclaredError,
) -> Result<GeometricError, Error> {
    let missing = || no_element(part, "coupling", "misalignment");
    let coupling = (model.couplings.iter())
        .find(|c| c.name.text == part.on.text)
        .ok_or_else(missing)?;
    let turning = coupling.between.iter().find_map(|end| match end {
        BranchEnd::Node(node) => Some(builder.theta(node)),
        BranchEnd::Ground => None,
    });
    let branch = first_branch(&builder.machine, &part.on.text).ok_or_else(missing)?;
    // δ = θ₂ − θ₁ − e, and end 2 leads by e: the gain turns the surplus round.
    Ok(single_branch_error(
        part,
        turning.ok_or_else(missing)??,
        (1, 1),
        branch,
        -1.0,
        shape(part, 1)?,
    ))
}

/// The joint of a belt.
fn belt(
    builder: &MachineBuilder,
    model: &Model,
    part: &model::DeclaredError,
) -> Result<GeometricError, Error> {
    let missing = || no_element(part, "belt", "belt-joint");
    let found: &Belt = (model.belts.iter())
        .find(|b| b.name.text == part.on.text)
        .ok_or_else(missing)?;
    let branch = first_branch(&builder.machine, &part.on.text).ok_or_else(missing)?;
    let turning = builder.theta(&found.between[0])?;
    let ErrorDefinition::Joint { length, .. } = part.size else {
        return Err(missing());
    };
    let around = TAU * found.radii[0];
    if length < around {
        let message = format!("a belt {length} m long does not go round its pulley of {around} m");
        return Err(Error::new(Code::OutOfRange, message).with_span(&part.on.span));
    }
    let pace = (nanometres(around), nanometres(length));
    Ok(single_branch_error(
        part,
        turning,
        pace,
        branch,
        1.0,
        shape(part, 1)?,
    ))
}

/// Lead error of a screw; a table over its travel is run through there and back, so that no step occurs at the ends.
fn screw(
    builder: &MachineBuilder,
    model: &Model,
    part: &model::DeclaredError,
) -> Result<GeometricError, Error> {
    let missing = || no_element(part, "screw", "lead");
    let found = (model.screws.iter())
        .find(|screw| screw.name.text == part.on.text)
        .ok_or_else(missing)?;
    let branch = first_branch(&builder.machine, &part.on.text).ok_or_else(missing)?;
    let turning = builder.theta(&found.between[0])?;
    let pace = match part.size {
        ErrorDefinition::Travel { travel, .. } => (found.lead as i64, nanometres(2.0 * travel)),
        _ => (1, 1),
    };
    Ok(single_branch_error(
        part,
        turning,
        pace,
        branch,
        1.0,
        shape(part, 1)?,
    ))
}

/// A table over a travel, and back again without its ends.
fn mirrored(values: &[f64]) -> Vec<f64> {
    let back = values.iter().skip(1).rev().skip(1);
    values.iter().chain(back).copied().collect()
}

/// The nearest whole number of nanometres, one at least.
fn nanometres(length: f64) -> i64 {
    ((1e9 * length).round() as i64).max(1)
}

/// An error that acts in one branch alone.
fn single_branch_error(
    part: &model::DeclaredError,
    turning: usize,
    pace: (i64, i64),
    branch: usize,
    gain: f64,
    waveform: Waveform,
) -> GeometricError {
    let flanks = [FlankTransfer { gain, phase: 0.0 }; 2];
    GeometricError {
        location: part.on.text.clone(),
        element: part.on.text.clone(),
        span: part.on.span.clone(),
        cause: part.cause,
        rotation_dof: turning,
        carrier: None,
        periods_per_rev: pace,
        acts: vec![ErrorAction { branch, flanks }],
        waveform,
        averaged: None,
        phase_known: part.phase_known,
        tolerance: part.tolerance,
        assumed: None,
    }
}

/// Reports an error declared on an element of another kind.
fn no_element(part: &model::DeclaredError, kind: &str, cause: &str) -> Error {
    let message = format!("there is no {kind} `{}`", part.on.text);
    Error::new(Code::UnknownNode, message)
        .with_span(&part.on.span)
        .with_hint(format!(
            "cause = \"{cause}\" is declared on a [[{kind}]] by its name"
        ))
}

/// The first branch of an element.
fn first_branch(machine: &Machine, name: &str) -> Option<usize> {
    let of =
        |branch: &crate::machine::components::Branch| machine.elements[branch.element].name == name;
    machine.branches.iter().position(of)
}
