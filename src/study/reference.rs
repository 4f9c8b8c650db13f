//! Reference solution: agreement of two unrelated methods at tight tolerances.

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
use crate::numeric::sorting::sort_rising;
use crate::plan::motion::cost::CostModel;
use crate::plan::motion::simulation_setup::SimulationSetup;

/// Reference solution of the errors.
pub struct ReferenceSolution {
    /// Method of the reference.
    pub method: &'static str,
    /// Requested tolerance or step; absent for methods exact to rounding.
    pub step_size: Option<StepSize>,
    /// Cross-checks of the reference, the closest first.
    pub cross_checks: Vec<CrossCheck>,
    /// Methods that could have witnessed and did not, with the reason.
    pub unavailable: Vec<(&'static str, String)>,
    /// Amplification of a change of the start: errors of rounding grow alike. Absent where nothing deforms.
    pub amplification: Option<Amplification>,
    /// The values, output by output.
    pub values: Vec<Vec<f64>>,
}

/// Another run, and how far it is off.
pub struct CrossCheck {
    /// Method of the cross-check.
    pub method: &'static str,
    /// Requested tolerance or step; absent for methods exact to rounding.
    pub step_size: Option<StepSize>,
    /// It descends from the same method: what both get wrong it cannot show.
    pub related: bool,
    /// Distance from the reference.
    pub distance: f64,
}

/// Two that agree so far need no third.
const AGREEMENT: f64 = 1e-11;

/// Two that agree so far need none that does not locate switches.
const FAIR_AGREEMENT: f64 = 1e-9;

/// The tightest run of a method, and the one before.
struct RefinementSeries {
    method: &'static IntegrationMethod,
    trials: Vec<(Option<StepSize>, MethodRun)>,
}

impl RefinementSeries {
    /// The tightest.
    fn best(&self) -> Option<&MethodRun> {
        self.trials.last().map(|t| &t.1)
    }

    fn values(&self) -> &[Vec<f64>] {
        self.best().map_or(&[], |t| &t.values)
    }
}

/// Two bounded motions differ by about twice their size at most; a larger distance is no difference of motions.
const MAX_DISTANCE: f64 = 10.0;

impl ReferenceSolution {
    /// Distance from the closest cross-check: an estimate of the reference's own error.
    pub fn agreement(&self) -> Option<f64> {
        self.cross_checks.first().map(|w| w.distance)
    }

    /// Finds it, no method for longer than a patience, s: of all pairs of unrelated methods the closest, and of this pair the one that is trusted more.
    ///
    /// # Errors
    /// No method that could serve, or one alone that does not resolve the motion; `Interrupted` before there is one.
    pub fn compute_reference(
        setup: &SimulationSetup,
        patience: (&CostModel, f64),
        monitor: &mut Monitor,
    ) -> Result<ReferenceSolution, Error> {
        let (found, silent) = candidate_runs(setup, patience, monitor)?;
        let Some((at, mut witnesses)) = most_trusted_pair(&found) else {
            let error = Error::new(
                Code::BudgetExceeded,
                "no method gives a reference for this setup",
            );
            let why: Vec<String> = silent
                .iter()
                .map(|(m, why)| format!("{m}: {why}"))
                .collect();
            return Err(error.with_hint(format!("request a shorter time; {}", why.join("; "))));
        };
        let own = &found[at];
        if witnesses.is_empty() {
            witnesses.extend(self_check(own)?);
        }
        let size = own.trials.last().and_then(|t| t.0);
        let known = witnesses.first().map_or(0.0, |w| w.distance);
        if !(known < MAX_DISTANCE) {
            let fault = format!("and its cross-check differ by {known:.0e} of the motion");
            return Err(unresolved(own.method.name, &fault));
        }
        let amplification = amplification(setup, own, monitor);
        let method = own.method.name;
        let values = own.values().to_vec();
        Ok(ReferenceSolution {
            method,
            step_size: size,
            cross_checks: witnesses,
            unavailable: silent,
            amplification,
            values,
        })
    }
}

/// The motion that a method follows is not that of the scene.
fn unresolved(method: &str, fault: &str) -> Error {
    let message = format!(
        "no method gives a reference for this scene: {method} {fault}, so that it does not resolve the motion"
    );
    Error::new(Code::BudgetExceeded, message).with_hint("request a shorter time: --until")
}

/// Rank of a method as a reference, the most trusted lowest: exact ones first, then those that locate events, then by order.
fn trust_rank(method: &IntegrationMethod) -> u32 {
    match (method.step_control, method.locates_events) {
        (StepControl::Exact, _) => 0,
        (StepControl::Adaptive, true) => 1,
        (StepControl::Adaptive, false) if method.order != Some(2) => 2,
        (StepControl::Fixed, _) => 3,
        (StepControl::Adaptive, false) => 4,
    }
}

/// Runs of unrelated methods, the most trusted first, until two agree closely; and those that failed.
#[allow(clippy::type_complexity, reason = "both halves are named above")]
fn candidate_runs(
    setup: &SimulationSetup,
    patience: (&CostModel, f64),
    monitor: &mut Monitor,
) -> Result<(Vec<RefinementSeries>, Vec<(&'static str, String)>), Error> {
    let model = &setup.model.model;
    let mut able: Vec<&'static IntegrationMethod> = METHODS
        .iter()
        .filter(|m| (m.unsupported_reason)(model).is_none())
        .collect();
    able.sort_by_key(|m| trust_rank(m));
    let (mut found, mut silent) = (Vec::<RefinementSeries>::new(), Vec::new());
    let mut silent_kin = Vec::new();
    let mut next = 0;
    while next < able.len() {
        let is_enough = |found: &[RefinementSeries], method| {
            let enough = if trust_rank(method) > 1 {
                FAIR_AGREEMENT
            } else {
                AGREEMENT
            };
            smallest_distance(found) <= enough
        };
        if is_enough(&found, able[next]) {
            break;
        }
        // Methods of different families side by side; one that proves needless is dropped.
        let mut wave: Vec<&'static IntegrationMethod> = Vec::new();
        while let Some(&method) = able.get(next).filter(|_| wave.len() < parallel::threads()) {
            let known = found.iter().any(|c| c.method.family == method.family);
            if !known && !silent_kin.contains(&method.family) {
                if wave.iter().any(|other| other.family == method.family) {
                    break;
                }
                if !monitor.proceed(&format!("reference by {}", method.name)) {
                    return Err(interrupted_error());
                }
                wave.push(method);
            }
            next += 1;
        }
        let cancel = monitor.cancel;
        let refined = parallel::map(&wave, |method| refine(setup, method, patience, cancel));
        for (method, refined) in wave.into_iter().zip(refined) {
            if is_enough(&found, method) {
                return Ok((found, silent));
            }
            match refined {
                Ok(climbed) => found.push(climbed),
                Err(error) if error.code == Code::Interrupted => return Err(error),
                Err(error) => {
                    // Explicit methods are all bound alike.
                    silent_kin.extend(method.bound.map(|_| method.family));
                    silent.push((method.name, error.message));
                }
            }
        }
    }
    Ok((found, silent))
}

/// Ever tighter runs of one method, while the next fits into what is left of its time.
fn refine(
    setup: &SimulationSetup,
    method: &'static IntegrationMethod,
    (cost, patience): (&CostModel, f64),
    cancel: &CancelToken,
) -> Result<RefinementSeries, Error> {
    let mut trials: Vec<(Option<StepSize>, MethodRun)> = Vec::new();
    let mut left = patience;
    for rung in step_sizes(setup, method) {
        let size = rung.unwrap_or(StepSize::Adaptive(MIN_TOLERANCE));
        let next = trials
            .last()
            .map_or(0.0, |t| t.1.seconds * cost_ratio(method));
        if next > left {
            break;
        }
        let least = cost.lower_bound(method, size);
        if let Some(least) = least.filter(|least| least.is_beyond(left)) {
            match trials.is_empty() {
                true => return Err(Error::new(Code::BudgetExceeded, least.text())),
                false => break,
            }
        }
        let patience = (cancel, left);
        match run_method(setup, method, size, &setup.initial_state, patience) {
            Ok(trial) if relative_distance(&trial.values, &trial.values).is_finite() => {
                left -= trial.seconds;
                // The one before is enough to compare with.
                trials.drain(..trials.len().saturating_sub(1));
                trials.push((rung, trial));
            }
            Ok(_) => {
                let message = "the motion grew beyond all numbers";
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

/// The distance of the closest pair.
fn smallest_distance(found: &[RefinementSeries]) -> f64 {
    let others = |at: usize| found[at + 1..].iter().map(move |b| (at, b));
    let pairs = (0..found.len()).flat_map(others);
    pairs
        .map(|(at, b)| relative_distance(b.values(), found[at].values()))
        .fold(f64::INFINITY, f64::min)
}

/// The most trusted of the closest pair, with all others by their distance from it; absent where there is none at all.
fn most_trusted_pair(found: &[RefinementSeries]) -> Option<(usize, Vec<CrossCheck>)> {
    let least = smallest_distance(found);
    let beside = |at: usize| {
        let others = found.iter().enumerate().filter(move |o| o.0 != at);
        let mut all: Vec<CrossCheck> = others
            .map(|(_, other)| CrossCheck {
                method: other.method.name,
                step_size: other.trials.last().and_then(|t| t.0),
                related: false,
                distance: relative_distance(other.values(), found[at].values()),
            })
            .collect();
        sort_rising(&mut all, |a| a.distance);
        (at, all)
    };
    let mut all = (0..found.len()).map(beside);
    // Distances go by the size of either, so that only the first of a pair has it exactly.
    all.find(|(_, w)| w.first().is_none_or(|w| w.distance <= least))
}

/// Cross-check by the same method at a looser tolerance, where no other is available.
///
/// # Errors
/// `BudgetExceeded`: the tighter tolerance took no more steps, so that the method follows something other than the motion and agrees with
/// itself for nothing.
fn self_check(own: &RefinementSeries) -> Result<Option<CrossCheck>, Error> {
    let [.., (size, before), (_, best)] = &own.trials[..] else {
        return Ok(None);
    };
    if best.stats.steps <= before.stats.steps {
        let fault = format!("takes {} steps at any tolerance", best.stats.steps);
        return Err(unresolved(own.method.name, &fault));
    }
    Ok(Some(CrossCheck {
        method: own.method.name,
        step_size: *size,
        related: true,
        distance: relative_distance(&before.values, &best.values),
    }))
}

/// Runs once more from a changed start.
fn amplification(
    setup: &SimulationSetup,
    own: &RefinementSeries,
    monitor: &mut Monitor,
) -> Option<Amplification> {
    let (request, best) = own.trials.last()?;
    let change = match &own.trials[..] {
        [.., (_, before), _] => best.deflections.change_above_errors(&before.deflections),
        _ => PERTURBATION_SHARE,
    };
    let model = &setup.model.model;
    let start = (best.deflections).perturbed_start(model, &setup.initial_state, change);
    let request = request.unwrap_or(StepSize::Adaptive(MIN_TOLERANCE));
    let patience = (monitor.cancel, 2.0 * best.seconds + 1.0);
    let moved = run_method(setup, own.method, request, &start, patience).ok()?;
    let found = (best.deflections).amplification(&moved.deflections, change)?;
    found.factor.is_finite().then_some(found)
}
