//! Flags of every command that shows a result: document, files, silence.

use std::path::PathBuf;

use clap::Args;

/// Outputs of a command next to its tables. A command says in its own words what `--csv` and `--svg` hold by `mut_arg`.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Output")]
pub struct OutputArgs {
    /// One JSON document on standard output, nothing else there
    #[arg(long)]
    pub json: bool,
    /// Write the table
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Draw the result
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Write a page with tables and interactive figures, which opens in a browser without a network
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// No warnings, no word about what was done
    #[arg(long)]
    pub quiet: bool,
}
