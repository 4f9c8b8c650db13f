//! Recursive least squares for ARX, exponential forgetting `λ^k`, square-root form (Givens).
//!
//! The triangular factor of the weighted rows is updated by Givens rotations (Gentleman, J. Inst. Maths Applics 12 (1973); Haykin,
//! Adaptive Filter Theory, 4th ed. (2002), §12.2), which preserve definiteness for any number of samples; a sample costs about `3n²`.

use super::model::{ModelStructure, PolynomialModel};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::identify::validation::check_rate;
use crate::numeric::Matrix;
use crate::numeric::factorisations::solve_from_r;

/// Model structure and forgetting factor of the recursion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecursiveOptions {
    /// Number of coefficients of A.
    pub a: usize,
    /// Number of coefficients of B; 0 without an input.
    pub b: usize,
    /// Delay from input to output, samples.
    pub delay: usize,
    /// Forgetting factor λ, 0 to 1: the factor of a sample's weight per later sample. The memory is `1/(1 − λ)` samples.
    pub forgetting: f64,
    /// Sample rate, Hz.
    pub rate_hz: f64,
}

impl RecursiveOptions {
    /// Structure of the model: AR without an input, ARX with one.
    pub fn structure(&self) -> ModelStructure {
        let RecursiveOptions { a, b, delay, .. } = *self;
        match b {
            0 => ModelStructure::Ar { a },
            _ => ModelStructure::Arx { a, b, delay },
        }
    }
}

/// Recursive least-squares estimator of AR or ARX coefficients.
#[derive(Debug, Clone)]
pub struct RecursiveLeastSquares {
    options: RecursiveOptions,
    /// Triangular factor of the weighted rows `[φ y]`.
    r_factor: Matrix,
    row: Vec<f64>,
    /// Past outputs, latest first.
    outputs: Vec<f64>,
    inputs: Vec<f64>,
    n_samples: usize,
    theta: Vec<f64>,
    /// `Σ λ^k` and `Σ λ^2k`.
    weights: [f64; 2],
}

impl RecursiveLeastSquares {
    /// Estimator without samples. The mean of the samples should be removed beforehand.
    ///
    /// # Errors
    /// `OutOfRange` for a rate that is not positive, no coefficient of A, or forgetting outside ]0, 1].
    pub fn new(options: RecursiveOptions) -> Result<RecursiveLeastSquares, Error> {
        check_rate(options.rate_hz)?;
        if options.a == 0 {
            return Err(Error::new(
                Code::OutOfRange,
                "a recursive model of order 0 has no coefficients",
            )
            .with_hint("give an order of 1 or more; two per mode is the least"));
        }
        let forgetting = options.forgetting;
        if !(forgetting > 0.0 && forgetting <= 1.0) {
            return Err(Error::new(
                Code::OutOfRange,
                format!("the forgetting factor is {forgetting}"),
            )
            .with_hint("use 1 − 1/m for a memory of m samples: 0.999 for 1000"));
        }
        let size = options.a + options.b;
        Ok(RecursiveLeastSquares {
            r_factor: Matrix::zeros(size + 1, size + 1),
            row: vec![0.0; size + 1],
            outputs: vec![0.0; options.a],
            inputs: vec![0.0; options.b + options.delay],
            n_samples: 0,
            theta: vec![0.0; size],
            weights: [0.0; 2],
            options,
        })
    }

    /// Updates the coefficients with one sample of input and output; returns the prediction error of the output before the update. `input`
    /// is ignored if B has no coefficients.
    ///
    /// # Errors
    /// `NotANumber` for a sample that is not finite; the estimator is unchanged.
    pub fn push(&mut self, input: f64, output: f64) -> Result<f64, Error> {
        let RecursiveOptions { a, b, delay, .. } = self.options;
        if !(output.is_finite() && (input.is_finite() || b == 0)) {
            return Err(Error::new(
                Code::NotANumber,
                format!("sample {} is {output} with input {input}", self.n_samples),
            )
            .with_hint("skip gaps: start a new model after each"));
        }
        if b > 0 {
            shift_in(&mut self.inputs, input, delay + b);
        }
        (0..a).for_each(|k| self.row[k] = -self.outputs[k]);
        (0..b).for_each(|j| self.row[a + j] = self.inputs[delay + j]);
        self.row[a + b] = output;
        let size = a + b;
        let predicted: f64 = (self.row.iter().zip(&self.theta)).map(|(x, t)| x * t).sum();
        shift_in(&mut self.outputs, output, a);
        self.n_samples += 1;
        if self.n_samples > a.max(delay + b.max(1) - 1) {
            self.rotate();
            // With fewer rows than unknowns the factor is singular, and the coefficients remain zero.
            if self.n_samples > 2 * size
                && let Some(theta) = back_substitute(&self.r_factor, size)
            {
                self.theta = theta;
            }
        }
        Ok(output - predicted)
    }

    /// Coefficients `a₁, a₂, …`.
    pub fn a(&self) -> &[f64] {
        &self.theta[..self.options.a]
    }

    /// Coefficients `b₀, b₁, …`.
    pub fn b(&self) -> &[f64] {
        &self.theta[self.options.a..]
    }

    /// Current model, with the covariance of its coefficients for white noise and the length of the memory.
    ///
    /// # Errors
    /// `TooShort` before there are enough samples; `IllPosed` if the samples in memory do not determine the coefficients.
    pub fn model(&self) -> Result<PolynomialModel, Error> {
        let size = self.theta.len();
        if self.n_samples <= 2 * size {
            return Err(Error::new(
                Code::TooShort,
                format!("{} samples are too few for {size} unknowns", self.n_samples),
            )
            .with_hint(format!("use it after more than {} samples", 2 * size)));
        }
        let solution = solve_from_r(&self.r_factor)?;
        let [w1, w2] = self.weights;
        let variance = solution.residual_square / w1;
        Ok(PolynomialModel {
            family: self.options.structure(),
            a: self.a().to_vec(),
            b: self.b().to_vec(),
            c: Vec::new(),
            f: Vec::new(),
            noise_variance: variance,
            covariance: Matrix::from_fn(size, size, |i, j| {
                solution.inverse[(i, j)] * variance * w2 / w1
            }),
            output_mean: 0.0,
            input_mean: 0.0,
            samples: self.n_samples,
            rate_hz: self.options.rate_hz,
            iterations: 0,
        })
    }

    /// Applies the forgetting factor to the triangular factor and rotates the row into it.
    fn rotate(&mut self) {
        let n = self.row.len();
        let forgetting = self.options.forgetting;
        let row_factor = forgetting.sqrt();
        self.weights[0] = self.weights[0] * forgetting + 1.0;
        self.weights[1] = self.weights[1] * forgetting * forgetting + 1.0;
        for i in 0..n {
            for j in i..n {
                self.r_factor[(i, j)] *= row_factor;
            }
            let (r, x) = (self.r_factor[(i, i)], self.row[i]);
            let length = r.hypot(x);
            if length == 0.0 {
                continue;
            }
            let (cos, sin) = (r / length, x / length);
            for j in i..n {
                let (r, x) = (self.r_factor[(i, j)], self.row[j]);
                self.r_factor[(i, j)] = cos * r + sin * x;
                self.row[j] = cos * x - sin * r;
            }
        }
    }
}

/// Inserts the newest sample at the front and drops the oldest.
fn shift_in(samples: &mut [f64], newest: f64, length: usize) {
    samples.copy_within(..length - 1, 1);
    samples[0] = newest;
}

/// Solution `R⁻¹ z` by back substitution; `None` if a pivot is zero.
fn back_substitute(r: &Matrix, n: usize) -> Option<Vec<f64>> {
    let mut x: Vec<f64> = r.col_as_slice(n)[..n].to_vec();
    for i in (0..n).rev() {
        x[i] /= r[(i, i)];
        let value = x[i];
        let column = &r.col_as_slice(i)[..i];
        (x[..i].iter_mut().zip(column)).for_each(|(x, r)| *x -= value * r);
    }
    x.iter().all(|x| x.is_finite()).then_some(x)
}
