//! Tooth-thickness deviation `E_sn = s_n − s_n,nominal` from span, balls, chord or constant chord.
//!
//! Sensitivities `ds_n` (of internal gears by span `−dW/cos α_n`) by span `dW/cos α_n`, by balls `dM sin α_M cos β_b/(c cos α_t)` (here from the exact inverse), by chord
//! `ds̄/cos ψ`, by constant chord `ds̄_c/cos² α_n`.

use super::super::cylindrical::involute::InvoluteGear;
use super::estimate::Estimate;
use crate::base::code::Code;
use crate::base::error::Error;

/// Method of the tooth-thickness measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ThicknessMethod {
    /// Span over so many teeth, of an internal gear over so many spaces.
    Span(u32),
    /// Over two balls, or pins, of a diameter; of an internal gear between them.
    Balls(f64),
    /// Chord at the reference cylinder, set below a tip cylinder of this diameter.
    Chord(f64),
    /// Constant chord, set below a tip cylinder of this diameter.
    ConstantChord(f64),
}

/// Nominal gauge reading of a tooth, and the gauge setting below the tip (chords only).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NominalReading {
    /// Size.
    pub size: f64,
    /// Height below the tip cylinder.
    pub height: Option<f64>,
}

impl ThicknessMethod {
    /// Nominal gauge reading of a tooth without backlash.
    ///
    /// # Errors
    /// `OutOfRange`: a size this gear does not have.
    pub fn nominal(self, gear: &InvoluteGear) -> Result<NominalReading, Error> {
        let s = gear.nominal_thickness();
        let (size, height) = match self {
            ThicknessMethod::Span(k) => (gear.span(k, s), None),
            ThicknessMethod::Balls(ball) => (gear.dimension_over_balls(ball, s), None),
            ThicknessMethod::Chord(tip) => {
                let (chord, height) = gear.chordal_thickness(tip, s);
                (chord, Some(height))
            }
            ThicknessMethod::ConstantChord(tip) => {
                let (chord, height) = gear.constant_chord(tip, s);
                (chord, Some(height))
            }
        };
        let sensible = match self {
            // Anvils are flat: the hollow flanks of an internal helical gear they touch at their edges.
            ThicknessMethod::Span(_) if gear.internal && gear.helix != 0.0 => false,
            ThicknessMethod::Span(k) => k >= 1 && k <= gear.teeth && self.is_measurable(gear, size),
            _ => size.is_finite() && size > 0.0 && height.is_none_or(|h| h > 0.0),
        };
        match sensible {
            true => Ok(NominalReading { size, height }),
            false => Err(self.refusal(gear)),
        }
    }

    /// Anvils k teeth apart touch flanks outside the base circle and within a module or two of the reference cylinder.
    fn is_measurable(self, gear: &InvoluteGear, size: f64) -> bool {
        let base_helix = (gear.helix.sin() * gear.pressure_angle.cos()).asin();
        let touch = gear.base_diameter().hypot(size * base_helix.cos());
        (touch - gear.reference_diameter()).abs()
            < 2.0 * (2.0 + gear.profile_shift.abs()) * gear.module
    }

    fn refusal(self, gear: &InvoluteGear) -> Error {
        let (what, hint) = match self {
            ThicknessMethod::Span(_) if gear.internal && gear.helix != 0.0 => (
                "an internal helical gear has no span".to_string(),
                "measure between balls: kind = \"balls\"".to_string(),
            ),
            ThicknessMethod::Span(k) if gear.internal => (
                format!("a span over {k} spaces does not touch the flanks of this gear"),
                format!("over {} spaces it does", gear.default_span_teeth()),
            ),
            ThicknessMethod::Span(k) => (
                format!("a span over {k} teeth does not touch the flanks of this gear"),
                format!("over {} teeth it does", gear.default_span_teeth()),
            ),
            ThicknessMethod::Balls(ball) => (
                format!(
                    "a ball of {:.4} mm does not lie on the flanks of this gear",
                    1e3 * ball
                ),
                format!("about {:.1} mm does", 1.7e3 * gear.module),
            ),
            ThicknessMethod::Chord(_) | ThicknessMethod::ConstantChord(_) => (
                "the tip cylinder is too small for the chord".to_string(),
                match gear.internal {
                    false => "give `tip_diameter`, above the reference diameter",
                    true => "give `tip_diameter`, below the reference diameter",
                }
                .to_string(),
            ),
        };
        Error::new(Code::OutOfRange, what).with_hint(hint)
    }

    /// The thickness deviation that a reading tells; `std`: the reading's standard uncertainty.
    ///
    /// # Errors
    /// Those of [`ThicknessMethod::nominal`]; `NotANumber`: a reading that is not finite; `OutOfRange`: one no such gear has.
    pub fn thickness_deviation(
        self,
        gear: &InvoluteGear,
        reading: f64,
        std: Option<f64>,
    ) -> Result<Estimate, Error> {
        let nominal = self.nominal(gear)?.size;
        if !reading.is_finite() {
            let message = "a reading of tooth thickness is missing or not a number";
            return Err(Error::new(Code::NotANumber, message));
        }
        let less = reading - nominal;
        if less.abs() > gear.module {
            let message = format!(
                "a reading is {:.4} mm (nominal {:.4} mm)",
                1e3 * reading,
                1e3 * nominal
            );
            return Err(Error::new(Code::OutOfRange, message).with_hint(
                "they differ by more than a module: check the unit, the number of teeth spanned, the size of the ball",
            ));
        }
        let (value, gain) = match self {
            ThicknessMethod::Span(_) => {
                let gain = 1.0 / gear.pressure_angle.cos();
                let sense = if gear.internal { -1.0 } else { 1.0 };
                (sense * less * gain, gain)
            }
            ThicknessMethod::ConstantChord(_) => {
                let gain = gear.pressure_angle.cos().powi(-2);
                (less * gain, gain)
            }
            ThicknessMethod::Chord(_) => {
                let half = gear.nominal_thickness() * gear.helix.cos().powi(3)
                    / (f64::from(gear.teeth) * gear.module);
                let gain = 1.0 / half.cos();
                (less * gain, gain)
            }
            ThicknessMethod::Balls(ball) => {
                let at =
                    |over: f64| gear.thickness_from_balls(ball, over) - gear.nominal_thickness();
                // The inverse is smooth; a step of a millionth of a module leaves ten digits of its slope's leading ones.
                let step = 1e-6 * gear.module;
                let slope = (at(reading + step) - at(reading - step)) / (2.0 * step);
                (at(reading), slope.abs())
            }
        };
        match value.is_finite() {
            true => Ok(Estimate::new(value, gain, std)),
            false => Err(self.refusal(gear)),
        }
    }
}
