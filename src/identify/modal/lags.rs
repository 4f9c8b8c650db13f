//! Sums over spectral lines for each lag, `S(τ) = Re Σ_k g_k exp(iω_k Δt τ)`: the Toeplitz blocks of z-domain fits.
//!
//! The sums take one FFT if the lines are equally spaced, else they are formed term by term.

use std::f64::consts::{PI, TAU};

use crate::numeric::Complex;
use crate::numeric::fft::ComplexFft;

/// Largest deviation of equally spaced lines from the grid, relative to the spacing; files with eight digits meet it.
const SPACING_TOLERANCE: f64 = 1e-3;

/// Evaluator of sums over lines for lags of a discrete-time model.
pub struct LagSums<'a> {
    frequency_hz: &'a [f64],
    /// Largest lag, in time steps.
    max_lag: usize,
    /// Time step, s.
    step: f64,
    /// Nyquist zone: the angles `ω Δt` of the lines lie in `[zone π, (zone + 1) π]`, as for a band-pass sampled signal.
    zone: usize,
    transform: Option<(ComplexFft, Vec<Complex>)>,
}

impl<'a> LagSums<'a> {
    /// Evaluator for lags from `−max_lag` to `max_lag` at lines `frequency_hz`.
    ///
    /// The time step is the longest for which the band lies in one Nyquist zone, `k B ≤ f_first`, `f_last ≤ (k + 1) B`, `B = 1/(2Δt)`.
    pub fn new(frequency_hz: &'a [f64], max_lag: usize) -> LagSums<'a> {
        let n = frequency_hz.len();
        let (first, last) = (frequency_hz[0], frequency_hz[n - 1]);
        let spacing = (last - first) / (n - 1) as f64;
        let is_even = (0..n).all(|k| {
            (frequency_hz[k] - first - k as f64 * spacing).abs() <= SPACING_TOLERANCE * spacing
        });
        let n_points = |zone: usize| {
            let min_points = 2.0 * last / ((zone + 1) as f64 * spacing);
            (min_points - SPACING_TOLERANCE).ceil().max(2.0)
        };
        let fits = |&zone: &usize| {
            zone as f64 * n_points(zone) * spacing / 2.0 <= first * (1.0 + f64::EPSILON)
        };
        let max_zone = (first / (last - first)) as usize;
        let zone = (0..=max_zone).rev().find(fits).unwrap_or(0);
        let points = n_points(zone);
        LagSums {
            frequency_hz,
            max_lag,
            step: 1.0 / (points * spacing),
            zone,
            transform: is_even.then(|| {
                let points = points as usize;
                (ComplexFft::new(points), vec![Complex::ZERO; points])
            }),
        }
    }

    /// Sums `S(τ)` for τ from `−max_lag` to `max_lag`; `g` returns the term of a line by index.
    pub fn sum(&mut self, g: impl Fn(usize) -> Complex) -> Vec<f64> {
        let max_lag = self.max_lag as i64;
        let first = TAU * self.frequency_hz[0] * self.step;
        let n = self.frequency_hz.len();
        match &mut self.transform {
            Some((fft, buffer)) => {
                let points = buffer.len() as i64;
                buffer.fill(Complex::ZERO);
                (0..n).for_each(|k| buffer[k % points as usize] += g(k).conj());
                fft.forward(buffer);
                let value = |tau: i64| {
                    let z = buffer[tau.rem_euclid(points) as usize].conj();
                    (z * unit_phasor(first * tau as f64)).re
                };
                (-max_lag..=max_lag).map(value).collect()
            }
            None => {
                let mut sums = vec![0.0; 2 * self.max_lag + 1];
                for k in 0..n {
                    let ratio = unit_phasor(TAU * self.frequency_hz[k] * self.step);
                    let mut term = g(k)
                        * unit_phasor(-TAU * self.frequency_hz[k] * self.step * max_lag as f64);
                    for sum in &mut sums {
                        *sum += term.re;
                        term *= ratio;
                    }
                }
                sums
            }
        }
    }

    /// Pole in the upper half of the s plane, rad/s, for a pole in z; `None` for the conjugate pole or the origin.
    pub fn to_s_plane(&self, z: Complex) -> Option<Complex> {
        let (zone, angle) = (self.zone as f64, z.im.atan2(z.re));
        let is_odd = self.zone % 2 == 1;
        let is_conjugate = if is_odd { angle >= 0.0 } else { angle <= 0.0 };
        if is_conjugate || z.norm_sqr() == 0.0 {
            return None;
        }
        let offset = if is_odd { zone + 1.0 } else { zone } * PI;
        Some(Complex::new(z.norm().ln(), angle + offset) / self.step)
    }
}

fn unit_phasor(angle: f64) -> Complex {
    let (sin, cos) = angle.sin_cos();
    Complex::new(cos, sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The FFT and the sum term by term agree, and poles are recovered from `z = exp(sΔt)` in every zone.
    #[test]
    fn law_transform_is_the_sum() {
        for start in [0.5, 30.25, 97.0] {
            let mut lines: Vec<f64> = (0..40).map(|k| start + 0.5 * f64::from(k)).collect();
            let g = |k: usize| Complex::new((k as f64).sin(), 1.0 / (1.0 + k as f64));
            let mut sums = LagSums::new(&lines, 7);
            let by_fft = sums.sum(g);
            let pole = Complex::new(-3.0, TAU * (start + 9.0));
            let z = unit_phasor(pole.im * sums.step) * (pole.re * sums.step).exp();
            assert!((sums.to_s_plane(z).unwrap() - pole).norm() < 1e-10);
            assert!(sums.to_s_plane(z.conj()).is_none());
            lines[3] += 2e-3; // off the grid: term by term
            let by_terms = LagSums::new(&lines, 7).sum(g);
            let deviation: f64 = by_fft
                .iter()
                .zip(&by_terms)
                .map(|(a, b)| (a - b).abs())
                .sum();
            assert!(deviation < 0.05 && deviation > 0.0, "{deviation}");
        }
    }
}
