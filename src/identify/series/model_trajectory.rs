//! Time-varying ARX model by recursive least squares: order and memory chosen, modes joined to tracks.
//!
//! The criterion is the mean square of the one-step errors made before each sample was used: Rissanen, IEEE Trans. Inf. Theory 30 (1984),
//! 629–636, "predictive least squares". It needs no penalty, since what is fitted to noise predicts the next sample worse.

use super::io_data::{InputOutputData, check_order, remove_mean};
use super::model::{ModelStructure, PolynomialModel};
use super::recursive::{RecursiveLeastSquares, RecursiveOptions};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::text::pluralise;
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::sorting::sort_rising;

/// Instants at which the model is looked at, evenly over the record.
pub const INSTANTS: usize = 200;

/// Shares of the record that are tried as memory, the longest first; infinity forgets nothing.
const MEMORY_SHARES: [f64; 6] = [f64::INFINITY, 0.3, 0.1, 0.03, 0.01, 0.003];

/// The share with which orders are compared.
const MEMORY_OF_ORDERS: f64 = 0.1;

/// Samples of memory for each unknown, at least.
pub const SAMPLES_PER_UNKNOWN: f64 = 10.0;

/// Orders one after the other that may predict no better before the search ends.
const MAX_ORDERS_WITHOUT_GAIN: usize = 3;

/// An order with a memory, and how well it predicted.
#[derive(Debug, Clone, PartialEq)]
pub struct MemoryTrial {
    /// The polynomials.
    pub family: ModelStructure,
    /// Samples of memory, `1/(1 − λ)`; infinite where nothing is forgotten.
    pub memory: f64,
    /// Mean square of the errors with which each sample was predicted before it was used, output squared.
    pub error_variance: f64,
}

/// A model as it was at some instants.
#[derive(Debug, Clone)]
pub struct ModelTrajectory {
    /// Selected memory length and its trial.
    pub chosen: MemoryTrial,
    /// The largest family that could have been tried.
    pub highest: ModelStructure,
    /// All that was tried.
    pub trials: Vec<MemoryTrial>,
    /// Mean square of the output over the samples predicted.
    pub output_variance: f64,
    /// Errors with which the samples were predicted, but for the first ones, which start the recursion.
    pub errors: Vec<f64>,
    /// Seconds from the first sample, and the model then.
    pub instants: Vec<(f64, PolynomialModel)>,
}

/// Follows a record with one of the orders (coefficients of A, rising) and a memory in samples, or the one that predicts best.
///
/// # Errors
/// `TooShort` where the record does not bear the orders, or the memory given holds fewer than ten samples for each unknown.
pub fn track_model(
    record: &InputOutputData,
    orders: &[usize],
    memory: Option<f64>,
) -> Result<ModelTrajectory, Error> {
    let mut runs = RecursionData::new(record);
    if let (Some(memory), Some(&a)) = (memory, orders.first()) {
        runs.check_memory(a, memory)?;
    }
    let bears = memory.unwrap_or(runs.samples() / 2.0);
    let orders: Vec<usize> = (orders.iter().copied())
        .filter(|&a| runs.least_memory(a) <= bears)
        .collect();
    let largest = orders
        .last()
        .map_or(0, |&a| runs.family(a).parameter_count());
    check_order(record.samples(), largest, 2 * largest)?;
    runs.first = (4 * largest).min(record.samples() / 4);
    let mut tried: Vec<MemoryTrial> = Vec::new();
    // All trials after the orders are of the best of these, so the best of all is one of its family.
    let mut best: Option<RecursionRun> = None;
    let mut try_it = |a: usize, memory: f64| -> Result<bool, Error> {
        let run = runs.run(a, memory)?;
        tried.push(run.trial.clone());
        let is_better =
            (best.as_ref()).is_none_or(|best| run.trial.error_variance < best.trial.error_variance);
        if is_better {
            best = Some(run);
        }
        Ok(is_better)
    };
    let (mut order, mut in_vain) = (0, 0);
    for &a in &orders {
        let share = (MEMORY_OF_ORDERS * runs.samples()).max(runs.least_memory(a));
        in_vain += 1;
        if try_it(a, memory.unwrap_or(share))? {
            (order, in_vain) = (a, 0);
        }
        if in_vain == MAX_ORDERS_WITHOUT_GAIN {
            break;
        }
    }
    if memory.is_none() {
        let of_orders = (MEMORY_OF_ORDERS * runs.samples()).max(runs.least_memory(order));
        for memory in MEMORY_SHARES.map(|share| share * runs.samples()) {
            if memory >= runs.least_memory(order) && memory != of_orders {
                try_it(order, memory)?;
            }
        }
    }
    let best = best.ok_or_else(|| Error::new(Code::OutOfRange, "no order was requested"))?;
    Ok(ModelTrajectory {
        chosen: best.trial,
        highest: runs.family(orders.last().copied().unwrap_or(order)),
        trials: tried,
        output_variance: mean_square(&runs.output[runs.first..]),
        errors: best.errors,
        instants: best.instants,
    })
}

fn mean_square(samples: &[f64]) -> f64 {
    samples.iter().map(|y| y * y).sum::<f64>() / samples.len() as f64
}

/// A record without its means, to be run over by several models.
struct RecursionData {
    output: Vec<f64>,
    input: Option<Vec<f64>>,
    rate_hz: f64,
    /// The first sample whose error counts.
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

    /// The shortest memory that determines an order, samples.
    fn least_memory(&self, a: usize) -> f64 {
        SAMPLES_PER_UNKNOWN * self.family(a).parameter_count() as f64
    }

    fn check_memory(&self, a: usize, memory: f64) -> Result<(), Error> {
        let least = self.least_memory(a);
        if memory >= least {
            return Ok(());
        }
        let message = format!(
            "a memory of {memory:.0} samples bears {:.0} unknowns at most; {} has {}",
            memory / SAMPLES_PER_UNKNOWN,
            pluralise(a / 2, "mode"),
            self.family(a).parameter_count()
        );
        Err(Error::new(Code::TooShort, message).with_hint(format!(
            "take {:.3} s of memory or more, or fewer modes",
            least / self.rate_hz
        )))
    }

    /// One run over the record, the model looked at once it has settled.
    fn run(&self, a: usize, memory: f64) -> Result<RecursionRun, Error> {
        let mut following = RecursiveLeastSquares::new(self.settings(a, memory))?;
        let family = self.family(a);
        let step = (self.output.len() / INSTANTS).max(1);
        let unknowns = 4.0 * family.parameter_count() as f64;
        let settled = memory.min(self.samples() / 10.0).max(unknowns) as usize;
        let mut errors = Vec::with_capacity(self.output.len() - self.first);
        let mut instants = Vec::new();
        for (k, &y) in self.output.iter().enumerate() {
            let u = self.input.as_ref().map_or(0.0, |u| u[k]);
            let error = following.push(u, y)?;
            if k >= self.first {
                errors.push(error);
            }
            if k >= settled && (k + 1) % step == 0 {
                // Where nothing moves, the samples in memory determine no model.
                let model = following.model().ok();
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

/// A trial, and the model as it was at some instants.
struct RecursionRun {
    trial: MemoryTrial,
    errors: Vec<f64>,
    instants: Vec<(f64, PolynomialModel)>,
}

/// One mode over the instants at which it was found.
#[derive(Debug, Clone)]
pub struct ModeTrack {
    /// Place of each instant, and the mode then.
    pub points: Vec<(usize, ModalParameters)>,
}

/// Instants that a mode may be lost for.
const MAX_MISSED_INSTANTS: usize = 5;

/// A change of frequency between two instants by which a mode stays itself, relative; three standard deviations, where they are more.
const MAX_FREQUENCY_STEP: f64 = 0.05;

/// Joins the modes of successive instants, nearest first; tracks of fewer than `least` points are left out.
pub fn mode_tracks(instants: &[Vec<ModalParameters>], least: usize) -> Vec<ModeTrack> {
    let mut all: Vec<ModeTrack> = Vec::new();
    for (at, modes) in instants.iter().enumerate() {
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (t, track) in all.iter().enumerate() {
            let Some((seen, last)) = track
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
                let apart = (mode.frequency_hz() - f).abs();
                if apart <= (MAX_FREQUENCY_STEP * f * (at - seen) as f64).max(3.0 * std) {
                    pairs.push((apart / f, t, m));
                }
            }
        }
        sort_rising(&mut pairs, |a| a.0);
        let mut track_of: Vec<Option<usize>> = vec![None; modes.len()];
        let mut taken = vec![false; all.len()];
        for (_, t, m) in pairs {
            if !taken[t] && track_of[m].is_none() {
                taken[t] = true;
                track_of[m] = Some(t);
            }
        }
        for (mode, track) in modes.iter().zip(track_of) {
            let point = (at, mode.clone());
            match track {
                Some(t) => all[t].points.push(point),
                None => all.push(ModeTrack {
                    points: vec![point],
                }),
            }
        }
    }
    all.retain(|t| t.points.len() >= least);
    all
}
