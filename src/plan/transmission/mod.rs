//! Transmission error of a chain.

/// The error over the angle, with its ranges.
pub mod recorded;

/// The run.
pub mod run;
