//! Steady answers to steady excitation: what they need, and running them.

/// How a response is found, and what is left out.
pub mod choice;

/// The run.
pub mod run;

/// Periodic motions over speed.
pub mod harmonic_balance;

/// Run-up maps.
pub mod run_up;
