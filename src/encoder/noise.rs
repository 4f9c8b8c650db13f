//! Noise spectrum of the residual: noise level near each order, significant lines.
//!
//! The residual under Hann's window has `E|R_k|² = S(o) Σw²`: S is what the variance of a sample would be if all orders were as noisy
//! as those near o.

use super::orders::CandidateOrder;
use crate::numeric::Complex;
use crate::numeric::fft::{RealFft, prev_fast_len};

/// Lines near an order from which its noise is known: as many as make the deviation known to a tenth.
const NOISE_LINES: usize = 48;

/// Lines to either side of a fitted order that it has emptied, with Hann's window.
const MASKED_LINES: f64 = 1.5;

/// Hann's neighbouring lines hang together: so many independent ones in one (36/19 of them are alike, Welch 1967).
const INDEPENDENCE: f64 = 0.53;

/// Noise about an order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseLevel {
    /// S, in squares of the unit of the samples.
    pub variance: f64,
    /// Degrees of freedom that S is known with.
    pub dof: f64,
}

/// The spectrum of a residual.
#[derive(Debug, Clone)]
pub struct ResidualSpectrum {
    /// Between lines, in orders.
    spacing: f64,
    /// `|R_k|²/Σw²`.
    power: Vec<f64>,
    /// Lines that noise is read from.
    quiet: Vec<bool>,
    /// Conversion of a line's power to amplitude²: amplitude² for each unit of power.
    square: f64,
}

impl ResidualSpectrum {
    /// Residual spectrum of samples at so many a turn, without the orders that were subtracted, up to the order `band`.
    pub fn new(
        values: &[f64],
        per_turn: usize,
        fitted: &[CandidateOrder],
        band: f64,
    ) -> ResidualSpectrum {
        // A few samples fewer, where so many are quicker to transform.
        let n = prev_fast_len(values.len());
        let mut fft = RealFft::new(n);
        let mut block = values[..n].to_vec();
        let mut lines = vec![Complex::ZERO; fft.lines()];
        fft.forward(&mut block, &mut lines);
        // Hann's window, laid on behind the transform: X_k/2 − (X_{k−1} + X_{k+1})/4; Σw = n/2, Σw² = 3n/8.
        let line = |k: usize| match k < lines.len() {
            true => lines[k],
            false => lines[n - k].conj(),
        };
        let windowed = |k: usize| {
            let before = if k == 0 { line(1).conj() } else { line(k - 1) };
            line(k) * 0.5 - (before + line(k + 1)) * 0.25
        };
        let (sum, squares) = (0.5 * n as f64, 0.375 * n as f64);
        let spacing = per_turn as f64 / n as f64;
        let kept = ((band / spacing) as usize + 1).min(lines.len());
        let power: Vec<f64> = (0..kept)
            .map(|k| windowed(k).norm_sqr() / squares)
            .collect();
        let mut quiet = vec![true; kept];
        let mut empty = |order: f64| {
            let at = order / spacing;
            let low = (at - MASKED_LINES).ceil().max(0.0) as usize;
            let high = ((at + MASKED_LINES).floor().max(0.0) as usize + 1).min(kept);
            quiet[low.min(high)..high].fill(false);
        };
        empty(0.0);
        fitted.iter().for_each(|o| empty(o.value));
        ResidualSpectrum {
            spacing,
            power,
            quiet,
            square: 4.0 * squares / (sum * sum),
        }
    }

    /// Noise near an order, from the quiet lines nearest to it; nothing where there are none.
    pub fn noise_level(&self, order: f64) -> Option<NoiseLevel> {
        let at = order / self.spacing;
        let start = (at.round() as usize).min(self.power.len());
        let (mut low, mut high) = (start, start);
        let (mut sum, mut count) = (0.0, 0);
        while count < NOISE_LINES && (low > 0 || high < self.power.len()) {
            let down = if low > 0 {
                at - (low - 1) as f64
            } else {
                f64::INFINITY
            };
            let up = if high < self.power.len() {
                high as f64 - at
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
            if self.quiet[k] {
                (sum, count) = (sum + self.power[k], count + 1);
            }
        }
        (count > 0).then(|| NoiseLevel {
            variance: sum / f64::from(count as u32),
            dof: (2.0 * INDEPENDENCE * f64::from(count as u32)).max(1.0),
        })
    }

    /// Signal-to-noise ratio of an order: power over the mean of the noise near it. The nearest two lines are looked at.
    pub fn noise_ratio(&self, order: f64) -> f64 {
        let at = order / self.spacing;
        let near = [at.floor() as usize, at.ceil() as usize];
        let power = near
            .into_iter()
            .filter_map(|k| self.power.get(k))
            .fold(0.0f64, |m, p| m.max(*p));
        match self.noise_level(order) {
            Some(level) if level.variance > 0.0 => power / level.variance,
            _ => 0.0,
        }
    }

    /// Noise no longer reads the lines about an order.
    pub fn exclude(&mut self, order: f64) {
        let at = order / self.spacing;
        let low = (at - MASKED_LINES).ceil().max(0.0) as usize;
        let high = ((at + MASKED_LINES).floor().max(0.0) as usize + 1).min(self.quiet.len());
        self.quiet[low.min(high)..high].fill(false);
    }

    /// The strongest line among the quiet ones: its order, its amplitude, its power over the noise about it.
    pub fn strongest_line(&self) -> Option<(f64, f64, f64)> {
        let quiet = (0..self.power.len()).filter(|k| self.quiet[*k]);
        let k = quiet.max_by(|a, b| self.power[*a].total_cmp(&self.power[*b]))?;
        let mut without = self.clone();
        without.exclude(k as f64 * self.spacing);
        let level = without.noise_level(k as f64 * self.spacing)?;
        // The line lies between two of the transform, by the ratio of the larger to its larger neighbour under Hann's window.
        let side = |j: Option<usize>| j.and_then(|j| self.power.get(j)).copied().unwrap_or(0.0);
        let (down, up) = (side(k.checked_sub(1)), side(Some(k + 1)));
        let ratio = (down.max(up) / self.power[k]).sqrt();
        let part = ((2.0 * ratio - 1.0) / (1.0 + ratio)).clamp(0.0, 0.5);
        let place = k as f64 + if up > down { part } else { -part };
        let loss = crate::spectrum::kaiser_fir::sinc(part) / (1.0 - part * part);
        let amplitude = (self.square * self.power[k]).sqrt() / loss;
        Some((
            place * self.spacing,
            amplitude,
            self.power[k] / level.variance,
        ))
    }

    /// Between lines, in orders.
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Lines looked at.
    pub fn line_count(&self) -> usize {
        self.power.len()
    }
}
