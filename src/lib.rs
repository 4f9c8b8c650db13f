//! Machine dynamics and transmission error of gear drive trains.
//!
//! The modules are floors: each imports only from those above it in this list.

/// Errors with places and hints; units; TOML with places.
pub mod base;

/// Linear algebra, without knowledge of files, gears or the terminal.
pub mod numeric;

/// Model and scene files as written.
pub mod scene;

/// Masses and branches.
pub mod machine;

/// Natural modes.
pub mod modes;

/// What a study needs, and running it.
pub mod plan;

/// What a person or a program reads of an answer.
pub mod report;
