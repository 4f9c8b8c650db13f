//! Peaks of the spectra that two modes share: the spectral matrix has as many large singular values as modes are near
//! (Brincker, Zhang & Andersen, Smart Mater. Struct. 10 (2001)), so that `s₂` peaks with `s₁`.
//!
//! Next to a single mode `s₂` is noise, or the slope of another mode: flat, or falling to one side.

use super::fdd::FddEstimate;

/// Least `s₂/s₁` of a shared peak.
const MIN_RATIO: f64 = 0.1;

/// By so much both values fall to either side, …
const MIN_FALL: f64 = 3.0;

/// … within so many half-power half-bandwidths, where a resonance has fallen to a seventeenth, and at least so many lines: those of a Hann
/// window, padded to twice its length, fall to a thousandth.
const REACH: (f64, f64) = (4.0, 6.0);

/// Distance from a mode in which its peak falls, Hz.
pub fn reach_hz(level: &FddEstimate, half_band_hz: f64) -> f64 {
    let line_hz = level.frequency_hz.get(1).copied().unwrap_or(0.0);
    (REACH.0 * half_band_hz).max(REACH.1 * line_hz)
}

/// Second over first singular value at a mode where both peak; `None` where only one does, or there is one channel.
pub fn second_mode_ratio(level: &FddEstimate, frequency_hz: f64, half_band_hz: f64) -> Option<f64> {
    let line_hz = level.frequency_hz.get(1).copied().filter(|l| *l > 0.0)?;
    let at = (frequency_hz / line_hz).round() as usize;
    // Means over the top of the peak, at least three lines.
    let half = ((0.5 * half_band_hz / line_hz) as usize).max(1);
    let reach = (reach_hz(level, half_band_hz) / line_hz) as usize;
    let (from, to) = (at.checked_sub(reach + half)?, at + reach + half);
    if to >= level.singular_values.len() {
        return None;
    }
    let values = &level.singular_values[from..=to];
    let peak_and_fall = |which: usize| {
        let all: Option<Vec<f64>> = values.iter().map(|v| v.get(which).copied()).collect();
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let means: Vec<f64> = all?.windows(2 * half + 1).map(mean).collect();
        let lowest = |side: &[f64]| side.iter().copied().fold(f64::INFINITY, f64::min);
        let valley = lowest(&means[..reach]).max(lowest(&means[reach + 1..]));
        Some((means[reach], means[reach] / valley))
    };
    let (first, second) = (peak_and_fall(0)?, peak_and_fall(1)?);
    let ratio = second.0 / first.0;
    (ratio > MIN_RATIO && first.1 >= MIN_FALL && second.1 >= MIN_FALL).then_some(ratio)
}
