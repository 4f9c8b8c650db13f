//! The library's surface: models, machines, recordings, and what their analyses return by name.

/// Reduced machines.
pub mod reduction;

/// Natural modes with names.
pub mod modes;

/// Frequency responses with names.
pub mod response;

/// Motion in time with names.
pub mod motion;

/// Transmission error by order, with names.
pub mod transmission;

/// Transmission error measured by two encoders.
pub mod encoder;

/// A machine that is ready for analysis.
pub mod machine;

/// Element by element, without a file.
pub mod builder;

/// A machine model from a file, from text or from a builder.
pub mod model;

/// A pair of cylindrical gears under load.
pub mod gear_pair;

/// Measured signals.
pub mod recording;
