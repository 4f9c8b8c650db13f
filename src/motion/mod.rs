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

/// First roots of polynomials, none skipped.
pub mod bracket;

/// Taylor series of what is known and of the motion it makes.
pub mod series;

/// The methods, one file each.
pub mod methods;

/// Parametric stability, periodic orbits.
pub mod floquet;

/// What of a state is wanted.
pub mod outputs;
