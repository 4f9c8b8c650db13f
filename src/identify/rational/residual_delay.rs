//! Residual delay: the delay contained in the residues of a fit without a delay.
//!
//! A normal mode has a receptance residue `R = a/(2jω)`, a real. A delay τ changes it to `R e^{−jωτ}`, so that the phases of `jR`, modulo
//! 180°, lie on a line through the origin of slope −τ over the angular frequencies of the modes.

use super::RationalFit;
use crate::numeric::Complex;
use crate::numeric::statistics::student_t_quantile;

/// Least number of modes that distinguishes a delay from complex shapes.
const MIN_MODES: usize = 3;

/// Least gain of a mode relative to the strongest; residues of weaker modes contain the skirts of others.
const MIN_GAIN_SHARE: f64 = 0.01;

/// Significance level of a delay, over all responses of a fit.
const SIGNIFICANCE: f64 = 0.01;

/// Least phase of a reported delay at the highest mode, rad (1°).
const MIN_PHASE: f64 = 0.017;

/// Step and number of the trial delays on either side of zero, as a phase of the highest mode, rad; up to 180°.
const TRIAL_PHASE: f64 = 0.02;
const TRIALS: i32 = 157;

/// Least score of a candidate delay relative to the highest; the shortest candidate is chosen.
const TIE_SHARE: f64 = 0.85;

/// Residual delay of one response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResidualDelay {
    /// Index of the response.
    pub response: usize,
    /// Delay, s; negative where the response leads.
    pub delay_s: f64,
    /// Half the 95 % interval, s.
    pub interval_s: f64,
}

/// Significant residual delays of the responses; empty if the fit includes a delay.
pub fn residual_delays(fit: &RationalFit) -> Vec<ResidualDelay> {
    if fit.delay_s.iter().any(|d| *d != 0.0) {
        return Vec::new();
    }
    let count = fit.residues.len();
    let significance = SIGNIFICANCE / count.max(1) as f64;
    (0..count)
        .filter_map(|response| residual_delay(fit, response, significance))
        .collect()
}

fn residual_delay(fit: &RationalFit, response: usize, significance: f64) -> Option<ResidualDelay> {
    // (ω, jR divided by the decay rate: its modulus is the height of the peak)
    let is_mode = |p: &Complex| {
        let is_equal = |m: &Complex| (m - p).norm() <= 1e-6 * p.norm();
        fit.modes.iter().any(|m| is_equal(&m.pole))
    };
    let mut peaks: Vec<(f64, Complex)> = (fit.poles.iter().zip(&fit.residues[response]))
        .filter(|(p, _)| is_mode(p) && p.re != 0.0)
        .map(|(p, r)| (p.im, r * Complex::new(0.0, 1.0) / p.re.abs()))
        .collect();
    let strongest = peaks.iter().map(|p| p.1.norm()).fold(0.0, f64::max);
    peaks.retain(|p| p.1.norm() > MIN_GAIN_SHARE * strongest);
    if peaks.len() < MIN_MODES {
        return None;
    }
    let max_omega = peaks.iter().map(|p| p.0).fold(0.0, f64::max);
    let angle = |(w, z): &(f64, Complex), delay: f64| 2.0 * (z.arg() + w * delay);
    let score = |delay: f64| peaks.iter().map(|p| angle(p, delay).cos()).sum::<f64>();
    let trials: Vec<f64> = (0..=TRIALS)
        .flat_map(|k| [1.0, -1.0].map(|sign| sign * f64::from(k) * TRIAL_PHASE / max_omega))
        .collect();
    let best = trials.iter().map(|d| score(*d)).fold(0.0, f64::max);
    let mut delay = *trials.iter().find(|d| score(**d) >= TIE_SHARE * best)?;
    // Least squares of the phase errors, each within ±90°; iterated because phases wrap.
    let sum_of_squares: f64 = peaks.iter().map(|p| p.0 * p.0).sum();
    let error =
        |delay: f64, p: &(f64, Complex)| 0.5 * angle(p, delay).sin().atan2(angle(p, delay).cos());
    for _ in 0..20 {
        delay -= peaks.iter().map(|p| p.0 * error(delay, p)).sum::<f64>() / sum_of_squares;
    }
    let dofs = peaks.len() as f64 - 1.0;
    let variance = peaks.iter().map(|p| error(delay, p).powi(2)).sum::<f64>() / dofs;
    let deviation = (variance / sum_of_squares).sqrt();
    let is_significant = delay.abs()
        > student_t_quantile(1.0 - 0.5 * significance, dofs) * deviation
        && delay.abs() * max_omega > MIN_PHASE;
    is_significant.then(|| ResidualDelay {
        response,
        delay_s: delay,
        interval_s: student_t_quantile(0.975, dofs) * deviation,
    })
}
