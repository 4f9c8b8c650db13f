//! Propagation by matrix exponentials where eigenvectors nearly coincide.
//!
//! `ẋ = A x + β₀ + β₁ τ + Σ Re(b e^{iωt})`; one exponential of the machine with its forces as further states gives the
//! step over 2^v s, and any τ is a sum of powers of two.

use std::cell::RefCell;
use std::collections::BTreeMap;

use crate::base::error::Error;
use crate::numeric::{Complex, Matrix, expm, symmetric};

/// A machine as a matrix.
#[derive(Debug, Clone)]
pub struct DenseSystem {
    /// A in states of like size.
    matrix: Matrix,
    /// ω and the force `b` of every harmonic.
    harmonics: Vec<(f64, Vec<Complex>)>,
    /// The greatest eigenvalue of `(A + Aᵀ)/2`: `‖e^{Aτ}‖ ≤ e^{growth τ}`.
    log_norm: f64,
    /// ‖A‖.
    norm: f64,
    /// Steps over 2^v s, made when wanted.
    steps: RefCell<BTreeMap<i32, Matrix>>,
}

/// Trajectory of the dense system.
#[derive(Debug, Clone)]
pub struct DenseTrajectory {
    /// x, β₀, β₁ and the harmonics' cosines and sines.
    start: Vec<f64>,
    /// Number of these that are x.
    states: usize,
    /// Bounds on |x| and |ẍ|.
    size: f64,
    bound: f64,
}

impl DenseTrajectory {
    /// The bound on |ẍ| of every state.
    pub fn acceleration_bound(&self) -> f64 {
        self.bound
    }

    /// Bounds on |x| of every state.
    pub fn sizes(&self) -> Vec<f64> {
        vec![self.size; self.states]
    }
}

impl DenseSystem {
    /// A machine and the harmonics that push it.
    ///
    /// # Errors
    /// Numbers out of range.
    pub fn new(matrix: Matrix, harmonics: Vec<(f64, Vec<Complex>)>) -> Result<DenseSystem, Error> {
        let n = matrix.nrows();
        let half = Matrix::from_fn(n, n, |i, j| 0.5 * (matrix[(i, j)] + matrix[(j, i)]));
        let growth = symmetric::symmetric_eigen(&half)?.values.last().copied();
        Ok(DenseSystem {
            norm: matrix.norm_l2(),
            log_norm: growth.unwrap_or(0.0).max(0.0),
            matrix,
            harmonics,
            steps: RefCell::default(),
        })
    }

    /// Number of states.
    pub fn count(&self) -> usize {
        self.matrix.nrows()
    }

    /// Largest growth rate of the norm of a state, 1/s.
    pub fn growth(&self) -> f64 {
        self.log_norm
    }

    /// ‖A‖, 1/s: no rate exceeds it.
    pub fn norm(&self) -> f64 {
        self.norm
    }

    /// c A.
    pub fn rate_of(&self, c: &[f64], out: &mut [f64]) {
        for j in 0..self.count() {
            out[j] = (0..self.count()).map(|i| c[i] * self.matrix[(i, j)]).sum();
        }
    }

    /// From x under `β₀ + β₁ τ`; `turns` holds `e^{iωt₀}`.
    pub fn start(
        &self,
        (x, b0, b1): (&[f64], &[f64], &[f64]),
        turns: &[Complex],
        span: f64,
    ) -> DenseTrajectory {
        let n = self.count();
        let mut start = Vec::with_capacity(3 * n + 2 * turns.len());
        start.extend_from_slice(&x[..n]);
        start.extend_from_slice(&b0[..n]);
        start.extend_from_slice(&b1[..n]);
        turns
            .iter()
            .for_each(|turn| start.extend([turn.re, turn.im]));
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let harmonic = |power: i32| -> f64 {
            let size = |(omega, b): &(f64, Vec<Complex>)| {
                omega.abs().powi(power) * b.iter().map(Complex::norm_sqr).sum::<f64>().sqrt()
            };
            self.harmonics.iter().map(size).sum()
        };
        // ẍ = A ẋ + ḃ, and ẋ itself obeys ẋ′ = A ẋ + ḃ: it grows from its first value by what ḃ adds.
        let rate = self.norm * norm(&x[..n]) + norm(&b0[..n]) + harmonic(0);
        let change = norm(&b1[..n]) + harmonic(1);
        DenseTrajectory {
            start,
            states: n,
            size: norm(&x[..n]) + rate * span,
            bound: self.norm * (rate + change * span) + change,
        }
    }

    /// x after τ.
    pub fn state_at(&self, run: &DenseTrajectory, tau: f64, out: &mut [f64]) {
        let n = self.count();
        let mut state = run.start.clone();
        let mut left = tau;
        while left > 0.0 {
            // The largest power of two in what is left.
            let power = exponent(left);
            let step = f64::from(power).exp2();
            if !self.step(power, &mut state) {
                state.fill(f64::NAN);
                break;
            }
            for i in 0..n {
                state[n + i] += step * state[2 * n + i];
            }
            left -= step;
        }
        out.copy_from_slice(&state[..n]);
    }

    /// Over 2^power s, all but β₀.
    fn step(&self, power: i32, state: &mut [f64]) -> bool {
        let mut steps = self.steps.borrow_mut();
        let made = match steps.get(&power) {
            Some(made) => made,
            None => match self.make(f64::from(power).exp2()) {
                Ok(made) => steps.entry(power).or_insert(made),
                Err(_) => return false,
            },
        };
        let n = self.count();
        let next = |i: usize| -> f64 { (0..made.ncols()).map(|j| made[(i, j)] * state[j]).sum() };
        let x: Vec<f64> = (0..n).map(next).collect();
        let turned: Vec<f64> = (0..self.harmonics.len())
            .flat_map(|f| {
                let (rows, at) = (n + 2 * f, 3 * n + 2 * f);
                let row = |i: usize| made[(i, at)] * state[at] + made[(i, at + 1)] * state[at + 1];
                [row(rows), row(rows + 1)]
            })
            .collect();
        state[..n].copy_from_slice(&x);
        state[3 * n..].copy_from_slice(&turned);
        true
    }

    /// The rows of x and of the harmonics of the exponential over h.
    fn make(&self, h: f64) -> Result<Matrix, Error> {
        let n = self.count();
        let all = 3 * n + 2 * self.harmonics.len();
        let mut a = Matrix::zeros(all, all);
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
            let at = 3 * n + 2 * f;
            a[(at, at + 1)] = -h * omega;
            a[(at + 1, at)] = h * omega;
        }
        let e = expm::expm(&a)?;
        Ok(Matrix::from_fn(
            n + 2 * self.harmonics.len(),
            all,
            |i, j| e[(if i < n { i } else { 2 * n + i }, j)],
        ))
    }
}

/// The largest v with `2^v ≤ x`.
fn exponent(x: f64) -> i32 {
    let near = x.log2().floor() as i32;
    match f64::from(near).exp2() > x {
        true => near - 1,
        false if f64::from(near + 1).exp2() <= x => near + 1,
        false => near,
    }
}
