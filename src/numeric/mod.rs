//! Linear algebra, the only files that name its packages.

use crate::base::code::Code;
use crate::base::error::Error;

/// Dense real matrix, column-major.
pub type Matrix = faer::Mat<f64>;

/// Dense complex matrix, column-major.
pub type ComplexMatrix = faer::Mat<Complex>;

/// A complex number.
pub type Complex = faer::c64;

/// Discrete Fourier transforms.
pub mod fft;

/// Values between samples at any instants.
pub mod band_limited;

/// Medians and distributions.
pub mod statistics;

/// Exact fractions.
pub mod fraction;

/// Points that fill a cube evenly.
pub mod lattice;

/// Constraints in exact fractions.
pub mod exact;

/// Sums over long vectors.
pub mod slices;

/// Householder reduction that keeps the digits of small rows.
mod rowwise;

/// Factors that set the grading of a matrix apart.
mod pivots;

/// One-sided Jacobi rotations.
mod jacobi;

/// Singular values of graded matrices, and elimination of freedoms without inertia.
pub mod graded;

/// One-to-one pairing.
pub mod assignment;

/// How alike two complex vectors are in direction.
pub mod collinearity;

/// Vector registers as they should be left.
pub mod registers;

/// Products in place.
pub mod products;

/// Symmetric eigenproblems, Cholesky factors, linear systems.
pub mod definite;

/// LU factors that are kept.
pub mod lu;

/// Least squares with many right-hand sides.
pub mod overdetermined;

/// Rows and columns brought to like size.
mod balance;

/// Nonsymmetric eigenproblems with the condition of every eigenvalue.
pub mod general;

/// The matrix exponential.
pub mod expm;

/// Small systems solved where they stand.
pub mod in_place;

/// Continuous state-space forms at a sample time.
pub mod sampling;

/// Least squares, orthonormal columns, least singular vectors.
pub mod least_squares;

/// Polishing of damped modes.
pub mod quadratic;

/// Orthonormal bases of column spaces.
pub mod orthonormal;

/// Triangles of tall matrices, least squares, singular values with vectors.
pub mod factors;

/// Sparse symmetric matrices, and their factorisation with a count of negative eigenvalues.
pub mod sparse;

/// Sparse complex systems of one pattern, solved for many values.
pub mod sparse_lu;

/// What hangs from what: the spanning forest of a machine's springs.
pub mod forest;

/// Series and parallel: a forest eliminated without subtraction, its solutions and its Sturm count.
pub mod elimination;

/// `(K − σM)⁻¹` from whatever factorised it.
pub mod inverse;

/// Modes nearest a shift.
pub mod lanczos;

/// The entries of a matrix, row by row.
pub fn by_rows(a: &Matrix) -> Vec<Vec<f64>> {
    let row = |i| (0..a.ncols()).map(|j| a[(i, j)]).collect();
    (0..a.nrows()).map(row).collect()
}

/// Refuses a matrix with an entry that is not a number or not finite; `what` names it.
fn check_finite(a: &Matrix, what: &str) -> Result<(), Error> {
    for j in 0..a.ncols() {
        if let Some(i) = a.col_as_slice(j).iter().position(|x| !x.is_finite()) {
            return Err(Error::new(
                Code::Overflow,
                format!("entry ({i}, {j}) of {what} is {}", a[(i, j)]),
            ));
        }
    }
    Ok(())
}
