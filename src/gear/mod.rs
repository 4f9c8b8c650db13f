//! Gear geometry and gear measurement on numbers and slices; no files, no dynamics.
//!
//! Knows neither files nor dynamics.

/// Cylindrical involute gears: member, outline, pair, reversal.
pub mod cylindrical;

/// Tooth stiffness, load sharing and loaded transmission error of cylindrical pairs.
pub mod load;

pub mod measurement;
