//! Variance of spectral lines without a measured variance, from fourth differences, then from residuals.

use crate::numeric::Complex;
use crate::numeric::statistics::{chi_squared_quantile, chi_squared_sf, median};

use super::scaled_responses::ScaledResponses;

/// Number of lines in the window of the sliding median.
const WINDOW: usize = 151;

/// Squared binomial coefficients: the shares of the five lines in the noise of a fourth difference.
const DIFFERENCE_WEIGHTS: [f64; 5] = [1.0, 16.0, 36.0, 16.0, 1.0];

/// Variance by response and line from fourth differences: `median |Δ⁴h|² / (70 ln 2)`; the median of an exponential distribution is `ln 2`
/// of its mean. Noise is assumed constant over a window; if noise proportional to the response fits the differences better, as over a 1/s²
/// slope, the larger of both is used, because an underestimated variance produces spurious poles.
pub(super) fn from_differences(lines: &ScaledResponses) -> Vec<Vec<f64>> {
    let response_variance = |i: usize| {
        let h = &lines.h[i];
        let power: Vec<f64> = h
            .windows(5)
            .map(|h| {
                (h[0] - h[1] * 4.0 + h[2] * 6.0 - h[3] * 4.0 + h[4]).norm_sqr()
                    / lines.fourth_difference_gain
            })
            .collect();
        let size: Vec<f64> = h
            .windows(5)
            .map(|h| {
                h.iter()
                    .zip(DIFFERENCE_WEIGHTS)
                    .map(|(h, s)| h.norm_sqr() * s)
                    .sum::<f64>()
                    / lines.fourth_difference_gain
            })
            .collect();
        let share: Vec<f64> = power.iter().zip(&size).map(|(p, s)| p / s).collect();
        let constant = sliding_median(&power);
        let proportional = sliding_median(&share);
        let is_proportional = share.iter().all(|s| s.is_finite())
            && is_proportional_noise(&proportional)
            && median_log_ratio(&share, &proportional) < median_log_ratio(&power, &constant);
        let at = |k: usize| k.saturating_sub(2).min(power.len() - 1);
        (0..h.len())
            .map(|k| {
                let scaled = match is_proportional {
                    true => proportional[at(k)] * h[k].norm_sqr(),
                    false => 0.0,
                };
                constant[at(k)].max(scaled).max(lines.variance_floor(i, k))
            })
            .collect()
    };
    (0..lines.h.len()).map(response_variance).collect()
}

/// Returns `true` if proportional noise is distinguishable from constant noise: its share of the power is small on most lines. A response
/// below the noise is itself noise and proportional to itself.
fn is_proportional_noise(shares: &[f64]) -> bool {
    const MAX_BELOW_NOISE_SHARE: f64 = 0.1;
    2 * shares
        .iter()
        .filter(|s| **s < MAX_BELOW_NOISE_SHARE)
        .count()
        > shares.len()
}

/// Median absolute deviation of `ln p/v`: the spread of powers relative to their expected values, robust against outliers.
fn median_log_ratio(power: &[f64], expected: &[f64]) -> f64 {
    let log = |(p, v): (&f64, &f64)| (p.max(f64::MIN_POSITIVE) / v.max(f64::MIN_POSITIVE)).ln();
    let mut logs: Vec<f64> = power.iter().zip(expected).map(log).collect();
    let centre = median(&mut logs).unwrap_or(0.0);
    logs.iter_mut().for_each(|l| *l = (*l - centre).abs());
    median(&mut logs).unwrap_or(0.0)
}

/// Variance by response and line from residuals of the scaled responses; `dof` is the degrees of freedom per real value, 0 to 1. Of noise
/// smooth in frequency and noise proportional to the response (rounding of a file), the one of larger likelihood is used.
pub(super) fn from_residuals(
    lines: &ScaledResponses,
    residual: &[Vec<Complex>],
    dof: f64,
) -> Vec<Vec<f64>> {
    let response_variance = |(i, e): (usize, &Vec<Complex>)| {
        let power: Vec<f64> = e.iter().map(|z| z.norm_sqr() / dof).collect();
        let apply_floor = |profile: Vec<f64>| -> Vec<f64> {
            let floor = |(k, v): (usize, f64)| v.max(lines.variance_floor(i, k));
            profile.into_iter().enumerate().map(floor).collect()
        };
        let constant = apply_floor(variance_profile(&power));
        let size: Vec<f64> = lines.h[i].iter().map(|h| h.norm_sqr()).collect();
        let share: Vec<f64> = power.iter().zip(&size).map(|(p, s)| p / s).collect();
        if share.iter().any(|s| !s.is_finite()) {
            return constant;
        }
        let shares = variance_profile(&share);
        if !is_proportional_noise(&shares) {
            return constant;
        }
        let proportional = apply_floor(shares.iter().zip(&size).map(|(r, s)| r * s).collect());
        match negative_log_likelihood(&power, &proportional)
            < negative_log_likelihood(&power, &constant)
        {
            true => proportional,
            false => constant,
        }
    };
    residual.iter().enumerate().map(response_variance).collect()
}

/// Variance along the lines: constant if blocks of lines agree, else a sliding median.
fn variance_profile(power: &[f64]) -> Vec<f64> {
    match is_constant(power) {
        true => vec![power.iter().sum::<f64>() / power.len() as f64; power.len()],
        false => sliding_median(power),
    }
}

/// `Σ ln v + p/v` for complex normal residuals of power p and variance v.
fn negative_log_likelihood(power: &[f64], variance: &[f64]) -> f64 {
    let term = |(p, v): (&f64, &f64)| v.ln() + p / v;
    power.iter().zip(variance).map(term).sum()
}

/// Number of blocks of the test for constant power, and its significance level.
const BLOCKS: usize = 20;
const VARIATION_PROBABILITY: f64 = 1e-3;

/// Returns `true` if the power is constant over the lines, by a χ² test of its block means.
fn is_constant(power: &[f64]) -> bool {
    let size = power.len() / BLOCKS;
    if size < 4 {
        return true;
    }
    let mean = power.iter().sum::<f64>() / power.len() as f64;
    if mean == 0.0 {
        return true;
    }
    let statistic: f64 = power
        .chunks_exact(size)
        .take(BLOCKS)
        .map(|block| {
            let block_mean = block.iter().sum::<f64>() / size as f64;
            (block_mean / mean - 1.0).powi(2) * size as f64
        })
        .sum();
    chi_squared_sf(statistic, BLOCKS as f64 - 1.0) > VARIATION_PROBABILITY
}

/// Sliding median divided by the median-to-mean ratio of χ² of two degrees of freedom; evaluated at every eighth of a window and
/// interpolated linearly.
fn sliding_median(power: &[f64]) -> Vec<f64> {
    let n = power.len();
    let half_width = WINDOW / 2;
    let median_ratio = chi_squared_quantile(0.5, 2.0) / 2.0;
    let stride = (WINDOW / 8).min(n.max(1));
    let mut window = Vec::with_capacity(WINDOW);
    let knots: Vec<(usize, f64)> = (0..n)
        .step_by(stride)
        .chain([n.saturating_sub(1)])
        .map(|at| {
            // The window keeps its full width at the ends.
            let from = at.saturating_sub(half_width).min(n.saturating_sub(WINDOW));
            window.clear();
            window.extend_from_slice(&power[from..(from + WINDOW).min(n)]);
            (at, median(&mut window).unwrap_or(0.0) / median_ratio)
        })
        .collect();
    let mut knot = 0;
    (0..n)
        .map(|k| {
            while knot + 2 < knots.len() && knots[knot + 1].0 < k {
                knot += 1;
            }
            let ((a, va), (b, vb)) = (knots[knot], knots[(knot + 1).min(knots.len() - 1)]);
            if a == b {
                return va;
            }
            let t = ((k as f64 - a as f64) / (b as f64 - a as f64)).clamp(0.0, 1.0);
            va + (vb - va) * t
        })
        .collect()
}

/// Geometric mean of the ratio of two variances over all responses and lines.
pub(super) fn mean_ratio(new: &[Vec<f64>], old: &[Vec<f64>]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (n, o) in new.iter().zip(old) {
        for (n, o) in n.iter().zip(o) {
            sum += (n / o).ln();
            count += 1.0;
        }
    }
    (sum / count).exp()
}
