//! Completions and manual pages, generated from the arguments themselves.

use std::path::Path;

use clap::CommandFactory;

use super::args::Cli;
use super::files::OutputFiles;
use super::output;
use crate::base::code::Code;
use crate::base::error::Error;

/// Prints completions for a shell.
///
/// # Errors
/// Standard output cannot be written.
pub fn completions(shell: clap_complete::Shell) -> Result<u8, Error> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "geardyn", &mut text);
    output::print(&String::from_utf8_lossy(&text))?;
    Ok(0)
}

/// Writes one manual page a command.
///
/// # Errors
/// The folder cannot be written.
pub fn pages(folder: &Path) -> Result<u8, Error> {
    let failed = |e: std::io::Error| {
        Error::new(
            Code::OutputFailed,
            format!("{} could not be written: {e}", folder.display()),
        )
    };
    std::fs::create_dir_all(folder).map_err(failed)?;
    let mut root = Cli::command();
    root.build();
    let mut files = OutputFiles::default();
    let subcommands: Vec<clap::Command> = root.get_subcommands().cloned().collect();
    for command in std::iter::once(root).chain(subcommands) {
        let name = command
            .get_display_name()
            .unwrap_or(command.get_name())
            .to_string();
        let page = format!("{name}.1");
        let mut text = Vec::new();
        clap_mangen::Man::new(command)
            .render(&mut text)
            .map_err(failed)?;
        files.write(&folder.join(&page), &text)?;
    }
    output::print(&format!(
        "wrote {} pages into {}\n",
        files.finish()?.len(),
        folder.display()
    ))?;
    Ok(0)
}
