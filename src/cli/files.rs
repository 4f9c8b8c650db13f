//! The output files of a run: each is written under a temporary name; all are renamed once all are complete.

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

/// The output files of a run. Those not finished leave nothing behind.
#[derive(Debug, Default)]
pub struct OutputFiles {
    /// Named pipes, open so that their readers wait for what is written.
    pipes: Vec<(PathBuf, File)>,
    complete: Vec<(NamedTempFile, PathBuf)>,
    written: Vec<PathBuf>,
}

impl OutputFiles {
    /// Checks the outputs before any work is done, and removes the temporary files of killed runs from their folders.
    ///
    /// # Errors
    /// An output is no [`Destination`], its folder cannot be written, or it would overwrite an input or another output.
    pub fn new(outputs: &[PathBuf], inputs: &[PathBuf]) -> Result<OutputFiles, Error> {
        let mut files = OutputFiles::default();
        let mut targets: Vec<PathBuf> = Vec::new();
        for path in outputs {
            let name = path.display();
            let destination = Destination::from_path(path)?;
            let same = |input: &PathBuf| resolve_links(input).ok() == resolve_links(path).ok();
            if inputs.iter().any(same) {
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
                let message = format!("two outputs go to {name}");
                return Err(Error::new(Code::Usage, message).with_hint("name two files"));
            }
            remove_stale(folder(&target));
            // A folder that takes no file is known before the work.
            temporary(folder(&target)).map_err(|e| output_error(path, &e))?;
            targets.push(target);
        }
        Ok(files)
    }

    /// Writes a file that is replaced when the run [finishes](Files::finish); a device or pipe is written at once.
    ///
    /// # Errors
    /// The folder or the file cannot be written.
    pub fn write(&mut self, path: &Path, bytes: &[u8]) -> Result<(), Error> {
        self.write_with(path, |to| {
            to.write_all(bytes).map_err(|e| output_error(path, &e))
        })
    }

    /// As [`OutputFiles::write`], with `fill` to write what is in it, so that it need not be in memory.
    ///
    /// # Errors
    /// The folder or the file cannot be written; those of `fill`.
    pub fn write_with(
        &mut self,
        path: &Path,
        fill: impl FnOnce(&mut dyn Write) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let wrong = |e: io::Error| output_error(path, &e);
        match Destination::from_path(path)? {
            Destination::Stream | Destination::Pipe => {
                let pipe = self.pipes.iter().position(|(named, _)| named == path);
                let open = match pipe {
                    Some(at) => self.pipes.swap_remove(at).1,
                    None => open_stream(path).map_err(wrong)?,
                };
                let mut to = BufWriter::new(open);
                fill(&mut to)?;
                to.flush().map_err(wrong)?;
            }
            Destination::File(target) => {
                let file = temporary(folder(&target)).map_err(wrong)?;
                interrupt::register(file.path());
                let mut to = BufWriter::new(file);
                fill(&mut to)?;
                let file = to.into_inner().map_err(|e| wrong(e.into_error()))?;
                settle(file.as_file(), &target).map_err(wrong)?;
                self.complete.push((file, target));
            }
        }
        self.written.push(path.to_path_buf());
        Ok(())
    }

    /// Gives every file its name, and says which were written.
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

/// Writes one file, and nothing else.
///
/// # Errors
/// As for [`OutputFiles::new`] and [`OutputFiles::write`].
pub fn write_one(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let mut files = OutputFiles::new(&[path.to_path_buf()], &[])?;
    files.write(path, bytes)?;
    files.finish().map(drop)
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
    let message = format!("the suffix of {} names no format", path.display());
    Err(Error::new(Code::Usage, message).with_hint(format!("end it in .{}", known.join(" or ."))))
}

/// The file of one of several figures: `FILE-word.svg`, without a word FILE itself.
pub fn sibling_path(path: &Path, word: &str) -> PathBuf {
    if word.is_empty() {
        return path.to_path_buf();
    }
    let mut name = path.file_stem().unwrap_or_default().to_os_string();
    name.push(format!("-{word}.svg"));
    path.with_file_name(name)
}

/// Names of temporary files: prefix, [`TEMP_RANDOM`] letters and digits, suffix.
const TEMP_PREFIX: &str = ".geardyn-";
const TEMP_RANDOM: usize = 12;
const TEMP_SUFFIX: &str = ".partial";

/// Whether a name is that of a temporary file of ours, and of no other file that begins so.
fn is_temporary_name(name: &str) -> bool {
    let random = name
        .strip_prefix(TEMP_PREFIX)
        .and_then(|rest| rest.strip_suffix(TEMP_SUFFIX));
    random.is_some_and(|r| r.len() == TEMP_RANDOM && r.chars().all(|c| c.is_ascii_alphanumeric()))
}

/// A temporary file that a run holds under a lock, which ends with the process however it ends. Another run may have taken it for
/// stale before it was locked; then another one is made. File systems without locks keep it, and keep stale ones.
fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder
        .prefix(TEMP_PREFIX)
        .rand_bytes(TEMP_RANDOM)
        .suffix(TEMP_SUFFIX);
    // Temporary files are made for their owner alone; an answer has the rights of any new file.
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

/// An error without the temporary name, which `tempfile` appends.
fn without_path(error: io::Error) -> io::Error {
    let text = error.to_string();
    let reason = text.split(" at path ").next().unwrap_or_default();
    io::Error::new(error.kind(), reason)
}

/// Removes temporary files that no run holds any more. What cannot be removed is left.
fn remove_stale(folder: &Path) {
    let is_temporary = |entry: &DirEntry| {
        is_temporary_name(&entry.file_name().to_string_lossy())
            && entry.file_type().is_ok_and(|kind| kind.is_file())
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

/// A complete file: it keeps the permissions of the one it replaces, and is on the disk.
fn settle(file: &File, target: &Path) -> io::Result<()> {
    if let Ok(old) = target.metadata() {
        file.set_permissions(old.permissions())?;
    }
    file.sync_all()
}
