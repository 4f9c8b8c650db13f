//! Fitted polynomial model `A y = B/F u + C e`: residuals, predictions, spectra, modes.

use std::f64::consts::TAU;

use super::filter::{filter_delayed, filter_inverse};
use super::io_data::InputOutputData;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::sorting::sort_rising;
use crate::numeric::{Complex, Matrix, eigen};

/// Which polynomials a model has, and how long they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelStructure {
    /// `A y = e`.
    Ar {
        /// Coefficients of A.
        a: usize,
    },
    /// `A y = C e`.
    Arma {
        /// Coefficients of A.
        a: usize,
        /// Coefficients of C.
        c: usize,
    },
    /// `A y = B u + e`.
    Arx {
        /// Coefficients of A.
        a: usize,
        /// Coefficients of B.
        b: usize,
        /// Samples from input to output; 0 where the input acts at once.
        delay: usize,
    },
    /// `A y = B u + C e`.
    Armax {
        /// Coefficients of A.
        a: usize,
        /// Coefficients of B.
        b: usize,
        /// Coefficients of C.
        c: usize,
        /// Samples from input to output.
        delay: usize,
    },
    /// `y = B/F u + e`.
    OutputError {
        /// Coefficients of B.
        b: usize,
        /// Coefficients of F.
        f: usize,
        /// Samples from input to output.
        delay: usize,
    },
}

/// Lengths of the polynomials.
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

    /// Coefficients to fit.
    pub fn parameter_count(self) -> usize {
        let n = self.orders();
        n.a + n.b + n.c + n.f
    }
}

impl PolynomialOrders {
    /// Samples before the first one that is predicted from a full past.
    pub(super) fn warm_up(self) -> usize {
        let input = if self.b > 0 {
            self.delay + self.b - 1
        } else {
            0
        };
        self.a.max(input)
    }
}

/// A fitted model.
#[derive(Debug, Clone)]
pub struct PolynomialModel {
    /// Structure of the fitted model.
    pub family: ModelStructure,
    /// `a₁, a₂, …`.
    pub a: Vec<f64>,
    /// `b₀, b₁, …`, the first acting after the delay; output per input.
    pub b: Vec<f64>,
    /// `c₁, c₂, …`.
    pub c: Vec<f64>,
    /// `f₁, f₂, …`.
    pub f: Vec<f64>,
    /// Variance of the noise e, output squared.
    pub noise_variance: f64,
    /// Covariance of the coefficients in the order a, b, c, f; right where the residuals are white.
    pub covariance: Matrix,
    /// Mean of the output, which was taken off.
    pub output_mean: f64,
    /// Mean of the input, which was taken off.
    pub input_mean: f64,
    /// Samples predicted in the fit.
    pub samples: usize,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Steps of the iteration; 0 where the fit is linear.
    pub iterations: usize,
}

impl PolynomialModel {
    /// Standard deviations of the coefficients in the order a, b, c, f.
    pub fn std(&self) -> Vec<f64> {
        (0..self.covariance.nrows())
            .map(|i| self.covariance[(i, i)].max(0.0).sqrt())
            .collect()
    }

    /// Errors of the one-step predictions; zero for the samples that only start the recursion.
    ///
    /// # Errors
    /// `NoSignal` where the model has an input and the record has none.
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

    /// One-step predictions: the output less the residual.
    ///
    /// # Errors
    /// As [`PolynomialModel::residuals`].
    pub fn predictions(&self, record: &InputOutputData) -> Result<Vec<f64>, Error> {
        let errors = self.residuals(record)?;
        Ok((record.output().iter().zip(errors))
            .map(|(y, e)| y - e)
            .collect())
    }

    /// One-sided power spectral density of what the noise causes, output squared per Hz, at `frequency_hz`.
    pub fn noise_density(&self, frequency_hz: f64) -> f64 {
        let shift = self.shift(frequency_hz);
        let shape = evaluate(&self.c, shift) / evaluate(&self.a, shift);
        2.0 * self.noise_variance / self.rate_hz * shape.norm_sqr()
    }

    /// Output over input at `frequency_hz`.
    pub fn response(&self, frequency_hz: f64) -> Complex {
        let shift = self.shift(frequency_hz);
        let delay = self.family.orders().delay;
        let top: Complex = (self.b.iter().enumerate())
            .map(|(j, &b)| power(shift, delay + j) * b)
            .sum();
        top / (evaluate(&self.a, shift) * evaluate(&self.f, shift))
    }

    /// Modes: roots z of A (of F, for output errors) above the real axis as poles `rate · ln z`, by rising frequency, with the
    /// covariance that the coefficients give them to first order. Shapes are empty.
    ///
    /// # Errors
    /// `NoConvergence` of the roots.
    pub fn modes(&self) -> Result<Vec<ModalParameters>, Error> {
        let of_f = self.a.is_empty();
        let first = if of_f {
            self.a.len() + self.b.len() + self.c.len()
        } else {
            0
        };
        let coefficients = if of_f { &self.f } else { &self.a };
        modes_of(coefficients, &self.covariance, first, self.rate_hz)
    }

    /// Weight of each of [`PolynomialModel::modes`] in the model's response to white noise (of the input, where it has one), by two shares
    /// from 0 to 1: of the power, `|c_j|/Σ|c|` with the autocovariance `Σ c_j z_j^k`; and of the response at the mode's own frequency,
    /// where a resonance outweighs all else and a root that only fills up the polynomial does not.
    ///
    /// # Errors
    /// `NoConvergence` of the roots.
    pub fn mode_shares(&self) -> Result<Vec<ModeShares>, Error> {
        let bottom = if self.a.is_empty() { &self.f } else { &self.a };
        let top: Vec<f64> = match self.b.is_empty() {
            true => std::iter::once(1.0).chain(self.c.iter().copied()).collect(),
            false => self.b.clone(),
        };
        let n = bottom.len();
        let sum = |c: &[f64], x: Complex| {
            (c.iter().rev()).fold(Complex::new(0.0, 0.0), |sum, &c| sum * x + c)
        };
        let roots = roots(bottom)?;
        // Residue of H(z) at a root: z^n N(1/z)/d′(z).
        let residue = |z: Complex| {
            let one = Complex::new(1.0, 0.0);
            let others = roots.iter().filter(|r| **r != z);
            power(z, n) * sum(&top, z.inv()) / others.fold(one, |p, r| p * (z - r))
        };
        let weights: Vec<Complex> = roots
            .iter()
            .map(|&z| residue(z) * sum(&top, z) / (evaluate(bottom, z) * z))
            .collect();
        let total: f64 = weights.iter().map(|c| c.norm()).sum();
        let mut all: Vec<(f64, ModeShares)> = (roots.iter().zip(&weights))
            .filter(|(z, _)| z.im > 0.0)
            .map(|(&z, c)| {
                let circle = z / z.norm();
                let own = (residue(z) / (circle - z)).norm();
                let whole = (sum(&top, circle.inv()) / evaluate(bottom, circle.inv())).norm();
                let pole = Complex::new(z.norm().ln(), z.im.atan2(z.re));
                let shares = ModeShares {
                    power: 2.0 * c.norm() / total,
                    at_peak: (own / whole).min(1.0),
                };
                (pole.norm(), shares)
            })
            .collect();
        sort_rising(&mut all, |a| a.0);
        Ok(all.into_iter().map(|a| a.1).collect())
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

/// Weight of a mode in a model.
#[derive(Debug, Clone, Copy)]
pub struct ModeShares {
    /// Share of the power.
    pub power: f64,
    /// Share of the response at the mode's own frequency.
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

/// An input is needed and there is none.
pub(super) fn no_input() -> Error {
    Error::new(
        Code::NoSignal,
        "the model has an input and the record has none",
    )
    .with_hint("give the input channel, or fit a family without one: AR or ARMA")
}

/// The polynomials, for computing.
#[derive(Debug, Clone, Copy)]
pub(super) struct PolynomialRefs<'a> {
    pub a: &'a [f64],
    pub b: &'a [f64],
    pub c: &'a [f64],
    pub f: &'a [f64],
    pub delay: usize,
}

/// Errors of the one-step predictions, and the undisturbed output `w = B/F u` behind them.
pub(super) struct Prediction {
    pub errors: Vec<f64>,
    pub undisturbed: Vec<f64>,
    pub first: usize,
}

/// `e = (A y − w)/C` from the first sample with a full past on, with `e = 0` before it.
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
        undisturbed,
        first,
    }
}

/// `1 + c₁x + c₂x² + …`.
fn evaluate(c: &[f64], x: Complex) -> Complex {
    let one = Complex::new(1.0, 0.0);
    (c.iter().rev()).fold(Complex::new(0.0, 0.0), |sum, &c| (sum + c) * x) + one
}

fn power(x: Complex, n: usize) -> Complex {
    (0..n).fold(Complex::new(1.0, 0.0), |product, _| product * x)
}

/// Modes of `z^n + a₁z^{n−1} + … + a_n`, whose coefficients have the covariance that starts at `first`.
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
            let known = sums.iter().all(|x| x.is_finite());
            ModalParameters {
                pole: Complex::new(z.norm().ln(), z.im.atan2(z.re)) * rate_hz,
                pole_covariance: known.then_some(sums),
                shape: Vec::new(),
            }
        })
        .collect();
    sort_rising(&mut modes, |a| a.pole.norm());
    Ok(modes)
}

/// `ds/da_k` for k from 1 to n.
fn sensitivities(a: &[f64], z: Complex, rate_hz: f64) -> Vec<Complex> {
    let n = a.len();
    let zero = Complex::new(0.0, 0.0);
    // Horner for P and P′ together.
    let (_, slope) = std::iter::once(&1.0)
        .chain(a)
        .fold((zero, zero), |(p, slope), &a| (p * z + a, slope * z + p));
    let scale = slope.inv() * -rate_hz;
    // z^{n−k−1}, from k = n (1/z) down to k = 1.
    let mut powers = vec![zero; n];
    let mut next = z.inv();
    for k in (0..n).rev() {
        powers[k] = next * scale;
        next *= z;
    }
    powers
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sensitivities agree with central differences of the pole.
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
