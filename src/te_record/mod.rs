//! Records of transmission error over the angle: ranges in windows, long and short wave, harmonics.
//!
//! Computed, measured by encoders or read from a chart, a record e(φ) is evaluated here.

pub mod windowed_ranges;

pub mod single_flank;
