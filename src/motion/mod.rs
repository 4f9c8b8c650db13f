//! Integration in time: machines in motion, and plain first-order problems.

/// Known functions of time.
pub mod signal;

/// Periodic functions of a phase.
pub mod wave;

/// Contacts with play.
pub mod contact;

/// Dry friction.
pub mod friction;

/// Torque over speed.
pub mod curve;

/// What methods take and give.
pub mod problem;

/// A machine in motion.
pub mod train;

/// Exact motion from switch to switch.
pub mod segment;

/// The methods, one file each.
pub mod methods;

/// What of a state is wanted.
pub mod outputs;
