//! Arguments as meant: flags become a study, in SI.

use super::args::StudyArgs;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::kind::Kind;
use crate::base::units;
use crate::scene::study::{ModesStudy, SpeedRange};

/// The study that the flags ask for.
///
/// # Errors
/// A quantity without sense.
pub fn of(args: &StudyArgs) -> Result<ModesStudy, Error> {
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
        damped: args.damped,
        speed: quantity(&args.speed, Kind::Speed, "rpm", "--speed")?,
        campbell: args
            .campbell
            .as_deref()
            .map(|text| SpeedRange::parse(text, "--campbell"))
            .transpose()?,
        lowest: args.lowest,
        near: hertz,
    })
}
