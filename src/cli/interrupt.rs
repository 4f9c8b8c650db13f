//! Ctrl-C: work ends at its next step, and what was finished is printed whole.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::base::stop::Stop;

/// Exit code of work that Ctrl-C ended; what was finished is whole.
pub const INTERRUPTED: u8 = 130;

/// Raised by Ctrl-C. A second one ends the process at once. Where whoever started it has Ctrl-C ignored, it stays so.
pub fn stop() -> Stop {
    let stop = Stop::default();
    let raised = stop.clone();
    let _ = ctrlc::try_set_handler(move || {
        if raised.raise() {
            take_away();
            std::process::exit(i32::from(INTERRUPTED));
        }
    });
    stop
}

/// The file that is being written under a temporary name.
static UNFINISHED: Mutex<Option<PathBuf>> = Mutex::new(None);

fn unfinished() -> MutexGuard<'static, Option<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file under a temporary name, for as long as it is one: Ctrl-C takes it away.
pub struct Unfinished;

impl Unfinished {
    /// Of this name.
    pub fn new(path: &Path) -> Unfinished {
        *unfinished() = Some(path.to_path_buf());
        Unfinished
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        *unfinished() = None;
    }
}

/// From here on Ctrl-C ends the process at once, without anything half-written left behind: for work that has nothing to show before
/// it is finished.
pub fn ends() {
    let _ = ctrlc::try_set_handler(|| {
        take_away();
        std::process::exit(i32::from(INTERRUPTED));
    });
}

fn take_away() {
    if let Some(path) = unfinished().take() {
        let _ = std::fs::remove_file(path);
    }
}
