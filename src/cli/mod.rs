//! The command: one file a subcommand. Nothing else touches the terminal.

/// Arguments as typed.
pub mod args;

/// Errors and warnings as text and JSON.
pub mod diagnostic;

/// Ctrl-C.
pub mod interrupt;

/// Standard output, and files that appear whole.
pub mod output;

/// What is said below an answer.
pub mod epilogue;

/// How far long work is.
pub mod progress;

/// The logs of one test.
pub mod logs;

/// Flags as a study.
pub mod study;

/// `new`.
pub mod new;

/// `check` of logs.
pub mod check_log;

/// `check`.
pub mod check;

/// `explain`.
pub mod explain;

/// Flags of motion as a study.
pub mod motion_flags;

/// `plan`.
pub mod plan;

/// `modes`.
pub mod modes;

/// `simulate`.
pub mod simulate;

/// `accuracy`.
pub mod accuracy;

/// `stability`.
pub mod stability;

/// `response`.
pub mod response;

/// `response --run-up`.
pub mod run_up;

/// `response --harmonic-balance`.
pub mod harmonic_balance;

/// `measure`.
pub mod measure;

/// `te` of a log.
pub mod te_log;

/// `te`.
pub mod te;

/// `run`.
pub mod run_scene;

/// `identify`.
pub mod identify;

/// `convert`.
pub mod convert;
/// `spectrum`.
pub mod spectrum;

/// `completions` and `man`.
pub mod manual;

use std::process::ExitCode;

use args::{Arguments, Command};

use crate::base::code::Code;
use crate::base::error::{Error, Errors};

/// Carries out a command and says how it ended: 0 answered, 1 a bad verdict, 2 bad input or usage, 3 numerical failure.
pub fn run(arguments: &Arguments) -> ExitCode {
    match carry_out(&arguments.command) {
        Ok(exit) => ExitCode::from(exit),
        Err(errors) => {
            let exit = errors
                .list()
                .iter()
                .map(|e| e.code.exit())
                .max()
                .unwrap_or(2);
            if wants_json(&arguments.command) {
                // Whoever asked for JSON reads standard output.
                let _ = output::print(&format!("{:#}\n", diagnostic::json(&errors)));
            } else {
                output::tell(&diagnostic::errors(&errors, diagnostic::colour()));
            }
            ExitCode::from(exit)
        }
    }
}

/// Says how the command is to be called: as JSON where that was asked for. Help and version are answers.
pub fn usage(error: &clap::Error) -> ExitCode {
    // Printing knows whether colours suit; where nobody reads it there is nothing to say.
    if !error.use_stderr() {
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    if std::env::args().any(|argument| argument == "--json") {
        let text = error.render().to_string();
        // The first paragraph is the message, its arguments on lines of their own.
        let mut lines = text.trim_start_matches("error: ").lines().map(str::trim);
        let message: Vec<&str> = lines.by_ref().take_while(|line| !line.is_empty()).collect();
        let hint = lines.find_map(|line| line.strip_prefix("tip: "));
        let wrong = Error::new(Code::Usage, message.join(" ")).hint(hint.unwrap_or("see --help"));
        let _ = output::print(&format!("{:#}\n", diagnostic::json(&wrong.into())));
    } else {
        let _ = error.print();
    }
    ExitCode::from(2)
}

fn carry_out(command: &Command) -> Result<u8, Errors> {
    Ok(match command {
        Command::New { file } => new::run(file)?,
        Command::Check(args) => check::run(args)?,
        Command::Explain { code } => explain::run(code.as_deref())?,
        Command::Plan(args) => plan::run(args)?,
        Command::Modes(args) => modes::run(args)?,
        Command::Simulate(args) => simulate::run(args)?,
        Command::Accuracy(args) => accuracy::run(args)?,
        Command::Stability(args) => stability::run(args)?,
        Command::Response(args) if args.harmonic_balance.is_some() => harmonic_balance::run(args)?,
        Command::Response(args) if args.run_up.is_some() => run_up::run(args)?,
        Command::Response(args) => response::run(args)?,
        Command::Measure(args) => measure::run(args)?,
        Command::Te(args) => te::run(args)?,
        Command::Run(args) => run_scene::run(args)?,
        Command::Identify(args) => identify::run(args)?,
        Command::Spectrum(args) => spectrum::run(args)?,
        Command::Convert(args) => convert::run(args)?,
        Command::Completions { shell } => manual::completions(*shell)?,
        Command::Man { folder } => manual::pages(folder)?,
    })
}

fn wants_json(command: &Command) -> bool {
    match command {
        Command::Check(args) => args.json,
        Command::Plan(args) => args.json,
        Command::Modes(args) => args.json,
        Command::Simulate(args) => args.json,
        Command::Accuracy(args) => args.json,
        Command::Stability(args) => args.json,
        Command::Response(args) => args.json,
        Command::Measure(args) => args.json,
        Command::Te(args) => args.json,
        Command::Run(args) => args.json,
        Command::Identify(args) => args.json,
        Command::Spectrum(args) => args.json,
        _ => false,
    }
}
