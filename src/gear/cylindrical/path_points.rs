//! Path of contact of a pair: its ends, the points A–E with diameters, roll angles and sliding, and contact ratios (ISO 21771-1:2024).

use std::f64::consts::PI;

use super::pair::Pair;
use super::path_of_contact::PathGeometry;
use crate::numeric::sorting::sort_ascending;

/// One point of the path of contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPoint {
    /// Distance from the pitch point along the path, positive after it, m.
    pub distance: f64,
    /// Length of roll on both gears, m.
    pub roll: [f64; 2],
    /// Diameter on both gears, m.
    pub diameter: [f64; 2],
    /// Roll angle ξ on both gears, rad.
    pub roll_angle: [f64; 2],
    /// Specific sliding ζ of both gears; −∞ where one of them rolls off its base circle.
    pub specific_sliding: [f64; 2],
    /// Sliding factor K_g: sliding velocity over pitch line velocity.
    pub sliding_factor: f64,
}

/// The points of the path in the order in which a driving gear passes them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPoints {
    /// Start of contact.
    pub a: PathPoint,
    /// The pair before leaves contact.
    pub b: PathPoint,
    /// Pitch point.
    pub c: PathPoint,
    /// The next pair comes into contact.
    pub d: PathPoint,
    /// End of contact.
    pub e: PathPoint,
}

impl PathPoints {
    /// The points of the path with their letters, in their order. Pairs touch alone between B and D, so both exist with a contact ratio
    /// from 1 to 2 only; C may lie outside the path.
    pub fn named(&self) -> Vec<(&'static str, PathPoint)> {
        let PathPoints { a, b, c, d, e } = *self;
        let is_between = |p: &PathPoint| a.distance <= p.distance && p.distance <= e.distance;
        let pitch = e.distance - b.distance;
        let alone = (1.0..=2.0).contains(&((e.distance - a.distance) / pitch));
        let mut points = vec![("A", a)];
        points.extend(alone.then_some(("B", b)));
        points.extend(is_between(&c).then_some(("C", c)));
        points.extend(alone.then_some(("D", d)));
        points.push(("E", e));
        sort_ascending(&mut points, |p| p.1.distance);
        points
    }
}

/// Contact ratios of a pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactRatios {
    /// ε_α.
    pub transverse: f64,
    /// ε_β.
    pub overlap: f64,
    /// ε_γ.
    pub total: f64,
}

impl Pair {
    /// The gears as their path of contact needs them; teeth end at the outlines' tips.
    pub fn path_geometry(&self) -> PathGeometry {
        PathGeometry {
            base: self.outlines.map(|o| o.base_radius),
            tip: self.outlines.map(|o| o.tip_radius),
            angle: self.working_pressure_angle,
            teeth: self.members[0].gear.teeth,
            internal: self.members[1].gear.internal,
        }
    }

    /// Lengths of the path before and beyond the pitch point, the first gear driving, m: tip to tip, no deeper than the form diameters.
    pub fn path_ends(&self) -> [f64; 2] {
        let geometry = self.path_geometry();
        let [c1, c2] = geometry.pitch_point();
        let [approach, recess] = geometry.ends();
        let [f1, f2] = self.outlines.map(|o| o.roll_length(o.form_radius));
        [approach.min(c1 - f1), recess.min(self.sense() * (c2 - f2))]
    }

    /// Length g_α of the path of contact, m; negative where the tips do not reach each other.
    pub fn path_length(&self) -> f64 {
        let [approach, recess] = self.path_ends();
        approach + recess
    }

    /// Contact ratios over the common face width.
    pub fn contact_ratios(&self) -> ContactRatios {
        let gear = &self.members[0].gear;
        let width = self.members[0].face_width.min(self.members[1].face_width);
        let transverse = self.path_length() / self.base_pitch();
        let overlap = width * gear.helix.sin().abs() / (PI * gear.module);
        ContactRatios {
            transverse,
            overlap,
            total: transverse + overlap,
        }
    }

    /// Point of the path at a distance from the pitch point, positive after it as the first gear drives.
    pub fn path_point(&self, distance: f64) -> PathPoint {
        let geometry = self.path_geometry();
        let [c1, c2] = geometry.pitch_point();
        // Rounding does not put an end of the path inside a base circle.
        let roll = [c1 + distance, c2 - self.sense() * distance].map(|roll| roll.max(0.0));
        let [z1, z2] = self.members.map(|m| f64::from(m.gear.teeth));
        let [rb1, rb2] = geometry.base;
        let [w1, w2] = self.working_diameters();
        PathPoint {
            distance,
            roll,
            diameter: [2.0 * rb1.hypot(roll[0]), 2.0 * rb2.hypot(roll[1])],
            roll_angle: [roll[0] / rb1, roll[1] / rb2],
            specific_sliding: [
                1.0 - z1 * roll[1] / (z2 * roll[0]),
                1.0 - z2 * roll[0] / (z1 * roll[1]),
            ],
            sliding_factor: distance.abs() * (2.0 / w1 + self.sense() * 2.0 / w2),
        }
    }

    /// Points A–E, the first gear driving.
    pub fn path_points(&self) -> PathPoints {
        let ([approach, recess], pitch) = (self.path_ends(), self.base_pitch());
        PathPoints {
            a: self.path_point(-approach),
            b: self.path_point(recess - pitch),
            c: self.path_point(0.0),
            d: self.path_point(pitch - approach),
            e: self.path_point(recess),
        }
    }

    /// Points A–E, the second gear driving: the same path backward.
    pub fn path_points_driven_by_second(&self) -> PathPoints {
        let PathPoints { a, b, c, d, e } = self.path_points();
        let backward = |point: PathPoint| PathPoint {
            distance: -point.distance,
            ..point
        };
        PathPoints {
            a: backward(e),
            b: backward(d),
            c,
            d: backward(b),
            e: backward(a),
        }
    }

    /// Active tip diameters d_Na, m.
    pub fn active_tip_diameters(&self) -> [f64; 2] {
        let PathPoints { a, e, .. } = self.path_points();
        [e.diameter[0], a.diameter[1]]
    }

    /// Active root diameters d_Nf, m.
    pub fn active_root_diameters(&self) -> [f64; 2] {
        let PathPoints { a, e, .. } = self.path_points();
        [a.diameter[0], e.diameter[1]]
    }
}
