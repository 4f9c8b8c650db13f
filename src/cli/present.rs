//! The end of every command: files written, result printed, notes, exit code.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::args::OutputArgs;
use super::destination::output_error;
use super::files::{self, OutputFiles};
use super::{browser, footer, interrupt, output, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::plan::prepared_machine::PreparedMachine;
use crate::report::figure::with_log_axis;
use crate::report::page::{Section, page};
use crate::report::presentation::{Presentation, StudyReport, document};
use crate::scene::Scene;

/// The outputs of a command, checked before any work.
pub struct Outputs<'a> {
    args: &'a OutputArgs,
    files: OutputFiles,
    named: Vec<PathBuf>,
}

impl<'a> Outputs<'a> {
    /// Checks the files that the flags name: the table, a plot for each of the suffixes `figures`, and `others`.
    ///
    /// # Errors
    /// A name without a format, or a file that cannot be written or that one of `inputs` is.
    pub fn check(
        args: &'a OutputArgs,
        figures: &[&str],
        others: &[&Option<PathBuf>],
        inputs: &[PathBuf],
    ) -> Result<Outputs<'a>, Error> {
        if args.log.is_some() && args.svg.is_none() && args.page.html.is_none() {
            let message = "--log has no figure to change";
            return Err(Error::new(Code::Usage, message).with_hint("add --svg FILE or --html FILE"));
        }
        let mut named: Vec<PathBuf> = args.csv.iter().cloned().collect();
        // A device has no ending; a file of another kind is not replaced by a table.
        if let Some(path) = args.csv.as_ref().filter(|path| path.extension().is_some()) {
            files::check_extension(path, &["csv"])?;
        }
        if let Some(path) = &args.svg {
            files::check_extension(path, &["svg"])?;
            named.extend(
                figures
                    .iter()
                    .map(|suffix| files::sibling_path(path, suffix)),
            );
        }
        if let Some(path) = browser::check(&args.page)? {
            named.push(path.clone());
        }
        named.extend(others.iter().copied().flatten().cloned());
        let files = OutputFiles::new(&named, inputs)?;
        Ok(Outputs { args, files, named })
    }

    /// Whether a figure is written.
    pub fn shows_figures(&self) -> bool {
        self.args.svg.is_some() || self.args.page.html.is_some()
    }

    /// Writes a file that is neither table nor figure of the result.
    ///
    /// # Errors
    /// It cannot be written; those of `fill`.
    pub fn write(
        &mut self,
        path: &Path,
        fill: impl FnOnce(&mut dyn Write) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.files.write_with(path, fill)
    }

    /// Writes the files of a result, unless it ends early, prints it and returns the exit code.
    ///
    /// # Errors
    /// A file or standard output cannot be written.
    pub fn present(mut self, result: &dyn Presentation) -> Result<u8, Errors> {
        let (args, whole) = (self.args, result.interruption().is_none());
        let mut notes = String::new();
        // A refused axis leaves no file.
        let figures = match (self.shows_figures() && whole, args.log) {
            (false, _) => Vec::new(),
            (true, None) => result.figures()?,
            (true, Some(axis)) => with_log_axis(result.figures()?, axis)?,
        };
        if let Some(path) = args.csv.as_ref().filter(|_| whole) {
            let failed = |e| output_error(path, &e);
            let table = result.table();
            self.write(path, |to| table.write_csv(to).map_err(failed))?;
        }
        if let Some(path) = args.svg.as_ref().filter(|_| whole) {
            for figure in &figures {
                let path = files::sibling_path(path, figure.suffix);
                self.files.write(&path, figure.svg().as_bytes())?;
            }
            notes = result.figure_notes();
        }
        if let Some(path) = args.page.html.as_ref().filter(|_| whole) {
            let section = Section::new(&command_line(), result, figures);
            let title = section.title().to_string();
            self.files
                .write(path, page(&title, &command_line(), &[section]).as_bytes())?;
        }
        let written = self.files.finish()?;
        match args.json {
            true => output::document(&document(result)?)?,
            false => {
                if result.warnings_first() && !args.quiet {
                    output::print_note(&footer::warnings(result.provenance().warnings));
                }
                let title = result.provenance().title;
                let gap = if title.is_empty() { "" } else { "\n\n" };
                output::print(&format!("{title}{gap}{}", result.text()))?;
            }
        }
        if whole {
            browser::open(&args.page)?;
        }
        let not_written = footer::not_written(&self.named, whole);
        if !args.quiet && !args.json {
            notes = footer::notes(result) + &footer::written_files(&written) + &notes;
        }
        if !args.quiet {
            output::print_note(&(notes + &not_written));
        }
        Ok(exit_code(result))
    }
}

/// The command as it was typed.
pub fn command_line() -> String {
    let quoted = |text: String| match text
        .contains(|c: char| c.is_whitespace() || "'\"$&;|<>*?()".contains(c))
    {
        true => format!("'{}'", text.replace('\'', "'\\''")),
        false => text,
    };
    let arguments = std::env::args_os().skip(1);
    let typed = arguments.map(|a| quoted(a.to_string_lossy().into_owned()));
    std::iter::once("geardyn".to_string())
        .chain(typed)
        .collect::<Vec<_>>()
        .join(" ")
}

/// Solves a study on the machine of a scene; at a terminal it says what is done.
///
/// # Errors
/// Whatever is wrong with the machine, or those of `solve`.
pub fn solve<'a, R>(
    (scene, machine): (&'a Scene, &'a PreparedMachine),
    what: &'static str,
    quiet: bool,
    solve: impl FnOnce(&PreparedMachine) -> Result<R, Error>,
) -> Result<StudyReport<'a, R>, Error> {
    let result = progress::with_spinner(what, quiet, || solve(machine))?;
    Ok(StudyReport {
        scene,
        machine,
        result,
    })
}

/// The exit code of a result.
pub fn exit_code(result: &dyn Presentation) -> u8 {
    match result.interruption() {
        Some(_) => interrupt::EXIT_INTERRUPTED,
        None => result.exit_code(),
    }
}
