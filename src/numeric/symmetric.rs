//! Symmetric and Hermitian eigenproblems `A x = λ x`, `K x = λ M x`; Cholesky `M = L Lᵀ`.
//!
//! Golub & Van Loan, Matrix Computations, 4th ed. (2013), §8.7.2 (Algorithm 8.7.1) for the pencil. Absolute errors are
//! a few ε times the largest value; for small frequencies of graded machines use `graded`.

use faer::Side;
use faer::linalg::solvers::{LltError, Solve};

use crate::base::code::Code;
use crate::base::error::Error;

use super::{ComplexMatrix, Matrix, check_finite, registers};

/// Eigenvalues and vectors of a symmetric matrix or a definite pencil.
#[derive(Debug, Clone)]
pub struct SymmetricEigen {
    /// Eigenvalues λ, ascending.
    pub values: Vec<f64>,
    /// Eigenvectors as columns in the order of the values; orthonormal, or with `φᵀ M φ = 1` for a pencil.
    pub vectors: Matrix,
}

/// Solves `A x = λ x`; only the lower triangle of `a` is read.
///
/// Errors: `Overflow` where an entry is not finite; `NoConvergence`.
pub fn symmetric_eigen(a: &Matrix) -> Result<SymmetricEigen, Error> {
    check_finite(a, "a symmetric matrix")?;
    if a.nrows() == 0 {
        return Ok(SymmetricEigen {
            values: vec![],
            vectors: a.clone(),
        }); // faer 0.24 subtracts one from n
    }
    let eigen = a.self_adjoint_eigen(Side::Lower);
    registers::zero_upper();
    let eigen = eigen.map_err(|_| {
        Error::new(
            Code::NoConvergence,
            format!(
                "the eigenvalues of a symmetric {0}×{0} matrix did not converge",
                a.nrows()
            ),
        )
    })?;
    Ok(SymmetricEigen {
        values: eigen.S().column_vector().iter().copied().collect(),
        vectors: eigen.U().to_owned(),
    })
}

/// Eigenvalues of a Hermitian matrix, ascending, and orthonormal eigenvectors as columns; only the lower triangle is read.
///
/// Errors: `Overflow` where an entry is not finite; `NoConvergence`.
pub fn hermitian_eigen(a: &ComplexMatrix) -> Result<(Vec<f64>, ComplexMatrix), Error> {
    let n = a.nrows();
    if n == 0 {
        return Ok((Vec::new(), a.clone())); // faer 0.24 subtracts one from n
    }
    if !(0..n).all(|j| (0..n).all(|i| a[(i, j)].re.is_finite() && a[(i, j)].im.is_finite())) {
        return Err(Error::new(
            Code::Overflow,
            format!("an entry of a Hermitian {n}×{n} matrix is not finite"),
        ));
    }
    let eigen = a.self_adjoint_eigen(Side::Lower);
    registers::zero_upper();
    let eigen = eigen.map_err(|_| {
        Error::new(
            Code::NoConvergence,
            format!("the eigenvalues of a Hermitian {n}×{n} matrix did not converge"),
        )
    })?;
    Ok((
        eigen
            .S()
            .column_vector()
            .iter()
            .map(|value| value.re)
            .collect(),
        eigen.U().to_owned(),
    ))
}

/// Solves `K x = λ M x` with M positive definite by `L⁻¹ K L⁻ᵀ y = λ y`, `x = L⁻ᵀ y`; K may be indefinite.
///
/// Errors: as [`symmetric_eigen`] and [`cholesky`].
pub fn generalised_symmetric_eigen(k: &Matrix, m: &Matrix) -> Result<SymmetricEigen, Error> {
    check_finite(k, "the stiffness matrix")?;
    let l = cholesky(m)?;
    let l_inv_k = solve_lower(&l, k);
    let reduced = solve_lower(&l, &l_inv_k.transpose().to_owned());
    let SymmetricEigen { values, vectors } = symmetric_eigen(&reduced)?;
    Ok(SymmetricEigen {
        values,
        vectors: solve_lower_transposed(&l, &vectors),
    })
}

/// Cholesky factor L, lower triangular, of `M = L Lᵀ`; only the lower triangle of `m` is read.
///
/// Errors: `NotPositiveDefinite` with the row whose pivot is not positive; `Overflow` where an entry is not finite.
pub fn cholesky(m: &Matrix) -> Result<Matrix, Error> {
    check_finite(m, "the mass matrix")?;
    let factor = m.llt(Side::Lower);
    registers::zero_upper();
    match factor {
        Ok(factor) => Ok(factor.L().to_owned()),
        Err(LltError::NonPositivePivot { index }) => {
            let message = format!(
                "row {index} of a {0}×{0} matrix has no positive pivot",
                m.nrows()
            );
            Err(Error::new(Code::NotPositiveDefinite, message))
        }
    }
}

/// Matrix product `A B`.
pub fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let c = a * b;
    registers::zero_upper();
    c
}

/// Solution `L⁻¹ B` for a lower triangular L.
pub fn solve_lower(l: &Matrix, b: &Matrix) -> Matrix {
    let mut x = b.clone();
    l.solve_lower_triangular_in_place(&mut x);
    registers::zero_upper();
    x
}

/// Solution `L⁻ᵀ B` for a lower triangular L.
pub fn solve_lower_transposed(l: &Matrix, b: &Matrix) -> Matrix {
    let mut x = b.clone();
    l.transpose().solve_upper_triangular_in_place(&mut x);
    registers::zero_upper();
    x
}

/// Solution `A⁻¹ B` by LU with partial pivoting.
///
/// Errors: `NotPositiveDefinite` where A is singular to working precision, with the pivot.
pub fn lu_solve(a: &Matrix, b: &Matrix) -> Result<Matrix, Error> {
    let lu = a.partial_piv_lu();
    registers::zero_upper();
    check_pivots((0..a.nrows()).map(|i| lu.U()[(i, i)].abs()))?;
    let x = lu.solve(b);
    registers::zero_upper();
    Ok(x)
}

/// Solution `A⁻¹ B` of complex matrices, as [`lu_solve`].
pub fn lu_solve_complex(a: &ComplexMatrix, b: &ComplexMatrix) -> Result<ComplexMatrix, Error> {
    let lu = a.partial_piv_lu();
    registers::zero_upper();
    check_pivots((0..a.nrows()).map(|i| lu.U()[(i, i)].norm()))?;
    let x = lu.solve(b);
    registers::zero_upper();
    Ok(x)
}

fn check_pivots(pivots: impl Iterator<Item = f64>) -> Result<(), Error> {
    for (i, size) in pivots.enumerate() {
        if !(size > 0.0 && size.is_finite()) {
            return Err(Error::new(
                Code::NotPositiveDefinite,
                format!("a linear system is singular: pivot {i} is {size}"),
            ));
        }
    }
    Ok(())
}

/// Singular values, descending, with an absolute error of ε times the largest, and right singular vectors as columns.
///
/// # Errors
/// `NoConvergence`; `Overflow` where an entry is not finite.
pub fn right_svd(a: &Matrix) -> Result<(Vec<f64>, Matrix), Error> {
    check_finite(a, "a matrix")?;
    let svd = a.thin_svd();
    registers::zero_upper();
    let svd = svd.map_err(|_| {
        let (m, n) = (a.nrows(), a.ncols());
        Error::new(
            Code::NoConvergence,
            format!("the singular values of a {m}×{n} matrix did not converge"),
        )
    })?;
    let values = svd.S().column_vector();
    Ok((
        (0..values.nrows()).map(|i| values[i]).collect(),
        svd.V().to_owned(),
    ))
}

/// Solution of `K x = f` for a positive semidefinite `K`, which may be singular; `f` must be in its range.
///
/// K is scaled to unit diagonal first, so that the rank decision does not depend on the size of the springs.
///
/// # Errors
/// Those of [`symmetric_eigen`].
pub fn solve_semidefinite(k: &Matrix, f: &[f64]) -> Result<Vec<f64>, Error> {
    let n = k.nrows();
    let scale: Vec<f64> = (0..n)
        .map(|i| {
            if k[(i, i)] > 0.0 {
                1.0 / k[(i, i)].sqrt()
            } else {
                1.0
            }
        })
        .collect();
    let scaled = Matrix::from_fn(n, n, |i, j| k[(i, j)] * scale[i] * scale[j]);
    let eigen = symmetric_eigen(&scaled)?;
    let largest = eigen.values.last().copied().unwrap_or(0.0);
    let mut x = vec![0.0; n];
    for (mode, &value) in eigen.values.iter().enumerate() {
        // Below the backward error of the eigenproblem, with a margin, an eigenvalue counts as zero.
        if value > 1e2 * n as f64 * f64::EPSILON * largest {
            let coordinate: f64 = (0..n)
                .map(|i| eigen.vectors[(i, mode)] * scale[i] * f[i])
                .sum::<f64>()
                / value;
            (0..n).for_each(|i| x[i] += coordinate * eigen.vectors[(i, mode)] * scale[i]);
        }
    }
    Ok(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: &[&[f64]]) -> Matrix {
        Matrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
    }

    fn assert_close(a: &Matrix, b: &Matrix, tolerance: f64) {
        assert!((a - b).norm_max() < tolerance, "{a:?} {b:?}");
    }

    /// Two discs on a spring: ω² = k (1/J₁ + 1/J₂), φᵀ M φ = 1.
    #[test]
    fn exact_two_discs() {
        let (k, m) = (
            matrix(&[&[1200.0, -1200.0], &[-1200.0, 1200.0]]),
            matrix(&[&[2.0, 0.0], &[0.0, 3.0]]),
        );
        let eigen = generalised_symmetric_eigen(&k, &m).unwrap();
        assert!(
            eigen.values[0].abs() < 1e-12 && (eigen.values[1] - 1000.0).abs() < 1e-12,
            "{:?}",
            eigen.values
        );
        assert_close(
            &(eigen.vectors.transpose() * &m * &eigen.vectors),
            &Matrix::identity(2, 2),
            1e-15,
        );
    }

    /// K Φ = M Φ Λ with a full M, K indefinite.
    #[test]
    fn law_pencil_residual() {
        let k = matrix(&[&[1.0, 2.0, 0.0], &[2.0, -3.0, 1.0], &[0.0, 1.0, 5.0]]);
        let m = matrix(&[&[4.0, 1.0, 0.0], &[1.0, 3.0, 1.0], &[0.0, 1.0, 2.0]]);
        let SymmetricEigen { values, vectors } = generalised_symmetric_eigen(&k, &m).unwrap();
        let m_phi_lambda = Matrix::from_fn(3, 3, |i, j| (&m * &vectors)[(i, j)] * values[j]);
        assert_close(&(&k * &vectors), &m_phi_lambda, 1e-13);
        assert!(values[0] < 0.0);
    }

    #[test]
    fn exact_factor_and_solutions() {
        let l = matrix(&[&[2.0, 0.0], &[1.0, 3.0]]);
        assert_close(&cholesky(&(&l * l.transpose())).unwrap(), &l, 1e-15);
        let b = matrix(&[&[4.0], &[8.0]]);
        assert_close(&solve_lower(&l, &b), &matrix(&[&[2.0], &[2.0]]), 1e-15);
        assert_close(
            &solve_lower_transposed(&l, &matrix(&[&[6.0], &[6.0]])),
            &matrix(&[&[2.0], &[2.0]]),
            1e-15,
        );
        assert_close(
            &lu_solve(&l, &b).unwrap(),
            &matrix(&[&[2.0], &[2.0]]),
            1e-15,
        );
    }

    #[test]
    fn refuses_what_is_not_definite() {
        let error = cholesky(&matrix(&[&[1.0, 2.0], &[2.0, 1.0]])).unwrap_err();
        assert_eq!(error.code, Code::NotPositiveDefinite);
        assert!(error.message.contains("row 1"), "{}", error.message);
    }

    #[test]
    fn refuses_a_singular_system() {
        let singular = matrix(&[&[1.0, 2.0], &[2.0, 4.0]]);
        assert_eq!(
            lu_solve(&singular, &singular).unwrap_err().code,
            Code::NotPositiveDefinite
        );
        let zero = ComplexMatrix::zeros(1, 1);
        assert_eq!(
            lu_solve_complex(&zero, &zero).unwrap_err().code,
            Code::NotPositiveDefinite
        );
    }

    #[test]
    fn refuses_what_is_not_finite() {
        assert_eq!(
            symmetric_eigen(&matrix(&[&[f64::NAN]])).unwrap_err().code,
            Code::Overflow
        );
    }

    #[test]
    fn survives_nothing_at_all() {
        let empty = Matrix::zeros(0, 0);
        assert!(
            generalised_symmetric_eigen(&empty, &empty)
                .unwrap()
                .values
                .is_empty()
        );
        assert_eq!(lu_solve(&empty, &empty).unwrap().nrows(), 0);
    }
}
