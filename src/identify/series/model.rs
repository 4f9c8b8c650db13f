//! Fitted polynomial model `A y = B/F u + C e` with its residuals, predictions, spectra and modes.

use std::f64::consts::TAU;

use super::filter::{filter_delayed, filter_inverse};
use super::io_data::InputOutputData;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::sorting::sort_ascending;
use crate::numeric::{Complex, Matrix, eigen};

/// Model structure: polynomials of the model and their lengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelStructure {
    /// `A y = e`.
    Ar {
        /// Number of coefficients of A.
        a: usize,
    },
    /// `A y = C e`.
    Arma {
        /// Number of coefficients of A.
        a: usize,
        /// Number of coefficients of C.
        c: usize,
    },
    /// `A y = B u + e`.
    Arx {
        /// Number of coefficients of A.
        a: usize,
        /// Number of coefficients of B.
        b: usize,
        /// Delay from input to output, samples; 0 for direct feedthrough.
        delay: usize,
    },
    /// `A y = B u + C e`.
    Armax {
        /// Number of coefficients of A.
        a: usize,
        /// Number of coefficients of B.
        b: usize,
        /// Number of coefficients of C.
        c: usize,
        /// Delay from input to output, samples.
        delay: usize,
    },
    /// `y = B/F u + e`.
    OutputError {
        /// Number of coefficients of B.
        b: usize,
        /// Number of coefficients of F.
        f: usize,
        /// Delay from input to output, samples.
        delay: usize,
    },
}

/// Numbers of coefficients of the polynomials, and the delay in samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct PolynomialOrders {
    pub a: usize,
    pub b: usize,
    pub c: usize,
    pub f: usize,
    pub delay: usize,
}

impl ModelStructure {
    pub(super) fn orders(self) -> PolynomialOrders {
        let none = PolynomialOrders::default();
        match self {
            ModelStructure::Ar { a } => PolynomialOrders { a, ..none },
            ModelStructure::Arma { a, c } => PolynomialOrders { a, c, ..none },
            ModelStructure::Arx { a, b, delay } => PolynomialOrders {
                a,
                b,
                delay,
                ..none
            },
            ModelStructure::Armax { a, b, c, delay } => PolynomialOrders {
                a,
                b,
                c,
                delay,
                f: 0,
            },
            ModelStructure::OutputError { b, f, delay } => PolynomialOrders {
                b,
                f,
                delay,
                ..none
            },
        }
    }

    /// Number of coefficients to fit.
    pub fn parameter_count(self) -> usize {
        let n = self.orders();
        n.a + n.b + n.c + n.f
    }
}

impl PolynomialOrders {
    /// Number of samples before the first prediction from a complete past.
    pub(super) fn warm_up(self) -> usize {
        let input = if self.b > 0 {
            self.delay + self.b - 1
        } else {
            0
        };
        self.a.max(input)
    }
}

/// Polynomial model with its covariance and the data of the fit.
#[derive(Debug, Clone)]
pub struct PolynomialModel {
    /// Structure of the fitted model.
    pub family: ModelStructure,
    /// Coefficients `a₁, a₂, …`.
    pub a: Vec<f64>,
    /// Coefficients `b₀, b₁, …`, the first at the delay; output unit per input unit.
    pub b: Vec<f64>,
    /// Coefficients `c₁, c₂, …`.
    pub c: Vec<f64>,
    /// Coefficients `f₁, f₂, …`.
    pub f: Vec<f64>,
    /// Variance of the noise e, output unit squared.
    pub noise_variance: f64,
    /// Covariance of the coefficients in the order a, b, c, f; valid for white residuals.
    pub covariance: Matrix,
    /// Mean of the output, subtracted before the fit.
    pub output_mean: f64,
    /// Mean of the input, subtracted before the fit.
    pub input_mean: f64,
    /// Number of samples predicted in the fit.
    pub samples: usize,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Number of iterations; 0 for a linear fit.
    pub iterations: usize,
}

impl PolynomialModel {
    /// Standard deviations of the coefficients in the order a, b, c, f.
    pub fn std(&self) -> Vec<f64> {
        (0..self.covariance.nrows())
            .map(|i| self.covariance[(i, i)].max(0.0).sqrt())
            .collect()
    }

    /// One-step prediction errors; zero for the samples of the warm-up.
    ///
    /// # Errors
    /// `NoSignal` if the model has an input and the record has none.
    pub fn residuals(&self, record: &InputOutputData) -> Result<Vec<f64>, Error> {
        let y: Vec<f64> = (record.output().iter())
            .map(|y| y - self.output_mean)
            .collect();
        let u = match (self.b.is_empty(), record.input()) {
            (true, _) => Vec::new(),
            (false, Some(u)) => u.iter().map(|u| u - self.input_mean).collect(),
            (false, None) => return Err(no_input()),
        };
        Ok(prediction_errors(self.polynomials(), &y, &u).errors)
    }

    /// One-step predictions: output minus residual.
    ///
    /// # Errors
    /// Errors of [`PolynomialModel::residuals`].
    pub fn predictions(&self, record: &InputOutputData) -> Result<Vec<f64>, Error> {
        let errors = self.residuals(record)?;
        Ok((record.output().iter().zip(errors))
            .map(|(y, e)| y - e)
            .collect())
    }

    /// One-sided power spectral density of the output due to the noise, output unit squared per Hz, at `frequency_hz`.
    pub fn noise_density(&self, frequency_hz: f64) -> f64 {
        let shift = self.shift(frequency_hz);
        let shape = evaluate(&self.c, shift) / evaluate(&self.a, shift);
        2.0 * self.noise_variance / self.rate_hz * shape.norm_sqr()
    }

    /// Frequency response at `frequency_hz`, output unit per input unit.
    pub fn response(&self, frequency_hz: f64) -> Complex {
        let shift = self.shift(frequency_hz);
        let delay = self.family.orders().delay;
        let numerator: Complex = (self.b.iter().enumerate())
            .map(|(j, &b)| power(shift, delay + j) * b)
            .sum();
        numerator / (evaluate(&self.a, shift) * evaluate(&self.f, shift))
    }

    /// Modes sorted by frequency: roots z of A (of F for an output-error model) above the real axis as poles `rate · ln z`, with the
    /// covariance propagated from the coefficients to first order. Shapes are empty.
    ///
    /// # Errors
    /// `NoConvergence` of the polynomial roots.
    pub fn modes(&self) -> Result<Vec<ModalParameters>, Error> {
        let is_output_error = self.a.is_empty();
        let first = if is_output_error {
            self.a.len() + self.b.len() + self.c.len()
        } else {
            0
        };
        let coefficients = if is_output_error { &self.f } else { &self.a };
        modes_of(coefficients, &self.covariance, first, self.rate_hz)
    }

    /// Shares from 0 to 1 of each of [`PolynomialModel::modes`] in the response of the model to white noise (at the input, if any): in the
    /// power, `|c_j|/Σ|c|` with the autocovariance `Σ c_j z_j^k`, and in the response at the frequency of the mode, close to 1 for a
    /// resonance and small for a numerical root.
    ///
    /// # Errors
    /// `NoConvergence` of the polynomial roots.
    pub fn mode_shares(&self) -> Result<Vec<ModeShares>, Error> {
        let den = if self.a.is_empty() { &self.f } else { &self.a };
        let num: Vec<f64> = match self.b.is_empty() {
            true => std::iter::once(1.0).chain(self.c.iter().copied()).collect(),
            false => self.b.clone(),
        };
        let n = den.len();
        let value = |c: &[f64], x: Complex| {
            (c.iter().rev()).fold(Complex::new(0.0, 0.0), |sum, &c| sum * x + c)
        };
        let roots = roots(den)?;
        // Residue of H(z) at a root: z^n N(1/z)/d′(z).
        let residue = |z: Complex| {
            let one = Complex::new(1.0, 0.0);
            let others = roots.iter().filter(|r| **r != z);
            power(z, n) * value(&num, z.inv()) / others.fold(one, |p, r| p * (z - r))
        };
        let weights: Vec<Complex> = roots
            .iter()
            .map(|&z| residue(z) * value(&num, z) / (evaluate(den, z) * z))
            .collect();
        let total: f64 = weights.iter().map(|c| c.norm()).sum();
        let mut modes: Vec<(f64, ModeShares)> = (roots.iter().zip(&weights))
            .filter(|(z, _)| z.im > 0.0)
            .map(|(&z, c)| {
                let circle = z / z.norm();
                let modal = (residue(z) / (circle - z)).norm();
                let response = (value(&num, circle.inv()) / evaluate(den, circle.inv())).norm();
                let pole = Complex::new(z.norm().ln(), z.im.atan2(z.re));
                let shares = ModeShares {
                    power: 2.0 * c.norm() / total,
                    at_peak: (modal / response).min(1.0),
                };
                (pole.norm(), shares)
            })
            .collect();
        sort_ascending(&mut modes, |a| a.0);
        Ok(modes.into_iter().map(|a| a.1).collect())
    }

    pub(super) fn polynomials(&self) -> PolynomialRefs<'_> {
        PolynomialRefs {
            a: &self.a,
            b: &self.b,
            c: &self.c,
            f: &self.f,
            delay: self.family.orders().delay,
        }
    }

    fn shift(&self, frequency_hz: f64) -> Complex {
        let angle = TAU * frequency_hz / self.rate_hz;
        Complex::new(angle.cos(), -angle.sin())
    }
}

/// Shares of a mode in the response of a model, from 0 to 1.
#[derive(Debug, Clone, Copy)]
pub struct ModeShares {
    /// Share of the power.
    pub power: f64,
    /// Share of the response at the frequency of the mode.
    pub at_peak: f64,
}

/// Roots of `z^n + a₁z^{n−1} + … + a_n`.
fn roots(a: &[f64]) -> Result<Vec<Complex>, Error> {
    let n = a.len();
    let companion = Matrix::from_fn(n, n, |i, j| match i {
        0 => -a[j],
        _ => f64::from(u8::from(j + 1 == i)),
    });
    Ok(eigen::eigen(&companion)?.values)
}

/// Error for a model with an input and a record without one.
pub(super) fn no_input() -> Error {
    Error::new(
        Code::NoSignal,
        "the model has an input and the record has none",
    )
    .with_hint("give the input channel, or fit a family without one: AR or ARMA")
}

/// Borrowed polynomials of a model.
#[derive(Debug, Clone, Copy)]
pub(super) struct PolynomialRefs<'a> {
    pub a: &'a [f64],
    pub b: &'a [f64],
    pub c: &'a [f64],
    pub f: &'a [f64],
    pub delay: usize,
}

/// One-step prediction errors and the noise-free output `w = B/F u`.
pub(super) struct Prediction {
    pub errors: Vec<f64>,
    pub noise_free: Vec<f64>,
    pub first: usize,
}

/// Computes `e = (A y − w)/C` from the first sample with a complete past on; `e = 0` before it.
pub(super) fn prediction_errors(model: PolynomialRefs, y: &[f64], u: &[f64]) -> Prediction {
    let lengths = PolynomialOrders {
        a: model.a.len(),
        b: model.b.len(),
        c: model.c.len(),
        f: model.f.len(),
        delay: model.delay,
    };
    let first = lengths.warm_up().min(y.len());
    let mut undisturbed = filter_delayed(u, model.b, model.delay);
    filter_inverse(&mut undisturbed, model.f);
    let mut errors = y.to_vec();
    for (k, a) in model.a.iter().enumerate() {
        (errors.iter_mut().skip(k + 1).zip(y)).for_each(|(e, y)| *e += a * y);
    }
    (errors.iter_mut().zip(&undisturbed)).for_each(|(e, w)| *e -= w);
    errors[..first].fill(0.0);
    filter_inverse(&mut errors[first..], model.c);
    Prediction {
        errors,
        noise_free: undisturbed,
        first,
    }
}

/// Evaluates `1 + c₁x + c₂x² + …`.
fn evaluate(c: &[f64], x: Complex) -> Complex {
    let one = Complex::new(1.0, 0.0);
    (c.iter().rev()).fold(Complex::new(0.0, 0.0), |sum, &c| (sum + c) * x) + one
}

fn power(x: Complex, n: usize) -> Complex {
    (0..n).fold(Complex::new(1.0, 0.0), |product, _| product * x)
}

/// Modes of `z^n + a₁z^{n−1} + … + a_n`; the covariance of the coefficients starts at row `first`.
///
/// `dz/da_k = −z^{n−k} / P′(z)` and `s = rate · ln z`, so `ds/da_k = −rate · z^{n−k−1} / P′(z)`.
fn modes_of(
    a: &[f64],
    covariance: &Matrix,
    first: usize,
    rate_hz: f64,
) -> Result<Vec<ModalParameters>, Error> {
    let roots = roots(a)?;
    let mut modes: Vec<ModalParameters> = (roots.iter())
        .filter(|z| z.im > 0.0)
        .map(|&z| {
            let weights = sensitivities(a, z, rate_hz);
            let mut sums = [0.0; 3];
            for (i, wi) in weights.iter().enumerate() {
                for (j, wj) in weights.iter().enumerate() {
                    let c = covariance[(first + i, first + j)];
                    sums[0] += wi.re * c * wj.re;
                    sums[1] += wi.im * c * wj.im;
                    sums[2] += wi.re * c * wj.im;
                }
            }
            let is_finite = sums.iter().all(|x| x.is_finite());
            ModalParameters {
                pole: Complex::new(z.norm().ln(), z.im.atan2(z.re)) * rate_hz,
                pole_covariance: is_finite.then_some(sums),
                shape: Vec::new(),
            }
        })
        .collect();
    sort_ascending(&mut modes, |a| a.pole.norm());
    Ok(modes)
}

/// Sensitivities `ds/da_k` for k from 1 to n.
fn sensitivities(a: &[f64], z: Complex, rate_hz: f64) -> Vec<Complex> {
    let n = a.len();
    let zero = Complex::new(0.0, 0.0);
    // Horner scheme for P and P′.
    let (_, slope) = std::iter::once(&1.0)
        .chain(a)
        .fold((zero, zero), |(p, slope), &a| (p * z + a, slope * z + p));
    let scale = slope.inv() * -rate_hz;
    // z^{n−k−1}, from k = n (1/z) down to k = 1.
    let mut powers = vec![zero; n];
    let mut power = z.inv();
    for k in (0..n).rev() {
        powers[k] = power * scale;
        power *= z;
    }
    powers
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sensitivities agree with central differences of the poles.
    #[test]
    fn law_sensitivities_are_derivatives() {
        let a = [-1.5, 1.1, -0.3, 0.2];
        let none = Matrix::zeros(4, 4);
        let poles = |a: &[f64]| -> Vec<Complex> {
            let modes = modes_of(a, &none, 0, 10.0).unwrap();
            modes.iter().map(|m| m.pole).collect()
        };
        let h = 1e-6;
        for (m, pole) in poles(&a).iter().enumerate() {
            let z = (pole / 10.0).exp();
            for (k, exact) in sensitivities(&a, z, 10.0).iter().enumerate() {
                let (mut up, mut down) = (a, a);
                up[k] += h;
                down[k] -= h;
                let measured = (poles(&up)[m] - poles(&down)[m]) / (2.0 * h);
                assert!((measured - exact).norm() < 1e-6 * exact.norm().max(1.0));
            }
        }
    }
}
