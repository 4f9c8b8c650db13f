//! Transmission-error study of a kinematic chain.

pub mod error_record;

pub mod run;
