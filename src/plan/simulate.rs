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
    /// By which method, and why.
    pub choice: MethodChoice,
    /// Time history.
    pub history: MotionResult,
    /// Sensitivity to initial conditions, where measured.
    pub sensitivity: Option<Sensitivity>,
    /// Results of the online analysis.
    pub online: OnlineResult,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Instant of the one step among the loads, s.
    pub step_time_s: Option<f64>,
    /// Response of each output to that step, where the history is kept; absent where it does not settle.
    pub step_responses: Vec<Option<StepResponse>>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Warnings about an operating point, which belong to linear studies.
const LINEAR_STUDY_WARNINGS: [&str; 3] = ["no-load", "contact-open", "loads-accelerate"];

impl SimulationResult {
    /// Prepares, chooses, integrates; `hear` hears at every sample what share of the time is done.
    ///
    /// # Errors
    /// Whatever is wrong with the machine or the motion.
    pub fn simulate(
        scene: &Scene,
        machine: &PreparedMachine,
        study: &SimulateStudy,
        cancel: &CancelToken,
        hear: &dyn Fn(f64),
    ) -> Result<SimulationResult, Error> {
        let ready = SimulationSetup::new(machine, &scene.start, study)?;
        let compares = !study.no_sensitivity && !ready.model.model.superposes();
        let share = if compares { 0.5 } else { 1.0 };
        let elements = &ready.model.model.elements;
        let follows_load = elements.iter().any(|element| element.follows_load());
        let carry_out = |choice: &MethodChoice| {
            let mut rows = OnlineAnalysis::new(machine, &ready, &study.running)?;
            let mut first = compares.then(|| RunSamples::new(&ready));
            let mut beyond: Option<(usize, f64)> = None;
            let mut watch = |at: (f64, &[f64]), values: &[f64]| {
                hear(share * at.0 / ready.end_time);
                if follows_load {
                    let loads = ready.model.model.loads_over_tables(at.0, at.1);
                    beyond = loads.chain(beyond).max_by(|a, b| a.1.total_cmp(&b.1));
                }
                first
                    .iter_mut()
                    .for_each(|first| first.see(&ready, at, values));
                rows.push(&ready, at, values)
            };
            let kept = (study.running.history, &mut watch as &mut StepObserver);
            let history = run::run_observed(&ready, choice, study.energy, cancel, kept)?;
            let result = rows.finish(history.interrupted)?;
            Ok::<_, Error>((history, (result, beyond), first))
        };
        let first = method_choice::choose_method(&ready.model.model, study)?;
        cost::check_budget(&ready, &first, study)?;
        let (choice, history, ((result, beyond), rows), handed_over) = match carry_out(&first) {
            Ok((history, result, rows)) => (first, history, (result, rows), None),
            Err(error) => {
                let next = method_choice::fallback(&ready.model.model, study, &first, &error);
                let Some(next) = next else { return Err(error) };
                let said = fallback_warning(&first, &next, error);
                let (history, result, rows) = carry_out(&next)?;
                (next, history, (result, rows), Some(said))
            }
        };
        let rows = rows.filter(|_| !history.interrupted);
        let compared = rows.map(|rows| {
            let hear = |done: f64| hear(share + (1.0 - share) * done);
            let first = (&rows, history.seconds);
            Sensitivity::measure(&ready, &choice, first, cancel, &hear)
        });
        let (sensitivity, not_compared) = match compared {
            Some(Ok(sensitivity)) => (Some(sensitivity), None),
            Some(Err(error)) => (None, Some(not_compared(&error))),
            None => (None, None),
        };
        let diagnostics = (machine.warnings().into_iter())
            .filter(|w| !LINEAR_STUDY_WARNINGS.contains(&w.code))
            .chain(handed_over)
            .chain(
                choice
                    .exact_alternative
                    .map(|exact| inexact_step_warning(&choice, exact)),
            )
            .chain(step_size_warning(&ready.model.model, &choice))
            .chain(
                input_sampling_warning(&ready)
                    .or_else(|| output_sampling_warning(&ready, &history)),
            )
            .chain(beyond.and_then(|most| beyond_load_table(&ready.model.model, most)))
            .chain(sensitivity.as_ref().and_then(unpredictable))
            .chain(not_compared)
            .chain(result.diagnostics.clone())
            .collect();
        let step_time_s = single_load_step(scene).filter(|t| *t < ready.end_time);
        let step_responses = match step_time_s {
            Some(at) if !history.time.is_empty() => (history.values.iter())
                .map(|values| step_response(&history.time, values, at))
                .collect(),
            _ => Vec::new(),
        };
        Ok(SimulationResult {
            plan: machine.after_meshes(stages::plan(&ready, &choice, study)),
            step_time_s,
            step_responses,
            setup: ready,
            choice,
            history,
            sensitivity,
            online: result,
            diagnostics,
        })
    }
}

/// A history that cannot be predicted to its end.
fn unpredictable(sensitivity: &Sensitivity) -> Option<Diagnostic> {
    let until = sensitivity.until()?;
    Some(Diagnostic {
        code: "not-predictable",
        message: format!(
            "not predictable beyond t = {}: a second run from a slightly changed start diverges there; the history after it is one of many possible",
            format_time(until)
        ),
        hint: Some(
            "use the rms and the percentiles over the second half; a longer motion narrows their intervals"
                .to_string(),
        ),
    })
}

/// A mesh under a larger load than its table has.
fn beyond_load_table(model: &DynamicModel, (at, share): (usize, f64)) -> Option<Diagnostic> {
    let name = &model.elements[at].name;
    (share > 1.0).then(|| Diagnostic {
        code: "beyond-load-table",
        message: format!(
            "`{name}` carries up to {} times the largest load of its table: there the tangent at that load goes on",
            format_number(share)
        ),
        hint: Some("give a larger last torque of `torques` in [mesh] of its gear file".to_string()),
    })
}

/// No second run tells which digits hold.
fn not_compared(error: &Error) -> Diagnostic {
    Diagnostic {
        code: "not-compared",
        message: format!(
            "the sensitivity to the start was not measured, so the number of significant digits is unknown: {}",
            error.message
        ),
        hint: error.hint.clone(),
    }
}

/// Warning that a step was requested where a method without one would be exact.
fn inexact_step_warning(choice: &MethodChoice, exact: &str) -> Diagnostic {
    Diagnostic {
        code: "step-for-exact",
        message: format!(
            "a step was stated, so {} was used; {exact} would have no step error",
            choice.method.name
        ),
        hint: Some("leave the step out; `geardyn accuracy` shows what its error is".to_string()),
    }
}

/// The highest frequency of loads, errors and stiffness waves of imposed speed, rad/s; zero where none acts.
fn fastest_acting(model: &DynamicModel) -> f64 {
    let all = model.harmonics().chain(frequencies(model));
    all.fold(0.0, f64::max)
}

/// Samples too far apart to see what the loads, the errors and the stiffness waves of imposed speed do.
fn input_sampling_warning(setup: &SimulationSetup) -> Option<Diagnostic> {
    let fastest = fastest_acting(&setup.model.model);
    let step = setup.end_time / setup.samples as f64;
    let per_period = TAU / (fastest * step);
    (per_period < MIN_SAMPLES_PER_PERIOD).then(|| Diagnostic {
        code: "coarse-samples",
        message: format!(
            "{} samples in a period of the fastest that acts, {} Hz: extremes and means of the outputs are those of the samples, and miss what lies between",
            format_per_period(per_period),
            format_number(fastest / TAU)
        ),
        hint: Some(sampling_hint(setup, per_period)),
    })
}

/// Warning that the samples are too far apart to resolve an output's oscillation.
fn output_sampling_warning(setup: &SimulationSetup, history: &MotionResult) -> Option<Diagnostic> {
    let UndersampledOutput { output, per_period } = history.undersampled?;
    Some(Diagnostic {
        code: "coarse-samples",
        message: format!(
            "`{}` oscillates so fast that a period has {} samples: extremes and means of the outputs are those of the samples",
            setup.outputs.list[output].name,
            format_per_period(per_period)
        ),
        hint: Some(sampling_hint(setup, per_period)),
    })
}

/// Hint at a sufficient number of samples, to two digits; where that exceeds the limit, at a shorter time.
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
        "--until \"{}\" gives {SAMPLES_PER_PERIOD} in each, with as many samples",
        format_flag_time(until)
    )
}

/// So many in a period, to two places, or two digits where it is far fewer than one.
fn format_per_period(per_period: f64) -> String {
    match per_period {
        n if n < 0.01 => format!("{n:.1e}"),
        n => format!("{n:.2}"),
    }
}

/// A time as a flag takes it.
fn format_flag_time(time_s: f64) -> String {
    match time_s {
        t if t < 1e-9 => format!("{t:.1e} s"),
        t => format_time(t),
    }
}

/// Warning that a fixed step is too long for the machine's oscillations or its loads.
fn step_size_warning(model: &DynamicModel, choice: &MethodChoice) -> Option<Diagnostic> {
    let StepSize::Fixed(step) = choice.step_size else {
        return None;
    };
    let free = fastest_mode_closed(model);
    if let (Some(bound), Some(free)) = (choice.method.bound, free)
        && step * free.rate > bound.radius
    {
        let limit = bound.radius / free.rate;
        return Some(Diagnostic {
            code: "long-step",
            message: format!(
                "a step of {} is longer than {}, beyond which every free motion so fast grows from step to step; {}",
                format_flag_time(step),
                format_flag_time(limit),
                free.describe()
            ),
            hint: Some(format!(
                "take --step \"{}\" or less, or leave method and step out",
                format_flag_time(0.5 * limit)
            )),
        });
    }
    let acting = fastest_acting(model);
    let (rate, told) = match free {
        Some(free) if free.rate >= acting => (free.rate, free.describe()),
        _ => (
            acting,
            format!(
                "the fastest that acts has {} Hz",
                format_number(acting / TAU)
            ),
        ),
    };
    // The period of an oscillation is then off by 2 to 3 %: (hω)²/12 of Newmark's average acceleration, (hω)⁴/120 of Runge and
    // Kutta's order 4.
    let fewest = match choice.method.order {
        Some(2) => 10.0,
        _ => 5.0,
    };
    let per_period = TAU / (step * rate);
    (per_period < fewest).then(|| Diagnostic {
        code: "long-step",
        message: format!(
            "{} steps per period of the fastest oscillation, which is not resolved if excited; {told}",
            format_per_period(per_period)
        ),
        hint: Some(format!(
            "--step \"{}\" gives {SAMPLES_PER_PERIOD} in each; if half the step changes nothing, it is not excited",
            format_flag_time(step * per_period / SAMPLES_PER_PERIOD)
        )),
    })
}

/// Samples in a period from which extremes are true to 1 %: cos(π/20).
const SAMPLES_PER_PERIOD: f64 = 20.0;

/// One method gave a motion up, another took it.
fn fallback_warning(first: &MethodChoice, next: &MethodChoice, error: Error) -> Diagnostic {
    Diagnostic {
        code: "handed-over",
        message: format!(
            "{}: {}; {} took the motion from its start",
            first.method.name, error.message, next.method.name
        ),
        hint: error.hint,
    }
}

/// The instant of the one step among the loads.
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
