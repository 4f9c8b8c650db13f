//! Output selection by name: degrees of freedom, branches, bearings, motors, brakes, loads.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::components;
use crate::modes::state_space::signals;
use crate::motion::assemble::load_name;
use crate::motion::assembled::AssembledModel;
use crate::motion::combination::LinearCombination;
use crate::motion::dynamic_model::{DynamicModel, ForceElement};
use crate::motion::outputs::{MotionOutput, MotionOutputs, OutputQuantity};
use crate::motion::signal::Signal;
use crate::plan::prepared_machine::PreparedMachine;

/// Outputs where a study names none: at most so many.
const MAX_DEFAULT_OUTPUTS: usize = 6;

/// The wanted outputs; speeds of what is loaded or driven where none is named.
///
/// # Errors
/// Names that do not exist, what does not follow from the motion.
pub fn select_outputs(
    prepared_machine: &PreparedMachine,
    model: &AssembledModel,
    names: &[String],
) -> Result<MotionOutputs, Error> {
    let machine = &prepared_machine.machine;
    let mut outputs = MotionOutputs::default();
    let usual: Vec<String>;
    let names = match names.is_empty() {
        false => names,
        true => {
            let loaded = machine
                .histories
                .iter()
                .map(|h| h.0)
                .chain(machine.motors.iter().map(|m| m.dof));
            let mut dofs: Vec<usize> = loaded.collect();
            if dofs.is_empty() {
                dofs = (0..machine.dofs.len()).collect();
            }
            let mut seen = Vec::new();
            dofs.retain(|f| {
                !seen.contains(f) && {
                    seen.push(*f);
                    true
                }
            });
            usual = dofs
                .iter()
                .take(MAX_DEFAULT_OUTPUTS)
                .map(|&f| format!("{}.speed", machine.dof_name(f)))
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
        let loaded = select_load(prepared_machine, model, &asked, &mut outputs)?;
        let quantity = match loaded.or_else(|| motors_or_brakes(prepared_machine, model, &asked)) {
            Some(OutputQuantity::Force(at)) if deflection => OutputQuantity::Deflection(at),
            Some(quantity) => {
                if let OutputQuantity::PrescribedTorque(_) | OutputQuantity::FrictionPower(..) =
                    quantity
                {
                    outputs.prescribed.clone_from(&model.prescribed);
                }
                quantity
            }
            None => match signals::parse_output(machine, &asked)? {
                signals::OutputSignal::Dof(dof, times) => {
                    let Some(place) = &model.dofs[dof] else {
                        return Err(no_state_error(name));
                    };
                    let light = |j: usize| model.model.is_massless(j);
                    if let Some(term) = place.terms.iter().find(|term| times == 2 && light(term.0))
                    {
                        let message = format!(
                            "`{name}` is not kept: {} has no inertia, and its equations give no acceleration",
                            model.model.coordinates[term.0]
                        );
                        return Err(
                            Error::new(Code::Conflict, message).with_hint("request its speed")
                        );
                    }
                    let row = push_row(place, &mut outputs);
                    [
                        OutputQuantity::Position(row),
                        OutputQuantity::Speed(row),
                        OutputQuantity::Acceleration(row),
                    ][usize::from(times).min(2)]
                }
                signals::OutputSignal::Support(at) => {
                    let support = &machine.supports[at];
                    match deflection {
                        true => {
                            let apart = LinearCombination {
                                terms: support.deflection.entries().collect(),
                                imposed: None,
                            };
                            let place = apart.substitute(&model.dofs);
                            let place = place.ok_or_else(|| no_state_error(name))?;
                            OutputQuantity::Position(push_row(&place, &mut outputs))
                        }
                        false => {
                            let own = |&(branch, share): &(usize, f64)| {
                                let at = model.branches[branch].first();
                                at.map(|&at| (at, share))
                                    .ok_or_else(|| no_state_error(name))
                            };
                            let sum = support.forces.iter().map(own);
                            outputs.sums.push(sum.collect::<Result<_, Error>>()?);
                            OutputQuantity::Forces(outputs.sums.len() - 1)
                        }
                    }
                }
                // Tooth pairs together: the gears' motion against each other.
                signals::OutputSignal::Force(branch)
                    if deflection && model.branches[branch].len() > 2 =>
                {
                    let apart = LinearCombination {
                        terms: machine.branches[branch].direction.entries().collect(),
                        imposed: None,
                    };
                    let place = apart.substitute(&model.dofs);
                    let place = place.ok_or_else(|| no_state_error(name))?;
                    OutputQuantity::Position(push_row(&place, &mut outputs))
                }
                // The forces of all flanks or tooth pairs.
                signals::OutputSignal::Force(branch)
                    if !deflection && model.branches[branch].len() > 1 =>
                {
                    let flanks = model.branches[branch].iter();
                    outputs.sums.push(flanks.map(|&at| (at, 1.0)).collect());
                    OutputQuantity::Forces(outputs.sums.len() - 1)
                }
                signals::OutputSignal::Force(branch) => {
                    match (model.branches[branch].first(), &model.springs[branch]) {
                        (Some(&at), _) if deflection => OutputQuantity::Deflection(at),
                        (Some(&at), _) => OutputQuantity::Force(at),
                        (None, Some(spring)) => {
                            let row = push_row(&spring.deflection, &mut outputs);
                            match deflection {
                                true => OutputQuantity::Position(row),
                                false => OutputQuantity::Spring {
                                    row,
                                    stiffness: spring.stiffness,
                                    damping: spring.damping,
                                },
                            }
                        }
                        (None, None) => match machine.branches[branch].law {
                            components::BranchLaw::Linear { .. } => {
                                return Err(no_state_error(name));
                            }
                            components::BranchLaw::Rigid => {
                                let message = format!("`{name}` does not follow from the motion");
                                return Err(Error::new(Code::Conflict, message)
                                    .with_hint("both ends of it move as one"));
                            }
                        },
                    }
                }
            },
        };
        outputs.list.push(MotionOutput {
            name: name.clone(),
            unit: unit(prepared_machine, &asked, quantity),
            quantity,
        });
    }
    Ok(outputs)
}

/// Force or torque of loads along or about a degree of freedom.
///
/// # Errors
/// Nothing loads it.
fn select_load(
    prepared_machine: &PreparedMachine,
    model: &AssembledModel,
    name: &str,
    outputs: &mut MotionOutputs,
) -> Result<Option<OutputQuantity>, Error> {
    let machine = &prepared_machine.machine;
    let stem = name.strip_suffix(".load");
    let Some(dof) = stem.and_then(|stem| machine.dof(stem)) else {
        return Ok(None);
    };
    let called = load_name(machine, dof);
    let over_time = model.loads.iter().filter(|load| load.0 == dof);
    let branches = model.model.elements.iter().enumerate();
    let followed: Vec<usize> = branches
        .filter(|(_, b)| b.name == called)
        .map(|(at, _)| at)
        .collect();
    if over_time.clone().count() + followed.len() == 0 {
        let message = format!("`{name}`: nothing loads {}", machine.dof_name(dof));
        let mut loaded: Vec<String> = (machine.histories.iter())
            .map(|h| format!("{}.load", machine.dof_name(h.0)))
            .collect();
        loaded.dedup();
        return Err(
            Error::new(Code::UnknownNode, message).with_hint(match loaded.is_empty() {
                true => "the scene has no [[load]]".to_string(),
                false => format!("there is {}", loaded.join(", ")),
            }),
        );
    }
    let sum = over_time.fold(Signal::default(), |sum, load| sum.plus(&load.1));
    outputs.loads.push((sum, followed));
    Ok(Some(OutputQuantity::Load(outputs.loads.len() - 1)))
}

/// The force of a motor or brake, which are branches of the motion alone, or the torque that a motor gives.
fn motors_or_brakes(
    prepared_machine: &PreparedMachine,
    model: &AssembledModel,
    name: &str,
) -> Option<OutputQuantity> {
    let (stem, what) = name.rsplit_once('.')?;
    let machine = &prepared_machine.machine;
    let is = |element: usize| machine.elements[element].name == stem;
    let motor = machine.motors.iter().any(|m| is(m.element));
    let branch = || model.model.elements.iter().position(|b| b.name == stem);
    let prescribes = || {
        let motions = &model.prescribed.as_ref()?.motions;
        motions.iter().position(|m| m.name == stem)
    };
    // Dry friction of an element that is more than that, or is that alone: its first branch and how many there are.
    let rubs = |kind: &str| {
        let of_kind = |b: &components::FrictionElement| {
            kind.is_empty() || machine.elements[b.element].kind == kind
        };
        machine
            .friction_elements
            .iter()
            .any(|b| is(b.element) && of_kind(b))
    };
    let named = |train: &DynamicModel| {
        let whole = format!("{stem} friction");
        let own = |b: &ForceElement| b.law.is_dry() && (b.name == whole || b.name == stem);
        let first = train.elements.iter().position(own)?;
        let count = train.elements[first..].iter().filter(|b| own(b)).count();
        Some((first, count))
    };
    match what {
        "torque" if motor => prescribes()
            .map(OutputQuantity::PrescribedTorque)
            .or_else(|| branch().map(OutputQuantity::MotorTorque)),
        "force" | "torque" if motor || rubs("brake") => branch().map(OutputQuantity::Force),
        "friction" => rubs("bearing")
            .then(|| named(&model.model))
            .flatten()
            .map(|at| OutputQuantity::Force(at.0)),
        "loss" if rubs("") => {
            let whole = model.prescribed.as_ref().map(|known| &known.whole);
            let (first, count) = named(whole.unwrap_or(&model.model))?;
            Some(OutputQuantity::FrictionPower(first, count))
        }
        _ => None,
    }
}

fn push_row(place: &LinearCombination, outputs: &mut MotionOutputs) -> usize {
    outputs.rows.push(place.clone());
    outputs.rows.len() - 1
}

/// Error of a name that is not among the unknowns.
fn no_state_error(name: &str) -> Error {
    let message =
        format!("`{name}` is not kept: a node without inertia next to dampers lags its neighbours");
    Error::new(Code::Conflict, message)
        .with_hint("request a neighbour, or give the node its inertia, however small")
}

/// Whether angles or lengths: by the axis of the degree of freedom, by the scale of the branch (one for shafts, metres for
/// meshes).
fn unit(prepared_machine: &PreparedMachine, name: &str, quantity: OutputQuantity) -> &'static str {
    let machine = &prepared_machine.machine;
    let turns = match signals::parse_output(machine, name.strip_suffix(".load").unwrap_or(name)) {
        Ok(signals::OutputSignal::Dof(dof, _)) => machine.dofs[dof].axis.is_rotation(),
        Ok(signals::OutputSignal::Support(at)) => machine.supports[at].axis.is_rotation(),
        Ok(signals::OutputSignal::Force(branch)) => {
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
        (OutputQuantity::Position(_) | OutputQuantity::Deflection(_), true) => "rad",
        (OutputQuantity::Position(_) | OutputQuantity::Deflection(_), false) => "m",
        (OutputQuantity::Speed(_), true) => "rad/s",
        (OutputQuantity::Speed(_), false) => "m/s",
        (OutputQuantity::Acceleration(_), true) => "rad/s²",
        (OutputQuantity::Acceleration(_), false) => "m/s²",
        (
            OutputQuantity::Force(_) | OutputQuantity::Forces(_) | OutputQuantity::Spring { .. },
            false,
        ) => "N",
        (
            OutputQuantity::Force(_) | OutputQuantity::Forces(_) | OutputQuantity::Spring { .. },
            true,
        ) => "N·m",
        (OutputQuantity::MotorTorque(_) | OutputQuantity::PrescribedTorque(_), _) => "N·m",
        (OutputQuantity::Load(_), true) => "N·m",
        (OutputQuantity::Load(_), false) => "N",
        (OutputQuantity::FrictionPower(..), _) => "W",
    }
}
