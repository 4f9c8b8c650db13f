//! Transmission error of a chain.

/// The run.
pub mod run;
