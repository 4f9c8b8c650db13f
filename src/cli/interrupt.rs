//! Ctrl-C: the run ends at its next sample, and what was finished is printed whole.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code of a run that Ctrl-C ended; what was finished is whole.
pub const INTERRUPTED: u8 = 130;

/// Raised by Ctrl-C. A second one ends the process at once. Where whoever started it has Ctrl-C ignored, it stays so.
pub fn flag() -> Arc<AtomicBool> {
    let raised = Arc::new(AtomicBool::new(false));
    let seen = raised.clone();
    let _ = ctrlc::try_set_handler(move || {
        if seen.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    });
    raised
}
