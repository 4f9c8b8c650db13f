//! Cancellation token and time budget: when long work ends early, and the forecast of an overrun.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::quantity::format_duration;

/// A wish that work end early; copies share it, across threads as well. Whoever works looks at it between steps and ends with what is finished.
#[derive(Debug, Clone, Default)]
pub struct CancelToken {
    raised: Arc<AtomicBool>,
    /// When patience runs out.
    until: Option<Instant>,
    /// Number of checks.
    n_checks: Arc<AtomicU32>,
    /// Patience has been seen to be over.
    is_over: Arc<AtomicBool>,
    /// Time budget of the whole.
    budget: Option<TimeBudget>,
}

/// Time budget of the whole, and the progress at the last check.
#[derive(Debug, Clone)]
struct TimeBudget {
    seconds: f64,
    since: Instant,
    last: Arc<Mutex<ProgressSample>>,
}

/// Progress at a look.
#[derive(Debug, Clone, Copy, Default)]
struct ProgressSample {
    /// After so many seconds.
    seconds: f64,
    /// So much of the whole was done.
    share: f64,
    /// Since the look before, so much in a second.
    rate: f64,
    /// The fastest of the paces since the first look.
    fastest: f64,
}

/// Forecast of work over its budget: cost so far and in total.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BudgetForecast {
    /// So far, s.
    pub spent: f64,
    /// Forecast total at the recent rate, s; ∞ without progress.
    pub total: f64,
    /// Time allowed, s.
    pub allowed: f64,
}

impl BudgetForecast {
    /// Forecast total and allowed time, as text.
    pub fn text(&self) -> String {
        format!(
            "at this pace the whole would take {}, and {} are allowed",
            format_duration(self.total),
            format_duration(self.allowed)
        )
    }
}

/// The first look comes after this share of what is allowed, a second of an hour; each later one after twice the time of the one
/// before.
const FIRST_CHECK: f64 = 3e-4;

/// And not sooner than this, s: what a cold start costs.
const MIN_CHECK_TIME: f64 = 0.02;

/// After this share of what is allowed an estimate is believed as it is, and standing still is taken for what follows. Before it a
/// start may be dear: after a share x the rest may go √(BELIEVED/x) times faster than the fastest pace seen, 13 times after two
/// seconds of an hour.
const TRUSTED_SHARE: f64 = 1.0 / 10.0;

/// A pace that has changed by less than this factor since the last look is believed at once.
const STEADY_RATE_RATIO: f64 = 1.25;

/// The clock is read once in so many questions: work of a microsecond does not feel it.
const CLOCK_CHECK_INTERVAL: u32 = 8;

impl CancelToken {
    /// Requests cancellation; true where that was requested before.
    pub fn cancel(&self) -> bool {
        self.raised.swap(true, Ordering::Relaxed)
    }

    /// True once cancellation was requested.
    pub fn is_cancelled(&self) -> bool {
        self.raised.load(Ordering::Relaxed)
    }

    /// The work is to end, whatever the reason.
    pub fn should_stop(&self) -> bool {
        if self.is_cancelled() {
            return true;
        }
        let Some(until) = self.until else {
            return false;
        };
        let asked = self.n_checks.fetch_add(1, Ordering::Relaxed);
        if asked.is_multiple_of(CLOCK_CHECK_INTERVAL) && Instant::now() >= until {
            self.is_over.store(true, Ordering::Relaxed);
        }
        self.is_over.load(Ordering::Relaxed)
    }

    /// The same wish, and patience for so many seconds from now.
    #[must_use]
    pub fn with_deadline(&self, seconds: f64) -> CancelToken {
        CancelToken {
            raised: Arc::clone(&self.raised),
            until: Some(Instant::now() + Duration::from_secs_f64(seconds)),
            n_checks: Arc::default(),
            is_over: Arc::default(),
            budget: None,
        }
    }

    /// The same wish, and from now on so many seconds for the whole of some work; nothing ends where they are over, but
    /// [`CancelToken::forecast_overrun`] tells before.
    #[must_use]
    pub fn with_budget(&self, seconds: f64) -> CancelToken {
        let budget = TimeBudget {
            seconds,
            since: Instant::now(),
            last: Arc::default(),
        };
        CancelToken {
            budget: Some(budget),
            ..self.clone()
        }
    }

    /// Forecast of the total cost, `share` of it being done, where that is more than is allowed.
    pub fn forecast_overrun(&self, share: f64) -> Option<BudgetForecast> {
        let budget = self.budget.as_ref()?;
        budget.foresees(share, budget.since.elapsed().as_secs_f64())
    }
}

impl TimeBudget {
    fn foresees(&self, share: f64, spent: f64) -> Option<BudgetForecast> {
        let mut latest = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let last = *latest;
        let allowed = self.seconds;
        if spent
            < (2.0 * last.seconds)
                .max(FIRST_CHECK * allowed)
                .max(MIN_CHECK_TIME)
            || share < last.share
        {
            return None;
        }
        let pace = (share - last.share) / (spent - last.seconds);
        // What was done before the first look holds what is done but once.
        let first = last.seconds == 0.0;
        let fastest = if first { 0.0 } else { last.fastest.max(pace) };
        *latest = ProgressSample {
            seconds: spent,
            share,
            rate: pace,
            fastest,
        };
        let left = 1.0 - share;
        let steady =
            !first && (1.0 / STEADY_RATE_RATIO..STEADY_RATE_RATIO).contains(&(pace / last.rate));
        let believed = spent >= TRUSTED_SHARE * allowed;
        let least = match (steady || believed, fastest > 0.0) {
            (true, _) => left / pace,
            (false, true) => left / fastest / (TRUSTED_SHARE * allowed / spent).sqrt(),
            (false, false) => 0.0,
        };
        (spent + least > allowed).then_some(BudgetForecast {
            spent,
            total: spent + left / pace,
            allowed,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Patience is each copy's own, the wish is shared.
    #[test]
    fn law_copies_share_the_wish() {
        let cancel = CancelToken::default();
        let (hasty, patient) = (cancel.with_deadline(0.0), cancel.with_deadline(1e3));
        assert!(hasty.should_stop() && !hasty.is_cancelled());
        assert!(!patient.should_stop() && !cancel.should_stop());
        // However often it is asked.
        assert!((0..20).all(|_| hasty.should_stop()));
        assert!(!patient.cancel() && cancel.cancel());
        assert!(cancel.should_stop() && hasty.is_cancelled());
    }

    fn default_budget(seconds: f64) -> TimeBudget {
        TimeBudget {
            seconds,
            since: Instant::now(),
            last: Arc::default(),
        }
    }

    /// A pace that holds is believed after two looks, whatever it says of the whole; one that allows enough is no reason to end.
    #[test]
    fn law_a_steady_pace_is_believed() {
        let slow = default_budget(1000.0);
        let seen: Vec<bool> = [0.1, 0.5, 0.75, 1.0, 1.5, 2.0]
            .map(|s| slow.foresees(s * 1e-4, s).is_some())
            .to_vec();
        assert_eq!(seen, [false, false, false, true, false, true]);
        let enough = default_budget(1000.0);
        for k in 0..1000 {
            let spent = f64::from(k);
            assert_eq!(enough.foresees(spent / 990.0, spent), None);
        }
    }

    /// A dear start is no reason to end: early, and where the pace has changed, five times too long is not believed; fifty times is.
    #[test]
    fn law_a_dear_start_is_forgiven() {
        let begun = default_budget(1000.0);
        assert_eq!(begun.foresees(1e-6, 1.0), None);
        assert_eq!(begun.foresees(3e-4, 2.5), None);
        assert_eq!(begun.foresees(0.01, 10.0), None);
        let slow = default_budget(1000.0);
        assert_eq!(slow.foresees(1e-6, 1.0), None);
        assert_eq!(slow.foresees(2e-5, 2.0).unwrap().allowed, 1000.0);
        let standing = default_budget(1000.0);
        assert_eq!(standing.foresees(0.0, 1.0), None);
        let found = standing.foresees(0.0, 200.0).unwrap();
        assert!(found.total.is_infinite() && found.spent == 200.0);
    }
}
