//! Minimum-norm least squares `min ‖A x − b‖` for many b, by QR and SVD.
//!
//! Golub & Van Loan, Matrix Computations, 4th ed. (2013), §5.5: columns to unit length, `A = Q R`, singular values of R.

use faer::linalg::solvers::Svd;

use crate::base::code::Code;
use crate::base::error::Error;

use super::{Matrix, check_finite, registers};

/// `x` for every column of `b`. Directions whose singular value is below rounding are left out.
///
/// # Errors
/// `IllPosed` with fewer rows than columns; `Overflow` where an entry is not finite; `NoConvergence`.
pub fn lstsq(a: &Matrix, b: &Matrix) -> Result<Matrix, Error> {
    let (m, n) = (a.nrows(), a.ncols());
    if m < n || n == 0 {
        return Err(Error::new(
            Code::IllPosed,
            format!("{m} equations do not determine {n} unknowns"),
        )
        .with_hint("use more lines or fewer modes"));
    }
    check_finite(a, "a least-squares problem")?;
    check_finite(b, "the right-hand side of a least-squares problem")?;
    let length: Vec<f64> = (0..n)
        .map(|j| Some(a.col(j).norm_l2()).filter(|&l| l > 0.0).unwrap_or(1.0))
        .collect();
    let unit = Matrix::from_fn(m, n, |i, j| a[(i, j)] / length[j]);
    let qr = unit.qr();
    let reduced = qr.compute_thin_Q().transpose() * b;
    let svd = Svd::new_thin(qr.thin_R()).map_err(|_| {
        Error::new(
            Code::NoConvergence,
            format!("the singular values of a {n}×{n} factor did not converge"),
        )
    })?;
    let sizes = svd.S().column_vector();
    let negligible = m.max(n) as f64 * f64::EPSILON * sizes[0];
    let along = svd.U().transpose() * reduced;
    let weighted = Matrix::from_fn(n, b.ncols(), |i, j| {
        if sizes[i] > negligible {
            along[(i, j)] / sizes[i]
        } else {
            0.0
        }
    });
    let x = svd.V() * weighted;
    registers::zero_upper();
    Ok(Matrix::from_fn(n, b.ncols(), |i, j| x[(i, j)] / length[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The line through (0, 1), (1, 2), (2, 4) nearest in squares is 5/6 + 3/2 t; a column repeated shares its part.
    #[test]
    fn exact_line_of_best_fit() {
        let b = Matrix::from_fn(3, 1, |i, _| [1.0, 2.0, 4.0][i]);
        let a = Matrix::from_fn(3, 2, |i, j| (i as f64).powi(j as i32));
        let x = lstsq(&a, &b).unwrap();
        assert!((x[(0, 0)] - 5.0 / 6.0).abs() < 1e-15 && (x[(1, 0)] - 1.5).abs() < 1e-15);
        let a = Matrix::from_fn(3, 3, |i, j| (i as f64).powi(j.min(1) as i32));
        let x = lstsq(&a, &b).unwrap();
        assert!((x[(1, 0)] - 0.75).abs() < 1e-14 && (x[(2, 0)] - 0.75).abs() < 1e-14);
    }

    #[test]
    fn refuses_too_few_equations() {
        let found = lstsq(&Matrix::zeros(1, 2), &Matrix::zeros(1, 1));
        assert_eq!(found.unwrap_err().code, Code::IllPosed);
    }
}
