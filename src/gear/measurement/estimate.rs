//! Value with standard uncertainty: `u(y)² = Σ (∂y/∂xᵢ)² uᵢ²` (GUM, JCGM 100:2008, eq. 10).

/// A value and how far it may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// One standard deviation, in the unit of the value; absent where no uncertainty of the readings is stated.
    pub std: Option<f64>,
}

impl Estimate {
    /// A value that grows `gain` times as the uncertainty `std` of each of its independent readings.
    pub fn new(value: f64, gain: f64, std: Option<f64>) -> Estimate {
        Estimate {
            value,
            std: std.map(|u| gain * u),
        }
    }

    /// The same in another unit or on another line.
    pub fn scaled_by(self, factor: f64) -> Estimate {
        Estimate {
            value: factor * self.value,
            std: self.std.map(|u| factor.abs() * u),
        }
    }
}

/// Refuses readings that are not finite; `what` says whose.
///
/// # Errors
/// `NotANumber`, with the number of the reading.
pub(super) fn check_finite(readings: &[f64], what: &str) -> Result<(), crate::base::error::Error> {
    use crate::base::{code::Code, error::Error};
    match readings.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(i) => Err(Error::new(
            Code::NotANumber,
            format!("reading {} of {what} is missing or no number", i + 1),
        )
        .with_hint("measure it again: missing values are not interpolated")),
    }
}
