//! Progress callback and cancellation of a study.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::time_budget::CancelToken;

/// Progress and interruption of a long study.
pub struct Monitor<'a> {
    /// Raised where the study is to end with what is finished.
    pub cancel: &'a CancelToken,
    /// Hears of each part before it starts.
    pub on_progress: &'a mut (dyn FnMut(&str) + Send),
}

impl Monitor<'_> {
    /// Says what comes next; false where it is not to come.
    pub fn proceed(&mut self, next: &str) -> bool {
        let on = !self.cancel.should_stop();
        if on {
            (self.on_progress)(next);
        }
        on
    }
}

/// The study ended before there was anything to show.
pub fn interrupted_error() -> Error {
    Error::new(Code::Interrupted, "interrupted before the first result")
}
