//! Optimal linear interpolation of a band-limited signal from nonuniform samples: the weights `w` minimise the mean over
//! `|f| ≤ B` of `|Σ w_j exp(2πi f t_j) − exp(2πi f t)|²`, `(G + εI) w = g` with `G_jk = sinc 2B(t_j − t_k)` and
//! `g_j = sinc 2B(t_j − t)` (Yen 1956, the minimum-energy solution, regularised by ε).

use std::f64::consts::PI;

/// Regularisation ε, which bounds the amplification of rounding and noise; the interpolation error due to it is √ε, −120 dB.
const REGULARISATION: f64 = 1e-12;

/// Interpolator over a fixed number of neighbouring samples, with its workspace.
pub struct BandLimitedInterpolator {
    band_hz: f64,
    points: usize,
    gram: Vec<f64>,
    factor: Vec<f64>,
    rhs: Vec<f64>,
    weights: Vec<f64>,
    trig: Vec<(f64, f64)>,
}

impl BandLimitedInterpolator {
    /// Interpolator of signals up to `band_hz`, Hz, from `points` samples.
    pub fn new(band_hz: f64, points: usize) -> BandLimitedInterpolator {
        BandLimitedInterpolator {
            band_hz,
            points,
            gram: vec![0.0; points * points],
            factor: vec![0.0; points * points],
            rhs: vec![0.0; points],
            weights: vec![0.0; points],
            trig: vec![(0.0, 0.0); points],
        }
    }

    /// Number of samples of an interpolation.
    pub fn n_samples(&self) -> usize {
        self.points
    }

    /// Weights of the samples at `times` (s, distinct, [`Self::n_samples`] of them) for the value at the time `at`, s, and their rms
    /// error relative to a signal with a flat spectrum over the band.
    pub fn weights(&mut self, times: &[f64], at: f64) -> (&[f64], f64) {
        let (n, omega) = (self.points, 2.0 * PI * self.band_hz);
        for (j, t) in times.iter().enumerate() {
            // sin and cos of each angle give the sines of all differences.
            self.trig[j] = (omega * (t - at)).sin_cos();
            self.rhs[j] = sinc(omega * (t - at), self.trig[j].0);
        }
        for j in 0..n {
            for k in 0..j {
                let sine = self.trig[j].0 * self.trig[k].1 - self.trig[j].1 * self.trig[k].0;
                self.gram[j * n + k] = sinc(omega * (times[j] - times[k]), sine);
            }
            self.gram[j * n + j] = 1.0;
        }
        self.solve();
        let (mut linear, mut square) = (0.0, 0.0);
        for j in 0..n {
            linear += self.weights[j] * self.rhs[j];
            let row: f64 = (0..j).map(|k| self.gram[j * n + k] * self.weights[k]).sum();
            square += self.weights[j] * (2.0 * row + self.weights[j]);
        }
        (&self.weights, (1.0 - 2.0 * linear + square).max(0.0).sqrt())
    }

    /// Solves `(G + εI) w = g` by Cholesky factorisation.
    fn solve(&mut self) {
        let n = self.points;
        for j in 0..n {
            for k in 0..=j {
                let (row, other) = (
                    &self.factor[j * n..j * n + k],
                    &self.factor[k * n..k * n + k],
                );
                let dot: f64 = row.iter().zip(other).map(|(a, b)| a * b).sum();
                let pivot = self.gram[j * n + k] - dot;
                self.factor[j * n + k] = match j == k {
                    // Pivots reduced below ε by rounding are set to ε.
                    true => (pivot + REGULARISATION).max(REGULARISATION).sqrt(),
                    false => pivot / self.factor[k * n + k],
                };
            }
        }
        for j in 0..n {
            let dot: f64 = (0..j)
                .map(|k| self.factor[j * n + k] * self.weights[k])
                .sum();
            self.weights[j] = (self.rhs[j] - dot) / self.factor[j * n + j];
        }
        for j in (0..n).rev() {
            let dot: f64 = (j + 1..n)
                .map(|k| self.factor[k * n + j] * self.weights[k])
                .sum();
            self.weights[j] = (self.weights[j] - dot) / self.factor[j * n + j];
        }
    }
}

/// Quotient `sin x / x` for a given `sin x`.
fn sinc(x: f64, sine: f64) -> f64 {
    // Below this the quotient is 1 to rounding, and `sine` may be inaccurate.
    const SMALL: f64 = 1e-8;
    if x.abs() < SMALL { 1.0 } else { sine / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sines inside the band are interpolated from jittered samples within the stated error; at a sample the error is zero.
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
                let value: f64 = w.iter().zip(&times).map(|(w, &t)| w * wave(t)).sum();
                assert!(error < 1e-4, "{error}");
                assert!(
                    (value - wave(at)).abs() < 30.0 * error + 1e-5,
                    "{f} {at} {value}"
                );
            }
        }
        assert!(interpolator.weights(&times, times[16]).1 < 1e-5);
    }
}
