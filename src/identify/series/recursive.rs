//! Recursive least squares for ARX, exponential forgetting `λ^k`, square-root form (Givens).
//!
//! The triangle of the weighted rows is kept up to date by Givens rotations (Gentleman, J. Inst. Maths Applics 12 (1973); Haykin,
//! Adaptive Filter Theory, 4th ed. (2002), §12.2), which cannot lose definiteness however long it runs; a sample costs about `3n²`.

use super::model::{ModelStructure, PolynomialModel};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::identify::validation::check_rate;
use crate::numeric::Matrix;
use crate::numeric::factorisations::solve_from_r;

/// Model structure and forgetting factor of the recursion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecursiveOptions {
    /// Coefficients of A.
    pub a: usize,
    /// Coefficients of B; 0 without an input.
    pub b: usize,
    /// Samples from input to output.
    pub delay: usize,
    /// λ: what is left of a sample's weight one sample later, at most 1 (nothing forgotten). The memory is `1/(1 − λ)` samples.
    pub forgetting: f64,
    /// Sample rate, Hz.
    pub rate_hz: f64,
}

impl RecursiveOptions {
    /// The polynomials followed: AR without an input, ARX with one.
    pub fn structure(&self) -> ModelStructure {
        let RecursiveOptions { a, b, delay, .. } = *self;
        match b {
            0 => ModelStructure::Ar { a },
            _ => ModelStructure::Arx { a, b, delay },
        }
    }
}

/// Coefficients that follow the samples.
#[derive(Debug, Clone)]
pub struct RecursiveLeastSquares {
    options: RecursiveOptions,
    /// Triangle of the weighted `[φ y]`.
    triangle: Matrix,
    row: Vec<f64>,
    /// Latest first.
    outputs: Vec<f64>,
    inputs: Vec<f64>,
    count: usize,
    theta: Vec<f64>,
    /// `Σ λ^k` and `Σ λ^2k`.
    weights: [f64; 2],
}

impl RecursiveLeastSquares {
    /// A model that knows nothing yet. Samples should come without their mean.
    ///
    /// # Errors
    /// `OutOfRange` for a rate that is not positive, no coefficient of A, or forgetting outside ]0, 1].
    pub fn new(options: RecursiveOptions) -> Result<RecursiveLeastSquares, Error> {
        check_rate(options.rate_hz)?;
        if options.a == 0 {
            return Err(Error::new(
                Code::OutOfRange,
                "a recursive model of order 0 follows nothing",
            )
            .with_hint("give an order of 1 or more; two per mode is the least"));
        }
        let forgetting = options.forgetting;
        if !(forgetting > 0.0 && forgetting <= 1.0) {
            return Err(Error::new(
                Code::OutOfRange,
                format!("the forgetting factor is {forgetting}"),
            )
            .with_hint("take 1 − 1/m for a memory of m samples: 0.999 for 1000"));
        }
        let size = options.a + options.b;
        Ok(RecursiveLeastSquares {
            triangle: Matrix::zeros(size + 1, size + 1),
            row: vec![0.0; size + 1],
            outputs: vec![0.0; options.a],
            inputs: vec![0.0; options.b + options.delay],
            count: 0,
            theta: vec![0.0; size],
            weights: [0.0; 2],
            options,
        })
    }

    /// Takes one sample of input and output; the error with which the model so far predicted the output. `input` is not read where B
    /// has no coefficient.
    ///
    /// # Errors
    /// `NotANumber` for a sample that is not finite; the model stays as it was.
    pub fn push(&mut self, input: f64, output: f64) -> Result<f64, Error> {
        let RecursiveOptions { a, b, delay, .. } = self.options;
        if !(output.is_finite() && (input.is_finite() || b == 0)) {
            return Err(Error::new(
                Code::NotANumber,
                format!("sample {} is {output} with input {input}", self.count),
            )
            .with_hint("skip gaps: start a new model behind them"));
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
        self.count += 1;
        if self.count > a.max(delay + b.max(1) - 1) {
            self.rotate();
            // Before as many rows as unknowns the triangle is singular, and the last answer (zero) stands.
            if self.count > 2 * size
                && let Some(theta) = back_substituted(&self.triangle, size)
            {
                self.theta = theta;
            }
        }
        Ok(output - predicted)
    }

    /// `a₁, a₂, …`.
    pub fn a(&self) -> &[f64] {
        &self.theta[..self.options.a]
    }

    /// `b₀, b₁, …`.
    pub fn b(&self) -> &[f64] {
        &self.theta[self.options.a..]
    }

    /// The model as it is now, with the covariance that white noise and the memory's length give its coefficients.
    ///
    /// # Errors
    /// `TooShort` before there are enough samples; `IllPosed` where the samples in memory do not determine the coefficients.
    pub fn model(&self) -> Result<PolynomialModel, Error> {
        let size = self.theta.len();
        if self.count <= 2 * size {
            return Err(Error::new(
                Code::TooShort,
                format!("{} samples so far, for {size} unknowns", self.count),
            )
            .with_hint(format!("use it after more than {} samples", 2 * size)));
        }
        let found = solve_from_r(&self.triangle)?;
        let [w1, w2] = self.weights;
        let variance = found.residual_square / w1;
        Ok(PolynomialModel {
            family: self.options.structure(),
            a: self.a().to_vec(),
            b: self.b().to_vec(),
            c: Vec::new(),
            f: Vec::new(),
            noise_variance: variance,
            covariance: Matrix::from_fn(size, size, |i, j| {
                found.inverse[(i, j)] * variance * w2 / w1
            }),
            output_mean: 0.0,
            input_mean: 0.0,
            samples: self.count,
            rate_hz: self.options.rate_hz,
            iterations: 0,
        })
    }

    /// Ages the triangle and rotates the row into it.
    fn rotate(&mut self) {
        let n = self.row.len();
        let forgetting = self.options.forgetting;
        let age = forgetting.sqrt();
        self.weights[0] = self.weights[0] * forgetting + 1.0;
        self.weights[1] = self.weights[1] * forgetting * forgetting + 1.0;
        for i in 0..n {
            for j in i..n {
                self.triangle[(i, j)] *= age;
            }
            let (r, x) = (self.triangle[(i, i)], self.row[i]);
            let length = r.hypot(x);
            if length == 0.0 {
                continue;
            }
            let (cos, sin) = (r / length, x / length);
            for j in i..n {
                let (r, x) = (self.triangle[(i, j)], self.row[j]);
                self.triangle[(i, j)] = cos * r + sin * x;
                self.row[j] = cos * x - sin * r;
            }
        }
    }
}

/// The newest in front, the oldest gone.
fn shift_in(past: &mut [f64], newest: f64, length: usize) {
    past.copy_within(..length - 1, 1);
    past[0] = newest;
}

/// `R⁻¹ z`; nothing where a pivot is zero.
fn back_substituted(r: &Matrix, n: usize) -> Option<Vec<f64>> {
    let mut x: Vec<f64> = r.col_as_slice(n)[..n].to_vec();
    for i in (0..n).rev() {
        x[i] /= r[(i, i)];
        let value = x[i];
        let above = &r.col_as_slice(i)[..i];
        (x[..i].iter_mut().zip(above)).for_each(|(x, r)| *x -= value * r);
    }
    x.iter().all(|x| x.is_finite()).then_some(x)
}
