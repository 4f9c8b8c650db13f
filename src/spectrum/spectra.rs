//! One-sided averaged auto and cross spectra: `S_xx` in unit²/Hz, `S_xy = E[X* Y]`, with random error.
//!
//! Bendat & Piersol, Random Data, 4th ed. (2010), sections 8.5 and 9.2.

use super::window::Window;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::statistics::chi_squared_quantile;

/// Auto and cross spectra of several channels.
#[derive(Debug, Clone, Default)]
pub struct Spectra {
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Frequencies of the spectral lines, Hz, from 0.
    pub frequency_hz: Vec<f64>,
    /// One-sided power spectral density of every channel, unit²/Hz.
    pub psd: Vec<Vec<f64>>,
    /// Cross spectra of the requested pairs.
    pub cross: Vec<CrossSpectrum>,
    /// Equivalent noise bandwidth, Hz: a tone of rms `a` has a density of `a²/bandwidth` at its line.
    pub bandwidth_hz: f64,
    /// Number of blocks (or tapers) averaged.
    pub blocks: usize,
    /// Equivalent number of independent blocks; `None` for a maximum (peak hold) instead of a mean.
    pub averages: Option<f64>,
    /// Decay rate σ of an exponential window `exp(−σt)` on the blocks, 1/s; 0 without such a window.
    pub window_decay: f64,
    /// Window on the blocks, if any: determines the leakage of a tone between two lines.
    pub window: Option<Window>,
}

/// A one-sided cross spectral density.
#[derive(Debug, Clone)]
pub struct CrossSpectrum {
    /// Indices of the channels x and y.
    pub pair: (usize, usize),
    /// `E[X* Y]`: unit of x times unit of y over Hz.
    pub values: Vec<Complex>,
}

/// Mean of a channel.
///
/// # Errors
/// `Overflow` if a sample or the sum is not finite.
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
    /// Cross spectrum from channel `x` to channel `y`, stored in either order; `None` if it was not requested.
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

    /// Ordinary coherence `|S_xy|²/(S_xx S_yy)`; 0 if a channel has no power; `None` if the pair was not requested.
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
        let per_average = if self.is_real_line(line) { 1.0 } else { 2.0 };
        self.averages.map(|n| per_average * n)
    }

    /// Confidence limits of the true density of a random signal as factors on the estimate: `ν/χ²_{½±½p}(ν)`, p = `confidence`.
    pub fn confidence_factors(&self, line: usize, confidence: f64) -> Option<(f64, f64)> {
        let nu = self.dof(line)?;
        let bound = |p: f64| nu / chi_squared_quantile(p, nu);
        Some((bound(0.5 + 0.5 * confidence), bound(0.5 - 0.5 * confidence)))
    }

    /// Whether the transform is real at a line: at 0 Hz, and at half the rate if a line coincides with it.
    pub fn is_real_line(&self, line: usize) -> bool {
        let f = self.frequency_hz[line];
        f == 0.0 || f == 0.5 * self.rate_hz
    }
}

/// Coherence `|S_xy|²/(S_xx S_yy)` without overflow, limited to 1 against rounding.
pub(super) fn coherence(sxx: f64, sxy: Complex, syy: f64) -> f64 {
    if sxx > 0.0 && syy > 0.0 {
        (sxy.norm() / sxx.sqrt() / syy.sqrt()).powi(2).min(1.0)
    } else {
        0.0
    }
}
