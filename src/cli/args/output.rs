//! Flags of every command that shows a result: document, files, silence.

use std::path::PathBuf;

use clap::Args;

use super::keys::word_parser;
use crate::base::table_reader::Word;
use crate::report::figure::LogAxis;

/// The page of a command.
#[derive(Debug, Clone, Default, Args)]
pub struct PageArgs {
    /// Write a page with tables and interactive figures, which opens in a browser without a network
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Open the page of --html in the default browser
    #[arg(long, requires = "html")]
    pub open: bool,
}

/// Outputs of a command next to its tables. A command says in its own words what `--csv` and `--svg` hold by `mut_arg`.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Output")]
pub struct OutputArgs {
    /// Print one JSON document, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
    /// Write the table
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Draw the result
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Logarithmic abscissa (x) or ordinate (y) of the first figure; rejected if the axis has values of zero or less
    #[arg(long, value_parser = word_parser::<LogAxis>(), value_name = "AXIS")]
    pub log: Option<LogAxis>,
    /// The page.
    #[command(flatten)]
    pub page: PageArgs,
    /// Print no warnings, no progress and no notes
    #[arg(long)]
    pub quiet: bool,
}

#[rustfmt::skip]
impl Word for LogAxis {
    const WORDS: &'static [(&'static str, LogAxis, &'static str)] = &[
        ("x", LogAxis::X, "The abscissa of the first figure"),
        ("y", LogAxis::Y, "The ordinate of its first plot"),
    ];
}
