//! Difference equations fitted to samples: `A(q) y = B(q)/F(q) u + C(q) e`, with `A = 1 + a₁q⁻¹ + …` and so on.
//!
//! Ljung, System Identification: Theory for the User, 2nd ed. (1999), §4.2 for the families, §10.2 for their fit.

/// The samples a model is fitted to.
pub mod record;

/// Filters by polynomials of the shift.
mod filter;

/// A fitted model: predictions, spectra, modes.
pub mod model;

/// Autoregressive models: Burg, Yule–Walker, least squares.
pub mod autoregressive;

/// Models with inputs and coloured noise, by prediction error.
pub mod prediction_error;

/// Which order.
pub mod order;

/// What residuals tell of a model.
pub mod residuals;

/// Models that follow a process as it changes.
pub mod recursive;

/// The course of such a model over a record: order and memory by what they predict, modes as tracks.
pub mod course;
