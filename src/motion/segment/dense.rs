//! Propagation by matrix exponentials for nearly defective systems.
//!
//! `ẋ = A x + β₀ + β₁ τ + Σ Re(b e^{iωt})`. The exponential of the system augmented by its inputs gives the step over 2^v s, and
//! any τ is a sum of powers of two.

use std::cell::RefCell;
use std::collections::BTreeMap;

use crate::base::error::Error;
use crate::numeric::{Complex, Matrix, expm, symmetric};

/// Linear system with its state matrix and harmonic inputs.
#[derive(Debug, Clone)]
pub struct DenseSystem {
    /// State matrix A in scaled states, 1/s.
    matrix: Matrix,
    /// Frequency ω, rad/s, and input vector b of every harmonic.
    harmonics: Vec<(f64, Vec<Complex>)>,
    /// Largest eigenvalue of `(A + Aᵀ)/2`, at least zero, 1/s: `‖e^{Aτ}‖ ≤ e^{log_norm τ}`.
    log_norm: f64,
    /// Norm ‖A‖₂, 1/s.
    norm: f64,
    /// Cached propagators over 2^v s.
    cache: RefCell<BTreeMap<i32, Matrix>>,
}

/// Trajectory of the dense system.
#[derive(Debug, Clone)]
pub struct DenseTrajectory {
    /// Augmented initial state: x, β₀, β₁ and the cosines and sines of the harmonics.
    start: Vec<f64>,
    /// Length of x.
    states: usize,
    /// Bounds of |x| and |ẍ|.
    size: f64,
    bound: f64,
}

impl DenseTrajectory {
    /// Bound of |ẍ| of every state, 1/s².
    pub fn acceleration_bound(&self) -> f64 {
        self.bound
    }

    /// Bounds of |x| of every state.
    pub fn sizes(&self) -> Vec<f64> {
        vec![self.size; self.states]
    }
}

impl DenseSystem {
    /// System with the state matrix A and its harmonic inputs (ω in rad/s, b).
    ///
    /// # Errors
    /// Overflow of the state matrix.
    pub fn new(matrix: Matrix, harmonics: Vec<(f64, Vec<Complex>)>) -> Result<DenseSystem, Error> {
        let n = matrix.nrows();
        let mean = Matrix::from_fn(n, n, |i, j| 0.5 * (matrix[(i, j)] + matrix[(j, i)]));
        let largest = symmetric::symmetric_eigen(&mean)?.values.last().copied();
        Ok(DenseSystem {
            norm: matrix.norm_l2(),
            log_norm: largest.unwrap_or(0.0).max(0.0),
            matrix,
            harmonics,
            cache: RefCell::default(),
        })
    }

    /// Number of states.
    pub fn count(&self) -> usize {
        self.matrix.nrows()
    }

    /// Bound of the growth rate of the norm of a state, 1/s.
    pub fn growth(&self) -> f64 {
        self.log_norm
    }

    /// Norm ‖A‖₂, 1/s, a bound of every rate.
    pub fn norm(&self) -> f64 {
        self.norm
    }

    /// Row vector product `c A`.
    pub fn rate_of(&self, c: &[f64], out: &mut [f64]) {
        for j in 0..self.count() {
            out[j] = (0..self.count()).map(|i| c[i] * self.matrix[(i, j)]).sum();
        }
    }

    /// Trajectory from x under `β₀ + β₁ τ` over at most `span`, s; `phasors` holds `e^{iωt₀}`.
    pub fn start(
        &self,
        (x, b0, b1): (&[f64], &[f64], &[f64]),
        phasors: &[Complex],
        span: f64,
    ) -> DenseTrajectory {
        let n = self.count();
        let mut start = Vec::with_capacity(3 * n + 2 * phasors.len());
        start.extend_from_slice(&x[..n]);
        start.extend_from_slice(&b0[..n]);
        start.extend_from_slice(&b1[..n]);
        phasors.iter().for_each(|z| start.extend([z.re, z.im]));
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let harmonic = |power: i32| -> f64 {
            let size = |(omega, b): &(f64, Vec<Complex>)| {
                omega.abs().powi(power) * b.iter().map(Complex::norm_sqr).sum::<f64>().sqrt()
            };
            self.harmonics.iter().map(size).sum()
        };
        // ẍ = A ẋ + ḃ, which bounds the growth of ẋ as well.
        let rate = self.norm * norm(&x[..n]) + norm(&b0[..n]) + harmonic(0);
        let input_rate = norm(&b1[..n]) + harmonic(1);
        DenseTrajectory {
            start,
            states: n,
            size: norm(&x[..n]) + rate * span,
            bound: self.norm * (rate + input_rate * span) + input_rate,
        }
    }

    /// State x after the time τ, s.
    pub fn state_at(&self, trajectory: &DenseTrajectory, tau: f64, out: &mut [f64]) {
        let n = self.count();
        let mut state = trajectory.start.clone();
        let mut rest = tau;
        while rest > 0.0 {
            // Largest power of two up to the remaining time.
            let power = exponent(rest);
            let step = f64::from(power).exp2();
            if !self.step(power, &mut state) {
                state.fill(f64::NAN);
                break;
            }
            for i in 0..n {
                state[n + i] += step * state[2 * n + i];
            }
            rest -= step;
        }
        out.copy_from_slice(&state[..n]);
    }

    /// Propagates the state over 2^power s, except β₀; false on overflow.
    fn step(&self, power: i32, state: &mut [f64]) -> bool {
        let mut cache = self.cache.borrow_mut();
        let e = match cache.get(&power) {
            Some(e) => e,
            None => match self.exponential(f64::from(power).exp2()) {
                Ok(e) => cache.entry(power).or_insert(e),
                Err(_) => return false,
            },
        };
        let n = self.count();
        let next = |i: usize| -> f64 { (0..e.ncols()).map(|j| e[(i, j)] * state[j]).sum() };
        let x: Vec<f64> = (0..n).map(next).collect();
        let harmonics: Vec<f64> = (0..self.harmonics.len())
            .flat_map(|f| {
                let (rows, col) = (n + 2 * f, 3 * n + 2 * f);
                let row = |i: usize| e[(i, col)] * state[col] + e[(i, col + 1)] * state[col + 1];
                [row(rows), row(rows + 1)]
            })
            .collect();
        state[..n].copy_from_slice(&x);
        state[3 * n..].copy_from_slice(&harmonics);
        true
    }

    /// Rows of x and of the harmonics of the exponential over the step h, s.
    fn exponential(&self, h: f64) -> Result<Matrix, Error> {
        let n = self.count();
        let size = 3 * n + 2 * self.harmonics.len();
        let mut a = Matrix::zeros(size, size);
        for i in 0..n {
            (0..n).for_each(|j| a[(i, j)] = h * self.matrix[(i, j)]);
            a[(i, n + i)] = h;
            a[(n + i, 2 * n + i)] = h;
            for (f, (_, b)) in self.harmonics.iter().enumerate() {
                a[(i, 3 * n + 2 * f)] = h * b[i].re;
                a[(i, 3 * n + 2 * f + 1)] = -h * b[i].im;
            }
        }
        for (f, (omega, _)) in self.harmonics.iter().enumerate() {
            let row = 3 * n + 2 * f;
            a[(row, row + 1)] = -h * omega;
            a[(row + 1, row)] = h * omega;
        }
        let e = expm::expm(&a)?;
        Ok(Matrix::from_fn(
            n + 2 * self.harmonics.len(),
            size,
            |i, j| e[(if i < n { i } else { 2 * n + i }, j)],
        ))
    }
}

/// Largest v with `2^v ≤ x`.
fn exponent(x: f64) -> i32 {
    let guess = x.log2().floor() as i32;
    match f64::from(guess).exp2() > x {
        true => guess - 1,
        false if f64::from(guess + 1).exp2() <= x => guess + 1,
        false => guess,
    }
}
