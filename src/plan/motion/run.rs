//! Integration run of a motion, with history and output statistics.

use std::ops::ControlFlow;
use std::time::Instant;

use super::method_choice::MethodChoice;
use super::simulation_setup::SimulationSetup;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_instant;
use crate::base::time_budget::CancelToken;
use crate::motion::diagnostics;
use crate::motion::energy_balance::{
    BalanceLimit, EnergyBalance, EnergyIntegrator, MAX_EVALUATIONS,
};
use crate::motion::event_log::{EventLog, EventRecord};
use crate::motion::output_statistics::{OutputStatistics, StatisticsAccumulator};
use crate::motion::peak_refinement::PeakRefinement;
use crate::motion::problem::{IntegrationOptions, IntegrationStats, Observer};
use crate::motion::progress::time_exceeded;
use crate::motion::sampling_check::{SamplingCheck, UndersampledOutput};

/// Result of an integration run.
#[derive(Debug, Clone)]
pub struct MotionResult {
    /// Sample times, s, ascending; empty if no history is stored.
    pub time: Vec<f64>,
    /// Values of each output at [`MotionResult::time`], SI; empty if no history is stored.
    pub values: Vec<Vec<f64>>,
    /// Extremes and means of each output.
    pub statistics: Vec<Option<OutputStatistics>>,
    /// Output with the fewest samples per period, if below [`MIN_SAMPLES_PER_PERIOD`].
    pub undersampled: Option<UndersampledOutput>,
    /// Time reached, s.
    pub end_time: f64,
    /// Statistics of the integration.
    pub stats: IntegrationStats,
    /// Wall-clock time of the integration, s.
    pub seconds: f64,
    /// Energy balance, if requested.
    pub balance: Option<EnergyBalance>,
    /// Events by kind; `None` if the method does not locate events.
    pub events: Option<Vec<EventRecord>>,
    /// Whether the run was cancelled before its end time.
    pub interrupted: bool,
}

/// Builds the integration problem of a setup with `samples` sampling intervals.
pub fn integration_problem(
    setup: &SimulationSetup,
    choice: &MethodChoice,
    samples: usize,
    cancel: &CancelToken,
) -> IntegrationOptions {
    IntegrationOptions {
        from: 0.0,
        to: setup.end_time,
        initial_state: setup.initial_state.clone(),
        samples,
        step_size: choice.step_size,
        max_work: u64::MAX,
        cancel: cancel.with_budget(setup.time_budget_s),
        observer: Observer::default(),
    }
}

/// Integrates and stores the history. If `cancel` ends the run early, the result covers the completed part.
///
/// # Errors
/// Errors of the method.
pub fn run(
    setup: &SimulationSetup,
    choice: &MethodChoice,
    energy: bool,
    cancel: &CancelToken,
) -> Result<MotionResult, Error> {
    run_observed(setup, choice, energy, cancel, (true, &mut |_, _| Ok(())))
}

/// Observer called at each sample with the time, s, and the state, and with the output values.
pub type StepObserver<'a> = dyn FnMut((f64, &[f64]), &[f64]) -> Result<(), Error> + 'a;

/// Integrates as [`run`] and calls an observer at each sample; `store_history` selects whether the history is stored.
///
/// # Errors
/// Errors of the method and of the observer.
pub fn run_observed(
    setup: &SimulationSetup,
    choice: &MethodChoice,
    energy: bool,
    cancel: &CancelToken,
    (store_history, observe): (bool, &mut StepObserver),
) -> Result<MotionResult, Error> {
    let model = &setup.model.model;
    let mut options = integration_problem(setup, choice, setup.samples, cancel);
    let energy_integrator = energy.then(|| {
        let limit = BalanceLimit {
            evaluations: MAX_EVALUATIONS,
            predicts: false,
            cancel: cancel.clone(),
        };
        let prescribed = setup.model.prescribed.as_ref();
        let span = [options.from, options.to];
        EnergyIntegrator::observe(model, prescribed, span, limit, &mut options.observer)
    });
    let events =
        (choice.method.locates_events).then(|| EventLog::observe(model, &mut options.observer));
    let (mut time, mut values) = (Vec::new(), vec![Vec::new(); setup.outputs.list.len()]);
    let mut accumulators = vec![StatisticsAccumulator::default(); setup.outputs.list.len()];
    let mut peaks = PeakRefinement::new(model, &setup.outputs);
    let steps = (setup.end_time, setup.samples);
    let mut sampling_check = SamplingCheck::new(model, &setup.outputs, steps);
    let (mut count, mut last_time, mut failure) = (0, 0.0, None);
    let start = Instant::now();
    let stats = (choice.method.run)(model, &options, &mut |t, y, regime| {
        let outputs = setup.outputs.evaluate(model, regime, t, y);
        if let Some(at) = outputs.iter().position(|value| !value.is_finite()) {
            failure = Some(overflow_error(&setup.outputs.list[at].name, outputs[at], t));
            return ControlFlow::Break(());
        }
        for (accumulator, value) in accumulators.iter_mut().zip(&outputs) {
            accumulator.push(t, *value);
        }
        peaks.push((t, y), regime, &outputs, &mut accumulators);
        sampling_check.push((t, y), regime, &outputs);
        if store_history {
            time.push(t);
            for (history, value) in values.iter_mut().zip(&outputs) {
                history.push(*value);
            }
        }
        last_time = t;
        failure = observe((t, y), &outputs).err();
        count += 1;
        // Without switching events only sampling takes time, so the budget is checked here.
        if count % COST_CHECK_INTERVAL == 0 && failure.is_none() {
            let forecast = options.cancel.forecast_overrun(t / options.to);
            failure = forecast.map(|forecast| time_exceeded(&options, forecast, t));
        }
        match failure {
            None => ControlFlow::Continue(()),
            Some(_) => ControlFlow::Break(()),
        }
    });
    let stats = failure
        .map_or(stats, Err)
        .map_err(|e| diagnostics::with_fastest_mode(e, model))?;
    let seconds = start.elapsed().as_secs_f64();
    let balance = energy_integrator.map(|energy_integrator| energy_integrator.borrow().balance());
    Ok(MotionResult {
        time,
        values,
        statistics: accumulators
            .iter()
            .map(StatisticsAccumulator::statistics)
            .collect(),
        undersampled: sampling_check.worst_output(MIN_SAMPLES_PER_PERIOD),
        end_time: last_time,
        stats,
        seconds,
        balance,
        events: events.map(|log| log.borrow().records()),
        interrupted: count <= options.samples,
    })
}

fn overflow_error(output: &str, value: f64, t: f64) -> Error {
    let message = format!("{output} is {value} at t = {}", format_instant(t));
    Error::new(Code::Overflow, message).with_hint(
        "check the sizes of loads, stiffness, inertia and initial state, and the duration",
    )
}

/// Samples per period below which sampled extremes may be a fifth too small: cos(π/5) = 0.81.
pub const MIN_SAMPLES_PER_PERIOD: f64 = 5.0;

/// Samples between two checks of the time budget.
const COST_CHECK_INTERVAL: usize = 1024;
