//! Arguments as meant: flags become a study, in SI.

use super::args::{HoldWord, ReduceWord, StudyArgs};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::kind::Kind;
use crate::base::units;
use crate::scene::Scene;
use crate::scene::study::{
    Hold, ModesStudy, ReduceMethod, ReduceStudy, SpeedRange, StateSpaceStudy, StudyKind,
};

/// The study that is asked for: the first a scene lists, with what the flags say put in its place.
///
/// # Errors
/// A quantity without sense.
pub fn of(args: &StudyArgs, scene: &Scene) -> Result<ModesStudy, Error> {
    let listed = scene.studies.iter().find_map(|study| match &study.kind {
        StudyKind::Modes(modes) => Some(modes.clone()),
        _ => None,
    });
    let listed = listed.unwrap_or_default();
    let quantity = |text: &Option<String>, kind, unit, flag| -> Result<Option<f64>, Error> {
        text.as_deref()
            .map(|t| units::parse_or_bare(t, kind, unit, flag))
            .transpose()
    };
    let hertz = quantity(&args.near, Kind::Frequency, "Hz", "--near")?;
    if hertz.is_some_and(|f| f < 0.0) {
        return Err(Error::new(
            Code::OutOfRange,
            "--near takes a frequency that is not negative",
        ));
    }
    if args.lowest == Some(0) {
        return Err(Error::new(Code::OutOfRange, "--lowest 0 asks for no mode")
            .hint("--lowest takes a count of at least 1"));
    }
    Ok(ModesStudy {
        damped: args.damped || listed.damped,
        speed: quantity(&args.speed, Kind::Speed, "rpm", "--speed")?.or(listed.speed),
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

fn state_space(args: &StudyArgs) -> Result<Option<StateSpaceStudy>, Error> {
    if args.state_space.is_none() {
        return Ok(None);
    }
    let time = args.sample_time.as_deref();
    let sample_time = time
        .map(|t| units::parse_or_bare(t, Kind::Time, "s", "--sample-time"))
        .transpose()?;
    let hold = match args.hold {
        HoldWord::Zero => Hold::Zero,
        HoldWord::First => Hold::First,
        HoldWord::Bilinear => Hold::Bilinear,
    };
    let (inputs, outputs) = (args.input.clone(), args.output.clone());
    Ok(Some(StateSpaceStudy {
        inputs,
        outputs,
        sample_time,
        hold,
    }))
}

fn reduce(args: &StudyArgs) -> Result<Option<ReduceStudy>, Error> {
    let (Some(word), Some(below)) = (args.reduce, &args.below) else {
        return Ok(None);
    };
    let hertz = |text: &str, flag| -> Result<f64, Error> {
        Ok(units::parse_or_bare(text, Kind::Frequency, "Hz", flag)? / std::f64::consts::TAU)
    };
    let at = args
        .condense_at
        .as_deref()
        .map(|text| hertz(text, "--condense-at"))
        .transpose()?;
    let method = match (word, at) {
        (ReduceWord::Guyan, None) => ReduceMethod::Guyan,
        (ReduceWord::Dynamic, Some(hz)) => ReduceMethod::Dynamic(hz),
        (ReduceWord::CraigBampton, None) => ReduceMethod::CraigBampton,
        (ReduceWord::Modal, None) => ReduceMethod::Modal,
        (ReduceWord::Dynamic, None) => {
            return Err(Error::new(
                Code::Usage,
                "--reduce dynamic takes the frequency it condenses at",
            )
            .hint("add --condense-at 100"));
        }
        _ => {
            return Err(Error::new(
                Code::Usage,
                "--condense-at belongs to --reduce dynamic",
            ));
        }
    };
    let below_hz = hertz(below, "--below")?;
    Ok(Some(ReduceStudy {
        method,
        keep: args.keep.clone(),
        below_hz,
        modes: args.keep_modes,
    }))
}
