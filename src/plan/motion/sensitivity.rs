//! Sensitivity of a motion to its initial conditions, and the digits of its readings that hold: two runs compared.
//!
//! Beyond the instant at which both have parted the history is one of many; what holds there are its statistics.

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

/// The second run of a method goes by so many times the tolerance.
const TOLERANCE_RATIO: f64 = 10.0;

/// The second run of a method with a fixed step goes by so many times the step.
const STEP_RATIO: f64 = 0.8;

/// A reading may be off by so many times what two runs differ by: the difference of one pair may be small by chance.
const ERROR_FACTOR: f64 = 3.0;

/// Digits that a table shows.
const TABLE_DIGITS: i32 = 4;

/// Samples compared of each output, at most.
const MAX_COMPARED_SAMPLES: usize = 20_000;

/// The second run may take so many times the first, and [`MIN_TIME_S`] seconds.
const MAX_TIME_RATIO: f64 = 4.0;
const MIN_TIME_S: f64 = 1.0;

/// Parts of the time, at most, each with [`SAMPLES_PER_WINDOW`] samples at least, that are predicted or not.
const MAX_WINDOWS: usize = 200;
const SAMPLES_PER_WINDOW: usize = 20;

/// A sample has parted where it differs by this share of the range of the output: two digits no longer hold.
const DIVERGED_SAMPLE_SHARE: f64 = 0.01;

/// Nor has a sample parted that differs by less than this share of the largest value: an output without range is constant.
const CONSTANT_SHARE: f64 = 1e-7;

/// A part of the time is not predicted where more than this share of its samples has parted: fewer are jumps a little earlier or later.
const MAX_DIVERGED_SHARE: f64 = 0.05;

/// Smallest share of the remaining time of a lasting divergence: below it the loss of predictability is temporary.
const MIN_DIVERGED_DURATION: f64 = 0.1;

/// Samples of a run, kept for comparison with another.
#[derive(Debug, Clone)]
pub struct RunSamples {
    deflections: Deflections,
    /// Stride between kept samples.
    stride: usize,
    count: usize,
    time: Vec<f64>,
    values: Vec<Vec<f64>>,
    accumulators: Vec<StatisticsAccumulator>,
}

impl RunSamples {
    /// For the samples of a scene.
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

    /// Takes the next sample: instant and state, outputs.
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
    /// Amplification of a change of the start; absent where every digit shown holds and the method makes errors of its own, larger than the
    /// remainder of such a change.
    pub amplification: Option<Amplification>,
    /// Between these instants, s, the runs part and meet again; absent where they never part, or part for good.
    pub temporary_parting: Option<[f64; 2]>,
    /// Predictability of each output.
    pub outputs: Vec<OutputPredictability>,
    /// Run time of the further runs, s.
    pub seconds: f64,
}

/// Predictability of an output.
#[derive(Debug, Clone)]
pub struct OutputPredictability {
    /// From here on its history cannot be predicted, s.
    pub until: Option<f64>,
    /// Error bound of the final reading; absent where it is not predictable.
    pub end: Option<f64>,
    /// The least value.
    pub min: Option<f64>,
    /// The instant of it, s.
    pub min_at: Option<f64>,
    /// The greatest value.
    pub max: Option<f64>,
    /// The instant of it, s.
    pub max_at: Option<f64>,
    /// The mean.
    pub mean: f64,
    /// The root of the mean square about it.
    pub standard_deviation: f64,
    /// Statistics of the second half of the time, where the history is not predictable.
    pub second_half: Option<Statistics>,
    /// Four digits of every reading hold, by the range of the output.
    pub all_shown: bool,
}

impl Sensitivity {
    /// Share of the deflections by which the start was changed.
    pub fn change(&self) -> f64 {
        self.amplification.map_or(PERTURBATION_SHARE, |a| a.change)
    }

    /// From here on the history of some output cannot be predicted, s.
    pub fn until(&self) -> Option<f64> {
        let all = self.outputs.iter().filter_map(|o| o.until);
        all.reduce(f64::min)
    }

    /// Every digit that a table shows holds.
    pub fn all_shown(&self) -> bool {
        self.outputs.iter().all(|o| o.all_shown)
    }

    /// Runs the motion again from a changed start and compares; `hear` hears what share is done.
    ///
    /// # Errors
    /// Those of the method; `BudgetExceeded` where the second run takes far longer than the first.
    pub fn measure(
        setup: &SimulationSetup,
        choice: &MethodChoice,
        (first, seconds): (&RunSamples, f64),
        cancel: &CancelToken,
        hear: &dyn Fn(f64),
    ) -> Result<Sensitivity, Error> {
        let begun = Instant::now();
        let patience = MAX_TIME_RATIO * seconds + MIN_TIME_S;
        let again = |change: f64, size: StepSize| {
            let changed =
                first
                    .deflections
                    .perturbed_start(&setup.model.model, &setup.initial_state, change);
            run(setup, (choice, size), changed, (cancel, patience), hear)
        };
        let other = match (choice.method.step_control, choice.step_size) {
            (StepControl::Exact, size) => size,
            (_, StepSize::Adaptive(tolerance)) => {
                StepSize::Adaptive((TOLERANCE_RATIO * tolerance).min(0.1))
            }
            (_, StepSize::Fixed(step)) => StepSize::Fixed(STEP_RATIO * step),
        };
        let second = again(PERTURBATION_SHARE, other)?;
        let partings: Vec<Parting> = (first.values.iter().zip(&second.values))
            .map(|(a, b)| Parting::of(&first.time, a, b))
            .collect();
        let untils = partings.iter().filter_map(|p| p.lasting_from);
        let until = untils.reduce(f64::min);
        let of = |(at, parting): (usize, &Parting)| {
            digits(first, &second, at, (parting.lasting_from, until))
        };
        let outputs: Vec<OutputPredictability> = partings.iter().enumerate().map(of).collect();
        let shown = outputs.iter().all(|o| o.all_shown);
        let amplification = match (choice.method.step_control, shown) {
            (StepControl::Exact, _) => {
                (first.deflections).amplification(&second.deflections, PERTURBATION_SHARE)
            }
            (_, true) => None,
            (_, false) => {
                let change = first.deflections.change_above_errors(&second.deflections);
                let third = again(change, choice.step_size)?;
                (first.deflections).amplification(&third.deflections, change)
            }
        };
        let temporary = partings.iter().filter_map(|p| p.temporary);
        Ok(Sensitivity {
            amplification,
            temporary_parting: temporary
                .reduce(|[a, b], [from, to]| [a.min(from), b.max(to)])
                .filter(|_| until.is_none()),
            outputs,
            seconds: begun.elapsed().as_secs_f64(),
        })
    }
}

/// Repeats the run from another start and at the given tolerance.
fn run(
    setup: &SimulationSetup,
    (choice, size): (&MethodChoice, StepSize),
    start: Vec<f64>,
    (cancel, patience): (&CancelToken, f64),
    hear: &dyn Fn(f64),
) -> Result<RunSamples, Error> {
    let model = &setup.model.model;
    let mut ask = integration_problem(
        setup,
        choice,
        setup.samples,
        &cancel.with_deadline(patience),
    );
    (ask.initial_state, ask.step_size) = (start, size);
    let mut rows = RunSamples::new(setup);
    let mut finite = true;
    (choice.method.run)(model, &ask, &mut |t, y, regime| {
        let now = setup.outputs.evaluate(model, regime, t, y);
        finite = now.iter().all(|value| value.is_finite());
        rows.see(setup, (t, y), &now);
        hear(t / setup.end_time);
        match finite {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        }
    })?;
    if !finite {
        return Err(Error::new(Code::Overflow, "the second run diverged"));
    }
    if rows.count <= setup.samples {
        let message = format!(
            "a run from a changed start takes more than {}, {MAX_TIME_RATIO} times the first",
            format_duration(patience)
        );
        return Err(Error::new(Code::BudgetExceeded, message));
    }
    Ok(rows)
}

/// Predictable digits of an output that parts for good at `until`, of a motion some output of which parts at `any_until`. From there on the
/// motion is one of many: a later extreme is predictable only of an output that never parts, with four digits that hold.
fn digits(
    first: &RunSamples,
    second: &RunSamples,
    output: usize,
    (until, any_until): (Option<f64>, Option<f64>),
) -> OutputPredictability {
    let (a, b) = (&first.values[output], &second.values[output]);
    let readings = [first, second].map(|rows| rows.accumulators[output].statistics());
    let [Some(x), Some(y)] = readings else {
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
    let predicted = |at: f64| any_until.is_none_or(|until| at <= until);
    let off = |x: f64, y: f64| ERROR_FACTOR * (x - y).abs();
    let size = x.max.0.abs().max(x.min.0.abs());
    let holds = |error: Option<f64>| {
        error.is_some_and(|error| 2.0 * error <= size * 10f64.powi(-TABLE_DIGITS))
    };
    let extreme = |x: (f64, f64), y: (f64, f64)| {
        let (value, at) = (off(x.0, y.0), off(x.1, y.1));
        let early = predicted(x.1) && predicted(y.1);
        let both = early || (until.is_none() && holds(Some(value)));
        let known = both && 2.0 * at <= x.1;
        (both.then_some(value), known.then_some(at))
    };
    let (least, greatest) = (extreme(x.min, y.min), extreme(x.max, y.max));
    let scatter = |of: fn(&OutputStatistics) -> f64| match until {
        None => 0.0,
        Some(_) => block_error([a, b], of),
    };
    let mean = off(x.mean, y.mean).max(scatter(|r| r.mean));
    let standard_deviation =
        off(x.standard_deviation, y.standard_deviation).max(scatter(|r| r.standard_deviation));
    let end = until.is_none().then(|| off(x.end, y.end));
    let all_shown = [
        end,
        least.0,
        greatest.0,
        Some(mean),
        Some(standard_deviation),
    ]
    .into_iter()
    .all(holds);
    let half = |values: &[f64]| values[values.len() / 2..].to_vec();
    OutputPredictability {
        until,
        end,
        min: least.0,
        min_at: least.1,
        max: greatest.0,
        max_at: greatest.1,
        mean,
        standard_deviation,
        second_half: until.map(|_| Statistics::from_runs([&half(a), &half(b)])),
        all_shown,
    }
}

/// When the samples of two runs part.
struct Parting {
    /// From here on they stay apart, in [`MIN_DIVERGED_DURATION`] of what follows at least, s.
    lasting_from: Option<f64>,
    /// Between these instants they part, s, and not for good.
    temporary: Option<[f64; 2]>,
}

impl Parting {
    fn of(time: &[f64], a: &[f64], b: &[f64]) -> Parting {
        let size = a.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        let range = peak_to_peak(a).max(peak_to_peak(b));
        let limit = (DIVERGED_SAMPLE_SHARE * range).max(CONSTANT_SHARE * size);
        let windows = (a.len() / SAMPLES_PER_WINDOW).clamp(1, MAX_WINDOWS);
        let long = a.len().div_ceil(windows).max(1);
        let lost = a.chunks(long).zip(b.chunks(long)).map(|(a, b)| {
            let apart = a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > limit);
            apart.count() as f64 > MAX_DIVERGED_SHARE * a.len() as f64
        });
        let lost: Vec<bool> = lost.collect();
        let lasting = (0..lost.len()).find(|&at| {
            let rest = &lost[at..];
            let count = rest.iter().filter(|lost| **lost).count();
            lost[at] && count as f64 >= MIN_DIVERGED_DURATION * rest.len() as f64
        });
        let ends = [
            lost.iter().position(|lost| *lost),
            lost.iter().rposition(|lost| *lost).map(|last| last + 1),
        ];
        let instant = |window: usize| time.get(window * long).or(time.last()).copied();
        let temporary = match ends.map(|end| end.and_then(instant)) {
            [Some(from), Some(to)] if lasting.is_none() => Some([from, to]),
            _ => None,
        };
        Parting {
            lasting_from: lasting.and_then(instant),
            temporary,
        }
    }
}
