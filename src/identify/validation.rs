//! Validation of samples and rates.

use crate::base::code::Code;
use crate::base::error::Error;

/// Refuses a rate that is not positive and finite.
pub(super) fn check_rate(rate_hz: f64) -> Result<(), Error> {
    if rate_hz > 0.0 && rate_hz.is_finite() {
        return Ok(());
    }
    Err(
        Error::new(Code::OutOfRange, format!("the sample rate is {rate_hz} Hz"))
            .with_hint("state the rate the samples were taken at"),
    )
}

/// Refuses samples that are absent, not finite or all alike; `what` names the signal.
pub(super) fn check_samples(samples: &[f64], what: &str) -> Result<(), Error> {
    let Some(first) = samples.first() else {
        return Err(Error::new(Code::EmptyLog, format!("{what} has no samples"))
            .with_hint("choose a segment of the record with samples"));
    };
    if let Some(at) = samples.iter().position(|x| !x.is_finite()) {
        return Err(Error::new(
            Code::NotANumber,
            format!("sample {at} of {what} is {}", samples[at]),
        )
        .with_hint("analyse each segment between gaps separately, or fill the gaps"));
    }
    if samples.iter().all(|x| x == first) {
        return Err(Error::new(
            Code::NoSignal,
            format!("{what} is {first} in all {} samples", samples.len()),
        )
        .with_hint("a constant holds no dynamics: check whether the sensor was connected"));
    }
    Ok(())
}
