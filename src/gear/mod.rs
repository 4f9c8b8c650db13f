//! Gear geometry and gear measurement on numbers and slices; no files, no dynamics.
//!
//! Knows neither files nor dynamics.

/// Envelopes of moving surfaces: the equation of meshing.
pub mod kernel;

/// Bevel and hypoid flanks from machine settings.
pub mod bevel;

/// Unloaded contact of flanks.
pub mod contact;

pub mod involute;

pub mod path_of_contact;

pub mod measurement;
