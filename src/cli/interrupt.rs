//! Ctrl-C: work ends at its next step, and what was finished is printed whole.

use crate::base::stop::Stop;

/// Exit code of work that Ctrl-C ended; what was finished is whole.
pub const INTERRUPTED: u8 = 130;

/// Raised by Ctrl-C. A second one ends the process at once. Where whoever started it has Ctrl-C ignored, it stays so.
pub fn stop() -> Stop {
    let stop = Stop::default();
    let raised = stop.clone();
    let _ = ctrlc::try_set_handler(move || {
        if raised.raise() {
            std::process::exit(i32::from(INTERRUPTED));
        }
    });
    stop
}
