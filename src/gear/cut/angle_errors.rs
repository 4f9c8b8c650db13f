//! Angle errors of a generator during the cut: harmonics of its chain and histories of its spindles, over the cradle's turn φ_c.

use crate::gear::kernel::law::Law;

/// An angle error over φ_c.
#[derive(Debug, Clone)]
pub struct AngleError {
    /// The error, rad.
    pub law: Law,
    /// Bound of its size, rad.
    pub bound: f64,
}

/// Angle errors of the rotating parts of a generator, rad, each ahead in the sense of its own turn.
#[derive(Debug, Clone, Default)]
pub struct AngleErrors {
    /// Errors of the cradle.
    pub cradle: Vec<AngleError>,
    /// Errors of the work.
    pub work: Vec<AngleError>,
    /// Errors of the cutter.
    pub cutter: Vec<AngleError>,
}

impl AngleError {
    /// The harmonic `amplitude cos(order φ_c + phase)`, `order` in cycles for 2π of the cradle.
    pub fn harmonic(amplitude: f64, order: f64, phase: f64) -> AngleError {
        AngleError {
            law: Law::Cosine {
                amplitude,
                order,
                phase,
            },
            bound: amplitude.abs(),
        }
    }

    /// Readings at rising φ_c, joined by straight lines and held beyond both ends; none of fewer than two.
    pub fn readings(places: Vec<f64>, errors: Vec<f64>) -> Option<AngleError> {
        if places.len() < 2 || places.len() != errors.len() {
            return None;
        }
        let bound = errors.iter().fold(0.0, |most: f64, e| most.max(e.abs()));
        let law = Law::function(move |x| {
            let after = places.partition_point(|place| *place < x);
            let (Some(b), Some(a)) = (places.get(after), after.checked_sub(1)) else {
                return [errors[after.min(errors.len() - 1)], 0.0, 0.0];
            };
            let slope = (errors[after] - errors[a]) / (b - places[a]);
            [errors[a] + slope * (x - places[a]), slope, 0.0]
        });
        Some(AngleError { law, bound })
    }
}

/// The sum of errors as a law.
pub(super) fn law(errors: &[AngleError]) -> Option<Law> {
    Law::sum(errors.iter().map(|e| e.law.clone()).collect())
}

/// Bound of the sum of errors, rad.
pub(super) fn bound(errors: &[AngleError]) -> f64 {
    errors.iter().map(|e| e.bound).sum()
}

impl AngleErrors {
    /// Laws of the errors of cradle and work.
    pub fn laws(&self) -> [Option<Law>; 2] {
        [law(&self.cradle), law(&self.work)]
    }
}
