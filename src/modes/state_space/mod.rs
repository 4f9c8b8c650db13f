//! The state-space form `ẋ = A x + B u`, `y = C x + D u` of a machine, between named inputs and outputs.

/// Signals by name.
pub mod signals;

/// Second-order equations with massless coordinates as first-order ones.
pub mod first_order;

/// The form itself.
mod system;

/// Discrete in time.
mod discrete;

/// What reaches and shows each mode.
pub mod participation;

/// JSON, CSV and MATLAB files.
mod export;

pub use system::StateSpace;
