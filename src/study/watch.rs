//! Who watches a study: hears what is worked at, and may end it.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::stop::Stop;

/// A watcher.
pub struct Watch<'a> {
    /// Raised where the study is to end with what is finished.
    pub stop: &'a Stop,
    /// Hears of each part before it starts.
    pub hear: &'a mut dyn FnMut(&str),
}

impl Watch<'_> {
    /// Says what comes next; false where it is not to come.
    pub fn goes_on(&mut self, next: &str) -> bool {
        let on = !self.stop.is_due();
        if on {
            (self.hear)(next);
        }
        on
    }
}

/// The study ended before there was anything to show.
pub fn interrupted() -> Error {
    Error::new(Code::Interrupted, "ended before anything was finished")
}
