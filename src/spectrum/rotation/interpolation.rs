//! Band-limited interpolation by a Kaiser-windowed sinc: `x(t) = Σ_j x_j h((t − j)/s)`, `s ≥ 1`.
//!
//! Kept to 10⁻⁴ up to `PASS_BAND` of half the lower of both rates; from half that rate on 80 dB down.

use crate::spectrum::kaiser_fir::{kaiser, kaiser_beta, sinc};

/// Edge of the pass band, over half the lower of the two rates.
pub const PASS_BAND: f64 = 0.85;

/// Samples on either side, before stretching: by Kaiser's formula a transition of 0.15 at 90 dB takes 39.
pub const HALF_KERNEL: usize = 40;

/// Design of the window, dB: ten more than are promised, for the straight lines through the table.
const STOP_BAND_DB: f64 = 90.0;

/// Values of the table to a sample; straight lines between them are off by (π/512)²/8 = 5e-6.
const TABLE_STEPS: usize = 512;

/// The kernel, tabulated.
#[derive(Debug, Clone)]
pub struct SincInterpolator {
    table: Vec<f64>,
}

impl Default for SincInterpolator {
    fn default() -> Self {
        let beta = kaiser_beta(STOP_BAND_DB);
        let cut = 0.5 * (PASS_BAND + 1.0);
        let value = |i: usize| {
            let u = i as f64 / TABLE_STEPS as f64;
            sinc(cut * u) * kaiser((u / HALF_KERNEL as f64).min(1.0), beta)
        };
        SincInterpolator {
            table: (0..=HALF_KERNEL * TABLE_STEPS + 1).map(value).collect(),
        }
    }
}

/// Weights of neighbouring samples for one position between them.
#[derive(Debug, Clone)]
pub struct InterpolationWeights {
    /// The first sample, counted from that at or below the position.
    pub first: i64,
    /// Their sum is 1.
    pub weights: Vec<f64>,
}

impl SincInterpolator {
    /// Weights at a position of `part` samples, 0 to 1, behind a sample, where the kernel lies within the signal.
    pub fn weights_at(&self, part: f64) -> InterpolationWeights {
        let reach = HALF_KERNEL as f64;
        let first = (part - reach).ceil() as i64;
        let last = (part + reach).floor() as i64;
        let weight = |j: i64| self.weight((part - j as f64).abs() * TABLE_STEPS as f64);
        let weights: Vec<f64> = (first..=last).map(weight).collect();
        let sum: f64 = weights.iter().sum();
        InterpolationWeights {
            first,
            weights: weights.into_iter().map(|w| w / sum).collect(),
        }
    }

    /// The kernel so many steps of the table from its middle.
    fn weight(&self, u: f64) -> f64 {
        let i = u as usize;
        let (a, b) = (self.table[i], self.table[i + 1]);
        a + (b - a) * (u - i as f64)
    }

    /// The value at a position in samples. Where the kernel reaches beyond the slice, what is left of it is weighed alone.
    pub fn value_at(&self, samples: &[f64], position: f64, segment: f64) -> f64 {
        let reach = HALF_KERNEL as f64 * segment;
        let from = (position - reach).ceil().max(0.0) as usize;
        let to = (((position + reach).floor() + 1.0).max(0.0) as usize).min(samples.len());
        let scale = TABLE_STEPS as f64 / segment;
        let (mut sum, mut weights) = (0.0, 0.0);
        for (j, x) in samples.iter().enumerate().take(to).skip(from) {
            let w = self.weight((position - j as f64).abs() * scale);
            sum += w * x;
            weights += w;
        }
        sum / weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Tones up to the pass edge within 1e-4 between samples, resampled or not; from half the lower rate on below 1e-4.
    #[test]
    fn law_bands_are_met() {
        let kernel = SincInterpolator::default();
        let n = 1400;
        let mut worst = (0.0_f64, 0.0_f64);
        for segment in [1.0, 1.7, 6.3] {
            for i in 0..=20 {
                let part = f64::from(i) / 20.0;
                let wave = |f: f64, t: f64| (TAU * f * t + 0.4).cos();
                let tone = |f: f64| -> Vec<f64> { (0..n).map(|j| wave(f, f64::from(j))).collect() };
                let keep = 0.5 * PASS_BAND * part / segment;
                let kept = tone(keep);
                let stop = 0.5 / segment + 0.5 * (1.0 - 1.0 / segment) * part;
                let stopped = tone(stop);
                for k in 0..40 {
                    let t = 650.0 + 0.73 * f64::from(k);
                    worst.0 = worst
                        .0
                        .max((kernel.value_at(&kept, t, segment) - wave(keep, t)).abs());
                    if segment > 1.0 {
                        worst.1 = worst.1.max(kernel.value_at(&stopped, t, segment).abs());
                    }
                }
            }
        }
        assert!(worst.0 < 1e-4 && worst.1 < 1e-4, "{worst:?}");
    }
}
