//! TOML files of ours as written: models and scenes, each value with its place.

/// A machine as its file describes it.
pub mod model;
