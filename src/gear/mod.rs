//! Gear geometry and gear measurement on numbers and slices; no files, no dynamics.
//!
//! Knows neither files nor dynamics.

pub mod plane;

pub mod involute;

pub mod path_of_contact;

pub mod measurement;
