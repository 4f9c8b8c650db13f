//! Flags of `te`.

use std::path::PathBuf;

use clap::Args;

use super::encoders::EncoderTeArgs;
use super::log::LogArgs;
use super::output::OutputArgs;

/// Arguments of `te`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write every line")))]
#[command(mut_arg("svg", |arg| arg.help("Draw the lines by order, the budget beside (FILE-budget.svg), with --speeds the map (FILE-speeds.svg); of a log the error over the angle, and its orders with their sources")))]
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
    /// Draw the lines over speeds A:B:N of that node (rpm where bare), and tell where each is largest
    #[arg(long, value_name = "A:B:N", allow_hyphen_values = true)]
    pub speeds: Option<String>,
    /// Whole turns of the output over which ranges are told; 1 where left out, of a record the full common period
    #[arg(long, value_name = "TURNS", value_parser = clap::value_parser!(u32).range(1..))]
    pub window: Option<u32>,
    /// The work is indexed tooth by tooth: the element behind which it moves on, and its teeth, such as differential:37
    #[arg(long, value_name = "ELEMENT:TEETH")]
    pub index: Option<String>,
    /// Teeth of the output, by which --record is told tooth by tooth; those of the gear that turns with it where left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub output_teeth: Option<u32>,
    /// Write the error over the angle; unknown phases are drawn, the same at every call
    #[arg(long = "record", value_name = "FILE")]
    pub written: Option<PathBuf>,
    /// Every line of the table, not only the largest; of a log every multiple of the shafts is fitted as well
    #[arg(long)]
    pub all: bool,
    /// Document, files and silence.
    #[command(flatten)]
    pub out: OutputArgs,
    /// What is said of a record of two encoders.
    #[command(flatten)]
    pub record: EncoderTeArgs,
    /// What may be said of the log.
    #[command(flatten)]
    pub log: LogArgs,
}
