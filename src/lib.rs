//! Machine dynamics and transmission error of gear drive trains.
//!
//! The modules are floors: each imports only from those above it in this list.

#![warn(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

/// Errors with places and hints; units; TOML with places.
pub mod base;

/// Linear algebra, without knowledge of files, gears or the terminal.
pub mod numeric;

/// Logs of measured signals.
pub mod recording;

/// What frequencies are in a signal.
pub mod spectrum;

/// From measured responses to transfer functions and modes.
pub mod identify;

/// Gears by themselves: knows neither files nor dynamics.
pub mod gear;

/// Model and scene files as written.
pub mod scene;

/// Masses and branches.
pub mod machine;

/// Natural modes.
pub mod modes;

/// Integration in time.
pub mod motion;

/// Steady answers to steady excitation, by frequency.
pub mod response;

/// Transmission error: chain, orders, budget.
pub mod transmission;

/// What a study needs, and running it.
pub mod plan;

/// Error against run time, where methods break.
pub mod study;

/// Results as tables, JSON, CSV and plots.
pub mod report;

/// The library's surface.
pub mod api;

/// The command: the only place that touches the terminal.
#[cfg(feature = "cli")]
pub mod cli;

pub use api::builder::ModelBuilder;
pub use api::machine::Machine;
pub use api::model::Model;
pub use base::error::Errors;
pub use recording::signals::Recording;

/// The programs of the library's tutorial and of the README, run as tests.
#[doc = include_str!("../docs/library.md")]
#[doc = include_str!("../README.md")]
#[cfg(doctest)]
struct Tutorial;

/// What most programs need: models, machines, recordings, the studies they take, errors.
///
/// ```
/// use geardyn::prelude::*;
///
/// let machine = Model::open("models/two_disc.toml")?.machine()?;
/// let modes = machine.modes(&ModesStudy::default())?;
/// assert!(modes[0].is_rigid);
/// # Ok::<(), Errors>(())
/// ```
pub mod prelude {
    pub use crate::plan::logs::identify_study::IdentifyStudy;
    pub use crate::plan::logs::spectrum_study::SpectrumStudy;
    pub use crate::scene::study::{ModesStudy, ResponseStudy, SimulateStudy, TransmissionStudy};
    pub use crate::{Errors, Machine, Model, ModelBuilder, Recording};
}
