//! Flags of `te`.

use std::path::PathBuf;

use clap::Args;

use super::encoder_args::EncoderArgs;
use super::log_args::LogArgs;

/// Arguments of `te`.
#[derive(Debug, Args)]
pub struct TeArgs {
    /// A model or a scene with declared errors, or the log of two encoders
    pub file: PathBuf,
    /// The node whose error is wanted; of a log the column of its encoder, or its two tracks
    #[arg(long, value_name = "NODE")]
    pub output: Option<String>,
    /// The node whose angle is prescribed; the first of `[speed]` where left out
    #[arg(long, value_name = "NODE")]
    pub driver: Option<String>,
    /// The node the output should turn with: the error of one against the other, such as work against cradle
    #[arg(long, value_name = "NODE")]
    pub against: Option<String>,
    /// Tell the error also as an arc at this radius of the output (mm where bare)
    #[arg(long, value_name = "LENGTH")]
    pub radius: Option<String>,
    /// Also the error at speed: speed of the first node of `[speed]` (rpm where bare)
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    pub speed: Option<String>,
    /// Every line of the table, not only the largest
    #[arg(long)]
    pub all: bool,
    /// One JSON document on standard output, nothing else there
    #[arg(long)]
    pub json: bool,
    /// Write every line
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Draw a record of encoders: the error over the angle, and its orders with their sources
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// No warnings, no word about what was done
    #[arg(long)]
    pub quiet: bool,
    /// What is said of a record of two encoders.
    #[command(flatten)]
    pub record: EncoderArgs,
    /// What may be said of the log.
    #[command(flatten)]
    pub log: LogArgs,
}
