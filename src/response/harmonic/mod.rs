//! Periodic motions of machines with play, clearance, dry friction and stiffness that varies, over speed: a balance of orders
//! with alternating frequency and time, followed by arc length; refined and judged by events and Floquet multipliers.

/// Without free turning.
pub mod relative;

/// One machine at every speed.
pub mod family;

/// The linear part.
pub mod lines;

/// Putting it together.
mod setup;

/// Forces from time to orders.
mod alternating;

/// The equations.
mod balance;

/// Multipliers.
mod multipliers;

/// One solution with all that is known of it.
pub mod point;

/// Steps along the curve.
mod follower;

/// Folds and bifurcations.
pub mod special;

/// Motions of two periods.
pub mod doubled;

/// The curve.
pub mod curve;
