//! Statistics of a chaotic motion with 95 % confidence intervals from the scatter of the blocks of two runs.

use super::output_statistics::{OutputStatistics, StatisticsAccumulator};
use crate::numeric::statistics::student_t_quantile;

/// Number of blocks of each run.
const BLOCKS: usize = 4;

/// Minimum number of samples of a block for percentiles.
const MIN_BLOCK_SAMPLES: usize = 100;

/// Fractions of the samples below the reported percentiles.
pub const PERCENTILES: [f64; 3] = [0.01, 0.5, 0.99];

/// Estimate with its 95 % confidence interval, `value ± error`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UncertainValue {
    /// Estimate, in the unit of the output.
    pub value: f64,
    /// Half width of the 95 % confidence interval; infinite with fewer than two blocks.
    pub error: f64,
}

/// Statistics of an output over two runs, in the unit of the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Statistics {
    /// Mean value.
    pub mean: UncertainValue,
    /// Standard deviation.
    pub standard_deviation: UncertainValue,
    /// Percentiles at the fractions [`PERCENTILES`]; absent with too few samples per block.
    pub percentiles: Option<[UncertainValue; 3]>,
}

impl Statistics {
    /// Pooled statistics of two runs.
    pub fn from_runs(runs: [&[f64]; 2]) -> Statistics {
        let samples: Vec<f64> = runs.concat();
        let pooled = stats_of(&samples);
        let estimate = |quantity: fn(&OutputStatistics) -> f64| UncertainValue {
            value: pooled.as_ref().map_or(0.0, quantity),
            error: block_error(runs, quantity),
        };
        let has_percentiles = runs
            .iter()
            .all(|run| run.len() >= BLOCKS * MIN_BLOCK_SAMPLES);
        let percentiles = PERCENTILES.map(|share| UncertainValue {
            value: percentile(&samples, share),
            error: half_width(runs, &|block| percentile(block, share)),
        });
        Statistics {
            mean: estimate(|r| r.mean),
            standard_deviation: estimate(|r| r.standard_deviation),
            percentiles: has_percentiles.then_some(percentiles),
        }
    }
}

/// Half width of the 95 % confidence interval of a statistic, from the scatter of the blocks of two runs.
pub fn block_error(runs: [&[f64]; 2], value: fn(&OutputStatistics) -> f64) -> f64 {
    half_width(runs, &|block| stats_of(block).as_ref().map_or(0.0, value))
}

/// Half width of the 95 % confidence interval of the mean over the blocks of both runs (Student's t).
fn half_width(runs: [&[f64]; 2], quantity: &dyn Fn(&[f64]) -> f64) -> f64 {
    let blocks = runs.iter().flat_map(|run| {
        let block_len = run.len().div_ceil(BLOCKS).max(1);
        run.chunks(block_len).map(quantity)
    });
    let mut stats = StatisticsAccumulator::default();
    let count = blocks.map(|x| stats.push(0.0, x)).count() as f64;
    let standard_deviation = stats.statistics().map_or(0.0, |r| r.standard_deviation);
    match count > 1.0 {
        true => student_t_quantile(0.975, count - 1.0) * standard_deviation / (count - 1.0).sqrt(),
        false => f64::INFINITY,
    }
}

fn stats_of(values: &[f64]) -> Option<OutputStatistics> {
    let mut stats = StatisticsAccumulator::default();
    values.iter().for_each(|x| stats.push(0.0, *x));
    stats.statistics()
}

/// Nearest-rank percentile at the fraction `share` of the sorted samples.
fn percentile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = share * sorted.len().saturating_sub(1) as f64;
    sorted.get(rank.round() as usize).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sine of amplitude 1 over whole periods in every block: mean 0, standard deviation 1/√2, percentile p equal to `sin(π (p − ½))`.
    #[test]
    fn exact_statistics_of_a_sine() {
        let n = 8000;
        let sine = |k: usize| (std::f64::consts::TAU * 8.0 * (k as f64 + 0.5) / n as f64).sin();
        let run: Vec<f64> = (0..n).map(sine).collect();
        let statistics = Statistics::from_runs([&run, &run]);
        assert!(statistics.mean.value.abs() < 1e-12 && statistics.mean.error < 1e-12);
        assert!((statistics.standard_deviation.value - 0.5f64.sqrt()).abs() < 1e-12);
        let [low, middle, high] = statistics.percentiles.unwrap();
        let expected = (std::f64::consts::PI * 0.49).sin();
        assert!((low.value + expected).abs() < 5e-4 && (high.value - expected).abs() < 5e-4);
        assert!(middle.value.abs() < 5e-3 && high.error < 1e-4);
    }
}
