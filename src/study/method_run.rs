//! One timed run of an integration method on a scene, with a time limit.

use std::ops::ControlFlow;
use std::time::Instant;

use super::monitor::interrupted_error;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity;
use crate::base::time_budget::CancelToken;
use crate::motion::methods::{IntegrationMethod, StepControl};
use crate::motion::problem::{IntegrationOptions, IntegrationStats, Observer, StepSize};
use crate::motion::sensitivity::Deflections;
use crate::plan::motion::simulation_setup::SimulationSetup;

/// Tightest requested tolerance of a method: below, rounding decides.
pub const MIN_TOLERANCE: f64 = 1e-13;

/// Tolerances of the refinement series.
const TOLERANCES: [f64; 6] = [1e-3, 1e-5, 1e-7, 1e-9, 1e-11, MIN_TOLERANCE];

/// Divisions of the time by fixed-step methods.
const STEPS: [f64; 4] = [1e3, 1e4, 1e5, 1e6];

/// A run that came to its end.
pub struct MethodRun {
    /// Values of each output, at every sample.
    pub values: Vec<Vec<f64>>,
    /// Deflections along the run.
    pub deflections: Deflections,
    /// Statistics of the integration.
    pub stats: IntegrationStats,
    /// Run time, s.
    pub seconds: f64,
}

/// Runs a method, for so many seconds at most; what is seen to take longer is not begun, or given up.
///
/// # Errors
/// Those of the method; `BudgetExceeded` where patience runs out, `Interrupted` where somebody asks for the end.
pub fn run_method(
    setup: &SimulationSetup,
    method: &IntegrationMethod,
    size: StepSize,
    start: &[f64],
    (cancel, patience): (&CancelToken, f64),
) -> Result<MethodRun, Error> {
    let model = &setup.model.model;
    let options = IntegrationOptions {
        from: 0.0,
        to: setup.end_time,
        initial_state: start.to_vec(),
        samples: setup.samples,
        step_size: size,
        max_work: u64::MAX,
        cancel: cancel.with_deadline(patience).with_budget(patience),
        observer: Observer::default(),
    };
    let mut values = vec![Vec::with_capacity(setup.samples + 1); setup.outputs.list.len()];
    let mut deflections = Deflections::new(model, setup.samples);
    let (mut count, mut reached) = (0, 0.0);
    let begin = Instant::now();
    let stats = (method.run)(model, &options, &mut |t, y, regime| {
        for (list, value) in values
            .iter_mut()
            .zip(setup.outputs.evaluate(model, regime, t, y))
        {
            list.push(value);
        }
        deflections.see(model, t, y);
        (count, reached) = (count + 1, t);
        ControlFlow::Continue(())
    })?;
    if cancel.is_cancelled() {
        return Err(interrupted_error());
    }
    if count <= setup.samples {
        let message = format!(
            "time budget of {patience} s exceeded at t = {} of {}",
            quantity::format_time(reached),
            quantity::format_time(setup.end_time)
        );
        return Err(Error::new(Code::BudgetExceeded, message));
    }
    Ok(MethodRun {
        values,
        deflections,
        stats,
        seconds: begin.elapsed().as_secs_f64(),
    })
}

/// Requested step sizes of a method, the coarsest first.
pub fn step_sizes(setup: &SimulationSetup, method: &IntegrationMethod) -> Vec<Option<StepSize>> {
    match method.step_control {
        StepControl::Exact => vec![None],
        StepControl::Adaptive => TOLERANCES.map(|t| Some(StepSize::Adaptive(t))).to_vec(),
        StepControl::Fixed => STEPS
            .map(|n| Some(StepSize::Fixed(setup.end_time / n)))
            .to_vec(),
    }
}

/// Upper bound of the cost ratio between successive step sizes of the refinement series. Steps go by a root of the tolerance: that of the
/// order, but
/// no more than the fourth, since errors are estimated with less.
pub fn cost_ratio(method: &IntegrationMethod) -> f64 {
    match method.step_control {
        StepControl::Fixed => 10.0,
        _ => 100.0f64.powf(1.0 / f64::from(method.order.unwrap_or(4).min(4))),
    }
}

/// The worst output's largest difference over all samples, each by its own largest size in the reference.
pub fn relative_distance(values: &[Vec<f64>], reference: &[Vec<f64>]) -> f64 {
    let of = |(x, r): (&Vec<f64>, &Vec<f64>)| {
        let size = r.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let worst = x.iter().zip(r).fold(0.0f64, |m, (a, b)| {
            let d = (a - b).abs();
            if d.is_nan() { f64::INFINITY } else { m.max(d) }
        });
        if size > 0.0 { worst / size } else { worst }
    };
    values.iter().zip(reference).map(of).fold(0.0, f64::max)
}
