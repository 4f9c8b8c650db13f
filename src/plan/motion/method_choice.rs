//! Selection of the integration method for a dynamic model, with the reason.

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

/// Default tolerance of the local error per step.
pub const DEFAULT_TOLERANCE: f64 = 1e-8;

/// Integration method with its requested settings.
#[derive(Clone)]
pub struct MethodChoice {
    /// The method.
    pub method: &'static IntegrationMethod,
    /// Tolerance or fixed step size.
    pub step_size: StepSize,
    /// Reason for the choice.
    pub reason: String,
    /// Exact method that would apply without the requested step.
    pub exact_alternative: Option<&'static str>,
}

/// Methods in order of preference: exact methods first, then those that keep their order across events and for stiff models.
const PREFERRED: &[&str] = &[
    "exact",
    "switched",
    "periodic",
    "radau5",
    "generalized-alpha",
    "dopri5",
];

/// Explicit method in place of [`FALLBACK_METHOD`] if stability needs few steps: one of its steps costs a tenth.
const EXPLICIT_METHOD: &str = "dop853-events";

/// Maximum number of explicit steps at [`DEFAULT_TOLERANCE`]: some seconds for forty degrees of freedom.
const MAX_EXPLICIT_STEPS: f64 = 1e5;

/// Number of explicit steps below which they cost less than [`FALLBACK_METHOD`], whose step count is proportional to `tolerance^(-1/5)`.
fn max_explicit_steps(tolerance: f64) -> f64 {
    MAX_EXPLICIT_STEPS * (DEFAULT_TOLERANCE / tolerance).powf(0.2)
}

/// Stability limit `h ω` on the imaginary axis of the Dormand–Prince method of order 8 (Hairer, Nørsett & Wanner,
/// Solving Ordinary Differential Equations I, §II.5; `stability` computes it from the coefficients).
const STABILITY_LIMIT: f64 = 6.0;

/// Upper bound of the number of stable explicit steps up to `until`, s; `None` if a force law has no maximum slope.
fn explicit_steps(model: &DynamicModel, until: f64) -> Option<f64> {
    let steps = until * rate_bound(model)? / STABILITY_LIMIT;
    steps.is_finite().then_some(steps)
}

/// Chooses the integration method for a model.
///
/// # Errors
/// An unknown method; a method that does not support the model; a fixed step for a method with step control.
pub fn choose_method(model: &DynamicModel, study: &SimulateStudy) -> Result<MethodChoice, Error> {
    let (method, mut reason, default_tolerance) = match &study.method {
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
    if let Some(unsupported) = (method.unsupported_reason)(model) {
        let supported: Vec<&str> = METHODS
            .iter()
            .filter(|m| (m.unsupported_reason)(model).is_none())
            .map(|m| m.name)
            .collect();
        let message = format!("{} cannot take this machine: {unsupported}", method.name);
        return Err(
            Error::new(Code::Conflict, message).with_hint(format!("{} can", supported.join(", ")))
        );
    }
    let step_size = match (method.step_control, study.step, study.tolerance) {
        (StepControl::Fixed, Some(step), _) if study.end_time.is_some_and(|until| step > until) => {
            let message = format!(
                "a step of {} exceeds the duration",
                crate::base::quantity::format_time(step)
            );
            return Err(Error::new(Code::OutOfRange, message).with_hint(
                "use a small fraction of the shortest period; `stability` shows the limits",
            ));
        }
        (StepControl::Fixed, Some(step), _) => StepSize::Fixed(step),
        (StepControl::Fixed, None, _) => {
            let message = format!("{} needs a fixed step, and none is given", method.name);
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
                .with_hint(format!("take a step only: {}", fixed.join(", "))));
        }
        (_, None, tolerance) => StepSize::Adaptive(tolerance.unwrap_or(default_tolerance)),
    };
    let exact_alternative = match study.method {
        None if method.step_control == StepControl::Fixed => exact_method(model),
        _ => None,
    };
    if let Some(exact) = exact_alternative {
        reason +=
            &format!("; the method {exact} is exact here but has no step, and one is requested");
    }
    Ok(MethodChoice {
        method,
        step_size,
        reason,
        exact_alternative,
    })
}

/// Name of an exact method that supports a model.
fn exact_method(model: &DynamicModel) -> Option<&'static str> {
    let is_applicable = |m: &&IntegrationMethod| {
        m.step_control == StepControl::Exact && (m.unsupported_reason)(model).is_none()
    };
    METHODS.iter().find(is_applicable).map(|m| m.name)
}

/// Method after one that did not converge; it does not locate switching events, hence contact chatter does not stop it.
const FALLBACK_METHOD: &str = "radau5";

/// Choice after `failed` ended with `error`; `None` if the method or a step was requested, or if no other method applies.
pub fn fallback(
    model: &DynamicModel,
    study: &SimulateStudy,
    failed: &MethodChoice,
    error: &Error,
) -> Option<MethodChoice> {
    let method = methods::method_by_name(FALLBACK_METHOD)
        .filter(|m| (m.unsupported_reason)(model).is_none())?;
    let is_requested = study.method.is_some() || study.step.is_some();
    if is_requested || method.name == failed.method.name || error.code != Code::NoConvergence {
        return None;
    }
    Some(MethodChoice {
        method,
        step_size: StepSize::Adaptive(study.tolerance.unwrap_or(DEFAULT_TOLERANCE)),
        reason: format!("{} did not converge", failed.method.name),
        exact_alternative: None,
    })
}

/// Method by name.
///
/// # Errors
/// An unknown name, with the nearest known one.
pub fn find_method(name: &str) -> Result<&'static IntegrationMethod, Error> {
    methods::method_by_name(name).ok_or_else(|| {
        let error = Error::new(Code::OutOfRange, format!("there is no method `{name}`"));
        let names: Vec<&str> = METHODS.iter().map(|m| m.name).collect();
        match suggestion(name, names.iter().copied()) {
            Some(nearest) => error.with_hint(format!("did you mean `{nearest}`?")),
            None => error.with_hint(format!("the methods are {}", names.join(", "))),
        }
    })
}

/// Methods by name, without duplicates.
///
/// # Errors
/// Those of [`find_method`].
pub fn find_methods(names: &[String]) -> Result<Vec<&'static IntegrationMethod>, Error> {
    let mut selected: Vec<&'static IntegrationMethod> = Vec::new();
    for name in names {
        let method = find_method(name)?;
        if selected.iter().all(|known| known.name != method.name) {
            selected.push(method);
        }
    }
    Ok(selected)
}

/// First method that supports a model, and a fixed step if one is requested.
fn first_applicable(
    model: &DynamicModel,
    study: &SimulateStudy,
) -> Option<&'static IntegrationMethod> {
    let is_applicable = |name: &&&str| {
        methods::method_by_name(name).is_some_and(|m| {
            (m.unsupported_reason)(model).is_none()
                && (study.step.is_none() || m.step_control == StepControl::Fixed)
        })
    };
    PREFERRED
        .iter()
        .chain(&METHODS.iter().map(|m| m.name).collect::<Vec<_>>()[..])
        .find(is_applicable)
        .copied()
        .and_then(methods::method_by_name)
}

fn choose_automatically(
    model: &DynamicModel,
    study: &SimulateStudy,
) -> Result<(&'static IntegrationMethod, String), Error> {
    let Some(method) = first_applicable(model, study) else {
        let reasons: Vec<String> = METHODS
            .iter()
            .filter_map(|m| (m.unsupported_reason)(model).map(|text| format!("{}: {text}", m.name)))
            .collect();
        return Err(
            Error::new(Code::BudgetExceeded, "no method takes this machine")
                .with_hint(reasons.join("; ")),
        );
    };
    if method.name != FALLBACK_METHOD {
        return Ok((method, structural_reason(method)));
    }
    let tolerance = study.tolerance.unwrap_or(DEFAULT_TOLERANCE);
    let limit = max_explicit_steps(tolerance);
    let explicit = methods::method_by_name(EXPLICIT_METHOD)
        .filter(|m| (m.unsupported_reason)(model).is_none());
    let steps = study
        .end_time
        .and_then(|until| explicit_steps(model, until));
    let (chosen, cost) = match (explicit, steps) {
        (Some(explicit), Some(steps)) if steps < limit => (
            explicit,
            format!(
                "not stiff: at most {steps:.0} steps keep it stable, and above {limit:.0} `{FALLBACK_METHOD}` costs less at a tolerance of {tolerance:.0e}"
            ),
        ),
        (Some(explicit), Some(steps)) => (
            method,
            format!(
                "stiff: `{}` may need {steps:.1e} steps to stay stable, and above {limit:.0} this one costs less at a tolerance of {tolerance:.0e}",
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
            "its nodes without inertia give equations that explicit methods cannot solve"
                .to_string(),
        ),
    };
    Ok((chosen, format!("{}; {cost}", nonlinear_text(model))))
}

/// Time for all modes of a model, s, up to which the exact solution is chosen without comparing the cost of steps.
const MAX_MODAL_SECONDS: f64 = 10.0;

/// Default tolerance of the local error of a method that replaces an exact one; 500 discs have an error of 5e-9 after 1 s.
const EXACT_TOLERANCE: f64 = 1e-11;

/// Time of a step of [`EXPLICIT_METHOD`] per coordinate, s: 2000 discs took 671 steps in 0.83 s, 20 000 took 597 in 9.5 s.
const SECONDS_PER_STEP: f64 = 8e-7;

/// Steps at [`EXACT_TOLERANCE`] relative to those for stability: 1679 against 333 for these discs.
const STEPS_FOR_EXACT: f64 = 5.0;

/// Explicit method if the applicable one needs all modes of many coordinates and explicit steps cost less.
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

/// Reason for a method chosen by the structure of the model.
fn structural_reason(method: &IntegrationMethod) -> String {
    match method.name {
        "exact" => "linear and time-invariant, so exact at every instant for any target error".to_string(),
        "switched" => "linear between switches, which are located; exact for any target error".to_string(),
        "periodic" => "periodic stiffness and loads, so that one period is tabulated; exact for any target error".to_string(),
        _ => format!("a step is given, and {} has a fixed step", method.title),
    }
}
