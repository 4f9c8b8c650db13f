//! How far a run has come: samples handed over, cost against the budget, failures told with their time.

use super::problem::{Ask, Effort, Sink, Wanted};
use super::regime::Regime;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::stop::Foreseen;
use crate::base::units::{duration, enough, instant, seconds};

/// Hands over samples, each once and in order.
pub struct Samples<'a, 's> {
    ask: &'a Ask,
    sink: &'a mut Sink<'s>,
    next: usize,
}

impl<'a, 's> Samples<'a, 's> {
    /// None handed over yet.
    pub fn new(ask: &'a Ask, sink: &'a mut Sink<'s>) -> Samples<'a, 's> {
        Samples { ask, sink, next: 0 }
    }

    /// The instant of the next sample, s; absent where all are handed over or no more are wanted.
    pub fn due(&self) -> Option<f64> {
        (self.next <= self.ask.samples && !self.ask.stop.is_due()).then(|| self.ask.time(self.next))
    }

    /// Whether a sample is due at or before `t`.
    pub fn due_by(&self, t: f64) -> Option<f64> {
        self.due().filter(|&due| due <= t)
    }

    /// The instants of all samples due at or before `t`.
    pub fn due_within(&self, t: f64) -> impl Iterator<Item = f64> {
        let instants = (self.next..=self.ask.samples).map(|at| self.ask.time(at));
        let wanted = !self.ask.stop.is_due();
        instants.take_while(move |due| wanted && *due <= t)
    }

    /// Hands over the state at the next instant, in its regime where there is one.
    ///
    /// # Errors
    /// `Overflow` where a state is not finite.
    pub fn give(&mut self, y: &[f64], regime: Option<&Regime>) -> Result<(), Error> {
        let t = self.ask.time(self.next);
        if let Some(at) = y.iter().position(|x| !x.is_finite()) {
            return Err(Error::new(
                Code::Overflow,
                format!("state {at} is {} at t = {}", y[at], instant(t)),
            ));
        }
        self.next += 1;
        if (self.sink)(t, y, regime).is_break() {
            self.next = self.ask.samples + 1;
        }
        Ok(())
    }

    /// Hands over all that is due up to `t`, each from `state` at its instant.
    ///
    /// # Errors
    /// Those of [`Samples::give`].
    pub fn give_until(
        &mut self,
        t: f64,
        y: &mut [f64],
        regime: Option<&Regime>,
        mut state: impl FnMut(f64, &mut [f64]),
    ) -> Result<(), Error> {
        while let Some(due) = self.due_by(t) {
            state(due, y);
            self.give(y, regime)?;
        }
        Ok(())
    }
}

/// Refuses what cannot be asked.
///
/// # Errors
/// `OutOfRange` for a start that does not fit or is not finite, time that runs backward, no tolerance or step.
pub fn check(ask: &Ask, states: usize) -> Result<(), Error> {
    let bad = |message: String| Err(Error::new(Code::OutOfRange, message));
    if ask.start.len() != states {
        return bad(format!(
            "the start has {} states, the problem {states}",
            ask.start.len()
        ));
    }
    if let Some(at) = ask.start.iter().position(|x| !x.is_finite()) {
        return bad(format!("state {at} is {} at the start", ask.start[at]));
    }
    if !(ask.to >= ask.from && ask.from.is_finite() && ask.to.is_finite()) {
        return bad(format!(
            "no time passes from {} s to {} s",
            ask.from, ask.to
        ));
    }
    match ask.effort {
        Wanted::Tolerance(x) if !(x > 0.0 && x < 1.0) => {
            bad(format!("a tolerance of {x} is not between 0 and 1"))
        }
        Wanted::Step(h) if !(h > 0.0 && h.is_finite()) => {
            bad(format!("a step of {h} s is not above zero"))
        }
        _ => Ok(()),
    }
}

/// Work after which a pace is told, in evaluations: starts from rest and fast transients are over by then, after which steps grow.
const PACE_TOLD: u64 = 200_000;

/// Whether work is to end that has come through a share of its time: once that is less than the square of the share of its budget
/// spent. So at first only what would take far more than is allowed ends, a hundred times as much after a hundredth of the budget; in the
/// end whatever is not done.
pub fn hopeless(spent: u64, budget: u64, share: f64) -> bool {
    let used = spent as f64 / budget as f64;
    spent > PACE_TOLD && used * used > share
}

/// The work so far, of the method, of who goes along with it and of the samples due by `t`.
pub fn work(ask: &Ask, effort: &Effort, t: f64) -> u64 {
    let samples = share(ask, t) * ask.samples as f64;
    effort.work(ask.start.len()) + ask.follower.spent() + samples as u64
}

/// The part of the time that lies before `t`.
fn share(ask: &Ask, t: f64) -> f64 {
    ((t - ask.from) / (ask.to - ask.from)).max(0.0)
}

/// Refuses to go on beyond the budget or towards far more than it, or where the whole would take longer than is allowed.
///
/// # Errors
/// `Hopeless`, with the time reached and what the whole would cost at this pace.
pub fn within_budget(ask: &Ask, effort: &Effort, t: f64) -> Result<(), Error> {
    let share = share(ask, t);
    if let Some(foreseen) = ask.stop.foresees(share) {
        return Err(too_long(ask, foreseen, t));
    }
    let spent = work(ask, effort, t);
    match spent > ask.budget || hopeless(spent, ask.budget, share) {
        false => Ok(()),
        true => Err(too_dear(ask, spent, t)),
    }
}

/// The refusal of a run that has come to `t` and would take too long.
pub fn too_long(ask: &Ask, foreseen: Foreseen, t: f64) -> Error {
    let Foreseen {
        spent,
        whole,
        allowed,
    } = foreseen;
    let message = format!(
        "{} of work brought the motion to t = {} of {}; {}",
        duration(spent),
        seconds(t - ask.from),
        seconds(ask.to - ask.from),
        foreseen.told()
    );
    let left = (t - ask.from) * allowed / spent;
    let more = match whole.is_finite() {
        true => format!(", allow more with --allow {}", enough(whole)),
        false => String::new(),
    };
    Error::new(Code::Hopeless, message).hint(format!(
        "ask for a shorter time (so far, {} would reach about t = {}), a coarser tolerance or step, or another method{more}",
        duration(allowed),
        seconds(left.min(ask.to - ask.from))
    ))
}

/// The refusal of a run whose work was `spent` by `t`.
pub fn too_dear(ask: &Ask, spent: u64, t: f64) -> Error {
    let share = share(ask, t);
    let whole = match share > 0.0 {
        true => format!("about {} at this pace", rounded(spent as f64 / share)),
        false => "more than can be told".to_string(),
    };
    let message = format!(
        "the work of {} evaluations brought the motion to t = {} of {}; the whole would take {whole}, and {} are allowed",
        rounded(spent as f64),
        instant(t - ask.from),
        instant(ask.to - ask.from),
        rounded(ask.budget as f64)
    );
    Error::new(Code::Hopeless, message)
        .hint("ask for a shorter time, a coarser tolerance or step, or a method for stiff machines")
}

/// A count of evaluations to two digits.
pub fn rounded(count: f64) -> String {
    match count {
        n if n < 1e4 => format!("{n:.0}"),
        n => format!("{n:.1e}"),
    }
}

/// `t` kept inside a stretch between two breaks, so that nothing is evaluated on their far sides, s.
pub fn inside(t: f64, from: f64, to: f64) -> f64 {
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
pub fn next_stop(next_break: impl Fn(f64) -> f64, t: f64, to: f64) -> f64 {
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
