//! Peaks of an averaged spectral density that are significant against noise, by prominence.
//!
//! A density of n averages is distributed as χ² of 2n degrees of freedom; its mean over neighbouring lines has as many times
//! the degrees of freedom as these are independent. Of N places the highest is above all but one in N, and the lowest below.

use std::ops::Range;

use crate::numeric::statistics::chi_squared_quantile;

/// Probability that a flat density shows a peak, by width.
const FALSE_ALARM: f64 = 0.01;

/// Least prominence: a peak exceeds its neighbourhood by half of its own power.
const MIN_PROMINENCE: f64 = 2.0;

/// Lines that hold as much noise as one independent line: Hann's window has a bandwidth of one and a half lines, and lines are padded to
/// half their distance.
const LINES_PER_INDEPENDENT: f64 = 3.0;

/// Means over more than this share of the lines are no neighbourhood.
const MAX_WIDTH_SHARE: f64 = 1.0 / 16.0;

/// Line and prominence of a peak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProminentPeak {
    /// The highest line of it.
    pub line: usize,
    /// Density over that of the higher adjacent valley, both means over the width of the peak.
    pub prominence: f64,
}

/// Peaks among the lines `inside`, rising, of a density with `freedoms` of χ² on each line. The narrowest width in which a peak stands
/// out counts.
pub fn significant_peaks(density: &[f64], inside: Range<usize>, dofs: f64) -> Vec<ProminentPeak> {
    let mut result: Vec<ProminentPeak> = Vec::new();
    let mut half = 0;
    loop {
        let width = 2 * half + 1;
        if half > 0 && width as f64 > MAX_WIDTH_SHARE * inside.len() as f64 {
            break;
        }
        let mean = moving_means(density, half);
        let needed = required_ratio(inside.len(), width, dofs);
        let mut new = Vec::new();
        for k in inside.clone().filter(|&k| k > 0 && k + 1 < mean.len()) {
            if !(mean[k] > mean[k - 1] && mean[k] >= mean[k + 1]) {
                continue;
            }
            let prominence = prominence(&mean, k);
            if prominence < needed
                || result
                    .iter()
                    .any(|f| is_same_peak(&mean, k, f.line, needed))
            {
                continue;
            }
            let line = highest(
                density,
                k.saturating_sub(half)..(k + half + 1).min(density.len()),
            );
            // The summit of a slope's end lies on the slope.
            if line > 0 && line + 1 < density.len() && inside.contains(&line) {
                new.push(ProminentPeak { line, prominence });
            }
        }
        result.extend(new);
        half = (2 * half).max(1);
    }
    result.sort_by_key(|f| f.line);
    result.dedup_by_key(|f| f.line);
    result
}

/// Whether no valley that noise does not make lies between a peak and another.
fn is_same_peak(mean: &[f64], peak: usize, other: usize, needed: f64) -> bool {
    let between = &mean[peak.min(other)..=peak.max(other)];
    between.iter().all(|x| *x * needed > mean[peak])
}

/// The highest over the lowest of `lines` means over `width` lines of an even density.
fn required_ratio(lines: usize, width: usize, dofs: f64) -> f64 {
    let independent = (width as f64 / LINES_PER_INDEPENDENT).max(1.0);
    let places = (lines as f64 / LINES_PER_INDEPENDENT / independent).max(1.0);
    let (chance, dofs) = (FALSE_ALARM / places, dofs * independent);
    let ratio = chi_squared_quantile(1.0 - chance, dofs) / chi_squared_quantile(chance, dofs);
    ratio.max(MIN_PROMINENCE)
}

/// Running means over `2 half + 1` lines, fewer at the ends.
fn moving_means(density: &[f64], half: usize) -> Vec<f64> {
    let mut sums = Vec::with_capacity(density.len() + 1);
    let mut sum = 0.0;
    sums.push(sum);
    for x in density {
        sum += x;
        sums.push(sum);
    }
    let one = |k: usize| {
        let (from, to) = (k.saturating_sub(half), (k + half + 1).min(density.len()));
        (sums[to] - sums[from]) / (to - from) as f64
    };
    match half {
        0 => density.to_vec(),
        _ => (0..density.len()).map(one).collect(),
    }
}

/// The peak over the higher of its valleys, each the lowest line on the way to a higher peak.
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

fn highest(density: &[f64], lines: Range<usize>) -> usize {
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

    /// An even density of so many averages, with some resonances: place, half width, height.
    fn density(seed: u64, peaks: &[(f64, f64, f64)]) -> Vec<f64> {
        let mut random = fastrand::Rng::with_seed(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let line = |k: usize| {
            let own: f64 = (0..AVERAGES).map(|_| -random.f64().max(1e-300).ln()).sum();
            let height = |&(at, half, height): &(f64, f64, f64)| {
                height / (1.0 + ((k as f64 - at) / half).powi(2))
            };
            own / AVERAGES as f64 * (1.0 + peaks.iter().map(height).sum::<f64>())
        };
        (0..3000).map(line).collect()
    }

    /// Noise has a peak as seldom as promised.
    #[test]
    fn law_noise_has_no_peaks() {
        let with = |&seed: &u64| {
            !significant_peaks(&density(seed, &[]), 4..2990, 2.0 * AVERAGES as f64).is_empty()
        };
        let count = (0..40).filter(with).count();
        assert!(count <= 2, "{count} of 40");
    }

    /// Narrow, wide and low resonances, each found once and where they are.
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
