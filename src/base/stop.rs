//! When work is to end before its time: somebody asks for it, or patience runs out.

use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// A wish that work end early; copies share it. Whoever works looks at it between steps and ends with what is finished.
#[derive(Debug, Clone, Default)]
pub struct Stop {
    raised: Arc<AtomicBool>,
    /// When patience runs out.
    until: Option<Instant>,
    /// How often it was asked.
    asked: Cell<u32>,
}

/// The clock is read once in so many questions: work of a microsecond does not feel it.
const SELDOM: u32 = 8;

impl Stop {
    /// Asks for the end; true where that was asked before.
    pub fn raise(&self) -> bool {
        self.raised.swap(true, Ordering::Relaxed)
    }

    /// Somebody asked for the end.
    pub fn is_raised(&self) -> bool {
        self.raised.load(Ordering::Relaxed)
    }

    /// The work is to end, whatever the reason.
    pub fn is_due(&self) -> bool {
        if self.is_raised() {
            return true;
        }
        let Some(until) = self.until else {
            return false;
        };
        let asked = self.asked.replace(self.asked.get().wrapping_add(1));
        asked.is_multiple_of(SELDOM) && Instant::now() >= until
    }

    /// The same wish, and patience for so many seconds from now.
    #[must_use]
    pub fn within(&self, seconds: f64) -> Stop {
        Stop {
            raised: Arc::clone(&self.raised),
            until: Some(Instant::now() + Duration::from_secs_f64(seconds)),
            asked: Cell::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Patience is each copy's own, the wish is shared.
    #[test]
    fn law_copies_share_the_wish() {
        let stop = Stop::default();
        let (hasty, patient) = (stop.within(0.0), stop.within(1e3));
        assert!(hasty.is_due() && !hasty.is_raised());
        assert!(!patient.is_due() && !stop.is_due());
        assert!(!patient.raise() && stop.raise());
        assert!(stop.is_due() && hasty.is_raised());
    }
}
