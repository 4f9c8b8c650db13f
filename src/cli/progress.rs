//! How far long work is, on standard error where that is a terminal.

use std::path::Path;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use crate::base::error::Errors;
use crate::recording::open;
use crate::recording::raw::Raw;
use crate::recording::settings::Settings;

/// Files below this are read before anyone wonders, bytes.
const LONG: u64 = 100 << 20;

/// Steps of a bar.
const STEPS: u64 = 1000;

/// Between two signs of life.
const BEAT: Duration = Duration::from_millis(500);

/// Opens a log; of a long one it says how much is read.
///
/// # Errors
/// As for [`open::open`].
pub fn open(path: &Path, settings: &Settings, quiet: bool) -> Result<Raw, Errors> {
    let name = path.display().to_string();
    let size = path.metadata().map_or(0, |found| found.len());
    if quiet || size < LONG {
        return open::open(&name, settings);
    }
    let look = ProgressStyle::with_template("reading {wide_bar} {percent} %");
    let bar = ProgressBar::new(STEPS);
    bar.set_style(look.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let raw = open::watched(&name, settings, &|share| {
        bar.set_position((share * STEPS as f64) as u64);
    });
    bar.finish_and_clear();
    raw
}

/// Does work of unknown length; meanwhile it says what is done, and for how long.
pub fn busy<T>(what: &'static str, quiet: bool, work: impl FnOnce() -> T) -> T {
    if quiet {
        return work();
    }
    let look = ProgressStyle::with_template("{spinner} {msg}, {elapsed}");
    let sign = ProgressBar::new_spinner().with_message(what);
    sign.set_style(look.unwrap_or_else(|_| ProgressStyle::default_spinner()));
    sign.enable_steady_tick(BEAT);
    let done = work();
    sign.finish_and_clear();
    done
}

/// Work that knows how far it is: hears its share, 0 to 1, and `None` when it is done.
pub fn share(what: &'static str, quiet: bool) -> impl Fn(Option<f64>) {
    let bar = (!quiet).then(|| {
        let look = ProgressStyle::with_template("{msg} {wide_bar} {percent} %, {elapsed}");
        let bar = ProgressBar::new(STEPS).with_message(what);
        bar.set_style(look.unwrap_or_else(|_| ProgressStyle::default_bar()));
        // Between two shares there may be a long time.
        bar.enable_steady_tick(BEAT);
        bar
    });
    move |share| match (&bar, share) {
        (Some(bar), Some(share)) => bar.set_position((share * STEPS as f64) as u64),
        (Some(bar), None) => bar.finish_and_clear(),
        (None, _) => {}
    }
}
