//! The sample rate: as stated by the user, by the file, or by the time stamps; what contradicts it.

use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::recording::raw::Group;
use crate::recording::settings::{RateSource, Settings};
use crate::recording::stated_rates::{self, StatedRate, differ};
use crate::recording::time_base::{Spacing, TimeBase};

/// Rates that a recorder may have, Hz: a sample in thirty thousand years to one in the time light takes for a third of a millimetre.
const RATES: std::ops::RangeInclusive<f64> = 1e-12..=1e12;

/// Standard deviations of the rate by the stamps that another rate may be off.
const DEVIATIONS: f64 = 3.0;

/// A sample rate.
pub(super) struct Rate {
    pub hertz: f64,
    /// Its standard deviation, relative; zero where it is stated.
    pub std: f64,
    /// Where it comes from, in words.
    pub source: String,
}

/// The rate within [`RATES`]; `base` is the clock by the stamps, where it can be examined.
pub(super) fn rate(
    group: &Group,
    base: Option<&TimeBase>,
    settings: &Settings,
) -> Result<Rate, Error> {
    let rate = chosen(group, base, settings)?;
    if !RATES.contains(&rate.hertz) {
        return Err(no_rate(rate.hertz, &format!(" {}", rate.source)));
    }
    Ok(rate)
}

fn chosen(group: &Group, base: Option<&TimeBase>, settings: &Settings) -> Result<Rate, Error> {
    let by_stamps = |base: &TimeBase| {
        let rows = group.rows();
        let how = match base.spacing {
            Spacing::Jittered { .. } => "mean",
            _ => "by regression",
        };
        Rate {
            hertz: base.rate_hz,
            std: base.rate_std,
            source: format!("{how} over {rows} stamps"),
        }
    };
    match (settings.rate, base) {
        (Some(RateSource::Hertz(rate)), _) => Ok(stated(rate, "as stated".to_string())),
        (Some(RateSource::Time), Some(base)) => Ok(by_stamps(base)),
        (Some(RateSource::Time), None) => {
            let message = "the log has no time stamps to take the rate from";
            Err(Error::new(Code::RateUnknown, message).hint("state it: --rate HZ"))
        }
        (None, Some(base)) => {
            let rates = &group.clock.stated_rates;
            let of_samples: Vec<&StatedRate> = rates.iter().filter(|r| !r.is_bare).collect();
            let off = |r: &&StatedRate| differs_from_stamps(r.hertz, base);
            match !of_samples.is_empty() && of_samples.iter().all(off) {
                true => Err(disagree(group, base)),
                false => Ok(by_stamps(base)),
            }
        }
        (Some(RateSource::Header), _) => by_header(group, true),
        (None, None) => by_header(group, false),
    }
}

fn stated(hertz: f64, source: String) -> Rate {
    Rate {
        hertz,
        std: 0.0,
        source,
    }
}

/// The rate that the file states; a bare `rate` where it is `named` by the user.
fn by_header(group: &Group, named: bool) -> Result<Rate, Error> {
    if let Some(rate) = stated_rates::agreed(&group.clock.stated_rates, named)? {
        let source = format!("as the header says ({})", rate.key);
        return Ok(stated(rate.hertz, source));
    }
    if let Some(unread) = &group.clock.unread_rate {
        return Err(unread.clone());
    }
    let (message, hint) = match named {
        true => (
            "the header of the log states no sample rate",
            "--rate-from time, or state it: --rate HZ",
        ),
        false => (
            "the log has neither time stamps nor a sample rate in its header",
            "state it: --rate HZ, or rate = \"… Hz\" in the sidecar",
        ),
    };
    Err(Error::new(Code::RateUnknown, message).hint(hint))
}

fn differs_from_stamps(rate_hz: f64, base: &TimeBase) -> bool {
    differ(rate_hz, base.rate_hz, DEVIATIONS * base.rate_std)
}

/// The warning of rates that contradict the one taken, unless the user chose between them (`--rate-from`).
pub(super) fn contradicted(
    group: &Group,
    base: Option<&TimeBase>,
    taken_hz: f64,
    settings: &Settings,
) -> Option<Warning> {
    let is_stated = match settings.rate {
        Some(RateSource::Time | RateSource::Header) => return None,
        Some(RateSource::Hertz(_)) => true,
        None => false,
    };
    let stated = group.clock.stated_rates.iter();
    let mut others: Vec<String> = stated
        .filter(|r| {
            differ(
                r.hertz,
                taken_hz,
                base.map_or(0.0, |b| DEVIATIONS * b.rate_std),
            )
        })
        .map(|r| format!("`{}` says {} Hz", r.key, short(r.hertz)))
        .collect();
    if let Some(base) = base.filter(|base| differs_from_stamps(taken_hz, base)) {
        others.push(format!("the time stamps say {} Hz", short(base.rate_hz)));
    }
    let hint = match is_stated {
        true => "leave --rate out to take the rate of the log, or check the unit of its times",
        false => "if the rate taken is wrong, state it: --rate HZ",
    };
    (!others.is_empty()).then(|| Warning {
        code: "rate-disagrees",
        message: format!(
            "the rate taken is {} Hz, but {}",
            short(taken_hz),
            others.join(" and ")
        ),
        hint: Some(hint.to_string()),
    })
}

/// A rate to a millionth of a hertz.
fn short(rate_hz: f64) -> f64 {
    (rate_hz * 1e6).round() / 1e6
}

/// The error of a rate that no recorder has.
fn no_rate(rate_hz: f64, source: &str) -> Error {
    let message = format!(
        "a sample rate of {rate_hz:e} Hz{source} cannot be: it lies outside of {:e} to {:e} Hz",
        RATES.start(),
        RATES.end()
    );
    Error::new(Code::OutOfRange, message)
        .hint("look at the unit of the rate, or of the time stamps")
}

/// The error of stamps that contradict every rate the file states.
fn disagree(group: &Group, base: &TimeBase) -> Error {
    let rows = group.rows();
    let samples = group.clock.header_samples.filter(|&n| n != rows);
    let counts = samples.map_or(String::new(), |n| {
        format!("; the header speaks of {n} samples, the file holds {rows}")
    });
    let stated: Vec<String> = stated_rates::candidates(&group.clock.stated_rates)
        .map(|r| format!("the header ({}) says {} Hz", r.key, r.hertz))
        .collect();
    let message = format!(
        "{}, the time stamps say {:.6} Hz{counts}",
        stated.join(", "),
        base.rate_hz
    );
    Error::new(Code::RateDisagrees, message)
        .hint("say which is right: --rate-from time, or --rate-from header")
}
