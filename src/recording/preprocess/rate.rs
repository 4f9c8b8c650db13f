//! Sample rate: as stated, from the header, or from the time stamps.

use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::recording::raw::ChannelGroup;
use crate::recording::read_options::{RateSource, ReadOptions};
use crate::recording::stated_rates::{self, StatedRate, differ};
use crate::recording::time_base::{Spacing, TimeBase};

/// Rates that a recorder may have, Hz: a sample in thirty thousand years to one in the time light takes for a third of a millimetre.
const VALID_RATES_HZ: std::ops::RangeInclusive<f64> = 1e-12..=1e12;

/// Standard deviations of the rate by the stamps that another rate may be off.
const DEVIATIONS: f64 = 3.0;

/// A sample rate.
pub(super) struct Rate {
    pub hertz: f64,
    /// Standard deviation, relative; zero where the rate is stated.
    pub std: f64,
    /// Source of the rate, as text.
    pub source: String,
}

/// The rate within [`VALID_RATES_HZ`]; `base` is the clock by the stamps, where it can be examined.
pub(super) fn rate(
    group: &ChannelGroup,
    base: Option<&TimeBase>,
    options: &ReadOptions,
) -> Result<Rate, Error> {
    let rate = chosen(group, base, options)?;
    if !VALID_RATES_HZ.contains(&rate.hertz) {
        return Err(implausible_rate(rate.hertz, &format!(" {}", rate.source)));
    }
    Ok(rate)
}

fn chosen(
    group: &ChannelGroup,
    base: Option<&TimeBase>,
    options: &ReadOptions,
) -> Result<Rate, Error> {
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
    match (options.rate, base) {
        (Some(RateSource::Hertz(rate)), _) => Ok(stated(rate, "as stated".to_string())),
        (Some(RateSource::TimeStamps), Some(base)) => Ok(by_stamps(base)),
        (Some(RateSource::TimeStamps), None) => {
            let message = "the log has no time stamps to determine the rate";
            Err(Error::new(Code::RateUnknown, message).with_hint("state it: --rate HZ"))
        }
        (None, Some(base)) => {
            let rates = &group.timing.stated_rates;
            let of_samples: Vec<&StatedRate> = rates.iter().filter(|r| !r.is_bare).collect();
            let off = |r: &&StatedRate| differs_from_stamps(r.hertz, base);
            match !of_samples.is_empty() && of_samples.iter().all(off) {
                true => Err(conflicting_rates(group, base)),
                false => Ok(by_stamps(base)),
            }
        }
        (Some(RateSource::Header), _) => header_rate(group, true),
        (None, None) => header_rate(group, false),
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
fn header_rate(group: &ChannelGroup, named: bool) -> Result<Rate, Error> {
    if let Some(rate) = stated_rates::agreed_rate(&group.timing.stated_rates, named)? {
        let source = format!("from the header ({})", rate.key);
        return Ok(stated(rate.hertz, source));
    }
    if let Some(unread) = &group.timing.invalid_rate {
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
    Err(Error::new(Code::RateUnknown, message).with_hint(hint))
}

fn differs_from_stamps(rate_hz: f64, base: &TimeBase) -> bool {
    differ(rate_hz, base.rate_hz, DEVIATIONS * base.rate_std)
}

/// The warning of rates that contradict the one taken, unless the user chose between them (`--rate-from`).
pub(super) fn contradicted(
    group: &ChannelGroup,
    base: Option<&TimeBase>,
    taken_hz: f64,
    options: &ReadOptions,
) -> Option<Diagnostic> {
    let is_stated = match options.rate {
        Some(RateSource::TimeStamps | RateSource::Header) => return None,
        Some(RateSource::Hertz(_)) => true,
        None => false,
    };
    let stated = group.timing.stated_rates.iter();
    let mut others: Vec<String> = stated
        .filter(|r| {
            differ(
                r.hertz,
                taken_hz,
                base.map_or(0.0, |b| DEVIATIONS * b.rate_std),
            )
        })
        .map(|r| format!("`{}` states {} Hz", r.key, short(r.hertz)))
        .collect();
    if let Some(base) = base.filter(|base| differs_from_stamps(taken_hz, base)) {
        others.push(format!("the time stamps say {} Hz", short(base.rate_hz)));
    }
    let hint = match is_stated {
        true => "omit --rate to use the rate of the log, or check the unit of its times",
        false => "if the rate taken is wrong, state it: --rate HZ",
    };
    (!others.is_empty()).then(|| Diagnostic {
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
fn implausible_rate(rate_hz: f64, source: &str) -> Error {
    let message = format!(
        "a sample rate of {rate_hz:e} Hz{source} is outside of {:e} to {:e} Hz",
        VALID_RATES_HZ.start(),
        VALID_RATES_HZ.end()
    );
    Error::new(Code::OutOfRange, message)
        .with_hint("check the unit of the rate, or of the time stamps")
}

/// The error of stamps that contradict every rate the file states.
fn conflicting_rates(group: &ChannelGroup, base: &TimeBase) -> Error {
    let rows = group.rows();
    let samples = group.timing.header_samples.filter(|&n| n != rows);
    let counts = samples.map_or(String::new(), |n| {
        format!("; the header speaks of {n} samples, the file holds {rows}")
    });
    let stated: Vec<String> = stated_rates::candidates(&group.timing.stated_rates)
        .map(|r| format!("the header ({}) states {} Hz", r.key, r.hertz))
        .collect();
    let message = format!(
        "{}, the time stamps say {:.6} Hz{counts}",
        stated.join(", "),
        base.rate_hz
    );
    Error::new(Code::RateDisagrees, message)
        .with_hint("state which is right: --rate-from time, or --rate-from header")
}
