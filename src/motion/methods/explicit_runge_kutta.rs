//! Adapter of the crate ode_solvers: RK4, DOPRI5 and DOP853.
//!
//! Two of its faults are gone round. Its Dormand–Prince method of order 8 has wrong nodes for explicit time, so time is
//! one more state. Its dense output is wrong at the last point, so only its steps are used. By a tolerance it is started anew at
//! every sample and every known break, and arrives there exactly; a fixed step is what was asked for whatever the samples are, and
//! these are read off between its steps.

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

use super::dop853::Dop853 as Inside;

/// Which of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExplicitMethod {
    /// Runge and Kutta's of order 4, fixed steps.
    Rk4,
    /// Dormand and Prince's of order 5.
    Dopri5,
    /// Dormand and Prince's of order 8.
    Dop853,
}

/// A machine by Runge and Kutta's method.
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

/// A machine by Dormand and Prince's method of order 5.
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

/// A machine by Dormand and Prince's method of order 8.
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
    let soon = 1e-2 * (options.to - options.from) / options.samples.max(1) as f64;
    let sizes = ErrorScale::for_model(model, options).sizes(
        &options.initial_state,
        &options.initial_state,
        soon,
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

/// Growth of a state over its first size that only a step beyond the limit of stability makes: the package takes it as it comes.
const DIVERGENCE_LIMIT: f64 = 1e30;

/// Most steps of one call of the package.
const STEPS_PER_CALL: u32 = 5_000;

/// Part of an interval between two breaks, with time as one more state.
struct TimedProblem<'a, P> {
    problem: &'a P,
    /// Both breaks, s.
    interval: [f64; 2],
    /// Start of the part, s.
    from: f64,
    /// The size of every state: tolerances are relative to it.
    sizes: &'a [f64],
    /// Something was not finite.
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

/// Integrates a problem.
///
/// # Errors
/// `NoConvergence` where steps shrink to nothing or the problem is too stiff, `Overflow` where a state is not finite,
/// `BudgetExceeded` beyond the budget, and what cannot be asked.
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
                "steps of {} would take {} evaluations, and {} are allowed",
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
        let between = [t, stop];
        while let Some(due) = samples.due().filter(|_| t < stop) {
            let end = match options.step_size {
                StepSize::Adaptive(_) => due.min(stop),
                StepSize::Fixed(_) => stop,
            };
            let part = SubInterval {
                problem,
                options,
                between,
                from: (t, &y),
                end,
            };
            let steps = part.advance(method, &mut sizes, &mut stats)?;
            let grown = |(now, first): (&f64, &f64)| now / first > DIVERGENCE_LIMIT;
            if matches!(options.step_size, StepSize::Fixed(_))
                && sizes.iter().zip(&first).any(grown)
            {
                return Err(out_of_range(t, end));
            }
            stats.evaluations += emit_samples(problem, options, &steps, &mut samples)?;
            if let Some((reached, state)) = steps.into_iter().next_back() {
                (t, y) = (reached, state);
            }
            check_budget(options, &stats, t)?;
        }
    }
    Ok(stats)
}

fn out_of_range(from: f64, to: f64) -> Error {
    let message = format!(
        "the motion leaves the range of numbers between t = {} and {}",
        format_instant(from),
        format_instant(to)
    );
    Error::new(Code::Overflow, message).with_hint("the step is too long for the stiffness: take a shorter one, a tolerance, or a method for stiff machines")
}

/// Sizes before anything has moved: what a state is, at least a thousandth of the largest; from rest, a billionth of what the
/// slope would soon make.
fn first_sizes<P: OdeProblem>(problem: &P, options: &IntegrationOptions) -> Vec<f64> {
    let mut slope = vec![0.0; problem.len()];
    problem.derivative(options.from, &options.initial_state, &mut slope);
    let soon = (options.to - options.from) / options.samples.max(1) as f64;
    let largest = |x: &[f64]| x.iter().map(|x| x.abs()).fold(0.0, f64::max);
    let least = match (largest(&options.initial_state), soon * largest(&slope)) {
        (state, _) if state > 0.0 => 1e-3 * state,
        (_, rise) if rise > 0.0 && rise.is_finite() => 1e-9 * rise,
        _ => 1e-9,
    };
    options
        .initial_state
        .iter()
        .map(|x| x.abs().max(least))
        .collect()
}

/// A part of the interval between two breaks.
struct SubInterval<'a, P> {
    problem: &'a P,
    options: &'a IntegrationOptions,
    /// Both breaks, s.
    between: [f64; 2],
    /// Start of the part, s, and the state there.
    from: (f64, &'a [f64]),
    /// End of the part, s.
    end: f64,
}

impl<P: OdeProblem> SubInterval<'_, P> {
    /// Goes as far as one call of the package leads, the ends of all steps with their states, its own beginning first.
    fn advance(
        &self,
        method: ExplicitMethod,
        sizes: &mut [f64],
        effort: &mut IntegrationStats,
    ) -> Result<Vec<(f64, Vec<f64>)>, Error> {
        let n = sizes.len();
        let failed = Cell::new(false);
        let (from, y) = self.from;
        let left = self.end - from;
        let system = TimedProblem {
            problem: self.problem,
            interval: self.between,
            from,
            sizes,
            failed: &failed,
        };
        let mut start: Vec<f64> = (0..n).map(|i| y[i] / sizes[i]).collect();
        start.push(0.0);
        let start = DVector::from_vec(start);
        // With a fixed step no error is too large.
        let (tolerance, first, longest) = match self.options.step_size {
            StepSize::Adaptive(tolerance) => (tolerance, 0.0, left),
            StepSize::Fixed(h) => {
                let h = equal_step(left, h);
                (1e100, h, h)
            }
        };
        let many = f64::from(STEPS_PER_CALL) * longest;
        let left = if method == ExplicitMethod::Rk4 && many < left {
            many
        } else {
            left
        };
        macro_rules! controlled {
            ($solver:ident, $grow:expr, $shrink:expr) => {{
                let mut solver = $solver::from_param(
                    system,
                    0.0,
                    left,
                    left,
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
                // It takes whole steps until it is past the end.
                let mut solver = Rk4::new(system, 0.0, start, left - 0.5 * longest, longest);
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
        // Equal steps are counted: their sum in the package gathers rounding.
        let since = |(k, x): (usize, &f64)| match method {
            ExplicitMethod::Rk4 => k as f64 * longest,
            _ => *x,
        };
        let instants = times.iter().enumerate().map(since);
        let instants = instants.map(|x| (from + x).min(self.end));
        let whole = states
            .iter()
            .map(|s| (0..n).map(|i| s[i] * sizes[i]).collect());
        let mut steps: Vec<(f64, Vec<f64>)> = instants.zip(whole).collect();
        for i in 0..n {
            let peak = states.iter().map(|s| s[i].abs()).fold(0.0, f64::max);
            sizes[i] = sizes[i].max(peak * sizes[i]);
        }
        let reached = match (&outcome, method) {
            (Ok(_), _) if from + left >= self.end => self.end,
            (_, ExplicitMethod::Rk4) => from + left,
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

/// Hands over the steps taken and the samples due in them. Inside a step the motion is that of one step of order 8 from its
/// beginning, shifted by what the ends are apart: less than the step's own error. Gives the evaluations that took.
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
        let at_an_end = |t: f64| to - t <= rounding || t - from <= rounding;
        let mut inside = None;
        if options.observer.is_set() || samples.due_within(*to).any(|due| !at_an_end(due)) {
            let mut step = Inside::new(StepSizeRule::Fixed(span), ErrorScale::plain(start.len()));
            let (_, reached) = step.step(problem, (*from, start), *to, &mut cost)?;
            let apart = end.iter().zip(&reached).map(|(end, reached)| end - reached);
            inside = Some((step, apart.collect::<Vec<f64>>()));
        }
        let mut at = |t: f64, y: &mut [f64]| match &inside {
            _ if to - t <= rounding => y.copy_from_slice(end),
            Some((step, apart)) => {
                let theta = (t - from) / span;
                Stepper::<P>::interpolate(step, theta, y);
                y.iter_mut()
                    .zip(apart)
                    .for_each(|(y, apart)| *y += theta * apart);
            }
            None => y.copy_from_slice(start),
        };
        options.observer.observe(DenseOutput {
            from: *from,
            to: *to,
            time_scale: span,
            regime: None,
            state: &mut at,
        });
        let mut sample = vec![0.0; start.len()];
        samples.emit_until(*to, &mut sample, None, at)?;
    }
    Ok(cost.evaluations)
}
