//! Gear geometry and gear measurement on numbers and slices; no files, no dynamics.
//!
//! Knows neither files nor dynamics.

/// Envelopes of moving surfaces: the equation of meshing.
pub mod kernel;

/// Plane meshing: ratio laws, centrodes, conjugate profiles.
pub mod plane;

pub mod involute;

pub mod path_of_contact;

pub mod measurement;
