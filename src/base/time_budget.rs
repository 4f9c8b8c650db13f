//! Cancellation token, deadline and time budget of a computation, with the forecast of an overrun.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::quantity::format_duration;

/// Cancellation token; clones share the request, across threads too. A computation polls it between steps and returns what is finished.
#[derive(Debug, Clone, Default)]
pub struct CancelToken {
    cancelled: Arc<AtomicBool>,
    /// Deadline.
    deadline: Option<Instant>,
    /// Number of polls.
    n_checks: Arc<AtomicU32>,
    /// The deadline was found expired.
    is_expired: Arc<AtomicBool>,
    /// Time budget of the computation.
    budget: Option<TimeBudget>,
}

/// Time budget of a computation, with the progress at the last check.
#[derive(Debug, Clone)]
struct TimeBudget {
    seconds: f64,
    start: Instant,
    last: Arc<Mutex<ProgressSample>>,
}

/// Progress at a check.
#[derive(Debug, Clone, Copy, Default)]
struct ProgressSample {
    /// Elapsed time, s.
    seconds: f64,
    /// Completed share of the work.
    share: f64,
    /// Rate of progress since the previous check, 1/s.
    rate: f64,
    /// Highest rate of progress since the first check, 1/s.
    fastest: f64,
}

/// Forecast of a budget overrun: elapsed, total and allowed time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BudgetForecast {
    /// Elapsed time, s.
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
            "the estimated total is {} (limit {})",
            format_duration(self.total),
            format_duration(self.allowed)
        )
    }
}

/// Share of the allowed time before the first check, a second of an hour; each later check doubles the elapsed time of the
/// previous one.
const FIRST_CHECK: f64 = 3e-4;

/// Earliest time of a check, s: the cost of a cold start.
const MIN_CHECK_TIME: f64 = 0.02;

/// Share of the allowed time after which a forecast is accepted unchanged, zero progress included. Before it the start may be costly:
/// at a share x the remaining work may go √(TRUSTED_SHARE/x) times faster than the highest rate measured, 13 times after two seconds
/// of an hour.
const TRUSTED_SHARE: f64 = 1.0 / 10.0;

/// Maximum ratio of the rates at two checks for which the forecast is accepted without delay.
const STEADY_RATE_RATIO: f64 = 1.25;

/// Number of polls per clock reading, negligible for steps of a microsecond.
const CLOCK_CHECK_INTERVAL: u32 = 8;

impl CancelToken {
    /// Requests cancellation; true if it was requested before.
    pub fn cancel(&self) -> bool {
        self.cancelled.swap(true, Ordering::Relaxed)
    }

    /// True once cancellation was requested.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// True once cancellation was requested or the deadline expired.
    pub fn should_stop(&self) -> bool {
        if self.is_cancelled() {
            return true;
        }
        let Some(deadline) = self.deadline else {
            return false;
        };
        let poll = self.n_checks.fetch_add(1, Ordering::Relaxed);
        if poll.is_multiple_of(CLOCK_CHECK_INTERVAL) && Instant::now() >= deadline {
            self.is_expired.store(true, Ordering::Relaxed);
        }
        self.is_expired.load(Ordering::Relaxed)
    }

    /// Token with the same cancellation and a deadline, s from now.
    #[must_use]
    pub fn with_deadline(&self, seconds: f64) -> CancelToken {
        CancelToken {
            cancelled: Arc::clone(&self.cancelled),
            deadline: Some(Instant::now() + Duration::from_secs_f64(seconds)),
            n_checks: Arc::default(),
            is_expired: Arc::default(),
            budget: None,
        }
    }

    /// Token with the same cancellation and a time budget from now, s. The budget ends no work; its overrun is forecast by
    /// [`CancelToken::forecast_overrun`].
    #[must_use]
    pub fn with_budget(&self, seconds: f64) -> CancelToken {
        let budget = TimeBudget {
            seconds,
            start: Instant::now(),
            last: Arc::default(),
        };
        CancelToken {
            budget: Some(budget),
            ..self.clone()
        }
    }

    /// Forecast of the total time with `share` of the work done, if it exceeds the budget.
    pub fn forecast_overrun(&self, share: f64) -> Option<BudgetForecast> {
        let budget = self.budget.as_ref()?;
        budget.forecast(share, budget.start.elapsed().as_secs_f64())
    }
}

impl TimeBudget {
    fn forecast(&self, share: f64, spent: f64) -> Option<BudgetForecast> {
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
        let rate = (share - last.share) / (spent - last.seconds);
        // The progress before the first check includes one-off work.
        let first = last.seconds == 0.0;
        let fastest = if first { 0.0 } else { last.fastest.max(rate) };
        *latest = ProgressSample {
            seconds: spent,
            share,
            rate,
            fastest,
        };
        let remaining = 1.0 - share;
        let is_steady =
            !first && (1.0 / STEADY_RATE_RATIO..STEADY_RATE_RATIO).contains(&(rate / last.rate));
        let is_trusted = spent >= TRUSTED_SHARE * allowed;
        let min_remaining = match (is_steady || is_trusted, fastest > 0.0) {
            (true, _) => remaining / rate,
            (false, true) => remaining / fastest / (TRUSTED_SHARE * allowed / spent).sqrt(),
            (false, false) => 0.0,
        };
        (spent + min_remaining > allowed).then_some(BudgetForecast {
            spent,
            total: spent + remaining / rate,
            allowed,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Clones share the cancellation, each has its deadline.
    #[test]
    fn law_copies_share_the_wish() {
        let cancel = CancelToken::default();
        let (expired, pending) = (cancel.with_deadline(0.0), cancel.with_deadline(1e3));
        assert!(expired.should_stop() && !expired.is_cancelled());
        assert!(!pending.should_stop() && !cancel.should_stop());
        // At every poll.
        assert!((0..20).all(|_| expired.should_stop()));
        assert!(!pending.cancel() && cancel.cancel());
        assert!(cancel.should_stop() && expired.is_cancelled());
    }

    fn default_budget(seconds: f64) -> TimeBudget {
        TimeBudget {
            seconds,
            start: Instant::now(),
            last: Arc::default(),
        }
    }

    /// A steady rate is accepted after two checks; a sufficient rate forecasts no overrun.
    #[test]
    fn law_a_steady_pace_is_believed() {
        let slow = default_budget(1000.0);
        let overruns: Vec<bool> = [0.1, 0.5, 0.75, 1.0, 1.5, 2.0]
            .map(|s| slow.forecast(s * 1e-4, s).is_some())
            .to_vec();
        assert_eq!(overruns, [false, false, false, true, false, true]);
        let enough = default_budget(1000.0);
        for k in 0..1000 {
            let spent = f64::from(k);
            assert_eq!(enough.forecast(spent / 990.0, spent), None);
        }
    }

    /// A costly start is no reason to end: early, or at a changed rate, a forecast five times too long is rejected; fifty times is accepted.
    #[test]
    fn law_a_dear_start_is_forgiven() {
        let started = default_budget(1000.0);
        assert_eq!(started.forecast(1e-6, 1.0), None);
        assert_eq!(started.forecast(3e-4, 2.5), None);
        assert_eq!(started.forecast(0.01, 10.0), None);
        let slow = default_budget(1000.0);
        assert_eq!(slow.forecast(1e-6, 1.0), None);
        assert_eq!(slow.forecast(2e-5, 2.0).unwrap().allowed, 1000.0);
        let stalled = default_budget(1000.0);
        assert_eq!(stalled.forecast(0.0, 1.0), None);
        let forecast = stalled.forecast(0.0, 200.0).unwrap();
        assert!(forecast.total.is_infinite() && forecast.spent == 200.0);
    }
}
