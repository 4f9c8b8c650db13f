//! Choice of the integration method for a dynamic model, with its reason.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_duration;
use crate::base::text::suggestion;
use crate::motion::diagnostics::rate_bound;
use crate::motion::dynamic_model::DynamicModel;
use crate::motion::methods::{self, IntegrationMethod, METHODS, MethodFamily, StepControl};
use crate::motion::problem::StepSize;
use crate::scene::study::SimulateStudy;

use super::dense_cost::DenseCost;
use super::structure::nonlinear_text;

/// Local error per step where a study names none.
pub const DEFAULT_TOLERANCE: f64 = 1e-8;

/// Integration method with its requested settings.
#[derive(Clone)]
pub struct MethodChoice {
    /// The method.
    pub method: &'static IntegrationMethod,
    /// Step size: tolerance or fixed step.
    pub step_size: StepSize,
    /// Why this one.
    pub reason: String,
    /// Exact method without steps that would apply here, where a step was requested.
    pub exact_alternative: Option<&'static str>,
}

/// The order in which methods are taken: exact ones first, then those that keep their order across events and stiffness.
const PREFERRED: &[&str] = &[
    "exact",
    "switched",
    "periodic",
    "radau5",
    "generalized-alpha",
    "dopri5",
];

/// Takes the place of [`FALLBACK_METHOD`] where its steps, bound by stability, are few: a step costs a tenth.
const EXPLICIT_METHOD: &str = "dop853-events";

/// Steps that are few at [`DEFAULT_TOLERANCE`]: some seconds for forty degrees of freedom.
const FEW_STEPS: f64 = 1e5;

/// Steps of an explicit method below which it costs less than [`FALLBACK_METHOD`], whose own steps go with `tolerance^(-1/5)`.
fn few_steps(tolerance: f64) -> f64 {
    FEW_STEPS * (DEFAULT_TOLERANCE / tolerance).powf(0.2)
}

/// `h ω` on the imaginary axis up to which Dormand and Prince's method of order 8 does not grow (Hairer, Nørsett & Wanner,
/// Solving Ordinary Differential Equations I, §II.5; what `stability` computes from its coefficients).
const STABILITY_LIMIT: f64 = 6.0;

/// Steps that keep the explicit method stable over a time, at most; nothing where a law has no greatest slope.
fn explicit_steps(model: &DynamicModel, until: f64) -> Option<f64> {
    let steps = until * rate_bound(model)? / STABILITY_LIMIT;
    steps.is_finite().then_some(steps)
}

/// Chooses a method for a machine.
///
/// # Errors
/// An unknown word; a method that cannot take the machine; a step for a method that chooses its own.
pub fn choose_method(model: &DynamicModel, study: &SimulateStudy) -> Result<MethodChoice, Error> {
    let (method, mut reason, usual) = match &study.method {
        Some(name) => (
            find_method(name)?,
            "requested".to_string(),
            DEFAULT_TOLERANCE,
        ),
        None => match explicit_alternative(model, study) {
            Some((method, reason)) => (method, reason, EXACT_TOLERANCE),
            None => {
                let (method, reason) = choose_automatically(model, study)?;
                (method, reason, DEFAULT_TOLERANCE)
            }
        },
    };
    if let Some(why) = (method.unsupported_reason)(model) {
        let able: Vec<&str> = METHODS
            .iter()
            .filter(|m| (m.unsupported_reason)(model).is_none())
            .map(|m| m.name)
            .collect();
        let message = format!("{} cannot take this machine: {why}", method.name);
        return Err(
            Error::new(Code::Conflict, message).with_hint(format!("{} can", able.join(", ")))
        );
    }
    let size = match (method.step_control, study.step, study.tolerance) {
        (StepControl::Fixed, Some(step), _) if study.end_time.is_some_and(|until| step > until) => {
            let message = format!(
                "a step of {} is longer than the motion",
                crate::base::quantity::format_time(step)
            );
            return Err(Error::new(Code::OutOfRange, message).with_hint(
                "take a small share of the shortest period; `stability` shows the limits",
            ));
        }
        (StepControl::Fixed, Some(step), _) => StepSize::Fixed(step),
        (StepControl::Fixed, None, _) => {
            let message = format!("{} goes by a fixed step, and none is given", method.name);
            return Err(Error::new(Code::Usage, message)
                .with_hint("add --step \"10 µs\", or take a method that chooses its steps"));
        }
        (_, Some(_), _) => {
            let message = format!("{} takes no fixed step", method.name);
            let fixed: Vec<&str> = METHODS
                .iter()
                .filter(|m| m.step_control == StepControl::Fixed)
                .map(|m| m.name)
                .collect();
            return Err(Error::new(Code::Usage, message)
                .with_hint(format!("fixed steps are for {}", fixed.join(", "))));
        }
        (_, None, tolerance) => StepSize::Adaptive(tolerance.unwrap_or(usual)),
    };
    let passed_over = match study.method {
        None if method.step_control == StepControl::Fixed => exact_method(model),
        _ => None,
    };
    if let Some(exact) = passed_over {
        reason += &format!(
            "; the method {exact} would have no error here, but takes no step, and one is requested"
        );
    }
    Ok(MethodChoice {
        method,
        step_size: size,
        reason,
        exact_alternative: passed_over,
    })
}

/// The method that is exact for a machine.
fn exact_method(model: &DynamicModel) -> Option<&'static str> {
    let able = |m: &&IntegrationMethod| {
        m.step_control == StepControl::Exact && (m.unsupported_reason)(model).is_none()
    };
    METHODS.iter().find(able).map(|m| m.name)
}

/// Takes over where the method that the structure suggests does not converge: it locates no switches, so that contacts which
/// chatter do not stop it.
const FALLBACK_METHOD: &str = "radau5";

/// Choice after one that failed with `error`; nothing where the method was requested, or no other applies to the machine.
pub fn fallback(
    model: &DynamicModel,
    study: &SimulateStudy,
    failed: &MethodChoice,
    error: &Error,
) -> Option<MethodChoice> {
    let method = methods::method_by_name(FALLBACK_METHOD)
        .filter(|m| (m.unsupported_reason)(model).is_none())?;
    let asked = study.method.is_some() || study.step.is_some();
    if asked || method.name == failed.method.name || error.code != Code::NoConvergence {
        return None;
    }
    Some(MethodChoice {
        method,
        step_size: StepSize::Adaptive(study.tolerance.unwrap_or(DEFAULT_TOLERANCE)),
        reason: format!("{} did not converge", failed.method.name),
        exact_alternative: None,
    })
}

/// The method of a word.
///
/// # Errors
/// No such word, with the nearest.
pub fn find_method(name: &str) -> Result<&'static IntegrationMethod, Error> {
    methods::method_by_name(name).ok_or_else(|| {
        let error = Error::new(Code::OutOfRange, format!("there is no method `{name}`"));
        let words: Vec<&str> = METHODS.iter().map(|m| m.name).collect();
        match suggestion(name, words.iter().copied()) {
            Some(near) => error.with_hint(format!("did you mean `{near}`?")),
            None => error.with_hint(format!("the methods are {}", words.join(", "))),
        }
    })
}

/// The methods of words, each once however often it is named.
///
/// # Errors
/// Those of [`find_method`].
pub fn find_methods(names: &[String]) -> Result<Vec<&'static IntegrationMethod>, Error> {
    let mut all: Vec<&'static IntegrationMethod> = Vec::new();
    for name in names {
        let method = find_method(name)?;
        if all.iter().all(|known| known.name != method.name) {
            all.push(method);
        }
    }
    Ok(all)
}

/// The first method that takes a machine, and goes by the step where one is given.
fn first_applicable(
    model: &DynamicModel,
    study: &SimulateStudy,
) -> Option<&'static IntegrationMethod> {
    let able = |name: &&&str| {
        methods::method_by_name(name).is_some_and(|m| {
            (m.unsupported_reason)(model).is_none()
                && (study.step.is_none() || m.step_control == StepControl::Fixed)
        })
    };
    PREFERRED
        .iter()
        .chain(&METHODS.iter().map(|m| m.name).collect::<Vec<_>>()[..])
        .find(able)
        .copied()
        .and_then(methods::method_by_name)
}

fn choose_automatically(
    model: &DynamicModel,
    study: &SimulateStudy,
) -> Result<(&'static IntegrationMethod, String), Error> {
    let Some(method) = first_applicable(model, study) else {
        let why: Vec<String> = METHODS
            .iter()
            .filter_map(|m| (m.unsupported_reason)(model).map(|why| format!("{}: {why}", m.name)))
            .collect();
        return Err(
            Error::new(Code::BudgetExceeded, "no method takes this machine")
                .with_hint(why.join("; ")),
        );
    };
    if method.name != FALLBACK_METHOD {
        return Ok((method, structural_reason(method)));
    }
    let tolerance = study.tolerance.unwrap_or(DEFAULT_TOLERANCE);
    let few = few_steps(tolerance);
    let explicit = methods::method_by_name(EXPLICIT_METHOD)
        .filter(|m| (m.unsupported_reason)(model).is_none());
    let steps = study
        .end_time
        .and_then(|until| explicit_steps(model, until));
    let (taken, cost) = match (explicit, steps) {
        (Some(explicit), Some(steps)) if steps < few => (
            explicit,
            format!(
                "not stiff: at most {steps:.0} steps keep it stable, and beyond {few:.0} `{FALLBACK_METHOD}` would cost less at a tolerance of {tolerance:.0e}"
            ),
        ),
        (Some(explicit), Some(steps)) => (
            method,
            format!(
                "stiff: `{}` may need {steps:.1e} steps to stay stable, and beyond {few:.0} this one costs less at a tolerance of {tolerance:.0e}",
                explicit.name
            ),
        ),
        (Some(explicit), None) => (
            method,
            format!(
                "the number of steps of `{}` cannot be predicted",
                explicit.name
            ),
        ),
        (None, _) => (
            method,
            "its nodes without inertia leave equations that explicit methods do not take"
                .to_string(),
        ),
    };
    Ok((taken, format!("{}; {cost}", nonlinear_text(model))))
}

/// Time, s, that all modes of a machine may take before the cost of steps is compared: an exact solution is worth a short wait.
const MAX_MODAL_SECONDS: f64 = 10.0;

/// Default tolerance of the local error of steps in place of an exact method: of 500 discs an error of 5e-9 in a second.
const EXACT_TOLERANCE: f64 = 1e-11;

/// Seconds of a step of [`EXPLICIT_METHOD`] by coordinate: 2000 discs took 671 steps in 0.83 s, 20 000 took 597 in 9.5 s.
const SECONDS_PER_STEP: f64 = 8e-7;

/// So many times the steps that keep the method stable give that error: 1679 for 333 on these discs.
const STEPS_FOR_EXACT: f64 = 5.0;

/// The explicit method where the machine's own would need all modes of many coordinates, and steps take less.
fn explicit_alternative(
    model: &DynamicModel,
    study: &SimulateStudy,
) -> Option<(&'static IntegrationMethod, String)> {
    let method =
        first_applicable(model, study).filter(|m| m.family == MethodFamily::Propagation)?;
    let modes = DenseCost::for_method(method, model.coordinate_count())?;
    let explicit = methods::method_by_name(EXPLICIT_METHOD)
        .filter(|m| (m.unsupported_reason)(model).is_none())?;
    let steps = explicit_steps(model, study.end_time?)?;
    let seconds = STEPS_FOR_EXACT * steps * SECONDS_PER_STEP * model.coordinate_count() as f64;
    (modes.seconds > MAX_MODAL_SECONDS && seconds < modes.seconds).then(|| {
        let reason = format!(
            "{}, which `{}` needs; at most {steps:.0} steps keep this one stable, about {} at a tolerance of {EXACT_TOLERANCE:.0e}",
            modes.text(),
            method.name,
            format_duration(seconds)
        );
        (explicit, reason)
    })
}

/// Why a method that the structure asks for is right.
fn structural_reason(method: &IntegrationMethod) -> String {
    match method.name {
        "exact" => "linear and time-invariant, so exact at every instant for any target error".to_string(),
        "switched" => "linear between switches, so exact up to each, and each is located; exact for any target error".to_string(),
        "periodic" => "stiffness and loads repeat in time, so that one period is tabulated and combined; exact for any target error".to_string(),
        _ => format!("a step is given, and {} goes by one", method.title),
    }
}
