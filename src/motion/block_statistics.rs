//! Statistics of a motion whose history cannot be predicted, with what they may be off by: the scatter of blocks of two runs.

use super::output_statistics::{OutputStatistics, StatisticsAccumulator};
use crate::numeric::statistics::student_t_quantile;

/// Blocks of each of two runs.
const BLOCKS: usize = 4;

/// The fewest samples of a block whose percentiles mean anything.
const MIN_BLOCK_SAMPLES: usize = 100;

/// Shares of the samples that lie below a percentile.
pub const PERCENTILES: [f64; 3] = [0.01, 0.5, 0.99];

/// A number and what it may be off by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UncertainValue {
    /// The number.
    pub value: f64,
    /// Half the 95 % interval.
    pub error: f64,
}

/// Statistics of an output over a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Statistics {
    /// Mean value.
    pub mean: UncertainValue,
    /// The root of the mean square about it.
    pub standard_deviation: UncertainValue,
    /// The values below which [`PERCENTILES`] of the samples lie; absent where samples are too few.
    pub percentiles: Option<[UncertainValue; 3]>,
}

impl Statistics {
    /// Pooled statistics of two runs.
    pub fn from_runs(runs: [&[f64]; 2]) -> Statistics {
        let all: Vec<f64> = runs.concat();
        let own = reading(&all);
        let known = |of: fn(&OutputStatistics) -> f64| UncertainValue {
            value: own.as_ref().map_or(0.0, of),
            error: block_error(runs, of),
        };
        let enough = runs
            .iter()
            .all(|run| run.len() >= BLOCKS * MIN_BLOCK_SAMPLES);
        let percentiles = PERCENTILES.map(|share| UncertainValue {
            value: percentile(&all, share),
            error: error(runs, &|block| percentile(block, share)),
        });
        Statistics {
            mean: known(|r| r.mean),
            standard_deviation: known(|r| r.standard_deviation),
            percentiles: enough.then_some(percentiles),
        }
    }
}

/// Error of a reading over two runs, from the scatter of its blocks.
pub fn block_error(runs: [&[f64]; 2], of: fn(&OutputStatistics) -> f64) -> f64 {
    error(runs, &|block| reading(block).as_ref().map_or(0.0, of))
}

/// Half the 95 % interval of the mean over the blocks of both runs.
fn error(runs: [&[f64]; 2], of: &dyn Fn(&[f64]) -> f64) -> f64 {
    let blocks = runs.iter().flat_map(|run| {
        let long = run.len().div_ceil(BLOCKS).max(1);
        run.chunks(long).map(of)
    });
    let mut reader = StatisticsAccumulator::default();
    let count = blocks.map(|x| reader.push(0.0, x)).count() as f64;
    let standard_deviation = reader.statistics().map_or(0.0, |r| r.standard_deviation);
    match count > 1.0 {
        true => student_t_quantile(0.975, count - 1.0) * standard_deviation / (count - 1.0).sqrt(),
        false => f64::INFINITY,
    }
}

fn reading(values: &[f64]) -> Option<OutputStatistics> {
    let mut reader = StatisticsAccumulator::default();
    values.iter().for_each(|x| reader.push(0.0, *x));
    reader.statistics()
}

/// The value below which a share of all lies.
fn percentile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = share * sorted.len().saturating_sub(1) as f64;
    sorted.get(at.round() as usize).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine of amplitude 1 over whole periods in every block: mean 0, standard_deviation 1/√2, percentiles sin of the quantile's angle, known exactly.
    #[test]
    fn exact_statistics_of_a_sine() {
        let n = 8000;
        let sine = |k: usize| (std::f64::consts::TAU * 8.0 * (k as f64 + 0.5) / n as f64).sin();
        let run: Vec<f64> = (0..n).map(sine).collect();
        let found = Statistics::from_runs([&run, &run]);
        assert!(found.mean.value.abs() < 1e-12 && found.mean.error < 1e-12);
        assert!((found.standard_deviation.value - 0.5f64.sqrt()).abs() < 1e-12);
        let [low, middle, high] = found.percentiles.unwrap();
        let expected = (std::f64::consts::PI * 0.49).sin();
        assert!((low.value + expected).abs() < 5e-4 && (high.value - expected).abs() < 5e-4);
        assert!(middle.value.abs() < 5e-3 && high.error < 1e-4);
    }
}
