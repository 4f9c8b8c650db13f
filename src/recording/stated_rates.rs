//! Sample rates that a file states: every candidate, and which of them may be the speed of a shaft.

use crate::base::code::Code;
use crate::base::error::Error;

/// Rates that differ by more than this, relative, contradict each other.
pub(super) const SAME_RATE: f64 = 1e-3;

/// Key of a sample rate or of the speed of a shaft, folded.
pub(super) const BARE_RATE: &str = "rate";

/// A bare `rate` below this may be the speed of a shaft, Hz: 1 kHz is 60 000 rpm.
const SHAFT_SPEEDS_BELOW: f64 = 1000.0;

/// A sample rate that a file states.
#[derive(Debug, Clone, PartialEq)]
pub struct StatedRate {
    /// The rate, Hz.
    pub hertz: f64,
    /// Key under which the file states it: `Delta_X`, `Sampling Frequency`.
    pub key: String,
    /// The key is `rate` alone, without a unit of samples: of a rotating machine it may be the speed of a shaft.
    pub is_bare: bool,
}

impl StatedRate {
    /// A rate whose key speaks of samples.
    pub fn is_sample_rate(hertz: f64, key: impl Into<String>) -> StatedRate {
        StatedRate {
            hertz,
            key: key.into(),
            is_bare: false,
        }
    }
}

/// Whether two rates contradict each other beyond `tolerance` and [`SAME_RATE`], relative.
pub(super) fn differ(one_hz: f64, other_hz: f64, tolerance: f64) -> bool {
    (one_hz / other_hz - 1.0).abs() > SAME_RATE.max(tolerance)
}

/// The candidates that count: those whose key speaks of samples; without any, the bare ones.
pub(super) fn candidates(rates: &[StatedRate]) -> impl Iterator<Item = &StatedRate> {
    let only_bare = rates.iter().all(|r| r.is_bare);
    rates.iter().filter(move |r| only_bare || !r.is_bare)
}

/// The rate on which the candidates agree; `None` where the file states none.
///
/// # Errors
/// Candidates that contradict each other (`rate-disagrees`); only a bare `rate` that may be the speed of a shaft (`rate-unknown`), unless
/// bare rates are accepted.
pub(super) fn agreed_rate(
    rates: &[StatedRate],
    accepts_bare: bool,
) -> Result<Option<&StatedRate>, Error> {
    let Some(first) = candidates(rates).next() else {
        return Ok(None);
    };
    if let Some(other) = candidates(rates).find(|r| differ(r.hertz, first.hertz, 0.0)) {
        let message = format!(
            "the file states two sample rates: `{}` = {} Hz, `{}` = {} Hz",
            first.key, first.hertz, other.key, other.hertz
        );
        return Err(Error::new(Code::RateDisagrees, message)
            .with_hint("state the right one: --rate HZ, or rate = \"… Hz\" in the sidecar"));
    }
    if first.is_bare && first.hertz < SHAFT_SPEEDS_BELOW && !accepts_bare {
        let message = format!(
            "the only sample rate the file states is `{}` = {} Hz, which may be the speed of a shaft",
            first.key, first.hertz
        );
        return Err(Error::new(Code::RateUnknown, message)
            .with_hint("if it is the sample rate: --rate-from header; else state it: --rate HZ"));
    }
    Ok(Some(first))
}
