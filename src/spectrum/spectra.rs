//! Averaged auto and cross spectra, one-sided: `S_xx` in unit²/Hz, `S_xy = E[X* Y]`, with random error.
//!
//! Bendat & Piersol, Random Data, 4th ed. (2010), sections 8.5 and 9.2.

use super::window::Window;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::statistics::chi_squared_quantile;

/// Auto and cross spectra of some channels.
#[derive(Debug, Clone, Default)]
pub struct Spectra {
    /// Samples a second of the signals, Hz.
    pub rate_hz: f64,
    /// Lines, Hz, from 0.
    pub frequency_hz: Vec<f64>,
    /// One-sided power spectral density of every channel, unit²/Hz.
    pub psd: Vec<Vec<f64>>,
    /// Cross spectra of the requested pairs.
    pub cross: Vec<CrossSpectrum>,
    /// Equivalent noise bandwidth, Hz: a tone of rms `a` has a density of `a²/bandwidth` at its line.
    pub bandwidth_hz: f64,
    /// Number of blocks (or tapers) averaged.
    pub blocks: usize,
    /// Number of independent blocks with the same random error; `None` where a maximum was kept instead of a mean.
    pub averages: Option<f64>,
    /// Rate σ of an exponential window `exp(−σt)` on the blocks, 1/s; 0 without one.
    pub window_decay: f64,
    /// The window on the blocks, where there was one: it says what a tone between two lines looks like.
    pub window: Option<Window>,
}

/// A one-sided cross spectral density.
#[derive(Debug, Clone)]
pub struct CrossSpectrum {
    /// Channels x and y.
    pub pair: (usize, usize),
    /// `E[X* Y]`: unit of x times unit of y over Hz.
    pub values: Vec<Complex>,
}

/// The mean of a channel.
///
/// # Errors
/// `Overflow` where a sample is not finite, or their sum.
pub(super) fn mean(channel: &[f64]) -> Result<f64, Error> {
    let mean = channel.iter().sum::<f64>() / channel.len() as f64;
    if !mean.is_finite() {
        return Err(Error::new(
            Code::Overflow,
            "a sample is not a number, or their sum is too large",
        ));
    }
    Ok(mean)
}

impl Spectra {
    /// The cross spectrum from channel `x` to channel `y`, whichever way round it is held; `None` where it was not requested.
    pub fn cross(&self, x: usize, y: usize) -> Option<Vec<Complex>> {
        if x == y {
            let real = |&s: &f64| Complex::new(s, 0.0);
            return self.psd.get(x).map(|psd| psd.iter().map(real).collect());
        }
        self.cross.iter().find_map(|c| {
            if c.pair == (x, y) {
                Some(c.values.clone())
            } else if c.pair == (y, x) {
                Some(c.values.iter().map(|z| z.conj()).collect())
            } else {
                None
            }
        })
    }

    /// Ordinary coherence `|S_xy|²/(S_xx S_yy)`; 0 where either channel has no power. `None` where the pair was not asked for.
    pub fn coherence(&self, x: usize, y: usize) -> Option<Vec<f64>> {
        let cross = self.cross(x, y)?;
        let lines = cross.iter().zip(&self.psd[x]).zip(&self.psd[y]);
        Some(lines.map(|((c, &a), &b)| coherence(a, *c, b)).collect())
    }

    /// Amplitude (0 to peak) of the tone at each line of a channel, in its unit; the mean value at 0 Hz.
    pub fn amplitude(&self, channel: usize) -> Vec<f64> {
        let factor = |line| if self.is_real_line(line) { 1.0 } else { 2.0 };
        let line = |(k, s): (usize, &f64)| (factor(k) * s * self.bandwidth_hz).sqrt();
        self.psd[channel].iter().enumerate().map(line).collect()
    }

    /// Root mean square of the tone at each line of a channel, in its unit.
    pub fn rms(&self, channel: usize) -> Vec<f64> {
        let line = |s: &f64| (s * self.bandwidth_hz).sqrt();
        self.psd[channel].iter().map(line).collect()
    }

    /// χ² degrees of freedom of a density: two for each independent average, one at 0 Hz and at half the rate, where transforms
    /// are real.
    pub fn dof(&self, line: usize) -> Option<f64> {
        let each = if self.is_real_line(line) { 1.0 } else { 2.0 };
        self.averages.map(|n| each * n)
    }

    /// Between which multiples of a density the true one of a random signal lies with probability `confidence`: `ν/χ²_{½±½p}(ν)`.
    pub fn confidence_factors(&self, line: usize, confidence: f64) -> Option<(f64, f64)> {
        let dofs = self.dof(line)?;
        let bound = |p: f64| dofs / chi_squared_quantile(p, dofs);
        Some((bound(0.5 + 0.5 * confidence), bound(0.5 - 0.5 * confidence)))
    }

    /// Whether the transform is real at a line: 0 Hz, and half the rate where a line falls on it.
    pub fn is_real_line(&self, line: usize) -> bool {
        let f = self.frequency_hz[line];
        f == 0.0 || f == 0.5 * self.rate_hz
    }
}

/// `|S_xy|²/(S_xx S_yy)` without leaving the number range, and not above 1 by rounding.
pub(super) fn coherence(sxx: f64, sxy: Complex, syy: f64) -> f64 {
    if sxx > 0.0 && syy > 0.0 {
        (sxy.norm() / sxx.sqrt() / syy.sqrt()).powi(2).min(1.0)
    } else {
        0.0
    }
}
