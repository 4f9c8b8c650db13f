//! What is wanted of a motion, by name: freedoms, branches, bearings, motors, brakes and loads.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::parts;
use crate::modes::state_space::signals;
use crate::motion::assemble::load_on;
use crate::motion::combination::Combination;
use crate::motion::moving::Moving;
use crate::motion::outputs::{Output, Outputs, Quantity};
use crate::motion::signal::Signal;
use crate::motion::train::{Branch, Train};
use crate::plan::prepared::Prepared;

/// Outputs where a study names none: at most so many.
const FEW: usize = 6;

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
        let loaded = load(prepared, moving, &asked, &mut outputs)?;
        let quantity = match loaded.or_else(|| motors_or_brakes(prepared, moving, &asked)) {
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

/// What loads exert along or about a freedom.
///
/// # Errors
/// Nothing loads it.
fn load(
    prepared: &Prepared,
    moving: &Moving,
    name: &str,
    outputs: &mut Outputs,
) -> Result<Option<Quantity>, Error> {
    let machine = &prepared.machine;
    let stem = name.strip_suffix(".load");
    let Some(freedom) = stem.and_then(|stem| machine.freedom(stem)) else {
        return Ok(None);
    };
    let called = load_on(machine, freedom);
    let over_time = moving.loads.iter().filter(|load| load.0 == freedom);
    let branches = moving.train.branches.iter().enumerate();
    let followed: Vec<usize> = branches
        .filter(|(_, b)| b.name == called)
        .map(|(at, _)| at)
        .collect();
    if over_time.clone().count() + followed.len() == 0 {
        let message = format!("`{name}`: nothing loads {}", machine.freedom_name(freedom));
        let mut loaded: Vec<String> = (machine.histories.iter())
            .map(|h| format!("{}.load", machine.freedom_name(h.0)))
            .collect();
        loaded.dedup();
        return Err(
            Error::new(Code::UnknownNode, message).hint(match loaded.is_empty() {
                true => "the scene has no [[load]]".to_string(),
                false => format!("there is {}", loaded.join(", ")),
            }),
        );
    }
    let sum = over_time.fold(Signal::default(), |sum, load| sum.plus(&load.1));
    outputs.loads.push((sum, followed));
    Ok(Some(Quantity::Load(outputs.loads.len() - 1)))
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
    let turns = match signals::output(machine, name.strip_suffix(".load").unwrap_or(name)) {
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
        (Quantity::Load(_), true) => "N·m",
        (Quantity::Load(_), false) => "N",
        (Quantity::Loss(..), _) => "W",
    }
}
