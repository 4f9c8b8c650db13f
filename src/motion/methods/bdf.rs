//! Backward differentiation formulas of order 1 to 5 with error control (crate diffsol).
//!
//! Source: Shampine and Reichelt, The MATLAB ODE Suite, SIAM J. Sci. Comput. 18 (1997) 1, section 2; diffsol starts them anew
//! at every known break. Switches are not located.

use std::cell::Cell;

use diffsol::{FaerLU, FaerMat, OdeBuilder, OdeSolverMethod};

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_instant;
use crate::motion::dynamic_model::DynamicModel;
use crate::motion::error_scale::ErrorScale;
use crate::motion::problem::{
    DenseOutput, IntegrationOptions, IntegrationStats, OdeProblem, SampleSink, StepSize,
};
use crate::motion::progress::{
    SampleEmitter, check_budget, check_options, clamp_time, next_discontinuity_within,
};

/// A machine.
///
/// # Errors
/// Those of [`run`].
pub fn integrate_model(
    model: &DynamicModel,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    check_options(options, model.len())?;
    run(model, options, ErrorScale::for_model(model, options), sink)
}

/// A plain problem.
///
/// # Errors
/// Those of [`run`].
pub fn integrate_ode<P: OdeProblem>(
    problem: &P,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    run(problem, options, ErrorScale::plain(problem.len()), sink)
}

/// Integrates a problem, every state measured by its size.
///
/// # Errors
/// `NoConvergence` where steps shrink to nothing, `Overflow` where a state is not finite, `Hopeless` beyond the budget, `Usage`
/// of a step in place of a tolerance, and what cannot be asked.
fn run<P: OdeProblem>(
    problem: &P,
    options: &IntegrationOptions,
    mut scale: ErrorScale,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    check_options(options, problem.len())?;
    let StepSize::Adaptive(tolerance) = options.step_size else {
        return Err(Error::new(Code::Usage, "bdf takes a tolerance, not a step"));
    };
    let mut stats = IntegrationStats::default();
    let mut samples = SampleEmitter::new(options, sink);
    let (mut t, mut y) = (options.from, options.initial_state.clone());
    let mut sample = y.clone();
    samples.emit_until(t, &mut sample, None, |_, _| ())?;
    while samples.due().is_some() && t < options.to {
        let stop = next_discontinuity_within(|t| problem.next_discontinuity(t), t, options.to);
        let soon = 1e-2 * (options.to - options.from) / options.samples.max(1) as f64;
        let passage = ScaledInterval {
            problem,
            from: t,
            to: stop,
            sizes: scale.sizes(&y, &y, soon),
            start: y.clone(),
            evaluations: Cell::new(0),
            failed: Cell::new(false),
        };
        y = passage.integrate_interval(tolerance, options, &mut scale, &mut samples, &mut stats)?;
        t = stop;
    }
    Ok(stats)
}

/// From one known break to the next, states over their sizes.
struct ScaledInterval<'a, P> {
    problem: &'a P,
    from: f64,
    to: f64,
    sizes: Vec<f64>,
    start: Vec<f64>,
    evaluations: Cell<u64>,
    failed: Cell<bool>,
}

/// Part of a state's size by which it is moved to see how f changes: balances rounding against curvature.
const DIFFERENCE_STEP: f64 = 1.5e-8;

impl<P: OdeProblem> ScaledInterval<'_, P> {
    /// ẏ over the sizes.
    fn slope(&self, t: f64, x: &[f64], dx: &mut [f64]) {
        self.evaluations.set(self.evaluations.get() + 1);
        let y: Vec<f64> = x.iter().zip(&self.sizes).map(|(x, s)| x * s).collect();
        self.problem
            .derivative(clamp_time(t, self.from, self.to), &y, dx);
        for (dx, size) in dx.iter_mut().zip(&self.sizes) {
            *dx /= size;
            if !dx.is_finite() {
                self.failed.set(true);
                *dx = 0.0;
            }
        }
    }

    /// ∂f/∂y along a direction, by a difference.
    fn change(&self, t: f64, x: &[f64], along: &[f64], change: &mut [f64]) {
        let largest = along.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        if largest == 0.0 {
            change.fill(0.0);
            return;
        }
        let state = x.iter().zip(along).filter(|(_, v)| **v != 0.0);
        let step = DIFFERENCE_STEP * state.fold(1.0f64, |m, (x, _)| m.max(x.abs())) / largest;
        let moved: Vec<f64> = x.iter().zip(along).map(|(x, v)| x + step * v).collect();
        let mut base = vec![0.0; x.len()];
        self.slope(t, x, &mut base);
        self.slope(t, &moved, change);
        for (change, base) in change.iter_mut().zip(base) {
            *change = (*change - base) / step;
        }
    }

    /// Passes it; the state at its end.
    fn integrate_interval(
        &self,
        tolerance: f64,
        options: &IntegrationOptions,
        scale: &mut ErrorScale,
        samples: &mut SampleEmitter,
        stats: &mut IntegrationStats,
    ) -> Result<Vec<f64>, Error> {
        let n = self.start.len();
        let mut problem = OdeBuilder::<FaerMat<f64>>::new()
            .t0(self.from)
            .h0(1e-3 * (self.to - self.from))
            .rtol(tolerance)
            .atol(vec![tolerance; n])
            .rhs_implicit(
                |x: &[f64], _: &[f64], t, dx: &mut [f64]| self.slope(t, x, dx),
                |x: &[f64], _: &[f64], t, along: &[f64], change: &mut [f64]| {
                    self.change(t, x, along, change);
                },
            )
            .init(
                |_: &[f64], _, x: &mut [f64]| {
                    for i in 0..n {
                        x[i] = self.start[i] / self.sizes[i];
                    }
                },
                n,
            )
            .build()
            .map_err(|e| self.step_failure(self.from, &e.to_string()))?;
        // The package would stop at 1e-13 s whatever the time scale.
        problem.ode_options.min_timestep = 1e-20 * (self.to - self.from);
        let mut solver = problem
            .bdf::<FaerLU<f64>>()
            .map_err(|e| self.step_failure(self.from, &e.to_string()))?;
        solver
            .set_stop_time(self.to)
            .map_err(|e| self.step_failure(self.from, &e.to_string()))?;
        let before = *stats;
        let mut sample = vec![0.0; n];
        let mut reached = self.from;
        while reached < self.to && samples.due().is_some() {
            let stepped = solver.step();
            let cost = solver.get_statistics();
            stats.steps = before.steps + cost.number_of_steps as u64;
            stats.rejected = before.rejected
                + (cost.number_of_error_test_failures + cost.number_of_nonlinear_solver_fails)
                    as u64;
            stats.factorisations =
                before.factorisations + cost.number_of_linear_solver_setups as u64;
            stats.evaluations = before.evaluations + self.evaluations.get();
            if self.failed.get() {
                let message = format!(
                    "the motion leaves the range of numbers after t = {}",
                    format_instant(reached)
                );
                return Err(Error::new(Code::Overflow, message).with_hint(
                    "check the loads and the stiffness, or request a tighter tolerance",
                ));
            }
            stepped.map_err(|e| self.step_failure(reached, &e.to_string()))?;
            let before = reached;
            reached = solver.state().t;
            check_budget(options, stats, reached)?;
            let mut lost = None;
            let mut at = |due: f64, into: &mut [f64]| match solver.interpolate(due.min(reached)) {
                Ok(x) => (0..n).for_each(|i| into[i] = x[i] * self.sizes[i]),
                Err(e) => lost = Some(e.to_string()),
            };
            options.observer.observe(DenseOutput {
                from: before,
                to: reached,
                time_scale: reached - before,
                regime: None,
                state: &mut at,
            });
            samples.emit_until(reached, &mut sample, None, at)?;
            if let Some(why) = lost {
                return Err(self.step_failure(reached, &why));
            }
        }
        let state = solver.state();
        let end: Vec<f64> = (0..n).map(|i| state.y[i] * self.sizes[i]).collect();
        scale.update(&end);
        Ok(end)
    }

    fn step_failure(&self, t: f64, why: &str) -> Error {
        let message = format!(
            "no step from t = {} keeps the error within the tolerance: {why}",
            format_instant(t)
        );
        Error::new(Code::NoConvergence, message).with_hint(
            "the motion jumps there: take a method that locates events, or a coarser tolerance",
        )
    }
}
