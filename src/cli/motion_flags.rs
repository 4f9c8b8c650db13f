//! Flags of motion as a study.

use super::args::{IntegrationArgs, MotionArgs};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::kind::Kind;
use crate::base::place::Place;
use crate::base::units;
use crate::scene::study::SimulateStudy;

/// An error of a study that came from a scene alone, with the place of that study.
pub fn placed(error: Error, args: &MotionArgs, study: Option<&Place>) -> Error {
    match study {
        Some(place) if !says(args) && error.place.is_none() && error.code.exit() == 2 => {
            error.at(place)
        }
        _ => error,
    }
}

/// Whether the flags say anything.
fn says(args: &MotionArgs) -> bool {
    !args.output.is_empty() || says_how(&args.integration)
}

/// Whether the flags say anything of how a motion is integrated.
pub fn says_how(args: &IntegrationArgs) -> bool {
    args.until.is_some()
        || args.method.is_some()
        || args.tolerance.is_some()
        || args.step.is_some()
        || args.samples.is_some()
}

/// The study of a scene with what the flags say put in its place.
///
/// # Errors
/// A quantity without sense.
pub fn study(args: &MotionArgs, listed: SimulateStudy) -> Result<SimulateStudy, Error> {
    let study = integrated(&args.integration, listed)?;
    Ok(match args.output.is_empty() {
        true => study,
        false => SimulateStudy {
            outputs: args.output.clone(),
            ..study
        },
    })
}

/// The study of a scene with what the flags say of its integration put in its place.
///
/// # Errors
/// A quantity without sense.
pub fn integrated(args: &IntegrationArgs, listed: SimulateStudy) -> Result<SimulateStudy, Error> {
    if args.tolerance.is_some_and(|t| !(t > 0.0 && t < 1.0)) {
        let error = Error::new(
            Code::OutOfRange,
            "--tolerance takes a number above 0 and below 1",
        );
        return Err(error.hint(
            "it is the local error of a step, relative to the size of each state: 1e-8 is usual",
        ));
    }
    if args.samples == Some(0) {
        return Err(Error::new(Code::OutOfRange, "--samples 0 asks for nothing")
            .hint("--samples takes a count of at least 1"));
    }
    let (tolerance, step) = (args.tolerance, time(&args.step, "--step")?);
    let said = tolerance.is_some() || step.is_some();
    Ok(SimulateStudy {
        until: time(&args.until, "--until")?.or(listed.until),
        method: args.method.clone().or(listed.method),
        tolerance: if said { tolerance } else { listed.tolerance },
        step: if said { step } else { listed.step },
        samples: args.samples.or(listed.samples),
        ..listed
    })
}

/// A time that a flag gives, s.
///
/// # Errors
/// What is no time above zero.
pub fn time(text: &Option<String>, flag: &str) -> Result<Option<f64>, Error> {
    let value = text
        .as_deref()
        .map(|t| units::parse_or_bare(t, Kind::Time, "s", flag))
        .transpose()?;
    match value {
        Some(value) if !(value > 0.0 && value.is_finite()) => {
            let given = text.as_deref().unwrap_or_default();
            let message = format!("{flag} takes a time above zero, and {given} is none");
            let hint = format!("write {flag} \"2 s\", or a bare number of seconds");
            Err(Error::new(Code::OutOfRange, message).hint(hint))
        }
        value => Ok(value),
    }
}
