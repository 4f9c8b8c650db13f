//! Destination of an output: a regular file that is replaced as a whole, or a device or pipe that is written to directly.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::base::code::Code;
use crate::base::error::Error;

/// Destination of the bytes of an output.
#[derive(Debug, Clone, PartialEq)]
pub enum Destination {
    /// A regular file, existing or new, with all links resolved: replaced by the complete output.
    File(PathBuf),
    /// A device, a pipe, or an open file by its `/dev` or `/proc` name: written to directly.
    Stream,
    /// A named pipe, written to directly; requires a waiting reader.
    Pipe,
}

/// True if standard output is reserved for a JSON document.
static RESERVED: AtomicBool = AtomicBool::new(false);

/// Reserves standard output for a JSON document: later output files must not resolve to it.
pub fn reserve_standard_output() {
    RESERVED.store(true, Ordering::Relaxed);
}

impl Destination {
    /// Determines the destination of a path.
    ///
    /// # Errors
    /// The path is empty, `-`, a folder, an unresolved link or a read-only file; its folder is missing; or it is standard output while
    /// that is reserved.
    pub fn from_path(path: &Path) -> Result<Destination, Error> {
        let name = path.display();
        let usage =
            |message: String, hint: &str| Err(Error::new(Code::Usage, message).with_hint(hint));
        if path.as_os_str() == "-" {
            return usage(
                "`-` is not a file name".into(),
                "name a file; --json prints to standard output",
            );
        }
        if path.as_os_str().is_empty() {
            return usage("an output has an empty name".into(), "name a file");
        }
        if path.is_dir() || path.as_os_str().as_encoded_bytes().ends_with(b"/") {
            return usage(format!("{name} is a folder"), "name a file in it");
        }
        let folder = folder(path);
        if !folder.is_dir() {
            let message = format!(
                "{name} cannot be written: there is no folder {}",
                folder.display()
            );
            return Err(Error::new(Code::OutputFailed, message).with_hint("create the folder"));
        }
        match path.metadata() {
            Ok(_) if RESERVED.load(Ordering::Relaxed) && is_standard_output(path) => usage(
                format!("{name} is standard output, which --json uses"),
                "name a file, or omit --json",
            ),
            Err(e) if path.is_symlink() => {
                let target = path.read_link().unwrap_or_default();
                let message = format!(
                    "{name} is a link to {}, which does not resolve: {e}",
                    target.display()
                );
                Err(Error::new(Code::OutputFailed, message)
                    .with_hint("remove the link, or create its target"))
            }
            Err(e) if e.kind() != io::ErrorKind::NotFound => Err(output_error(path, &e)),
            Ok(_) if is_open_file(path) => Ok(Destination::Stream),
            Ok(_) if is_named_pipe(path) => Ok(Destination::Pipe),
            Ok(metadata) if !metadata.is_file() => Ok(Destination::Stream),
            Ok(metadata) if metadata.permissions().readonly() => usage(
                format!("{name} is read-only and would be replaced"),
                "name another file, or make this one writable",
            ),
            _ => resolve_links(path)
                .map(Destination::File)
                .map_err(|e| output_error(path, &e)),
        }
    }
}

/// Folder of a file; `.` for a bare file name.
pub fn folder(path: &Path) -> &Path {
    path.parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

/// Path with all links resolved; the file itself need not exist.
///
/// # Errors
/// The folder does not exist.
pub fn resolve_links(path: &Path) -> io::Result<PathBuf> {
    let in_folder = || {
        Ok(folder(path)
            .canonicalize()?
            .join(path.file_name().unwrap_or_default()))
    };
    path.canonicalize().or_else(|_| in_folder())
}

/// Error of an output that could not be written.
pub fn output_error(path: &Path, error: &io::Error) -> Error {
    let message = format!("{} could not be written: {error}", path.display());
    Error::new(Code::OutputFailed, message).with_hint("name a file in a writable folder")
}

/// Maximum number of links followed, as in Linux (path_resolution(7)).
const MAX_LINKS: usize = 40;

/// True for names such as `/dev/stdout` or `/dev/fd/3`, system links to an open file.
fn is_open_file(path: &Path) -> bool {
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        let (Ok(folder), Ok(target)) = (folder(&path).canonicalize(), path.read_link()) else {
            return false;
        };
        if folder == Path::new("/dev") || folder.starts_with("/proc") {
            return true;
        }
        path = folder.join(target);
    }
    false
}

/// True for standard output, whether terminal, pipe or file; false for the null device, which accepts any output.
#[cfg(unix)]
fn is_standard_output(path: &Path) -> bool {
    use std::os::fd::AsFd;
    use std::os::unix::fs::MetadataExt;
    let stdout = io::stdout().as_fd().try_clone_to_owned().map(File::from);
    let (Ok(stdout), Ok(metadata)) = (stdout.and_then(|f| f.metadata()), path.metadata()) else {
        return false;
    };
    let null = path
        .canonicalize()
        .is_ok_and(|p| p == Path::new("/dev/null"));
    !null && (metadata.dev(), metadata.ino()) == (stdout.dev(), stdout.ino())
}

#[cfg(not(unix))]
fn is_standard_output(_: &Path) -> bool {
    false
}

/// Opens a device, a pipe or an open file for appending. Standard output and standard error keep their position.
///
/// # Errors
/// It cannot be opened.
#[cfg(unix)]
pub fn open_stream(path: &Path) -> io::Result<File> {
    use std::os::fd::AsFd;
    use std::os::unix::fs::MetadataExt;
    let target = path.metadata()?;
    for stream in [
        io::stdout().as_fd().try_clone_to_owned(),
        io::stderr().as_fd().try_clone_to_owned(),
    ] {
        let stream = File::from(stream?);
        let metadata = stream.metadata()?;
        if (metadata.dev(), metadata.ino()) == (target.dev(), target.ino()) {
            return Ok(stream);
        }
    }
    OpenOptions::new().append(true).open(path)
}

/// Opens a device or a pipe.
///
/// # Errors
/// It cannot be opened.
#[cfg(not(unix))]
pub fn open_stream(path: &Path) -> io::Result<File> {
    OpenOptions::new().append(true).open(path)
}

/// Opens a named pipe for writing. The first, non-blocking opening fails with ENXIO if no reader waits; the second opening is for
/// blocking writes.
///
/// # Errors
/// No reader waits at the pipe, or the pipe cannot be opened.
#[cfg(unix)]
pub fn open_pipe(path: &Path) -> Result<File, Error> {
    use std::os::unix::fs::OpenOptionsExt;
    let probe = OpenOptions::new()
        .write(true)
        .custom_flags(libc::O_NONBLOCK)
        .open(path);
    match probe {
        Err(e) if e.raw_os_error() == Some(libc::ENXIO) => {
            let message = format!(
                "{} is a named pipe without a reader, and writing to it would block",
                path.display()
            );
            Err(Error::new(Code::Usage, message)
                .with_hint("start its reader first, or name a file"))
        }
        Err(e) => Err(output_error(path, &e)),
        // The first opening lasts until the second, so that the reader does not receive an end of file.
        Ok(_first) => OpenOptions::new()
            .write(true)
            .open(path)
            .map_err(|e| output_error(path, &e)),
    }
}

/// Opens a named pipe.
///
/// # Errors
/// The pipe cannot be opened.
#[cfg(not(unix))]
pub fn open_pipe(path: &Path) -> Result<File, Error> {
    open_stream(path).map_err(|e| output_error(path, &e))
}

/// True for a named pipe; false for a pipe that a shell has opened as a file descriptor.
#[cfg(unix)]
fn is_named_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    let is_pipe = path
        .metadata()
        .is_ok_and(|metadata| metadata.file_type().is_fifo());
    is_pipe && !is_open_file(path)
}

#[cfg(not(unix))]
fn is_named_pipe(_: &Path) -> bool {
    false
}
