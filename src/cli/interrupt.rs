//! Ctrl-C: the run ends at its next sample, and what was finished is printed whole.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::base::code::Code;
use crate::base::error::Error;

/// Raised by Ctrl-C. A second one ends the process at once.
///
/// # Errors
/// The system does not let signals be caught.
pub fn flag() -> Result<Arc<AtomicBool>, Error> {
    let raised = Arc::new(AtomicBool::new(false));
    let seen = raised.clone();
    let caught = ctrlc::try_set_handler(move || {
        if seen.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(super::simulate::INTERRUPTED));
        }
    });
    match caught {
        Ok(()) => Ok(raised),
        Err(e) => Err(Error::new(
            Code::Usage,
            format!("Ctrl-C cannot be caught: {e}"),
        )),
    }
}
