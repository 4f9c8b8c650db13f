//! Pitch readings of one side of the teeth: `f_i = p_i − p̄`, `F_i = Σ f_j`, `F_p = max F − min F`.
//!
//! Pitch i reaches from flank i to flank i + 1, the last back to the first. Taking the mean off is least squares over the pitch the
//! comparator was set to. With u the standard uncertainty of a reading, a sum over k pitches has `u √(k (z − k)/z)` by comparator and
//! `u √2` by index positions.

use super::estimate::{Estimate, check_finite};
use crate::base::code::Code;
use crate::base::error::Error;

/// Method of the pitch measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PitchMethod {
    /// Each pitch against one unknown setting: the relative method.
    Comparator,
    /// Each flank's place against an ideal division: the absolute method.
    Index,
}

/// Pitch deviations of one side of the teeth.
#[derive(Debug, Clone, PartialEq)]
pub struct PitchDeviations {
    /// f_i of every pitch, with the sum zero.
    pub single: Vec<f64>,
    /// F_i after every pitch, from the first flank; the last is zero.
    pub cumulative: Vec<f64>,
    /// Drift of the first flank when read again at the end; zero where it was not.
    pub drift: f64,
    method: PitchMethod,
    std: Option<f64>,
}

/// A value and the pitches it comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocatedDeviation {
    /// The value.
    pub estimate: Estimate,
    /// The first pitch, from 0.
    pub first: usize,
    /// The pitch after the last, from 0.
    pub end: usize,
}

impl PitchDeviations {
    /// Evaluates the readings of a gear with `teeth` teeth: as many readings, or by index one more, the first flank read again, whose
    /// drift is then taken off evenly. `std`: the standard uncertainty of one reading, independent of the others.
    ///
    /// # Errors
    /// `OutOfRange`: another count, fewer than three teeth. `NotANumber`: a reading that is not finite.
    pub fn new(
        readings: &[f64],
        method: PitchMethod,
        teeth: usize,
        std: Option<f64>,
    ) -> Result<PitchDeviations, Error> {
        if teeth < 3 {
            let message = format!("{teeth} teeth are too few for pitch deviations");
            return Err(
                Error::new(Code::OutOfRange, message).with_hint("at least 3 teeth are needed")
            );
        }
        let again = method == PitchMethod::Index && readings.len() == teeth + 1;
        if readings.len() != teeth && !again {
            let message = format!("{} pitch readings for {teeth} teeth", readings.len());
            let hint = match method {
                PitchMethod::Comparator => "give one reading per pitch",
                PitchMethod::Index => {
                    "give one reading per tooth; the first may be repeated at the end"
                }
            };
            return Err(Error::new(Code::OutOfRange, message).with_hint(hint));
        }
        check_finite(readings, "the pitches")?;
        let z = teeth as f64;
        let drift = if again {
            readings[teeth] - readings[0]
        } else {
            0.0
        };
        let single: Vec<f64> = match method {
            PitchMethod::Comparator => {
                let mean = readings.iter().sum::<f64>() / z;
                readings.iter().map(|p| p - mean).collect()
            }
            PitchMethod::Index => {
                let place = |i: usize| readings[i % teeth] - drift * (i % teeth) as f64 / z;
                (0..teeth).map(|i| place(i + 1) - place(i)).collect()
            }
        };
        let mut sum = 0.0;
        let mut cumulative: Vec<f64> = single
            .iter()
            .map(|f| {
                sum += f;
                sum
            })
            .collect();
        // The last differs from zero by rounding alone.
        if let Some(last) = cumulative.last_mut() {
            *last = 0.0;
        }
        Ok(PitchDeviations {
            single,
            cumulative,
            drift,
            method,
            std,
        })
    }

    /// Number of teeth.
    pub fn teeth(&self) -> usize {
        self.single.len()
    }

    /// Place of every flank against an ideal division through the first.
    pub fn flank_positions(&self) -> Vec<f64> {
        let z = self.teeth();
        (0..z).map(|i| self.cumulative[(i + z - 1) % z]).collect()
    }

    /// Standard uncertainty of a sum over `k` pitches.
    pub fn std_over(&self, k: usize) -> Option<f64> {
        let (z, k) = (self.teeth() as f64, (k % self.teeth()) as f64);
        let gain = match self.method {
            _ if k == 0.0 => 0.0,
            PitchMethod::Comparator => (k * (z - k) / z).sqrt(),
            PitchMethod::Index => std::f64::consts::SQRT_2,
        };
        self.std.map(|u| gain * u)
    }

    /// Standard uncertainty of the amplitude of the first order of the places.
    pub fn std_first_order(&self) -> Option<f64> {
        let z = self.teeth() as f64;
        let gain = match self.method {
            PitchMethod::Index => (2.0 / z).sqrt(),
            // Sums of readings: order 1 of them is that of the readings over 2 sin(π/z).
            PitchMethod::Comparator => (2.0 / z).sqrt() / (2.0 * (std::f64::consts::PI / z).sin()),
        };
        self.std.map(|u| gain * u)
    }

    /// f_p: the deviation of largest size, with its sign.
    pub fn single_pitch(&self) -> LocatedDeviation {
        self.span_deviation(1)
    }

    /// F_pk: the deviation over `k` pitches of largest size, with its sign, round the gear.
    pub fn span_deviation(&self, k: usize) -> LocatedDeviation {
        let z = self.teeth();
        let k = k.clamp(1, z - 1);
        let places = self.flank_positions();
        let over = |i: usize| match k {
            1 => self.single[i],
            _ => places[(i + k) % z] - places[i],
        };
        let first = arg_max_abs((0..z).map(over));
        LocatedDeviation {
            estimate: Estimate {
                value: over(first),
                std: self.std_over(k),
            },
            first,
            end: first + k,
        }
    }

    /// F_p: from the lowest to the highest place.
    pub fn cumulative_total(&self) -> LocatedDeviation {
        let places = self.flank_positions();
        let (low, high) = arg_min_max(&places);
        LocatedDeviation {
            estimate: Estimate {
                value: places[high] - places[low],
                std: self.std_over(high.abs_diff(low)),
            },
            first: low.min(high),
            end: low.max(high),
        }
    }

    /// f_u: the largest difference of neighbouring pitches.
    pub fn adjacent(&self) -> LocatedDeviation {
        let z = self.teeth();
        let difference = |i: usize| self.single[(i + 1) % z] - self.single[i];
        let first = arg_max_abs((0..z).map(difference));
        let gain = match self.method {
            PitchMethod::Comparator => 2f64.sqrt(),
            // 1, −2, 1; of three teeth the ends of the three places are still different.
            PitchMethod::Index => 6f64.sqrt(),
        };
        LocatedDeviation {
            estimate: Estimate::new(difference(first).abs(), gain, self.std),
            first,
            end: first + 2,
        }
    }
}

/// Default number of pitches of F_pk: z/8, at least 2.
pub fn default_span(teeth: usize) -> usize {
    (teeth / 8).max(2)
}

/// Indices of the lowest and the highest value; the first of equals.
pub(super) fn arg_min_max(values: &[f64]) -> (usize, usize) {
    let (mut low, mut high) = (0, 0);
    for (i, x) in values.iter().enumerate() {
        if *x < values[low] {
            low = i;
        }
        if *x > values[high] {
            high = i;
        }
    }
    (low, high)
}

/// Index of the value of largest size; the first of equals.
fn arg_max_abs(values: impl Iterator<Item = f64>) -> usize {
    let mut best = (0, -1.0);
    for (i, x) in values.enumerate() {
        if x.abs() > best.1 {
            best = (i, x.abs());
        }
    }
    best.0
}
