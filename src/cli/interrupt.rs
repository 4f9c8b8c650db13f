//! Ctrl-C: cancels work at its next step; partial files are removed.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::base::error::Error;
use crate::base::time_budget::CancelToken;

/// Exit code of interrupted work.
pub const EXIT_INTERRUPTED: u8 = 130;

/// Time after which an interrupt ends a document that is being printed: its reader has stopped reading.
const STALLED: Duration = Duration::from_secs(1);

/// The state of this run as a signal finds it.
struct RunState {
    /// Raised by the first signal, if the command can end early with a partial result.
    cancel: Option<CancelToken>,
    /// When the files were complete and the result began to be printed.
    answer_began: Option<Instant>,
    /// Files under temporary names.
    temporaries: Vec<PathBuf>,
}

static RUN: Mutex<RunState> = Mutex::new(RunState {
    cancel: None,
    answer_began: None,
    temporaries: Vec::new(),
});

fn state() -> MutexGuard<'static, RunState> {
    RUN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Listens for interrupts. The first one raises [`cancel_on_ctrl_c`] where the command uses it; without it, and at the second one, temporary
/// files are removed, `report` prints the error unless an answer has begun, and the process exits with [`EXIT_INTERRUPTED`]. An answer
/// that has begun is printed to its end unless it takes longer than a second. A signal that the caller of the process has ignored
/// (`nohup`, background jobs of a script) stays ignored.
pub fn listen(report: impl Fn() + Send + 'static) {
    let mut first = true;
    on_signal(move || {
        let mut run = state();
        let first = std::mem::replace(&mut first, false);
        if run
            .answer_began
            .is_some_and(|began| began.elapsed() < STALLED)
        {
            return;
        }
        if let Some(cancel) = run.cancel.as_ref().filter(|_| first) {
            cancel.cancel();
            return;
        }
        for path in run.temporaries.drain(..) {
            let _ = std::fs::remove_file(path);
        }
        if run.answer_began.is_none() {
            report();
        }
        std::process::exit(i32::from(EXIT_INTERRUPTED));
    });
}

/// A cancellation token that the first interrupt raises.
pub fn cancel_on_ctrl_c() -> CancelToken {
    state().cancel.get_or_insert_default().clone()
}

/// Registers a file under a temporary name: an interrupt removes it.
pub fn register(temporary: &Path) {
    state().temporaries.push(temporary.to_path_buf());
}

/// Renames the temporary files; an interrupt waits until all are renamed.
///
/// # Errors
/// Those of `rename`.
pub fn commit(rename: impl FnOnce() -> Result<(), Error>) -> Result<(), Error> {
    let mut run = state();
    rename()?;
    run.temporaries.clear();
    run.answer_began = Some(Instant::now());
    Ok(())
}

/// From here on a document is being printed: interrupts let it end.
pub fn begin_document() {
    state().answer_began = Some(Instant::now());
}

#[cfg(unix)]
fn on_signal(mut act: impl FnMut() + Send + 'static) {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let heard = [SIGINT, SIGTERM, SIGHUP]
        .into_iter()
        .filter(|signal| !is_ignored(*signal));
    let Ok(mut signals) = signal_hook::iterator::Signals::new(heard) else {
        return;
    };
    std::thread::spawn(move || signals.forever().for_each(|_| act()));
}

/// Whether the process was started with a signal ignored: bit `signal − 1` of `SigIgn` (proc_pid_status(5)). Where the system does
/// not say, SIGHUP is left alone, since `nohup` is the usual reason.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:"))
        .and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    match mask {
        Some(mask) => mask >> (signal - 1) & 1 == 1,
        None => signal == signal_hook::consts::SIGHUP,
    }
}

#[cfg(not(unix))]
fn on_signal(act: impl FnMut() + Send + 'static) {
    let _ = ctrlc::try_set_handler(act);
}
