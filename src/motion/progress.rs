//! Sample output and work budget of an integration run.

use super::problem::{IntegrationOptions, IntegrationStats, SampleSink, StepSize};
use super::regime::Regime;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::{format_duration, format_instant, format_time, suggested_time_limit};
use crate::base::time_budget::BudgetForecast;

/// Emitter of the samples to a sink, each once and in order.
pub struct SampleEmitter<'a, 's> {
    options: &'a IntegrationOptions,
    sink: &'a mut SampleSink<'s>,
    next: usize,
}

impl<'a, 's> SampleEmitter<'a, 's> {
    /// Emitter before the first sample.
    pub fn new(
        options: &'a IntegrationOptions,
        sink: &'a mut SampleSink<'s>,
    ) -> SampleEmitter<'a, 's> {
        SampleEmitter {
            options,
            sink,
            next: 0,
        }
    }

    /// Time of the next sample, s; `None` after the last sample or a cancellation.
    pub fn due(&self) -> Option<f64> {
        (self.next <= self.options.samples && !self.options.cancel.should_stop())
            .then(|| self.options.time(self.next))
    }

    /// Time of the next sample, s, if it is at most `t`.
    pub fn due_by(&self, t: f64) -> Option<f64> {
        self.due().filter(|&due| due <= t)
    }

    /// Times of all remaining samples up to `t`, s.
    pub fn due_within(&self, t: f64) -> impl Iterator<Item = f64> {
        let instants = (self.next..=self.options.samples).map(|at| self.options.time(at));
        let active = !self.options.cancel.should_stop();
        instants.take_while(move |due| active && *due <= t)
    }

    /// Emits the state at the next sample time, with its regime if there is one.
    ///
    /// # Errors
    /// `Overflow` for a state that is not finite.
    pub fn emit(&mut self, y: &[f64], regime: Option<&Regime>) -> Result<(), Error> {
        let t = self.options.time(self.next);
        if let Some(at) = y.iter().position(|x| !x.is_finite()) {
            return Err(Error::new(
                Code::Overflow,
                format!("state {at} is {} at t = {}", y[at], format_instant(t)),
            ));
        }
        self.next += 1;
        if (self.sink)(t, y, regime).is_break() {
            self.next = self.options.samples + 1;
        }
        Ok(())
    }

    /// Emits all samples up to `t`; `state` writes the state at a sample time.
    ///
    /// # Errors
    /// Those of [`SampleEmitter::emit`].
    pub fn emit_until(
        &mut self,
        t: f64,
        y: &mut [f64],
        regime: Option<&Regime>,
        mut state: impl FnMut(f64, &mut [f64]),
    ) -> Result<(), Error> {
        while let Some(due) = self.due_by(t) {
            state(due, y);
            self.emit(y, regime)?;
        }
        Ok(())
    }
}

/// Rejects invalid options.
///
/// # Errors
/// `OutOfRange` for an initial state of wrong length or not finite, an end before the start, an invalid tolerance or step.
pub fn check_options(options: &IntegrationOptions, states: usize) -> Result<(), Error> {
    let error = |message: String| Err(Error::new(Code::OutOfRange, message));
    if options.initial_state.len() != states {
        return error(format!(
            "the initial state has {} values, the problem {states} states",
            options.initial_state.len()
        ));
    }
    if let Some(at) = options.initial_state.iter().position(|x| !x.is_finite()) {
        return error(format!(
            "state {at} is {} at the start",
            options.initial_state[at]
        ));
    }
    if !(options.to >= options.from && options.from.is_finite() && options.to.is_finite()) {
        return error(format!(
            "the interval from {} s to {} s is empty",
            options.from, options.to
        ));
    }
    match options.step_size {
        StepSize::Adaptive(x) if !(x > 0.0 && x < 1.0) => {
            error(format!("a tolerance of {x} is not between 0 and 1"))
        }
        StepSize::Fixed(h) if !(h > 0.0 && h.is_finite()) => {
            error(format!("a step of {h} s is not above zero"))
        }
        _ => Ok(()),
    }
}

/// Work after which the cost of a run is predicted, in evaluations of f: by then initial transients have decayed and steps have grown.
const PREDICT_AFTER: u64 = 200_000;

/// Whether a run at the `fraction` of its time is to end: if `fraction` is less than the square of the used fraction of the budget.
/// After 1 % of the budget, only a run that would need 100 times the budget ends; at 100 %, every unfinished run.
pub fn will_exceed_budget(spent: u64, budget: u64, fraction: f64) -> bool {
    let used = spent as f64 / budget as f64;
    spent > PREDICT_AFTER && used * used > fraction
}

/// Work up to `t` in evaluations of f: method, observers and samples.
pub fn total_work(options: &IntegrationOptions, stats: &IntegrationStats, t: f64) -> u64 {
    let samples = elapsed_fraction(options, t) * options.samples as f64;
    stats.work(options.initial_state.len()) + options.observer.work() + samples as u64
}

/// Fraction of the simulated time that has elapsed at `t`.
fn elapsed_fraction(options: &IntegrationOptions, t: f64) -> f64 {
    ((t - options.from) / (options.to - options.from)).max(0.0)
}

/// Checks the work budget and the time budget of a run at time `t`, s.
///
/// # Errors
/// `BudgetExceeded` for an exceeded or predicted excess of either budget, with the time reached and the predicted total.
pub fn check_budget(
    options: &IntegrationOptions,
    stats: &IntegrationStats,
    t: f64,
) -> Result<(), Error> {
    let fraction = elapsed_fraction(options, t);
    if let Some(forecast) = options.cancel.forecast_overrun(fraction) {
        return Err(time_exceeded(options, forecast, t));
    }
    let spent = total_work(options, stats, t);
    match spent > options.max_work || will_exceed_budget(spent, options.max_work, fraction) {
        false => Ok(()),
        true => Err(budget_exceeded(options, spent, t)),
    }
}

/// Error of a run that has reached `t` and would exceed its time budget.
pub fn time_exceeded(options: &IntegrationOptions, forecast: BudgetForecast, t: f64) -> Error {
    let BudgetForecast {
        spent,
        total,
        allowed,
    } = forecast;
    let message = format!(
        "work budget of {} exceeded at t = {} of {}; {}",
        format_duration(spent),
        format_time(t - options.from),
        format_time(options.to - options.from),
        forecast.text()
    );
    let reachable = (t - options.from) * allowed / spent;
    let option = match total.is_finite() {
        true => format!(", allow more with --allow {}", suggested_time_limit(total)),
        false => String::new(),
    };
    Error::new(Code::BudgetExceeded, message).with_hint(format!(
        "request a shorter time (so far, {} would reach about t = {}), a coarser tolerance or step, or another method{option}",
        format_duration(allowed),
        format_time(reachable.min(options.to - options.from))
    ))
}

/// Error of a run that has spent the work `spent` up to `t` and would exceed its budget.
pub fn budget_exceeded(options: &IntegrationOptions, spent: u64, t: f64) -> Error {
    let fraction = elapsed_fraction(options, t);
    let total = match fraction > 0.0 {
        true => format!("about {}", rounded(spent as f64 / fraction)),
        false => "unknown".to_string(),
    };
    let message = format!(
        "the work of {} evaluations was spent at t = {} of {}; the estimated total is {total} (limit {})",
        rounded(spent as f64),
        format_instant(t - options.from),
        format_instant(options.to - options.from),
        rounded(options.max_work as f64)
    );
    Error::new(Code::BudgetExceeded, message).with_hint(
        "request a shorter time, a coarser tolerance or step, or a method for stiff machines",
    )
}

/// Count of evaluations as text, with two digits from 10 000 on.
pub fn rounded(count: f64) -> String {
    match count {
        n if n < 1e4 => format!("{n:.0}"),
        n => format!("{n:.1e}"),
    }
}

/// Time `t` clamped into an interval between two discontinuities by a rounding margin, s.
pub fn clamp_time(t: f64, from: f64, to: f64) -> f64 {
    let (first, last) = (
        from + 8.0 * f64::EPSILON * from.abs(),
        to - 8.0 * f64::EPSILON * to.abs(),
    );
    match first < last {
        true => t.clamp(first, last),
        false => from + 0.5 * (to - from),
    }
}

/// First discontinuity after `t` by more than rounding, at most `to`, s.
pub fn next_discontinuity_within(discontinuity_after: impl Fn(f64) -> f64, t: f64, to: f64) -> f64 {
    let after = t + 16.0 * f64::EPSILON * t.abs();
    let mut next = discontinuity_after(t);
    while next <= after {
        let later = discontinuity_after(after.max(next));
        if later <= next {
            return to;
        }
        next = later;
    }
    next.min(to)
}
