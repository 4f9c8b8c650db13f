//! Run-up study: order responses over speed (Campbell map) and critical speeds.

use std::f64::consts::PI;
use std::time::Instant;

use super::method_choice::{self, ResponseMethodChoice};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::quantity::format_number;
use crate::base::text::pluralise;
use crate::machine::operating_point::mean_forces;
use crate::modes::excitation_orders::reference_dof;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::stages::StageDecision;
use crate::response::excitation::{OrderExcitation, UNIT_AMPLITUDE, excitations};
use crate::response::frf::ResponseSolver;
use crate::response::ports::{Port, Ports, ResponseInput, ResponseOutput};
use crate::response::run_up::{AmplitudeMap, CriticalSpeed, OrderResponses, rss_amplitude};
use crate::scene::study::{ResponseStudy, RunUpStudy};

/// Amplitudes of the outputs over the speeds of a run-up, order by order.
pub struct RunUpResult {
    /// Speeds of the node, rad/s.
    pub speeds: Vec<f64>,
    /// Node of the speeds.
    pub node: String,
    /// Names and units of the outputs.
    pub outputs: Vec<(String, &'static str)>,
    /// Excitation orders: the declared errors, and all other orders of meshes and shafts without amplitude; if no error is declared,
    /// all orders have the assumed amplitude.
    pub excitations: Vec<OrderExcitation>,
    /// Amplitude assumed for every excitation if no error is declared, m.
    pub assumed_amplitude: Option<f64>,
    /// Fixed degrees of freedom.
    pub fixed_dofs: Vec<String>,
    /// Amplitudes by output, excitation and speed; `None` for excitations without amplitude.
    pub amplitudes: AmplitudeMap,
    /// Speed of the largest RSS amplitude of each output, rad/s, and that amplitude, over the requested and the critical speeds.
    pub max_amplitudes: Vec<(f64, f64)>,
    /// Critical speeds, in descending order of the amplitude of the first output.
    pub critical: Vec<CriticalSpeed>,
    /// Method with the reason for its choice.
    pub choice: ResponseMethodChoice,
    /// Stages with their decisions.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// Wall-clock time, s.
    pub seconds: f64,
}

impl RunUpResult {
    /// Whether an excitation has a declared or assumed amplitude.
    pub fn is_declared(&self, excitation: usize) -> bool {
        self.assumed_amplitude.is_some() || self.excitations[excitation].declared
    }

    /// Root sum of squares over all excitations of an output at a speed, since their phases are unknown.
    pub fn rss_amplitude(&self, output: usize, speed: usize) -> f64 {
        rss_amplitude(&self.amplitudes[output], speed)
    }
}

/// Maximum number of responses in a map.
const MAX_RESPONSES: usize = 20_000_000;

/// Prepared study; `left_out` counts the excitations of open contacts.
struct RunUpSetup {
    node: usize,
    speeds: Vec<f64>,
    ports: Ports,
    excitations: Vec<OrderExcitation>,
    left_out: usize,
    choice: ResponseMethodChoice,
    /// No error is declared: every excitation has the amplitude [`UNIT_AMPLITUDE`].
    is_assumed: bool,
    /// Number of outputs of the study; the further outputs of `ports` are mesh forces.
    n_requested: usize,
    /// Meshes with their forces under the mean loads, N; empty without loads or declared errors.
    mean_forces: Vec<(usize, f64)>,
}

impl RunUpSetup {
    fn new(prepared_machine: &PreparedMachine, study: &RunUpStudy) -> Result<RunUpSetup, Error> {
        let PreparedMachine {
            machine,
            kinematics,
            model: linear,
            ..
        } = prepared_machine;
        let Some(range) = study.speeds else {
            let error = Error::new(Code::Usage, "no speeds are stated");
            return Err(error.with_hint("state `speeds`, such as 0:3000:301"));
        };
        let node = reference_dof(machine)?;
        let sources = excitations(machine, kinematics, &prepared_machine.operating)?;
        let count = sources.len();
        // An open contact or a rigid branch transmits no error.
        let transmits = |e: &OrderExcitation| {
            e.branches
                .iter()
                .all(|b| linear.branches.iter().any(|l| l.index == b.0))
        };
        let excitations: Vec<OrderExcitation> = sources.into_iter().filter(transmits).collect();
        if excitations.is_empty() {
            let message = "this machine excites no orders: it has no loaded gears or belts";
            return Err(Error::new(Code::Conflict, message).with_hint(
                "add gears, or state in [[load]] the torques that close their contacts",
            ));
        }
        let meshes = linear.branches.iter().map(|l| l.index).filter(|b| {
            excitations
                .iter()
                .any(|e| e.branches.iter().any(|branch| branch.0 == *b))
        });
        let outputs: Vec<String> = match study.outputs.is_empty() {
            true => meshes
                .map(|b| format!("{}.force", machine.branch_name(b)))
                .collect(),
            false => study.outputs.clone(),
        };
        let is_assumed = !excitations.iter().any(|e| e.declared);
        let mut ports = Ports::parse(machine, &[], &outputs, &study.fixed_dofs)?;
        let n_requested = ports.outputs.len();
        let mean_forces = match is_assumed {
            true => Vec::new(),
            false => mesh_forces(prepared_machine),
        };
        ports
            .outputs
            .extend(mean_forces.iter().map(|(branch, _)| Port {
                name: machine.branch_name(*branch),
                unit: "N",
                kind: ResponseOutput::Force(*branch),
            }));
        let mut excited_branches: Vec<usize> = excitations
            .iter()
            .flat_map(|e| e.branches.iter().map(|b| b.0))
            .collect();
        excited_branches.sort_unstable();
        excited_branches.dedup();
        ports.inputs = excited_branches
            .iter()
            .map(|&b| Port {
                name: machine.branch_name(b),
                unit: "m",
                kind: ResponseInput::Displacement(b),
            })
            .collect();
        let lines = excitations.len() * range.count as usize;
        if lines * ports.outputs.len() > MAX_RESPONSES {
            let message = format!(
                "{} at {} exceed the number of responses of a map",
                pluralise(excitations.len(), "excitation"),
                pluralise(range.count as usize, "speed")
            );
            return Err(Error::new(Code::BudgetExceeded, message)
                .with_hint("request fewer speeds or outputs"));
        }
        let response_study = ResponseStudy {
            lines: Some(lines as u32),
            ..ResponseStudy::default()
        };
        Ok(RunUpSetup {
            node,
            speeds: range.values(),
            left_out: count - excitations.len(),
            is_assumed,
            n_requested,
            mean_forces,
            choice: method_choice::choose_method(prepared_machine, &response_study),
            ports,
            excitations,
        })
    }

    fn plan(&self, prepared_machine: &PreparedMachine) -> Vec<(&'static str, StageDecision)> {
        let declared = self.excitations.iter().filter(|e| e.declared).count();
        let undeclared = self.excitations.len() - declared;
        let orders = match self.is_assumed {
            true => format!(
                "no error is declared: {} of meshes and shafts, each assumed 1 µm",
                pluralise(undeclared, "excitation")
            ),
            false => format!(
                "{}; {undeclared} more orders have no declared amplitude: only their critical speeds are given",
                pluralise(declared, "declared excitation")
            ),
        };
        let mut rows = vec![
            ("orders", StageDecision::Runs(orders)),
            (
                "responses",
                StageDecision::Runs(format!(
                    "{} at {}, {}",
                    pluralise(self.excitations.len(), "order"),
                    pluralise(self.speeds.len(), "speed"),
                    self.choice.reason
                )),
            ),
            (
                "critical speeds",
                StageDecision::Runs(
                    "where an order crosses a natural frequency, with the element of highest strain energy"
                        .to_string(),
                ),
            ),
            (
                "gyroscopic terms",
                StageDecision::LeftOut(
                    "responses exclude gyroscopic effects".to_string(),
                ),
            ),
            (
                "varying stiffness",
                StageDecision::LeftOut(
                    "responses are linear: see --harmonic-balance for parametric excitation".to_string(),
                ),
            ),
        ];
        if self.left_out > 0 {
            rows.push((
                "open contacts",
                StageDecision::LeftOut(format!(
                    "{} in unloaded branches",
                    pluralise(self.left_out, "excitation")
                )),
            ));
        }
        if prepared_machine.machine.gyroscopic.is_empty() {
            rows.retain(|row| row.0 != "gyroscopic terms");
        }
        rows
    }
}

/// Gear meshes with their forces under the mean loads, N; empty if no load is stated or the loads do not balance.
fn mesh_forces(prepared_machine: &PreparedMachine) -> Vec<(usize, f64)> {
    let PreparedMachine {
        machine,
        kinematics,
        ..
    } = prepared_machine;
    let prescribed: Vec<usize> = machine.speeds.iter().map(|speed| speed.0).take(1).collect();
    let operating_point = match machine.loads.is_empty() {
        true => None,
        false => mean_forces(machine, kinematics, &prescribed).ok(),
    };
    let is_mesh = |branch: usize| machine.gears.iter().any(|g| g.branches.contains(&branch));
    let forces = operating_point
        .filter(|f| !f.accelerates)
        .map_or(Vec::new(), |f| f.forces);
    let loaded_meshes = forces
        .into_iter()
        .filter(|(branch, force)| is_mesh(*branch) && *force != 0.0);
    loaded_meshes.collect()
}

/// Formats a positive force to three significant digits.
fn three_digits(force: f64) -> String {
    let unit = 10f64.powf(force.log10().floor() - 2.0);
    format_number((force / unit).round() * unit)
}

/// Warning of contact loss in meshes whose largest force amplitude exceeds the mean force.
fn contact_loss(
    prepared_machine: &PreparedMachine,
    mean_forces: &[(usize, f64)],
    largest: &[(f64, f64)],
) -> Option<Diagnostic> {
    let report = |((branch, mean), (speed, amplitude)): (&(usize, f64), &(f64, f64))| {
        (*amplitude > mean.abs()).then(|| {
            format!(
                "{} oscillates by {} N, the root sum of squares of its orders, about {} N at {:.0} rpm",
                prepared_machine.machine.branch_name(*branch),
                three_digits(*amplitude),
                three_digits(mean.abs()),
                speed * 30.0 / PI
            )
        })
    };
    let descriptions: Vec<String> = mean_forces.iter().zip(largest).filter_map(report).collect();
    (!descriptions.is_empty()).then(|| Diagnostic {
        code: "contact-loss",
        message: format!(
            "teeth would separate, but the responses assume contact: {}",
            descriptions.join(", ")
        ),
        hint: Some(
            "state the backlash and simulate these speeds, or follow them by --harmonic-balance"
                .into(),
        ),
    })
}

/// Plans a study: its stages with their decisions.
///
/// # Errors
/// Errors of [`run`] before it solves.
pub fn plan(
    machine: &PreparedMachine,
    study: &RunUpStudy,
) -> Result<Vec<(&'static str, StageDecision)>, Error> {
    Ok(RunUpSetup::new(machine, study)?.plan(machine))
}

/// Runs a study.
///
/// # Errors
/// Missing entries of the study; unknown names; a machine without excitation orders; errors of the responses.
pub fn run(prepared_machine: &PreparedMachine, study: &RunUpStudy) -> Result<RunUpResult, Error> {
    let start = Instant::now();
    let setup = RunUpSetup::new(prepared_machine, study)?;
    let PreparedMachine {
        machine,
        model: linear_model,
        ..
    } = prepared_machine;
    let model = prepared_machine.operating_model(None);
    let ports = &setup.ports;
    let mut solver = ResponseSolver::new(&model, ports, setup.choice.method)?;
    let frequencies = |speed: &f64| {
        setup
            .excitations
            .iter()
            .map(|e| (e.order * speed).abs())
            .collect::<Vec<f64>>()
    };
    let line_frequencies: Vec<f64> = setup.speeds.iter().flat_map(frequencies).collect();
    solver.check(&line_frequencies)?;
    let responses = OrderResponses::new(&solver, ports, &setup.excitations, setup.is_assumed);
    let mut amplitudes = responses.amplitudes(&setup.speeds)?;
    let values = amplitudes.iter().flatten().flatten().flatten();
    if let Some(beyond) = values.into_iter().find(|a| !(a.powi(2) < f64::MAX)) {
        let message = format!("a response of {beyond:.1e} overflows");
        return Err(Error::new(Code::Overflow, message)
            .with_hint("check the units of stiffnesses, dampings and errors"));
    }
    let damped = linear_model.is_damped(machine);
    let critical = responses.critical_speeds(&model, &setup.speeds, damped)?;
    let finite_peaks = if damped { &critical[..] } else { &[] };
    let mut max_amplitudes = responses.largest_rss(&setup.speeds, &amplitudes, finite_peaks)?;
    let mut diagnostics = prepared_machine.warnings();
    let mesh_maxima = max_amplitudes.split_off(setup.n_requested);
    amplitudes.truncate(setup.n_requested);
    diagnostics.extend(contact_loss(
        prepared_machine,
        &setup.mean_forces,
        &mesh_maxima,
    ));
    if !damped {
        diagnostics.push(Diagnostic {
            code: "undamped",
            message: "this machine has no damping: responses at its critical speeds are infinite and not given".to_string(),
            hint: Some("give branches a damping_ratio or c".to_string()),
        });
    }
    Ok(RunUpResult {
        node: machine.dof_name(setup.node),
        assumed_amplitude: setup.is_assumed.then_some(UNIT_AMPLITUDE),
        fixed_dofs: (ports.fixed.iter())
            .map(|&dof| machine.dof_name(dof))
            .collect(),
        outputs: ports
            .outputs
            .iter()
            .take(setup.n_requested)
            .map(|p| (p.name.clone(), p.unit))
            .collect(),
        plan: prepared_machine.after_meshes(setup.plan(prepared_machine)),
        speeds: setup.speeds,
        excitations: setup.excitations,
        choice: setup.choice,
        amplitudes,
        max_amplitudes,
        critical,
        diagnostics,
        seconds: start.elapsed().as_secs_f64(),
    })
}
