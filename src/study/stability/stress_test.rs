//! Stress test: simulations of the scene with extreme parameters, verified by the energy balance.

use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};

use super::perturbations::{CASES, Perturbation, PerturbedScene, no_effect_reason};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_time;
use crate::base::time_budget::CancelToken;
use crate::motion::energy_balance::{BalanceLimit, EnergyBalance, EnergyIntegrator};
use crate::motion::methods::{IntegrationMethod, METHODS, StepControl};
use crate::motion::problem::{IntegrationOptions, Observer, StepSize};
use crate::motion::progress::rounded;
use crate::numeric::parallel;
use crate::plan::motion::method_choice::{DEFAULT_TOLERANCE, choose_method, find_methods};
use crate::plan::motion::simulation_setup::SimulationSetup;
use crate::scene::study::SimulateStudy;
use crate::study::monitor::Monitor;

/// Case of the stress test: a simulation of the perturbed scene by one method.
pub struct StressCase {
    /// Name of the perturbation.
    pub name: String,
    /// Integration method.
    pub method: &'static str,
    /// Verdict on the case.
    pub verdict: CaseVerdict,
    /// Energy-balance error, relative to the largest term of the balance.
    pub energy_error: Option<f64>,
    /// Reason of a refusal or failure.
    pub reason: Option<String>,
}

/// Verdict on a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CaseVerdict {
    /// The result is finite and satisfies the energy balance.
    Pass,
    /// The method is not applicable or exceeds the budget, the energy balance is too uncertain, or the requested accuracy is too low for
    /// it.
    Refused,
    /// The result is not finite or violates the energy balance.
    Fail,
}

impl CaseVerdict {
    /// Verdict as text.
    pub fn name(self) -> &'static str {
        match self {
            CaseVerdict::Pass => "pass",
            CaseVerdict::Refused => "refused",
            CaseVerdict::Fail => "fail",
        }
    }
}

/// Maximum relative energy-balance error including its uncertainty: a deviation visible in a plot.
pub const MAX_ENERGY_ERROR: f64 = 1e-3;

/// Default methods: one of every kind, in addition to the automatic choice.
const DEFAULT_METHODS: &[&str] = &[
    "radau5",
    "generalized-alpha-controlled",
    "dop853-events",
    "dopri5",
];

/// Default methods of the coarse-step case.
const FIXED_STEP_METHODS: &[&str] = &["rk4", "generalized-alpha", "newmark"];

/// Default number of steps of fixed-step methods.
const STEPS: f64 = 1e5;

/// Coarse-step case: name, and step as a share of the simulated time.
const COARSE_STEP: (&str, f64) = ("step a tenth of the time", 0.1);

/// Integration methods of a stress test.
pub struct CaseMethods {
    /// Methods of every perturbation.
    general: Vec<&'static IntegrationMethod>,
    /// Methods of the coarse-step case.
    fixed_step: Vec<&'static IntegrationMethod>,
    /// Methods not applicable to the machine, with the reason.
    pub unsupported: Vec<(&'static str, String)>,
}

impl CaseMethods {
    /// Named methods; by default the automatic choice and one of every kind.
    ///
    /// # Errors
    /// An unknown method.
    pub fn new(
        setup: &SimulationSetup,
        study: &SimulateStudy,
        names: &[String],
    ) -> Result<CaseMethods, Error> {
        let model = &setup.model.model;
        let rows = |names: &'static [&str]| METHODS.iter().filter(move |m| names.contains(&m.name));
        let (mut general, mut fixed_step): (Vec<_>, Vec<_>) = if names.is_empty() {
            let automatic = SimulateStudy {
                method: None,
                step: None,
                ..study.clone()
            };
            let first = choose_method(model, &automatic)?.method;
            let defaults = rows(DEFAULT_METHODS).filter(|m| m.name != first.name);
            let general = [first].into_iter().chain(defaults).collect();
            (general, rows(FIXED_STEP_METHODS).collect())
        } else {
            let named = find_methods(names)?;
            let fixed_step = named
                .iter()
                .copied()
                .filter(|m| m.step_control == StepControl::Fixed);
            (named.clone(), fixed_step.collect())
        };
        let mut unsupported: Vec<(&str, String)> = Vec::new();
        for method in general.iter().chain(&fixed_step) {
            if let Some(reason) = (method.unsupported_reason)(model)
                && unsupported.iter().all(|(name, _)| *name != method.name)
            {
                unsupported.push((method.name, reason));
            }
        }
        let applies = |m: &&IntegrationMethod| unsupported.iter().all(|(name, _)| *name != m.name);
        general.retain(applies);
        fixed_step.retain(applies);
        Ok(CaseMethods {
            general,
            fixed_step,
            unsupported,
        })
    }
}

/// Simulates a scene with every perturbation by every method; after a cancellation the completed cases are returned.
pub fn stress_test(
    setup: &SimulationSetup,
    study: &SimulateStudy,
    methods: &CaseMethods,
    monitor: &mut Monitor,
) -> Vec<StressCase> {
    let tolerance = study.tolerance.unwrap_or(DEFAULT_TOLERANCE);
    let step = study.step.unwrap_or(setup.end_time / STEPS);
    let unperturbed = PerturbedScene::new(setup, tolerance, step);
    let perturbations = CASES
        .iter()
        .filter(|c| no_effect_reason(c.0, setup).is_none());
    // Only fixed-step methods run with a coarse step.
    let coarse: (_, Perturbation) = (COARSE_STEP.0, |x| x.step = COARSE_STEP.1 * x.end_time);
    let runs = perturbations.flat_map(|change| methods.general.iter().map(move |m| (change, *m)));
    let coarse_runs = methods.fixed_step.iter().map(|m| (&coarse, *m));
    let cases: Vec<_> = runs.chain(coarse_runs).collect();
    let cancel = monitor.cancel;
    let monitor = Mutex::new(monitor);
    let completed = parallel::map(&cases, |&(&(name, change), method)| {
        let is_running = monitor
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .proceed(&format!("{name}: {}", method.name));
        if !is_running {
            return None;
        }
        let mut scene = unperturbed.clone();
        change(&mut scene);
        run_case(name, method, (&scene, setup.samples), cancel)
    });
    completed.into_iter().flatten().collect()
}

/// Runs one case by one method with `samples` samples; `None` after a cancellation.
pub fn run_case(
    name: &str,
    method: &'static IntegrationMethod,
    (scene, samples): (&PerturbedScene, usize),
    cancel: &CancelToken,
) -> Option<StressCase> {
    let case = |(verdict, energy_error, reason)| StressCase {
        name: name.to_string(),
        method: method.name,
        verdict,
        energy_error,
        reason,
    };
    let refused = |reason: String| Some(case((CaseVerdict::Refused, None, Some(reason))));
    let (model, prescribed) = match scene.integration_model() {
        Ok(model) => model,
        Err(error) => return refused(error_message(error)),
    };
    if let Some(reason) = (method.unsupported_reason)(&model) {
        return refused(reason);
    }
    let limit = BalanceLimit {
        evaluations: scene.budget,
        predicts: true,
        cancel: cancel.clone(),
    };
    let mut observer = Observer::default();
    let span = [0.0, scene.end_time];
    let energy = EnergyIntegrator::observe(&model, prescribed.as_ref(), span, limit, &mut observer);
    let options = IntegrationOptions {
        from: 0.0,
        to: scene.end_time,
        initial_state: scene.start.clone(),
        samples,
        step_size: match method.step_control {
            StepControl::Fixed => StepSize::Fixed(scene.step),
            _ => StepSize::Adaptive(scene.tolerance),
        },
        max_work: scene.budget,
        cancel: cancel.clone(),
        observer,
    };
    let mut is_finite = true;
    let outcome = (method.run)(&model, &options, &mut |_, y, _| {
        is_finite &= y.iter().all(|x| x.is_finite());
        ControlFlow::Continue(())
    });
    if cancel.is_cancelled() {
        return None;
    }
    match outcome {
        Err(error) => refused(error_message(error)),
        Ok(_) if !is_finite => {
            let message = "the result is not finite".to_string();
            Some(case((CaseVerdict::Fail, None, Some(message))))
        }
        Ok(effort) => {
            let balance = energy.borrow().balance();
            let requested = match method.step_control {
                StepControl::Exact => RequestedAccuracy::Exact,
                StepControl::Adaptive => {
                    RequestedAccuracy::Tolerance(scene.tolerance, effort.steps)
                }
                StepControl::Fixed => {
                    RequestedAccuracy::Step(scene.step, method.order.unwrap_or(1))
                }
            };
            Some(case(judge_balance(&balance, requested)))
        }
    }
}

fn error_message(error: Error) -> String {
    match error.code {
        Code::BudgetExceeded => error.message,
        code => format!("{} [{}]", error.message, code.as_str()),
    }
}

/// Requested accuracy of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RequestedAccuracy {
    /// To rounding.
    Exact,
    /// Tolerance of the local error, and number of steps.
    Tolerance(f64, u64),
    /// Fixed step, s, and order of the method.
    Step(f64, u32),
}

impl RequestedAccuracy {
    /// Maximum relative energy-balance error at the permitted local errors: twice their sum, as energy is quadratic.
    fn max_energy_error(self) -> f64 {
        match self {
            RequestedAccuracy::Exact => 0.0,
            RequestedAccuracy::Tolerance(tolerance, steps) => 2.0 * tolerance * steps as f64,
            RequestedAccuracy::Step(..) => f64::INFINITY,
        }
    }

    /// Message about a too coarse tolerance or step, with a sufficient one.
    fn coarse_step_message(self, gap: f64) -> String {
        let ratio = MAX_ENERGY_ERROR / gap;
        match self {
            RequestedAccuracy::Exact => String::new(),
            RequestedAccuracy::Tolerance(tolerance, steps) => format!(
                "too coarse: energy-balance error {gap:.0e}, consistent with an error of {tolerance:.0e} in each of {steps} steps; use a tolerance of about {:.0e}",
                tolerance * ratio
            ),
            RequestedAccuracy::Step(step, order) => format!(
                "the step is too long: energy-balance error {gap:.0e}; use steps of about {}",
                format_time(step * ratio.powf(1.0 / f64::from(order)))
            ),
        }
    }
}

/// Judges a completed run by its energy balance: verdict, relative error, reason.
pub fn judge_balance(
    balance: &EnergyBalance,
    options: RequestedAccuracy,
) -> (CaseVerdict, Option<f64>, Option<String>) {
    let gap = balance.relative_error().abs();
    let refused = |error, reason| (CaseVerdict::Refused, error, Some(reason));
    if let Some(share) = balance.stopped_at {
        let total = match share > 0.0 {
            true => format!("about {}", rounded(balance.evaluations as f64 / share)),
            false => "more than can be estimated".to_string(),
        };
        let message = format!(
            "its energy balance cannot be computed: {} evaluations of the powers covered {} % of the time; all would take {total}, which exceeds the budget",
            rounded(balance.evaluations as f64),
            percentage(share)
        );
        return refused(None, message);
    }
    let uncertainty = balance.error_bound().unwrap_or(f64::INFINITY);
    if gap + uncertainty <= MAX_ENERGY_ERROR {
        (CaseVerdict::Pass, Some(gap), None)
    } else if gap - uncertainty > MAX_ENERGY_ERROR.max(options.max_energy_error()) {
        let message = "the energy balance does not close".to_string();
        (CaseVerdict::Fail, Some(gap), Some(message))
    } else if gap - uncertainty > MAX_ENERGY_ERROR {
        refused(Some(gap), options.coarse_step_message(gap))
    } else {
        let message = format!(
            "its energy balance is not conclusive: it closes to {gap:.0e} with an uncertainty of {uncertainty:.0e}"
        );
        refused(Some(gap), message)
    }
}

/// Formats a share below one in per cent, rounded down.
fn percentage(share: f64) -> String {
    let per_cent = 100.0 * share;
    match per_cent {
        0.0 => "0".to_string(),
        c if c >= 1.0 => format!("{:.0}", c.floor()),
        c => format!("{c:.1e}"),
    }
}
