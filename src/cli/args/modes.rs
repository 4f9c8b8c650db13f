//! Flags of `modes`, and of `plan`, which asks the same.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::motion::IntegrationArgs;
use super::output::OutputArgs;

/// What is asked of the modes.
#[derive(Debug, Args)]
pub struct ModesStudyArgs {
    /// Complex modes: damping counts
    #[arg(long)]
    pub damped: bool,
    /// Mean speed of the first node of `[speed]` (rpm where bare); gyroscopic terms count
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    pub speed: Option<String>,
    /// Modes over speed, FIRST:LAST:POINTS (rpm where bare, 50 points where left out), crossed with the orders of every gear
    #[arg(
        long,
        value_name = "A:B:N",
        allow_hyphen_values = true,
        conflicts_with = "speed"
    )]
    pub campbell: Option<String>,
    /// Only the lowest N modes
    #[arg(long, value_name = "N")]
    pub lowest: Option<u32>,
    /// Also the state-space form A, B, C, D, written to FILE (.json, .csv or .mat)
    #[arg(long, value_name = "FILE")]
    pub state_space: Option<PathBuf>,
    /// Inputs of it: freedoms such as motor.theta; all where left out
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        requires = "state_space"
    )]
    pub input: Vec<String>,
    /// Outputs of it: motor.theta, motor.theta.speed, motor.theta.acceleration, belt.force
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        requires = "state_space"
    )]
    pub output: Vec<String>,
    /// Sample it (s where bare)
    #[arg(long, value_name = "TIME", requires = "state_space")]
    pub sample_time: Option<String>,
    /// What inputs do between samples
    #[arg(long, value_enum, requires = "sample_time", default_value_t = HoldArg::Zero)]
    pub hold: HoldArg,
    /// Also a reduced machine that keeps --keep, compared with the full one up to --below
    #[arg(long, value_enum, value_name = "METHOD", requires_all = ["keep", "below"])]
    pub reduce: Option<ReductionArg>,
    /// Freedoms kept, loaded and measured
    #[arg(long, value_name = "NAMES", value_delimiter = ',', requires = "reduce")]
    pub keep: Vec<String>,
    /// The band that matters reaches up to here (Hz where bare)
    #[arg(long, value_name = "FREQUENCY", requires = "reduce")]
    pub below: Option<String>,
    /// Where `--reduce dynamic` condenses (Hz where bare)
    #[arg(long, value_name = "FREQUENCY", requires = "reduce")]
    pub condense_at: Option<String>,
    /// Modes kept by craig-bampton and modal; those below twice the band where left out
    #[arg(long, value_name = "N", requires = "reduce")]
    pub keep_modes: Option<u32>,
    /// The modes nearest a frequency (Hz where bare); as many as --lowest says, 20 otherwise
    #[arg(
        long,
        value_name = "FREQUENCY",
        allow_hyphen_values = true,
        conflicts_with = "campbell"
    )]
    pub near: Option<String>,
}

/// Words for holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum HoldArg {
    /// They stay
    Zero,
    /// They go straight to the next sample
    First,
    /// Tustin's rule
    Bilinear,
}

/// Words for reductions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ReductionArg {
    /// Static condensation
    Guyan,
    /// Condensation at --condense-at
    Dynamic,
    /// Static condensation and fixed-interface modes
    CraigBampton,
    /// Modes with a static residual
    Modal,
}

/// Arguments of `modes`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write the table of modes with their shapes")))]
#[command(mut_arg("svg", |arg| arg.help("Draw the first 8 mode shapes, and the energies of the first 20 modes beside (FILE-energies.svg); with --campbell the diagram")))]
pub struct ModesArgs {
    /// A model or a scene
    pub model: PathBuf,
    /// What is asked.
    #[command(flatten)]
    pub study: ModesStudyArgs,
    /// Show mode N at length: energies, sensitivities, shape
    #[arg(long, value_name = "N", conflicts_with = "json")]
    pub mode: Option<usize>,
    /// Only the N largest entries of every shape and list in JSON
    #[arg(long, value_name = "N", requires = "json")]
    pub top: Option<usize>,
    /// Document, files and silence.
    #[command(flatten)]
    pub out: OutputArgs,
}

/// Arguments of `plan`.
#[derive(Debug, Args)]
pub struct PlanArgs {
    /// A model or a scene
    pub model: PathBuf,
    /// What would be asked of it.
    #[command(flatten)]
    pub study: ModesStudyArgs,
    /// Also solve, and offer the freedoms that could follow statically while all frequencies up to here (Hz where bare) keep
    /// within --tolerance, then a relative change, 1e-3 where left out
    #[arg(long, value_name = "FREQUENCY")]
    pub advise: Option<String>,
    /// Of the motions it would integrate.
    #[command(flatten)]
    pub integration: IntegrationArgs,
    /// One JSON document on standard output
    #[arg(long)]
    pub json: bool,
}
