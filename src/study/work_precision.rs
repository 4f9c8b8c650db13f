//! Work–precision study: integration methods against one reference solution.
//!
//! The error of an output is its largest difference from the reference over all samples, divided by the largest size of the
//! reference; that of a run is the worst of its outputs. Nothing below the distance of the reference from its closest unrelated
//! witness can be told, so no error is stated smaller. Times are the least of several repeats.

use super::method_run::{MIN_TOLERANCE, cost_ratio, relative_distance, run_method, step_sizes};
use super::monitor::Monitor;
use super::reference::ReferenceSolution;
use super::timing::min_time;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity;
use crate::base::time_budget::CancelToken;
use crate::motion::methods::{IntegrationMethod, METHODS};
use crate::motion::problem::{IntegrationStats, StepSize};
use crate::plan::motion::cost::{CostModel, check_memory};
use crate::plan::motion::method_choice::find_methods;
use crate::plan::motion::simulation_setup::SimulationSetup;

/// Error against run time of one scene.
pub struct WorkPrecisionResult {
    /// Reference of the errors.
    pub reference: ReferenceSolution,
    /// Every rung of every method, run or not.
    pub runs: Vec<WorkPrecisionRun>,
    /// It ended before all were done.
    pub interrupted: bool,
}

/// One rung of a method.
pub struct WorkPrecisionRun {
    /// The method.
    pub method: &'static str,
    /// Requested tolerance or step; absent for exact methods, and for those that take no step size at all.
    pub step_size: Option<StepSize>,
    /// Outcome of the run.
    pub outcome: RunOutcome,
}

/// Outcome of a run.
pub enum RunOutcome {
    /// It came to its end.
    Completed {
        /// Error of the run, not below that of the reference.
        error: f64,
        /// The least time of its repeats, s.
        seconds: f64,
        /// Statistics of the integration.
        stats: IntegrationStats,
    },
    /// It did not, for this reason.
    Failed(Error),
    /// It was not begun, for this reason.
    Skipped(String),
}

/// Recommendation for an error.
pub enum Recommendation<'a> {
    /// The cheapest run that reaches it, and the cheapest of another method.
    Cheapest(&'a WorkPrecisionRun, Option<&'a WorkPrecisionRun>),
    /// None reaches it; this one comes nearest.
    Nearest(&'a WorkPrecisionRun),
    /// No run came to its end.
    Unavailable,
}

/// Seconds a rung may take, and all runs of one method for the reference.
pub const TIME_LIMIT: f64 = 10.0;

/// Histories held at a time: those of the methods that may be the reference, and of the rung compared with it.
const MAX_HISTORIES: usize = 16;

/// Runs every method. A rung that would take longer than `time_limit`, s, is not begun or given up. Ended early, it gives the runs
/// that were finished.
///
/// # Errors
/// An unknown method; no method that could serve as the reference; `Interrupted` before there is one.
pub fn work_precision(
    setup: &SimulationSetup,
    methods: &[String],
    patience: f64,
    monitor: &mut Monitor,
) -> Result<WorkPrecisionResult, Error> {
    refuse(setup, methods)?;
    let chosen: Vec<&'static IntegrationMethod> = match methods.is_empty() {
        true => METHODS.iter().collect(),
        false => find_methods(methods)?,
    };
    let cost = CostModel::new(setup);
    let reference = ReferenceSolution::compute_reference(setup, (&cost, patience), monitor)?;
    let judge = RunCriteria {
        reference: &reference,
        cost,
        time_limit: patience,
    };
    let mut runs = Vec::new();
    for method in chosen {
        match (method.unsupported_reason)(&setup.model.model) {
            Some(why) => runs.push(WorkPrecisionRun {
                method: method.name,
                step_size: None,
                outcome: RunOutcome::Skipped(why),
            }),
            None => run_step_sizes(setup, method, &judge, monitor, &mut runs),
        }
        if monitor.cancel.is_cancelled() {
            break;
        }
    }
    Ok(WorkPrecisionResult {
        reference,
        runs,
        interrupted: monitor.cancel.is_cancelled(),
    })
}

/// Refuses what can be known before any run.
///
/// # Errors
/// An unknown method; histories that would take more room than is allowed.
pub fn refuse(setup: &SimulationSetup, methods: &[String]) -> Result<(), Error> {
    find_methods(methods)?;
    check_memory(setup, MAX_HISTORIES)
}

/// Criteria that judge the runs.
struct RunCriteria<'a> {
    reference: &'a ReferenceSolution,
    cost: CostModel<'a>,
    /// Seconds a rung may take.
    time_limit: f64,
}

/// Every rung of a method, the coarsest first; those that would take too long are listed and not begun.
fn run_step_sizes(
    setup: &SimulationSetup,
    method: &'static IntegrationMethod,
    judge: &RunCriteria,
    monitor: &mut Monitor,
    runs: &mut Vec<WorkPrecisionRun>,
) {
    let mut dear = None;
    for rung in step_sizes(setup, method) {
        let size = rung.unwrap_or(StepSize::Adaptive(MIN_TOLERANCE));
        let least = judge.cost.lower_bound(method, size);
        let least = least.filter(|least| least.is_beyond(judge.time_limit));
        dear = dear.or(least.map(|least| format!("not run: {}", least.text())));
        let outcome = match &dear {
            Some(why) => RunOutcome::Skipped(String::clone(why)),
            None => {
                let on = monitor.proceed(method.name);
                let outcome = run(setup, method, rung, judge, monitor.cancel);
                if !on || monitor.cancel.is_cancelled() {
                    return;
                }
                dear = outcome.skip_reason(method, judge.time_limit);
                outcome
            }
        };
        runs.push(WorkPrecisionRun {
            method: method.name,
            step_size: rung,
            outcome,
        });
    }
}

impl RunOutcome {
    /// Why the next finer rung is not worth beginning.
    fn skip_reason(&self, method: &IntegrationMethod, patience: f64) -> Option<String> {
        match self {
            RunOutcome::Completed { seconds, .. } => {
                let next = cost_ratio(method) * seconds;
                (next > patience).then(|| {
                    format!(
                        "not run: the last took {}, the next would take about {}",
                        quantity::format_time(*seconds),
                        quantity::format_time(next)
                    )
                })
            }
            RunOutcome::Failed(error) if error.code == Code::BudgetExceeded => {
                Some("not run: the last was given up".to_string())
            }
            _ => None,
        }
    }
}

impl WorkPrecisionRun {
    /// Error, where the run was completed.
    pub fn error(&self) -> Option<f64> {
        match self.outcome {
            RunOutcome::Completed { error, .. } => Some(error),
            _ => None,
        }
    }

    /// Run time, s, where the run was completed.
    pub fn seconds(&self) -> Option<f64> {
        match self.outcome {
            RunOutcome::Completed { seconds, .. } => Some(seconds),
            _ => None,
        }
    }

    /// Why it has no error.
    pub fn reason(&self) -> Option<&str> {
        match &self.outcome {
            RunOutcome::Completed { .. } => None,
            RunOutcome::Failed(error) => Some(&error.message),
            RunOutcome::Skipped(why) => Some(why),
        }
    }
}

impl WorkPrecisionResult {
    /// Recommends a method for an error.
    pub fn recommend(&self, error: f64) -> Recommendation<'_> {
        let reached = || {
            let all = self.runs.iter();
            all.filter(|r| r.error().is_some_and(|e| e <= error))
        };
        let time = |run: &WorkPrecisionRun| run.seconds().unwrap_or(f64::INFINITY);
        let cheaper = |a: &&WorkPrecisionRun, b: &&WorkPrecisionRun| time(a).total_cmp(&time(b));
        if let Some(best) = reached().min_by(cheaper) {
            let others = reached().filter(|r| r.method != best.method);
            return Recommendation::Cheapest(best, others.min_by(cheaper));
        }
        let ended = self.runs.iter().filter(|r| r.error().is_some());
        let off = |run: &WorkPrecisionRun| run.error().unwrap_or(f64::INFINITY);
        let nearest = ended.min_by(|a, b| off(a).total_cmp(&off(b)).then(cheaper(a, b)));
        nearest.map_or(Recommendation::Unavailable, Recommendation::Nearest)
    }
}

fn run(
    setup: &SimulationSetup,
    method: &'static IntegrationMethod,
    rung: Option<StepSize>,
    judge: &RunCriteria,
    cancel: &CancelToken,
) -> RunOutcome {
    let size = rung.unwrap_or(StepSize::Adaptive(MIN_TOLERANCE));
    let (outcome, seconds) = min_time(|| {
        let trial = run_method(
            setup,
            method,
            size,
            &setup.initial_state,
            (cancel, judge.time_limit),
        )?;
        let error = relative_distance(&trial.values, &judge.reference.values);
        let error = error.max(judge.reference.agreement().unwrap_or(0.0));
        match error.is_finite() {
            true => Ok((error, trial.stats)),
            false => Err(Error::new(
                Code::Overflow,
                "the motion grew beyond all numbers",
            )),
        }
    });
    match outcome {
        Ok((error, stats)) => RunOutcome::Completed {
            error,
            seconds,
            stats,
        },
        Err(error) => RunOutcome::Failed(error),
    }
}
