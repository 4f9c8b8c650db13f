//! What a person or a program reads of an answer.

/// The surface of every picture.
pub mod style;

/// The order of nodes along a train.
pub mod train;

/// Pictures of mode shapes.
pub mod shapes;

/// Where the energy of each mode sits, as a picture.
pub mod energy_bars;

/// Frequencies over speed, as a picture.
pub mod campbell_picture;
