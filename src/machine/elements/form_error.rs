//! Declared errors as surplus along the lines of action they reach: `e_b = −gain · shape(φ + turn)`.
//!
//! A gear off its axis by ε is a vector that turns with it: along the normal n of a flank it is worth `ε (n_x cos φ + n_y sin φ)`, of
//! a spur gear ε along the line of action, `2ε/cos α` from crest to trough on the pitch circle. An arc of the pitch circle is worth
//! its lever over the radius, `cos α cos β`. Axes of a joint at an angle β turn unevenly by `Σ tan²ᵏ(β/2)/k · sin 2kφ`, of which two
//! terms are kept (Duditza, Kardangelenkgetriebe und ihre Anwendungen, 1973, for the series).

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::measurement::iso::{Edition, Size};
use crate::gear::measurement::quantity::Quantity;
use crate::machine::builder::Builder;
use crate::machine::parts::{Acting, FormError, Gear, Machine, Reach, Seat};
use crate::scene::laws::Shape;
use crate::scene::model::{self, Belt, Cause, End, ErrorSize, Model};

/// Puts a declared error where it acts.
///
/// # Errors
/// Nothing there could have such an error; a length where no module gives the machine its size; a pitch table that does not go
/// with the teeth.
pub fn add(builder: &mut Builder, model: &Model, part: &model::FormError) -> Result<(), Error> {
    let error = match part.cause {
        Cause::Misalignment => joint(builder, model, part)?,
        Cause::BeltJoint => belt(builder, model, part)?,
        Cause::Lead => screw(builder, model, part)?,
        _ => gear(builder, part)?,
    };
    builder.machine.errors.push(error);
    Ok(())
}

fn gear(builder: &Builder, part: &model::FormError) -> Result<FormError, Error> {
    let machine = &builder.machine;
    let standing = machine
        .members
        .iter()
        .find(|m| m.stands && m.name == part.on.text);
    let (turning, gears) = match standing {
        Some(member) => (member.gear.turning, vec![&member.gear]),
        None => {
            let turning = builder.theta(&part.on)?;
            (turning, gears(machine, part, turning)?)
        }
    };
    let first = gears[0];
    let teeth = first.teeth.unwrap_or(1);
    let alike = gears.iter().all(|g| g.teeth == Some(teeth));
    if part.cause == Cause::Axial && machine.elements[first.element].kind != "worm_pair" {
        let message = format!(
            "`{}` is no worm, and cause = \"axial\" is of worms",
            part.on.text
        );
        return Err(Error::new(Code::Conflict, message)
            .at(&part.on.place)
            .hint("give what it does to the line of action as cause = \"form\""));
    }
    let counts = part.cause.is_pitch() || matches!(part.size, ErrorSize::Mesh(_));
    if counts && !alike {
        let message = format!(
            "`{}` carries gears of different tooth numbers",
            part.on.text
        );
        return Err(Error::new(Code::Conflict, message)
            .at(&part.on.place)
            .hint("say with `mesh` which pair the error belongs to"));
    }
    let graded = match part.size {
        ErrorSize::Grade { grade, phase } => Some(graded(part, first, grade, phase)?),
        _ => None,
    };
    let mut acts = Vec::new();
    let zero = first.seats.first().map_or(0.0, |seat| seat.angle);
    for gear in &gears {
        for (&branch, seat) in gear.branches.iter().zip(&gear.seats) {
            if !seat.sized {
                return Err(unsized_pair(machine, part, gear));
            }
            let mut flanks = [
                reach(part.cause, seat, 0, zero),
                reach(part.cause, seat, 1, zero),
            ];
            // The planets run through what stands in the sense of the carrier.
            if standing.is_some() {
                flanks.iter_mut().for_each(|flank| flank.turn = -flank.turn);
            }
            acts.push(Acting { branch, flanks });
        }
    }
    let on = match &part.mesh {
        Some(mesh) => format!("{} in {}", part.on.text, mesh.text),
        None => part.on.text.clone(),
    };
    let shape = match &graded {
        Some((shape, _)) => shape.clone(),
        None => shape(part, teeth)?,
    };
    Ok(FormError {
        on,
        element: part.on.text.clone(),
        place: part.on.place.clone(),
        cause: part.cause,
        turning,
        carrier: first.carrier,
        pace: (1, 1),
        acts,
        shape,
        phase_known: part.phase_known,
        tolerance: part.tolerance,
        assumed: graded.map(|g| g.1),
    })
}

/// The toothed gears on a node, or those of the pair that is named.
fn gears<'a>(
    machine: &'a Machine,
    part: &model::FormError,
    turning: usize,
) -> Result<Vec<&'a Gear>, Error> {
    let planets = machine.members.iter().filter(|member| !member.stands);
    let of_node = (machine.gears.iter())
        .chain(planets.map(|member| &member.gear))
        .filter(|g| g.turning == turning && g.teeth.is_some());
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
            &mesh.place,
        ),
        None => (
            format!("`{}` carries no toothed gear", part.on.text),
            &part.on.place,
        ),
    };
    let hint = "an error stands on the node of a gear, and `mesh` names one of its pairs; of a coupling (cause = \"misalignment\") or a belt (\"belt-joint\") on that element";
    Err(Error::new(Code::UnknownNode, message).at(place).hint(hint))
}

fn unsized_pair(machine: &Machine, part: &model::FormError, gear: &Gear) -> Error {
    let name = &machine.elements[gear.element].name;
    let message = format!(
        "`{name}` has no module, so a length on `{}` is no angle",
        part.on.text
    );
    Error::new(Code::MissingKey, message)
        .at(&part.on.place)
        .hint(format!("give `{name}` its `module`"))
}

/// How an error of a gear reaches a flank: 0 drive, 1 coast.
fn reach(cause: Cause, seat: &Seat, flank: usize, zero: f64) -> Reach {
    let [x, y] = seat.across[flank];
    let material = [1.0, -1.0][flank];
    match cause {
        _ if cause.is_offset() => Reach {
            gain: x.hypot(y),
            turn: -y.atan2(x),
        },
        Cause::Axial => Reach {
            gain: seat.along,
            turn: 0.0,
        },
        _ => Reach {
            gain: if cause.is_pitch() {
                seat.lever
            } else {
                material
            },
            turn: -(seat.angle - zero),
        },
    }
}

/// The error over one turn.
fn shape(part: &model::FormError, teeth: u32) -> Result<Shape, Error> {
    let orders = |terms: &[(u32, f64, f64)], each: u32| Shape::Fourier {
        mean: 0.0,
        terms: terms
            .iter()
            .map(|&(n, a, phase)| (n * each, a, phase))
            .collect(),
    };
    Ok(match &part.size {
        ErrorSize::Orders(terms) => orders(terms, 1),
        ErrorSize::Mesh(terms) => orders(terms, teeth),
        ErrorSize::Table(values) if part.cause.is_pitch() => {
            if values.len() != teeth as usize {
                let message = format!(
                    "{} pitches are given, and `{}` has {teeth} teeth",
                    values.len(),
                    part.on.text
                );
                return Err(Error::new(Code::OutOfRange, message)
                    .at(&part.on.place)
                    .hint("a pitch table has one value a tooth"));
            }
            Shape::Table(match part.cause {
                Cause::SinglePitch => added_up(values),
                _ => values.clone(),
            })
        }
        ErrorSize::Table(values) => Shape::Table(values.clone()),
        ErrorSize::Travel { values, .. } => Shape::Table(there_and_back(values)),
        ErrorSize::Tilt { angle, phase } => {
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
        ErrorSize::Grade { .. } => orders(&[], 1),
        &ErrorSize::Joint {
            amplitude, phase, ..
        } => orders(&[(1, amplitude, phase)], 1),
    })
}

/// What a grade allows, and how that was taken: half of F_r as an offset, half of F_p once a turn, a quarter of f_fα at the mesh, where two
/// pairs of teeth share the load, pitches that differ from each other by chance within ± f_pt.
fn graded(
    part: &model::FormError,
    gear: &Gear,
    grade: u32,
    phase: f64,
) -> Result<(Shape, String), Error> {
    let refuse = |message: String| {
        let hint = "state an `amplitude`, and in a comment where it comes from";
        Error::new(Code::OutOfRange, message)
            .at(&part.on.place)
            .hint(hint)
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
        Cause::Eccentricity => (Quantity::Runout, "F_r", 0.5, "half", 1),
        Cause::CumulativePitch => (Quantity::CumulativePitch, "F_p", 0.5, "half", 1),
        Cause::SinglePitch => (Quantity::SinglePitch, "f_pt", 1.0, "", 1),
        _ => (Quantity::ProfileForm, "f_fα", 0.25, "a quarter", teeth),
    };
    let size = Size {
        teeth,
        module,
        diameter: 2.0 * radius,
        face_width: 0.0,
        helix: 0.0,
        contact_ratio: None,
        designed_short_wave: None,
    };
    let limit = Edition::Y1995
        .exact(quantity, &size, grade)
        .ok_or_else(|| {
            refuse(format!(
                "{name} has no {symbol} for a gear of {teeth} teeth and module {} mm",
                1e3 * module
            ))
        })?;
    if part.cause == Cause::SinglePitch {
        let how = format!(
            "{name} grade {grade}: pitches by chance within ± f_pt, {:.1} µm, added up to orders 1 to {BY_CHANCE}",
            1e6 * limit
        );
        return Ok((by_chance(limit, teeth, phase), how));
    }
    let amplitude = share * limit;
    let how = format!(
        "{name} grade {grade}: {word} of {symbol}, {:.1} µm",
        1e6 * amplitude
    );
    let shape = Shape::Fourier {
        mean: 0.0,
        terms: vec![(order, amplitude, phase)],
    };
    Ok((shape, how))
}

/// Orders a turn that pitches by chance are told by.
const BY_CHANCE: u32 = 10;

/// Pitches that are independent of each other and even within ± `limit`, of variance `limit²/3`: each order of theirs has the rms amplitude
/// `2 limit/√(3z)`, and added up from tooth to tooth the n-th is `1/(2 sin(πn/z))` of that. Phases are spread, `−π n(n−1)/N` (Schroeder, IEEE
/// Trans. Inf. Theory 16 (1970) 85).
fn by_chance(limit: f64, teeth: u32, phase: f64) -> Shape {
    let z = f64::from(teeth);
    let last = BY_CHANCE.min((teeth / 2).max(1));
    let term = |n: u32| {
        let single = 2.0 * limit / (3.0 * z).sqrt();
        let spread = -PI * f64::from(n * (n - 1)) / f64::from(last);
        let added = single / (2.0 * (PI * f64::from(n) / z).sin());
        (n, added, f64::from(n) * phase + spread)
    };
    Shape::Fourier {
        mean: 0.0,
        terms: (1..=last).map(term).collect(),
    }
}

/// Cumulative deviations of single ones, whose mean is the size of the pitch and no error: the last is zero.
fn added_up(values: &[f64]) -> Vec<f64> {
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
fn joint(builder: &Builder, model: &Model, part: &model::FormError) -> Result<FormError, Error> {
    let missing = || no_element(part, "coupling", "misalignment");
    let coupling = (model.couplings.iter())
        .find(|c| c.name.text == part.on.text)
        .ok_or_else(missing)?;
    let turning = coupling.between.iter().find_map(|end| match end {
        End::Node(node) => Some(builder.theta(node)),
        End::Ground => None,
    });
    let branch = of_element(&builder.machine, &part.on.text).ok_or_else(missing)?;
    // δ = θ₂ − θ₁ − e, and end 2 leads by e: the gain turns the surplus round.
    Ok(fixed(
        part,
        turning.ok_or_else(missing)??,
        (1, 1),
        branch,
        -1.0,
        shape(part, 1)?,
    ))
}

/// The joint of a belt.
fn belt(builder: &Builder, model: &Model, part: &model::FormError) -> Result<FormError, Error> {
    let missing = || no_element(part, "belt", "belt-joint");
    let found: &Belt = (model.belts.iter())
        .find(|b| b.name.text == part.on.text)
        .ok_or_else(missing)?;
    let branch = of_element(&builder.machine, &part.on.text).ok_or_else(missing)?;
    let turning = builder.theta(&found.between[0])?;
    let ErrorSize::Joint { length, .. } = part.size else {
        return Err(missing());
    };
    let around = TAU * found.radii[0];
    if length < around {
        let message = format!("a belt {length} m long does not go round its pulley of {around} m");
        return Err(Error::new(Code::OutOfRange, message).at(&part.on.place));
    }
    let pace = (nanometres(around), nanometres(length));
    Ok(fixed(part, turning, pace, branch, 1.0, shape(part, 1)?))
}

/// The lead of a screw; a table over its travel is run through there and back, so that no step stands at the ends.
fn screw(builder: &Builder, model: &Model, part: &model::FormError) -> Result<FormError, Error> {
    let missing = || no_element(part, "screw", "lead");
    let found = (model.screws.iter())
        .find(|screw| screw.name.text == part.on.text)
        .ok_or_else(missing)?;
    let branch = of_element(&builder.machine, &part.on.text).ok_or_else(missing)?;
    let turning = builder.theta(&found.between[0])?;
    let pace = match part.size {
        ErrorSize::Travel { travel, .. } => (found.lead as i64, nanometres(2.0 * travel)),
        _ => (1, 1),
    };
    Ok(fixed(part, turning, pace, branch, 1.0, shape(part, 1)?))
}

/// A table over a travel, and back again without its ends.
fn there_and_back(values: &[f64]) -> Vec<f64> {
    let back = values.iter().skip(1).rev().skip(1);
    values.iter().chain(back).copied().collect()
}

/// The nearest whole number of nanometres, one at least.
fn nanometres(length: f64) -> i64 {
    ((1e9 * length).round() as i64).max(1)
}

/// An error that acts in one branch alone.
fn fixed(
    part: &model::FormError,
    turning: usize,
    pace: (i64, i64),
    branch: usize,
    gain: f64,
    shape: Shape,
) -> FormError {
    let flanks = [Reach { gain, turn: 0.0 }; 2];
    FormError {
        on: part.on.text.clone(),
        element: part.on.text.clone(),
        place: part.on.place.clone(),
        cause: part.cause,
        turning,
        carrier: None,
        pace,
        acts: vec![Acting { branch, flanks }],
        shape,
        phase_known: part.phase_known,
        tolerance: part.tolerance,
        assumed: None,
    }
}

/// An error that stands on no element of its kind.
fn no_element(part: &model::FormError, kind: &str, cause: &str) -> Error {
    let message = format!("there is no {kind} `{}`", part.on.text);
    Error::new(Code::UnknownNode, message)
        .at(&part.on.place)
        .hint(format!(
            "cause = \"{cause}\" stands on a [[{kind}]] by its name"
        ))
}

/// The first branch of an element.
fn of_element(machine: &Machine, name: &str) -> Option<usize> {
    let of = |branch: &crate::machine::parts::Branch| machine.elements[branch.element].name == name;
    machine.branches.iter().position(of)
}
