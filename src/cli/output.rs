//! Where answers go: standard output, and files that appear whole or not at all.

use std::io::{self, ErrorKind, Write};
use std::path::Path;

use crate::base::code::Code;
use crate::base::error::Error;

/// Prints an answer. A reader that has gone away (`| head`) is no error.
///
/// # Errors
/// Standard output cannot be written for another reason.
pub fn print(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Error::new(
            Code::OutputFailed,
            format!("standard output could not be written: {e}"),
        )),
        _ => Ok(()),
    }
}

/// Writes a file under a temporary name beside it, and renames it when it is whole.
///
/// # Errors
/// The folder or the file cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let whole = || -> io::Result<()> {
        let mut file = tempfile::Builder::new()
            .prefix(".geardyn-")
            .tempfile_in(folder)?;
        file.write_all(bytes)?;
        file.as_file().sync_all()?;
        readable_by_others(&file)?;
        file.persist(path).map_err(|e| e.error)?;
        Ok(())
    };
    whole().map_err(|e| {
        Error::new(
            Code::OutputFailed,
            format!("{} could not be written: {e}", path.display()),
        )
    })
}

/// Temporary files are made for their owner alone; an answer has the rights of any new file.
#[cfg(unix)]
fn readable_by_others(file: &tempfile::NamedTempFile) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.as_file()
        .set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable_by_others(_: &tempfile::NamedTempFile) -> io::Result<()> {
    Ok(())
}
