//! Overlap of teeth away from the path of contact: places that touch before the contact that the path follows.
//!
//! The path is that of one contact. Where the ease-off falls again towards a corner, as by twist, the flanks meet there first; the ridges
//! of least gap show it.

use super::contact_path::ContactPath;
use super::pair::FlankPair;
use super::ridge::RidgeStations;

/// Stations along the face.
const STATIONS: usize = 17;
/// Positions of a pitch.
const POSITIONS: usize = 12;
/// Metal in common below this, m, is rounding of the ridges.
const ROUNDING: f64 = 5e-8;

/// The place at which teeth overlap most while the path of contact touches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// Angle of the pinion, rad.
    pub pinion_angle: f64,
    /// Shares of face and height of the pinion.
    pub shares: [f64; 2],
    /// Metal in common along the normal, m.
    pub depth: f64,
    /// Transmission error there beyond that of the path, rad.
    pub te: f64,
}

impl FlankPair {
    /// The deepest overlap over a pitch; none where every place stays behind the path.
    pub fn overlap(&self, path: &ContactPath) -> Option<Overlap> {
        let stations = RidgeStations::over_face(self, &path.reference, STATIONS);
        let step = self.pitch() / POSITIONS as f64;
        let overlaps = (0..POSITIONS).flat_map(|i| {
            let angle = path.reference.pinion_angle + step * i as f64;
            let leading = self.leading(path, angle).map(|leading| leading.te);
            let overlaps = leading.into_iter().flat_map(|te| {
                let ridges = stations.ridges(self, angle).into_iter();
                ridges.map(move |place| Overlap {
                    pinion_angle: angle,
                    shares: [place.face, place.height],
                    depth: place.arm * (place.te - te),
                    te: place.te - te,
                })
            });
            overlaps.collect::<Vec<_>>()
        });
        let deepest = overlaps.max_by(|a, b| a.depth.total_cmp(&b.depth))?;
        (deepest.depth > ROUNDING).then_some(deepest)
    }
}
