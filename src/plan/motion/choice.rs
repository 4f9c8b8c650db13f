//! Which method integrates a machine, and why.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::units::duration;
use crate::base::words::suggestion;
use crate::motion::methods::{self, Kin, Ladder, METHODS, Method};
use crate::motion::problem::Wanted;
use crate::motion::train::{Law, Train};
use crate::scene::study::SimulateStudy;

use super::dense::Dense;
use super::structure::curved;

/// Local error per step where a study names none.
pub const TOLERANCE: f64 = 1e-8;

/// A method with what is asked of it.
#[derive(Clone)]
pub struct Choice {
    /// The method.
    pub method: &'static Method,
    /// How exact, or how fine.
    pub wanted: Wanted,
    /// Why this one.
    pub reason: String,
    /// The method that would be exact here, and takes no step: one was asked for.
    pub passed_over: Option<&'static str>,
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

/// Takes the place of [`STURDY`] where its steps, bound by stability, are few: a step costs a tenth.
const EXPLICIT: &str = "dop853-events";

/// Steps that are few at [`TOLERANCE`]: some seconds for forty freedoms.
const FEW_STEPS: f64 = 1e5;

/// Steps of an explicit method below which it costs less than [`STURDY`], whose own steps go with `tolerance^(-1/5)`.
fn few_steps(tolerance: f64) -> f64 {
    FEW_STEPS * (TOLERANCE / tolerance).powf(0.2)
}

/// `h ω` on the imaginary axis up to which Dormand and Prince's method of order 8 does not grow (Hairer, Nørsett & Wanner,
/// Solving Ordinary Differential Equations I, §II.5; what `stability` computes from its coefficients).
const REACH: f64 = 6.0;

/// Steps that keep the explicit method stable over a time, at most; nothing where a law has no greatest slope.
fn explicit_steps(train: &Train, until: f64) -> Option<f64> {
    let mut stiffness = vec![0.0; train.n()];
    let mut damping = vec![0.0; train.n()];
    let mut inner = 0.0f64;
    for branch in &train.branches {
        let factor = branch.greatest_factor();
        let (k, c) = match &branch.law {
            Law::Linear { stiffness, damping } => (*stiffness, *damping),
            Law::Contact(contact) => (contact.stiffness, contact.damping),
            Law::Maxwell { stiffness, damping } => {
                inner = inner.max(stiffness / damping);
                (*stiffness, 0.0)
            }
            // What sticks is held, and what slides has the slope of its law alone.
            Law::Friction(_) | Law::Orders { .. } => (0.0, 0.0),
            Law::Lagged { lag, .. } => {
                inner = inner.max(1.0 / lag);
                (0.0, 0.0)
            }
            _ => return None,
        };
        // Row sums of M^-½ K M^-½ bound its largest eigenvalue (Gershgorin).
        let root = |i: usize| train.mass.at(i, i).sqrt();
        let sum: f64 = branch
            .direction
            .scaled()
            .map(|(i, a)| a.abs() / root(i))
            .sum();
        for (i, a) in branch.direction.scaled() {
            let share = a.abs() / root(i) * sum;
            stiffness[i] += (k * factor).abs() * share;
            damping[i] += (c * factor).abs() * share;
        }
    }
    let largest = |all: &[f64]| all.iter().copied().fold(0.0, f64::max);
    let fastest = largest(&stiffness).sqrt() + largest(&damping) + inner;
    let steps = until * fastest / REACH;
    steps.is_finite().then_some(steps)
}

/// Chooses a method for a machine.
///
/// # Errors
/// An unknown word; a method that cannot take the machine; a step for a method that chooses its own.
pub fn choose(train: &Train, study: &SimulateStudy) -> Result<Choice, Error> {
    let (method, mut reason, usual) = match &study.method {
        Some(name) => (named(name)?, "asked for".to_string(), TOLERANCE),
        None => match instead_of_modes(train, study) {
            Some((method, reason)) => (method, reason, TIGHT),
            None => {
                let (method, reason) = automatic(train, study)?;
                (method, reason, TOLERANCE)
            }
        },
    };
    if let Some(why) = (method.refuses)(train) {
        let able: Vec<&str> = METHODS
            .iter()
            .filter(|m| (m.refuses)(train).is_none())
            .map(|m| m.name)
            .collect();
        let message = format!("{} cannot take this machine: {why}", method.name);
        return Err(Error::new(Code::Conflict, message).hint(format!("{} can", able.join(", "))));
    }
    let wanted = match (method.ladder, study.step, study.tolerance) {
        (Ladder::Step, Some(step), _) if study.until.is_some_and(|until| step > until) => {
            let message = format!(
                "a step of {} is longer than the motion",
                crate::base::units::seconds(step)
            );
            return Err(Error::new(Code::OutOfRange, message)
                .hint("take a small share of the shortest period; `stability` shows the limits"));
        }
        (Ladder::Step, Some(step), _) => Wanted::Step(step),
        (Ladder::Step, None, _) => {
            let message = format!("{} goes by a fixed step, and none is given", method.name);
            return Err(Error::new(Code::Usage, message)
                .hint("add --step \"10 µs\", or take a method that chooses its steps"));
        }
        (_, Some(_), _) => {
            let message = format!("{} takes no fixed step", method.name);
            let fixed: Vec<&str> = METHODS
                .iter()
                .filter(|m| m.ladder == Ladder::Step)
                .map(|m| m.name)
                .collect();
            return Err(Error::new(Code::Usage, message)
                .hint(format!("fixed steps are for {}", fixed.join(", "))));
        }
        (_, None, tolerance) => Wanted::Tolerance(tolerance.unwrap_or(usual)),
    };
    let passed_over = match study.method {
        None if method.ladder == Ladder::Step => exact(train),
        _ => None,
    };
    if let Some(exact) = passed_over {
        reason += &format!(
            "; the method {exact} would have no error here, but takes no step, and one is asked for"
        );
    }
    Ok(Choice {
        method,
        wanted,
        reason,
        passed_over,
    })
}

/// The method that is exact for a machine.
fn exact(train: &Train) -> Option<&'static str> {
    let able = |m: &&Method| m.ladder == Ladder::Exact && (m.refuses)(train).is_none();
    METHODS.iter().find(able).map(|m| m.name)
}

/// Takes over where the method that the structure suggests does not converge: it locates no switches, so that contacts which
/// chatter do not stop it.
const STURDY: &str = "radau5";

/// The choice after one that failed with `error`; nothing where the method was asked for, or no other takes the machine.
pub fn successor(
    train: &Train,
    study: &SimulateStudy,
    failed: &Choice,
    error: &Error,
) -> Option<Choice> {
    let method = methods::find(STURDY).filter(|m| (m.refuses)(train).is_none())?;
    let asked = study.method.is_some() || study.step.is_some();
    if asked || method.name == failed.method.name || error.code != Code::NoConvergence {
        return None;
    }
    Some(Choice {
        method,
        wanted: Wanted::Tolerance(study.tolerance.unwrap_or(TOLERANCE)),
        reason: format!("{} did not converge", failed.method.name),
        passed_over: None,
    })
}

/// The method of a word.
///
/// # Errors
/// No such word, with the nearest.
pub fn named(name: &str) -> Result<&'static Method, Error> {
    methods::find(name).ok_or_else(|| {
        let error = Error::new(Code::OutOfRange, format!("there is no method `{name}`"));
        let words: Vec<&str> = METHODS.iter().map(|m| m.name).collect();
        match suggestion(name, words.iter().copied()) {
            Some(near) => error.hint(format!("did you mean `{near}`?")),
            None => error.hint(format!("the methods are {}", words.join(", "))),
        }
    })
}

/// The methods of words, each once however often it is named.
///
/// # Errors
/// Those of [`named`].
pub fn each_named(names: &[String]) -> Result<Vec<&'static Method>, Error> {
    let mut all: Vec<&'static Method> = Vec::new();
    for name in names {
        let method = named(name)?;
        if all.iter().all(|known| known.name != method.name) {
            all.push(method);
        }
    }
    Ok(all)
}

/// The first method that takes a machine, and goes by the step where one is given.
fn first(train: &Train, study: &SimulateStudy) -> Option<&'static Method> {
    let able = |name: &&&str| {
        methods::find(name).is_some_and(|m| {
            (m.refuses)(train).is_none() && (study.step.is_none() || m.ladder == Ladder::Step)
        })
    };
    PREFERRED
        .iter()
        .chain(&METHODS.iter().map(|m| m.name).collect::<Vec<_>>()[..])
        .find(able)
        .copied()
        .and_then(methods::find)
}

fn automatic(train: &Train, study: &SimulateStudy) -> Result<(&'static Method, String), Error> {
    let Some(method) = first(train, study) else {
        let why: Vec<String> = METHODS
            .iter()
            .filter_map(|m| (m.refuses)(train).map(|why| format!("{}: {why}", m.name)))
            .collect();
        return Err(Error::new(Code::Hopeless, "no method takes this machine").hint(why.join("; ")));
    };
    if method.name != STURDY {
        return Ok((method, structural(method)));
    }
    let tolerance = study.tolerance.unwrap_or(TOLERANCE);
    let few = few_steps(tolerance);
    let explicit = methods::find(EXPLICIT).filter(|m| (m.refuses)(train).is_none());
    let steps = study.until.and_then(|until| explicit_steps(train, until));
    let (taken, cost) = match (explicit, steps) {
        (Some(explicit), Some(steps)) if steps < few => (
            explicit,
            format!(
                "not stiff: at most {steps:.0} steps keep it stable, and beyond {few:.0} `{STURDY}` would cost less at a tolerance of {tolerance:.0e}"
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
            format!("no law tells how many steps `{}` would need", explicit.name),
        ),
        (None, _) => (
            method,
            "its nodes without inertia leave equations that explicit methods do not take"
                .to_string(),
        ),
    };
    Ok((taken, format!("{}; {cost}", curved(train))))
}

/// Seconds that all modes of a machine may take before it is asked whether steps take less: what is exact is worth a short wait.
const WORTH: f64 = 10.0;

/// The local error of steps that stand in for what would be exact, where a study names none: of 500 discs an error of 5e-9 in a second.
const TIGHT: f64 = 1e-11;

/// Seconds of a step of [`EXPLICIT`] by coordinate: 2000 discs took 671 steps in 0.83 s, 20 000 took 597 in 9.5 s.
const STEP: f64 = 8e-7;

/// So many times the steps that keep the method stable give that error: 1679 for 333 on these discs.
const EXACT: f64 = 5.0;

/// The explicit method where the machine's own would need all modes of many coordinates, and steps take less.
fn instead_of_modes(train: &Train, study: &SimulateStudy) -> Option<(&'static Method, String)> {
    let method = first(train, study).filter(|m| m.kin == Kin::Propagation)?;
    let modes = Dense::of(method, train.n())?;
    let explicit = methods::find(EXPLICIT).filter(|m| (m.refuses)(train).is_none())?;
    let steps = explicit_steps(train, study.until?)?;
    let seconds = EXACT * steps * STEP * train.n() as f64;
    (modes.seconds > WORTH && seconds < modes.seconds).then(|| {
        let reason = format!(
            "{}, which `{}` needs; at most {steps:.0} steps keep this one stable, about {} at a tolerance of {TIGHT:.0e}",
            modes.told(),
            method.name,
            duration(seconds)
        );
        (explicit, reason)
    })
}

/// Why a method that the structure asks for is right.
fn structural(method: &Method) -> String {
    match method.name {
        "exact" => "linear and time-invariant, so exact at every instant whatever error is asked".to_string(),
        "switched" => "linear between switches, so exact up to each, and each is located; whatever error is asked".to_string(),
        "periodic" => "stiffness and loads repeat in time, so that one period is tabulated and combined; whatever error is asked".to_string(),
        _ => format!("a step is given, and {} goes by one", method.title),
    }
}
