//! What turns with a shaft: its angle from a tacho or an encoder, signals over angle instead of time, orders, averages over revolutions,
//! and what repeats set apart from what does not.

/// Crossings of a level, with hysteresis.
pub mod edges;

/// Pulses of a tacho: counted, the missing and the extra ones found.
pub mod tacho;

/// The angle of a shaft as a function of time.
pub mod angle;

/// Incremental encoders: counters and quadrature.
pub mod encoder;

/// Band-limited interpolation between samples.
pub mod interpolation;

/// Signals at equal steps of angle.
pub mod angular;

/// Order spectra and order tracks.
pub mod orders;

/// Orders of signals while they arrive.
pub mod demodulation;

/// Averages over revolutions.
pub mod averaging;

/// What repeats and what is random.
pub mod separation;
