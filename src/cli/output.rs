//! Where answers go: standard output, and files that appear whole or not at all.

use std::fs::OpenOptions;
use std::io::{self, BufWriter, ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};

use super::interrupt;
use crate::base::code::Code;
use crate::base::error::Error;

/// Prints an answer. A reader that has gone away (`| head`) is no error. Names from a file may hold signs that would command a
/// terminal; they are shown as unreadable.
///
/// # Errors
/// Standard output cannot be written for another reason.
pub fn print(text: &str) -> Result<(), Error> {
    let commands = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    let text = text.replace(commands, "\u{fffd}");
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Error::new(
            Code::OutputFailed,
            format!("standard output could not be written: {e}"),
        )),
        _ => Ok(()),
    }
}

/// Says something beside the answer, on standard error. Where that cannot be written nobody reads it.
pub fn tell(text: &str) {
    let _ = io::stderr().lock().write_all(text.as_bytes());
}

/// Says on a terminal what is worked at; the next line takes its place.
pub fn working(what: &str, quiet: bool) {
    if !quiet && io::stderr().is_terminal() {
        tell(&format!("\r\x1b[K{what} …\r"));
    }
}

/// Refuses outputs that would overwrite an input or each other, or whose folder is missing, before any work is done.
///
/// # Errors
/// Names the path.
pub fn check(outputs: &[PathBuf], inputs: &[PathBuf]) -> Result<(), Error> {
    let same = |a: &Path, b: &Path| resolved(a) == resolved(b);
    for (at, path) in outputs.iter().enumerate() {
        let name = path.display();
        if path.as_os_str() == "-" {
            let message = "`-` names no file";
            return Err(Error::new(Code::Usage, message)
                .hint("name a file; --json prints to standard output"));
        }
        if is_unread_pipe(path) {
            let message = format!("{name} is a pipe, and would wait until somebody reads it");
            return Err(Error::new(Code::Usage, message).hint("name a file"));
        }
        let folder = folder(path);
        if !folder.is_dir() {
            let message = format!(
                "{name} cannot be written: there is no folder {}",
                folder.display()
            );
            return Err(Error::new(Code::OutputFailed, message).hint("make the folder first"));
        }
        if inputs.iter().any(|input| same(path, input)) {
            let message =
                format!("{name} is read by this command and would be overwritten by its output");
            return Err(Error::new(Code::Usage, message).hint("name another file"));
        }
        if outputs[..at].iter().any(|other| same(path, other)) && is_replaced(path) {
            return Err(
                Error::new(Code::Usage, format!("two outputs go to {name}")).hint("name two files")
            );
        }
    }
    Ok(())
}

/// The folder a file is in.
fn folder(path: &Path) -> &Path {
    path.parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

/// A path by which two names of one file are equal, whether it exists yet or not.
fn resolved(path: &Path) -> PathBuf {
    let of_folder = || Some(folder(path).canonicalize().ok()?.join(path.file_name()?));
    path.canonicalize()
        .ok()
        .or_else(of_folder)
        .unwrap_or(path.to_path_buf())
}

/// Refuses a name that does not end in one of the known formats.
///
/// # Errors
/// Names the path.
pub fn ends(path: &Path, known: &[&str]) -> Result<(), Error> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    if known.contains(&extension) {
        return Ok(());
    }
    let message = format!("{} does not say its format", path.display());
    Err(Error::new(Code::Usage, message).hint(format!("end it in .{}", known.join(" or ."))))
}

/// A pipe with a name of its own, not one that a shell has opened for its other end.
#[cfg(unix)]
fn is_unread_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    let is_pipe = path
        .metadata()
        .is_ok_and(|found| found.file_type().is_fifo());
    is_pipe && !path.starts_with("/dev") && !path.starts_with("/proc")
}

#[cfg(not(unix))]
fn is_unread_pipe(_: &Path) -> bool {
    false
}

/// A regular file, or none yet; devices and pipes are written to.
fn is_replaced(path: &Path) -> bool {
    path.metadata().map_or(true, |found| found.is_file())
}

/// Writes a file under a temporary name beside it, and renames it when it is whole. What is no regular file (a device, a pipe) is
/// written to as it is; a link is followed; a file that exists keeps its permissions.
///
/// # Errors
/// The folder or the file cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    write_with(path, |to| to.write_all(bytes).map_err(|e| failed(path, &e)))
}

/// As [`fn@write`], with `fill` to write what is in it, so that it need not be in memory.
///
/// # Errors
/// The folder or the file cannot be written; those of `fill`.
pub fn write_with(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> Result<(), Error>,
) -> Result<(), Error> {
    let wrong = |e: io::Error| failed(path, &e);
    if !is_replaced(path) {
        let file = OpenOptions::new().write(true).open(path).map_err(wrong)?;
        let mut to = BufWriter::new(file);
        fill(&mut to)?;
        return to.flush().map_err(wrong);
    }
    let target = path.canonicalize().unwrap_or(path.to_path_buf());
    let unnamed = builder().tempfile_in(folder(&target)).map_err(wrong)?;
    let _unfinished = interrupt::Unfinished::new(unnamed.path());
    let mut to = BufWriter::new(unnamed);
    fill(&mut to)?;
    let file = to.into_inner().map_err(|e| wrong(e.into_error()))?;
    let settled = || -> io::Result<()> {
        if let Ok(old) = target.metadata() {
            file.as_file().set_permissions(old.permissions())?;
        }
        file.as_file().sync_all()
    };
    settled().map_err(wrong)?;
    file.persist(&target).map_err(|e| wrong(e.error))?;
    Ok(())
}

/// Where one of several pictures goes: `FILE-word.svg`, without a word FILE itself.
pub fn beside(path: &Path, word: &str) -> PathBuf {
    if word.is_empty() {
        return path.to_path_buf();
    }
    let mut name = path.file_stem().unwrap_or_default().to_os_string();
    name.push(format!("-{word}.svg"));
    path.with_file_name(name)
}

fn failed(path: &Path, error: &io::Error) -> Error {
    let message = format!("{} could not be written: {error}", path.display());
    Error::new(Code::OutputFailed, message)
}

/// Temporary files are made for their owner alone; an answer has the rights of any new file.
fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".geardyn-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder
}
