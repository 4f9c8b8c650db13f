//! The state-space form `ẋ = A x + B u`, `y = C x + D u` of a machine, between named inputs and outputs.

pub mod signals;

pub mod first_order;

mod system;

mod discrete;

pub mod participation;

mod export;

pub use system::StateSpace;
