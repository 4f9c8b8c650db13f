//! Frequency-response study: responses at spectral lines, resonance peaks, strain energy at the peaks.

use std::f64::consts::TAU;
use std::time::Instant;

use super::method_choice::{self, ResponseMethodChoice};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::quantity::{format_duration, quotient_unit};
use crate::base::text::pluralise;
use crate::base::time_budget::{BudgetForecast, CancelToken};
use crate::numeric::Complex;
use crate::numeric::sorting::sort_ascending;
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

/// Frequency responses of a study with their resonance peaks.
pub struct ResponseResult {
    /// Frequencies of the spectral lines, Hz, ascending.
    pub frequency_hz: Vec<f64>,
    /// Response of every output to every input, the outputs of one input in sequence.
    pub pairs: Vec<ResponseCurve>,
    /// Frequencies of the plotted curves, Hz, ascending: refined near the peaks; empty without plots.
    pub plot_frequency_hz: Vec<f64>,
    /// Method with the reason for its choice.
    pub choice: ResponseMethodChoice,
    /// Linear solver.
    pub solver: SolverKind,
    /// Statistics of the solution.
    pub stats: ResponseStats,
    /// Stages with their decisions.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Frequency response of one output to one input.
pub struct ResponseCurve {
    /// Name of the input.
    pub input: String,
    /// Name of the output.
    pub output: String,
    /// Unit of the response, such as `rad/(N·m)`; 1 if both units are equal.
    pub unit: String,
    /// Response at each spectral line.
    pub values: Vec<Complex>,
    /// Response at each of [`ResponseResult::plot_frequency_hz`].
    pub plotted: Vec<Complex>,
    /// Magnitude at 0 Hz, if it exists and is not zero.
    pub static_response: Option<f64>,
    /// Resonance peaks, ascending in frequency.
    pub peaks: Vec<ResonancePeak>,
}

/// Resonance peak with the element of highest strain energy.
pub struct ResonancePeak {
    /// Frequency, height and half-power band of the peak.
    pub peak: ResponsePeak,
    /// Index of the element with the largest share of the strain energy, and that share.
    pub dominant_element: Option<(usize, f64)>,
}

/// Frequency band of a study, rad/s, with its inputs and outputs.
fn request(machine: &PreparedMachine, study: &ResponseStudy) -> Result<((f64, f64), Ports), Error> {
    let Some(band) = study.band else {
        return Err(Error::new(Code::Usage, "no frequencies are stated")
            .with_hint("add --band 1:500, or `band = \"1:500\"` to the study"));
    };
    let ports = Ports::parse(
        &machine.machine,
        &study.inputs,
        &study.outputs,
        &study.fixed_dofs,
    )?;
    for (count, flag, example) in [
        (ports.inputs.len(), "input", "motor.theta"),
        (ports.outputs.len(), "output", "workpiece.theta"),
    ] {
        if count == 0 {
            let hint = format!(
                "add --{flag} NAME, or `{flag}s` to the study; names are such as {example}"
            );
            return Err(Error::new(Code::Usage, format!("no {flag} is named")).with_hint(hint));
        }
    }
    Ok((band, ports))
}

/// Checks a study as [`run`] does before it solves.
///
/// # Errors
/// Missing entries of the study; unknown names; invalid speeds; a forecast beyond the time budget.
pub fn check_study(machine: &PreparedMachine, study: &ResponseStudy) -> Result<(), Error> {
    request(machine, study)?;
    machine.speeds_at(study.speed)?;
    method_choice::check_budget(
        machine,
        study,
        &method_choice::choose_method(machine, study),
    )
}

/// Runs a study; `with_plots` requests the refined curves of the plots.
///
/// # Errors
/// Missing entries of the study; unknown names; errors of the solver.
pub fn run(
    prepared_machine: &PreparedMachine,
    study: &ResponseStudy,
    with_plots: bool,
) -> Result<ResponseResult, Error> {
    let start = Instant::now();
    let PreparedMachine {
        machine,
        model: linear_model,
        ..
    } = prepared_machine;
    let ((from, to), mut ports) = request(prepared_machine, study)?;
    ports
        .outputs
        .iter_mut()
        .for_each(|port| convert_motion(port, study.motion_quantity));
    let speeds = prepared_machine.speeds_at(study.speed)?;
    let model = prepared_machine.operating_model(speeds.as_deref());
    let choice = method_choice::choose_method(prepared_machine, study);
    method_choice::check_budget(prepared_machine, study, &choice)?;
    let lines = study.lines.unwrap_or(method_choice::DEFAULT_LINES);
    let spacing = (to - from) / f64::from(lines - 1);
    let omega: Vec<f64> = (0..lines)
        .map(|k| {
            if k + 1 == lines {
                to
            } else {
                from + spacing * f64::from(k)
            }
        })
        .collect();
    let mut solver = ResponseSolver::new(&model, &ports, choice.method)?;
    solver.check(&omega)?;
    let budget = CancelToken::default().with_budget(DEFAULT_TIME_BUDGET_S);
    let solve_line = |(k, &w): (usize, &f64)| {
        let fraction = k as f64 / omega.len() as f64;
        match budget.forecast_overrun(fraction) {
            Some(forecast) => Err(budget_error(forecast, k)),
            None => solver.response_at(w),
        }
    };
    let solutions = omega.iter().enumerate().map(solve_line);
    let values = solutions.collect::<Result<Vec<_>, Error>>()?;

    let natural = natural_frequencies(&model, &ports, (from, to));
    let strain = StrainEnergy::new(&model, &ports)?;
    let damped = linear_model.is_damped(machine);
    let mut pairs = Vec::new();
    for (i, input) in ports.inputs.iter().enumerate() {
        for (o, output) in ports.outputs.iter().enumerate() {
            let curve: Vec<Complex> = values.iter().map(|h| h[(o, i)]).collect();
            let magnitudes: Vec<(f64, f64)> = omega
                .iter()
                .zip(&curve)
                .map(|(&w, z)| (w, z.norm()))
                .collect();
            let magnitude_at = |w: f64| Ok(solver.response_at(w)?[(o, i)].norm());
            let curve_peaks = match damped {
                true => peaks::find_peaks(&magnitudes, &natural, magnitude_at)?,
                false => Vec::new(),
            };
            // A static response within rounding counts as zero.
            let largest = magnitudes.iter().fold(0.0f64, |m, s| m.max(s.1));
            let static_magnitude = solver.response_at(0.0).ok().map(|h| h[(o, i)].norm());
            let with_strain_energy = |peak: ResponsePeak| {
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
                static_response: static_magnitude.filter(|h| *h > ROUNDING * largest),
                values: curve,
                peaks: curve_peaks
                    .into_iter()
                    .map(with_strain_energy)
                    .collect::<Result<_, Error>>()?,
            });
        }
    }
    let mut plot_frequency_hz = Vec::new();
    if with_plots {
        let refined = refine(&omega, values, &half_power_widths(&pairs), |w| {
            solver.response_at(w)
        });
        plot_frequency_hz = refined.omega.iter().map(|w| w / TAU).collect();
        for (k, pair) in pairs.iter_mut().enumerate() {
            let (i, o) = (k / ports.outputs.len(), k % ports.outputs.len());
            pair.plotted = refined.values.iter().map(|h| h[(o, i)]).collect();
        }
    }
    let mut diagnostics = prepared_machine.warnings();
    diagnostics.extend(unstable(prepared_machine, study.speed)?);
    if !damped {
        diagnostics.push(Diagnostic {
            code: "undamped",
            message: "this machine has no damping: its peaks are infinite and not listed".to_string(),
            hint: Some("give branches a damping_ratio or c, or see `geardyn modes` for the natural frequencies".to_string()),
        });
    }
    Ok(ResponseResult {
        frequency_hz: omega.iter().map(|w| w / TAU).collect(),
        plot_frequency_hz,
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

/// Warning of an instability, evaluated only if negative damping, a force law or gyroscopic terms can cause it.
fn unstable(
    prepared_machine: &PreparedMachine,
    speed: Option<f64>,
) -> Result<Option<Diagnostic>, Error> {
    let (machine, linear) = (&prepared_machine.machine, &prepared_machine.model);
    let gyroscopic = speed.is_some_and(|speed| speed != 0.0) && !machine.gyroscopic.is_empty();
    let has_source = linear
        .branches
        .iter()
        .any(|b| b.damping < 0.0 || b.loss_factor < 0.0 || b.force.is_some());
    if !(gyroscopic || has_source || !linear.is_sum_of_squares()) || linear.n > MAX_COMPLEX_ORDER {
        return Ok(None);
    }
    let study = ModesStudy {
        damped: true,
        speed: speed.filter(|_| gyroscopic),
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

/// Frequencies and half-power widths of all peaks, rad/s; 1 % of the frequency if a neighbouring peak hides the width.
fn half_power_widths(pairs: &[ResponseCurve]) -> Vec<(f64, f64)> {
    const DEFAULT_WIDTH: f64 = 1e-2;
    let peaks = pairs.iter().flat_map(|p| &p.peaks).map(|s| s.peak);
    let width = |p: ResponsePeak| {
        p.half_power
            .map_or(DEFAULT_WIDTH * p.omega, |(low, high)| high - low)
    };
    let mut widths: Vec<(f64, f64)> = peaks.map(|p| (p.omega, width(p))).collect();
    // Peaks of several responses at the same mode count once.
    sort_ascending(&mut widths, |a| a.0);
    widths.dedup_by(|a, b| (a.0 - b.0).abs() < 0.1 * b.1);
    widths
}

/// Rounding relative to the largest value of a response; a smaller static response is zero.
const ROUNDING: f64 = 1e-9;

/// Converts a motion output to displacement, velocity or acceleration.
fn convert_motion(port: &mut Port<ResponseOutput>, quantity: Option<ResponseQuantity>) {
    let (ResponseOutput::Sum(_, derivative), Some(quantity)) = (&mut port.kind, quantity) else {
        return;
    };
    let is_rotational = port.unit.starts_with("rad");
    let order = quantity.derivative_order();
    let units = match is_rotational {
        true => ["rad", "rad/s", "rad/s²"],
        false => ["m", "m/s", "m/s²"],
    };
    (*derivative, port.unit) = (order, units[usize::from(order)]);
}
