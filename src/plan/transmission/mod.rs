//! Transmission-error study of a kinematic chain.

pub mod chain;

pub mod error_record;

pub mod result;

pub mod stages;

mod diagnostics;

pub mod run;
