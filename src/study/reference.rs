//! Reference solution: agreement of two methods of different families at tight tolerances.

use super::method_run::{
    MIN_TOLERANCE, MethodRun, cost_ratio, relative_distance, run_method, step_sizes,
};
use super::monitor::{Monitor, interrupted_error};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::time_budget::CancelToken;
use crate::motion::methods::{IntegrationMethod, METHODS, StepControl};
use crate::motion::problem::StepSize;
use crate::motion::sensitivity::{Amplification, PERTURBATION_SHARE};
use crate::numeric::parallel;
use crate::numeric::sorting::sort_ascending;
use crate::plan::motion::cost::CostModel;
use crate::plan::motion::simulation_setup::SimulationSetup;

/// Reference solution with its cross-checks.
pub struct ReferenceSolution {
    /// Method of the reference.
    pub method: &'static str,
    /// Requested tolerance or step; absent for methods exact to rounding.
    pub step_size: Option<StepSize>,
    /// Cross-checks, by ascending distance.
    pub cross_checks: Vec<CrossCheck>,
    /// Methods without a result, with the reason.
    pub unavailable: Vec<(&'static str, String)>,
    /// Amplification of a perturbed initial state, as of rounding errors; `None` if nothing deforms.
    pub amplification: Option<Amplification>,
    /// Samples of each output.
    pub values: Vec<Vec<f64>>,
}

/// Cross-check of the reference by another run.
pub struct CrossCheck {
    /// Method of the cross-check.
    pub method: &'static str,
    /// Requested tolerance or step; absent for methods exact to rounding.
    pub step_size: Option<StepSize>,
    /// True for the method of the reference: common errors are not detected.
    pub related: bool,
    /// Relative distance from the reference.
    pub distance: f64,
}

/// Relative distance of two methods that need no third.
const AGREEMENT: f64 = 1e-11;

/// Relative distance of two methods that need none without event location.
const FAIR_AGREEMENT: f64 = 1e-9;

/// Refinement of one method: the run of tightest tolerance and the previous one.
struct RefinementSeries {
    method: &'static IntegrationMethod,
    trials: Vec<(Option<StepSize>, MethodRun)>,
}

impl RefinementSeries {
    /// Run of the tightest tolerance.
    fn best(&self) -> Option<&MethodRun> {
        self.trials.last().map(|t| &t.1)
    }

    fn values(&self) -> &[Vec<f64>] {
        self.best().map_or(&[], |t| &t.values)
    }
}

/// Maximum relative distance of two bounded motions, which is about 2; above it a run is unresolved.
const MAX_DISTANCE: f64 = 10.0;

impl ReferenceSolution {
    /// Error estimate of the reference: distance from the closest cross-check.
    pub fn agreement(&self) -> Option<f64> {
        self.cross_checks.first().map(|w| w.distance)
    }

    /// Computes the reference with a time limit per method, s: the more trusted method of the closest pair of different families.
    ///
    /// # Errors
    /// `BudgetExceeded` if no method resolves the motion in time; `Interrupted` before a reference is available.
    pub fn compute_reference(
        setup: &SimulationSetup,
        budget: (&CostModel, f64),
        monitor: &mut Monitor,
    ) -> Result<ReferenceSolution, Error> {
        let (runs, failures) = candidate_runs(setup, budget, monitor)?;
        let Some((index, mut cross_checks)) = most_trusted_pair(&runs) else {
            let error = Error::new(
                Code::BudgetExceeded,
                "no method gives a reference for this setup",
            );
            let reason: Vec<String> = failures
                .iter()
                .map(|(m, reason)| format!("{m}: {reason}"))
                .collect();
            return Err(error.with_hint(format!("request a shorter time; {}", reason.join("; "))));
        };
        let reference = &runs[index];
        if cross_checks.is_empty() {
            cross_checks.extend(self_check(reference)?);
        }
        let size = reference.trials.last().and_then(|t| t.0);
        let distance = cross_checks.first().map_or(0.0, |w| w.distance);
        if !(distance < MAX_DISTANCE) {
            let fault = format!("and its cross-check differ by {distance:.0e} of the motion");
            return Err(unresolved(reference.method.name, &fault));
        }
        let amplification = amplification(setup, reference, monitor);
        let method = reference.method.name;
        let values = reference.values().to_vec();
        Ok(ReferenceSolution {
            method,
            step_size: size,
            cross_checks,
            unavailable: failures,
            amplification,
            values,
        })
    }
}

/// Error for a method that does not resolve the motion.
fn unresolved(method: &str, fault: &str) -> Error {
    let message = format!(
        "no method gives a reference for this scene: {method} {fault}, so that it does not resolve the motion"
    );
    Error::new(Code::BudgetExceeded, message).with_hint("request a shorter time: --until")
}

/// Trust rank of a method, lowest for the most trusted: exact methods, methods with event location, then by order.
fn trust_rank(method: &IntegrationMethod) -> u32 {
    match (method.step_control, method.locates_events) {
        (StepControl::Exact, _) => 0,
        (StepControl::Adaptive, true) => 1,
        (StepControl::Adaptive, false) if method.order != Some(2) => 2,
        (StepControl::Fixed, _) => 3,
        (StepControl::Adaptive, false) => 4,
    }
}

/// Runs methods of different families, by trust rank, until two agree closely; returns the runs and the failures.
#[allow(clippy::type_complexity, reason = "both halves are named above")]
fn candidate_runs(
    setup: &SimulationSetup,
    budget: (&CostModel, f64),
    monitor: &mut Monitor,
) -> Result<(Vec<RefinementSeries>, Vec<(&'static str, String)>), Error> {
    let model = &setup.model.model;
    let mut pool: Vec<&'static IntegrationMethod> = METHODS
        .iter()
        .filter(|m| (m.unsupported_reason)(model).is_none())
        .collect();
    pool.sort_by_key(|m| trust_rank(m));
    let (mut runs, mut failures) = (Vec::<RefinementSeries>::new(), Vec::new());
    let mut failed_families = Vec::new();
    let mut next = 0;
    while next < pool.len() {
        let is_enough = |runs: &[RefinementSeries], method| {
            let agreement = if trust_rank(method) > 1 {
                FAIR_AGREEMENT
            } else {
                AGREEMENT
            };
            smallest_distance(runs) <= agreement
        };
        if is_enough(&runs, pool[next]) {
            break;
        }
        // Methods of different families run in parallel; unneeded results are dropped.
        let mut batch: Vec<&'static IntegrationMethod> = Vec::new();
        while let Some(&method) = pool.get(next).filter(|_| batch.len() < parallel::threads()) {
            let is_tried = runs.iter().any(|c| c.method.family == method.family);
            if !is_tried && !failed_families.contains(&method.family) {
                if batch.iter().any(|other| other.family == method.family) {
                    break;
                }
                if !monitor.proceed(&format!("reference by {}", method.name)) {
                    return Err(interrupted_error());
                }
                batch.push(method);
            }
            next += 1;
        }
        let cancel = monitor.cancel;
        let refined = parallel::map(&batch, |method| refine(setup, method, budget, cancel));
        for (method, refined) in batch.into_iter().zip(refined) {
            if is_enough(&runs, method) {
                return Ok((runs, failures));
            }
            match refined {
                Ok(series) => runs.push(series),
                Err(error) if error.code == Code::Interrupted => return Err(error),
                Err(error) => {
                    // The stability limit is common to the explicit methods of a family.
                    failed_families.extend(method.bound.map(|_| method.family));
                    failures.push((method.name, error.message));
                }
            }
        }
    }
    Ok((runs, failures))
}

/// Runs one method with decreasing tolerances or steps within its time limit, s.
fn refine(
    setup: &SimulationSetup,
    method: &'static IntegrationMethod,
    (cost, time_limit): (&CostModel, f64),
    cancel: &CancelToken,
) -> Result<RefinementSeries, Error> {
    let mut trials: Vec<(Option<StepSize>, MethodRun)> = Vec::new();
    let mut remaining_s = time_limit;
    for setting in step_sizes(setup, method) {
        let size = setting.unwrap_or(StepSize::Adaptive(MIN_TOLERANCE));
        let next = trials
            .last()
            .map_or(0.0, |t| t.1.seconds * cost_ratio(method));
        if next > remaining_s {
            break;
        }
        let min_cost = cost.lower_bound(method, size);
        if let Some(min_cost) = min_cost.filter(|min_cost| min_cost.is_beyond(remaining_s)) {
            match trials.is_empty() {
                true => return Err(Error::new(Code::BudgetExceeded, min_cost.text())),
                false => break,
            }
        }
        let time_limit = (cancel, remaining_s);
        match run_method(setup, method, size, &setup.initial_state, time_limit) {
            Ok(trial) if relative_distance(&trial.values, &trial.values).is_finite() => {
                remaining_s -= trial.seconds;
                // The previous trial suffices for comparison.
                trials.drain(..trials.len().saturating_sub(1));
                trials.push((setting, trial));
            }
            Ok(_) => {
                let message = "the solution diverged (overflow)";
                return Err(Error::new(Code::Overflow, message));
            }
            Err(error) if error.code == Code::Interrupted || trials.is_empty() => {
                return Err(error);
            }
            Err(_) => break,
        }
    }
    Ok(RefinementSeries { method, trials })
}

/// Distance of the closest pair.
fn smallest_distance(runs: &[RefinementSeries]) -> f64 {
    let partners = |index: usize| runs[index + 1..].iter().map(move |b| (index, b));
    let pairs = (0..runs.len()).flat_map(partners);
    pairs
        .map(|(index, b)| relative_distance(b.values(), runs[index].values()))
        .fold(f64::INFINITY, f64::min)
}

/// Index of the more trusted run of the closest pair, with cross-checks by the others; `None` without a run.
fn most_trusted_pair(runs: &[RefinementSeries]) -> Option<(usize, Vec<CrossCheck>)> {
    let smallest = smallest_distance(runs);
    let cross_checked = |index: usize| {
        let partners = runs.iter().enumerate().filter(move |o| o.0 != index);
        let mut checks: Vec<CrossCheck> = partners
            .map(|(_, other)| CrossCheck {
                method: other.method.name,
                step_size: other.trials.last().and_then(|t| t.0),
                related: false,
                distance: relative_distance(other.values(), runs[index].values()),
            })
            .collect();
        sort_ascending(&mut checks, |a| a.distance);
        (index, checks)
    };
    let mut checks = (0..runs.len()).map(cross_checked);
    // Distances are relative to either run, so that only the first of a pair matches exactly.
    checks.find(|(_, w)| w.first().is_none_or(|w| w.distance <= smallest))
}

/// Cross-check by the same method at a looser tolerance, for lack of another method.
///
/// # Errors
/// `BudgetExceeded`: the tighter tolerance took no more steps, so that the method does not resolve the motion and the agreement proves
/// nothing.
fn self_check(series: &RefinementSeries) -> Result<Option<CrossCheck>, Error> {
    let [.., (size, previous), (_, best)] = &series.trials[..] else {
        return Ok(None);
    };
    if best.stats.steps <= previous.stats.steps {
        let fault = format!("takes {} steps at any tolerance", best.stats.steps);
        return Err(unresolved(series.method.name, &fault));
    }
    Ok(Some(CrossCheck {
        method: series.method.name,
        step_size: *size,
        related: true,
        distance: relative_distance(&previous.values, &best.values),
    }))
}

/// Amplification of a perturbation of the initial state, by one more run.
fn amplification(
    setup: &SimulationSetup,
    series: &RefinementSeries,
    monitor: &mut Monitor,
) -> Option<Amplification> {
    let (request, best) = series.trials.last()?;
    let change = match &series.trials[..] {
        [.., (_, previous), _] => best.deflections.change_above_errors(&previous.deflections),
        _ => PERTURBATION_SHARE,
    };
    let model = &setup.model.model;
    let initial = (best.deflections).perturbed_start(model, &setup.initial_state, change);
    let request = request.unwrap_or(StepSize::Adaptive(MIN_TOLERANCE));
    let limit = (monitor.cancel, 2.0 * best.seconds + 1.0);
    let perturbed = run_method(setup, series.method, request, &initial, limit).ok()?;
    let amplification = (best.deflections).amplification(&perturbed.deflections, change)?;
    amplification.factor.is_finite().then_some(amplification)
}
