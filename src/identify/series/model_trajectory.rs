//! Time-varying ARX model by recursive least squares, with selection of order and memory, and tracks of its modes.
//!
//! The criterion is the mean square of the a priori one-step prediction errors ("predictive least squares": Rissanen, IEEE Trans. Inf.
//! Theory 30 (1984), 629–636). It needs no penalty term, since a model fitted to noise predicts the next sample worse.

use super::io_data::{InputOutputData, check_order, remove_mean};
use super::model::{ModelStructure, PolynomialModel};
use super::recursive::{RecursiveLeastSquares, RecursiveOptions};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::text::pluralise;
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::sorting::sort_ascending;

/// Number of instants at which the model is sampled, equally spaced over the record.
pub const INSTANTS: usize = 200;

/// Trial memories as shares of the record, the longest first; infinite: no forgetting.
const MEMORY_SHARES: [f64; 6] = [f64::INFINITY, 0.3, 0.1, 0.03, 0.01, 0.003];

/// Memory for the comparison of orders, as a share of the record.
const MEMORY_OF_ORDERS: f64 = 0.1;

/// Minimum memory per unknown, samples.
pub const SAMPLES_PER_UNKNOWN: f64 = 10.0;

/// Number of consecutive orders without a better prediction that ends the search.
const MAX_ORDERS_WITHOUT_GAIN: usize = 3;

/// Trial of an order and a memory with its prediction error.
#[derive(Debug, Clone, PartialEq)]
pub struct MemoryTrial {
    /// Model structure.
    pub family: ModelStructure,
    /// Memory `1/(1 − λ)`, samples; infinite without forgetting.
    pub memory: f64,
    /// Mean square of the a priori prediction errors, output unit squared.
    pub error_variance: f64,
}

/// Time-varying model sampled at instants, with the trials of its selection.
#[derive(Debug, Clone)]
pub struct ModelTrajectory {
    /// Selected trial.
    pub selected: MemoryTrial,
    /// Largest structure that the record length permits.
    pub max_structure: ModelStructure,
    /// Trials in order of computation.
    pub trials: Vec<MemoryTrial>,
    /// Mean square of the output over the predicted samples, output unit squared.
    pub output_variance: f64,
    /// A priori prediction errors without the initial samples of the recursion.
    pub errors: Vec<f64>,
    /// Time from the first sample, s, and the model at this time.
    pub instants: Vec<(f64, PolynomialModel)>,
}

/// Tracks a record with the `orders` (numbers of coefficients of A, ascending) and memories, and selects the trial that predicts best.
///
/// # Errors
/// `TooShort` if the record is too short for the orders, or the `memory` (samples) is shorter than ten samples per unknown.
pub fn track_model(
    record: &InputOutputData,
    orders: &[usize],
    memory: Option<f64>,
) -> Result<ModelTrajectory, Error> {
    let mut runs = RecursionData::new(record);
    if let (Some(memory), Some(&a)) = (memory, orders.first()) {
        runs.check_memory(a, memory)?;
    }
    let max_memory = memory.unwrap_or(runs.samples() / 2.0);
    let orders: Vec<usize> = (orders.iter().copied())
        .filter(|&a| runs.min_memory(a) <= max_memory)
        .collect();
    let max_parameters = orders
        .last()
        .map_or(0, |&a| runs.family(a).parameter_count());
    check_order(record.samples(), max_parameters, 2 * max_parameters)?;
    runs.first = (4 * max_parameters).min(record.samples() / 4);
    let mut trials: Vec<MemoryTrial> = Vec::new();
    // The trials of the memory use the best order, so the best trial has its structure.
    let mut best: Option<RecursionRun> = None;
    let mut evaluate = |a: usize, memory: f64| -> Result<bool, Error> {
        let run = runs.run(a, memory)?;
        trials.push(run.trial.clone());
        let is_better =
            (best.as_ref()).is_none_or(|best| run.trial.error_variance < best.trial.error_variance);
        if is_better {
            best = Some(run);
        }
        Ok(is_better)
    };
    let (mut order, mut n_worse) = (0, 0);
    for &a in &orders {
        let share = (MEMORY_OF_ORDERS * runs.samples()).max(runs.min_memory(a));
        n_worse += 1;
        if evaluate(a, memory.unwrap_or(share))? {
            (order, n_worse) = (a, 0);
        }
        if n_worse == MAX_ORDERS_WITHOUT_GAIN {
            break;
        }
    }
    if memory.is_none() {
        let of_orders = (MEMORY_OF_ORDERS * runs.samples()).max(runs.min_memory(order));
        for memory in MEMORY_SHARES.map(|share| share * runs.samples()) {
            if memory >= runs.min_memory(order) && memory != of_orders {
                evaluate(order, memory)?;
            }
        }
    }
    let best = best.ok_or_else(|| Error::new(Code::OutOfRange, "no order was requested"))?;
    Ok(ModelTrajectory {
        selected: best.trial,
        max_structure: runs.family(orders.last().copied().unwrap_or(order)),
        trials,
        output_variance: mean_square(&runs.output[runs.first..]),
        errors: best.errors,
        instants: best.instants,
    })
}

fn mean_square(samples: &[f64]) -> f64 {
    samples.iter().map(|y| y * y).sum::<f64>() / samples.len() as f64
}

/// Record with subtracted means for several recursions.
struct RecursionData {
    output: Vec<f64>,
    input: Option<Vec<f64>>,
    rate_hz: f64,
    /// Index of the first sample in the error criterion.
    first: usize,
}

impl RecursionData {
    fn new(record: &InputOutputData) -> RecursionData {
        RecursionData {
            output: remove_mean(record.output()).0,
            input: record.input().map(|u| remove_mean(u).0),
            rate_hz: record.rate_hz(),
            first: 0,
        }
    }

    fn samples(&self) -> f64 {
        self.output.len() as f64
    }

    fn settings(&self, a: usize, memory: f64) -> RecursiveOptions {
        RecursiveOptions {
            a,
            b: self.input.as_ref().map_or(0, |_| a + 1),
            delay: 0,
            forgetting: 1.0 - 1.0 / memory,
            rate_hz: self.rate_hz,
        }
    }

    fn family(&self, a: usize) -> ModelStructure {
        self.settings(a, f64::INFINITY).structure()
    }

    /// Minimum memory of an order, samples.
    fn min_memory(&self, a: usize) -> f64 {
        SAMPLES_PER_UNKNOWN * self.family(a).parameter_count() as f64
    }

    fn check_memory(&self, a: usize, memory: f64) -> Result<(), Error> {
        let min_memory = self.min_memory(a);
        if memory >= min_memory {
            return Ok(());
        }
        let message = format!(
            "a memory of {memory:.0} samples determines at most {:.0} unknowns; {} has {}",
            memory / SAMPLES_PER_UNKNOWN,
            pluralise(a / 2, "mode"),
            self.family(a).parameter_count()
        );
        Err(Error::new(Code::TooShort, message).with_hint(format!(
            "use a memory of {:.3} s or more, or fewer modes",
            min_memory / self.rate_hz
        )))
    }

    /// Runs one recursion over the record and samples the model after the initial transient.
    fn run(&self, a: usize, memory: f64) -> Result<RecursionRun, Error> {
        let mut recursion = RecursiveLeastSquares::new(self.settings(a, memory))?;
        let family = self.family(a);
        let step = (self.output.len() / INSTANTS).max(1);
        let unknowns = 4.0 * family.parameter_count() as f64;
        let warm_up = memory.min(self.samples() / 10.0).max(unknowns) as usize;
        let mut errors = Vec::with_capacity(self.output.len() - self.first);
        let mut instants = Vec::new();
        for (k, &y) in self.output.iter().enumerate() {
            let u = self.input.as_ref().map_or(0.0, |u| u[k]);
            let error = recursion.push(u, y)?;
            if k >= self.first {
                errors.push(error);
            }
            if k >= warm_up && (k + 1) % step == 0 {
                // Samples in memory without motion do not determine a model.
                let model = recursion.model().ok();
                instants.extend(model.map(|m| (k as f64 / self.rate_hz, m)));
            }
        }
        Ok(RecursionRun {
            trial: MemoryTrial {
                family,
                memory,
                error_variance: mean_square(&errors),
            },
            errors,
            instants,
        })
    }
}

/// Trial with the prediction errors and the model at instants.
struct RecursionRun {
    trial: MemoryTrial,
    errors: Vec<f64>,
    instants: Vec<(f64, PolynomialModel)>,
}

/// Mode over the instants at which it was identified.
#[derive(Debug, Clone)]
pub struct ModeTrack {
    /// Index of the instant and the mode at this instant.
    pub points: Vec<(usize, ModalParameters)>,
}

/// Maximum gap of a track, instants.
const MAX_MISSED_INSTANTS: usize = 5;

/// Maximum relative change of frequency of a mode between two instants; three standard deviations if larger.
const MAX_FREQUENCY_STEP: f64 = 0.05;

/// Joins the modes of successive instants to tracks, nearest frequencies first, and drops tracks of fewer than `min_points` points.
pub fn mode_tracks(instants: &[Vec<ModalParameters>], min_points: usize) -> Vec<ModeTrack> {
    let mut tracks: Vec<ModeTrack> = Vec::new();
    for (at, modes) in instants.iter().enumerate() {
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (t, track) in tracks.iter().enumerate() {
            let Some((last_at, last)) = track
                .points
                .last()
                .filter(|p| at - p.0 <= MAX_MISSED_INSTANTS)
            else {
                continue;
            };
            for (m, mode) in modes.iter().enumerate() {
                let f = last.frequency_hz();
                let std = (last.frequency_std_hz().unwrap_or(0.0))
                    .hypot(mode.frequency_std_hz().unwrap_or(0.0));
                let distance = (mode.frequency_hz() - f).abs();
                if distance <= (MAX_FREQUENCY_STEP * f * (at - last_at) as f64).max(3.0 * std) {
                    pairs.push((distance / f, t, m));
                }
            }
        }
        sort_ascending(&mut pairs, |a| a.0);
        let mut track_of: Vec<Option<usize>> = vec![None; modes.len()];
        let mut is_assigned = vec![false; tracks.len()];
        for (_, t, m) in pairs {
            if !is_assigned[t] && track_of[m].is_none() {
                is_assigned[t] = true;
                track_of[m] = Some(t);
            }
        }
        for (mode, track) in modes.iter().zip(track_of) {
            let point = (at, mode.clone());
            match track {
                Some(t) => tracks[t].points.push(point),
                None => tracks.push(ModeTrack {
                    points: vec![point],
                }),
            }
        }
    }
    tracks.retain(|t| t.points.len() >= min_points);
    tracks
}
