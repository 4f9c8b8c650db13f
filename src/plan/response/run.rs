//! Frequency-response study: lines, resonance peaks, strain energy at the peaks.

use std::f64::consts::TAU;
use std::time::Instant;

use super::method_choice::{self, ResponseMethodChoice};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::quantity::{format_duration, quotient_unit};
use crate::base::text::pluralise;
use crate::base::time_budget::{BudgetForecast, CancelToken};
use crate::numeric::Complex;
use crate::numeric::sorting::sort_rising;
use crate::plan::linear_stability::UNSTABLE;
use crate::plan::modes_run::run as run_modes;
use crate::plan::motion::simulation_setup::DEFAULT_TIME_BUDGET_S;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::stages::{MAX_COMPLEX_ORDER, ModesPlan, StageDecision};
use crate::response::frf::{ResponseSolver, ResponseStats, SolverKind};
use crate::response::peaks::{self, ResponsePeak};
use crate::response::ports::{Port, Ports, ResponseOutput};
use crate::response::refinement::refine;
use crate::response::strain_energy::StrainEnergy;
use crate::response::system::natural_frequencies;
use crate::scene::study::{ModesStudy, ResponseQuantity, ResponseStudy};

/// Frequency responses with their peaks.
pub struct ResponseResult {
    /// Hz.
    pub frequency_hz: Vec<f64>,
    /// Response of every input and output.
    pub pairs: Vec<ResponseCurve>,
    /// Frequencies of the plots' lines, Hz: closer where the curves need it; empty unless plots are wanted.
    pub drawn_hz: Vec<f64>,
    /// Why it was found so.
    pub choice: ResponseMethodChoice,
    /// Solver.
    pub solver: SolverKind,
    /// Statistics of the solution.
    pub stats: ResponseStats,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// A response of one output to one input.
pub struct ResponseCurve {
    /// The input.
    pub input: String,
    /// The output.
    pub output: String,
    /// The unit, `rad/(N·m)`; 1 where both are alike.
    pub unit: String,
    /// By line.
    pub values: Vec<Complex>,
    /// By line of the plots.
    pub plotted: Vec<Complex>,
    /// At 0 Hz, where that exists and is not zero.
    pub static_response: Option<f64>,
    /// Peaks, ascending.
    pub peaks: Vec<ResonancePeak>,
}

/// A peak and what is strained there.
pub struct ResonancePeak {
    /// The peak.
    pub peak: ResponsePeak,
    /// The element with the largest share of the strain energy, and the share.
    pub dominant_element: Option<(usize, f64)>,
}

/// Band of a study, rad/s, with its inputs and outputs.
fn request(machine: &PreparedMachine, study: &ResponseStudy) -> Result<((f64, f64), Ports), Error> {
    let Some(band) = study.band else {
        return Err(Error::new(Code::Usage, "no frequencies are stated")
            .with_hint("state `band`, such as 1:500"));
    };
    let ports = Ports::parse(
        &machine.machine,
        &study.inputs,
        &study.outputs,
        &study.fixed_dofs,
    )?;
    for (list, flag, example) in [
        (ports.inputs.len(), "input", "motor.theta"),
        (ports.outputs.len(), "output", "workpiece.theta"),
    ] {
        if list == 0 {
            let hint = format!(
                "add --{flag} NAME, or `{flag}s` to the study; names are such as {example}"
            );
            return Err(Error::new(Code::Usage, format!("no {flag} is named")).with_hint(hint));
        }
    }
    Ok((band, ports))
}

/// Refuses what [`run`] would refuse before it solves anything.
///
/// # Errors
/// What is missing in the study; names that do not exist; speeds that do not fit; what would take too long.
pub fn refuse(machine: &PreparedMachine, study: &ResponseStudy) -> Result<(), Error> {
    request(machine, study)?;
    machine.speeds_at(study.speed)?;
    method_choice::check_budget(
        machine,
        study,
        &method_choice::choose_method(machine, study),
    )
}

/// Runs a study; `plotted`: plots are wanted of it.
///
/// # Errors
/// What is missing in the study; names that do not exist; those of the solution.
pub fn run(
    prepared_machine: &PreparedMachine,
    study: &ResponseStudy,
    drawn: bool,
) -> Result<ResponseResult, Error> {
    let start = Instant::now();
    let PreparedMachine {
        machine,
        model: linear,
        ..
    } = prepared_machine;
    let ((from, to), mut ports) = request(prepared_machine, study)?;
    ports
        .outputs
        .iter_mut()
        .for_each(|port| convert_motion(port, study.motion_quantity));
    let speeds = prepared_machine.speeds_at(study.speed)?;
    let model = prepared_machine.frequency_setting(speeds.as_deref());
    let choice = method_choice::choose_method(prepared_machine, study);
    method_choice::check_budget(prepared_machine, study, &choice)?;
    let lines = study.lines.unwrap_or(method_choice::DEFAULT_LINES);
    let step = (to - from) / f64::from(lines - 1);
    let omega: Vec<f64> = (0..lines)
        .map(|k| {
            if k + 1 == lines {
                to
            } else {
                from + step * f64::from(k)
            }
        })
        .collect();
    let mut solver = ResponseSolver::new(&model, &ports, choice.method)?;
    solver.check(&omega)?;
    let allowed = CancelToken::default().with_budget(DEFAULT_TIME_BUDGET_S);
    let line = |(k, &w): (usize, &f64)| {
        let done = k as f64 / omega.len() as f64;
        match allowed.forecast_overrun(done) {
            Some(forecast) => Err(budget_error(forecast, k)),
            None => solver.response_at(w),
        }
    };
    let lined = omega.iter().enumerate().map(line);
    let values = lined.collect::<Result<Vec<_>, Error>>()?;

    let natural = natural_frequencies(&model, &ports, (from, to));
    let strain = StrainEnergy::new(&model, &ports)?;
    let damped = linear.is_damped(machine);
    let mut pairs = Vec::new();
    for (i, input) in ports.inputs.iter().enumerate() {
        for (o, output) in ports.outputs.iter().enumerate() {
            let value: Vec<Complex> = values.iter().map(|h| h[(o, i)]).collect();
            let sizes: Vec<(f64, f64)> = omega
                .iter()
                .zip(&value)
                .map(|(&w, z)| (w, z.norm()))
                .collect();
            let height = |w: f64| Ok(solver.response_at(w)?[(o, i)].norm());
            let found = match damped {
                true => peaks::find_peaks(&sizes, &natural, height)?,
                false => Vec::new(),
            };
            // A force at rest that only rounding leaves is none.
            let largest = sizes.iter().fold(0.0f64, |m, s| m.max(s.1));
            let at_rest = solver.response_at(0.0).ok().map(|h| h[(o, i)].norm());
            let strained = |peak: ResponsePeak| {
                Ok(ResonancePeak {
                    dominant_element: (strain.energies(peak.omega, &[(i, Complex::ONE)])?)
                        .largest_share(),
                    peak,
                })
            };
            pairs.push(ResponseCurve {
                input: input.name.clone(),
                output: output.name.clone(),
                plotted: Vec::new(),
                unit: quotient_unit(output.unit, input.unit),
                static_response: at_rest.filter(|h| *h > ROUNDING * largest),
                values: value,
                peaks: found
                    .into_iter()
                    .map(strained)
                    .collect::<Result<_, Error>>()?,
            });
        }
    }
    let mut drawn_hz = Vec::new();
    if drawn {
        let course = refine(&omega, values, &half_power_widths(&pairs), |w| {
            solver.response_at(w)
        });
        drawn_hz = course.omega.iter().map(|w| w / TAU).collect();
        for (k, pair) in pairs.iter_mut().enumerate() {
            let (i, o) = (k / ports.outputs.len(), k % ports.outputs.len());
            pair.plotted = course.values.iter().map(|h| h[(o, i)]).collect();
        }
    }
    let mut diagnostics = prepared_machine.warnings();
    diagnostics.extend(unstable(prepared_machine, study.speed)?);
    if !damped {
        diagnostics.push(Diagnostic {
            code: "undamped",
            message: "nothing damps this machine: its peaks are infinite and none is listed".to_string(),
            hint: Some("give branches a damping_ratio or c, or see `geardyn modes` for the natural frequencies".to_string()),
        });
    }
    Ok(ResponseResult {
        frequency_hz: omega.iter().map(|w| w / TAU).collect(),
        drawn_hz,
        pairs,
        solver: solver.kind(),
        stats: ResponseStats {
            seconds: start.elapsed().as_secs_f64(),
            ..solver.stats
        },
        plan: prepared_machine.after_meshes(method_choice::plan(prepared_machine, study)),
        choice,
        diagnostics,
    })
}

/// The warning of roots that grow, where anything could feed them.
fn unstable(
    prepared_machine: &PreparedMachine,
    speed: Option<f64>,
) -> Result<Option<Diagnostic>, Error> {
    let (machine, linear) = (&prepared_machine.machine, &prepared_machine.model);
    let turns = speed.is_some_and(|speed| speed != 0.0) && !machine.gyroscopic.is_empty();
    let fed = linear
        .branches
        .iter()
        .any(|b| b.damping < 0.0 || b.loss_factor < 0.0 || b.force.is_some());
    if !(turns || fed || !linear.is_sum_of_squares()) || linear.n > MAX_COMPLEX_ORDER {
        return Ok(None);
    }
    let study = ModesStudy {
        damped: true,
        speed: speed.filter(|_| turns),
        ..ModesStudy::default()
    };
    let result = run_modes(
        prepared_machine,
        &study,
        &ModesPlan::plan_modes(prepared_machine, &study),
    )?;
    Ok(result.diagnostics.into_iter().find(|w| w.code == UNSTABLE))
}

fn budget_error(forecast: BudgetForecast, lines: usize) -> Error {
    let message = format!(
        "{} took {}; {}",
        pluralise(lines, "line"),
        format_duration(forecast.spent),
        forecast.text()
    );
    Error::new(Code::BudgetExceeded, message)
        .with_hint("request fewer --lines, or model the machine with fewer coordinates")
}

/// Places and half-power widths of all peaks, rad/s; where a neighbour hides the width, a hundredth of the place.
fn half_power_widths(pairs: &[ResponseCurve]) -> Vec<(f64, f64)> {
    const DEFAULT_WIDTH: f64 = 1e-2;
    let all = pairs.iter().flat_map(|p| &p.peaks).map(|s| s.peak);
    let width = |p: ResponsePeak| {
        p.half_power
            .map_or(DEFAULT_WIDTH * p.omega, |(low, high)| high - low)
    };
    let mut all: Vec<(f64, f64)> = all.map(|p| (p.omega, width(p))).collect();
    // Peaks of several responses at one mode have one circle.
    sort_rising(&mut all, |a| a.0);
    all.dedup_by(|a, b| (a.0 - b.0).abs() < 0.1 * b.1);
    all
}

/// Rounding as a share of the largest value of a response: less is zero.
const ROUNDING: f64 = 1e-9;

/// A motion as displacement, speed or acceleration.
fn convert_motion(port: &mut Port<ResponseOutput>, shown: Option<ResponseQuantity>) {
    let (ResponseOutput::Sum(_, times), Some(shown)) = (&mut port.kind, shown) else {
        return;
    };
    let turns = port.unit.starts_with("rad");
    let order = shown.derivative_order();
    let units = match turns {
        true => ["rad", "rad/s", "rad/s²"],
        false => ["m", "m/s", "m/s²"],
    };
    (*times, port.unit) = (order, units[usize::from(order)]);
}
