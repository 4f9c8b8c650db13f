//! From measured responses to transfer functions and modal parameters with their uncertainty. On slices; knows neither files nor the
//! terminal.

/// A mode as identified.
pub mod mode;

/// Common poles of many frequency responses, without hints.
pub mod rational;

/// Modes of free decays.
pub mod free_decay;

/// Transfer functions by poles and residues: zeros, polynomials, state space, sampled forms, export.
pub mod transfer;

/// Rational fits to start from and to check against: Levy, vector fitting, AAA.
pub mod starts;

/// How well shapes agree with each other and a model with its measurement.
pub mod compare;

/// Modes from frequency responses.
pub mod modal;

/// Checks of samples.
mod samples;

/// Difference equations: AR, ARMA, ARX, ARMAX, output error.
pub mod series;

/// Modes from responses alone.
pub mod operational;
