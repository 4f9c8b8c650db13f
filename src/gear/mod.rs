//! Gears by themselves: what they are and what was measured of them, on numbers and slices. Knows neither files nor dynamics.

/// Involute cylindrical gears: base circle, tooth thickness, span, dimension over balls.
pub mod involute;

/// Where along the line of action teeth touch, and how they slide.
pub mod path;

/// What charts and readings of a gear say.
pub mod measurement;
