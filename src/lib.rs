//! Machine dynamics and transmission error of gear drive trains: natural modes, frequency responses, motion in time and transmission
//! error of machine models; spectra and modal parameters of measured logs.
//!
//! [`prelude`] holds what most programs need; the tutorial is docs/library.md.
//!
//! The private modules are floors: each imports only from those above it in this list.

#![warn(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

/// Errors with places and hints; units; TOML with places.
mod base;

/// Linear algebra, without knowledge of files, gears or the terminal.
mod numeric;

/// Records of transmission error: ranges, waves, harmonics.
mod te_record;

/// Logs of measured signals and their sidecars.
mod recording;

/// Spectral estimation: line and density spectra, frequency responses, orders.
mod spectrum;

/// From measured responses to transfer functions and modes.
mod identify;

/// Transmission error from the records of two encoders.
mod encoder;

/// Gears by themselves: knows neither files nor dynamics.
mod gear;

/// Model and scene files as written.
mod scene;

/// Masses and branches.
mod machine;

/// Natural modes.
mod modes;

/// Integration in time.
mod motion;

/// Steady-state response over frequency and speed.
mod response;

/// Transmission error: chain, orders, budget.
mod transmission;

/// Stages of each study, and their run.
mod plan;

/// Error against run time, where methods break.
mod study;

/// Results as tables, JSON, CSV and plots.
mod report;

/// The library's surface.
mod api;

/// The command: the only place that touches the terminal.
#[cfg(feature = "cli")]
mod cli;

pub use api::builder::ModelBuilder;
pub use api::encoder::{MeasuredFlank, MeasuredOrder, MeasuredTransmissionError};
pub use api::gear_pair::{GearMesh, GearPair};
pub use api::machine::Machine;
pub use api::model::Model;
pub use api::modes::{
    Campbell, CampbellCrossing, ModalSensitivity, Mode, Modes, StateSpaceMatrices,
};
pub use api::motion::{Motion, MotionOutput};
pub use api::reduction::Reduction;
pub use api::response::{Response, ResponseFunction, ResponsePeak};
pub use api::transmission::{AmplitudesOverSpeed, ErrorRecord, OrderComponent, TransmissionError};
pub use base::code::Code;
pub use base::error::{Diagnostic, Error, Errors};
pub use encoder::gear_train::GearTrain;
pub use gear::load::compliance::StiffnessMethod;
pub use gear::load::mesh_result::LoadedCycle;
pub use identify::modal_parameters::ModalParameters;
pub use identify::rational::DelayModel;
pub use identify::transfer::function::TransferFunction;
pub use modes::campbell::CampbellBranch;
pub use modes::reduction::BandError;
pub use modes::sensitivity::SensitivityParameter;
pub use modes::whirl::Whirl;
pub use motion::energy_balance::EnergyBalance;
pub use numeric::Complex;
pub use plan::logs::encoder_study::EncoderStudy;
pub use plan::logs::frf_estimation::FrfStudy;
pub use plan::logs::identification_result::{IdentificationResult, IdentifiedMode};
pub use plan::logs::identify_study::IdentifyStudy;
pub use plan::logs::method::IdentificationMethod;
pub use plan::logs::spectrum_study::{
    AbscissaKind, ChannelSpectrum, LabelledPeak, SpectrumKind, SpectrumResult, SpectrumStudy,
};
pub use recording::frequency_responses::{ChannelLabel, FrequencyResponse, FrequencyResponses};
pub use recording::raw::Repair;
pub use recording::signals::{Channel, Recording};
pub use scene::mesh_table::MeshStudy;
pub use scene::study::{
    IndexingStudy, InputHold, ModesStudy, OnlineStudy, OrderTrackingStudy, ReductionKind,
    ReductionStudy, ResponseMethodTag, ResponseQuantity, ResponseStudy, SimulateStudy, SpeedRange,
    StateSpaceStudy, TransmissionStudy,
};
pub use spectrum::frf::Estimator;
pub use spectrum::integrate::MotionQuantity;
pub use spectrum::line_labels::ExpectedLine;
pub use spectrum::welch::{Averaging, Detrend};
pub use spectrum::window::Window;

/// The programs of the library's tutorial and of the README, run as tests.
#[doc = include_str!("../docs/library.md")]
#[doc = include_str!("../README.md")]
#[cfg(doctest)]
struct Tutorial;

/// The types most programs use: models, machines, gear pairs, recordings, the studies they take, errors.
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
    pub use crate::{
        EncoderStudy, Errors, GearPair, IdentifyStudy, Machine, MeshStudy, Model, ModelBuilder,
        ModesStudy, Recording, ResponseStudy, SimulateStudy, SpectrumStudy, TransmissionStudy,
    };
}

/// The floors of the house, for the tests and benchmarks of this project and for nothing else: no promise of stability.
#[doc(hidden)]
#[allow(missing_docs, reason = "the floors have their own")]
pub mod internals {
    pub mod base {
        pub use crate::base::*;
    }
    pub mod numeric {
        pub use crate::numeric::*;
    }
    pub mod te_record {
        pub use crate::te_record::*;
    }
    pub mod recording {
        pub use crate::recording::*;
    }
    pub mod spectrum {
        pub use crate::spectrum::*;
    }
    pub mod identify {
        pub use crate::identify::*;
    }
    pub mod encoder {
        pub use crate::encoder::*;
    }
    pub mod gear {
        pub use crate::gear::*;
    }
    pub mod scene {
        pub use crate::scene::*;
    }
    pub mod machine {
        pub use crate::machine::*;
    }
    pub mod modes {
        pub use crate::modes::*;
    }
    pub mod motion {
        pub use crate::motion::*;
    }
    pub mod response {
        pub use crate::response::*;
    }
    pub mod transmission {
        pub use crate::transmission::*;
    }
    pub mod plan {
        pub use crate::plan::*;
    }
    pub mod study {
        pub use crate::study::*;
    }
    pub mod report {
        pub use crate::report::*;
    }
    #[cfg(feature = "cli")]
    pub mod cli {
        pub use crate::cli::*;
    }
}

/// Runs the command on the arguments of the process, the program's name first.
#[cfg(feature = "cli")]
#[doc(hidden)]
pub use cli::run as run_command;
