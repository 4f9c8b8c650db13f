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

/// Result of a study of motion.
#[derive(Debug, Clone)]
pub struct MotionResult {
    /// Instants, s; none where no history is kept.
    pub time: Vec<f64>,
    /// Values of each output, SI; none where no history is kept.
    pub values: Vec<Vec<f64>>,
    /// Extremes and means of each output.
    pub statistics: Vec<Option<OutputStatistics>>,
    /// The output that its samples follow least, where too few of them lie in a period to read extremes off.
    pub undersampled: Option<UndersampledOutput>,
    /// Time reached, s.
    pub end_time: f64,
    /// Statistics of the integration.
    pub stats: IntegrationStats,
    /// Seconds.
    pub seconds: f64,
    /// Energy balance, on request.
    pub balance: Option<EnergyBalance>,
    /// Events by kind, where the method locates them.
    pub events: Option<Vec<EventRecord>>,
    /// It was stopped before its end.
    pub interrupted: bool,
}

/// Integration problem of a scene.
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

/// Integrates and keeps the history. `cancel` ends the run early; what was finished is whole.
///
/// # Errors
/// Those of the method.
pub fn run(
    setup: &SimulationSetup,
    choice: &MethodChoice,
    energy: bool,
    cancel: &CancelToken,
) -> Result<MotionResult, Error> {
    run_observed(setup, choice, energy, cancel, (true, &mut |_, _| Ok(())))
}

/// Observer of a running motion: at an instant with the state, at the outputs.
pub type StepObserver<'a> = dyn FnMut((f64, &[f64]), &[f64]) -> Result<(), Error> + 'a;

/// The same under eyes that see every instant, its history kept or not.
///
/// # Errors
/// Those of the method, and of those that look on.
pub fn run_observed(
    setup: &SimulationSetup,
    choice: &MethodChoice,
    energy: bool,
    cancel: &CancelToken,
    (keep, watch): (bool, &mut StepObserver),
) -> Result<MotionResult, Error> {
    let model = &setup.model.model;
    let mut options = integration_problem(setup, choice, setup.samples, cancel);
    let meter = energy.then(|| {
        let limit = BalanceLimit {
            evaluations: MAX_EVALUATIONS,
            predicts: false,
            cancel: cancel.clone(),
        };
        let known = setup.model.prescribed.as_ref();
        let run = [options.from, options.to];
        EnergyIntegrator::observe(model, known, run, limit, &mut options.observer)
    });
    let events =
        (choice.method.locates_events).then(|| EventLog::observe(model, &mut options.observer));
    let (mut time, mut values) = (Vec::new(), vec![Vec::new(); setup.outputs.list.len()]);
    let mut accumulators = vec![StatisticsAccumulator::default(); setup.outputs.list.len()];
    let mut peaks = PeakRefinement::new(model, &setup.outputs);
    let steps = (setup.end_time, setup.samples);
    let mut fineness = SamplingCheck::new(model, &setup.outputs, steps);
    let (mut count, mut reached, mut refused) = (0, 0.0, None);
    let start = Instant::now();
    let stats = (choice.method.run)(model, &options, &mut |t, y, regime| {
        let now = setup.outputs.evaluate(model, regime, t, y);
        if let Some(at) = now.iter().position(|value| !value.is_finite()) {
            refused = Some(overflow_error(&setup.outputs.list[at].name, now[at], t));
            return ControlFlow::Break(());
        }
        for (reader, value) in accumulators.iter_mut().zip(&now) {
            reader.push(t, *value);
        }
        peaks.push((t, y), regime, &now, &mut accumulators);
        fineness.push((t, y), regime, &now);
        if keep {
            time.push(t);
            for (list, value) in values.iter_mut().zip(&now) {
                list.push(*value);
            }
        }
        reached = t;
        refused = watch((t, y), &now).err();
        count += 1;
        // Where nothing switches, samples alone take time.
        if count % COST_CHECK_INTERVAL == 0 && refused.is_none() {
            let forecast = options.cancel.forecast_overrun(t / options.to);
            refused = forecast.map(|forecast| time_exceeded(&options, forecast, t));
        }
        match refused {
            None => ControlFlow::Continue(()),
            Some(_) => ControlFlow::Break(()),
        }
    });
    let stats = refused
        .map_or(stats, Err)
        .map_err(|e| diagnostics::with_fastest_mode(e, model))?;
    let seconds = start.elapsed().as_secs_f64();
    let balance = meter.map(|meter| meter.borrow().balance());
    Ok(MotionResult {
        time,
        values,
        statistics: accumulators
            .iter()
            .map(StatisticsAccumulator::statistics)
            .collect(),
        undersampled: fineness.worst_output(MIN_SAMPLES_PER_PERIOD),
        end_time: reached,
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

/// Samples in a period below which extremes may be a fifth short, cos(π/5).
pub const MIN_SAMPLES_PER_PERIOD: f64 = 5.0;

/// Samples between two looks at how long the whole would take.
const COST_CHECK_INTERVAL: usize = 1024;
