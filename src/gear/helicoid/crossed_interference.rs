//! Interference of crossed involute gears off the path of contact: one flank against the other over their face widths.
//!
//! The involute helicoid through a point at azimuth θ, height z and radius `r_b/cos a` has the phase `σ (θ − z/p) + tan a − a`; a point that
//! lies in the metal is behind by the depth over `r_b cos β_b`.

use super::crossed_pair::{CrossedPair, CrossedPath};
use crate::gear::cylindrical::involute::inv;
use crate::gear::kernel::vector::{Vector, wrapped};

/// A point of the gear's flank in the metal of the pinion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossedInterference {
    /// Place of the contact on the path, from T₁.
    pub distance: f64,
    /// Distances of the point from both axes.
    pub radii: [f64; 2],
    /// Depth along the normal of the pinion's flank.
    pub depth: f64,
}

/// Contacts along the path.
const CONTACTS: u32 = 8;
/// Radii and heights of the gear's flank.
const PARTS: u32 = 24;

impl CrossedPair {
    /// The point of the gear's flank that lies deepest in the pinion while both flanks touch on the path; none where all depths are below
    /// `tolerance`.
    pub fn interference(
        &self,
        path: &CrossedPath,
        face_widths: [f64; 2],
        tolerance: f64,
    ) -> Option<CrossedInterference> {
        let [first, last] = path.ends_on_flanks();
        let places =
            (0..=CONTACTS).map(|k| first + (last - first) * f64::from(k) / f64::from(CONTACTS));
        let found = places.filter_map(|distance| {
            let at = path.tangent_points[0] + path.direction * distance;
            let phases = [self.phase(path, 0, at)?, self.phase(path, 1, at)?];
            let points = self.flank_points(path, phases[1], face_widths[1]);
            let depths = points.filter_map(|point| {
                let place = self.place(0, point);
                let inside = place.radius <= self.gears[0].tip_radius
                    && place.height.abs() <= 0.5 * face_widths[0];
                let behind = phases[0] - self.phase(path, 0, point)?;
                let depth = wrapped(behind) * path.advance;
                (inside && depth > tolerance).then(|| CrossedInterference {
                    distance,
                    radii: [place.radius, self.place(1, point).radius],
                    depth,
                })
            });
            depths.max_by(|a, b| a.depth.total_cmp(&b.depth))
        });
        found.max_by(|a, b| a.depth.total_cmp(&b.depth))
    }

    /// Points of the gear's flank of a phase over its face width, from the base cylinder to the tip.
    fn flank_points(
        &self,
        path: &CrossedPath,
        phase: f64,
        face_width: f64,
    ) -> impl Iterator<Item = Vector> {
        let gear = self.gears[1];
        let (axis, foot) = (self.second_axis(), Vector::X * self.centre_distance);
        let sense = self.sense(path, 1);
        let across = axis.cross(Vector::X);
        let share = |k: u32| f64::from(k) / f64::from(PARTS);
        let places = (1..=PARTS).flat_map(move |i| (0..=PARTS).map(move |j| [share(i), share(j)]));
        places.map(move |[up, along]| {
            let radius = gear.base_radius + up * (gear.tip_radius - gear.base_radius);
            let height = face_width * (along - 0.5);
            let azimuth =
                sense * (phase - involute(gear.base_radius, radius)) + height * gear.twist();
            let (sin, cos) = azimuth.sin_cos();
            foot + axis * height + (Vector::X * cos + across * sin) * radius
        })
    }

    /// Phase of the flank through a point; none within the base cylinder.
    pub(super) fn phase(&self, path: &CrossedPath, gear: usize, point: Vector) -> Option<f64> {
        let of = &self.gears[gear];
        let at = self.place(gear, point);
        let unwound = involute(of.base_radius, at.radius);
        let phase = self.sense(path, gear) * (at.azimuth - at.height * of.twist()) + unwound;
        phase.is_finite().then_some(phase)
    }

    /// Sense σ of the azimuth in which a gear's flank looks.
    pub(super) fn sense(&self, path: &CrossedPath, gear: usize) -> f64 {
        let axis = self.axis(gear);
        let foot = Vector::X * (gear as f64 * self.centre_distance);
        let outward = path.direction * [1.0, -1.0][gear];
        axis.cross(path.tangent_points[gear] - foot)
            .dot(outward)
            .signum()
    }

    /// Cylindrical coordinates of a point about the axis of a gear; azimuth from x.
    fn place(&self, gear: usize, point: Vector) -> Cylindrical {
        let axis = self.axis(gear);
        let r = point - Vector::X * (gear as f64 * self.centre_distance);
        let (x, y) = (r.x, axis.cross(Vector::X).dot(r));
        Cylindrical {
            radius: f64::hypot(x, y),
            azimuth: y.atan2(x),
            height: axis.dot(r),
        }
    }
}

/// Radius, azimuth and height about an axis.
struct Cylindrical {
    radius: f64,
    azimuth: f64,
    height: f64,
}

/// `inv a` with `cos a = r_b/r`.
pub(super) fn involute(base: f64, radius: f64) -> f64 {
    inv((base / radius).acos())
}
