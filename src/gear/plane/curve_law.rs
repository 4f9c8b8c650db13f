//! The turn of the mate of a given pitch curve: `φ₂ = ∫ r₁/(a − r₁) dφ₁`.

use std::f64::consts::TAU;

use super::pitch_curve::{PitchCurve, millimetres, out_of_range};
use crate::base::error::Error;
use crate::numeric::quadrature::CumulativeIntegral;

/// A pitch curve of gear 1 at a centre distance.
#[derive(Debug)]
pub(super) struct CurveLaw {
    pub(super) curve: PitchCurve,
    /// Centre distance, m.
    pub(super) centre_distance: f64,
    /// Start of the integral over a turn.
    first: f64,
    turn: CumulativeIntegral,
}

impl CurveLaw {
    /// Refuses a centre distance that does not exceed the largest radius.
    pub(super) fn new(curve: &PitchCurve, centre_distance: f64) -> Result<CurveLaw, Error> {
        let ends = curve.panel_ends();
        let radii = ends.iter().map(|x| curve.at(*x)[0]);
        let largest = radii.fold(0.0, f64::max);
        if !(centre_distance > largest && centre_distance.is_finite()) {
            return Err(out_of_range(format!(
                "centre distance {} does not exceed the largest radius {} of the pitch curve",
                millimetres(centre_distance),
                millimetres(largest)
            )));
        }
        Ok(CurveLaw {
            curve: curve.clone(),
            centre_distance,
            first: ends[0],
            turn: CumulativeIntegral::new(|x| rate(curve, centre_distance, x), ends),
        })
    }

    /// Turn of the mate (rad) from the start of the table to an angle of gear 1.
    pub(super) fn angle_2(&self, angle_1: f64) -> f64 {
        let turns = ((angle_1 - self.first) / TAU).floor();
        let rate = |x: f64| rate(&self.curve, self.centre_distance, x);
        turns * self.turn.total() + self.turn.at(rate, angle_1 - turns * TAU)
    }
}

fn rate(curve: &PitchCurve, centre_distance: f64, angle_1: f64) -> f64 {
    let r = curve.at(angle_1)[0];
    r / (centre_distance - r)
}
