//! Where methods and machine break: the linear facts, and the scene rerun at its extremes.

/// What a step of a method makes of a mode.
pub mod amplification;

/// The linear facts.
pub mod facts;

/// What extremes make of a scene.
pub mod cases;

/// The reruns.
pub mod extremes;
