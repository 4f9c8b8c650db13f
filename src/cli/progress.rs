//! Progress bars and spinners on standard error.

use std::path::Path;
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::base::error::Errors;
use crate::recording::open;
use crate::recording::raw::RawLog;
use crate::recording::read_options::ReadOptions;

/// Files below this are read before anyone wonders, bytes.
const MIN_BYTES_FOR_BAR: u64 = 100 << 20;

/// Steps of a bar.
const STEPS: u64 = 1000;

/// Between two signs of life.
const TICK: Duration = Duration::from_millis(500);

/// Work shorter than this is done before anyone wonders.
const BAR_DELAY: Duration = Duration::from_secs(1);

/// Opens a log; of a long one it says how much is read.
///
/// # Errors
/// As for [`open::open`].
pub fn open(path: &Path, options: &ReadOptions, quiet: bool) -> Result<RawLog, Errors> {
    let name = path.display().to_string();
    let size = path.metadata().map_or(0, |found| found.len());
    if quiet || size < MIN_BYTES_FOR_BAR {
        return open::open(&name, options);
    }
    let look = ProgressStyle::with_template("reading {wide_bar} {percent} %");
    let bar = ProgressBar::new(STEPS);
    bar.set_style(look.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let raw = open::open_with_progress(&name, options, &|share| {
        bar.set_position((share * STEPS as f64) as u64);
    });
    bar.finish_and_clear();
    raw
}

/// Does work of unknown length; meanwhile it says what is done, and for how long.
pub fn with_spinner<T>(what: &'static str, quiet: bool, work: impl FnOnce() -> T) -> T {
    if quiet {
        return work();
    }
    let sign = delayed_bar(
        ProgressBar::new_spinner(),
        "{spinner} {msg}, {elapsed}",
        what,
    );
    let done = work();
    sign.finish_and_clear();
    done
}

/// Work that knows how far it is: hears its share, 0 to 1, and `None` when it is done.
pub fn progress_bar(what: &'static str, quiet: bool) -> impl Fn(Option<f64>) {
    let look = "{msg} {wide_bar} {percent} %, {elapsed}";
    let bar = (!quiet).then(|| delayed_bar(ProgressBar::new(STEPS), look, what));
    move |share| match (&bar, share) {
        (Some(bar), Some(share)) => bar.set_position((share * STEPS as f64) as u64),
        (Some(bar), None) => bar.finish_and_clear(),
        (None, _) => {}
    }
}

/// A bar that is seen once the work has taken a while, and then gives signs of life whether it hears of any or not.
fn delayed_bar(bar: ProgressBar, look: &str, what: &'static str) -> ProgressBar {
    let look = ProgressStyle::with_template(look);
    bar.set_draw_target(ProgressDrawTarget::hidden());
    bar.set_style(look.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_message(what);
    let shown = bar.clone();
    thread::spawn(move || {
        thread::sleep(BAR_DELAY);
        if !shown.is_finished() {
            shown.set_draw_target(ProgressDrawTarget::stderr());
            shown.enable_steady_tick(TICK);
        }
    });
    bar
}
