//! QR factorisation of a tall matrix row by row (R only), least squares from R, singular value decomposition.
//!
//! R is updated by Householder reflections of `[R; new rows]` (Golub & Van Loan, Matrix Computations, 4th ed. (2013), §6.5.3).

use crate::base::code::Code;
use crate::base::error::Error;

use super::{Matrix, check_finite, registers};

/// Triangular factor R of a tall matrix, updated row by row; the memory is a few times that of R for any number of rows.
#[derive(Debug, Clone)]
pub struct IncrementalQr {
    /// Factor R at the top, rows not yet factorised below.
    rows: Matrix,
    filled: usize,
}

/// Rows per update, in multiples of the number of columns, so that most reflections are blocked.
const BLOCK_FACTOR: usize = 3;

impl IncrementalQr {
    /// Factor of a matrix with `columns` columns.
    pub fn new(columns: usize) -> IncrementalQr {
        IncrementalQr {
            rows: Matrix::zeros(columns + (BLOCK_FACTOR * columns).max(64), columns),
            filled: 0,
        }
    }

    /// Adds a row; entries beyond the number of columns are ignored.
    pub fn push(&mut self, row: &[f64]) {
        if self.filled == self.rows.nrows() {
            self.update();
        }
        for (j, &x) in row.iter().enumerate().take(self.rows.ncols()) {
            self.rows[(self.filled, j)] = x;
        }
        self.filled += 1;
    }

    /// Square upper triangular R of all rows; the signs of its rows are arbitrary.
    pub fn finish(mut self) -> Matrix {
        self.update();
        let n = self.rows.ncols();
        self.rows.subrows(0, n).to_owned()
    }

    fn update(&mut self) {
        let n = self.rows.ncols();
        if n == 0 {
            return;
        }
        let rows = self.filled.max(n); // rows never written are zero
        let qr = self.rows.subrows(0, rows).qr();
        registers::zero_upper();
        let r = qr.thin_R();
        for j in 0..n {
            let column = self.rows.col_as_slice_mut(j);
            column.fill(0.0);
            (0..=j).for_each(|i| column[i] = r[(i, j)]);
        }
        self.filled = n;
    }
}

/// Least-squares solution, the minimiser of `‖A x − b‖`.
#[derive(Debug, Clone)]
pub struct LeastSquaresSolution {
    /// Solution x.
    pub solution: Vec<f64>,
    /// Residual sum of squares `‖A x − b‖²`.
    pub residual_square: f64,
    /// Inverse normal matrix `(AᵀA)⁻¹`.
    pub inverse: Matrix,
}

/// Relative tolerance of a pivot of R: a column with a smaller pivot is linearly dependent on those before it.
const MIN_PIVOT: f64 = 1e-12;

/// Solves the least-squares problem from the factor R of `[A b]`.
///
/// # Errors
/// `IllPosed` if a column of A is linearly dependent on those before it.
pub fn solve_from_r(r: &Matrix) -> Result<LeastSquaresSolution, Error> {
    let n = r.ncols().saturating_sub(1);
    for j in 0..n {
        let column = r.col_as_slice(j)[..=j].iter().map(|x| x * x).sum::<f64>();
        let pivot = r[(j, j)].abs();
        if !(pivot > MIN_PIVOT * column.sqrt()) {
            return Err(Error::new(
                Code::IllPosed,
                format!(
                    "unknown {} of {n} is linearly dependent on those before it",
                    j + 1
                ),
            )
            .with_hint("fit fewer coefficients, or use data that vary more"));
        }
    }
    let substitute = |column: &mut [f64]| {
        for i in (0..n).rev() {
            column[i] /= r[(i, i)];
            let value = column[i];
            let above = &r.col_as_slice(i)[..i];
            (column[..i].iter_mut().zip(above)).for_each(|(c, a)| *c -= value * a);
        }
    };
    let mut solution: Vec<f64> = r.col_as_slice(n)[..n].to_vec();
    substitute(&mut solution);
    let mut inverse = Matrix::identity(n, n);
    (0..n).for_each(|j| substitute(inverse.col_as_slice_mut(j)));
    Ok(LeastSquaresSolution {
        solution,
        residual_square: r[(n, n)] * r[(n, n)],
        inverse: &inverse * inverse.transpose(),
    })
}

/// Singular value decomposition `A = U diag(values) Vᵀ` with square U and V.
#[derive(Debug, Clone)]
pub struct Svd {
    /// Left singular vectors as columns.
    pub u: Matrix,
    /// Singular values in descending order, min(m, n) of them.
    pub values: Vec<f64>,
    /// Right singular vectors as columns.
    pub v: Matrix,
}

/// Computes the singular value decomposition with square U and V.
///
/// # Errors
/// `NoConvergence`; `Overflow` if an entry is not finite.
pub fn svd(a: &Matrix) -> Result<Svd, Error> {
    check_finite(a, "a matrix")?;
    let factors = a.svd();
    registers::zero_upper();
    let factors = factors.map_err(|_| {
        let (m, n) = (a.nrows(), a.ncols());
        Error::new(
            Code::NoConvergence,
            format!("the singular values of a {m}×{n} matrix did not converge"),
        )
    })?;
    Ok(Svd {
        u: factors.U().to_owned(),
        values: factors.S().column_vector().iter().copied().collect(),
        v: factors.V().to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise-free rows give the exact unknowns, and `(AᵀA)⁻¹ AᵀA = I`.
    #[test]
    fn law_rows_one_by_one() {
        let mut rng = fastrand::Rng::with_seed(7);
        let mut triangle = IncrementalQr::new(4);
        let mut gram = Matrix::zeros(3, 3);
        for _ in 0..1000 {
            let a = [rng.f64(), rng.f64() - 0.5, rng.f64() * 2.0];
            triangle.push(&[a[0], a[1], a[2], 2.0 * a[0] - 3.0 * a[1] + 0.5 * a[2]]);
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                gram[(i, j)] += a[i] * a[j];
            }
        }
        let fit = solve_from_r(&triangle.finish()).unwrap();
        for (x, expected) in fit.solution.iter().zip([2.0, -3.0, 0.5]) {
            assert!((x - expected).abs() < 1e-13);
        }
        let identity = &fit.inverse * &gram;
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            assert!((identity[(i, j)] - f64::from(u8::from(i == j))).abs() < 1e-11);
        }
    }

    #[test]
    fn refuses_a_repeated_column() {
        let mut triangle = IncrementalQr::new(3);
        (0..10).for_each(|i| triangle.push(&[f64::from(i), 2.0 * f64::from(i), 1.0]));
        let error = solve_from_r(&triangle.finish()).unwrap_err();
        assert_eq!(error.code, Code::IllPosed);
    }

    #[test]
    fn law_factors_multiply_to_the_matrix() {
        let a = Matrix::from_fn(6, 4, |i, j| ((3 * i + j * j) % 7) as f64);
        let factors = svd(&a).unwrap();
        let scaled = Matrix::from_fn(6, 4, |i, j| factors.u[(i, j)] * factors.values[j]);
        assert!((&scaled * factors.v.transpose() - &a).norm_max() < 1e-13);
        let identity = factors.u.transpose() * &factors.u;
        assert!((&identity - Matrix::identity(6, 6)).norm_max() < 1e-14);
    }
}
