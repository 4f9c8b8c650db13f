//! Modes from frequency responses: poles by one of several methods over rising orders, a stabilisation diagram, the automatic choice of
//! the physical ones, shapes and residues by least squares.

/// Frequency responses of several outputs to several inputs, checked.
pub mod responses;

/// Poles of a model order, each with the shape and participation the method gives.
pub mod candidates;

/// Sums over lines for every lag.
mod lags;

/// Monic least squares for every order from one factor.
mod nested;

/// Poly-reference least-squares complex frequency domain.
pub mod plscf;

/// Least-squares complex exponential.
pub mod lsce;

/// Rational fraction polynomials.
pub mod rfp;

/// One mode at a time: peak, half power, circle.
pub mod single;

/// The stabilisation diagram.
pub mod stabilisation;

/// Agglomerative clusters.
pub(super) mod clusters;

/// The automatic choice of physical poles.
pub mod selection;

/// Residues, shapes and scaling for known poles.
pub mod lsfd;
