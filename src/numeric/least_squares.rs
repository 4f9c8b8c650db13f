//! Least squares `min ‖A x − b‖` by Householder QR with unit columns; related factorisations.
//!
//! Golub & Van Loan, Matrix Computations, 4th ed. (2013), §5.3; the scaling of columns: van der Sluis, Numer. Math. 14 (1969).

use faer::linalg::solvers::SolveLstsqCore;

use super::symmetric::right_svd;
use super::{Complex, ComplexMatrix, Matrix, check_finite, registers};
use crate::base::code::Code;
use crate::base::error::Error;

/// A pivot below this share of a unit column: it lies in the span of those before it, and its unknown means nothing.
const DEPENDENT: f64 = 1e-15;

/// Columns X with `‖A X − B‖` least; A has at least as many rows as columns.
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
    // A column of zeros has become NaN here, and is caught as well.
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

/// R of `A = Q R`: with `‖R x‖ = ‖A x‖` for every x, in no more rows than columns.
pub fn qr_r(a: &Matrix) -> Matrix {
    if a.nrows() <= a.ncols() {
        return a.clone();
    }
    let r = a.qr().thin_R().to_owned();
    registers::zero_upper();
    r
}

/// `A − Q Qᵀ A`: what the orthonormal columns of Q do not reach.
pub fn project_out(q: &Matrix, a: &Matrix) -> Matrix {
    let along = q.transpose() * a;
    let rest = a - q * along;
    registers::zero_upper();
    rest
}

/// The unit x with `‖A x‖` least, and that least.
///
/// # Errors
/// `NoConvergence`; `Overflow` where an entry is not finite.
pub fn smallest_singular(a: &Matrix) -> Result<(Vec<f64>, f64), Error> {
    let n = a.ncols();
    let mut square = Matrix::zeros(a.nrows().max(n), n); // full rows, so that every right vector is there
    (0..n).for_each(|j| square.col_as_slice_mut(j)[..a.nrows()].copy_from_slice(a.col_as_slice(j)));
    let (values, vectors) = right_svd(&square)?;
    Ok((
        vectors.col_as_slice(n - 1).to_vec(),
        values.last().copied().unwrap_or(0.0),
    ))
}

/// `A = L R` with as few columns of L as its rank, counting singular values above `negligible` times the largest.
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
        let one = ComplexMatrix::from_fn(rank, 1, |_, _| Complex::ONE);
        return Ok((ComplexMatrix::from_fn(rows, rank, |i, j| a[(i, j)]), one));
    }
    let found = a.thin_svd();
    registers::zero_upper();
    let found = found.map_err(|_| {
        let message =
            format!("the singular values of a complex {rows}×{columns} matrix did not settle");
        Error::new(Code::NoConvergence, message)
    })?;
    let values = found.S().column_vector();
    let floor = negligible * values.iter().map(|x| x.norm()).fold(0.0, f64::max);
    let rank = values.iter().filter(|x| x.norm() > floor).count();
    let left = ComplexMatrix::from_fn(rows, rank, |i, j| found.U()[(i, j)] * values[j]);
    let right = ComplexMatrix::from_fn(rank, columns, |i, j| found.V()[(j, i)].conj());
    Ok((left, right))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Consistent equations with columns 1e-12 to 1e12 in size give the unknowns they were made from.
    #[test]
    fn exact_badly_scaled_columns() {
        let mut rng = fastrand::Rng::with_seed(5);
        let a = Matrix::from_fn(30, 4, |_, j| {
            (rng.f64() - 0.5) * 10f64.powi(8 * j as i32 - 12)
        });
        let x = Matrix::from_fn(4, 2, |i, j| {
            10f64.powi(12 - 8 * i as i32) * (1 + i + j) as f64
        });
        let found = solve(&a, &(&a * &x)).unwrap();
        for (i, j) in (0..4).flat_map(|i| (0..2).map(move |j| (i, j))) {
            assert!((found[(i, j)] / x[(i, j)] - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn refuses_dependent_columns() {
        let twice = Matrix::from_fn(5, 2, |i, j| (i * (j + 1)) as f64);
        assert_eq!(
            solve(&twice, &Matrix::zeros(5, 1)).unwrap_err().code,
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

    /// A complex matrix of rank two comes back from two columns.
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

    /// `[1 −1]` annihilates what is equal in both columns; `Q Qᵀ` is reached, what is next to it is kept by its triangle.
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
        let left = project_out(&q, &b);
        assert!((q.transpose() * &left).norm_max() < 1e-12);
        let r = qr_r(&left);
        assert!((r.norm_l2() / left.norm_l2() - 1.0).abs() < 1e-14);
    }
}
