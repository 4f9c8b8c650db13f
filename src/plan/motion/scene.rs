//! A scene ready to move: equations, start, wanted outputs.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::kinematics::{Kinematics, mean_speeds};
use crate::machine::linear::Linear;
use crate::machine::operating::Operating;
use crate::machine::parts::{self, Machine};
use crate::modes::state_space::signals;
use crate::motion::assemble::assemble;
use crate::motion::combination::Combination;
use crate::motion::moving::Moving;
use crate::motion::outputs::{Output, Outputs, Quantity};
use crate::motion::problem::Problem;
use crate::motion::start;
use crate::motion::train::{Branch, Train};
use crate::plan::prepared::Prepared;
use crate::scene::laws::{Curve, Drive};
use crate::scene::start::Start;
use crate::scene::study::SimulateStudy;

/// A scene ready to move.
pub struct MotionScene {
    /// The equations.
    pub moving: Moving,
    /// The state at zero.
    pub start: Vec<f64>,
    /// What is wanted of the motion.
    pub outputs: Outputs,
    /// To this instant, s.
    pub until: f64,
    /// How many equal steps the outputs divide the time into.
    pub samples: usize,
}

/// Samples where a study names no number.
pub const SAMPLES: u32 = 1000;

/// Outputs where a study names none: at most so many.
const FEW: usize = 6;

impl MotionScene {
    /// Assembles, finds the start, resolves the outputs.
    ///
    /// # Errors
    /// What has no motion in time; names that do not exist; a study without an end.
    pub fn new(
        prepared: &Prepared,
        begin: &Start,
        study: &SimulateStudy,
    ) -> Result<MotionScene, Error> {
        let Some(until) = study.until else {
            let error = Error::new(Code::MissingKey, "nothing says how long the motion lasts");
            return Err(error.hint("add --until \"2 s\", or `until` to the study"));
        };
        if !(until.is_finite() && until > 0.0) {
            let error = Error::new(
                Code::OutOfRange,
                format!("a motion until {until} s cannot be"),
            );
            return Err(error.hint("--until takes a time above zero"));
        }
        let Prepared {
            machine,
            kinematics,
            ..
        } = prepared;
        let speeds = match machine.speeds.is_empty() && study.speed.is_none() {
            true => None,
            false => Some(mean_speeds(machine, kinematics, study.speed)?),
        };
        let shifted;
        let machine = match study.speed {
            None => machine,
            Some(_) => {
                shifted = at_speed(machine, kinematics, speeds.as_deref())?;
                &shifted
            }
        };
        let moving = assemble(machine, kinematics, begin.phase, speeds.as_deref())?;
        let linear = Linear::new(machine, kinematics, &Operating::default())?;
        let mut start = start::state(&moving, &linear, speeds.as_deref(), begin.at, 0.0)?;
        let n = moving.train.n();
        let carried = moving.carried(0.0);
        for (list, offset) in [(&begin.angles, 0), (&begin.speeds, n)] {
            for (name, value) in list {
                let stays = machine
                    .freedom(&name.text)
                    .and_then(|f| linear.free.iter().position(|&i| i == f));
                if let Some(None) = stays.map(|i| moving.place(i)) {
                    let message = format!(
                        "`{}` has no start of its own: it moves as a motor prescribes, or has no inertia and follows its neighbours",
                        name.text
                    );
                    return Err(Error::new(Code::Conflict, message)
                        .at(&name.place)
                        .hint("leave its start out"));
                }
                let Some(j) = stays.and_then(|i| moving.place(i)) else {
                    let message = format!(
                        "`{}` is no freedom that stays: rigid joints tie it to another, or it does not exist",
                        name.text
                    );
                    let hint = format!(
                        "name one of {}",
                        crate::base::words::listed(
                            moving.train.coordinates.iter().map(String::as_str)
                        )
                    );
                    return Err(Error::new(Code::NoSuchFreedom, message)
                        .at(&name.place)
                        .hint(hint));
                };
                let known = if offset == 0 {
                    carried[j].0
                } else {
                    carried[j].1
                };
                start[offset + j] = *value - known;
            }
        }
        let outputs = outputs(prepared, &moving, &study.outputs)?;
        let samples = study.samples.unwrap_or(SAMPLES) as usize;
        debug_assert_eq!(start.len(), moving.train.len());
        Ok(MotionScene {
            moving,
            start,
            outputs,
            until,
            samples,
        })
    }
}

/// The machine with its motors set to other speeds, as a converter does: the same torque at the same slip.
fn at_speed(
    machine: &Machine,
    kinematics: &Kinematics,
    speeds: Option<&[f64]>,
) -> Result<Machine, Error> {
    let mut machine = machine.clone();
    let before = match machine.speeds.is_empty() {
        true => None,
        false => Some(mean_speeds(&machine, kinematics, None)?),
    };
    for motor in &mut machine.motors {
        let speed = |list: Option<&[f64]>| list.map_or(0.0, |s| s[motor.freedom]);
        let (old, new) = (speed(before.as_deref()), speed(speeds));
        match &mut motor.drive {
            Drive::Curve { curve, .. } => *curve = shifted(curve, new - old),
            Drive::Speed(course) if old != 0.0 => {
                course.points.iter_mut().for_each(|p| p.1 *= new / old);
            }
            Drive::Speed(_) | Drive::Angle(_) => {}
        }
    }
    Ok(machine)
}

/// A torque curve moved along its speeds.
fn shifted(curve: &Curve, by: f64) -> Curve {
    match curve {
        Curve::Straight { stall, idle } => Curve::Straight {
            stall: stall * (idle + by) / idle,
            idle: idle + by,
        },
        Curve::Induction {
            pull_out,
            slip,
            synchronous,
        } => Curve::Induction {
            pull_out: *pull_out,
            slip: slip * synchronous / (synchronous + by),
            synchronous: synchronous + by,
        },
        Curve::Table(points) => Curve::Table(points.iter().map(|p| (p.0 + by, p.1)).collect()),
    }
}

/// The wanted outputs; speeds of what is loaded or driven where none is named.
///
/// # Errors
/// Names that do not exist, what does not follow from the motion.
pub fn outputs(prepared: &Prepared, moving: &Moving, names: &[String]) -> Result<Outputs, Error> {
    let machine = &prepared.machine;
    let mut outputs = Outputs::default();
    let usual: Vec<String>;
    let names = match names.is_empty() {
        false => names,
        true => {
            let loaded = machine
                .histories
                .iter()
                .map(|h| h.0)
                .chain(machine.motors.iter().map(|m| m.freedom));
            let mut freedoms: Vec<usize> = loaded.collect();
            if freedoms.is_empty() {
                freedoms = (0..machine.freedoms.len()).collect();
            }
            let mut seen = Vec::new();
            freedoms.retain(|f| {
                !seen.contains(f) && {
                    seen.push(*f);
                    true
                }
            });
            usual = freedoms
                .iter()
                .take(FEW)
                .map(|&f| format!("{}.speed", machine.freedom_name(f)))
                .collect();
            &usual
        }
    };
    for (at, name) in names.iter().enumerate() {
        if names[..at].contains(name) {
            continue;
        }
        let (asked, deflection) = match name.strip_suffix(".deflection") {
            Some(stem) => (format!("{stem}.force"), true),
            None => (name.clone(), false),
        };
        let quantity = match motors_or_brakes(prepared, moving, &asked) {
            Some(Quantity::Force(at)) if deflection => Quantity::Deflection(at),
            Some(quantity) => {
                if let Quantity::Drive(_) | Quantity::Loss(..) = quantity {
                    outputs.prescribed.clone_from(&moving.prescribed);
                }
                quantity
            }
            None => match signals::output(machine, &asked)? {
                signals::Output::Freedom(freedom, times) => {
                    let Some(place) = &moving.freedoms[freedom] else {
                        return Err(remembers(name));
                    };
                    let light = |j: usize| moving.train.is_light(j);
                    if let Some(term) = place.terms.iter().find(|term| times == 2 && light(term.0))
                    {
                        let message = format!(
                            "`{name}` is not kept: {} has no inertia, and its equations give no acceleration",
                            moving.train.coordinates[term.0]
                        );
                        return Err(Error::new(Code::Conflict, message).hint("ask for its speed"));
                    }
                    let row = row_of(place, &mut outputs);
                    [
                        Quantity::Position(row),
                        Quantity::Speed(row),
                        Quantity::Acceleration(row),
                    ][usize::from(times).min(2)]
                }
                signals::Output::Support(at) => {
                    let support = &machine.supports[at];
                    match deflection {
                        true => {
                            let apart = Combination {
                                terms: support.apart.scaled().collect(),
                                imposed: None,
                            };
                            let place = apart.over(&moving.freedoms);
                            let place = place.ok_or_else(|| remembers(name))?;
                            Quantity::Position(row_of(&place, &mut outputs))
                        }
                        false => {
                            let own = |&(branch, share): &(usize, f64)| {
                                let at = moving.branches[branch].first();
                                at.map(|&at| (at, share)).ok_or_else(|| remembers(name))
                            };
                            let sum = support.forces.iter().map(own);
                            outputs.sums.push(sum.collect::<Result<_, Error>>()?);
                            Quantity::Forces(outputs.sums.len() - 1)
                        }
                    }
                }
                signals::Output::Force(branch) => {
                    match (moving.branches[branch].first(), &moving.springs[branch]) {
                        (Some(&at), _) if deflection => Quantity::Deflection(at),
                        (Some(&at), _) => Quantity::Force(at),
                        (None, Some(spring)) => {
                            let row = row_of(&spring.deflection, &mut outputs);
                            match deflection {
                                true => Quantity::Position(row),
                                false => Quantity::Spring {
                                    row,
                                    stiffness: spring.stiffness,
                                    damping: spring.damping,
                                },
                            }
                        }
                        (None, None) => match machine.branches[branch].law {
                            parts::Law::Linear { .. } => return Err(remembers(name)),
                            parts::Law::Rigid => {
                                let message = format!("`{name}` does not follow from the motion");
                                return Err(Error::new(Code::Conflict, message)
                                    .hint("both ends of it move as one"));
                            }
                        },
                    }
                }
            },
        };
        outputs.list.push(Output {
            name: name.clone(),
            unit: unit(prepared, &asked, quantity),
            quantity,
        });
    }
    Ok(outputs)
}

/// The force of a motor or brake, which are branches of the motion alone, or the torque that a motor gives.
fn motors_or_brakes(prepared: &Prepared, moving: &Moving, name: &str) -> Option<Quantity> {
    let (stem, what) = name.rsplit_once('.')?;
    let machine = &prepared.machine;
    let is = |element: usize| machine.elements[element].name == stem;
    let motor = machine.motors.iter().any(|m| is(m.element));
    let branch = || moving.train.branches.iter().position(|b| b.name == stem);
    let prescribes = || {
        let motions = &moving.prescribed.as_ref()?.motions;
        motions.iter().position(|m| m.name == stem)
    };
    // Dry friction of an element that is more than that, or is that alone: its first branch and how many there are.
    let rubs = |kind: &str| {
        let of_kind =
            |b: &parts::Brake| kind.is_empty() || machine.elements[b.element].kind == kind;
        machine.brakes.iter().any(|b| is(b.element) && of_kind(b))
    };
    let named = |train: &Train| {
        let whole = format!("{stem} friction");
        let own = |b: &Branch| b.law.is_dry() && (b.name == whole || b.name == stem);
        let first = train.branches.iter().position(own)?;
        let count = train.branches[first..].iter().filter(|b| own(b)).count();
        Some((first, count))
    };
    match what {
        "torque" if motor => prescribes()
            .map(Quantity::Drive)
            .or_else(|| branch().map(Quantity::Given)),
        "force" | "torque" if motor || rubs("brake") => branch().map(Quantity::Force),
        "friction" => rubs("bearing")
            .then(|| named(&moving.train))
            .flatten()
            .map(|at| Quantity::Force(at.0)),
        "loss" if rubs("") => {
            let whole = moving.prescribed.as_ref().map(|known| &known.whole);
            let (first, count) = named(whole.unwrap_or(&moving.train))?;
            Some(Quantity::Loss(first, count))
        }
        _ => None,
    }
}

fn row_of(place: &Combination, outputs: &mut Outputs) -> usize {
    outputs.rows.push(place.clone());
    outputs.rows.len() - 1
}

/// What has no place among the unknowns.
fn remembers(name: &str) -> Error {
    let message = format!(
        "`{name}` is not kept: a node without inertia beside dampers follows its neighbours late"
    );
    Error::new(Code::Conflict, message)
        .hint("ask for a neighbour, or give the node its inertia, however small")
}

/// Whether angles or lengths: by the axis of the freedom, by the scale of the branch (one for shafts, metres for meshes).
fn unit(prepared: &Prepared, name: &str, quantity: Quantity) -> &'static str {
    let machine = &prepared.machine;
    let turns = match signals::output(machine, name) {
        Ok(signals::Output::Freedom(freedom, _)) => machine.freedoms[freedom].axis.turns(),
        Ok(signals::Output::Support(at)) => machine.supports[at].axis.turns(),
        Ok(signals::Output::Force(branch)) => {
            let kind = machine.elements[machine.branches[branch].element].kind;
            ![
                "gear_pair",
                "worm_pair",
                "planetary",
                "belt",
                "screw",
                "bearing",
            ]
            .contains(&kind)
        }
        Err(_) => true,
    };
    match (quantity, turns) {
        (Quantity::Position(_) | Quantity::Deflection(_), true) => "rad",
        (Quantity::Position(_) | Quantity::Deflection(_), false) => "m",
        (Quantity::Speed(_), true) => "rad/s",
        (Quantity::Speed(_), false) => "m/s",
        (Quantity::Acceleration(_), true) => "rad/s²",
        (Quantity::Acceleration(_), false) => "m/s²",
        (Quantity::Force(_) | Quantity::Forces(_) | Quantity::Spring { .. }, false) => "N",
        (Quantity::Force(_) | Quantity::Forces(_) | Quantity::Spring { .. }, true) => "N·m",
        (Quantity::Given(_) | Quantity::Drive(_), _) => "N·m",
        (Quantity::Loss(..), _) => "W",
    }
}
