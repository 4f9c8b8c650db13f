//! Setup of a simulation: dynamic model `ẏ = f(t, y)`, initial state, outputs, end time.

use std::f64::consts::TAU;

use super::output_selection::select_outputs;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::components::{BranchLaw, Machine};
use crate::machine::kinematics::{Kinematics, mean_speeds, supports_turning};
use crate::machine::linear::LinearModel;
use crate::machine::operating_point::OperatingPoint;
use crate::machine::spin::spin_speeds;
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

/// Simulation problem: dynamic model, initial state, outputs and duration.
pub struct SimulationSetup {
    /// Equations of motion.
    pub model: AssembledModel,
    /// State at t = 0.
    pub initial_state: Vec<f64>,
    /// Requested outputs.
    pub outputs: MotionOutputs,
    /// End of the simulation, s.
    pub end_time: f64,
    /// Number of output intervals, equal in length.
    pub samples: usize,
    /// Budget of run time, s.
    pub time_budget_s: f64,
}

/// Default number of output intervals.
pub const DEFAULT_SAMPLES: u32 = 1000;

/// Default budget of run time, s.
pub const DEFAULT_TIME_BUDGET_S: f64 = 3600.0;

impl SimulationSetup {
    /// Assembles the model, computes the initial state and resolves the outputs. If the method locates events, meshes of gear files
    /// consist of tooth pairs or follow their load table.
    ///
    /// # Errors
    /// The machine has no equations of motion; a name does not exist; the study has no end time.
    pub fn new(
        prepared_machine: &PreparedMachine,
        begin: &InitialConditions,
        study: &SimulateStudy,
    ) -> Result<SimulationSetup, Error> {
        let locates_events = match &study.method {
            Some(name) => method_by_name(name).is_some_and(|method| method.locates_events),
            None => study.step.is_none(),
        };
        match locates_events {
            true => SimulationSetup::of_machine(prepared_machine, None, begin, study),
            false => SimulationSetup::with_single_spring_meshes(prepared_machine, begin, study),
        }
    }

    /// As [`SimulationSetup::new`] with every mesh as one spring, so that methods with and without event location solve the same problem.
    ///
    /// # Errors
    /// Errors of [`SimulationSetup::new`].
    pub fn with_single_spring_meshes(
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

    /// Setup of a prepared machine, or of `other`, which differs from it in the springs of its meshes.
    fn of_machine(
        prepared_machine: &PreparedMachine,
        other: Option<&Machine>,
        begin: &InitialConditions,
        study: &SimulateStudy,
    ) -> Result<SimulationSetup, Error> {
        let Some(until) = study.end_time else {
            let error = Error::new(Code::MissingKey, "the duration of the motion is not stated");
            return Err(error.with_hint("add --until \"2 s\", or `until = \"2 s\"` to the study"));
        };
        if !(until.is_finite() && until > 0.0) {
            let error = Error::new(
                Code::OutOfRange,
                format!("a duration of {until} s is not possible"),
            );
            return Err(error.with_hint("give --until a time above zero"));
        }
        let PreparedMachine {
            machine,
            kinematics,
            ..
        } = prepared_machine;
        let machine = other.unwrap_or(machine);
        let speeds = match machine.speeds.is_empty() && study.speed.is_none() {
            true => None,
            false => Some(spin_speeds(machine, kinematics, study.speed)?),
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
            check_steady_supports(machine, speeds.as_deref().unwrap_or_default())?;
        }
        let model = assemble(
            machine,
            kinematics,
            &prepared_machine.operating,
            begin,
            speeds.as_deref(),
        )?;
        let linear_model = LinearModel::new(machine, kinematics, &OperatingPoint::default())?;
        let mut state =
            initial_state::initial_state(&model, &linear_model, speeds.as_deref(), begin.at, 0.0)?;
        let n = model.model.coordinate_count();
        let prescribed = model.prescribed_motion(0.0);
        for (values, offset) in [(&begin.angles, 0), (&begin.speeds, n)] {
            for (name, value) in values {
                let independent = machine
                    .dof(&name.text)
                    .and_then(|f| linear_model.independent_dofs.iter().position(|&i| i == f));
                if let Some(None) = independent.map(|i| model.coordinate_index(i)) {
                    let message = format!(
                        "`{}` has no initial state: its motion is prescribed by a motor, or it has no inertia",
                        name.text
                    );
                    return Err(Error::new(Code::Conflict, message)
                        .with_span(&name.span)
                        .with_hint("omit its initial state"));
                }
                let Some(j) = independent.and_then(|i| model.coordinate_index(i)) else {
                    let message = format!(
                        "`{}` is not an independent degree of freedom: it is rigidly joined to another, or does not exist",
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
                let offset_value = if offset == 0 {
                    prescribed[j].0
                } else {
                    prescribed[j].1
                };
                state[offset + j] = *value - offset_value;
            }
        }
        let outputs = select_outputs(prepared_machine, &model, &study.outputs)?;
        let samples = study.samples.unwrap_or(DEFAULT_SAMPLES) as usize;
        debug_assert_eq!(state.len(), model.model.len());
        Ok(SimulationSetup {
            model,
            initial_state: state,
            outputs,
            end_time: until,
            samples,
            time_budget_s: study.time_limit.unwrap_or(DEFAULT_TIME_BUDGET_S),
        })
    }
}

/// Rejects a steady start of a rotating body with a torsional support to ground. Linear studies apply the support to oscillations about the
/// mean rotation; a simulation applies it to the total angle and would wind it up.
fn check_steady_supports(machine: &Machine, speeds: &[f64]) -> Result<(), Error> {
    let support = machine.branches.iter().find_map(|branch| {
        let BranchLaw::Linear { stiffness, .. } = branch.law else {
            return None;
        };
        let rotates = |t: &(usize, f64)| speeds.get(t.0).is_some_and(|speed| *speed != 0.0);
        let dof = branch.direction.terms.iter().find(|t| rotates(t))?.0;
        (stiffness != 0.0 && supports_turning(machine, branch)).then_some((branch, dof))
    });
    let Some((branch, dof)) = support else {
        return Ok(());
    };
    let element = &machine.elements[branch.element];
    let message = format!(
        "a steady start turns {} at {:.1} rpm, which winds up the `k_theta` of `{}` to ground",
        machine.dof_name(dof),
        speeds[dof] * 60.0 / TAU,
        element.name
    );
    Err(Error::new(Code::Conflict, message)
        .with_span(&element.span)
        .with_hint("start at rest for the motion about the mean rotation, or drive the body by a [[motor]] and omit `k_theta`"))
}

/// Machine with its motors at other speeds, rad/s, as with a frequency converter: the same torque at the same slip.
fn at_speed(
    machine: &Machine,
    kinematics: &Kinematics,
    speeds: Option<&[f64]>,
) -> Result<Machine, Error> {
    let mut machine = machine.clone();
    let stated = match machine.speeds.is_empty() {
        true => None,
        false => Some(mean_speeds(&machine, kinematics, None)?),
    };
    for motor in &mut machine.motors {
        let speed = |speeds_of: Option<&[f64]>| speeds_of.map_or(0.0, |s| s[motor.dof]);
        let (old, new) = (speed(stated.as_deref()), speed(speeds));
        match &mut motor.drive {
            MotorModel::Curve { curve, .. } => *curve = shift_curve(curve, new - old),
            MotorModel::Speed(law) if old != 0.0 => {
                law.points.iter_mut().for_each(|p| p.1 *= new / old);
            }
            MotorModel::Speed(_) | MotorModel::Angle(_) => {}
        }
    }
    Ok(machine)
}

/// Torque–speed curve shifted by a speed, rad/s.
fn shift_curve(curve: &TorqueSpeedCurve, shift: f64) -> TorqueSpeedCurve {
    match curve {
        TorqueSpeedCurve::Linear { stall, idle } => TorqueSpeedCurve::Linear {
            stall: stall * (idle + shift) / idle,
            idle: idle + shift,
        },
        TorqueSpeedCurve::Induction {
            pull_out,
            slip,
            synchronous,
        } => TorqueSpeedCurve::Induction {
            pull_out: *pull_out,
            slip: slip * synchronous / (synchronous + shift),
            synchronous: synchronous + shift,
        },
        TorqueSpeedCurve::Table(points) => {
            TorqueSpeedCurve::Table(points.iter().map(|p| (p.0 + shift, p.1)).collect())
        }
    }
}
