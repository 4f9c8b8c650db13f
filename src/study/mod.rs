//! Studies over plans: what an answer costs, where methods break.

/// Who watches.
pub mod watch;

/// How long something takes.
mod timing;

/// The sizes of states without rigid motion.
mod elastic_sizes;

/// One run of a method.
mod trial;

/// What errors are measured against.
pub mod reference;

/// Error against run time of a motion.
pub mod accuracy;

/// Ways to one answer.
pub mod ways;

/// Error against run time of natural frequencies.
pub mod frequencies;

/// Error against run time of frequency responses.
pub mod responses;

/// Where methods and machine break.
pub mod stability;

/// Stability of machines whose stiffness varies at imposed speed.
pub mod parametric;

/// What the studies of a scene would refuse.
pub mod check;
