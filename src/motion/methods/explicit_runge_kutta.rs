//! Adapter of the crate ode_solvers: explicit Runge–Kutta methods RK4, DOPRI5 and DOP853.
//!
//! The adapter avoids two defects. The Dormand–Prince method of order 8 has wrong nodes for explicit time: time is a state. The
//! dense output is wrong at the last point: only the steps are used. An adaptive method restarts at every sample and discontinuity
//! and ends there exactly; a fixed step is independent of the samples, which are interpolated.

use std::cell::Cell;

use nalgebra::DVector;
use ode_solvers::dop_shared::{IntegrationError, OutputType};
use ode_solvers::{Dop853, Dopri5, Rk4, System};

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::{format_instant, format_time};
use crate::motion::diagnostics;
use crate::motion::dynamic_model::DynamicModel;
use crate::motion::error_scale::ErrorScale;
use crate::motion::problem::{
    DenseOutput, IntegrationOptions, IntegrationStats, OdeProblem, SampleSink, StepSize,
};
use crate::motion::progress::{
    SampleEmitter, check_budget, check_options, clamp_time, next_discontinuity_within, rounded,
};
use crate::motion::stepper::{StepSizeRule, Stepper, equal_step};

use super::dop853::Dop853 as Dop8Step;

/// Explicit Runge–Kutta method of the adapter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExplicitMethod {
    /// Classical Runge–Kutta method of order 4, fixed step.
    Rk4,
    /// Dormand–Prince method of order 5.
    Dopri5,
    /// Dormand–Prince method of order 8.
    Dop853,
}

/// Integrates a dynamic model by the classical Runge–Kutta method.
///
/// # Errors
/// Those of [`run`].
pub fn rk4(
    model: &DynamicModel,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    machine(ExplicitMethod::Rk4, model, options, sink)
}

/// Integrates a dynamic model by the Dormand–Prince method of order 5.
///
/// # Errors
/// Those of [`run`].
pub fn dopri5(
    model: &DynamicModel,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    machine(ExplicitMethod::Dopri5, model, options, sink)
}

/// Integrates a dynamic model by the Dormand–Prince method of order 8.
///
/// # Errors
/// Those of [`run`].
pub fn dop853(
    model: &DynamicModel,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    machine(ExplicitMethod::Dop853, model, options, sink)
}

fn machine(
    method: ExplicitMethod,
    model: &DynamicModel,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    check_options(options, model.len())?;
    let horizon = 1e-2 * (options.to - options.from) / options.samples.max(1) as f64;
    let sizes = ErrorScale::for_model(model, options).sizes(
        &options.initial_state,
        &options.initial_state,
        horizon,
    );
    let sizes = sizes
        .into_iter()
        .map(|s| if s > 1e-200 { s } else { 1e-9 })
        .collect();
    let mut last = (options.from, options.initial_state.clone());
    let result = from_sizes(method, model, options, sizes, &mut |t, y, _| {
        last = (t, y.to_vec());
        sink(t, y, None)
    });
    result.map_err(|error| match error.code {
        Code::NoConvergence | Code::Overflow => {
            diagnostics::with_nearest_switch(error, model, last.0, &last.1)
        }
        _ => error,
    })
}

/// Growth of a state over its initial scale that proves an unstable step; the crate does not detect it.
const DIVERGENCE_LIMIT: f64 = 1e30;

/// Maximum number of steps per call of the crate.
const STEPS_PER_CALL: u32 = 5_000;

/// Scaled problem between two discontinuities, with time as an additional state.
struct TimedProblem<'a, P> {
    problem: &'a P,
    /// Both discontinuities, s.
    interval: [f64; 2],
    /// Start of the sub-interval, s.
    from: f64,
    /// Scale of every state, to which tolerances are relative.
    sizes: &'a [f64],
    /// A derivative was not finite.
    failed: &'a Cell<bool>,
}

impl<P: OdeProblem> System<f64, DVector<f64>> for TimedProblem<'_, P> {
    fn system(&self, _x: f64, y: &DVector<f64>, dy: &mut DVector<f64>) {
        let n = self.sizes.len();
        if self.failed.get() {
            return;
        }
        let t = clamp_time(self.from + y[n], self.interval[0], self.interval[1]);
        let state: Vec<f64> = (0..n).map(|i| self.sizes[i] * y[i]).collect();
        let mut slope = vec![0.0; n];
        self.problem.derivative(t, &state, &mut slope);
        for i in 0..n {
            dy[i] = slope[i] / self.sizes[i];
        }
        dy[n] = 1.0;
        if !dy.iter().all(|x| x.is_finite()) {
            self.failed.set(true);
        }
    }
}

/// Integrates an initial value problem.
///
/// # Errors
/// `NoConvergence` for step size underflow or stiffness, `Overflow` for a state that is not finite,
/// `BudgetExceeded` beyond the budget, and invalid options.
pub fn run<P: OdeProblem>(
    method: ExplicitMethod,
    problem: &P,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    check_options(options, problem.len())?;
    from_sizes(
        method,
        problem,
        options,
        first_sizes(problem, options),
        sink,
    )
}

fn from_sizes<P: OdeProblem>(
    method: ExplicitMethod,
    problem: &P,
    options: &IntegrationOptions,
    mut sizes: Vec<f64>,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    if let (ExplicitMethod::Rk4, StepSize::Adaptive(_)) = (method, options.step_size) {
        return Err(Error::new(Code::Usage, "rk4 takes a step, not a tolerance"));
    }
    if let StepSize::Fixed(h) = options.step_size {
        let stages = [4.0, 6.0, 12.0][method as usize];
        let cost = stages * (options.to - options.from) / h;
        if cost > options.max_work as f64 {
            let message = format!(
                "steps of {} take {} evaluations (limit {})",
                format_time(h),
                rounded(cost),
                rounded(options.max_work as f64)
            );
            return Err(Error::new(Code::BudgetExceeded, message).with_hint("take a longer step"));
        }
    }
    let first = sizes.clone();
    let mut stats = IntegrationStats::default();
    let mut samples = SampleEmitter::new(options, sink);
    let mut t = options.from;
    let mut y = options.initial_state.clone();
    samples.emit_until(t, &mut y, None, |_, _| ())?;
    while samples.due().is_some() && t < options.to {
        let stop = next_discontinuity_within(|t| problem.next_discontinuity(t), t, options.to);
        let discontinuities = [t, stop];
        while let Some(due) = samples.due().filter(|_| t < stop) {
            let end = match options.step_size {
                StepSize::Adaptive(_) => due.min(stop),
                StepSize::Fixed(_) => stop,
            };
            let sub_interval = SubInterval {
                problem,
                options,
                discontinuities,
                from: (t, &y),
                end,
            };
            let steps = sub_interval.advance(method, &mut sizes, &mut stats)?;
            let diverged = |(now, first): (&f64, &f64)| now / first > DIVERGENCE_LIMIT;
            if matches!(options.step_size, StepSize::Fixed(_))
                && sizes.iter().zip(&first).any(diverged)
            {
                return Err(out_of_range(t, end));
            }
            stats.evaluations += emit_samples(problem, options, &steps, &mut samples)?;
            if let Some((end_time, state)) = steps.into_iter().next_back() {
                (t, y) = (end_time, state);
            }
            check_budget(options, &stats, t)?;
        }
    }
    Ok(stats)
}

fn out_of_range(from: f64, to: f64) -> Error {
    let message = format!(
        "the solution diverged (overflow) between t = {} and {}",
        format_instant(from),
        format_instant(to)
    );
    Error::new(Code::Overflow, message).with_hint("the step is too long for the stiffness: take a shorter one, a tolerance, or a method for stiff machines")
}

/// Initial scales of the states: their magnitudes, at least a thousandth of the largest; from rest, a billionth of the
/// increment by the derivative over one sample.
fn first_sizes<P: OdeProblem>(problem: &P, options: &IntegrationOptions) -> Vec<f64> {
    let mut slope = vec![0.0; problem.len()];
    problem.derivative(options.from, &options.initial_state, &mut slope);
    let sample = (options.to - options.from) / options.samples.max(1) as f64;
    let largest = |x: &[f64]| x.iter().map(|x| x.abs()).fold(0.0, f64::max);
    let smallest = match (largest(&options.initial_state), sample * largest(&slope)) {
        (state, _) if state > 0.0 => 1e-3 * state,
        (_, increment) if increment > 0.0 && increment.is_finite() => 1e-9 * increment,
        _ => 1e-9,
    };
    options
        .initial_state
        .iter()
        .map(|x| x.abs().max(smallest))
        .collect()
}

/// Sub-interval between two discontinuities.
struct SubInterval<'a, P> {
    problem: &'a P,
    options: &'a IntegrationOptions,
    /// Both discontinuities, s.
    discontinuities: [f64; 2],
    /// Start of the sub-interval, s, and its state.
    from: (f64, &'a [f64]),
    /// End of the sub-interval, s.
    end: f64,
}

impl<P: OdeProblem> SubInterval<'_, P> {
    /// Advances by one call of the crate; returns the start and the ends of all steps, s, with their states.
    fn advance(
        &self,
        method: ExplicitMethod,
        sizes: &mut [f64],
        effort: &mut IntegrationStats,
    ) -> Result<Vec<(f64, Vec<f64>)>, Error> {
        let n = sizes.len();
        let failed = Cell::new(false);
        let (from, y) = self.from;
        let length = self.end - from;
        let system = TimedProblem {
            problem: self.problem,
            interval: self.discontinuities,
            from,
            sizes,
            failed: &failed,
        };
        let mut start: Vec<f64> = (0..n).map(|i| y[i] / sizes[i]).collect();
        start.push(0.0);
        let start = DVector::from_vec(start);
        // A fixed step accepts any error.
        let (tolerance, first, longest) = match self.options.step_size {
            StepSize::Adaptive(tolerance) => (tolerance, 0.0, length),
            StepSize::Fixed(h) => {
                let h = equal_step(length, h);
                (1e100, h, h)
            }
        };
        let call_length = f64::from(STEPS_PER_CALL) * longest;
        let length = if method == ExplicitMethod::Rk4 && call_length < length {
            call_length
        } else {
            length
        };
        macro_rules! controlled {
            ($solver:ident, $grow:expr, $shrink:expr) => {{
                let mut solver = $solver::from_param(
                    system,
                    0.0,
                    length,
                    length,
                    start,
                    tolerance,
                    tolerance,
                    0.9,
                    0.0,
                    $shrink,
                    $grow,
                    longest,
                    first,
                    STEPS_PER_CALL,
                    1000,
                    OutputType::Sparse,
                );
                let outcome = solver.integrate();
                let (times, states) = solver.results().get();
                (
                    outcome,
                    times.clone(),
                    states
                        .iter()
                        .map(|x| x.as_slice().to_vec())
                        .collect::<Vec<_>>(),
                )
            }};
        }
        let (outcome, times, states) = match method {
            ExplicitMethod::Rk4 => {
                // The solver takes full steps until the end is passed.
                let mut solver = Rk4::new(system, 0.0, start, length - 0.5 * longest, longest);
                let outcome = solver.integrate();
                let states = solver.y_out().iter().map(|x| x.as_slice().to_vec());
                (outcome, solver.x_out().clone(), states.collect())
            }
            ExplicitMethod::Dopri5 => controlled!(Dopri5, 10.0, 0.2),
            ExplicitMethod::Dop853 => controlled!(Dop853, 6.0, 0.333),
        };
        if failed.get() {
            return Err(out_of_range(from, self.end));
        }
        // Equal steps are counted: their sum in the crate accumulates rounding.
        let elapsed = |(k, x): (usize, &f64)| match method {
            ExplicitMethod::Rk4 => k as f64 * longest,
            _ => *x,
        };
        let instants = times.iter().enumerate().map(elapsed);
        let instants = instants.map(|x| (from + x).min(self.end));
        let unscaled = states
            .iter()
            .map(|s| (0..n).map(|i| s[i] * sizes[i]).collect());
        let mut steps: Vec<(f64, Vec<f64>)> = instants.zip(unscaled).collect();
        for i in 0..n {
            let peak = states.iter().map(|s| s[i].abs()).fold(0.0, f64::max);
            sizes[i] = sizes[i].max(peak * sizes[i]);
        }
        let reached = match (&outcome, method) {
            (Ok(_), _) if from + length >= self.end => self.end,
            (_, ExplicitMethod::Rk4) => from + length,
            _ => steps.last().map_or(from, |(t, _)| *t),
        };
        if let Some(last) = steps.last_mut() {
            last.0 = reached;
        }
        match outcome {
            Ok(stats) => {
                effort.steps += u64::from(stats.accepted_steps);
                effort.rejected += u64::from(stats.rejected_steps);
                effort.evaluations += u64::from(stats.num_eval);
                Ok(steps)
            }
            Err(IntegrationError::MaxNumStepReached { n_step, .. }) => {
                let stages = if method == ExplicitMethod::Dopri5 {
                    6
                } else {
                    12
                };
                effort.steps += u64::from(n_step);
                effort.evaluations += u64::from(n_step) * stages;
                Ok(steps)
            }
            Err(IntegrationError::StepSizeUnderflow { .. }) => Err(Error::new(
                Code::NoConvergence,
                format!(
                    "no step from t = {} keeps the error within the tolerance",
                    format_instant(reached)
                ),
            )
            .with_hint(
                "the motion jumps there: take a method that locates events, or a coarser tolerance",
            )),
            Err(IntegrationError::StiffnessDetected { .. }) => Err(Error::new(
                Code::NoConvergence,
                format!(
                    "the motion is too stiff for an explicit method at t = {}",
                    format_instant(reached)
                ),
            )
            .with_hint("take radau5")),
        }
    }
}

/// Emits the steps and the samples due in them; returns the number of evaluations. One step of order 8 from the start of each step
/// interpolates, shifted by the difference of both end states, which is below the local error.
fn emit_samples<P: OdeProblem>(
    problem: &P,
    options: &IntegrationOptions,
    steps: &[(f64, Vec<f64>)],
    samples: &mut SampleEmitter,
) -> Result<u64, Error> {
    let mut cost = IntegrationStats::default();
    for pair in steps.windows(2) {
        let [(from, start), (to, end)] = pair else {
            continue;
        };
        let span = to - from;
        if span <= 0.0 {
            continue;
        }
        let rounding = 4.0 * f64::EPSILON * to.abs();
        let is_end = |t: f64| to - t <= rounding || t - from <= rounding;
        let mut interpolant = None;
        if options.observer.is_set() || samples.due_within(*to).any(|due| !is_end(due)) {
            let mut step = Dop8Step::new(StepSizeRule::Fixed(span), ErrorScale::plain(start.len()));
            let (_, last) = step.step(problem, (*from, start), *to, &mut cost)?;
            let shift = end.iter().zip(&last).map(|(end, last)| end - last);
            interpolant = Some((step, shift.collect::<Vec<f64>>()));
        }
        let mut state_at = |t: f64, y: &mut [f64]| match &interpolant {
            _ if to - t <= rounding => y.copy_from_slice(end),
            Some((step, shift)) => {
                let theta = (t - from) / span;
                Stepper::<P>::interpolate(step, theta, y);
                y.iter_mut()
                    .zip(shift)
                    .for_each(|(y, shift)| *y += theta * shift);
            }
            None => y.copy_from_slice(start),
        };
        options.observer.observe(DenseOutput {
            from: *from,
            to: *to,
            time_scale: span,
            regime: None,
            state: &mut state_at,
        });
        let mut sample = vec![0.0; start.len()];
        samples.emit_until(*to, &mut sample, None, state_at)?;
    }
    Ok(cost.evaluations)
}
