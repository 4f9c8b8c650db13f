//! Linear algebra, the only files that name its packages.

/// Constraints in exact fractions.
pub mod exact;

/// Dense real matrix, column-major.
pub type Matrix = faer::Mat<f64>;

/// Dense complex matrix, column-major.
pub type ComplexMatrix = faer::Mat<Complex>;

/// A complex number.
pub type Complex = faer::c64;

/// Householder reduction that keeps the digits of small rows.
mod rowwise;

/// One-sided Jacobi rotations.
mod jacobi;

/// Singular values of graded matrices, and elimination of freedoms without inertia.
pub mod graded;

// /// Symmetric eigenproblems, Cholesky factors, linear systems.
// pub mod definite;

// /// Nonsymmetric eigenproblems with conditions, and the polishing of damped modes.
// pub mod general;
