//! Gear geometry and gear measurement on numbers and slices; no files, no dynamics.
//!
//! Knows neither files nor dynamics.

/// Envelopes of moving surfaces: the equation of meshing.
pub mod kernel;

/// Plane meshing: ratio laws, centrodes, conjugate profiles.
pub mod plane;

/// Hand of teeth.
pub mod hand;

/// Cylindrical involute gears: member, outline, pair, reversal.
pub mod cylindrical;

/// Bevel and hypoid gears: flanks from machine settings.
pub mod bevel;

/// Helicoids: worm threads, disk tools, worm pairs, crossed helical pairs.
pub mod helicoid;

/// Contact of two flanks: path, ellipse, transmission error.
pub mod contact;

/// Flanks as discrete blades cut them; correction of machine settings.
pub mod cut;

/// Tooth stiffness, load sharing and loaded transmission error.
pub mod load;

pub mod measurement;
