//! Transmission error from two encoders: angles, count checks, resampling, orders.
//!
//! ```text
//! Rows ─► survey (ways, pace, ratio, slip) ─► jumps ─► Cells ─► lines, composite values, backlash
//! ```

pub mod gear_train;

pub mod readings;

pub mod survey;

pub mod count_steps;

pub mod index_pulses;

pub mod count_check;

pub mod resampling;

pub mod interval;

pub mod orders;

pub mod fit;

pub mod noise;

pub mod residual_steps;

pub mod shaft_average;

pub mod composite;

pub mod flank;

pub mod backlash;

pub mod angle_origin;

pub mod speed;

pub mod evaluate;

pub mod eccentricity;
