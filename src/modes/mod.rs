//! Natural modes: real and complex, few or all, with energies and sensitivities.

pub mod mode;

pub mod modal_basis;

pub mod undamped;

pub mod mode_subset;

pub mod modal_matrices;

pub mod gyroscopic;

mod massless;

mod companion;

mod conserved;

pub mod damped;

pub mod excitation_orders;

pub mod tracking;

pub mod whirl;

pub mod crossings;

pub mod campbell;

pub mod energy;

pub mod sensitivity;

pub mod system_matrices;

pub mod state_space;

pub mod reduction;
