//! Both flanks of a bevel tooth: space width, thickness, top land.
//!
//! Flanks that one cutter leaves at once bound a space by themselves; flanks cut one after the other are turned against each other until
//! the mean normal thickness is met.

use std::f64::consts::TAU;

use super::blank::Blank;
use super::flank::{BevelFlank, ToothPoint};
use super::frames::WorkFrame;
use super::structure_elements::StructureElements;
use crate::gear::kernel::envelope::FlankPoint;
use crate::gear::kernel::vector::wrapped;

/// Index of the concave and of the convex flank.
pub const SIDES: [&str; 2] = ["concave", "convex"];

/// Columns along the face at which top lands are compared.
const COLUMNS: usize = 17;
/// Bisections of a height: its last interval is rounding.
const BISECTIONS: usize = 50;

/// A tooth with both flanks.
#[derive(Debug, Clone)]
pub struct BevelTooth {
    /// Concave and convex flank.
    pub flanks: [BevelFlank; 2],
    /// Parameters of their middles.
    middles: [[f64; 3]; 2],
    /// Number of teeth.
    pub teeth: u32,
    /// Azimuths of the flanks at the mean point as they are cut, rad.
    azimuths: [f64; 2],
    /// The flank whose space lies at growing azimuth.
    lower: usize,
    /// Angle of the space at the mean point, rad.
    mean_space: f64,
    /// `[z, radius]` of the mean point.
    mean_point: [f64; 2],
    /// Spiral angle at the mean point, rad.
    spiral_angle: f64,
}

/// The thinnest place of the top lands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TopLand {
    /// Share of the face.
    pub face: f64,
    /// Normal width, m; below zero where the flanks cross below the tip.
    pub width: f64,
    /// Share of the height at which the flanks meet; none where they do not.
    pub pointed_at: Option<f64>,
}

impl BevelTooth {
    /// The tooth of two flanks through the mean point of a blank; `thickness`, the mean normal one in m, turns the flanks against each
    /// other. None where a flank does not pass the mean point or both face the same way.
    pub fn new(
        flanks: [BevelFlank; 2],
        teeth: u32,
        blank: &Blank,
        thickness: Option<f64>,
    ) -> Option<BevelTooth> {
        let mean_point = blank.mean_point();
        let middles = [flanks[0].middle()?, flanks[1].middle()?];
        let points = [0, 1].map(|k| {
            let point = flanks[k].tooth_point(mean_point, middles[k])?.point;
            let (r, n) = (point.point.coordinates, point.normal.components);
            Some((r.y.atan2(r.x), r.x * n.y - r.y * n.x, point))
        });
        let [Some(a), Some(b)] = points else {
            return None;
        };
        let lower = match (a.1 > 0.0, b.1 > 0.0) {
            (true, false) => 0,
            (false, true) => 1,
            _ => return None,
        };
        let azimuths = [a.0, b.0];
        let cut = azimuths[1 - lower] - azimuths[lower];
        let pitch = TAU / f64::from(teeth);
        let spiral_angle = StructureElements::of(&a.2, blank.pitch_apex)?.spiral_angle;
        let mean_space = match thickness {
            Some(thickness) => pitch - thickness / (mean_point[1] * spiral_angle.cos()),
            None => cut.rem_euclid(pitch),
        };
        Some(BevelTooth {
            flanks,
            middles,
            teeth,
            azimuths,
            lower,
            mean_space,
            mean_point,
            spiral_angle,
        })
    }

    /// Pitch, rad.
    pub fn pitch(&self) -> f64 {
        TAU / f64::from(self.teeth)
    }

    /// The flanks of the tooth by growing azimuth: the one that has its space below it first.
    pub fn by_azimuth(&self) -> [usize; 2] {
        [1 - self.lower, self.lower]
    }

    /// A point of a flank of the tooth whose middle lies at the azimuth 0 of the mean point: the point and its azimuth.
    pub fn point(&self, flank: usize, place: [f64; 2]) -> Option<(ToothPoint, f64)> {
        let found = self.flanks[flank].tooth_point(place, self.middles[flank])?;
        Some((found, self.azimuth(flank, &found.point)))
    }

    /// A point of a flank as if the straight blade reached down to it, and its azimuth as in [`BevelTooth::point`].
    pub fn blade_point(
        &self,
        flank: usize,
        place: [f64; 2],
    ) -> Option<(FlankPoint<WorkFrame>, f64)> {
        let envelope = &self.flanks[flank].envelope;
        let found = envelope.point(envelope.on_circle(place, self.middles[flank])?)?;
        Some((found, self.azimuth(flank, &found)))
    }

    /// Azimuth of a flank's point in the tooth about the azimuth 0.
    fn azimuth(&self, flank: usize, point: &FlankPoint<WorkFrame>) -> f64 {
        let r = point.point.coordinates;
        let at_mean = self.azimuths[flank] - self.turn_to_cut(flank);
        at_mean + wrapped(r.y.atan2(r.x) - self.azimuths[flank])
    }

    /// Turn from the tooth about the azimuth 0 to a flank as its settings cut it, rad.
    pub fn turn_to_cut(&self, flank: usize) -> f64 {
        let half = 0.5 * (self.pitch() - self.mean_space);
        match flank == self.lower {
            true => self.azimuths[flank] - half,
            false => self.azimuths[flank] + half,
        }
    }

    /// Angle of the tooth at `[z, radius]`, rad; below zero beyond a point at which the flanks cross.
    pub fn angle(&self, place: [f64; 2]) -> Option<f64> {
        let [(_, low), (_, high)] = [
            self.point(1 - self.lower, place)?,
            self.point(self.lower, place)?,
        ];
        Some(high - low)
    }

    /// Normal thickness at `[z, radius]`, m, with the spiral angle of the mean point.
    pub fn normal_thickness(&self, place: [f64; 2]) -> Option<f64> {
        Some(self.angle(place)? * place[1] * self.spiral_angle.cos())
    }

    /// Transverse arcs of tooth and space at the mean point, m.
    pub fn mean_arcs(&self) -> [f64; 2] {
        [self.pitch() - self.mean_space, self.mean_space].map(|angle| angle * self.mean_point[1])
    }

    /// Mean normal thickness s_mn, m.
    pub fn mean_normal_thickness(&self) -> f64 {
        (self.pitch() - self.mean_space) * self.mean_point[1] * self.spiral_angle.cos()
    }

    /// The thinnest top land; none where the flanks do not reach the tip.
    pub fn top_land(&self) -> Option<TopLand> {
        let section = &self.flanks[0].section;
        let at = |i: usize| i as f64 / (COLUMNS - 1) as f64;
        let width = |face: f64, height: f64| self.normal_thickness(section.at(face, height));
        let lands = (0..COLUMNS).filter_map(|i| Some((at(i), width(at(i), 1.0)?)));
        let (face, width_at_tip) = lands.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let pointed_at = (width_at_tip <= 0.0).then(|| {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                match width(face, middle).is_some_and(|w| w <= 0.0) {
                    true => high = middle,
                    false => low = middle,
                }
            }
            high
        });
        Some(TopLand {
            face,
            width: width_at_tip,
            pointed_at,
        })
    }
}
