//! Errors with places and hints, units, and the reading of TOML with places.

/// Where in a file something stands.
pub mod place;

/// The words errors go by.
pub mod code;

/// What went wrong, where, and what to do now.
pub mod error;
