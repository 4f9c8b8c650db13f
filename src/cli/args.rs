//! Arguments as typed.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

/// Machine dynamics of gear drive trains: a model file becomes modes.
#[derive(Debug, Parser)]
#[command(
    name = "geardyn",
    version,
    about,
    max_term_width = 100,
    arg_required_else_help = true
)]
#[command(after_help = "Example:\n  geardyn modes models/y2250.toml")]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write an annotated model to start from
    #[command(after_help = "Example:\n  geardyn new my_machine.toml")]
    New {
        /// The file to write; it must not exist yet
        file: PathBuf,
    },
    /// Validate model and scene files: say what is wrong and where
    #[command(after_help = "Example:\n  geardyn check models/y2250.toml models/two_disc.toml")]
    Check {
        /// Models or scenes
        #[arg(required = true)]
        files: Vec<PathBuf>,
        /// One JSON document on standard output
        #[arg(long)]
        json: bool,
    },
    /// Explain an error code at length
    #[command(after_help = "Example:\n  geardyn explain contradictory-ratios")]
    Explain {
        /// The word in brackets behind an error; all of them where left out
        code: Option<String>,
    },
    /// Say what would be computed, what is left out and why, without computing it
    #[command(after_help = "Example:\n  geardyn plan models/y2250.toml --damped")]
    Plan {
        /// A model or a scene
        model: PathBuf,
        /// What would be asked of it.
        #[command(flatten)]
        study: StudyArgs,
        /// One JSON document on standard output
        #[arg(long)]
        json: bool,
    },
    /// Natural frequencies, damping, shapes, energies and sensitivities
    #[command(after_help = "Examples:
  geardyn modes models/y2250.toml
  geardyn modes models/y2250.toml --damped --mode 2
  geardyn modes models/uniform_chain.toml --lowest 5 --json
  geardyn modes models/overhung_rotor.toml --campbell 0:12000:61 --svg campbell.svg")]
    Modes(ModesArgs),
    /// Print completions for a shell
    #[command(after_help = "Example:\n  geardyn completions bash > geardyn.bash")]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write the manual pages into a folder
    #[command(after_help = "Example:\n  geardyn man target/man")]
    Man {
        /// The folder; made where it is missing
        folder: PathBuf,
    },
}

/// What is asked of the modes.
#[derive(Debug, Args)]
pub struct StudyArgs {
    /// Complex modes: damping counts
    #[arg(long)]
    pub damped: bool,
    /// Mean speed of the first node of [speed] (rpm where bare); gyroscopic terms count
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    pub speed: Option<String>,
    /// Modes over speed, FIRST:LAST:POINTS (rpm where bare), crossed with the orders of every gear
    #[arg(long, value_name = "A:B:N", allow_hyphen_values = true)]
    pub campbell: Option<String>,
    /// Only the lowest N modes
    #[arg(long, value_name = "N")]
    pub lowest: Option<u32>,
    /// The modes nearest a frequency (Hz where bare); as many as --lowest says, 20 otherwise
    #[arg(long, value_name = "FREQUENCY", allow_hyphen_values = true)]
    pub near: Option<String>,
}

/// Arguments of `modes`.
#[derive(Debug, Args)]
pub struct ModesArgs {
    /// A model or a scene
    pub model: PathBuf,
    /// What is asked.
    #[command(flatten)]
    pub study: StudyArgs,
    /// Show mode N at length: energies, sensitivities, shape
    #[arg(long, value_name = "N")]
    pub mode: Option<usize>,
    /// Only the N largest entries of every shape and list in JSON
    #[arg(long, value_name = "N")]
    pub top: Option<usize>,
    /// One JSON document on standard output, nothing else there
    #[arg(long)]
    pub json: bool,
    /// Write the table of modes with their shapes
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Draw the mode shapes, and the energies beside (FILE-energies.svg); with --campbell the diagram
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// No warnings, no word about what was left out
    #[arg(long)]
    pub quiet: bool,
}
