//! Sample output and work budget of an integration run.

use super::problem::{IntegrationOptions, IntegrationStats, SampleSink, StepSize};
use super::regime::Regime;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::{format_duration, format_instant, format_time, suggested_time_limit};
use crate::base::time_budget::BudgetForecast;

/// Hands over samples, each once and in order.
pub struct SampleEmitter<'a, 's> {
    options: &'a IntegrationOptions,
    sink: &'a mut SampleSink<'s>,
    next: usize,
}

impl<'a, 's> SampleEmitter<'a, 's> {
    /// None handed over yet.
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

    /// The instant of the next sample, s; absent where all are handed over or no more are wanted.
    pub fn due(&self) -> Option<f64> {
        (self.next <= self.options.samples && !self.options.cancel.should_stop())
            .then(|| self.options.time(self.next))
    }

    /// Whether a sample is due at or before `t`.
    pub fn due_by(&self, t: f64) -> Option<f64> {
        self.due().filter(|&due| due <= t)
    }

    /// The instants of all samples due at or before `t`.
    pub fn due_within(&self, t: f64) -> impl Iterator<Item = f64> {
        let instants = (self.next..=self.options.samples).map(|at| self.options.time(at));
        let wanted = !self.options.cancel.should_stop();
        instants.take_while(move |due| wanted && *due <= t)
    }

    /// Hands over the state at the next instant, in its regime where there is one.
    ///
    /// # Errors
    /// `Overflow` where a state is not finite.
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

    /// Hands over all that is due up to `t`, each from `state` at its instant.
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
/// `OutOfRange` for a start that does not fit or is not finite, time that runs backward, no tolerance or step.
pub fn check_options(options: &IntegrationOptions, states: usize) -> Result<(), Error> {
    let bad = |message: String| Err(Error::new(Code::OutOfRange, message));
    if options.initial_state.len() != states {
        return bad(format!(
            "the start has {} states, the problem {states}",
            options.initial_state.len()
        ));
    }
    if let Some(at) = options.initial_state.iter().position(|x| !x.is_finite()) {
        return bad(format!(
            "state {at} is {} at the start",
            options.initial_state[at]
        ));
    }
    if !(options.to >= options.from && options.from.is_finite() && options.to.is_finite()) {
        return bad(format!(
            "no time passes from {} s to {} s",
            options.from, options.to
        ));
    }
    match options.step_size {
        StepSize::Adaptive(x) if !(x > 0.0 && x < 1.0) => {
            bad(format!("a tolerance of {x} is not between 0 and 1"))
        }
        StepSize::Fixed(h) if !(h > 0.0 && h.is_finite()) => {
            bad(format!("a step of {h} s is not above zero"))
        }
        _ => Ok(()),
    }
}

/// Work after which the cost of a run is predicted, in evaluations: starts from rest and fast transients are over by then, after which
/// steps grow.
const PREDICT_AFTER: u64 = 200_000;

/// Whether work is to end that has come through a share of its time: once that is less than the square of the share of its budget
/// spent. So at first only what would take far more than is allowed ends, a hundred times as much after a hundredth of the budget; in the
/// end whatever is not done.
pub fn will_exceed_budget(spent: u64, budget: u64, share: f64) -> bool {
    let used = spent as f64 / budget as f64;
    spent > PREDICT_AFTER && used * used > share
}

/// The work so far, of the method, of who goes along with it and of the samples due by `t`.
pub fn total_work(options: &IntegrationOptions, stats: &IntegrationStats, t: f64) -> u64 {
    let samples = elapsed_share(options, t) * options.samples as f64;
    stats.work(options.initial_state.len()) + options.observer.work() + samples as u64
}

/// The part of the time that lies before `t`.
fn elapsed_share(options: &IntegrationOptions, t: f64) -> f64 {
    ((t - options.from) / (options.to - options.from)).max(0.0)
}

/// Refuses to go on beyond the budget or towards far more than it, or where the whole would take longer than is allowed.
///
/// # Errors
/// `BudgetExceeded`, with the time reached and what the whole would cost at this pace.
pub fn check_budget(
    options: &IntegrationOptions,
    stats: &IntegrationStats,
    t: f64,
) -> Result<(), Error> {
    let share = elapsed_share(options, t);
    if let Some(forecast) = options.cancel.forecast_overrun(share) {
        return Err(time_exceeded(options, forecast, t));
    }
    let spent = total_work(options, stats, t);
    match spent > options.max_work || will_exceed_budget(spent, options.max_work, share) {
        false => Ok(()),
        true => Err(budget_exceeded(options, spent, t)),
    }
}

/// The refusal of a run that has come to `t` and would take too long.
pub fn time_exceeded(options: &IntegrationOptions, forecast: BudgetForecast, t: f64) -> Error {
    let BudgetForecast {
        spent,
        total: whole,
        allowed,
    } = forecast;
    let message = format!(
        "{} of work brought the motion to t = {} of {}; {}",
        format_duration(spent),
        format_time(t - options.from),
        format_time(options.to - options.from),
        forecast.text()
    );
    let left = (t - options.from) * allowed / spent;
    let more = match whole.is_finite() {
        true => format!(", allow more with --allow {}", suggested_time_limit(whole)),
        false => String::new(),
    };
    Error::new(Code::BudgetExceeded, message).with_hint(format!(
        "request a shorter time (so far, {} would reach about t = {}), a coarser tolerance or step, or another method{more}",
        format_duration(allowed),
        format_time(left.min(options.to - options.from))
    ))
}

/// The refusal of a run whose work was `work` by `t`.
pub fn budget_exceeded(options: &IntegrationOptions, spent: u64, t: f64) -> Error {
    let share = elapsed_share(options, t);
    let whole = match share > 0.0 {
        true => format!("about {} at this pace", rounded(spent as f64 / share)),
        false => "more than can be estimated".to_string(),
    };
    let message = format!(
        "the work of {} evaluations brought the motion to t = {} of {}; the whole would take {whole}, and {} are allowed",
        rounded(spent as f64),
        format_instant(t - options.from),
        format_instant(options.to - options.from),
        rounded(options.max_work as f64)
    );
    Error::new(Code::BudgetExceeded, message).with_hint(
        "request a shorter time, a coarser tolerance or step, or a method for stiff machines",
    )
}

/// A count of evaluations to two digits.
pub fn rounded(count: f64) -> String {
    match count {
        n if n < 1e4 => format!("{n:.0}"),
        n => format!("{n:.1e}"),
    }
}

/// `t` kept inside an interval between two breaks, so that nothing is evaluated on their far sides, s.
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

/// The first break after `t` that is more than rounding away, at most `to`, s.
pub fn next_discontinuity_within(next_break: impl Fn(f64) -> f64, t: f64, to: f64) -> f64 {
    let near = t + 16.0 * f64::EPSILON * t.abs();
    let mut stop = next_break(t);
    while stop <= near {
        let later = next_break(near.max(stop));
        if later <= stop {
            return to;
        }
        stop = later;
    }
    stop.min(to)
}
