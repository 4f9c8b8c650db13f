//! Builds a simulation study from scene and flags.

use super::args::{IntegrationArgs, MotionArgs};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::SourceSpan;
use crate::scene::study::SimulateStudy;

/// An error of a study that came from a scene alone, with the place of that study.
pub fn with_study_span(error: Error, args: &MotionArgs, study: Option<&SourceSpan>) -> Error {
    match study {
        Some(span) if !any_set(args) && error.span.is_none() && error.code.exit_code() == 2 => {
            error.with_span(span)
        }
        _ => error,
    }
}

/// Whether the flags say anything.
fn any_set(args: &MotionArgs) -> bool {
    !args.output.is_empty() || any_integration_set(&args.integration)
}

/// Whether the flags say anything of how a motion is integrated.
pub fn any_integration_set(args: &IntegrationArgs) -> bool {
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
pub fn from_args(args: &MotionArgs, listed: SimulateStudy) -> Result<SimulateStudy, Error> {
    let study = integration_from_args(&args.integration, listed)?;
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
pub fn integration_from_args(
    args: &IntegrationArgs,
    listed: SimulateStudy,
) -> Result<SimulateStudy, Error> {
    if args.tolerance.is_some_and(|t| !(t > 0.0 && t < 1.0)) {
        let error = Error::new(
            Code::OutOfRange,
            "--tolerance takes a number above 0 and below 1",
        );
        return Err(error.with_hint(
            "it is the local error of a step, relative to the size of each state: 1e-8 is usual",
        ));
    }
    if args.samples == Some(0) {
        return Err(Error::new(Code::OutOfRange, "--samples 0 asks for nothing")
            .with_hint("--samples takes a count of at least 1"));
    }
    let (tolerance, step) = (args.tolerance, parse_time(&args.step, "--step")?);
    let said = tolerance.is_some() || step.is_some();
    Ok(SimulateStudy {
        end_time: parse_time(&args.until, "--until")?.or(listed.end_time),
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
pub fn parse_time(text: &Option<String>, flag: &str) -> Result<Option<f64>, Error> {
    let value = text
        .as_deref()
        .map(|t| quantity::parse_or_bare(t, QuantityKind::Time, "s", flag))
        .transpose()?;
    match value {
        Some(value) if !(value > 0.0 && value.is_finite()) => {
            let given = text.as_deref().unwrap_or_default();
            let message = format!("{flag} takes a time above zero, and {given} is none");
            let hint = format!("write {flag} \"2 s\", or a bare number of seconds");
            Err(Error::new(Code::OutOfRange, message).with_hint(hint))
        }
        value => Ok(value),
    }
}
