//! Gear geometry and gear measurement on numbers and slices; no files, no dynamics.
//!
//! Knows neither files nor dynamics.

/// Cylindrical involute gears: member, outline, pair, reversal.
pub mod cylindrical;

pub mod measurement;
