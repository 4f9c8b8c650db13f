//! Radial run-out: `F_r = max r − min r`; from both sides' pitches `r_i = −S_i / (2 tan α_t)`, S_i the deviation of space i.

use std::f64::consts::TAU;

use super::estimate::{Estimate, check_finite};
use super::pitch::{PitchDeviations, arg_min_max};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::statistics::peak_to_peak;

/// Radial readings of a gear and what they say.
#[derive(Debug, Clone, PartialEq)]
pub struct Runout {
    /// Readings in space after space, positive outward.
    pub readings: Vec<f64>,
    /// F_r.
    pub range: Estimate,
    /// Amplitude of the first order, by least squares.
    pub eccentricity: Estimate,
    /// Phase of the maximum of the first order, rad from the first space.
    pub phase: f64,
    /// The mean of the readings.
    pub mean: f64,
    /// The range that is left without the first order.
    pub remainder: f64,
}

impl Runout {
    /// Mean and first order at every reading.
    pub fn first_order(&self) -> Vec<f64> {
        let n = self.readings.len();
        let wave =
            |i: usize| self.eccentricity.value * (TAU * i as f64 / n as f64 - self.phase).cos();
        (0..n).map(|i| self.mean + wave(i)).collect()
    }
}

/// From a ball (or anvil) set in every space; `std`: the standard uncertainty of one reading.
///
/// # Errors
/// `OutOfRange`: another count than teeth, fewer than three. `NotANumber`: a reading that is not finite.
pub fn from_ball(readings: &[f64], teeth: usize, std: Option<f64>) -> Result<Runout, Error> {
    if readings.len() != teeth || teeth < 3 {
        let message = format!("{} run-out readings for {teeth} teeth", readings.len());
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("give one reading per space, at least 3"));
    }
    check_finite(readings, "the run-out")?;
    let spread = std.map(|u| 2f64.sqrt() * u);
    let first = std.map(|u| (2.0 / teeth as f64).sqrt() * u);
    Ok(evaluate(readings.to_vec(), spread, first))
}

/// From the pitches of both sides; reading i of each belongs to the two flanks of space i, teeth counted so that a longer pitch moves
/// later flanks on. At the radius where pitches were read the transverse pressure angle is `angle`.
///
/// # Errors
/// `OutOfRange`: sides of different counts.
pub fn from_pitches(
    left: &PitchDeviations,
    right: &PitchDeviations,
    angle: f64,
) -> Result<Runout, Error> {
    let teeth = left.teeth();
    if right.teeth() != teeth {
        let message = format!(
            "{teeth} pitches on the left, {} on the right",
            right.teeth()
        );
        return Err(
            Error::new(Code::OutOfRange, message).with_hint("give the same number on both sides")
        );
    }
    let slope = 2.0 * angle.tan();
    let places = left
        .flank_positions()
        .into_iter()
        .zip(right.flank_positions());
    let readings: Vec<f64> = places.map(|(l, r)| (r - l) / slope).collect();
    let (low, high) = arg_min_max(&readings);
    let std = |k: usize| Some(left.std_over(k)?.hypot(right.std_over(k)?) / slope);
    let spread = std(high.abs_diff(low));
    let first = || Some(left.std_first_order()?.hypot(right.std_first_order()?) / slope);
    Ok(evaluate(readings, spread, first()))
}

fn evaluate(readings: Vec<f64>, spread: Option<f64>, first_order: Option<f64>) -> Runout {
    let n = readings.len() as f64;
    let angle = |i: usize| TAU * i as f64 / n;
    let (mut cosine, mut sine) = (0.0, 0.0);
    for (i, r) in readings.iter().enumerate() {
        cosine += 2.0 / n * r * angle(i).cos();
        sine += 2.0 / n * r * angle(i).sin();
    }
    let rest: Vec<f64> = readings
        .iter()
        .enumerate()
        .map(|(i, r)| r - cosine * angle(i).cos() - sine * angle(i).sin())
        .collect();
    Runout {
        range: Estimate {
            value: peak_to_peak(&readings),
            std: spread,
        },
        eccentricity: Estimate {
            value: cosine.hypot(sine),
            std: first_order,
        },
        phase: sine.atan2(cosine),
        mean: readings.iter().sum::<f64>() / n,
        remainder: peak_to_peak(&rest),
        readings,
    }
}
