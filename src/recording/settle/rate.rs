//! The sample rate: as stated, by the header, or by the time stamps.

use super::SAME_RATE;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::recording::raw::Group;
use crate::recording::settings::{RateSource, Settings};
use crate::recording::time_base::{Spacing, TimeBase};

/// Rates that a recorder may have, Hz: a sample in thirty thousand years to one in the time light takes for a third of a millimetre.
const RATES: std::ops::RangeInclusive<f64> = 1e-12..=1e12;

/// The rate within [`RATES`], Hz, and where it comes from in words.
pub(super) fn rate(
    group: &Group,
    base: Option<&TimeBase>,
    settings: &Settings,
) -> Result<(f64, String), Error> {
    let (rate_hz, source) = said(group, base, settings)?;
    if !RATES.contains(&rate_hz) {
        return Err(no_rate(rate_hz, &format!(" {source}")));
    }
    Ok((rate_hz, source))
}

/// The rate, and where it comes from in words.
fn said(
    group: &Group,
    base: Option<&TimeBase>,
    settings: &Settings,
) -> Result<(f64, String), Error> {
    let header = group.clock.header_rate.as_ref();
    let by_stamps = |base: &TimeBase| {
        let rows = group.rows();
        let how = match base.spacing {
            Spacing::Jittered { .. } => "mean",
            _ => "by regression",
        };
        (base.rate_hz, format!("{how} over {rows} stamps"))
    };
    if let (Some(RateSource::Header), _, None) | (None, None, None) = (settings.rate, base, header)
        && let Some(unread) = &group.clock.unread_rate
    {
        return Err(unread.clone());
    }
    match (settings.rate, base, header) {
        (Some(RateSource::Hertz(rate)), _, _) => Ok((rate, "as stated".to_string())),
        (Some(RateSource::Time), Some(base), _) => Ok(by_stamps(base)),
        (Some(RateSource::Time), None, _) => {
            let message = "the log has no time stamps to take the rate from";
            Err(Error::new(Code::RateUnknown, message).hint("state it: --rate HZ"))
        }
        (Some(RateSource::Header), _, Some((rate, key))) => {
            Ok((*rate, format!("as the header says ({key})")))
        }
        (Some(RateSource::Header), _, None) => {
            let message = "the header of the log states no sample rate";
            Err(Error::new(Code::RateUnknown, message)
                .hint("--rate-from time, or state it: --rate HZ"))
        }
        (None, Some(base), Some((rate, key)))
            if (rate / base.rate_hz - 1.0).abs() > SAME_RATE.max(3.0 * base.rate_std) =>
        {
            Err(disagree(group, base, *rate, key))
        }
        (None, Some(base), _) => Ok(by_stamps(base)),
        (None, None, Some((rate, key))) => Ok((*rate, format!("as the header says ({key})"))),
        (None, None, None) => {
            let message = "the log has neither time stamps nor a sample rate in its header";
            let hint = "state it: --rate HZ, or rate = \"… Hz\" in the sidecar";
            Err(Error::new(Code::RateUnknown, message).hint(hint))
        }
    }
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

/// The three ways to the rate, shown side by side.
fn disagree(group: &Group, base: &TimeBase, header: f64, key: &str) -> Error {
    let rows = group.rows();
    let stated = group.clock.header_samples.filter(|&n| n != rows);
    let counts = stated.map_or(String::new(), |n| {
        format!("; the header speaks of {n} samples, the file holds {rows}")
    });
    let message = format!(
        "the header ({key}) says {header} Hz, the time stamps say {:.6} Hz{counts}",
        base.rate_hz
    );
    Error::new(Code::RateDisagrees, message)
        .hint("say which is right: --rate-from time, or --rate-from header")
}
