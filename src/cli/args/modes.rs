//! Flags of `modes`, and of `plan`, which asks the same.

use std::path::PathBuf;

use clap::Args;

use super::keys::{Key, KeyFlags, KeyGroups, KeyTable, file, list, number, switch, word};
use super::motion::IntegrationKeys;
use super::output::OutputArgs;
use crate::scene::study::{InputHold, ReductionKind};

/// Keys of a study of modes.
#[derive(Debug)]
pub struct ModesKeys;

impl KeyTable for ModesKeys {
    const KEYS: KeyGroups = &[(None, MODES)];
}

#[rustfmt::skip]
const MODES: &[Key] = &[
    switch("damped", "Complex modes, including damping"),
    number("speed", "SPEED", "Mean speed of the first node of `[speed]` (default unit rpm); includes gyroscopic terms"),
    number("campbell", "A:B:N", "Modes over speed, FIRST:LAST:POINTS (default unit rpm, default 50 points), crossed with the orders of every gear"),
    number("lowest", "N", "Only the lowest N modes"),
    file("state-space", "Also the state-space form A, B, C, D, written to FILE (.json, .csv or .mat)"),
    list("input", "NAMES", "Inputs of the state-space model: degrees of freedom such as motor.theta; by default all"),
    list("output", "NAMES", "Outputs of the state-space model: motor.theta, motor.theta.speed, motor.theta.acceleration, belt.force"),
    number("sample-time", "TIME", "Sample time of the state-space model (default unit s)"),
    word::<InputHold>("hold", "HOLD", "Hold of the inputs between samples; default zero"),
    word::<ReductionKind>("reduce", "METHOD", "Also a reduced machine that keeps --keep, compared with the full one up to --below"),
    list("keep", "NAMES", "Degrees of freedom kept"),
    number("below", "FREQUENCY", "Upper end of the frequency range of interest (default unit Hz)"),
    number("condense-at", "FREQUENCY", "Frequency of the dynamic condensation (default unit Hz; with --reduce dynamic)"),
    number("keep-modes", "N", "Modes kept by craig-bampton and modal; by default those below twice the band"),
    number("near", "FREQUENCY", "Modes nearest a frequency (default unit Hz); --lowest sets their number, default 20"),
];

/// Arguments of `modes`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write the table of modes with their shapes")))]
#[command(mut_arg("svg", |arg| arg.help("Draw the first 8 mode shapes, and the energies of the first 20 modes (FILE-energies.svg); with --campbell the diagram")))]
pub struct ModesArgs {
    /// A model or a scene
    pub model: PathBuf,
    /// Keys of the study.
    #[command(flatten)]
    pub study: KeyFlags<ModesKeys>,
    /// Show mode N in detail: energies, sensitivities, shape
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
    /// A model, a scene or a gear file
    pub model: PathBuf,
    /// Keys of the study of modes.
    #[command(flatten)]
    pub study: KeyFlags<ModesKeys>,
    /// Also list the degrees of freedom that could be condensed statically with all frequencies up to this one (default unit Hz)
    /// within the relative change --tolerance (default 1e-3)
    #[arg(long, value_name = "FREQUENCY")]
    pub advise: Option<String>,
    /// Keys of the motions that would be integrated.
    #[command(flatten)]
    pub integration: KeyFlags<IntegrationKeys>,
    /// One JSON document on standard output
    #[arg(long)]
    pub json: bool,
}
