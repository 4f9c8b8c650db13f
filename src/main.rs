//! The `geardyn` command: parse, call, report.

use std::process::ExitCode;

use clap::Parser;
use geardyn::cli::{self, args::Arguments};

fn main() -> ExitCode {
    cli::run(&Arguments::parse())
}
