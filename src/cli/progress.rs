//! Progress bars and spinners on standard error.

use std::path::Path;
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::base::error::Errors;
use crate::recording::open;
use crate::recording::raw::RawLog;
use crate::recording::read_options::ReadOptions;

/// Minimum file size for a progress bar, bytes.
const MIN_BYTES_FOR_BAR: u64 = 100 << 20;

/// Number of steps of a progress bar.
const STEPS: u64 = 1000;

/// Interval between two updates of a spinner.
const TICK: Duration = Duration::from_millis(500);

/// Delay before a bar is drawn; shorter work shows none.
const BAR_DELAY: Duration = Duration::from_secs(1);

/// Opens a log, with a progress bar for a large one.
///
/// # Errors
/// As for [`open::open`].
pub fn open(path: &Path, options: &ReadOptions, quiet: bool) -> Result<RawLog, Errors> {
    let name = path.display().to_string();
    let size = path.metadata().map_or(0, |metadata| metadata.len());
    if quiet || size < MIN_BYTES_FOR_BAR {
        return open::open(&name, options);
    }
    let style = ProgressStyle::with_template("reading {wide_bar} {percent} %");
    let bar = ProgressBar::new(STEPS);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let raw = open::open_with_progress(&name, options, &|share| {
        bar.set_position((share * STEPS as f64) as u64);
    });
    bar.finish_and_clear();
    raw
}

/// Runs work of unknown duration behind a spinner with its description and the elapsed time.
pub fn with_spinner<T>(what: &'static str, quiet: bool, work: impl FnOnce() -> T) -> T {
    if quiet {
        return work();
    }
    let spinner = delayed_bar(
        ProgressBar::new_spinner(),
        "{spinner} {msg}, {elapsed}",
        what,
    );
    let result = work();
    spinner.finish_and_clear();
    result
}

/// Progress callback for work of known length: takes the completed share, 0 to 1, and `None` at the end.
pub fn progress_bar(what: &'static str, quiet: bool) -> impl Fn(Option<f64>) {
    let style = "{msg} {wide_bar} {percent} %, {elapsed}";
    let bar = (!quiet).then(|| delayed_bar(ProgressBar::new(STEPS), style, what));
    move |share| match (&bar, share) {
        (Some(bar), Some(share)) => bar.set_position((share * STEPS as f64) as u64),
        (Some(bar), None) => bar.finish_and_clear(),
        (None, _) => {}
    }
}

/// Progress bar drawn after [`BAR_DELAY`] and refreshed every [`TICK`] from a thread of its own.
fn delayed_bar(bar: ProgressBar, style: &str, what: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template(style);
    bar.set_draw_target(ProgressDrawTarget::hidden());
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_message(what);
    let handle = bar.clone();
    thread::spawn(move || {
        thread::sleep(BAR_DELAY);
        if !handle.is_finished() {
            handle.set_draw_target(ProgressDrawTarget::stderr());
            handle.enable_steady_tick(TICK);
        }
    });
    bar
}
