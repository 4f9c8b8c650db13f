//! Command-line interface, one file per subcommand; the only module that uses the terminal.
//!
//! Nothing else touches the terminal.

pub mod args;

pub mod render;

pub mod interrupt;

pub mod output;

pub mod destination;

pub mod files;

pub mod footer;

pub mod browser;

pub mod progress;

pub mod present;

pub mod logs;

pub mod new;

pub mod gear;

pub mod check_log;

pub mod check;

pub mod explain;

pub mod plan;

pub mod modes;

pub mod simulate;

pub mod accuracy;

pub mod stability;

pub mod response;

pub mod measure;

pub mod te_log;

pub mod te;

pub mod run_scene;

pub mod identify;

pub mod convert;

pub mod spectrum;

pub mod manual;

use std::ffi::OsString;
use std::io;
use std::process::ExitCode;

use args::{Cli, Command};
use clap::Parser;

use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::numeric::parallel;

/// Parses the arguments, program name first, and carries out the command. Exit codes: 0 answered, 1 a bad verdict, 2 bad input or
/// usage, 3 numerical failure, 130 interrupted.
pub fn run(arguments: &[OsString]) -> ExitCode {
    let json = arguments.iter().any(|argument| argument == "--json");
    if let Err(error) = refuse_unreadable(arguments) {
        return report_error(&error.into(), json);
    }
    let command = match Cli::try_parse_from(arguments) {
        Ok(parsed) => {
            parsed
                .threads
                .into_iter()
                .map(usize::from)
                .for_each(parallel::set_threads);
            parsed.command
        }
        Err(error) => return usage(&error, json),
    };
    if json {
        destination::reserve_standard_output();
    }
    interrupt::listen(move || {
        let error = Error::new(
            Code::Interrupted,
            "interrupted before the work was finished",
        );
        let _ = report_error(&error.with_hint("output files are unchanged").into(), json);
    });
    match dispatch(&command) {
        Ok(exit) => ExitCode::from(exit),
        Err(errors) => {
            interrupt::begin_document();
            report_error(&errors, json)
        }
    }
}

/// Refuses arguments that are not UTF-8, file names among them.
fn refuse_unreadable(arguments: &[OsString]) -> Result<(), Error> {
    let unreadable = |(k, argument): (usize, &OsString)| match argument.to_str() {
        Some(_) => None,
        None => Some((k, argument.to_string_lossy().into_owned())),
    };
    match arguments.iter().enumerate().find_map(unreadable) {
        None => Ok(()),
        Some((k, shown)) => {
            let message = format!("argument {k} is not UTF-8: `{shown}`");
            Err(Error::new(Code::Usage, message).with_hint("if it names a file, rename the file"))
        }
    }
}

/// Prints why a command ended, and says with which exit code. Whoever asked for JSON reads standard output.
fn report_error(errors: &Errors, json: bool) -> ExitCode {
    let document = || format!("{:#}\n", render::json(errors));
    let printed = json && output::print(&document()).is_ok();
    if !printed {
        output::print_note(&render::render_errors(errors, render::use_colour()));
    }
    let exit = errors.as_slice().iter().map(|e| e.code.exit_code()).max();
    ExitCode::from(exit.unwrap_or(2))
}

/// Prints the usage error, as JSON where requested. Help and version are answers.
fn usage(error: &clap::Error, json: bool) -> ExitCode {
    // Printing knows whether colours suit.
    let help = !error.use_stderr();
    if help || !json {
        return match error.print() {
            Err(e) if help && e.kind() != io::ErrorKind::BrokenPipe => {
                let message = format!("standard output could not be written: {e}");
                report_error(&Error::new(Code::OutputFailed, message).into(), false)
            }
            _ if help => ExitCode::SUCCESS,
            _ => ExitCode::from(2),
        };
    }
    let text = error.render().to_string();
    // The first paragraph is the message, its arguments on lines of their own.
    let mut lines = text.trim_start_matches("error: ").lines().map(str::trim);
    let message: Vec<&str> = lines.by_ref().take_while(|line| !line.is_empty()).collect();
    let hint = lines.find_map(|line| line.strip_prefix("tip: "));
    let wrong = Error::new(Code::Usage, message.join(" ")).with_hint(hint.unwrap_or("see --help"));
    report_error(&wrong.into(), json)
}

fn dispatch(command: &Command) -> Result<u8, Errors> {
    Ok(match command {
        Command::New { file, gear } => new::run(file, gear.as_deref())?,
        Command::Check(args) => check::run(args)?,
        Command::Explain { code } => explain::run(code.as_deref())?,
        Command::Plan(args) => plan::run(args)?,
        Command::Modes(args) => modes::run(args)?,
        Command::Simulate(args) => simulate::run(args)?,
        Command::Accuracy(args) => accuracy::run(args)?,
        Command::Stability(args) => stability::run(args)?,
        Command::Response(args) => response::run(args)?,
        Command::Measure(args) => measure::run(args)?,
        Command::Gear(args) => gear::run(args)?,
        Command::Te(args) => te::run(args)?,
        Command::Run(args) => run_scene::run(args)?,
        Command::Identify(args) => identify::run(args)?,
        Command::Spectrum(args) => spectrum::run(args)?,
        Command::Convert(args) => convert::run(args)?,
        Command::Completions { shell } => manual::completions(*shell)?,
        Command::Man { folder } => manual::pages(folder)?,
    })
}
