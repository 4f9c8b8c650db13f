//! Motion of a machine: what is assembled, by which method it runs, what is kept.

/// What is wanted of a motion, by name.
pub mod wanted;

/// A scene ready to move.
pub mod scene;

/// What kind of equations a machine has.
pub mod structure;

/// What dense matrices cost.
pub mod dense;

/// Which method, and why.
pub mod choice;

/// Its stages.
pub mod stages;

/// What it costs at least.
pub mod cost;

/// What can be read off an output.
pub mod reading;

/// Whether samples follow it.
pub mod fineness;

/// The run.
pub mod run;

/// Statistics of what cannot be predicted.
pub mod statistics;

/// How it amplifies a change of its start.
pub mod sensitivity;
