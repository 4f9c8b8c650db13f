//! Noise spectrum of the residual: noise level at each order, significant lines.
//!
//! With a Hann window `E|R_k|² = S(o) Σw²`, where S is the variance of a sample of white noise with the spectral density at o.

use super::orders::CandidateOrder;
use crate::numeric::Complex;
use crate::numeric::fft::{RealFft, prev_fast_len};

/// Number of spectral lines for the noise level of an order, which give the standard deviation to about 10 %.
const NOISE_LINES: usize = 48;

/// Half-width of the main lobe that a subtracted order occupies with the Hann window, lines.
const MASKED_LINES: f64 = 1.5;

/// Independent lines per spectral line with the Hann window: 19/36, since neighbouring lines correlate (Welch 1967).
const INDEPENDENCE: f64 = 0.53;

/// Noise level near an order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseLevel {
    /// Variance S, squared unit of the samples.
    pub variance: f64,
    /// Degrees of freedom of the estimate of S.
    pub dof: f64,
}

/// Spectrum of a residual with a Hann window.
#[derive(Debug, Clone)]
pub struct ResidualSpectrum {
    /// Line spacing, orders.
    spacing: f64,
    /// `|R_k|²/Σw²`.
    power: Vec<f64>,
    /// Lines that contain noise only.
    is_noise: Vec<bool>,
    /// Squared amplitude per unit of power, `4 Σw²/(Σw)²`.
    amplitude_factor: f64,
}

impl ResidualSpectrum {
    /// Spectrum of residual samples, `per_turn` per revolution, up to the order `band`; the lines of the orders `fitted` are masked.
    pub fn new(
        values: &[f64],
        per_turn: usize,
        fitted: &[CandidateOrder],
        band: f64,
    ) -> ResidualSpectrum {
        // The transform length is reduced to a fast one.
        let n = prev_fast_len(values.len());
        let mut fft = RealFft::new(n);
        let mut block = values[..n].to_vec();
        let mut lines = vec![Complex::ZERO; fft.lines()];
        fft.forward(&mut block, &mut lines);
        // Hann window, applied after the transform: X_k/2 − (X_{k−1} + X_{k+1})/4; Σw = n/2, Σw² = 3n/8.
        let line = |k: usize| match k < lines.len() {
            true => lines[k],
            false => lines[n - k].conj(),
        };
        let windowed = |k: usize| {
            let previous = if k == 0 { line(1).conj() } else { line(k - 1) };
            line(k) * 0.5 - (previous + line(k + 1)) * 0.25
        };
        let (sum, squares) = (0.5 * n as f64, 0.375 * n as f64);
        let spacing = per_turn as f64 / n as f64;
        let n_lines = ((band / spacing) as usize + 1).min(lines.len());
        let power: Vec<f64> = (0..n_lines)
            .map(|k| windowed(k).norm_sqr() / squares)
            .collect();
        let mut is_noise = vec![true; n_lines];
        let mut mask = |order: f64| {
            let position = order / spacing;
            let low = (position - MASKED_LINES).ceil().max(0.0) as usize;
            let high = ((position + MASKED_LINES).floor().max(0.0) as usize + 1).min(n_lines);
            is_noise[low.min(high)..high].fill(false);
        };
        mask(0.0);
        fitted.iter().for_each(|o| mask(o.value));
        ResidualSpectrum {
            spacing,
            power,
            is_noise,
            amplitude_factor: 4.0 * squares / (sum * sum),
        }
    }

    /// Noise level near an order, from the nearest noise lines; `None` if there is none.
    pub fn noise_level(&self, order: f64) -> Option<NoiseLevel> {
        let position = order / self.spacing;
        let start = (position.round() as usize).min(self.power.len());
        let (mut low, mut high) = (start, start);
        let (mut sum, mut count) = (0.0, 0);
        while count < NOISE_LINES && (low > 0 || high < self.power.len()) {
            let down = if low > 0 {
                position - (low - 1) as f64
            } else {
                f64::INFINITY
            };
            let up = if high < self.power.len() {
                high as f64 - position
            } else {
                f64::INFINITY
            };
            let k = if down <= up {
                low -= 1;
                low
            } else {
                high += 1;
                high - 1
            };
            if self.is_noise[k] {
                (sum, count) = (sum + self.power[k], count + 1);
            }
        }
        (count > 0).then(|| NoiseLevel {
            variance: sum / f64::from(count as u32),
            dof: (2.0 * INDEPENDENCE * f64::from(count as u32)).max(1.0),
        })
    }

    /// Signal-to-noise ratio of an order: the larger power of its two neighbouring lines over the noise variance near it.
    pub fn noise_ratio(&self, order: f64) -> f64 {
        let position = order / self.spacing;
        let lines = [position.floor() as usize, position.ceil() as usize];
        let power = lines
            .into_iter()
            .filter_map(|k| self.power.get(k))
            .fold(0.0f64, |m, p| m.max(*p));
        match self.noise_level(order) {
            Some(level) if level.variance > 0.0 => power / level.variance,
            _ => 0.0,
        }
    }

    /// Excludes the lines of an order from the noise.
    pub fn exclude(&mut self, order: f64) {
        let position = order / self.spacing;
        let low = (position - MASKED_LINES).ceil().max(0.0) as usize;
        let high =
            ((position + MASKED_LINES).floor().max(0.0) as usize + 1).min(self.is_noise.len());
        self.is_noise[low.min(high)..high].fill(false);
    }

    /// Strongest noise line: its order, its amplitude, and its power over the noise variance near it.
    pub fn strongest_line(&self) -> Option<(f64, f64, f64)> {
        let candidates = (0..self.power.len()).filter(|k| self.is_noise[*k]);
        let k = candidates.max_by(|a, b| self.power[*a].total_cmp(&self.power[*b]))?;
        let mut masked = self.clone();
        masked.exclude(k as f64 * self.spacing);
        let level = masked.noise_level(k as f64 * self.spacing)?;
        // Interpolation between two lines from the ratio of the larger line and its larger neighbour (Hann window).
        let power_at = |j: Option<usize>| j.and_then(|j| self.power.get(j)).copied().unwrap_or(0.0);
        let (lower, upper) = (power_at(k.checked_sub(1)), power_at(Some(k + 1)));
        let ratio = (lower.max(upper) / self.power[k]).sqrt();
        let offset = ((2.0 * ratio - 1.0) / (1.0 + ratio)).clamp(0.0, 0.5);
        let position = k as f64 + if upper > lower { offset } else { -offset };
        let scalloping = crate::spectrum::kaiser_fir::sinc(offset) / (1.0 - offset * offset);
        let amplitude = (self.amplitude_factor * self.power[k]).sqrt() / scalloping;
        Some((
            position * self.spacing,
            amplitude,
            self.power[k] / level.variance,
        ))
    }

    /// Line spacing, orders.
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Number of spectral lines.
    pub fn line_count(&self) -> usize {
        self.power.len()
    }
}
