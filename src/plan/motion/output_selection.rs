//! Selection of motion outputs by name: degrees of freedom, branches, bearings, motors, brakes, loads.

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

/// Maximum number of default outputs, selected if a study names none.
const MAX_DEFAULT_OUTPUTS: usize = 6;

/// Selects the requested outputs; by default the speeds of the loaded and motor-driven degrees of freedom.
///
/// # Errors
/// Unknown names; quantities that the states do not determine.
pub fn select_outputs(
    prepared_machine: &PreparedMachine,
    model: &AssembledModel,
    names: &[String],
) -> Result<MotionOutputs, Error> {
    let machine = &prepared_machine.machine;
    let mut outputs = MotionOutputs::default();
    let default_names: Vec<String>;
    let names = match names.is_empty() {
        false => names,
        true => {
            let loaded_dofs = machine
                .histories
                .iter()
                .map(|h| h.0)
                .chain(machine.motors.iter().map(|m| m.dof));
            let mut dofs: Vec<usize> = loaded_dofs.collect();
            if dofs.is_empty() {
                dofs = (0..machine.dofs.len()).collect();
            }
            let mut distinct = Vec::new();
            dofs.retain(|f| {
                !distinct.contains(f) && {
                    distinct.push(*f);
                    true
                }
            });
            default_names = dofs
                .iter()
                .take(MAX_DEFAULT_OUTPUTS)
                .map(|&f| format!("{}.speed", machine.dof_name(f)))
                .collect();
            &default_names
        }
    };
    for (at, name) in names.iter().enumerate() {
        if names[..at].contains(name) {
            continue;
        }
        let (signal, deflection) = match name.strip_suffix(".deflection") {
            Some(stem) => (format!("{stem}.force"), true),
            None => (name.clone(), false),
        };
        let load = select_load(prepared_machine, model, &signal, &mut outputs)?;
        let quantity = match load.or_else(|| motor_or_brake(prepared_machine, model, &signal)) {
            Some(OutputQuantity::Force(at)) if deflection => OutputQuantity::Deflection(at),
            Some(quantity) => {
                if let OutputQuantity::PrescribedTorque(_) | OutputQuantity::FrictionPower(..) =
                    quantity
                {
                    outputs.prescribed.clone_from(&model.prescribed);
                }
                quantity
            }
            None => match signals::parse_output(machine, &signal)? {
                signals::OutputSignal::Dof(dof, order) => {
                    let Some(motion) = &model.dofs[dof] else {
                        return Err(no_state_error(name));
                    };
                    let massless = |j: usize| model.model.is_massless(j);
                    if let Some(term) = motion.terms.iter().find(|t| order == 2 && massless(t.0)) {
                        let message = format!(
                            "`{name}` is not available: {} has no inertia, and its equations have no acceleration",
                            model.model.coordinates[term.0]
                        );
                        return Err(
                            Error::new(Code::Conflict, message).with_hint("request its speed")
                        );
                    }
                    let row = push_row(motion, &mut outputs);
                    [
                        OutputQuantity::Position(row),
                        OutputQuantity::Speed(row),
                        OutputQuantity::Acceleration(row),
                    ][usize::from(order).min(2)]
                }
                signals::OutputSignal::Support(at) => {
                    let support = &machine.supports[at];
                    match deflection {
                        true => {
                            let relative_displacement = LinearCombination {
                                terms: support.deflection.entries().collect(),
                                imposed: None,
                            };
                            let motion = relative_displacement.substitute(&model.dofs);
                            let motion = motion.ok_or_else(|| no_state_error(name))?;
                            OutputQuantity::Position(push_row(&motion, &mut outputs))
                        }
                        false => {
                            let element_share = |&(branch, share): &(usize, f64)| {
                                let at = model.branches[branch].first();
                                at.map(|&at| (at, share))
                                    .ok_or_else(|| no_state_error(name))
                            };
                            let sum = support.forces.iter().map(element_share);
                            outputs.sums.push(sum.collect::<Result<_, Error>>()?);
                            OutputQuantity::Forces(outputs.sums.len() - 1)
                        }
                    }
                }
                // Several tooth pairs: the relative displacement of the gears.
                signals::OutputSignal::Force(branch)
                    if deflection && model.branches[branch].len() > 2 =>
                {
                    let relative_displacement = LinearCombination {
                        terms: machine.branches[branch].direction.entries().collect(),
                        imposed: None,
                    };
                    let motion = relative_displacement.substitute(&model.dofs);
                    let motion = motion.ok_or_else(|| no_state_error(name))?;
                    OutputQuantity::Position(push_row(&motion, &mut outputs))
                }
                // Sum of the forces of all flanks or tooth pairs.
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
                                let message = format!("`{name}` is not determined by the motion");
                                return Err(Error::new(Code::Conflict, message)
                                    .with_hint("both its ends move alike"));
                            }
                        },
                    }
                }
            },
        };
        outputs.list.push(MotionOutput {
            name: name.clone(),
            unit: unit(prepared_machine, &signal, quantity),
            quantity,
        });
    }
    Ok(outputs)
}

/// Selects the total load on a degree of freedom, N or N·m; `None` for names that do not end in `.load`.
///
/// # Errors
/// No load acts on the degree of freedom.
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
    let element_name = load_name(machine, dof);
    let histories_of_dof = model.loads.iter().filter(|load| load.0 == dof);
    let branches = model.model.elements.iter().enumerate();
    let element_indices: Vec<usize> = branches
        .filter(|(_, b)| b.name == element_name)
        .map(|(at, _)| at)
        .collect();
    if histories_of_dof.clone().count() + element_indices.len() == 0 {
        let message = format!("`{name}`: {} has no load", machine.dof_name(dof));
        let mut loads: Vec<String> = (machine.histories.iter())
            .map(|h| format!("{}.load", machine.dof_name(h.0)))
            .collect();
        loads.dedup();
        return Err(
            Error::new(Code::UnknownNode, message).with_hint(match loads.is_empty() {
                true => "the scene has no [[load]]".to_string(),
                false => format!("there is {}", loads.join(", ")),
            }),
        );
    }
    let sum = histories_of_dof.fold(Signal::default(), |sum, load| sum.plus(&load.1));
    outputs.loads.push((sum, element_indices));
    Ok(Some(OutputQuantity::Load(outputs.loads.len() - 1)))
}

/// Force or torque of a motor or brake, friction force or friction power; `None` for other names.
fn motor_or_brake(
    prepared_machine: &PreparedMachine,
    model: &AssembledModel,
    name: &str,
) -> Option<OutputQuantity> {
    let (stem, quantity) = name.rsplit_once('.')?;
    let machine = &prepared_machine.machine;
    let is_stem = |element: usize| machine.elements[element].name == stem;
    let motor = machine.motors.iter().any(|m| is_stem(m.element));
    let branch = || model.model.elements.iter().position(|b| b.name == stem);
    let prescribes = || {
        let motions = &model.prescribed.as_ref()?.motions;
        motions.iter().position(|m| m.name == stem)
    };
    // Dry-friction branches of an element are named `NAME friction` or, without other branches, `NAME`: the first of them and their count.
    let has_friction = |kind: &str| {
        let is_kind = |b: &components::FrictionElement| {
            kind.is_empty() || machine.elements[b.element].kind == kind
        };
        machine
            .friction_elements
            .iter()
            .any(|b| is_stem(b.element) && is_kind(b))
    };
    let friction_branches = |model: &DynamicModel| {
        let full_name = format!("{stem} friction");
        let is_dry =
            |b: &ForceElement| b.law.is_dry_friction() && (b.name == full_name || b.name == stem);
        let first = model.elements.iter().position(is_dry)?;
        let count = model.elements[first..].iter().filter(|b| is_dry(b)).count();
        Some((first, count))
    };
    match quantity {
        "torque" if motor => prescribes()
            .map(OutputQuantity::PrescribedTorque)
            .or_else(|| branch().map(OutputQuantity::MotorTorque)),
        "force" | "torque" if motor || has_friction("brake") => branch().map(OutputQuantity::Force),
        "friction" => has_friction("bearing")
            .then(|| friction_branches(&model.model))
            .flatten()
            .map(|at| OutputQuantity::Force(at.0)),
        "loss" if has_friction("") => {
            let full_model = (model.prescribed.as_ref()).map(|prescribed| &prescribed.full_model);
            let (first, count) = friction_branches(full_model.unwrap_or(&model.model))?;
            Some(OutputQuantity::FrictionPower(first, count))
        }
        _ => None,
    }
}

fn push_row(motion: &LinearCombination, outputs: &mut MotionOutputs) -> usize {
    outputs.rows.push(motion.clone());
    outputs.rows.len() - 1
}

/// Error of an output whose degree of freedom is not a state of the model.
fn no_state_error(name: &str) -> Error {
    let message =
        format!("`{name}` is undefined: a massless node next to dampers lags its neighbours");
    Error::new(Code::Conflict, message)
        .with_hint("request a neighbour, or give the node a (small) inertia")
}

/// Unit of an output: angular or linear by the axis of the degree of freedom, or by the kind of the element of a branch.
fn unit(prepared_machine: &PreparedMachine, name: &str, quantity: OutputQuantity) -> &'static str {
    let machine = &prepared_machine.machine;
    let rotary = match signals::parse_output(machine, name.strip_suffix(".load").unwrap_or(name)) {
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
    match (quantity, rotary) {
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
