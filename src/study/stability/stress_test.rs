//! Stress test: the scene rerun with extreme parameters, checked by its energy balance.

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

/// One rerun of the scene.
pub struct StressCase {
    /// Name of the change.
    pub name: String,
    /// By which method.
    pub method: &'static str,
    /// Verdict on the case.
    pub verdict: CaseVerdict,
    /// Energy-balance error, as a share of the largest part of the balance.
    pub energy_error: Option<f64>,
    /// Why it was refused or failed.
    pub reason: Option<String>,
}

/// Verdict on a rerun.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CaseVerdict {
    /// The result is finite and satisfies the energy balance.
    Pass,
    /// The method reported that it cannot, or at what cost; its energy balance was too uncertain; or the request is too coarse to satisfy
    /// it.
    Refused,
    /// The method returned an impossible result.
    Fail,
}

impl CaseVerdict {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            CaseVerdict::Pass => "pass",
            CaseVerdict::Refused => "refused",
            CaseVerdict::Fail => "fail",
        }
    }
}

/// Largest energy-balance error, its uncertainty included: the share a user would see in a plot.
pub const MAX_ENERGY_ERROR: f64 = 1e-3;

/// Methods taken where none is named: what a plan would choose, and one of every kind.
const DEFAULT_METHODS: &[&str] = &[
    "radau5",
    "generalized-alpha-controlled",
    "dop853-events",
    "dopri5",
];

/// Methods given a step far too large where none is named.
const FIXED_STEP_METHODS: &[&str] = &["rk4", "generalized-alpha", "newmark"];

/// Steps of methods that go by one, where the study names no step.
const STEPS: f64 = 1e5;

/// The case of a step far too large, and its share of the time.
const COARSE_STEP: (&str, f64) = ("step a tenth of the time", 0.1);

/// The methods a scene is rerun by.
pub struct CaseMethods {
    /// In every case.
    every: Vec<&'static IntegrationMethod>,
    /// Those given too large a step as well.
    fixed_step: Vec<&'static IntegrationMethod>,
    /// Those that cannot take the machine, and why.
    pub unsupported: Vec<(&'static str, String)>,
}

impl CaseMethods {
    /// Those named; where none is, what a plan would choose and one of every kind.
    ///
    /// # Errors
    /// An unknown method.
    pub fn new(
        setup: &SimulationSetup,
        study: &SimulateStudy,
        names: &[String],
    ) -> Result<CaseMethods, Error> {
        let model = &setup.model.model;
        let of = |names: &'static [&str]| METHODS.iter().filter(move |m| names.contains(&m.name));
        let (mut every, mut stepped): (Vec<_>, Vec<_>) = if names.is_empty() {
            let free = SimulateStudy {
                method: None,
                step: None,
                ..study.clone()
            };
            let first = choose_method(model, &free)?.method;
            let others = of(DEFAULT_METHODS).filter(|m| m.name != first.name);
            let every = [first].into_iter().chain(others).collect();
            (every, of(FIXED_STEP_METHODS).collect())
        } else {
            let all = find_methods(names)?;
            let stepped = all
                .iter()
                .copied()
                .filter(|m| m.step_control == StepControl::Fixed);
            (all.clone(), stepped.collect())
        };
        let mut left_out: Vec<(&str, String)> = Vec::new();
        for method in every.iter().chain(&stepped) {
            if let Some(why) = (method.unsupported_reason)(model)
                && left_out.iter().all(|(name, _)| *name != method.name)
            {
                left_out.push((method.name, why));
            }
        }
        let able = |m: &&IntegrationMethod| left_out.iter().all(|(name, _)| *name != m.name);
        every.retain(able);
        stepped.retain(able);
        Ok(CaseMethods {
            every,
            fixed_step: stepped,
            unsupported: left_out,
        })
    }
}

/// Reruns a scene at its extremes. Ended early, it gives the cases that were finished.
pub fn stress_test(
    setup: &SimulationSetup,
    study: &SimulateStudy,
    methods: &CaseMethods,
    monitor: &mut Monitor,
) -> Vec<StressCase> {
    let tolerance = study.tolerance.unwrap_or(DEFAULT_TOLERANCE);
    let step = study.step.unwrap_or(setup.end_time / STEPS);
    let as_it_is = PerturbedScene::new(setup, tolerance, step);
    let changes = CASES
        .iter()
        .filter(|c| no_effect_reason(c.0, setup).is_none());
    // A step far too large is for those that take what they are given.
    let coarse: (_, Perturbation) = (COARSE_STEP.0, |x| x.step = COARSE_STEP.1 * x.end_time);
    let every = changes.flat_map(|change| methods.every.iter().map(move |m| (change, *m)));
    let stepped = methods.fixed_step.iter().map(|m| (&coarse, *m));
    let cases: Vec<_> = every.chain(stepped).collect();
    let cancel = monitor.cancel;
    let monitor = Mutex::new(monitor);
    let finished = parallel::map(&cases, |&(&(name, change), method)| {
        let proceeds = monitor
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .proceed(&format!("{name}: {}", method.name));
        if !proceeds {
            return None;
        }
        let mut extreme = as_it_is.clone();
        change(&mut extreme);
        run_case(name, method, (&extreme, setup.samples), cancel)
    });
    finished.into_iter().flatten().collect()
}

/// One case by one method, with so many samples; nothing where it was ended.
pub fn run_case(
    name: &str,
    method: &'static IntegrationMethod,
    (extreme, samples): (&PerturbedScene, usize),
    cancel: &CancelToken,
) -> Option<StressCase> {
    let case = |(verdict, figure, reason)| StressCase {
        name: name.to_string(),
        method: method.name,
        verdict,
        energy_error: figure,
        reason,
    };
    let refused = |why: String| Some(case((CaseVerdict::Refused, None, Some(why))));
    let (model, known) = match extreme.integration_model() {
        Ok(moving) => moving,
        Err(error) => return refused(error_message(error)),
    };
    if let Some(why) = (method.unsupported_reason)(&model) {
        return refused(why);
    }
    let limit = BalanceLimit {
        evaluations: extreme.budget,
        predicts: true,
        cancel: cancel.clone(),
    };
    let mut observer = Observer::default();
    let run = [0.0, extreme.end_time];
    let meter = EnergyIntegrator::observe(&model, known.as_ref(), run, limit, &mut observer);
    let options = IntegrationOptions {
        from: 0.0,
        to: extreme.end_time,
        initial_state: extreme.start.clone(),
        samples,
        step_size: match method.step_control {
            StepControl::Fixed => StepSize::Fixed(extreme.step),
            _ => StepSize::Adaptive(extreme.tolerance),
        },
        max_work: extreme.budget,
        cancel: cancel.clone(),
        observer,
    };
    let mut finite = true;
    let ran = (method.run)(&model, &options, &mut |_, y, _| {
        finite &= y.iter().all(|x| x.is_finite());
        ControlFlow::Continue(())
    });
    if cancel.is_cancelled() {
        return None;
    }
    match ran {
        Err(error) => refused(error_message(error)),
        Ok(_) if !finite => {
            let words = "the result is not finite".to_string();
            Some(case((CaseVerdict::Fail, None, Some(words))))
        }
        Ok(effort) => {
            let balance = meter.borrow().balance();
            let asked = match method.step_control {
                StepControl::Exact => RequestedAccuracy::Exact,
                StepControl::Adaptive => {
                    RequestedAccuracy::Tolerance(extreme.tolerance, effort.steps)
                }
                StepControl::Fixed => {
                    RequestedAccuracy::Step(extreme.step, method.order.unwrap_or(1))
                }
            };
            Some(case(judge_balance(&balance, asked)))
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
    /// By a tolerance of each step's error, and the steps it took.
    Tolerance(f64, u64),
    /// By a step, s, whatever comes of it; and the order of the method.
    Step(f64, u32),
}

impl RequestedAccuracy {
    /// Largest energy-balance error where every step errs as far as it may: twice the errors, energy being of their square.
    fn max_energy_error(self) -> f64 {
        match self {
            RequestedAccuracy::Exact => 0.0,
            RequestedAccuracy::Tolerance(tolerance, steps) => 2.0 * tolerance * steps as f64,
            RequestedAccuracy::Step(..) => f64::INFINITY,
        }
    }

    /// Why so much of the energy is missing, and what would hold it.
    fn coarse_step_message(self, gap: f64) -> String {
        let less = MAX_ENERGY_ERROR / gap;
        match self {
            RequestedAccuracy::Exact => String::new(),
            RequestedAccuracy::Tolerance(tolerance, steps) => format!(
                "too coarse: {gap:.0e} of the energy is missing, which an error of {tolerance:.0e} in each of {steps} steps allows; a tolerance of about {:.0e} would hold it",
                tolerance * less
            ),
            RequestedAccuracy::Step(step, order) => format!(
                "the step is too long: {gap:.0e} of the energy is missing; steps of about {} would hold it",
                format_time(step * less.powf(1.0 / f64::from(order)))
            ),
        }
    }
}

/// Judges a completed run by its energy balance: verdict, figure, reason.
pub fn judge_balance(
    balance: &EnergyBalance,
    options: RequestedAccuracy,
) -> (CaseVerdict, Option<f64>, Option<String>) {
    let gap = balance.relative_error().abs();
    let refused = |figure, why| (CaseVerdict::Refused, figure, Some(why));
    if let Some(share) = balance.stopped_at {
        let whole = match share > 0.0 {
            true => format!("about {}", rounded(balance.evaluations as f64 / share)),
            false => "more than can be estimated".to_string(),
        };
        let words = format!(
            "its energy balance cannot be computed: {} evaluations of the powers covered {} % of the time; all would take {whole}, which exceeds the budget",
            rounded(balance.evaluations as f64),
            brief_share(share)
        );
        return refused(None, words);
    }
    let doubt = balance.error_bound().unwrap_or(f64::INFINITY);
    if gap + doubt <= MAX_ENERGY_ERROR {
        (CaseVerdict::Pass, Some(gap), None)
    } else if gap - doubt > MAX_ENERGY_ERROR.max(options.max_energy_error()) {
        let words = "the energy does not add up".to_string();
        (CaseVerdict::Fail, Some(gap), Some(words))
    } else if gap - doubt > MAX_ENERGY_ERROR {
        refused(Some(gap), options.coarse_step_message(gap))
    } else {
        let words = format!(
            "its energy balance is not conclusive: it closes to {gap:.0e} with an uncertainty of {doubt:.0e}"
        );
        refused(Some(gap), words)
    }
}

/// A share in per cent, never rounded to all of it.
fn brief_share(share: f64) -> String {
    let cent = 100.0 * share;
    match cent {
        0.0 => "0".to_string(),
        c if c >= 1.0 => format!("{:.0}", c.floor()),
        c => format!("{c:.1e}"),
    }
}
