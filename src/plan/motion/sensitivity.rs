//! Sensitivity of a motion to its initial conditions, and the predictable digits of its outputs, by comparison of two runs.
//!
//! After the runs have diverged only the statistics of the motion are predictable.

use std::ops::ControlFlow;
use std::time::Instant;

use super::method_choice::MethodChoice;
use super::run::integration_problem;
use super::simulation_setup::SimulationSetup;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_duration;
use crate::base::time_budget::CancelToken;
use crate::motion::block_statistics::{Statistics, block_error};
use crate::motion::methods::StepControl;
use crate::motion::output_statistics::{OutputStatistics, StatisticsAccumulator};
use crate::motion::problem::StepSize;
use crate::motion::sensitivity::{Amplification, Deflections, PERTURBATION_SHARE};
use crate::numeric::statistics::peak_to_peak;

/// Ratio of the tolerance of the second run to that of the first.
const TOLERANCE_RATIO: f64 = 10.0;

/// Ratio of the fixed step of the second run to that of the first.
const STEP_RATIO: f64 = 0.8;

/// Ratio of the error bound to the difference of two runs, which may be small by chance.
const ERROR_FACTOR: f64 = 3.0;

/// Significant digits of a table.
const TABLE_DIGITS: i32 = 4;

/// Maximum number of samples compared per output.
const MAX_COMPARED_SAMPLES: usize = 20_000;

/// Time limit of the second run: this multiple of the first, plus [`MIN_TIME_S`].
const MAX_TIME_RATIO: f64 = 4.0;
const MIN_TIME_S: f64 = 1.0;

/// Maximum number of time windows, each of at least [`SAMPLES_PER_WINDOW`] samples, judged for divergence.
const MAX_WINDOWS: usize = 200;
const SAMPLES_PER_WINDOW: usize = 20;

/// Minimum difference of a diverged sample, as a share of the range of the output: two digits are lost.
const DIVERGED_SAMPLE_SHARE: f64 = 0.01;

/// Minimum difference of a diverged sample, as a share of the largest value: an output without range is constant.
const CONSTANT_SHARE: f64 = 1e-7;

/// Maximum share of diverged samples of a predictable window: fewer are jumps slightly earlier or later.
const MAX_DIVERGED_SHARE: f64 = 0.05;

/// Smallest share of the remaining time of a lasting divergence: below it the loss of predictability is temporary.
const MIN_DIVERGED_DURATION: f64 = 0.1;

/// Samples of a run for comparison with another.
#[derive(Debug, Clone)]
pub struct RunSamples {
    deflections: Deflections,
    /// Stride between stored samples.
    stride: usize,
    count: usize,
    time: Vec<f64>,
    values: Vec<Vec<f64>>,
    accumulators: Vec<StatisticsAccumulator>,
}

impl RunSamples {
    /// Empty storage for the outputs of a simulation.
    pub fn new(setup: &SimulationSetup) -> RunSamples {
        let outputs = setup.outputs.list.len();
        RunSamples {
            deflections: Deflections::new(&setup.model.model, setup.samples),
            stride: setup.samples / MAX_COMPARED_SAMPLES + 1,
            count: 0,
            time: Vec::new(),
            values: vec![Vec::new(); outputs],
            accumulators: vec![StatisticsAccumulator::default(); outputs],
        }
    }

    /// Adds the next sample: time, s, and state, outputs.
    pub fn see(&mut self, setup: &SimulationSetup, (t, y): (f64, &[f64]), outputs: &[f64]) {
        self.deflections.see(&setup.model.model, t, y);
        for (reader, value) in self.accumulators.iter_mut().zip(outputs) {
            reader.push(t, *value);
        }
        if self.count.is_multiple_of(self.stride) {
            self.time.push(t);
            for (list, value) in self.values.iter_mut().zip(outputs) {
                list.push(*value);
            }
        }
        self.count += 1;
    }
}

/// Sensitivity of a motion to its initial conditions.
#[derive(Debug, Clone)]
pub struct Sensitivity {
    /// Amplification of a perturbation of the initial state; `None` if all displayed digits are predictable and the errors of the method
    /// exceed such a perturbation.
    pub amplification: Option<Amplification>,
    /// Interval of temporary divergence, s; `None` without divergence or with a lasting one.
    pub temporary_parting: Option<[f64; 2]>,
    /// Predictability of each output.
    pub outputs: Vec<OutputPredictability>,
    /// Run time of the additional runs, s.
    pub seconds: f64,
}

/// Predictability of an output.
#[derive(Debug, Clone)]
pub struct OutputPredictability {
    /// Time up to which the history is predictable, s; `None`: throughout.
    pub until: Option<f64>,
    /// Error bound of the final value, in the unit of the output; `None` if not predictable.
    pub end: Option<f64>,
    /// Error bound of the minimum.
    pub min: Option<f64>,
    /// Error bound of the time of the minimum, s.
    pub min_at: Option<f64>,
    /// Error bound of the maximum.
    pub max: Option<f64>,
    /// Error bound of the time of the maximum, s.
    pub max_at: Option<f64>,
    /// Error bound of the mean.
    pub mean: f64,
    /// Error bound of the standard deviation.
    pub standard_deviation: f64,
    /// Statistics of the second half of the time, for an unpredictable history.
    pub second_half: Option<Statistics>,
    /// True if four digits of every statistic are predictable, relative to the largest value.
    pub all_shown: bool,
}

impl Sensitivity {
    /// Perturbation of the initial state, as a share of the deflections.
    pub fn change(&self) -> f64 {
        self.amplification.map_or(PERTURBATION_SHARE, |a| a.change)
    }

    /// Time up to which the histories of all outputs are predictable, s; `None`: throughout.
    pub fn until(&self) -> Option<f64> {
        let all = self.outputs.iter().filter_map(|o| o.until);
        all.reduce(f64::min)
    }

    /// True if all displayed digits are predictable.
    pub fn all_shown(&self) -> bool {
        self.outputs.iter().all(|o| o.all_shown)
    }

    /// Measures the sensitivity by a rerun from a perturbed initial state; `progress` receives the completed share.
    ///
    /// # Errors
    /// Errors of the method; `BudgetExceeded` if the second run takes far longer than the first.
    pub fn measure(
        setup: &SimulationSetup,
        choice: &MethodChoice,
        (first, seconds): (&RunSamples, f64),
        cancel: &CancelToken,
        progress: &dyn Fn(f64),
    ) -> Result<Sensitivity, Error> {
        let start = Instant::now();
        let limit = MAX_TIME_RATIO * seconds + MIN_TIME_S;
        let rerun = |change: f64, size: StepSize| {
            let changed =
                first
                    .deflections
                    .perturbed_start(&setup.model.model, &setup.initial_state, change);
            run(setup, (choice, size), changed, (cancel, limit), progress)
        };
        let other_size = match (choice.method.step_control, choice.step_size) {
            (StepControl::Exact, size) => size,
            (_, StepSize::Adaptive(tolerance)) => {
                StepSize::Adaptive((TOLERANCE_RATIO * tolerance).min(0.1))
            }
            (_, StepSize::Fixed(step)) => StepSize::Fixed(STEP_RATIO * step),
        };
        let second = rerun(PERTURBATION_SHARE, other_size)?;
        let divergences: Vec<Divergence> = (first.values.iter().zip(&second.values))
            .map(|(a, b)| Divergence::new(&first.time, a, b))
            .collect();
        let onsets = divergences.iter().filter_map(|p| p.lasting_from);
        let until = onsets.reduce(f64::min);
        let predictability = |(output, divergence): (usize, &Divergence)| {
            output_predictability(first, &second, output, (divergence.lasting_from, until))
        };
        let outputs: Vec<_> = divergences.iter().enumerate().map(predictability).collect();
        let all_shown = outputs.iter().all(|o| o.all_shown);
        let amplification = match (choice.method.step_control, all_shown) {
            (StepControl::Exact, _) => {
                (first.deflections).amplification(&second.deflections, PERTURBATION_SHARE)
            }
            (_, true) => None,
            (_, false) => {
                let change = first.deflections.change_above_errors(&second.deflections);
                let third = rerun(change, choice.step_size)?;
                (first.deflections).amplification(&third.deflections, change)
            }
        };
        let temporary = divergences.iter().filter_map(|p| p.temporary);
        Ok(Sensitivity {
            amplification,
            temporary_parting: temporary
                .reduce(|[a, b], [from, to]| [a.min(from), b.max(to)])
                .filter(|_| until.is_none()),
            outputs,
            seconds: start.elapsed().as_secs_f64(),
        })
    }
}

/// Repeats the run from another initial state with the given tolerance or step.
fn run(
    setup: &SimulationSetup,
    (choice, size): (&MethodChoice, StepSize),
    start: Vec<f64>,
    (cancel, limit): (&CancelToken, f64),
    progress: &dyn Fn(f64),
) -> Result<RunSamples, Error> {
    let model = &setup.model.model;
    let mut problem =
        integration_problem(setup, choice, setup.samples, &cancel.with_deadline(limit));
    (problem.initial_state, problem.step_size) = (start, size);
    let mut rows = RunSamples::new(setup);
    let mut is_finite = true;
    (choice.method.run)(model, &problem, &mut |t, y, regime| {
        let values = setup.outputs.evaluate(model, regime, t, y);
        is_finite = values.iter().all(|value| value.is_finite());
        rows.see(setup, (t, y), &values);
        progress(t / setup.end_time);
        match is_finite {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        }
    })?;
    if !is_finite {
        return Err(Error::new(Code::Overflow, "the second run diverged"));
    }
    if rows.count <= setup.samples {
        let message = format!(
            "a run from a perturbed initial state takes more than {}, {MAX_TIME_RATIO} times the first",
            format_duration(limit)
        );
        return Err(Error::new(Code::BudgetExceeded, message));
    }
    Ok(rows)
}

/// Predictability of an output with a lasting divergence at `until`, of a motion with the first lasting divergence at `any_until`. A later
/// extreme is predictable only for an output without divergence, with four predictable digits.
fn output_predictability(
    first: &RunSamples,
    second: &RunSamples,
    output: usize,
    (until, any_until): (Option<f64>, Option<f64>),
) -> OutputPredictability {
    let (a, b) = (&first.values[output], &second.values[output]);
    let statistics = [first, second].map(|rows| rows.accumulators[output].statistics());
    let [Some(x), Some(y)] = statistics else {
        return OutputPredictability {
            until,
            end: None,
            min: None,
            min_at: None,
            max: None,
            max_at: None,
            mean: f64::NAN,
            standard_deviation: f64::NAN,
            second_half: None,
            all_shown: false,
        };
    };
    let predicted = |time: f64| any_until.is_none_or(|until| time <= until);
    let error_bound = |x: f64, y: f64| ERROR_FACTOR * (x - y).abs();
    let largest = x.max.0.abs().max(x.min.0.abs());
    let shows_digits = |error: Option<f64>| {
        error.is_some_and(|error| 2.0 * error <= largest * 10f64.powi(-TABLE_DIGITS))
    };
    let extreme = |x: (f64, f64), y: (f64, f64)| {
        let (value, time) = (error_bound(x.0, y.0), error_bound(x.1, y.1));
        let is_early = predicted(x.1) && predicted(y.1);
        let is_known = is_early || (until.is_none() && shows_digits(Some(value)));
        let is_time_known = is_known && 2.0 * time <= x.1;
        (is_known.then_some(value), is_time_known.then_some(time))
    };
    let (minimum, maximum) = (extreme(x.min, y.min), extreme(x.max, y.max));
    let block_scatter = |statistic: fn(&OutputStatistics) -> f64| match until {
        None => 0.0,
        Some(_) => block_error([a, b], statistic),
    };
    let mean = error_bound(x.mean, y.mean).max(block_scatter(|r| r.mean));
    let standard_deviation = error_bound(x.standard_deviation, y.standard_deviation)
        .max(block_scatter(|r| r.standard_deviation));
    let end = until.is_none().then(|| error_bound(x.end, y.end));
    let all_shown = [
        end,
        minimum.0,
        maximum.0,
        Some(mean),
        Some(standard_deviation),
    ]
    .into_iter()
    .all(shows_digits);
    let half = |values: &[f64]| values[values.len() / 2..].to_vec();
    OutputPredictability {
        until,
        end,
        min: minimum.0,
        min_at: minimum.1,
        max: maximum.0,
        max_at: maximum.1,
        mean,
        standard_deviation,
        second_half: until.map(|_| Statistics::from_runs([&half(a), &half(b)])),
        all_shown,
    }
}

/// Divergence of the samples of two runs.
struct Divergence {
    /// Start of the lasting divergence, over at least [`MIN_DIVERGED_DURATION`] of the remaining time, s.
    lasting_from: Option<f64>,
    /// Interval of temporary divergence, s.
    temporary: Option<[f64; 2]>,
}

impl Divergence {
    fn new(time: &[f64], a: &[f64], b: &[f64]) -> Divergence {
        let largest = a.iter().fold(0.0f64, |max, x| max.max(x.abs()));
        let range = peak_to_peak(a).max(peak_to_peak(b));
        let limit = (DIVERGED_SAMPLE_SHARE * range).max(CONSTANT_SHARE * largest);
        let windows = (a.len() / SAMPLES_PER_WINDOW).clamp(1, MAX_WINDOWS);
        let length = a.len().div_ceil(windows).max(1);
        let diverged = a.chunks(length).zip(b.chunks(length)).map(|(a, b)| {
            let n_diverged = a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > limit);
            n_diverged.count() as f64 > MAX_DIVERGED_SHARE * a.len() as f64
        });
        let diverged: Vec<bool> = diverged.collect();
        let lasting = (0..diverged.len()).find(|&window| {
            let remaining = &diverged[window..];
            let count = remaining.iter().filter(|diverged| **diverged).count();
            diverged[window] && count as f64 >= MIN_DIVERGED_DURATION * remaining.len() as f64
        });
        let ends = [
            diverged.iter().position(|d| *d),
            diverged.iter().rposition(|d| *d).map(|last| last + 1),
        ];
        let instant = |window: usize| time.get(window * length).or(time.last()).copied();
        let temporary = match ends.map(|end| end.and_then(instant)) {
            [Some(from), Some(to)] if lasting.is_none() => Some([from, to]),
            _ => None,
        };
        Divergence {
            lasting_from: lasting.and_then(instant),
            temporary,
        }
    }
}
