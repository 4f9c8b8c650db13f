//! One-step methods with step-size control and dense output.

use super::problem::{IntegrationOptions, IntegrationStats, OdeProblem, SampleSink};
use super::progress::{SampleEmitter, check_budget, check_options, next_discontinuity_within};
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
        stats: &mut IntegrationStats,
    ) -> Result<(f64, Vec<f64>), Error>;

    /// The state at a share θ of the last step, from 0 to 1.
    fn interpolate(&self, theta: f64, y: &mut [f64]);
}

/// Integrates a problem without events, every known break at the end of a step.
///
/// # Errors
/// Those of the steps, and what cannot be asked.
pub fn run<P: OdeProblem>(
    problem: &P,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
    stepper: &mut impl Stepper<P>,
) -> Result<IntegrationStats, Error> {
    check_options(options, problem.len())?;
    let mut stats = IntegrationStats::default();
    let mut samples = SampleEmitter::new(options, sink);
    let (mut t, mut y) = (options.from, options.initial_state.clone());
    let mut sample = y.clone();
    samples.emit_until(t, &mut sample, None, |_, _| ())?;
    while samples.due().is_some() && t < options.to {
        let stop = next_discontinuity_within(|t| problem.next_discontinuity(t), t, options.to);
        stepper.restart();
        while t < stop && samples.due().is_some() {
            let (reached, state) = stepper.step(problem, (t, &y), stop, &mut stats)?;
            stats.steps += 1;
            check_budget(options, &stats, reached)?;
            samples.emit_until(reached, &mut sample, None, |due, into| {
                match due == reached {
                    true => into.copy_from_slice(&state),
                    false => stepper.interpolate((due - t) / (reached - t), into),
                }
            })?;
            (t, y) = (reached, state);
        }
    }
    Ok(stats)
}

/// Step-size rule of a stepper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StepSizeRule {
    /// By the error estimated, against this tolerance.
    Tolerance(f64),
    /// It does not: equal parts of every interval between breaks, this long at most, s.
    Fixed(f64),
}

/// The part of what is left that a step of at most `h` takes, so that all that is left goes into equal steps, s.
pub fn equal_step(left: f64, h: f64) -> f64 {
    left / (left / h - 1e-6).ceil().max(1.0)
}
