//! Gear geometry and gear measurement on numbers and slices; no files, no dynamics.
//!
//! Knows neither files nor dynamics.

/// The kernel of meshing: tools, motions, envelopes, limits.
pub mod kernel;

/// Cylindrical involute gears: member, outline, pair, reversal.
pub mod cylindrical;

/// Tooth stiffness, load sharing and loaded transmission error of cylindrical pairs.
pub mod load;

pub mod measurement;
