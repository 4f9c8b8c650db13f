//! Peaks of an averaged spectral density that are significant against noise, by prominence.
//!
//! A density of n averages is distributed as χ² of 2n degrees of freedom; the mean over m
//! independent lines has 2nm. The highest and lowest of N independent means are estimated by the quantiles 1 − 1/N and 1/N.

use std::ops::Range;

use crate::numeric::statistics::chi_squared_quantile;

/// Probability of a false peak in a flat density, for each smoothing width.
const FALSE_ALARM: f64 = 0.01;

/// Least prominence (a ratio of densities) of a peak.
const MIN_PROMINENCE: f64 = 2.0;

/// Number of lines equivalent to one independent line: the noise bandwidth of the Hann window is 1.5 lines, and zero padding halves the
/// line spacing.
const LINES_PER_INDEPENDENT: f64 = 3.0;

/// Largest smoothing width, as a share of the lines.
const MAX_WIDTH_SHARE: f64 = 1.0 / 16.0;

/// Significant peak of a spectral density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProminentPeak {
    /// Index of the line of largest density.
    pub line: usize,
    /// Ratio of the density to that of the higher adjacent valley, both averaged over the width of the peak.
    pub prominence: f64,
}

/// Peaks of a spectral density among the lines `band`, by increasing line; each line is distributed as χ² of `dofs` degrees of freedom.
/// The narrowest smoothing width in which a peak is significant determines its prominence.
pub fn significant_peaks(density: &[f64], band: Range<usize>, dofs: f64) -> Vec<ProminentPeak> {
    let mut result: Vec<ProminentPeak> = Vec::new();
    let mut half_width = 0;
    loop {
        let width = 2 * half_width + 1;
        if half_width > 0 && width as f64 > MAX_WIDTH_SHARE * band.len() as f64 {
            break;
        }
        let means = moving_means(density, half_width);
        let min_ratio = required_ratio(band.len(), width, dofs);
        let mut new_peaks = Vec::new();
        for k in band.clone().filter(|&k| k > 0 && k + 1 < means.len()) {
            if !(means[k] > means[k - 1] && means[k] >= means[k + 1]) {
                continue;
            }
            let prominence = prominence(&means, k);
            if prominence < min_ratio
                || result
                    .iter()
                    .any(|f| is_same_peak(&means, k, f.line, min_ratio))
            {
                continue;
            }
            let line = highest_line(
                density,
                k.saturating_sub(half_width)..(k + half_width + 1).min(density.len()),
            );
            // A maximum at the end of the density is the end of a slope, not a peak.
            if line > 0 && line + 1 < density.len() && band.contains(&line) {
                new_peaks.push(ProminentPeak { line, prominence });
            }
        }
        result.extend(new_peaks);
        half_width = (2 * half_width).max(1);
    }
    result.sort_by_key(|f| f.line);
    result.dedup_by_key(|f| f.line);
    result
}

/// Returns `true` if no significant valley separates two peaks.
fn is_same_peak(mean: &[f64], peak: usize, other: usize, min_ratio: f64) -> bool {
    let segment = &mean[peak.min(other)..=peak.max(other)];
    segment.iter().all(|x| *x * min_ratio > mean[peak])
}

/// Ratio of the highest to the lowest of `lines` moving means over `width` lines that noise of a flat density explains.
fn required_ratio(lines: usize, width: usize, dofs: f64) -> f64 {
    let independent_lines = (width as f64 / LINES_PER_INDEPENDENT).max(1.0);
    let n_independent = (lines as f64 / LINES_PER_INDEPENDENT / independent_lines).max(1.0);
    let (p, dofs) = (FALSE_ALARM / n_independent, dofs * independent_lines);
    let ratio = chi_squared_quantile(1.0 - p, dofs) / chi_squared_quantile(p, dofs);
    ratio.max(MIN_PROMINENCE)
}

/// Moving means over `2 h + 1` lines, fewer at the ends.
fn moving_means(density: &[f64], h: usize) -> Vec<f64> {
    let mut sums = Vec::with_capacity(density.len() + 1);
    let mut sum = 0.0;
    sums.push(sum);
    for x in density {
        sum += x;
        sums.push(sum);
    }
    let mean = |k: usize| {
        let (from, to) = (k.saturating_sub(h), (k + h + 1).min(density.len()));
        (sums[to] - sums[from]) / (to - from) as f64
    };
    match h {
        0 => density.to_vec(),
        _ => (0..density.len()).map(mean).collect(),
    }
}

/// Ratio of a peak to the higher of its two valleys, each the minimum between the peak and the next higher line.
fn prominence(density: &[f64], line: usize) -> f64 {
    let valley = |lines: &mut dyn Iterator<Item = usize>| {
        let mut lowest = density[line];
        for k in lines {
            if density[k] > density[line] {
                break;
            }
            lowest = lowest.min(density[k]);
        }
        lowest
    };
    let left = valley(&mut (0..line).rev());
    let right = valley(&mut (line + 1..density.len()));
    density[line] / left.max(right)
}

fn highest_line(density: &[f64], lines: Range<usize>) -> usize {
    let first = lines.start;
    lines.fold(
        first,
        |best, k| if density[k] > density[best] { k } else { best },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const AVERAGES: usize = 20;

    /// Density of `AVERAGES` averages: flat noise with resonances given by line, half-width (lines) and height.
    fn density(seed: u64, peaks: &[(f64, f64, f64)]) -> Vec<f64> {
        let mut random = fastrand::Rng::with_seed(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let line = |k: usize| {
            let noise: f64 = (0..AVERAGES).map(|_| -random.f64().max(1e-300).ln()).sum();
            let height = |&(peak_line, half_width, height): &(f64, f64, f64)| {
                height / (1.0 + ((k as f64 - peak_line) / half_width).powi(2))
            };
            noise / AVERAGES as f64 * (1.0 + peaks.iter().map(height).sum::<f64>())
        };
        (0..3000).map(line).collect()
    }

    /// The rate of false peaks in noise does not exceed `FALSE_ALARM`.
    #[test]
    fn law_noise_has_no_peaks() {
        let has_peaks = |&seed: &u64| {
            !significant_peaks(&density(seed, &[]), 4..2990, 2.0 * AVERAGES as f64).is_empty()
        };
        let count = (0..40).filter(has_peaks).count();
        assert!(count <= 2, "{count} of 40");
    }

    /// Narrow, wide and low resonances are each detected once, at their own line.
    #[test]
    fn law_resonances_of_every_width() {
        let peaks = [
            (400.0, 3.0, 60.0),
            (430.0, 3.0, 30.0),
            (1200.0, 20.0, 6.0),
            (2300.0, 80.0, 5.0),
        ];
        for seed in 100..120 {
            let result = significant_peaks(&density(seed, &peaks), 4..2990, 2.0 * AVERAGES as f64);
            assert_eq!(result.len(), peaks.len(), "{seed}: {result:?}");
            for (result, (at, half, _)) in result.iter().zip(peaks) {
                assert!(
                    (result.line as f64 - at).abs() < 1.5 * half,
                    "{seed}: {result:?}"
                );
            }
        }
    }
}
