//! Run-up study: order responses over speed (Campbell map) and critical speeds.

use std::time::Instant;

use super::method_choice::{self, ResponseMethodChoice};
use super::run::{StrainEnergy, natural_frequencies};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;
use crate::modes::excitation_orders::reference_dof;
use crate::numeric::{Complex, parallel};
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::stages::StageDecision;
use crate::response::excitation::{OrderExcitation, UNIT_AMPLITUDE, excitations};
use crate::response::frf::ResponseSolver;
use crate::response::ports::{Port, Ports, ResponseInput};
use crate::scene::study::{ResponseStudy, RunUpStudy};

/// A run-up.
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
    pub amplitudes: Vec<Vec<Option<Vec<f64>>>>,
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

/// Critical speed: an order meets a natural frequency and the machine responds.
#[derive(Debug, Clone, Copy)]
pub struct CriticalSpeed {
    /// Speed of the node, rad/s.
    pub speed: f64,
    /// The natural frequency, rad/s.
    pub omega: f64,
    /// Which excitation.
    pub excitation: usize,
    /// The first output there; absent where nothing damps the machine, it is infinite, and where the excitation has no size.
    pub amplitude: Option<f64>,
    /// The element with the largest share of the strain energy, and the share.
    pub highest_strain_energy: Option<(usize, f64)>,
}

impl RunUpResult {
    /// Whether the size of an excitation is declared, or assumed of all.
    pub fn is_declared(&self, excitation: usize) -> bool {
        self.assumed.is_some() || self.excitations[excitation].declared
    }

    /// The square root of the sum of squares over all excitations of an output at a speed: their phases are not known.
    pub fn rss_amplitude(&self, output: usize, speed: usize) -> f64 {
        self.amplitudes[output]
            .iter()
            .flatten()
            .map(|a| a[speed].powi(2))
            .sum::<f64>()
            .sqrt()
    }
}

/// The strain energy at a resonance is so much of what it is alongside.
const MIN_ENERGY_RATIO: f64 = 2.0;

/// Next to: this far off, relative.
const REFERENCE_OFFSET: f64 = 0.1;

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
        let mut ports = Ports::parse(machine, &[], &outputs, &study.fixed_dofs)?;
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
            assumes: !excitations.iter().any(|e| e.declared),
            choice: method_choice::choose_method(prepared_machine, &asked),
            ports,
            excitations,
        })
    }

    /// Whether the size of an excitation is declared, or assumed of all.
    fn is_declared(&self, excitation: &OrderExcitation) -> bool {
        self.assumes || excitation.declared
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
    let weights: Vec<Vec<(usize, Complex)>> = ready
        .excitations
        .iter()
        .map(|e| input_amplitudes(e, ports))
        .collect();
    let has_size = |e: &OrderExcitation| ready.is_declared(e);
    let column = |e| has_size(e).then(|| vec![0.0; ready.speeds.len()]);
    let empty: Vec<Option<Vec<f64>>> = ready.excitations.iter().map(column).collect();
    let mut amplitudes = vec![empty; ports.outputs.len()];
    // Amplitudes of every output by every excitation that has a size, in their order.
    let at_speed = |&speed: &f64| -> Result<Vec<Vec<f64>>, Error> {
        let sized = (ready.excitations.iter().zip(&weights)).filter(|(e, _)| has_size(e));
        let amplitudes = sized.map(|(e, own)| {
            let h = solver.response_at((e.order * speed).abs())?;
            let outputs = 0..ports.outputs.len();
            Ok(outputs
                .map(|o| summed_amplitude(|i| h[(o, i)], own))
                .collect())
        });
        amplitudes.collect()
    };
    for (at, found) in parallel::try_map(&ready.speeds, at_speed)?
        .iter()
        .enumerate()
    {
        for (o, table) in amplitudes.iter_mut().enumerate() {
            for (column, own) in table.iter_mut().flatten().zip(found) {
                column[at] = own[o];
            }
        }
    }
    let known = amplitudes.iter().flatten().flatten().flatten();
    if let Some(beyond) = known.into_iter().find(|a| !(a.powi(2) < f64::MAX)) {
        let message = format!("a response of {beyond:.1e} overflows");
        return Err(Error::new(Code::Overflow, message)
            .with_hint("check the units of stiffnesses, dampings and errors"));
    }
    let damped = linear.is_damped(machine);
    let critical = critical_speeds(prepared_machine, &ready, &solver, &weights, damped)?;
    let total = |speed: f64| -> Result<Vec<f64>, Error> {
        let mut squares = vec![0.0; ports.outputs.len()];
        for (e, own) in ready
            .excitations
            .iter()
            .zip(&weights)
            .filter(|e| has_size(e.0))
        {
            let h = solver.response_at((e.order * speed).abs())?;
            for (o, sum) in squares.iter_mut().enumerate() {
                *sum += summed_amplitude(|i| h[(o, i)], own).powi(2);
            }
        }
        Ok(squares.into_iter().map(f64::sqrt).collect())
    };
    let mut most: Vec<(f64, f64)> = (amplitudes.iter())
        .map(|table| {
            let square = |at: usize| table.iter().flatten().map(|a| a[at].powi(2)).sum::<f64>();
            let all = ready.speeds.iter().enumerate();
            all.map(|(at, &speed)| (speed, square(at).sqrt()))
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap_or_default()
        })
        .collect();
    if damped {
        for c in &critical {
            let here = total(c.speed)?;
            for (best, here) in most.iter_mut().zip(here) {
                if here > best.1 {
                    *best = (c.speed, here);
                }
            }
        }
    }
    let mut diagnostics = prepared_machine.warnings();
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
            .map(|p| (p.name.clone(), p.unit))
            .collect(),
        plan: prepared_machine.after_meshes(ready.plan(prepared_machine)),
        speeds: ready.speeds,
        excitations: ready.excitations,
        choice: ready.choice,
        amplitudes,
        max_amplitudes: most,
        critical,
        diagnostics,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// Critical speeds: orders meet natural frequencies and the machine responds.
fn critical_speeds(
    prepared_machine: &PreparedMachine,
    ready: &RunUpSetup,
    solver: &ResponseSolver,
    weights: &[Vec<(usize, Complex)>],
    damped: bool,
) -> Result<Vec<CriticalSpeed>, Error> {
    let size = |s: &f64| s.abs();
    let (low, high) = ready
        .speeds
        .iter()
        .map(size)
        .fold((f64::INFINITY, 0.0f64), |(l, h), s| (l.min(s), h.max(s)));
    // A range through standstill holds every speed down to zero.
    let through = ready.speeds.first().is_some_and(|f| *f < 0.0)
        && ready.speeds.last().is_some_and(|l| *l > 0.0);
    let low = if through { 0.0 } else { low };
    let most = ready
        .excitations
        .iter()
        .map(|e| e.order)
        .fold(0.0, f64::max)
        * high;
    let omegas = natural_frequencies(prepared_machine, &ready.ports, (0.0, most));
    let machine = &prepared_machine.machine;
    let model = prepared_machine.frequency_setting(None);
    let strain = StrainEnergy::new(&model, &ready.ports)?;
    let mut all = Vec::new();
    for &omega in &omegas {
        for (excitation, e) in ready.excitations.iter().enumerate() {
            let speed = omega / e.order;
            if speed < low || speed > high || speed == 0.0 {
                continue;
            }
            // On the very frequency of an undamped machine there is no answer; next to it the shape is the same.
            let near = if damped { omega } else { omega * (1.0 + 1e-6) };
            let energies = strain.strain_energies(near, &weights[excitation])?;
            let sum = |omega: f64| -> Result<f64, Error> {
                Ok(strain
                    .strain_energies(omega, &weights[excitation])?
                    .iter()
                    .map(|e| e.1)
                    .sum())
            };
            let total: f64 = energies.iter().map(|e| e.1).sum();
            if total
                < MIN_ENERGY_RATIO
                    * sum(omega * (1.0 - REFERENCE_OFFSET))?
                        .max(sum(omega * (1.0 + REFERENCE_OFFSET))?)
            {
                continue;
            }
            let mut by_element = vec![0.0; machine.elements.len()];
            energies.iter().for_each(|e| by_element[e.0] += e.1);
            let worst =
                (0..by_element.len()).max_by(|&a, &b| by_element[a].total_cmp(&by_element[b]));
            let amplitude = match damped && ready.is_declared(e) {
                true => {
                    let h = solver.response_at(omega)?;
                    Some(summed_amplitude(|i| h[(0, i)], &weights[excitation]))
                }
                false => None,
            };
            all.push(CriticalSpeed {
                speed,
                omega,
                excitation,
                amplitude,
                highest_strain_energy: worst.map(|w| (w, by_element[w] / total)),
            });
        }
    }
    all.sort_by(|a, b| {
        b.amplitude
            .unwrap_or(0.0)
            .total_cmp(&a.amplitude.unwrap_or(0.0))
            .then(a.speed.total_cmp(&b.speed))
    });
    Ok(all)
}

/// Inputs of an excitation, with their complex amplitudes.
fn input_amplitudes(e: &OrderExcitation, ports: &Ports) -> Vec<(usize, Complex)> {
    let input = |(branch, share): &(usize, Complex)| {
        let number = ports
            .inputs
            .iter()
            .position(|p| p.kind == ResponseInput::Displacement(*branch))?;
        Some((number, share * e.amplitude))
    };
    e.branches.iter().filter_map(input).collect()
}

fn summed_amplitude(h: impl Fn(usize) -> Complex, weights: &[(usize, Complex)]) -> f64 {
    weights
        .iter()
        .fold(Complex::new(0.0, 0.0), |sum, &(i, a)| sum + h(i) * a)
        .norm()
}
