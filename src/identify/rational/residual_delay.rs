//! Delay that a fit without a delay leaves in its residues.
//!
//! A normal mode has a receptance residue `R = a/(2jω)`, a real. A delay τ turns it to `R e^{−jωτ}`, so that the phases of `jR`, taken
//! modulo 180°, lie on a line through zero of slope −τ over the frequencies of the modes.

use super::RationalFit;
use crate::numeric::Complex;
use crate::numeric::statistics::student_t_quantile;

/// Fewer modes do not tell a delay from complex shapes.
const MIN_MODES: usize = 3;

/// Modes with a gain below this share of the strongest are left out: their residues hold the skirts of others.
const MIN_GAIN_SHARE: f64 = 0.01;

/// A delay is reported where chance shows one in a hundred fits, over all responses, …
const SIGNIFICANCE: f64 = 0.01;

/// … and it turns the highest mode by more than this, rad (1°).
const MIN_PHASE: f64 = 0.017;

/// Delays tried on either side of zero, in steps of this phase of the highest mode, rad, up to 180°.
const TRIAL_PHASE: f64 = 0.02;
const TRIALS: i32 = 157;

/// Share of the highest score that makes a delay a candidate; the shortest candidate is taken.
const TIE_SHARE: f64 = 0.85;

/// A delay left in one response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResidualDelay {
    /// Index of the response.
    pub response: usize,
    /// Delay, s; negative where the response leads.
    pub delay_s: f64,
    /// Half the 95 % interval, s.
    pub interval_s: f64,
}

/// The delays left in the responses, where they are significant; none where the fit has a delay of its own.
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
    // (ω, jR over the damping: its length is the height of the peak)
    let is_mode = |p: &Complex| {
        let near = |m: &Complex| (m - p).norm() <= 1e-6 * p.norm();
        fit.modes.iter().any(|m| near(&m.pole))
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
    let highest = peaks.iter().map(|p| p.0).fold(0.0, f64::max);
    let axis = |(w, z): &(f64, Complex), delay: f64| 2.0 * (z.arg() + w * delay);
    let score = |delay: f64| peaks.iter().map(|p| axis(p, delay).cos()).sum::<f64>();
    let trials: Vec<f64> = (0..=TRIALS)
        .flat_map(|k| [1.0, -1.0].map(|sign| sign * f64::from(k) * TRIAL_PHASE / highest))
        .collect();
    let best = trials.iter().map(|d| score(*d)).fold(0.0, f64::max);
    let mut delay = *trials.iter().find(|d| score(**d) >= TIE_SHARE * best)?;
    // Least squares of the phases about the delay, each within ±90°, repeated as phases wrap.
    let square: f64 = peaks.iter().map(|p| p.0 * p.0).sum();
    let left =
        |delay: f64, p: &(f64, Complex)| 0.5 * axis(p, delay).sin().atan2(axis(p, delay).cos());
    for _ in 0..20 {
        delay -= peaks.iter().map(|p| p.0 * left(delay, p)).sum::<f64>() / square;
    }
    let dofs = peaks.len() as f64 - 1.0;
    let variance = peaks.iter().map(|p| left(delay, p).powi(2)).sum::<f64>() / dofs;
    let deviation = (variance / square).sqrt();
    let is_significant = delay.abs()
        > student_t_quantile(1.0 - 0.5 * significance, dofs) * deviation
        && delay.abs() * highest > MIN_PHASE;
    is_significant.then(|| ResidualDelay {
        response,
        delay_s: delay,
        interval_s: student_t_quantile(0.975, dofs) * deviation,
    })
}
