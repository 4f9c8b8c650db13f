//! Linear algebra, the only files that name its packages.

/// Constraints in exact fractions.
pub mod exact;

/// Dense real matrix, column-major.
pub type Matrix = faer::Mat<f64>;

/// Dense complex matrix, column-major.
pub type ComplexMatrix = faer::Mat<Complex>;

/// A complex number.
pub type Complex = faer::c64;
