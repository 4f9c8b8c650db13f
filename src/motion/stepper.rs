//! Steps of whatever length keeps the error small, with the motion inside each.

use super::problem::{Ask, Effort, Problem, Sink};
use super::progress::{Samples, check, next_stop, within_budget};
use crate::base::error::Error;

/// A method of one step that knows the motion inside its last step.
pub trait Stepper<P> {
    /// Forgets the steps before: f has jumped.
    fn restart(&mut self);

    /// One step from `t`, to `end` at most; gives the time reached, s, and the state there.
    ///
    /// # Errors
    /// `NoConvergence` where no step is short enough, `Hopeless` beyond the budget.
    fn step(
        &mut self,
        problem: &P,
        at: (f64, &[f64]),
        end: f64,
        effort: &mut Effort,
    ) -> Result<(f64, Vec<f64>), Error>;

    /// The state at a share θ of the last step, from 0 to 1.
    fn inside(&self, theta: f64, y: &mut [f64]);
}

/// Integrates a problem without events, every known break at the end of a step.
///
/// # Errors
/// Those of the steps, and what cannot be asked.
pub fn run<P: Problem>(
    problem: &P,
    ask: &Ask,
    sink: &mut Sink,
    stepper: &mut impl Stepper<P>,
) -> Result<Effort, Error> {
    check(ask, problem.len())?;
    let mut effort = Effort::default();
    let mut samples = Samples::new(ask, sink);
    let (mut t, mut y) = (ask.from, ask.start.clone());
    let mut sample = y.clone();
    samples.give_until(t, &mut sample, None, |_, _| ())?;
    while samples.due().is_some() && t < ask.to {
        let stop = next_stop(|t| problem.next_break(t), t, ask.to);
        stepper.restart();
        while t < stop && samples.due().is_some() {
            let (reached, state) = stepper.step(problem, (t, &y), stop, &mut effort)?;
            effort.steps += 1;
            within_budget(ask, &effort, reached)?;
            samples.give_until(reached, &mut sample, None, |due, into| {
                match due == reached {
                    true => into.copy_from_slice(&state),
                    false => stepper.inside((due - t) / (reached - t), into),
                }
            })?;
            (t, y) = (reached, state);
        }
    }
    Ok(effort)
}

/// How a stepper chooses its steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Control {
    /// By the error estimated, against this tolerance.
    Tolerance(f64),
    /// It does not: equal parts of every stretch between breaks, this long at most, s.
    Fixed(f64),
}

/// The part of what is left that a step of at most `h` takes, so that all that is left goes into equal steps, s.
pub fn equal_part(left: f64, h: f64) -> f64 {
    left / (left / h - 1e-6).ceil().max(1.0)
}
