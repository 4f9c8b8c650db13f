//! Simulation study: setup, method choice, integration, fallback method, diagnostics.

use std::f64::consts::TAU;

use super::motion::cost;
use super::motion::method_choice::{self, MethodChoice};
use super::motion::run::{self, MIN_SAMPLES_PER_PERIOD, MotionResult, StepObserver};
use super::motion::sensitivity::{RunSamples, Sensitivity};
use super::motion::simulation_setup::SimulationSetup;
use super::motion::stages;
use super::online::{OnlineAnalysis, OnlineResult};
use super::prepared_machine::PreparedMachine;
use super::stages::StageDecision;
use crate::base::error::{Diagnostic, Error};
use crate::base::quantity::{format_number, format_time};
use crate::base::time_budget::CancelToken;
use crate::motion::diagnostics::fastest_mode_closed;
use crate::motion::dynamic_model::DynamicModel;
use crate::motion::methods::periodic::grid::frequencies;
use crate::motion::problem::StepSize;
use crate::motion::progress::rounded;
use crate::motion::sampling_check::UndersampledOutput;
use crate::motion::step_response::{StepResponse, step_response};
use crate::scene::Scene;
use crate::scene::laws::LoadHistory;
use crate::scene::study::SimulateStudy;

/// Simulated motion with its diagnostics.
pub struct SimulationResult {
    /// Setup of the motion.
    pub setup: SimulationSetup,
    /// Method with the reason for its choice.
    pub choice: MethodChoice,
    /// Time history with the statistics of its outputs.
    pub history: MotionResult,
    /// Sensitivity to initial conditions, if measured.
    pub sensitivity: Option<Sensitivity>,
    /// Results of the online analysis.
    pub online: OnlineResult,
    /// Stages with their decisions.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Instant of the load step, s, if exactly one lies within the run.
    pub step_time_s: Option<f64>,
    /// Step response of each output, empty without a load step or a stored history; `None` if the output does not settle.
    pub step_responses: Vec<Option<StepResponse>>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Codes of operating-point warnings, which apply to linear studies only.
const LINEAR_STUDY_WARNINGS: [&str; 3] = ["no-load", "contact-open", "loads-accelerate"];

impl SimulationResult {
    /// Prepares the setup, chooses the method and integrates; `progress` receives the completed fraction at every sample.
    ///
    /// # Errors
    /// Errors of the machine, the setup, the method and the online analysis.
    pub fn simulate(
        scene: &Scene,
        machine: &PreparedMachine,
        study: &SimulateStudy,
        cancel: &CancelToken,
        progress: &dyn Fn(f64),
    ) -> Result<SimulationResult, Error> {
        let setup = SimulationSetup::new(machine, &scene.start, study)?;
        let measures_sensitivity = !study.no_sensitivity && !setup.model.model.is_linear_in_state();
        let share = if measures_sensitivity { 0.5 } else { 1.0 };
        let elements = &setup.model.model.elements;
        let follows_load = elements.iter().any(|element| element.follows_load());
        let integrate = |choice: &MethodChoice| {
            let mut analysis = OnlineAnalysis::new(machine, &setup, &study.running)?;
            let mut samples = measures_sensitivity.then(|| RunSamples::new(&setup));
            let mut overload: Option<(usize, f64)> = None;
            let mut observe = |sample: (f64, &[f64]), values: &[f64]| {
                progress(share * sample.0 / setup.end_time);
                if follows_load {
                    let loads = setup.model.model.loads_over_tables(sample.0, sample.1);
                    overload = loads.chain(overload).max_by(|a, b| a.1.total_cmp(&b.1));
                }
                samples
                    .iter_mut()
                    .for_each(|samples| samples.see(&setup, sample, values));
                analysis.push(&setup, sample, values)
            };
            let observer = (study.running.history, &mut observe as &mut StepObserver);
            let history = run::run_observed(&setup, choice, study.energy, cancel, observer)?;
            let result = analysis.finish(history.interrupted)?;
            Ok::<_, Error>((history, (result, overload), samples))
        };
        let first = method_choice::choose_method(&setup.model.model, study)?;
        cost::check_budget(&setup, &first, study)?;
        let (choice, history, ((result, overload), samples), handover) = match integrate(&first) {
            Ok((history, result, samples)) => (first, history, (result, samples), None),
            Err(error) => {
                let next = method_choice::fallback(&setup.model.model, study, &first, &error);
                let Some(next) = next else { return Err(error) };
                let warning = fallback_warning(&first, &next, error);
                let (history, result, samples) = integrate(&next)?;
                (next, history, (result, samples), Some(warning))
            }
        };
        let samples = samples.filter(|_| !history.interrupted);
        let measured = samples.map(|samples| {
            let progress = |fraction: f64| progress(share + (1.0 - share) * fraction);
            let first_run = (&samples, history.seconds);
            Sensitivity::measure(&setup, &choice, first_run, cancel, &progress)
        });
        let (sensitivity, failure) = match measured {
            Some(Ok(sensitivity)) => (Some(sensitivity), None),
            Some(Err(error)) => (None, Some(sensitivity_not_measured(&error))),
            None => (None, None),
        };
        let diagnostics = (machine.warnings().into_iter())
            .filter(|w| !LINEAR_STUDY_WARNINGS.contains(&w.code))
            .chain(handover)
            .chain(
                choice
                    .exact_alternative
                    .map(|exact| inexact_step_warning(&choice, exact)),
            )
            .chain(step_size_warning(&setup.model.model, &choice))
            .chain(
                input_sampling_warning(&setup)
                    .or_else(|| output_sampling_warning(&setup, &history)),
            )
            .chain(overload.and_then(|largest| beyond_load_table(&setup.model.model, largest)))
            .chain(sensitivity.as_ref().and_then(unpredictable))
            .chain(failure)
            .chain(result.diagnostics.clone())
            .collect();
        let step_time_s = single_load_step(scene).filter(|t| *t < setup.end_time);
        let step_responses = match step_time_s {
            Some(at) if !history.time.is_empty() => (history.values.iter())
                .map(|values| step_response(&history.time, values, at))
                .collect(),
            _ => Vec::new(),
        };
        Ok(SimulationResult {
            plan: machine.after_meshes(stages::plan(&setup, &choice, study)),
            step_time_s,
            step_responses,
            setup,
            choice,
            history,
            sensitivity,
            online: result,
            diagnostics,
        })
    }
}

/// Warning that the history is not predictable to its end.
fn unpredictable(sensitivity: &Sensitivity) -> Option<Diagnostic> {
    let until = sensitivity.until()?;
    Some(Diagnostic {
        code: "not-predictable",
        message: format!(
            "not predictable beyond t = {}: a second run from perturbed initial conditions diverges there; the later history is one of many possible",
            format_time(until)
        ),
        hint: Some(
            "use the rms and the percentiles over the second half; a longer motion narrows their intervals"
                .to_string(),
        ),
    })
}

/// Warning that a mesh carries more than the largest load of its table; `share` is their ratio.
fn beyond_load_table(model: &DynamicModel, (at, share): (usize, f64)) -> Option<Diagnostic> {
    let name = &model.elements[at].name;
    (share > 1.0).then(|| Diagnostic {
        code: "beyond-load-table",
        message: format!(
            "`{name}` carries up to {} times the largest load of its table, which is extrapolated by its tangent",
            format_number(share)
        ),
        hint: Some("give a larger last torque of `torques` in [mesh] of its gear file".to_string()),
    })
}

/// Warning that the sensitivity to initial conditions was not measured.
fn sensitivity_not_measured(error: &Error) -> Diagnostic {
    Diagnostic {
        code: "not-compared",
        message: format!(
            "the sensitivity to initial conditions was not measured, so the number of significant digits is unknown: {}",
            error.message
        ),
        hint: error.hint.clone(),
    }
}

/// Warning that a step was requested although an exact method without step applies.
fn inexact_step_warning(choice: &MethodChoice, exact: &str) -> Diagnostic {
    Diagnostic {
        code: "step-for-exact",
        message: format!(
            "a step was stated, so {} was used; {exact} would have no step error",
            choice.method.name
        ),
        hint: Some("omit the step; `geardyn accuracy` shows its error".to_string()),
    }
}

/// Highest frequency of loads, errors and stiffness waves of imposed speed, rad/s; zero without any.
fn highest_input_frequency(model: &DynamicModel) -> f64 {
    let inputs = model.harmonics().chain(frequencies(model));
    inputs.fold(0.0, f64::max)
}

/// Warning that the samples do not resolve the loads, the errors and the stiffness waves of imposed speed.
fn input_sampling_warning(setup: &SimulationSetup) -> Option<Diagnostic> {
    let fastest = highest_input_frequency(&setup.model.model);
    let step = setup.end_time / setup.samples as f64;
    let per_period = TAU / (fastest * step);
    (per_period < MIN_SAMPLES_PER_PERIOD).then(|| Diagnostic {
        code: "coarse-samples",
        message: format!(
            "{} samples per period of the fastest excitation, {} Hz: extremes and means of the outputs are those of the samples",
            format_per_period(per_period),
            format_number(fastest / TAU)
        ),
        hint: Some(sampling_hint(setup, per_period)),
    })
}

/// Warning that the samples do not resolve the oscillation of an output.
fn output_sampling_warning(setup: &SimulationSetup, history: &MotionResult) -> Option<Diagnostic> {
    let UndersampledOutput { output, per_period } = history.undersampled?;
    Some(Diagnostic {
        code: "coarse-samples",
        message: format!(
            "`{}` oscillates with {} samples per period: extremes and means of the outputs are those of the samples",
            setup.outputs.list[output].name,
            format_per_period(per_period)
        ),
        hint: Some(sampling_hint(setup, per_period)),
    })
}

/// Hint with a sufficient number of samples, to two digits, or with a shorter end time if that number exceeds `u32::MAX`.
fn sampling_hint(setup: &SimulationSetup, per_period: f64) -> String {
    let samples = SAMPLES_PER_PERIOD / per_period * setup.samples as f64;
    let digit = 10f64.powf(samples.log10().floor() - 1.0).max(1.0);
    let samples = (samples / digit).ceil() * digit;
    if samples <= f64::from(u32::MAX) {
        return format!(
            "--samples {} gives {SAMPLES_PER_PERIOD} in each",
            rounded(samples)
        );
    }
    let until = setup.end_time * per_period / SAMPLES_PER_PERIOD;
    format!(
        "--until \"{}\" gives {SAMPLES_PER_PERIOD} in each, with the same number of samples",
        format_flag_time(until)
    )
}

/// Formats a number of samples per period: two decimals, or two significant digits below 0.01.
fn format_per_period(per_period: f64) -> String {
    match per_period {
        n if n < 0.01 => format!("{n:.1e}"),
        n => format!("{n:.2}"),
    }
}

/// Formats a time as accepted by a command-line flag.
fn format_flag_time(time_s: f64) -> String {
    match time_s {
        t if t < 1e-9 => format!("{t:.1e} s"),
        t => format_time(t),
    }
}

/// Warning that a fixed step exceeds the stability limit, or does not resolve the fastest oscillation or load.
fn step_size_warning(model: &DynamicModel, choice: &MethodChoice) -> Option<Diagnostic> {
    let StepSize::Fixed(step) = choice.step_size else {
        return None;
    };
    let mode = fastest_mode_closed(model);
    if let (Some(bound), Some(mode)) = (choice.method.bound, mode)
        && step * mode.rate > bound.radius
    {
        let limit = bound.radius / mode.rate;
        return Some(Diagnostic {
            code: "long-step",
            message: format!(
                "a step of {} exceeds the stability limit of {}; {}",
                format_flag_time(step),
                format_flag_time(limit),
                mode.describe()
            ),
            hint: Some(format!(
                "use --step \"{}\" or less, or omit method and step",
                format_flag_time(0.5 * limit)
            )),
        });
    }
    let input_frequency = highest_input_frequency(model);
    let (rate, cause) = match mode {
        Some(mode) if mode.rate >= input_frequency => (mode.rate, mode.describe()),
        _ => (
            input_frequency,
            format!(
                "the fastest excitation has {} Hz",
                format_number(input_frequency / TAU)
            ),
        ),
    };
    // At this limit the period error is 2 to 3 %: (hω)²/12 for Newmark's average acceleration, (hω)⁴/120 for the
    // Runge–Kutta method of order 4.
    let min_steps = match choice.method.order {
        Some(2) => 10.0,
        _ => 5.0,
    };
    let per_period = TAU / (step * rate);
    (per_period < min_steps).then(|| Diagnostic {
        code: "long-step",
        message: format!(
            "{} steps per period of the fastest oscillation, which is not resolved if excited; {cause}",
            format_per_period(per_period)
        ),
        hint: Some(format!(
            "--step \"{}\" gives {SAMPLES_PER_PERIOD} in each; if half the step changes nothing, it is not excited",
            format_flag_time(step * per_period / SAMPLES_PER_PERIOD)
        )),
    })
}

/// Samples per period from which sampled extremes are accurate to 1 %: cos(π/20) = 0.99.
const SAMPLES_PER_PERIOD: f64 = 20.0;

/// Warning that the first method failed and the next one integrated the motion.
fn fallback_warning(first: &MethodChoice, next: &MethodChoice, error: Error) -> Diagnostic {
    Diagnostic {
        code: "handed-over",
        message: format!(
            "{}: {}; {} integrated the motion from the start",
            first.method.name, error.message, next.method.name
        ),
        hint: error.hint,
    }
}

/// Instant of the load step, s; `None` unless all load steps share one instant.
fn single_load_step(scene: &Scene) -> Option<f64> {
    let steps = scene
        .model
        .loads
        .iter()
        .filter_map(|load| match load.history {
            LoadHistory::Step { time, .. } => Some(time),
            _ => None,
        });
    let mut instants: Vec<f64> = steps.collect();
    instants.dedup();
    match instants[..] {
        [at] if at >= 0.0 => Some(at),
        _ => None,
    }
}
