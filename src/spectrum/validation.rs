//! Validation of samples, rates and counts.

use crate::base::code::Code;
use crate::base::error::Error;

/// Refuses fewer than `least` samples, and samples that are not finite.
pub fn check_samples(samples: &[f64], least: usize) -> Result<(), Error> {
    if samples.len() < least {
        return Err(Error::new(
            Code::TooShort,
            format!("{} samples are too few (minimum {least})", samples.len()),
        )
        .with_hint("take a longer segment of the record"));
    }
    match samples.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(at) => Err(
            Error::new(Code::NotANumber, format!("sample {at} is {}", samples[at]))
                .with_hint("analyse each segment between gaps separately, or fill the gaps"),
        ),
    }
}

/// Refuses a rate, a frequency or a speed that is not positive and finite; `what` names it with its unit.
pub fn check_positive(value: f64, what: &str) -> Result<(), Error> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(Error::new(
        Code::OutOfRange,
        format!("{what} is {value}; it must be positive"),
    ))
}

/// Refuses a count below `least`; `what` names it.
pub fn check_count(count: usize, least: usize, what: &str) -> Result<(), Error> {
    if count >= least {
        return Ok(());
    }
    Err(Error::new(
        Code::OutOfRange,
        format!("{what} is {count} (minimum {least})"),
    ))
}

/// Arithmetic mean; 0 of nothing.
pub fn mean(samples: &[f64]) -> f64 {
    samples.iter().sum::<f64>() / samples.len().max(1) as f64
}
