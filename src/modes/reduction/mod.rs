//! Model reduction: `p = T_r r` with fewer coordinates, and what the response loses by it over a band.

/// The shapes interior coordinates take.
mod interior;

/// The methods.
mod method;

/// Errors over a band: estimated, and measured.
mod band;

/// What can be left out.
mod advice;

pub use advice::{Advice, LeftOut, advise};
pub use band::{Band, BandError};
pub use method::{Keep, Method, Reduced, coordinate, frequencies};
