//! Work–precision study: integration methods against one reference solution.
//!
//! The error of an output is its largest difference from the reference over all samples, divided by the largest size of the
//! reference; that of a run is the worst of its outputs. Errors below the difference of the reference from the closest
//! independent solution cannot be resolved, so no smaller error is stated. Times are the minimum of several repeats.

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

/// Work–precision results of one scene.
pub struct WorkPrecisionResult {
    /// Reference of the errors.
    pub reference: ReferenceSolution,
    /// Runs of every method at every tolerance or step, completed or not.
    pub runs: Vec<WorkPrecisionRun>,
    /// True if the study was interrupted.
    pub interrupted: bool,
}

/// Run of a method at one tolerance or step.
pub struct WorkPrecisionRun {
    /// Method name.
    pub method: &'static str,
    /// Requested tolerance or step; absent for exact and unsupported methods, and for methods without a step size.
    pub step_size: Option<StepSize>,
    /// Outcome of the run.
    pub outcome: RunOutcome,
}

/// Outcome of a run.
pub enum RunOutcome {
    /// Completed run.
    Completed {
        /// Error of the run, not below that of the reference.
        error: f64,
        /// Minimum run time of the repeats, s.
        seconds: f64,
        /// Statistics of the integration.
        stats: IntegrationStats,
    },
    /// Failed run with its error.
    Failed(Error),
    /// Skipped run with the reason.
    Skipped(String),
}

/// Recommended run for an error bound.
pub enum Recommendation<'a> {
    /// Cheapest run within the bound, and the cheapest one of another method.
    Cheapest(&'a WorkPrecisionRun, Option<&'a WorkPrecisionRun>),
    /// Run with the smallest error, if none is within the bound.
    Nearest(&'a WorkPrecisionRun),
    /// No run was completed.
    Unavailable,
}

/// Default time limit, s, of a run, and of all runs of one method for the reference.
pub const TIME_LIMIT: f64 = 10.0;

/// Maximum number of histories in memory: those of the reference candidates, and that of the run compared with the reference.
const MAX_HISTORIES: usize = 16;

/// Runs every method. A run that would take longer than `time_limit`, s, is skipped or aborted. If interrupted, the study returns the
/// completed runs.
///
/// # Errors
/// An unknown method; no method that could serve as the reference; `Interrupted` before there is one.
pub fn work_precision(
    setup: &SimulationSetup,
    methods: &[String],
    time_limit: f64,
    monitor: &mut Monitor,
) -> Result<WorkPrecisionResult, Error> {
    check_study(setup, methods)?;
    let selection: Vec<&'static IntegrationMethod> = match methods.is_empty() {
        true => METHODS.iter().collect(),
        false => find_methods(methods)?,
    };
    let cost = CostModel::new(setup);
    let reference = ReferenceSolution::compute_reference(setup, (&cost, time_limit), monitor)?;
    let criteria = RunCriteria {
        reference: &reference,
        cost,
        time_limit,
    };
    let mut runs = Vec::new();
    for method in selection {
        match (method.unsupported_reason)(&setup.model.model) {
            Some(reason) => runs.push(WorkPrecisionRun {
                method: method.name,
                step_size: None,
                outcome: RunOutcome::Skipped(reason),
            }),
            None => run_step_sizes(setup, method, &criteria, monitor, &mut runs),
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

/// Checks methods and memory before any run.
///
/// # Errors
/// An unknown method; histories that exceed the memory limit.
pub fn check_study(setup: &SimulationSetup, methods: &[String]) -> Result<(), Error> {
    find_methods(methods)?;
    check_memory(setup, MAX_HISTORIES)
}

/// Reference and limits of the runs.
struct RunCriteria<'a> {
    reference: &'a ReferenceSolution,
    cost: CostModel<'a>,
    /// Time limit of a run, s.
    time_limit: f64,
}

/// Runs a method at every tolerance or step, the coarsest first; runs beyond the time limit are listed as skipped.
fn run_step_sizes(
    setup: &SimulationSetup,
    method: &'static IntegrationMethod,
    criteria: &RunCriteria,
    monitor: &mut Monitor,
    runs: &mut Vec<WorkPrecisionRun>,
) {
    let mut skip_reason = None;
    for step_size in step_sizes(setup, method) {
        let size = step_size.unwrap_or(StepSize::Adaptive(MIN_TOLERANCE));
        let bound = criteria.cost.lower_bound(method, size);
        let bound = bound.filter(|bound| bound.is_beyond(criteria.time_limit));
        skip_reason = skip_reason.or(bound.map(|bound| format!("not run: {}", bound.text())));
        let outcome = match &skip_reason {
            Some(reason) => RunOutcome::Skipped(String::clone(reason)),
            None => {
                let proceeds = monitor.proceed(method.name);
                let outcome = run(setup, method, step_size, criteria, monitor.cancel);
                if !proceeds || monitor.cancel.is_cancelled() {
                    return;
                }
                skip_reason = outcome.skip_reason(method, criteria.time_limit);
                outcome
            }
        };
        runs.push(WorkPrecisionRun {
            method: method.name,
            step_size,
            outcome,
        });
    }
}

impl RunOutcome {
    /// Reason to skip the next finer run; none if it fits the time limit.
    fn skip_reason(&self, method: &IntegrationMethod, time_limit: f64) -> Option<String> {
        match self {
            RunOutcome::Completed { seconds, .. } => {
                let next = cost_ratio(method) * seconds;
                (next > time_limit).then(|| {
                    format!(
                        "not run: the previous run took {}, this one would take about {}",
                        quantity::format_time(*seconds),
                        quantity::format_time(next)
                    )
                })
            }
            RunOutcome::Failed(error) if error.code == Code::BudgetExceeded => {
                Some("not run: the previous run exceeded its time budget".to_string())
            }
            _ => None,
        }
    }
}

impl WorkPrecisionRun {
    /// Error of a completed run.
    pub fn error(&self) -> Option<f64> {
        match self.outcome {
            RunOutcome::Completed { error, .. } => Some(error),
            _ => None,
        }
    }

    /// Run time of a completed run, s.
    pub fn seconds(&self) -> Option<f64> {
        match self.outcome {
            RunOutcome::Completed { seconds, .. } => Some(seconds),
            _ => None,
        }
    }

    /// Reason that the run has no error.
    pub fn reason(&self) -> Option<&str> {
        match &self.outcome {
            RunOutcome::Completed { .. } => None,
            RunOutcome::Failed(error) => Some(&error.message),
            RunOutcome::Skipped(reason) => Some(reason),
        }
    }
}

impl WorkPrecisionResult {
    /// Recommends a run for an error bound.
    pub fn recommend(&self, error: f64) -> Recommendation<'_> {
        let candidates = || {
            let runs = self.runs.iter();
            runs.filter(|r| r.error().is_some_and(|e| e <= error))
        };
        let time = |run: &WorkPrecisionRun| run.seconds().unwrap_or(f64::INFINITY);
        let cheaper = |a: &&WorkPrecisionRun, b: &&WorkPrecisionRun| time(a).total_cmp(&time(b));
        if let Some(cheapest) = candidates().min_by(cheaper) {
            let others = candidates().filter(|r| r.method != cheapest.method);
            return Recommendation::Cheapest(cheapest, others.min_by(cheaper));
        }
        let runs = self.runs.iter().filter(|r| r.error().is_some());
        let error_of = |run: &WorkPrecisionRun| run.error().unwrap_or(f64::INFINITY);
        let nearest = runs.min_by(|a, b| error_of(a).total_cmp(&error_of(b)).then(cheaper(a, b)));
        nearest.map_or(Recommendation::Unavailable, Recommendation::Nearest)
    }
}

fn run(
    setup: &SimulationSetup,
    method: &'static IntegrationMethod,
    step_size: Option<StepSize>,
    criteria: &RunCriteria,
    cancel: &CancelToken,
) -> RunOutcome {
    let size = step_size.unwrap_or(StepSize::Adaptive(MIN_TOLERANCE));
    let (outcome, seconds) = min_time(|| {
        let trial = run_method(
            setup,
            method,
            size,
            &setup.initial_state,
            (cancel, criteria.time_limit),
        )?;
        let error = relative_distance(&trial.values, &criteria.reference.values);
        let error = error.max(criteria.reference.agreement().unwrap_or(0.0));
        match error.is_finite() {
            true => Ok((error, trial.stats)),
            false => Err(Error::new(
                Code::Overflow,
                "the solution diverged (overflow)",
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
