//! Transmission error: how far a driven shaft is from where an ideal train would have it, `TE = θ₂ − θ₁ z₁/z₂`.

/// Measured with two encoders.
pub mod measured;
