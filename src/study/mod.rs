//! Studies over plans: what an answer costs, where methods break.

/// How long something takes.
mod timing;

/// Error against run time of a motion.
pub mod accuracy;

/// Error against run time of natural frequencies.
pub mod frequencies;

/// Where methods and machine break.
pub mod stability;

/// Stability of machines whose stiffness varies at imposed speed.
pub mod parametric;
