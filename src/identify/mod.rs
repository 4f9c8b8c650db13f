//! From measured responses to transfer functions and modal parameters with their uncertainty. On slices; knows neither files nor the
//! terminal.

/// A mode as identified.
pub mod mode;
