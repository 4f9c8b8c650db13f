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
    /// Whose speed is counted.
    pub node: String,
    /// Names and units of the outputs.
    pub outputs: Vec<(String, &'static str)>,
    /// Excitations: the declared errors, and without a size of their own whatever else turns or meshes; where none is declared all, of an
    /// assumed size.
    pub excitations: Vec<OrderExcitation>,
    /// The size assumed of every excitation, m, where no error is declared.
    pub assumed: Option<f64>,
    /// Degrees of freedom that are held still.
    pub fixed_dofs: Vec<String>,
    /// Amplitudes by output, excitation and speed; nothing of excitations without a size.
    pub amplitudes: AmplitudeMap,
    /// Speed of the largest total amplitude of every output, rad/s, and that amplitude: of these speeds and the critical ones.
    pub max_amplitudes: Vec<(f64, f64)>,
    /// Critical speeds by falling response of the first output.
    pub critical: Vec<CriticalSpeed>,
    /// Method of the responses.
    pub choice: ResponseMethodChoice,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// s.
    pub seconds: f64,
}

impl RunUpResult {
    /// Whether the size of an excitation is declared, or assumed of all.
    pub fn is_declared(&self, excitation: usize) -> bool {
        self.assumed.is_some() || self.excitations[excitation].declared
    }

    /// The root of the sum of squares over all excitations of an output at a speed: their phases are not known.
    pub fn rss_amplitude(&self, output: usize, speed: usize) -> f64 {
        rss_amplitude(&self.amplitudes[output], speed)
    }
}

/// Responses that a map may take.
const MAX_RESPONSES: usize = 20_000_000;

/// A study before it runs.
struct RunUpSetup {
    node: usize,
    speeds: Vec<f64>,
    ports: Ports,
    excitations: Vec<OrderExcitation>,
    left_out: usize,
    choice: ResponseMethodChoice,
    /// No error is declared: every excitation has the size [`UNIT_AMPLITUDE`].
    assumes: bool,
    /// Outputs of the study; those behind them are the forces of the meshes.
    requested: usize,
    /// Meshes with their forces under the mean loads, N; none where no load or no error is stated.
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
        let all = excitations(machine, kinematics, &prepared_machine.operating)?;
        let count = all.len();
        // A branch that is open or joins what moves as one carries no error.
        let carries = |e: &OrderExcitation| {
            e.branches
                .iter()
                .all(|b| linear.branches.iter().any(|l| l.index == b.0))
        };
        let excitations: Vec<OrderExcitation> = all.into_iter().filter(carries).collect();
        if excitations.is_empty() {
            let message = "nothing of this machine excites orders: it has no gears or belts that carry any load";
            return Err(Error::new(Code::Conflict, message).with_hint(
                "add gears, or state the torques in [[load]] that close their contacts",
            ));
        }
        let meshes = linear.branches.iter().map(|l| l.index).filter(|b| {
            excitations
                .iter()
                .any(|e| e.branches.iter().any(|own| own.0 == *b))
        });
        let outputs: Vec<String> = match study.outputs.is_empty() {
            true => meshes
                .map(|b| format!("{}.force", machine.branch_name(b)))
                .collect(),
            false => study.outputs.clone(),
        };
        let assumes = !excitations.iter().any(|e| e.declared);
        let mut ports = Ports::parse(machine, &[], &outputs, &study.fixed_dofs)?;
        let requested = ports.outputs.len();
        let mean_forces = match assumes {
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
        let mut driven: Vec<usize> = excitations
            .iter()
            .flat_map(|e| e.branches.iter().map(|b| b.0))
            .collect();
        driven.sort_unstable();
        driven.dedup();
        ports.inputs = driven
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
                "{} at {} are more responses than a map takes",
                pluralise(excitations.len(), "excitation"),
                pluralise(range.count as usize, "speed")
            );
            return Err(Error::new(Code::BudgetExceeded, message)
                .with_hint("request fewer speeds or outputs"));
        }
        let asked = ResponseStudy {
            lines: Some(lines as u32),
            ..ResponseStudy::default()
        };
        Ok(RunUpSetup {
            node,
            speeds: range.values(),
            left_out: count - excitations.len(),
            assumes,
            requested,
            mean_forces,
            choice: method_choice::choose_method(prepared_machine, &asked),
            ports,
            excitations,
        })
    }

    fn plan(&self, prepared_machine: &PreparedMachine) -> Vec<(&'static str, StageDecision)> {
        let declared = self.excitations.iter().filter(|e| e.declared).count();
        let rest = self.excitations.len() - declared;
        let orders = match self.assumes {
            true => format!(
                "no error is declared: {} of what meshes or turns, each assumed 1 µm",
                pluralise(rest, "excitation")
            ),
            false => format!(
                "{}; {rest} more orders have no declared amplitude: only their critical speeds are given",
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
                    "where an order meets a natural frequency, with the element of highest strain energy"
                        .to_string(),
                ),
            ),
            (
                "gyroscopic terms",
                StageDecision::LeftOut(
                    "responses are those of the machine without its spin".to_string(),
                ),
            ),
            (
                "varying stiffness",
                StageDecision::LeftOut(
                    "responses are linear: see --harmonic-balance for what it feeds".to_string(),
                ),
            ),
        ];
        if self.left_out > 0 {
            rows.push((
                "open contacts",
                StageDecision::LeftOut(format!(
                    "{} in branches that carry nothing",
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

/// Gear meshes with their forces under the mean loads, N; none where no load is stated or the loads do not balance.
fn mesh_forces(prepared_machine: &PreparedMachine) -> Vec<(usize, f64)> {
    let PreparedMachine {
        machine,
        kinematics,
        ..
    } = prepared_machine;
    let held: Vec<usize> = machine.speeds.iter().map(|speed| speed.0).take(1).collect();
    let found = match machine.loads.is_empty() {
        true => None,
        false => mean_forces(machine, kinematics, &held).ok(),
    };
    let is_mesh = |branch: usize| machine.gears.iter().any(|g| g.branches.contains(&branch));
    let forces = found
        .filter(|f| !f.accelerates)
        .map_or(Vec::new(), |f| f.forces);
    let carrying = forces
        .into_iter()
        .filter(|(branch, force)| is_mesh(*branch) && *force != 0.0);
    carrying.collect()
}

/// A force above zero to three digits.
fn three_digits(force: f64) -> String {
    let unit = 10f64.powf(force.log10().floor() - 2.0);
    format_number((force / unit).round() * unit)
}

/// A warning of meshes whose teeth would part: the largest amplitude exceeds the mean force.
fn contact_loss(
    prepared_machine: &PreparedMachine,
    mean_forces: &[(usize, f64)],
    largest: &[(f64, f64)],
) -> Option<Diagnostic> {
    let parts = |((branch, mean), (speed, amplitude)): (&(usize, f64), &(f64, f64))| {
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
    let parted: Vec<String> = mean_forces.iter().zip(largest).filter_map(parts).collect();
    (!parted.is_empty()).then(|| Diagnostic {
        code: "contact-loss",
        message: format!(
            "teeth would part, and the responses are those of teeth that stay in contact: {}",
            parted.join(", ")
        ),
        hint: Some(
            "state the backlash and simulate these speeds, or follow them by --harmonic-balance"
                .into(),
        ),
    })
}

/// The plan of a study, row by row.
///
/// # Errors
/// As for [`run`].
pub fn plan(
    machine: &PreparedMachine,
    study: &RunUpStudy,
) -> Result<Vec<(&'static str, StageDecision)>, Error> {
    Ok(RunUpSetup::new(machine, study)?.plan(machine))
}

/// Runs a study.
///
/// # Errors
/// What is missing in the study; names that do not exist; machines without orders; those of the responses.
pub fn run(prepared_machine: &PreparedMachine, study: &RunUpStudy) -> Result<RunUpResult, Error> {
    let start = Instant::now();
    let ready = RunUpSetup::new(prepared_machine, study)?;
    let PreparedMachine {
        machine,
        model: linear,
        ..
    } = prepared_machine;
    let model = prepared_machine.frequency_setting(None);
    let ports = &ready.ports;
    let mut solver = ResponseSolver::new(&model, ports, ready.choice.method)?;
    let frequencies = |speed: &f64| {
        ready
            .excitations
            .iter()
            .map(|e| (e.order * speed).abs())
            .collect::<Vec<f64>>()
    };
    let all: Vec<f64> = ready.speeds.iter().flat_map(frequencies).collect();
    solver.check(&all)?;
    let responses = OrderResponses::new(&solver, ports, &ready.excitations, ready.assumes);
    let mut amplitudes = responses.amplitudes(&ready.speeds)?;
    let known = amplitudes.iter().flatten().flatten().flatten();
    if let Some(beyond) = known.into_iter().find(|a| !(a.powi(2) < f64::MAX)) {
        let message = format!("a response of {beyond:.1e} overflows");
        return Err(Error::new(Code::Overflow, message)
            .with_hint("check the units of stiffnesses, dampings and errors"));
    }
    let damped = linear.is_damped(machine);
    let critical = responses.critical_speeds(&model, &ready.speeds, damped)?;
    let finite = if damped { &critical[..] } else { &[] };
    let mut max_amplitudes = responses.largest_totals(&ready.speeds, &amplitudes, finite)?;
    let mut diagnostics = prepared_machine.warnings();
    let of_meshes = max_amplitudes.split_off(ready.requested);
    amplitudes.truncate(ready.requested);
    diagnostics.extend(contact_loss(
        prepared_machine,
        &ready.mean_forces,
        &of_meshes,
    ));
    if !damped {
        diagnostics.push(Diagnostic {
            code: "undamped",
            message: "this machine has no damping: at its critical speeds every response is infinite, and none is given".to_string(),
            hint: Some("give branches a damping_ratio or c".to_string()),
        });
    }
    Ok(RunUpResult {
        node: machine.dof_name(ready.node),
        assumed: ready.assumes.then_some(UNIT_AMPLITUDE),
        fixed_dofs: (ports.fixed.iter())
            .map(|&dof| machine.dof_name(dof))
            .collect(),
        outputs: ports
            .outputs
            .iter()
            .take(ready.requested)
            .map(|p| (p.name.clone(), p.unit))
            .collect(),
        plan: prepared_machine.after_meshes(ready.plan(prepared_machine)),
        speeds: ready.speeds,
        excitations: ready.excitations,
        choice: ready.choice,
        amplitudes,
        max_amplitudes,
        critical,
        diagnostics,
        seconds: start.elapsed().as_secs_f64(),
    })
}
