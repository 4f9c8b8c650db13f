//! The best linear interpolator of a band-limited signal from samples at any instants: the weights `w` that make the mean over
//! `|f| ≤ B` of `|Σ w_j exp(2πi f t_j) − exp(2πi f t)|²` smallest, `(G + εI) w = g` with `G_jk = sinc 2B(t_j − t_k)` and
//! `g_j = sinc 2B(t_j − t)` (Yen 1956, the minimum-energy solution, kept bounded by ε).

use std::f64::consts::PI;

/// Bounds what rounding and noise are amplified by; the interpolation error it leaves is its root, −120 dB.
const REGULARISATION: f64 = 1e-12;

/// An interpolator over a fixed number of neighbouring samples, with its workspace.
pub struct BandLimitedInterpolator {
    band_hz: f64,
    points: usize,
    gram: Vec<f64>,
    factor: Vec<f64>,
    right: Vec<f64>,
    weights: Vec<f64>,
    turns: Vec<(f64, f64)>,
}

impl BandLimitedInterpolator {
    /// Signals up to `band_hz`, `n_samples` samples at a time.
    pub fn new(band_hz: f64, points: usize) -> BandLimitedInterpolator {
        BandLimitedInterpolator {
            band_hz,
            points,
            gram: vec![0.0; points * points],
            factor: vec![0.0; points * points],
            right: vec![0.0; points],
            weights: vec![0.0; points],
            turns: vec![(0.0, 0.0); points],
        }
    }

    /// Samples taken at a time.
    pub fn n_samples(&self) -> usize {
        self.points
    }

    /// Weights of the samples at `times` (s, distinct, as many as planned) for the value at `at`, and their rms error relative to a
    /// signal whose power is spread evenly over the band.
    pub fn weights(&mut self, times: &[f64], at: f64) -> (&[f64], f64) {
        let (n, turn) = (self.points, 2.0 * PI * self.band_hz);
        for (j, t) in times.iter().enumerate() {
            // sin and cos of each angle give those of every difference.
            self.turns[j] = (turn * (t - at)).sin_cos();
            self.right[j] = sinc(turn * (t - at), self.turns[j].0);
        }
        for j in 0..n {
            for k in 0..j {
                let sine = self.turns[j].0 * self.turns[k].1 - self.turns[j].1 * self.turns[k].0;
                self.gram[j * n + k] = sinc(turn * (times[j] - times[k]), sine);
            }
            self.gram[j * n + j] = 1.0;
        }
        self.solve();
        let (mut linear, mut square) = (0.0, 0.0);
        for j in 0..n {
            linear += self.weights[j] * self.right[j];
            let row: f64 = (0..j).map(|k| self.gram[j * n + k] * self.weights[k]).sum();
            square += self.weights[j] * (2.0 * row + self.weights[j]);
        }
        (&self.weights, (1.0 - 2.0 * linear + square).max(0.0).sqrt())
    }

    /// Cholesky of `G + εI` and both substitutions, in place.
    fn solve(&mut self) {
        let n = self.points;
        for j in 0..n {
            for k in 0..=j {
                let (row, other) = (
                    &self.factor[j * n..j * n + k],
                    &self.factor[k * n..k * n + k],
                );
                let dot: f64 = row.iter().zip(other).map(|(a, b)| a * b).sum();
                let rest = self.gram[j * n + k] - dot;
                self.factor[j * n + k] = match j == k {
                    // What rounding takes below the bound is put back to it.
                    true => (rest + REGULARISATION).max(REGULARISATION).sqrt(),
                    false => rest / self.factor[k * n + k],
                };
            }
        }
        for j in 0..n {
            let dot: f64 = (0..j)
                .map(|k| self.factor[j * n + k] * self.weights[k])
                .sum();
            self.weights[j] = (self.right[j] - dot) / self.factor[j * n + j];
        }
        for j in (0..n).rev() {
            let dot: f64 = (j + 1..n)
                .map(|k| self.factor[k * n + j] * self.weights[k])
                .sum();
            self.weights[j] = (self.weights[j] - dot) / self.factor[j * n + j];
        }
    }
}

/// `sin x / x` where `sin x` is known.
fn sinc(x: f64, sine: f64) -> f64 {
    // Below this the quotient is 1 to rounding, and `sine` may have lost its digits.
    const SMALL: f64 = 1e-8;
    if x.abs() < SMALL { 1.0 } else { sine / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sines inside the band come out to the stated error from jittered instants; at a sample nothing is lost.
    #[test]
    fn exact_sines_inside_the_band() {
        let mut random = fastrand::Rng::with_seed(7);
        let times: Vec<f64> = (0..32)
            .map(|j| f64::from(j) + 0.2 * (random.f64() - 0.5))
            .collect();
        let mut interpolator = BandLimitedInterpolator::new(0.35, 32);
        for f in [0.0, 0.05, 0.2, 0.33] {
            for at in [15.2, 16.0, 16.71] {
                let (w, error) = interpolator.weights(&times, at);
                let wave = |t: f64| (2.0 * PI * f * t + 0.4).cos();
                let found: f64 = w.iter().zip(&times).map(|(w, &t)| w * wave(t)).sum();
                assert!(error < 1e-4, "{error}");
                assert!(
                    (found - wave(at)).abs() < 30.0 * error + 1e-5,
                    "{f} {at} {found}"
                );
            }
        }
        assert!(interpolator.weights(&times, times[16]).1 < 1e-5);
    }
}
