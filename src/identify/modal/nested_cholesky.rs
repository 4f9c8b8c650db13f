//! Minimum of `αᵀ M α` with last coefficient 1 for every order, from one Cholesky factor.

use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::symmetric::cholesky;

/// Added to the diagonal, relative to its mean: above the rounding of the sums, below any noise worth fitting.
const RIDGE: f64 = 1e-13;

/// Growth factor of the ridge after a failed factorisation, so many times: to 1e-7, which moves poles by less than noise ever does.
const RIDGE_GROWTH: f64 = 100.0;
const MAX_RIDGE_STEPS: usize = 3;

/// Adds `RIDGE` to the diagonal, so that what is singular but for rounding has a factor.
pub fn add_ridge(m: &mut Matrix) {
    let n = m.nrows();
    let mean = (0..n).map(|i| m[(i, i)].abs()).sum::<f64>() / n as f64;
    (0..n).for_each(|i| m[(i, i)] += RIDGE * n as f64 * mean);
}

/// Cholesky factor R of the largest order: its leading blocks factor every lower order.
pub struct NestedCholesky {
    factor: Matrix,
}

impl NestedCholesky {
    /// Factorises M, whose trace is positive.
    ///
    /// # Errors
    /// `Indefinite` where rounding leaves no positive pivot; `Overflow` where an entry is not finite.
    pub fn new(mut m: Matrix) -> Result<NestedCholesky, Error> {
        add_ridge(&mut m);
        let mut scale = 1.0;
        // Responses without noise are singular at every order above their own, and the sums round by more than the least ridge.
        for _ in 0..MAX_RIDGE_STEPS {
            if let Ok(factor) = cholesky(&m) {
                return Ok(NestedCholesky { factor });
            }
            let n = m.nrows();
            let mean = (0..n).map(|i| m[(i, i)].abs()).sum::<f64>() / n as f64;
            let next = RIDGE * n as f64 * mean;
            scale *= RIDGE_GROWTH;
            (0..n).for_each(|i| m[(i, i)] += next * scale);
        }
        Ok(NestedCholesky {
            factor: cholesky(&m).map_err(|error| {
                error.with_hint(
                    "request a lower order or a wider band: the normal equations are singular",
                )
            })?,
        })
    }

    /// `(L Lᵀ)⁻¹ x` with the leading block of L as long as x.
    pub fn solve(&self, x: &mut [f64]) {
        let n = x.len();
        for j in 0..n {
            let column = &self.factor.col_as_slice(j)[..n];
            x[j] /= column[j];
            let (known, rest) = x.split_at_mut(j + 1);
            let value = known[j];
            rest.iter_mut()
                .zip(&column[j + 1..])
                .for_each(|(x, l)| *x -= value * l);
        }
        self.solve_transposed(x);
    }

    /// Coefficients `α_0 … α_{n−1}` next to `α_n = 1`.
    pub fn monic_minimum(&self, n: usize) -> Vec<f64> {
        let mut a: Vec<f64> = (0..n).map(|j| -self.factor[(n, j)]).collect();
        self.solve_transposed(&mut a);
        a
    }

    fn solve_transposed(&self, x: &mut [f64]) {
        let n = x.len();
        for j in (0..n).rev() {
            let column = &self.factor.col_as_slice(j)[..n];
            let sum: f64 = x[j + 1..]
                .iter()
                .zip(&column[j + 1..])
                .map(|(x, l)| x * l)
                .sum();
            x[j] = (x[j] - sum) / column[j];
        }
    }
}
