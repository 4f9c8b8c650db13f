//! The `geardyn` command: parse, call, report.

use std::ffi::OsString;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    geardyn::run_command(&arguments)
}
