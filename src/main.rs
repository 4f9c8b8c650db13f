//! The `geardyn` command: parse, call, report.

use std::process::ExitCode;

use clap::Parser;
use geardyn::cli::{self, args::Arguments};

fn main() -> ExitCode {
    match Arguments::try_parse() {
        Ok(arguments) => cli::run(&arguments),
        Err(usage) => cli::usage(&usage),
    }
}
