//! Natural modes: real and complex, few or all, with energies and sensitivities.

/// One mode.
pub mod mode;

/// All undamped modes, in factored form.
pub mod basis;

/// Undamped modes over all freedoms.
pub mod undamped;

/// A few modes of a large machine.
pub mod lowest;

/// The machine in modal coordinates.
pub mod modal;

/// Modes that gyrate and lose nothing.
pub mod gyroscopic;

/// Massless coordinates in modal equations.
mod massless;

/// Modal equations in first-order form.
mod companion;

/// Rigid motions that gyroscopic terms couple to others: both roots stay zero.
mod conserved;

/// Complex modes.
pub mod damped;

/// Orders of excitation.
pub mod orders;

/// Following modes from speed to speed.
pub mod tracking;

/// Forward and backward whirl.
pub mod whirl;

/// Where modes meet orders.
pub mod crossings;

/// Campbell diagrams.
pub mod campbell;

/// Energy shares.
pub mod energy;

/// What a frequency depends on.
pub mod sensitivity;

/// Equations of motion as dense matrices, over any coordinates.
pub mod equations;

/// The state-space form.
pub mod state_space;

/// Fewer coordinates, and what that costs.
pub mod reduction;
