//! Results as tables, JSON, CSV and pictures. Computes nothing.

/// Columns of numbers.
pub mod number;

/// The surface of every picture.
pub mod style;

/// Frequencies over speed, as a picture.
pub mod campbell_picture;

/// Campbell diagrams.
pub mod campbell;

/// Modes in words.
pub mod words;

/// JSON documents.
pub mod json;

/// CSV files.
pub mod csv;

/// Tables for a terminal.
#[cfg(feature = "cli")]
pub mod table;

/// The order of nodes along a train.
pub mod train;

/// Pictures of mode shapes.
pub mod shapes;

/// Where the energy of each mode sits, as a picture.
pub mod energy_bars;
