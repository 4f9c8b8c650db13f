//! Least squares `min ‖A x − b‖` by Householder QR with unit columns; related factorisations.
//!
//! Golub & Van Loan, Matrix Computations, 4th ed. (2013), §5.3; the scaling of columns: van der Sluis, Numer. Math. 14 (1969).

use faer::linalg::solvers::SolveLstsqCore;

use super::symmetric::right_svd;
use super::{Complex, ComplexMatrix, Matrix, check_finite, registers};
use crate::base::code::Code;
use crate::base::error::Error;

/// Pivot of a unit column below which it depends linearly on the earlier columns.
const DEPENDENT: f64 = 1e-15;

/// Least-squares solution X that minimises `‖A X − B‖`; A has at least as many rows as columns.
///
/// # Errors
/// `Overflow` where an entry is not finite; `IllPosed` where columns of A depend on each other or are too many.
pub fn solve(a: &Matrix, b: &Matrix) -> Result<Matrix, Error> {
    check_finite(a, "a least-squares problem")?;
    check_finite(b, "a least-squares right side")?;
    let (rows, n) = (a.nrows(), a.ncols());
    if rows < n {
        let message = format!("{rows} equations do not determine {n} unknowns");
        return Err(Error::new(Code::IllPosed, message));
    }
    if n == 0 {
        return Ok(Matrix::zeros(0, b.ncols()));
    }
    let mut scaled = a.clone();
    let lengths: Vec<f64> = (0..n).map(|j| a.col(j).norm_l2()).collect();
    for (j, length) in lengths.iter().enumerate() {
        let column = scaled.col_as_slice_mut(j);
        column.iter_mut().for_each(|x| *x /= length);
    }
    let qr = scaled.qr();
    registers::zero_upper();
    let r = qr.thin_R();
    // A zero column is NaN after scaling and is detected as well.
    if let Some(j) = (0..n)
        .find(|&j| r[(j, j)].abs().partial_cmp(&DEPENDENT) != Some(std::cmp::Ordering::Greater))
    {
        let message = format!(
            "column {j} of a least-squares problem with {n} unknowns depends on those before it"
        );
        return Err(Error::new(Code::IllPosed, message));
    }
    let mut x = b.clone();
    qr.solve_lstsq_in_place_with_conj(faer::Conj::No, x.as_mut());
    registers::zero_upper();
    Ok(Matrix::from_fn(n, b.ncols(), |i, j| x[(i, j)] / lengths[i]))
}

/// Orthonormal columns Q of `A = Q R`; A has at least as many rows as columns.
pub fn orthonormal_basis(a: &Matrix) -> Matrix {
    if a.ncols() == 0 {
        return a.clone();
    }
    let q = a.qr().compute_thin_Q();
    registers::zero_upper();
    q
}

/// Triangular factor R of `A = Q R`: `‖R x‖ = ‖A x‖` for every x; A itself if it has no more rows than columns.
pub fn qr_r(a: &Matrix) -> Matrix {
    if a.nrows() <= a.ncols() {
        return a.clone();
    }
    let r = a.qr().thin_R().to_owned();
    registers::zero_upper();
    r
}

/// Component of A orthogonal to the orthonormal columns of Q, `A − Q Qᵀ A`.
pub fn project_out(q: &Matrix, a: &Matrix) -> Matrix {
    let coefficients = q.transpose() * a;
    let residual = a - q * coefficients;
    registers::zero_upper();
    residual
}

/// Right singular vector x of the smallest singular value, `‖x‖ = 1`, and the value `‖A x‖`.
///
/// # Errors
/// `NoConvergence`; `Overflow` where an entry is not finite.
pub fn smallest_singular(a: &Matrix) -> Result<(Vec<f64>, f64), Error> {
    let n = a.ncols();
    let mut padded = Matrix::zeros(a.nrows().max(n), n); // at least n rows: the thin SVD then has all right vectors
    (0..n).for_each(|j| padded.col_as_slice_mut(j)[..a.nrows()].copy_from_slice(a.col_as_slice(j)));
    let (values, vectors) = right_svd(&padded)?;
    Ok((
        vectors.col_as_slice(n - 1).to_vec(),
        values.last().copied().unwrap_or(0.0),
    ))
}

/// Rank factorisation `A = L R`; the rank counts the singular values above `negligible` times the largest.
///
/// # Errors
/// `NoConvergence`.
pub fn rank_factorisation(
    a: &ComplexMatrix,
    negligible: f64,
) -> Result<(ComplexMatrix, ComplexMatrix), Error> {
    let (rows, columns) = (a.nrows(), a.ncols());
    if columns == 1 {
        let rank = usize::from(a.norm_max() > 0.0);
        let unit = ComplexMatrix::from_fn(rank, 1, |_, _| Complex::ONE);
        return Ok((ComplexMatrix::from_fn(rows, rank, |i, j| a[(i, j)]), unit));
    }
    let svd = a.thin_svd();
    registers::zero_upper();
    let svd = svd.map_err(|_| {
        let message =
            format!("the singular values of a complex {rows}×{columns} matrix did not converge");
        Error::new(Code::NoConvergence, message)
    })?;
    let values = svd.S().column_vector();
    let threshold = negligible * values.iter().map(|x| x.norm()).fold(0.0, f64::max);
    let rank = values.iter().filter(|x| x.norm() > threshold).count();
    let left = ComplexMatrix::from_fn(rows, rank, |i, j| svd.U()[(i, j)] * values[j]);
    let right = ComplexMatrix::from_fn(rank, columns, |i, j| svd.V()[(j, i)].conj());
    Ok((left, right))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Consistent equations with columns of size 1e-12 to 1e12 return the exact unknowns.
    #[test]
    fn exact_badly_scaled_columns() {
        let mut rng = fastrand::Rng::with_seed(5);
        let a = Matrix::from_fn(30, 4, |_, j| {
            (rng.f64() - 0.5) * 10f64.powi(8 * j as i32 - 12)
        });
        let x = Matrix::from_fn(4, 2, |i, j| {
            10f64.powi(12 - 8 * i as i32) * (1 + i + j) as f64
        });
        let solution = solve(&a, &(&a * &x)).unwrap();
        for (i, j) in (0..4).flat_map(|i| (0..2).map(move |j| (i, j))) {
            assert!((solution[(i, j)] / x[(i, j)] - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn refuses_dependent_columns() {
        let dependent = Matrix::from_fn(5, 2, |i, j| (i * (j + 1)) as f64);
        assert_eq!(
            solve(&dependent, &Matrix::zeros(5, 1)).unwrap_err().code,
            Code::IllPosed
        );
        assert_eq!(
            solve(&Matrix::zeros(5, 1), &Matrix::zeros(5, 1))
                .unwrap_err()
                .code,
            Code::IllPosed
        );
        assert_eq!(
            solve(&Matrix::zeros(1, 2), &Matrix::zeros(1, 1))
                .unwrap_err()
                .code,
            Code::IllPosed
        );
    }

    /// A complex matrix of rank two is the product of factors with two columns and two rows.
    #[test]
    fn law_factors() {
        let mut rng = fastrand::Rng::with_seed(6);
        let mut random = |rows, columns| {
            ComplexMatrix::from_fn(rows, columns, |_, _| {
                Complex::new(rng.f64() - 0.5, rng.f64() - 0.5)
            })
        };
        let a = random(5, 2) * random(2, 3);
        let (left, right) = rank_factorisation(&a, 1e-12).unwrap();
        assert_eq!(left.ncols(), 2);
        assert!((left * right - a).norm_max() < 1e-15);
    }

    /// `[1 −1]` is the null vector of two equal columns; a projected matrix is orthogonal to Q, and its R has the same norm.
    #[test]
    fn exact_smallest_and_triangle() {
        let a = Matrix::from_fn(6, 2, |i, _| i as f64);
        let (x, least) = smallest_singular(&a).unwrap();
        assert!(
            least < 1e-14 && (x[0] + x[1]).abs() < 1e-14,
            "{x:?} {least}"
        );
        let mut rng = fastrand::Rng::with_seed(7);
        let (q, b) = (
            Matrix::from_fn(20, 3, |_, _| rng.f64()),
            Matrix::from_fn(20, 2, |i, j| (i * i + j) as f64),
        );
        let q = orthonormal_basis(&q);
        let projected = project_out(&q, &b);
        assert!((q.transpose() * &projected).norm_max() < 1e-12);
        let r = qr_r(&projected);
        assert!((r.norm_l2() / projected.norm_l2() - 1.0).abs() < 1e-14);
    }
}
