//! The explicit methods of ode_solvers: Runge and Kutta's of order 4, Dormand and Prince's of order 5 and 8.
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
use crate::base::units::{instant, seconds};
use crate::motion::problem::{Ask, Effort, Problem, Sink, Stretch, Wanted};
use crate::motion::progress::{Samples, check, inside, next_stop, rounded, within_budget};
use crate::motion::scale::Scale;
use crate::motion::stepper::{Control, Stepper, equal_part};
use crate::motion::train::Train;
use crate::motion::trouble;

use super::dop853::Dop853 as Inside;

/// Which of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Explicit {
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
pub fn rk4(train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    machine(Explicit::Rk4, train, ask, sink)
}

/// A machine by Dormand and Prince's method of order 5.
///
/// # Errors
/// Those of [`run`].
pub fn dopri5(train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    machine(Explicit::Dopri5, train, ask, sink)
}

/// A machine by Dormand and Prince's method of order 8.
///
/// # Errors
/// Those of [`run`].
pub fn dop853(train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    machine(Explicit::Dop853, train, ask, sink)
}

fn machine(method: Explicit, train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    check(ask, train.len())?;
    let soon = 1e-2 * (ask.to - ask.from) / ask.samples.max(1) as f64;
    let sizes = Scale::of_train(train, ask).sizes(&ask.start, &ask.start, soon);
    let sizes = sizes
        .into_iter()
        .map(|s| if s > 1e-200 { s } else { 1e-9 })
        .collect();
    let mut last = (ask.from, ask.start.clone());
    let result = from_sizes(method, train, ask, sizes, &mut |t, y, _| {
        last = (t, y.to_vec());
        sink(t, y, None)
    });
    result.map_err(|error| match error.code {
        Code::NoConvergence | Code::Overflow => trouble::beside(error, train, last.0, &last.1),
        _ => error,
    })
}

/// Growth of a state over its first size that only a step beyond the limit of stability makes: the package takes it as it comes.
const BEYOND_BELIEF: f64 = 1e30;

/// Most steps of one call of the package.
const STEPS_A_CALL: u32 = 5_000;

/// Part of a stretch between two breaks, with time as one more state.
struct Clocked<'a, P> {
    problem: &'a P,
    /// Both breaks, s.
    stretch: [f64; 2],
    /// Where the part begins, s.
    from: f64,
    /// The size of every state: tolerances are relative to it.
    sizes: &'a [f64],
    /// Something was not finite.
    failed: &'a Cell<bool>,
}

impl<P: Problem> System<f64, DVector<f64>> for Clocked<'_, P> {
    fn system(&self, _x: f64, y: &DVector<f64>, dy: &mut DVector<f64>) {
        let n = self.sizes.len();
        if self.failed.get() {
            return;
        }
        let t = inside(self.from + y[n], self.stretch[0], self.stretch[1]);
        let state: Vec<f64> = (0..n).map(|i| self.sizes[i] * y[i]).collect();
        let mut slope = vec![0.0; n];
        self.problem.slope(t, &state, &mut slope);
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
/// `Hopeless` beyond the budget, and what cannot be asked.
pub fn run<P: Problem>(
    method: Explicit,
    problem: &P,
    ask: &Ask,
    sink: &mut Sink,
) -> Result<Effort, Error> {
    check(ask, problem.len())?;
    from_sizes(method, problem, ask, first_sizes(problem, ask), sink)
}

fn from_sizes<P: Problem>(
    method: Explicit,
    problem: &P,
    ask: &Ask,
    mut sizes: Vec<f64>,
    sink: &mut Sink,
) -> Result<Effort, Error> {
    if let (Explicit::Rk4, Wanted::Tolerance(_)) = (method, ask.effort) {
        return Err(Error::new(Code::Usage, "rk4 takes a step, not a tolerance"));
    }
    if let Wanted::Step(h) = ask.effort {
        let stages = [4.0, 6.0, 12.0][method as usize];
        let cost = stages * (ask.to - ask.from) / h;
        if cost > ask.budget as f64 {
            let message = format!(
                "steps of {} would take {} evaluations, and {} are allowed",
                seconds(h),
                rounded(cost),
                rounded(ask.budget as f64)
            );
            return Err(Error::new(Code::Hopeless, message).hint("take a longer step"));
        }
    }
    let first = sizes.clone();
    let mut effort = Effort::default();
    let mut samples = Samples::new(ask, sink);
    let mut t = ask.from;
    let mut y = ask.start.clone();
    samples.give_until(t, &mut y, None, |_, _| ())?;
    while samples.due().is_some() && t < ask.to {
        let stop = next_stop(|t| problem.next_break(t), t, ask.to);
        let between = [t, stop];
        while let Some(due) = samples.due().filter(|_| t < stop) {
            let end = match ask.effort {
                Wanted::Tolerance(_) => due.min(stop),
                Wanted::Step(_) => stop,
            };
            let part = Part {
                problem,
                ask,
                between,
                from: (t, &y),
                end,
            };
            let steps = part.pass(method, &mut sizes, &mut effort)?;
            let grown = |(now, first): (&f64, &f64)| now / first > BEYOND_BELIEF;
            if matches!(ask.effort, Wanted::Step(_)) && sizes.iter().zip(&first).any(grown) {
                return Err(out_of_range(t, end));
            }
            effort.evaluations += hand_over(problem, ask, &steps, &mut samples)?;
            if let Some((reached, state)) = steps.into_iter().next_back() {
                (t, y) = (reached, state);
            }
            within_budget(ask, &effort, t)?;
        }
    }
    Ok(effort)
}

fn out_of_range(from: f64, to: f64) -> Error {
    let message = format!(
        "the motion leaves the range of numbers between t = {} and {}",
        instant(from),
        instant(to)
    );
    Error::new(Code::Overflow, message).hint("the step is too long for the stiffness: take a shorter one, a tolerance, or a method for stiff machines")
}

/// Sizes before anything has moved: what a state is, at least a thousandth of the largest; from rest, a billionth of what the
/// slope would soon make.
fn first_sizes<P: Problem>(problem: &P, ask: &Ask) -> Vec<f64> {
    let mut slope = vec![0.0; problem.len()];
    problem.slope(ask.from, &ask.start, &mut slope);
    let soon = (ask.to - ask.from) / ask.samples.max(1) as f64;
    let largest = |x: &[f64]| x.iter().map(|x| x.abs()).fold(0.0, f64::max);
    let least = match (largest(&ask.start), soon * largest(&slope)) {
        (state, _) if state > 0.0 => 1e-3 * state,
        (_, rise) if rise > 0.0 && rise.is_finite() => 1e-9 * rise,
        _ => 1e-9,
    };
    ask.start.iter().map(|x| x.abs().max(least)).collect()
}

/// A part of the stretch between two breaks.
struct Part<'a, P> {
    problem: &'a P,
    ask: &'a Ask,
    /// Both breaks, s.
    between: [f64; 2],
    /// Where it begins, s, and the state there.
    from: (f64, &'a [f64]),
    /// Where it is to end, s.
    end: f64,
}

impl<P: Problem> Part<'_, P> {
    /// Goes as far as one call of the package leads, the ends of all steps with their states, its own beginning first.
    fn pass(
        &self,
        method: Explicit,
        sizes: &mut [f64],
        effort: &mut Effort,
    ) -> Result<Vec<(f64, Vec<f64>)>, Error> {
        let n = sizes.len();
        let failed = Cell::new(false);
        let (from, y) = self.from;
        let left = self.end - from;
        let system = Clocked {
            problem: self.problem,
            stretch: self.between,
            from,
            sizes,
            failed: &failed,
        };
        let mut start: Vec<f64> = (0..n).map(|i| y[i] / sizes[i]).collect();
        start.push(0.0);
        let start = DVector::from_vec(start);
        // With a fixed step no error is too large.
        let (tolerance, first, longest) = match self.ask.effort {
            Wanted::Tolerance(tolerance) => (tolerance, 0.0, left),
            Wanted::Step(h) => {
                let h = equal_part(left, h);
                (1e100, h, h)
            }
        };
        let many = f64::from(STEPS_A_CALL) * longest;
        let left = if method == Explicit::Rk4 && many < left {
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
                    STEPS_A_CALL,
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
            Explicit::Rk4 => {
                // It takes whole steps until it is past the end.
                let mut solver = Rk4::new(system, 0.0, start, left - 0.5 * longest, longest);
                let outcome = solver.integrate();
                let states = solver.y_out().iter().map(|x| x.as_slice().to_vec());
                (outcome, solver.x_out().clone(), states.collect())
            }
            Explicit::Dopri5 => controlled!(Dopri5, 10.0, 0.2),
            Explicit::Dop853 => controlled!(Dop853, 6.0, 0.333),
        };
        if failed.get() {
            return Err(out_of_range(from, self.end));
        }
        // Equal steps are counted: their sum in the package gathers rounding.
        let since = |(k, x): (usize, &f64)| match method {
            Explicit::Rk4 => k as f64 * longest,
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
            (_, Explicit::Rk4) => from + left,
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
                let stages = if method == Explicit::Dopri5 { 6 } else { 12 };
                effort.steps += u64::from(n_step);
                effort.evaluations += u64::from(n_step) * stages;
                Ok(steps)
            }
            Err(IntegrationError::StepSizeUnderflow { .. }) => Err(Error::new(
                Code::NoConvergence,
                format!(
                    "no step from t = {} keeps the error within the tolerance",
                    instant(reached)
                ),
            )
            .hint(
                "the motion jumps there: take a method that locates events, or a coarser tolerance",
            )),
            Err(IntegrationError::StiffnessDetected { .. }) => Err(Error::new(
                Code::NoConvergence,
                format!(
                    "the motion is too stiff for an explicit method at t = {}",
                    instant(reached)
                ),
            )
            .hint("take radau5")),
        }
    }
}

/// Hands over the steps taken and the samples due in them. Inside a step the motion is that of one step of order 8 from its
/// beginning, shifted by what the ends are apart: less than the step's own error. Gives the evaluations that took.
fn hand_over<P: Problem>(
    problem: &P,
    ask: &Ask,
    steps: &[(f64, Vec<f64>)],
    samples: &mut Samples,
) -> Result<u64, Error> {
    let mut cost = Effort::default();
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
        if ask.follower.is_there() || samples.due_within(*to).any(|due| !at_an_end(due)) {
            let mut step = Inside::new(Control::Fixed(span), Scale::plain(start.len()));
            let (_, reached) = step.step(problem, (*from, start), *to, &mut cost)?;
            let apart = end.iter().zip(&reached).map(|(end, reached)| end - reached);
            inside = Some((step, apart.collect::<Vec<f64>>()));
        }
        let mut at = |t: f64, y: &mut [f64]| match &inside {
            _ if to - t <= rounding => y.copy_from_slice(end),
            Some((step, apart)) => {
                let theta = (t - from) / span;
                Stepper::<P>::inside(step, theta, y);
                y.iter_mut()
                    .zip(apart)
                    .for_each(|(y, apart)| *y += theta * apart);
            }
            None => y.copy_from_slice(start),
        };
        ask.follower.follow(Stretch {
            from: *from,
            to: *to,
            grain: span,
            regime: None,
            state: &mut at,
        });
        let mut sample = vec![0.0; start.len()];
        samples.give_until(*to, &mut sample, None, at)?;
    }
    Ok(cost.evaluations)
}
