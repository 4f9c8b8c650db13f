//! Builds a modes study from scene and flags, in SI.

use super::args::{HoldArg, ModesStudyArgs, ReductionArg};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::scene::Scene;
use crate::scene::study::{
    DiscretisationMethod, ModesStudy, ReductionKind, ReductionStudy, SpeedRange, StateSpaceStudy,
    StudyKind,
};

/// The study that is asked for: the first a scene lists, with what the flags say put in its place.
///
/// # Errors
/// A quantity without sense.
pub fn from_args(args: &ModesStudyArgs, scene: &Scene) -> Result<ModesStudy, Error> {
    let listed = scene.studies.iter().find_map(|study| match &study.kind {
        StudyKind::Modes(modes) => Some(modes.clone()),
        _ => None,
    });
    let listed = listed.unwrap_or_default();
    let quantity = |text: &Option<String>, kind, unit, flag| -> Result<Option<f64>, Error> {
        text.as_deref()
            .map(|t| quantity::parse_or_bare(t, kind, unit, flag))
            .transpose()
    };
    let hertz = quantity(&args.near, QuantityKind::Frequency, "Hz", "--near")?;
    if hertz.is_some_and(|f| f < 0.0) {
        return Err(Error::new(
            Code::OutOfRange,
            "--near takes a frequency that is not negative",
        ));
    }
    if args.lowest == Some(0) {
        return Err(Error::new(Code::OutOfRange, "--lowest 0 asks for no mode")
            .with_hint("--lowest takes a count of at least 1"));
    }
    Ok(ModesStudy {
        damped: args.damped || listed.damped,
        speed: quantity(&args.speed, QuantityKind::Speed, "rpm", "--speed")?.or(listed.speed),
        campbell: args
            .campbell
            .as_deref()
            .map(|text| SpeedRange::parse(text, "--campbell"))
            .transpose()?
            .or(listed.campbell),
        lowest: args.lowest.or(listed.lowest),
        near: hertz.or(listed.near),
        state_space: state_space(args)?,
        reduce: reduce(args)?,
    })
}

fn state_space(args: &ModesStudyArgs) -> Result<Option<StateSpaceStudy>, Error> {
    if args.state_space.is_none() {
        return Ok(None);
    }
    let time = args.sample_time.as_deref();
    let sample_time = time
        .map(|t| quantity::parse_or_bare(t, QuantityKind::Time, "s", "--sample-time"))
        .transpose()?;
    let method = match args.hold {
        HoldArg::Zero => DiscretisationMethod::Zero,
        HoldArg::First => DiscretisationMethod::First,
        HoldArg::Bilinear => DiscretisationMethod::Bilinear,
    };
    let (inputs, outputs) = (args.input.clone(), args.output.clone());
    Ok(Some(StateSpaceStudy {
        inputs,
        outputs,
        sample_time,
        method,
    }))
}

fn reduce(args: &ModesStudyArgs) -> Result<Option<ReductionStudy>, Error> {
    let (Some(word), Some(below)) = (args.reduce, &args.below) else {
        return Ok(None);
    };
    let hertz = |text: &str, flag| -> Result<f64, Error> {
        Ok(
            quantity::parse_or_bare(text, QuantityKind::Frequency, "Hz", flag)?
                / std::f64::consts::TAU,
        )
    };
    let at = args
        .condense_at
        .as_deref()
        .map(|text| hertz(text, "--condense-at"))
        .transpose()?;
    let method = match (word, at) {
        (ReductionArg::Guyan, None) => ReductionKind::Guyan,
        (ReductionArg::Dynamic, Some(hz)) => ReductionKind::Dynamic(hz),
        (ReductionArg::CraigBampton, None) => ReductionKind::CraigBampton,
        (ReductionArg::Modal, None) => ReductionKind::Modal,
        (ReductionArg::Dynamic, None) => {
            return Err(Error::new(
                Code::Usage,
                "--reduce dynamic takes the frequency it condenses at",
            )
            .with_hint("add --condense-at 100"));
        }
        _ => {
            return Err(Error::new(
                Code::Usage,
                "--condense-at belongs to --reduce dynamic",
            ));
        }
    };
    let below_hz = hertz(below, "--below")?;
    Ok(Some(ReductionStudy {
        method,
        keep: args.keep.clone(),
        max_frequency_hz: below_hz,
        modes: args.keep_modes,
    }))
}
