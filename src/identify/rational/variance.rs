//! Variance of spectral lines where none is measured: fourth differences, then residuals.

use crate::numeric::Complex;
use crate::numeric::statistics::{chi_squared_quantile, chi_squared_sf, median};

use super::scaled_responses::ScaledResponses;

/// Lines in a window, for the median of squared differences and of squared residuals.
const WINDOW: usize = 151;

/// Squares of the binomial coefficients, by which the lines of a difference share in its noise.
const DIFFERENCE_WEIGHTS: [f64; 5] = [1.0, 16.0, 36.0, 16.0, 1.0];

/// From fourth differences: `median |Δ⁴h|² / (70 ln 2)`, the median of the exponential law being `ln 2` of its mean. Noise is taken
/// to be even along a window of lines; where noise in proportion to the response leaves the differences more alike in size, as over
/// what falls as 1/s², it is taken to be the larger of both: what a first estimate has too little would be taken for poles.
pub(super) fn from_differences(lines: &ScaledResponses) -> Vec<Vec<f64>> {
    let of_response = |i: usize| {
        let h = &lines.h[i];
        let power: Vec<f64> = h
            .windows(5)
            .map(|h| (h[0] - h[1] * 4.0 + h[2] * 6.0 - h[3] * 4.0 + h[4]).norm_sqr() / lines.fourth)
            .collect();
        let size: Vec<f64> = h
            .windows(5)
            .map(|h| {
                h.iter()
                    .zip(DIFFERENCE_WEIGHTS)
                    .map(|(h, s)| h.norm_sqr() * s)
                    .sum::<f64>()
                    / lines.fourth
            })
            .collect();
        let share: Vec<f64> = power.iter().zip(&size).map(|(p, s)| p / s).collect();
        let along = sliding_median(&power);
        let in_proportion = sliding_median(&share);
        let is_in_proportion = share.iter().all(|s| s.is_finite())
            && is_proportional_noise(&in_proportion)
            && median_log_ratio(&share, &in_proportion) < median_log_ratio(&power, &along);
        let at = |k: usize| k.saturating_sub(2).min(power.len() - 1);
        (0..h.len())
            .map(|k| {
                let other = match is_in_proportion {
                    true => in_proportion[at(k)] * h[k].norm_sqr(),
                    false => 0.0,
                };
                along[at(k)].max(other).max(lines.variance_floor(i, k))
            })
            .collect()
    };
    (0..lines.h.len()).map(of_response).collect()
}

/// Noise in proportion to the response is distinguishable from even noise where it is below this share of the power on most lines: a
/// response below its noise is its noise, and that is in proportion to itself.
fn is_proportional_noise(shares: &[f64]) -> bool {
    const MAX_BELOW_NOISE_SHARE: f64 = 0.1;
    2 * shares
        .iter()
        .filter(|s| **s < MAX_BELOW_NOISE_SHARE)
        .count()
        > shares.len()
}

/// The median of `|ln p/v|` about its own median: how unlike powers are, each over what is expected of it, some lines left aside.
fn median_log_ratio(power: &[f64], expected: &[f64]) -> f64 {
    let of = |(p, v): (&f64, &f64)| (p.max(f64::MIN_POSITIVE) / v.max(f64::MIN_POSITIVE)).ln();
    let mut logs: Vec<f64> = power.iter().zip(expected).map(of).collect();
    let centre = median(&mut logs).unwrap_or(0.0);
    logs.iter_mut().for_each(|l| *l = (*l - centre).abs());
    median(&mut logs).unwrap_or(0.0)
}

/// From residuals `e` of the scaled responses, of which a share `freedom` of the data is left: noise along the axis, or noise in
/// proportion to the response, as rounding of what was written is; whichever makes the residuals likelier.
pub(super) fn from_residuals(
    lines: &ScaledResponses,
    residual: &[Vec<Complex>],
    dof: f64,
) -> Vec<Vec<f64>> {
    let of_response = |(i, e): (usize, &Vec<Complex>)| {
        let power: Vec<f64> = e.iter().map(|z| z.norm_sqr() / dof).collect();
        let floored = |profile: Vec<f64>| -> Vec<f64> {
            let floor = |(k, v): (usize, f64)| v.max(lines.variance_floor(i, k));
            profile.into_iter().enumerate().map(floor).collect()
        };
        let along = floored(variance_profile(&power));
        let size: Vec<f64> = lines.h[i].iter().map(|h| h.norm_sqr()).collect();
        let share: Vec<f64> = power.iter().zip(&size).map(|(p, s)| p / s).collect();
        if share.iter().any(|s| !s.is_finite()) {
            return along;
        }
        let shares = variance_profile(&share);
        if !is_proportional_noise(&shares) {
            return along;
        }
        let in_proportion = floored(shares.iter().zip(&size).map(|(r, s)| r * s).collect());
        match negative_log_likelihood(&power, &in_proportion)
            < negative_log_likelihood(&power, &along)
        {
            true => in_proportion,
            false => along,
        }
    };
    residual.iter().enumerate().map(of_response).collect()
}

/// Constant where blocks of lines do not disagree, else a sliding median.
fn variance_profile(power: &[f64]) -> Vec<f64> {
    match is_constant(power) {
        true => vec![power.iter().sum::<f64>() / power.len() as f64; power.len()],
        false => sliding_median(power),
    }
}

/// `Σ ln v + p/v`: the negative logarithm of the likelihood of complex normal residuals of power p and variance v.
fn negative_log_likelihood(power: &[f64], variance: &[f64]) -> f64 {
    let term = |(p, v): (&f64, &f64)| v.ln() + p / v;
    power.iter().zip(variance).map(term).sum()
}

/// Blocks of lines the power is compared in, and the probability under which it is taken to vary.
const BLOCKS: usize = 20;
const VARIATION_PROBABILITY: f64 = 1e-3;

/// Whether the power of the lines is the same all along, by the χ² of its block means.
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
            let own = block.iter().sum::<f64>() / size as f64;
            (own / mean - 1.0).powi(2) * size as f64
        })
        .sum();
    chi_squared_sf(statistic, BLOCKS as f64 - 1.0) > VARIATION_PROBABILITY
}

/// Median over a sliding window, over that of the χ² law of two degrees of freedom per unit of mean. Evaluated on every eighth
/// of a window and joined by straight lines.
fn sliding_median(power: &[f64]) -> Vec<f64> {
    let n = power.len();
    let half = WINDOW / 2;
    let law = chi_squared_quantile(0.5, 2.0) / 2.0;
    let stride = (WINDOW / 8).min(n.max(1));
    let mut work = Vec::with_capacity(WINDOW);
    let knots: Vec<(usize, f64)> = (0..n)
        .step_by(stride)
        .chain([n.saturating_sub(1)])
        .map(|at| {
            // a window of full width that does not reach beyond the ends
            let from = at.saturating_sub(half).min(n.saturating_sub(WINDOW));
            work.clear();
            work.extend_from_slice(&power[from..(from + WINDOW).min(n)]);
            (at, median(&mut work).unwrap_or(0.0) / law)
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

/// Geometric mean of the ratio of two variances.
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
