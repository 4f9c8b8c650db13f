//! Channel calibration: scale factor from the unit and the sensor sensitivity (such as `100 mV/g`).

use super::channel_unit::{self, MeasuredQuantity};
use super::read_options::ChannelOptions;
use crate::base::code::Code;
use crate::base::error::Error;

/// Conversion of a channel's recorded numbers to the measured quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// Name of the channel after calibration.
    pub name: String,
    /// Unit after scaling.
    pub unit: String,
    /// Scale factor of the recorded numbers.
    pub factor: f64,
    /// Samples at or beyond this size, after scaling, are overloads.
    pub overload: Option<f64>,
}

/// The calibration of a channel: that of the file unless overridden by the options.
///
/// # Errors
/// A sensitivity without sense, or of a channel that is not in volts.
pub fn for_channel(
    name: &str,
    unit: &str,
    said: Option<&ChannelOptions>,
) -> Result<Calibration, Error> {
    let mut found = Calibration {
        name: name.to_string(),
        unit: unit.to_string(),
        factor: 1.0,
        overload: None,
    };
    let Some(said) = said else {
        return Ok(found);
    };
    if let Some(rename) = &said.rename {
        found.name.clone_from(rename);
    }
    if let Some(unit) = &said.unit {
        found.unit.clone_from(unit);
    }
    if let Some(sensitivity) = &said.sensitivity {
        let (per_unit, unit) = parse_sensitivity(sensitivity, name)?;
        // Numbers without a unit are taken as volts: what a converter writes.
        let volts = match channel_unit::parse(&found.unit) {
            Some(q) if q.quantity == MeasuredQuantity::Voltage => q.factor,
            None if found.unit.is_empty() => 1.0,
            _ => {
                let message = format!(
                    "channel \"{name}\" is in {}, not in volts: a sensitivity does not apply",
                    found.unit
                );
                return Err(Error::new(Code::WrongUnit, message).with_hint(
                    "omit the sensitivity, or state that the numbers are volts: --unit NAME=V",
                ));
            }
        };
        found.factor = volts / per_unit;
        if !found.factor.is_normal() {
            let message = format!("invalid sensitivity \"{sensitivity}\" of \"{name}\"");
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("write V or mV per unit: \"100 mV/g\""));
        }
        found.unit = unit;
    }
    found.overload = said.overload.map(|level| level.abs() * found.factor.abs());
    Ok(found)
}

/// `100 mV/g`: volts for one unit, and the unit.
fn parse_sensitivity(text: &str, channel: &str) -> Result<(f64, String), Error> {
    let wrong = || {
        let message = format!("\"{text}\" is not a sensitivity");
        Error::new(Code::WrongUnit, message).with_hint(format!(
            "write volts per unit, such as --sensitivity \"{channel}=100 mV/g\""
        ))
    };
    let (number, rest) = text.trim().split_once(' ').ok_or_else(wrong)?;
    let (volts, unit) = rest.trim().split_once('/').ok_or_else(wrong)?;
    let number: f64 = number.parse().map_err(|_| wrong())?;
    let unit = unit.trim().trim_start_matches('(').trim_end_matches(')');
    let scale = channel_unit::parse(volts)
        .filter(|q| q.quantity == MeasuredQuantity::Voltage)
        .ok_or_else(wrong)?;
    let per_unit = number * scale.factor;
    if !per_unit.is_finite() || per_unit == 0.0 || unit.is_empty() {
        return Err(wrong());
    }
    Ok((per_unit, unit.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stated_text(unit: Option<&str>, sensitivity: &str) -> ChannelOptions {
        ChannelOptions {
            name: "a".into(),
            unit: unit.map(str::to_string),
            sensitivity: Some(sensitivity.into()),
            ..ChannelOptions::default()
        }
    }

    #[test]
    fn exact_sensitivities() {
        let found = for_channel("a", "mV", Some(&stated_text(None, "100 mV/g"))).unwrap();
        assert!((found.factor - 0.01).abs() < 1e-17 && found.unit == "g");
        let found = for_channel("a", "", Some(&stated_text(None, "2.25 mV/N"))).unwrap();
        assert!((found.factor - 1.0 / 2.25e-3).abs() < 1e-10 && found.unit == "N");
    }

    #[test]
    fn refuses_sensitivities_without_sense() {
        for wrong in ["100", "100 g/mV", "x mV/g", "0 mV/g", "nan mV/g", "100 mV/"] {
            assert_eq!(
                for_channel("a", "V", Some(&stated_text(None, wrong)))
                    .unwrap_err()
                    .code,
                Code::WrongUnit,
                "{wrong}"
            );
        }
        assert!(for_channel("a", "m/s²", Some(&stated_text(None, "100 mV/g"))).is_err());
    }
}
