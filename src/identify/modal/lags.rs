//! Sums over lines per lag, `S(τ) = Re Σ_k g_k exp(iω_k Δt τ)`: Toeplitz blocks of z-domain fits.
//!
//! By one transform where the lines are equally spaced, else term by term.

use std::f64::consts::{PI, TAU};

use crate::numeric::Complex;
use crate::numeric::fft::ComplexFft;

/// Lines count as equally spaced when none is off its place by more than this share of the spacing; files with eight digits meet it.
const SPACING_TOLERANCE: f64 = 1e-3;

/// The time step of the discrete-time model and the means to sum over lines.
pub struct LagSums<'a> {
    frequency_hz: &'a [f64],
    /// Lags up to this.
    max_lag: usize,
    /// Time step, s.
    step: f64,
    /// The lines fill the half circle `[zone π, (zone + 1) π]`, as those of a signal sampled below the band do.
    zone: usize,
    transform: Option<(ComplexFft, Vec<Complex>)>,
}

impl<'a> LagSums<'a> {
    /// Lags from `−most` to `max_lag` for these lines.
    ///
    /// The step is the longest for which the band still lies within one half circle, `k B ≤ f_first`, `f_last ≤ (k + 1) B`, `B = 1/(2Δt)`.
    pub fn new(frequency_hz: &'a [f64], most: usize) -> LagSums<'a> {
        let n = frequency_hz.len();
        let (first, last) = (frequency_hz[0], frequency_hz[n - 1]);
        let spacing = (last - first) / (n - 1) as f64;
        let is_even = (0..n).all(|k| {
            (frequency_hz[k] - first - k as f64 * spacing).abs() <= SPACING_TOLERANCE * spacing
        });
        let length = |zone: usize| {
            let least = 2.0 * last / ((zone + 1) as f64 * spacing);
            (least - SPACING_TOLERANCE).ceil().max(2.0)
        };
        let fits = |&zone: &usize| {
            zone as f64 * length(zone) * spacing / 2.0 <= first * (1.0 + f64::EPSILON)
        };
        let highest = (first / (last - first)) as usize;
        let zone = (0..=highest).rev().find(fits).unwrap_or(0);
        let points = length(zone);
        LagSums {
            frequency_hz,
            max_lag: most,
            step: 1.0 / (points * spacing),
            zone,
            transform: is_even.then(|| {
                let points = points as usize;
                (ComplexFft::new(points), vec![Complex::ZERO; points])
            }),
        }
    }

    /// `S(τ)`, τ from `−most` to `max_lag`.
    pub fn sum(&mut self, g: impl Fn(usize) -> Complex) -> Vec<f64> {
        let most = self.max_lag as i64;
        let first = TAU * self.frequency_hz[0] * self.step;
        let n = self.frequency_hz.len();
        match &mut self.transform {
            Some((fft, space)) => {
                let points = space.len() as i64;
                space.fill(Complex::ZERO);
                (0..n).for_each(|k| space[k % points as usize] += g(k).conj());
                fft.forward(space);
                let value = |tau: i64| {
                    let z = space[tau.rem_euclid(points) as usize].conj();
                    (z * unit_phasor(first * tau as f64)).re
                };
                (-most..=most).map(value).collect()
            }
            None => {
                let mut sums = vec![0.0; 2 * self.max_lag + 1];
                for k in 0..n {
                    let ratio = unit_phasor(TAU * self.frequency_hz[k] * self.step);
                    let mut term =
                        g(k) * unit_phasor(-TAU * self.frequency_hz[k] * self.step * most as f64);
                    for sum in &mut sums {
                        *sum += term.re;
                        term *= ratio;
                    }
                }
                sums
            }
        }
    }

    /// The pole in s of the upper half plane, rad/s, for a pole in z; nothing for the conjugate partner or the origin.
    pub fn to_s_plane(&self, z: Complex) -> Option<Complex> {
        let (zone, angle) = (self.zone as f64, z.im.atan2(z.re));
        let is_turned = self.zone % 2 == 1;
        let is_partner = if is_turned {
            angle >= 0.0
        } else {
            angle <= 0.0
        };
        if is_partner || z.norm_sqr() == 0.0 {
            return None;
        }
        let whole = if is_turned { zone + 1.0 } else { zone } * PI;
        Some(Complex::new(z.norm().ln(), angle + whole) / self.step)
    }
}

fn unit_phasor(angle: f64) -> Complex {
    let (sin, cos) = angle.sin_cos();
    Complex::new(cos, sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The transform and the sum term by term agree; poles come back from `z = exp(sΔt)` in every zone.
    #[test]
    fn law_transform_is_the_sum() {
        for start in [0.5, 30.25, 97.0] {
            let mut lines: Vec<f64> = (0..40).map(|k| start + 0.5 * f64::from(k)).collect();
            let g = |k: usize| Complex::new((k as f64).sin(), 1.0 / (1.0 + k as f64));
            let mut quick = LagSums::new(&lines, 7);
            let fast = quick.sum(g);
            let pole = Complex::new(-3.0, TAU * (start + 9.0));
            let z = unit_phasor(pole.im * quick.step) * (pole.re * quick.step).exp();
            assert!((quick.to_s_plane(z).unwrap() - pole).norm() < 1e-10);
            assert!(quick.to_s_plane(z.conj()).is_none());
            lines[3] += 2e-3; // off the grid: term by term
            let slow = LagSums::new(&lines, 7).sum(g);
            let off: f64 = fast.iter().zip(&slow).map(|(a, b)| (a - b).abs()).sum();
            assert!(off < 0.05 && off > 0.0, "{off}");
        }
    }
}
