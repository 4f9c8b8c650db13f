//! Linear algebra, the only files that name its packages.

/// Dense real matrix, column-major.
pub type Matrix = faer::Mat<f64>;

/// Dense complex matrix, column-major.
pub type ComplexMatrix = faer::Mat<Complex>;

/// A complex number.
pub type Complex = faer::c64;

/// Sums over long vectors.
mod slices;

/// Sparse symmetric matrices, and their factorisation with a count of negative eigenvalues.
pub mod sparse;

/// What hangs from what: the spanning forest of a machine's springs.
pub mod forest;

/// Series and parallel: a forest eliminated without subtraction, its solutions and its Sturm count.
pub mod elimination;

/// `(K − σM)⁻¹` from whatever factorised it.
pub mod inverse;

/// Modes nearest a shift.
pub mod lanczos;
