//! Studies over plans: what an answer costs, where methods break.

/// Error against run time.
pub mod accuracy;

/// Where methods and machine break.
pub mod stability;
