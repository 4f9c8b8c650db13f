//! Output files of a run: each is written under a temporary name; all are renamed when all are complete.

use std::fs::{DirEntry, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::destination::{
    Destination, folder, open_pipe, open_stream, output_error, resolve_links,
};
use super::interrupt;
use crate::base::code::Code;
use crate::base::error::Error;

/// Output files of a run; files of a run that fails are removed.
#[derive(Debug, Default)]
pub struct OutputFiles {
    /// Named pipes, opened at the start so that their readers wait for the data.
    pipes: Vec<(PathBuf, File)>,
    complete: Vec<(NamedTempFile, PathBuf)>,
    written: Vec<PathBuf>,
}

impl OutputFiles {
    /// Checks the outputs before the computation, and removes the temporary files of killed runs from their folders.
    ///
    /// # Errors
    /// An output is not a valid [`Destination`], its folder is not writable, or it would overwrite an input or another output.
    pub fn new(outputs: &[PathBuf], inputs: &[PathBuf]) -> Result<OutputFiles, Error> {
        let mut files = OutputFiles::default();
        let mut targets: Vec<PathBuf> = Vec::new();
        for path in outputs {
            let name = path.display();
            let destination = Destination::from_path(path)?;
            let is_output = |input: &PathBuf| resolve_links(input).ok() == resolve_links(path).ok();
            if inputs.iter().any(is_output) {
                let message = format!(
                    "{name} is read by this command and would be overwritten by its output"
                );
                return Err(Error::new(Code::Usage, message).with_hint("name another file"));
            }
            let target = match destination {
                Destination::File(target) => target,
                Destination::Pipe => {
                    files.pipes.push((path.clone(), open_pipe(path)?));
                    continue;
                }
                Destination::Stream => continue,
            };
            if targets.contains(&target) {
                let message = format!("two outputs are written to {name}");
                return Err(Error::new(Code::Usage, message).with_hint("name two files"));
            }
            remove_stale(folder(&target));
            // A folder that is not writable is reported before the computation.
            temporary(folder(&target)).map_err(|e| output_error(path, &e))?;
            targets.push(target);
        }
        Ok(files)
    }

    /// Writes a file that takes its name in [`OutputFiles::finish`]; a device or pipe is written immediately.
    ///
    /// # Errors
    /// The folder or the file cannot be written.
    pub fn write(&mut self, path: &Path, bytes: &[u8]) -> Result<(), Error> {
        self.write_with(path, |writer| {
            writer.write_all(bytes).map_err(|e| output_error(path, &e))
        })
    }

    /// Writes as [`OutputFiles::write`], with the contents streamed by `fill` rather than held in memory.
    ///
    /// # Errors
    /// The folder or the file cannot be written; errors of `fill`.
    pub fn write_with(
        &mut self,
        path: &Path,
        fill: impl FnOnce(&mut dyn Write) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let io_error = |e: io::Error| output_error(path, &e);
        match Destination::from_path(path)? {
            Destination::Stream | Destination::Pipe => {
                let pipe = self.pipes.iter().position(|(name, _)| name == path);
                let stream = match pipe {
                    Some(index) => self.pipes.swap_remove(index).1,
                    None => open_stream(path).map_err(io_error)?,
                };
                let mut writer = BufWriter::new(stream);
                fill(&mut writer)?;
                writer.flush().map_err(io_error)?;
            }
            Destination::File(target) => {
                let file = temporary(folder(&target)).map_err(io_error)?;
                interrupt::register(file.path());
                let mut writer = BufWriter::new(file);
                fill(&mut writer)?;
                let file = writer.into_inner().map_err(|e| io_error(e.into_error()))?;
                sync_file(file.as_file(), &target).map_err(io_error)?;
                self.complete.push((file, target));
            }
        }
        self.written.push(path.to_path_buf());
        Ok(())
    }

    /// Renames every file to its target and returns the paths written.
    ///
    /// # Errors
    /// A file cannot be renamed.
    pub fn finish(self) -> Result<Vec<PathBuf>, Error> {
        interrupt::commit(|| {
            for (file, target) in self.complete {
                file.persist(&target)
                    .map_err(|e| output_error(&target, &e.error))?;
            }
            Ok(())
        })?;
        Ok(self.written)
    }
}

/// Writes a single file.
///
/// # Errors
/// As for [`OutputFiles::new`] and [`OutputFiles::write`].
pub fn write_one(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let mut files = OutputFiles::new(&[path.to_path_buf()], &[])?;
    files.write(path, bytes)?;
    files.finish().map(drop)
}

/// Checks that the extension of a path is one of the known formats.
///
/// # Errors
/// `Usage` for another extension.
pub fn check_extension(path: &Path, known: &[&str]) -> Result<(), Error> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    if known.contains(&extension) {
        return Ok(());
    }
    let message = format!("the suffix of {} names no format", path.display());
    Err(Error::new(Code::Usage, message).with_hint(format!("end it in .{}", known.join(" or ."))))
}

/// Path of one of several figures: `FILE-word.svg`, or FILE itself for an empty word.
pub fn sibling_path(path: &Path, word: &str) -> PathBuf {
    if word.is_empty() {
        return path.to_path_buf();
    }
    let mut name = path.file_stem().unwrap_or_default().to_os_string();
    name.push(format!("-{word}.svg"));
    path.with_file_name(name)
}

/// Prefix of temporary file names, followed by [`TEMP_RANDOM`] letters and digits and the suffix.
const TEMP_PREFIX: &str = ".geardyn-";
const TEMP_RANDOM: usize = 12;
const TEMP_SUFFIX: &str = ".partial";

/// Whether a name has the exact pattern of our temporary files.
fn is_temporary_name(name: &str) -> bool {
    let random = name
        .strip_prefix(TEMP_PREFIX)
        .and_then(|rest| rest.strip_suffix(TEMP_SUFFIX));
    random.is_some_and(|r| r.len() == TEMP_RANDOM && r.chars().all(|c| c.is_ascii_alphanumeric()))
}

/// Creates a temporary file under a lock, which the system releases when the process ends. If another run removed the file as stale
/// before it was locked, a new one is created. On file systems without locks stale files are not removed.
fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder
        .prefix(TEMP_PREFIX)
        .rand_bytes(TEMP_RANDOM)
        .suffix(TEMP_SUFFIX);
    // `tempfile` restricts its files to the owner; an output has the permissions of any new file.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    loop {
        let file = builder.tempfile_in(folder).map_err(without_path)?;
        if file.as_file().lock().is_err() || file.path().exists() {
            return Ok(file);
        }
    }
}

/// Removes the temporary path that `tempfile` appends to an error.
fn without_path(error: io::Error) -> io::Error {
    let text = error.to_string();
    let reason = text.split(" at path ").next().unwrap_or_default();
    io::Error::new(error.kind(), reason)
}

/// Removes unlocked temporary files of earlier runs; failures are ignored.
fn remove_stale(folder: &Path) {
    let is_temporary = |entry: &DirEntry| {
        is_temporary_name(&entry.file_name().to_string_lossy())
            && entry.file_type().is_ok_and(|file_type| file_type.is_file())
    };
    let entries = folder.read_dir().into_iter().flatten().flatten();
    for path in entries.filter(is_temporary).map(|entry| entry.path()) {
        let Ok(file) = File::open(&path) else {
            continue;
        };
        if file.try_lock().is_ok() {
            let _ = std::fs::remove_file(&path);
        }
    }
}

/// Completes a file: copies the permissions of the file that it replaces, and flushes it to the disk.
fn sync_file(file: &File, target: &Path) -> io::Result<()> {
    if let Ok(replaced) = target.metadata() {
        file.set_permissions(replaced.permissions())?;
    }
    file.sync_all()
}
