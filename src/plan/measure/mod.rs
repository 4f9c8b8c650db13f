//! A gear's charts and readings: columns read, evaluated, graded.

/// Columns of the files charts stand in.
pub mod columns;

/// Values beside their limits and grades.
pub mod grading;

/// What each chart says.
pub mod charts;

/// What charts say of each other: single-flank record from pitch and profile, and back.
mod rolling;

/// The run.
pub mod run;
