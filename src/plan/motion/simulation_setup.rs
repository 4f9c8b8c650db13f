//! Setup of a simulation: dynamic model, initial state, outputs, end time.

use std::f64::consts::TAU;

use super::output_selection::select_outputs;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::components::{BranchLaw, Machine};
use crate::machine::kinematics::{Kinematics, mean_speeds, supports_turning};
use crate::machine::linear::LinearModel;
use crate::machine::operating_point::OperatingPoint;
use crate::machine::spin::spinning;
use crate::motion::assemble::assemble;
use crate::motion::assembled::AssembledModel;
use crate::motion::initial_state;
use crate::motion::methods::method_by_name;
use crate::motion::outputs::MotionOutputs;
use crate::motion::problem::OdeProblem;
use crate::plan::prepared_machine::PreparedMachine;
use crate::scene::initial_conditions::InitialConditions;
use crate::scene::laws::{InitialState, MotorModel, TorqueSpeedCurve};
use crate::scene::study::SimulateStudy;

/// A scene ready to move.
pub struct SimulationSetup {
    /// The equations.
    pub model: AssembledModel,
    /// The state at zero.
    pub initial_state: Vec<f64>,
    /// Requested outputs of the motion.
    pub outputs: MotionOutputs,
    /// To this instant, s.
    pub end_time: f64,
    /// Number of equal steps of the outputs over the time.
    pub samples: usize,
    /// Time budget, s.
    pub time_budget_s: f64,
}

/// Samples where a study names no number.
pub const DEFAULT_SAMPLES: u32 = 1000;

/// Seconds that the work of a motion may take where a study names no time.
pub const DEFAULT_TIME_BUDGET_S: f64 = 3600.0;

impl SimulationSetup {
    /// Assembles, finds the start, resolves the outputs. Where the method locates events, meshes of gear files are tooth pairs or follow
    /// their load.
    ///
    /// # Errors
    /// What has no motion in time; names that do not exist; a study without an end.
    pub fn new(
        prepared_machine: &PreparedMachine,
        begin: &InitialConditions,
        study: &SimulateStudy,
    ) -> Result<SimulationSetup, Error> {
        let locates = match &study.method {
            Some(name) => method_by_name(name).is_some_and(|method| method.locates_events),
            None => study.step.is_none(),
        };
        match locates {
            true => SimulationSetup::of_machine(prepared_machine, None, begin, study),
            false => SimulationSetup::of_whole_meshes(prepared_machine, begin, study),
        }
    }

    /// The same with every mesh as one spring whatever the method, so that methods with and without events solve one problem.
    ///
    /// # Errors
    /// As [`SimulationSetup::new`].
    pub fn of_whole_meshes(
        prepared_machine: &PreparedMachine,
        begin: &InitialConditions,
        study: &SimulateStudy,
    ) -> Result<SimulationSetup, Error> {
        let machine = &prepared_machine.machine;
        if machine.branches.iter().all(|b| b.mesh_springs.is_none()) {
            return SimulationSetup::of_machine(prepared_machine, None, begin, study);
        }
        let mut machine = machine.clone();
        let branches = machine.branches.iter_mut();
        branches.for_each(|branch| branch.mesh_springs = None);
        SimulationSetup::of_machine(prepared_machine, Some(&machine), begin, study)
    }

    /// The setup of a prepared machine, or of one that differs from it in the springs of its meshes.
    fn of_machine(
        prepared_machine: &PreparedMachine,
        other: Option<&Machine>,
        begin: &InitialConditions,
        study: &SimulateStudy,
    ) -> Result<SimulationSetup, Error> {
        let Some(until) = study.end_time else {
            let error = Error::new(Code::MissingKey, "the duration of the motion is not stated");
            return Err(error.with_hint("add --until \"2 s\", or `until` to the study"));
        };
        if !(until.is_finite() && until > 0.0) {
            let error = Error::new(
                Code::OutOfRange,
                format!("a motion until {until} s cannot be"),
            );
            return Err(error.with_hint("--until takes a time above zero"));
        }
        let PreparedMachine {
            machine,
            kinematics,
            ..
        } = prepared_machine;
        let machine = other.unwrap_or(machine);
        let speeds = match machine.speeds.is_empty() && study.speed.is_none() {
            true => None,
            false => Some(spinning(machine, kinematics, study.speed)?),
        };
        let shifted;
        let machine = match study.speed {
            None => machine,
            Some(_) => {
                shifted = at_speed(machine, kinematics, speeds.as_deref())?;
                &shifted
            }
        };
        if begin.at == InitialState::Steady {
            refuse_wound_supports(machine, speeds.as_deref().unwrap_or_default())?;
        }
        let model = assemble(
            machine,
            kinematics,
            &prepared_machine.operating,
            begin,
            speeds.as_deref(),
        )?;
        let linear_model = LinearModel::new(machine, kinematics, &OperatingPoint::default())?;
        let mut start =
            initial_state::initial_state(&model, &linear_model, speeds.as_deref(), begin.at, 0.0)?;
        let n = model.model.coordinate_count();
        let carried = model.prescribed_motion(0.0);
        for (list, offset) in [(&begin.angles, 0), (&begin.speeds, n)] {
            for (name, value) in list {
                let stays = machine
                    .dof(&name.text)
                    .and_then(|f| linear_model.independent_dofs.iter().position(|&i| i == f));
                if let Some(None) = stays.map(|i| model.coordinate_index(i)) {
                    let message = format!(
                        "`{}` has no start of its own: it moves as a motor prescribes, or has no inertia and follows its neighbours",
                        name.text
                    );
                    return Err(Error::new(Code::Conflict, message)
                        .with_span(&name.span)
                        .with_hint("leave its start out"));
                }
                let Some(j) = stays.and_then(|i| model.coordinate_index(i)) else {
                    let message = format!(
                        "`{}` is not an independent degree of freedom: rigid joints tie it to another, or it does not exist",
                        name.text
                    );
                    let hint = format!(
                        "name one of {}",
                        crate::base::text::quoted_list(
                            model.model.coordinates.iter().map(String::as_str)
                        )
                    );
                    return Err(Error::new(Code::UnknownDof, message)
                        .with_span(&name.span)
                        .with_hint(hint));
                };
                let known = if offset == 0 {
                    carried[j].0
                } else {
                    carried[j].1
                };
                start[offset + j] = *value - known;
            }
        }
        let outputs = select_outputs(prepared_machine, &model, &study.outputs)?;
        let samples = study.samples.unwrap_or(DEFAULT_SAMPLES) as usize;
        debug_assert_eq!(start.len(), model.model.len());
        Ok(SimulationSetup {
            model,
            initial_state: start,
            outputs,
            end_time: until,
            samples,
            time_budget_s: study.time_limit.unwrap_or(DEFAULT_TIME_BUDGET_S),
        })
    }
}

/// Refuses a steady start of a body that turns and that a torsional support to ground holds. Linear studies take the support about the mean
/// turn; a motion in time holds the whole turn and would wind it up.
fn refuse_wound_supports(machine: &Machine, speeds: &[f64]) -> Result<(), Error> {
    let wound = machine.branches.iter().find_map(|branch| {
        let BranchLaw::Linear { stiffness, .. } = branch.law else {
            return None;
        };
        let turns = |t: &(usize, f64)| speeds.get(t.0).is_some_and(|speed| *speed != 0.0);
        let dof = branch.direction.terms.iter().find(|t| turns(t))?.0;
        (stiffness != 0.0 && supports_turning(machine, branch)).then_some((branch, dof))
    });
    let Some((branch, dof)) = wound else {
        return Ok(());
    };
    let element = &machine.elements[branch.element];
    let message = format!(
        "a steady start turns {} at {:.1} rpm, and the `k_theta` of `{}` to ground would wind up",
        machine.dof_name(dof),
        speeds[dof] * 60.0 / TAU,
        element.name
    );
    Err(Error::new(Code::Conflict, message)
        .with_span(&element.span)
        .with_hint("start at rest for the motion about the mean turn, or drive the body by a [[motor]] and leave `k_theta` out"))
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
        let speed = |list: Option<&[f64]>| list.map_or(0.0, |s| s[motor.dof]);
        let (old, new) = (speed(before.as_deref()), speed(speeds));
        match &mut motor.drive {
            MotorModel::Curve { curve, .. } => *curve = shift_curve(curve, new - old),
            MotorModel::Speed(course) if old != 0.0 => {
                course.points.iter_mut().for_each(|p| p.1 *= new / old);
            }
            MotorModel::Speed(_) | MotorModel::Angle(_) => {}
        }
    }
    Ok(machine)
}

/// A torque curve moved along its speeds.
fn shift_curve(curve: &TorqueSpeedCurve, by: f64) -> TorqueSpeedCurve {
    match curve {
        TorqueSpeedCurve::Linear { stall, idle } => TorqueSpeedCurve::Linear {
            stall: stall * (idle + by) / idle,
            idle: idle + by,
        },
        TorqueSpeedCurve::Induction {
            pull_out,
            slip,
            synchronous,
        } => TorqueSpeedCurve::Induction {
            pull_out: *pull_out,
            slip: slip * synchronous / (synchronous + by),
            synchronous: synchronous + by,
        },
        TorqueSpeedCurve::Table(points) => {
            TorqueSpeedCurve::Table(points.iter().map(|p| (p.0 + by, p.1)).collect())
        }
    }
}
