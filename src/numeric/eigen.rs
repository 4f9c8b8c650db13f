//! Nonsymmetric eigenproblems `A x = λ x`, `yᴴA = λ yᴴ` with eigenvalue condition numbers.
//!
//! Balanced by powers of two first: Parlett & Reinsch, Numer. Math. 13 (1969), pp. 293–304, with the 2-norms of
//! James, Langou & Lowery, On matrix balancing and eigenvector computation, arXiv:1401.5766 (2014), Algorithm 3.

use crate::base::code::Code;
use crate::base::error::Error;

use super::balance::balance;
use super::sorting::ascending_order;
use super::symmetric::lu_solve_complex;
use super::{Complex, ComplexMatrix, Matrix, check_finite, registers};

/// Eigenvalues, right and left eigenvectors, and condition numbers of a general matrix.
#[derive(Debug, Clone)]
pub struct GeneralEigen {
    /// Eigenvalues in ascending order of |λ|; of a conjugate pair the one with positive imaginary part first.
    pub values: Vec<Complex>,
    /// Right vectors as columns of length one.
    pub right: ComplexMatrix,
    /// Left vectors as columns, `yᴴ x = 1`; of length one if the condition number is infinite.
    pub left_vectors: ComplexMatrix,
    /// Eigenvalue condition numbers of the balanced matrix; infinite for an eigenvalue defective to working precision.
    pub condition: Vec<f64>,
    /// Frobenius norm of the balanced matrix: λ_i is uncertain by about `ε · norm · condition[i]`.
    pub norm: f64,
}

/// Eigenvalues of `a` with left and right vectors.
///
/// Errors: `Overflow` if an entry is not finite; `NoConvergence`.
pub fn eigen(a: &Matrix) -> Result<GeneralEigen, Error> {
    check_finite(a, "a square matrix")?;
    let n = a.nrows();
    let (balanced, scale) = balance(a, f64::hypot);
    let (values, right) = sorted_eigen(&balanced)?;
    let left = match biorthogonal(&right) {
        Some(left) => left,
        None => matched_left(&balanced, &values)?,
    };
    let mut result = GeneralEigen {
        values,
        right,
        left_vectors: left,
        condition: vec![0.0; n],
        norm: balanced.norm_l2(),
    };
    for j in 0..n {
        result.condition[j] = normalise(&mut result, j, &scale);
    }
    Ok(result)
}

/// Eigenvalues without eigenvectors, in ascending order of |λ|; of a conjugate pair the one with positive imaginary part first.
///
/// # Errors
/// `NoConvergence`; `Overflow` if an entry is not finite.
pub fn eigenvalues(a: &Matrix) -> Result<Vec<Complex>, Error> {
    check_finite(a, "a square matrix")?;
    let n = a.nrows();
    if n == 0 {
        return Ok(Vec::new());
    }
    let (balanced, _) = balance(a, f64::hypot);
    let values = balanced.eigenvalues();
    registers::zero_upper();
    let mut values = values.map_err(|_| no_convergence(n))?;
    if values
        .iter()
        .any(|v| !v.re.is_finite() || !v.im.is_finite())
    {
        return Err(no_convergence(n));
    }
    values.sort_by(|a, b| a.norm().total_cmp(&b.norm()).then(b.im.total_cmp(&a.im)));
    Ok(values)
}

/// Eigenvalues of a real matrix and right eigenvectors as columns, in ascending order of |λ|.
///
/// # Errors
/// `NoConvergence`; `Overflow` if an entry is not finite.
pub fn right_eigen(a: &Matrix) -> Result<(Vec<Complex>, ComplexMatrix), Error> {
    check_finite(a, "a square matrix")?;
    sorted_eigen(a)
}

/// Eigenvalues of a complex matrix and right eigenvectors of length one as columns, in ascending order of |λ|.
///
/// # Errors
/// `NoConvergence`; `Overflow` if an entry is not finite.
pub fn eigen_complex(a: &ComplexMatrix) -> Result<(Vec<Complex>, ComplexMatrix), Error> {
    let n = a.nrows();
    let is_finite = |z: &Complex| z.re.is_finite() && z.im.is_finite();
    if (0..n).any(|j| a.col_as_slice(j).iter().any(|z| !is_finite(z))) {
        return Err(Error::new(
            Code::Overflow,
            "an entry of a complex matrix is not finite",
        ));
    }
    let decomposition = a.eigen();
    registers::zero_upper();
    let decomposition = decomposition.map_err(|_| no_convergence(n))?;
    let (values, vectors) = (decomposition.S().column_vector(), decomposition.U());
    let order = ascending_order((0..n).map(|i| values[i].norm()));
    let right = ComplexMatrix::from_fn(n, n, |i, k| {
        vectors[(i, order[k])] / vectors.col(order[k]).norm_l2()
    });
    Ok((order.iter().map(|&k| values[k]).collect(), right))
}

/// Generalised eigenvalues λ of `A x = λ E x`; `None` for an infinite λ, which an algebraic equation has.
///
/// Errors: `Overflow` if an entry is not finite; `NoConvergence`.
pub fn generalised_eigenvalues(a: &Matrix, e: &Matrix) -> Result<Vec<Option<Complex>>, Error> {
    check_finite(a, "a descriptor system")?;
    check_finite(e, "a descriptor system's mass")?;
    let n = a.nrows();
    let pencil = a.generalized_eigen(e);
    registers::zero_upper();
    let pencil = pencil.map_err(|_| no_convergence(n))?;
    let negligible = n as f64 * f64::EPSILON * e.norm_l2();
    let (alpha, beta) = (pencil.S_a().column_vector(), pencil.S_b().column_vector());
    Ok((0..n)
        .map(|i| (beta[i].norm() > negligible).then(|| alpha[i] / beta[i]))
        .collect())
}

fn no_convergence(n: usize) -> Error {
    Error::new(
        Code::NoConvergence,
        format!("the QR iteration for the eigenvalues of a {n}×{n} matrix did not converge"),
    )
}

fn sorted_eigen(a: &Matrix) -> Result<(Vec<Complex>, ComplexMatrix), Error> {
    let n = a.nrows();
    let decomposition = a.eigen();
    registers::zero_upper();
    let decomposition = decomposition.map_err(|_| no_convergence(n))?;
    let values: Vec<Complex> = decomposition.S().column_vector().iter().copied().collect();
    if values
        .iter()
        .any(|v| !v.re.is_finite() || !v.im.is_finite())
    {
        return Err(no_convergence(n));
    }
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| {
        values[i]
            .norm()
            .total_cmp(&values[j].norm())
            .then(values[j].im.total_cmp(&values[i].im))
    });
    let vectors = ComplexMatrix::from_fn(n, n, |i, j| decomposition.U()[(i, order[j])]);
    Ok((order.iter().map(|&i| values[i]).collect(), vectors))
}

/// Biorthogonal left vectors `Y = X⁻ᴴ`, `Yᴴ X = I`; none if X is nearly singular.
fn biorthogonal(right: &ComplexMatrix) -> Option<ComplexMatrix> {
    let n = right.nrows();
    let inverse = lu_solve_complex(right, &ComplexMatrix::identity(n, n)).ok()?;
    let longest = inverse.norm_max();
    (longest < MAX_INVERSE_ENTRY).then(|| inverse.adjoint().to_owned())
}

const MAX_INVERSE_ENTRY: f64 = 1e10; // largest entry of X⁻¹; beyond, ill-conditioned columns contaminate all others

/// Left eigenvectors as right eigenvectors of `Aᵀ`, matched by the nearest eigenvalue.
fn matched_left(a: &Matrix, values: &[Complex]) -> Result<ComplexMatrix, Error> {
    let n = a.nrows();
    let (transposed, vectors) = sorted_eigen(&a.transpose().to_owned())?;
    let mut unmatched: Vec<usize> = (0..n).collect();
    let mut partner = Vec::with_capacity(n);
    for value in values {
        let distance = |&i: &usize| (transposed[i] - value).norm();
        let nearest = (0..unmatched.len())
            .min_by(|&i, &j| distance(&unmatched[i]).total_cmp(&distance(&unmatched[j])));
        partner.extend(nearest.map(|index| unmatched.remove(index)));
    }
    Ok(ComplexMatrix::from_fn(n, n, |i, j| {
        vectors[(i, partner[j])].conj()
    }))
}

/// Reverts the balancing of eigenpair j and normalises it; returns its condition number.
fn normalise(eigen: &mut GeneralEigen, j: usize, scale: &[f64]) -> f64 {
    let n = scale.len();
    let length = |m: &ComplexMatrix| (0..n).map(|i| m[(i, j)].norm_sqr()).sum::<f64>().sqrt();
    let product: Complex = (0..n)
        .map(|i| eigen.left_vectors[(i, j)].conj() * eigen.right[(i, j)])
        .sum();
    let condition = length(&eigen.right) * length(&eigen.left_vectors) / product.norm();
    let is_sound = condition.is_finite() && condition * f64::EPSILON < 1.0;
    for i in 0..n {
        eigen.right[(i, j)] *= scale[i];
        eigen.left_vectors[(i, j)] /= scale[i];
    }
    let right_length = length(&eigen.right);
    let left_factor = if is_sound {
        product.conj().inv() * right_length
    } else {
        Complex::new(1.0 / length(&eigen.left_vectors), 0.0)
    };
    for i in 0..n {
        eigen.right[(i, j)] /= right_length;
        eigen.left_vectors[(i, j)] *= left_factor;
    }
    if is_sound { condition } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: &[&[f64]]) -> Matrix {
        Matrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
    }

    fn complex(a: &Matrix) -> ComplexMatrix {
        ComplexMatrix::from_fn(a.nrows(), a.ncols(), |i, j| Complex::new(a[(i, j)], 0.0))
    }

    /// An oscillator: λ² + 2ζω λ + ω² = 0.
    #[test]
    fn exact_oscillator() {
        let (w, zeta) = (100.0, 0.02_f64);
        let found = eigen(&matrix(&[&[0.0, 1.0], &[-w * w, -2.0 * zeta * w]])).unwrap();
        let exact = Complex::new(-zeta * w, w * (1.0 - zeta * zeta).sqrt());
        assert!(
            (found.values[0] - exact).norm() < 1e-13 * w,
            "{:?}",
            found.values
        );
        assert_eq!(found.values[1], found.values[0].conj());
        assert!(
            found.condition[0] < 1.1,
            "balanced, it is nearly normal: {:?}",
            found.condition
        );
    }

    /// A X = X Λ, Yᴴ A = Λ Yᴴ, Yᴴ X = I.
    #[test]
    fn law_residuals_and_biorthogonality() {
        let a = Matrix::from_fn(7, 7, |i, j| {
            (((5 * i + 3 * j * j) % 13) as f64 - 6.0) * 10f64.powi(i as i32 - j as i32)
        });
        let found = eigen(&a).unwrap();
        let product = found.left_vectors.adjoint() * &found.right;
        let (ax, ya) = (
            complex(&a) * &found.right,
            found.left_vectors.adjoint() * complex(&a),
        );
        for (i, j) in (0..7).flat_map(|i| (0..7).map(move |j| (i, j))) {
            let size = found.left_vectors.col(i).norm_l2();
            assert!(
                (product[(i, j)] - f64::from(u8::from(i == j))).norm() < 1e-13 * size,
                "({i}, {j})"
            );
            assert!(
                (ax[(i, j)] - found.right[(i, j)] * found.values[j]).norm() < 1e-13 * a.norm_l2()
            );
            assert!(
                (ya[(i, j)] - found.left_vectors[(j, i)].conj() * found.values[i]).norm()
                    < 1e-13 * a.norm_l2() * size
            );
        }
    }

    /// A Jordan block next to a simple eigenvalue: infinite and moderate conditions, no NaN.
    #[test]
    fn survives_a_defective_pair() {
        let found = eigen(&matrix(&[
            &[2.0, 1.0, 0.0],
            &[0.0, 2.0, 1.0],
            &[0.0, 0.0, 5.0],
        ]))
        .unwrap();
        assert!(
            found.condition[0] > 1e7 && found.condition[1] > 1e7,
            "{:?}",
            found.condition
        );
        assert!(found.condition[2] < 2.0, "{:?}", found.condition);
        let entries = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
        assert!(
            entries
                .map(|at| found.left_vectors[at].norm() + found.right[at].norm())
                .all(f64::is_finite)
        );
    }

    /// Repeated but not defective.
    #[test]
    fn exact_repeated() {
        let found = eigen(&Matrix::identity(3, 3)).unwrap();
        assert_eq!(found.condition, [1.0; 3]);
    }

    /// A similarity by powers of ten from 1e-60 to 1e60 does no harm.
    #[test]
    fn survives_bad_scaling() {
        let a = matrix(&[
            &[1.0, 2e-60, 0.5e-60],
            &[3e60, 4.0, 1.0],
            &[1e60, -1.0, 2.0],
        ]);
        let plain = matrix(&[&[1.0, 2.0, 0.5], &[3.0, 4.0, 1.0], &[1.0, -1.0, 2.0]]);
        let (scaled, plain) = (eigen(&a).unwrap(), eigen(&plain).unwrap());
        for i in 0..3 {
            assert!(
                (scaled.values[i] - plain.values[i]).norm() < 1e-13,
                "{:?} {:?}",
                scaled.values,
                plain.values
            );
        }
    }

    #[test]
    fn exact_descriptor() {
        let (a, e) = (
            matrix(&[&[-2.0, 1.0], &[1.0, -1.0]]),
            matrix(&[&[1.0, 0.0], &[0.0, 0.0]]),
        );
        let mut found = generalised_eigenvalues(&a, &e).unwrap();
        found.sort_by_key(Option::is_none);
        assert!(
            (found[0].unwrap() - Complex::new(-1.0, 0.0)).norm() < 1e-14,
            "{found:?}"
        );
        assert_eq!(found[1], None);
    }

    #[test]
    fn survives_nothing_at_all() {
        assert!(eigen(&Matrix::zeros(0, 0)).unwrap().values.is_empty());
    }
}
