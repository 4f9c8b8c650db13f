//! One-step methods with step-size control and dense output.

use super::problem::{IntegrationOptions, IntegrationStats, OdeProblem, SampleSink};
use super::progress::{SampleEmitter, check_budget, check_options, next_discontinuity_within};
use crate::base::error::Error;

/// One-step method with dense output over its last step.
pub trait Stepper<P> {
    /// Discards the history of steps after a discontinuity of f.
    fn restart(&mut self);

    /// Takes one step from the time and state `start`, at most to the time `end`, s; returns the new time, s, and state.
    ///
    /// # Errors
    /// `NoConvergence` if no step meets the tolerance, `BudgetExceeded`.
    fn step(
        &mut self,
        problem: &P,
        start: (f64, &[f64]),
        end: f64,
        stats: &mut IntegrationStats,
    ) -> Result<(f64, Vec<f64>), Error>;

    /// Dense output at the fraction θ of the last step, 0 to 1.
    fn interpolate(&self, theta: f64, y: &mut [f64]);
}

/// Integrates a problem without events; every known discontinuity is the end of a step.
///
/// # Errors
/// Errors of the steps, and invalid options.
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
        let t_stop = next_discontinuity_within(|t| problem.next_discontinuity(t), t, options.to);
        stepper.restart();
        while t < t_stop && samples.due().is_some() {
            let (t_end, state) = stepper.step(problem, (t, &y), t_stop, &mut stats)?;
            stats.steps += 1;
            check_budget(options, &stats, t_end)?;
            samples.emit_until(t_end, &mut sample, None, |t_sample, y_out| {
                match t_sample == t_end {
                    true => y_out.copy_from_slice(&state),
                    false => stepper.interpolate((t_sample - t) / (t_end - t), y_out),
                }
            })?;
            (t, y) = (t_end, state);
        }
    }
    Ok(stats)
}

/// Step-size rule of a stepper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StepSizeRule {
    /// Error control with this tolerance.
    Tolerance(f64),
    /// Equal steps between discontinuities with this maximum, s.
    Fixed(f64),
}

/// Step size of equal steps of at most `h` over the remaining time `span`, s.
pub fn equal_step(span: f64, h: f64) -> f64 {
    span / (span / h - 1e-6).ceil().max(1.0)
}
