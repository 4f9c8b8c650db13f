//! Rotating machinery: shaft angle from tacho or encoder, order analysis, synchronous averages.

pub mod level_crossings;

pub mod tacho;

pub mod angle_curve;

pub mod encoder;

pub mod interpolation;

pub mod angular_resampling;

pub mod orders;

pub mod order_demodulation;

pub mod synchronous_average;

pub mod separation;
