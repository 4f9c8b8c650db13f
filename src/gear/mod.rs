//! Gears by themselves: what they are and what was measured of them, on numbers and slices. Knows neither files nor dynamics.

/// What charts and readings of a gear say.
pub mod measurement;
