//! Minimum run time over repeats.

use std::time::Instant;

/// Seconds spent on repeats of one thing.
const REPEAT_TIME: f64 = 0.15;

/// The outcome and the least time of several repeats, s; one that fails is not repeated.
pub fn min_time<T, E>(mut task: impl FnMut() -> Result<T, E>) -> (Result<T, E>, f64) {
    let start = Instant::now();
    let mut least = f64::INFINITY;
    loop {
        let begin = Instant::now();
        let outcome = task();
        least = least.min(begin.elapsed().as_secs_f64());
        if outcome.is_err() || start.elapsed().as_secs_f64() >= REPEAT_TIME {
            return (outcome, least);
        }
    }
}
