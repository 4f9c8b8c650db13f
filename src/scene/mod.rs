//! TOML files of ours as written: models and scenes, each value with its place.

/// Laws of motion in time.
pub mod laws;

/// A machine as its file describes it.
pub mod model;

/// Tables by their headers.
mod tables;

/// Waves over a period.
mod waves;

/// Force over deflection that is not linear.
mod characteristic;

/// What many tables share.
mod common;

/// The materials a file can name.
pub mod materials;

/// Bodies and rows of them.
mod bodies;

/// Shafts and couplings.
mod shafts;

/// Friction of bearings and teeth.
mod friction;

/// Screws and slides.
pub mod screws;

/// Gear pairs, worm pairs and belts.
mod gears;

/// Planetary stages.
mod planetary;

/// Bearings, dampers, speeds, damping.
mod supports;

/// Numbers over time that are multiplied.
mod factors;

/// Loads, motors and brakes.
mod drives;

/// Errors of gears.
mod form_errors;

/// Where a scene starts.
pub mod start;

/// What no single table can tell.
mod nodes;

/// Values a scene puts in place of the model's.
mod overrides;

/// What a scene asks.
pub mod study;

/// From the first byte to a checked scene.
mod file;

/// The sidecar of a recording.
pub mod log;

/// A gear with its charts and readings.
pub mod measured;

/// Limits somebody typed in.
pub mod limit_table;

pub use file::{Scene, read, read_text};
