//! The page of a command in the default browser, by the opener of the platform.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::args::PageArgs;
use super::destination::Destination;
use super::files;
use crate::base::code::Code;
use crate::base::error::Error;

/// The program that opens a file in the application it belongs to, and its arguments before the file.
const OPENER: (&str, &[&str]) = if cfg!(windows) {
    ("rundll32.exe", &["url.dll,FileProtocolHandler"])
} else if cfg!(target_os = "macos") {
    ("open", &[])
} else {
    ("xdg-open", &[])
};

/// The file of the page, checked before any work.
///
/// # Errors
/// Its suffix is another one; with `--open`, nothing opens files, or the page is not written to a file.
pub fn check(args: &PageArgs) -> Result<Option<&PathBuf>, Error> {
    let Some(path) = &args.html else {
        return Ok(None);
    };
    files::check_extension(path, &["html"])?;
    if args.open
        && matches!(
            Destination::from_path(path),
            Ok(Destination::Stream | Destination::Pipe)
        )
    {
        let message = format!("{} cannot be opened in a browser", path.display());
        return Err(Error::new(Code::Usage, message).with_hint("name a file, or omit --open"));
    }
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let is_here = || std::env::split_paths(&folders).any(|folder| folder.join(OPENER.0).is_file());
    if args.open && !is_here() {
        return Err(no_opener(path, "it is not on the PATH"));
    }
    Ok(Some(path))
}

/// Opens the page where that is requested, and does not wait for the browser.
///
/// # Errors
/// The opener does not start.
pub fn open(args: &PageArgs) -> Result<(), Error> {
    let Some(path) = args.html.as_ref().filter(|_| args.open) else {
        return Ok(());
    };
    let (program, before) = OPENER;
    let mut command = Command::new(program);
    command.args(before).arg(path);
    command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let started = command.spawn().map(drop);
    started.map_err(|e| no_opener(path, &e.to_string()))
}

fn no_opener(path: &Path, why: &str) -> Error {
    let message = format!("{} cannot open the page: {why}", OPENER.0);
    let hint = format!("omit --open and open {} in a browser", path.display());
    Error::new(Code::Usage, message).with_hint(hint)
}
