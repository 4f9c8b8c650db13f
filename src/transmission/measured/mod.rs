//! Transmission error from the encoders of two shafts: readings → angles → checks → even cells of angle → orders with intervals.
//!
//! ```text
//! Rows ─► survey (ways, pace, ratio, slip) ─► jumps ─► Cells ─► lines, composite values, backlash
//! ```

/// Tooth numbers between the encoders.
pub mod teeth;

/// Readings row by row.
pub mod rows;

/// A first look: ways, pace, ratio.
pub mod survey;

/// Lost and extra counts.
pub mod jumps;

/// Index pulses.
pub mod index;

/// Steps judged by index pulses.
pub mod verdict;

/// Even cells of angle.
pub mod cells;

/// Intervals of amplitudes.
pub mod interval;

/// Orders a train can show.
pub mod orders;

/// Waves of known orders.
pub mod fit;

/// What is left beside them.
pub mod noise;

/// Steps left beside them.
pub mod steps;

/// Mean turns of the shafts.
pub mod mean_turn;

/// Ranges, long and short wave.
pub mod composite;

/// One flank.
pub mod flank;

/// Play between two flanks.
pub mod play;

/// Where angles begin.
pub mod marks;

/// Speed tooth by tooth.
pub mod speed;

/// The whole evaluation.
pub mod evaluate;

/// Eccentricity of encoders and gears apart.
pub mod eccentricity;
