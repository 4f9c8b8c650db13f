//! Slots between the teeth of a pair of blanks: slot widths, thicknesses, top lands from toe to heel, points of blades.
//!
//! AGMA 929-B22, Clause 4, both members generated, the wheel by spread blades; numbers in brackets are its equations. The minus sign of
//! (177) is that of its worked example.

use std::f64::consts::PI;

use super::edge_radii::EdgeRadii;
use super::iso23509::{BlankPair, cone_distance_on_wheel, milled_spiral_angle};
use crate::gear::cylindrical::involute::inv;

/// Slots of a pair along the face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slots {
    /// Slot widths W of pinion and wheel at toe, mean point and heel, m.
    pub widths: [[f64; 3]; 2],
    /// Normal circular thicknesses s_n at toe, mean point and heel, m.
    pub thicknesses: [[f64; 3]; 2],
    /// Normal top lands s_an at toe, mean point and heel, m; below zero where the tooth is pointed.
    pub top_lands: [[f64; 3]; 2],
    /// Points of finishing blades that cut both flanks of a slot, m.
    pub blade_points: [f64; 2],
    /// Largest edge radii of these blades.
    pub edge_radii: EdgeRadii,
}

/// A finishing blade overlaps the middle of the slot by this length (94), (95), m.
const OVERLAP: f64 = 0.025e-3;
/// Quantities that the places along the face share.
struct Pair<'a> {
    pair: &'a BlankPair,
    /// Cone distances R_m.
    mean: [f64; 2],
    /// Dedendum angles θ_f, rad.
    dedendum_angles: [f64; 2],
    /// Sum and half-angle of both pressure angles: tan α_D + tan α_C.
    tangents: f64,
    /// Mean normal pitch p_n.
    pitch: f64,
    /// Mean normal backlash in the pitch plane `p_n − s_mn1 − s_mn2`.
    play: f64,
    /// Mean slot width of the wheel W_m2.
    wheel_slot: f64,
}

impl Slots {
    /// The slots of a face-milled pair.
    pub fn of(pair: &BlankPair) -> Slots {
        let of = Pair::of(pair);
        let ends = pair.blanks.map(|b| b.cone_distances());
        let places = |k: usize| [ends[k][0], of.mean[k], ends[k][1]];
        let on_wheel = places(0).map(|r| of.on_wheel(r));
        let widths = [
            on_wheel.map(|r| of.pinion_slot(r)),
            places(1).map(|r| of.wheel_slot(r)),
        ];
        let thicknesses = [
            on_wheel.map(|r| of.pinion_thickness(r)),
            places(1).map(|r| of.wheel_thickness(r)),
        ];
        let three = [0, 1, 2];
        let top_lands = [0, 1].map(|k| {
            three.map(|j| {
                let addendum = of.dedendum(1 - k, of.on(1 - k, k, places(k)[j])) - pair.clearance;
                let wheel = [on_wheel, places(1)][k][j];
                let spiral = of.spiral_angle(k, wheel);
                let radius = places(k)[j] * pair.blanks[k].pitch_angle.tan() / spiral.cos().powi(2);
                top_land(radius, addendum, thicknesses[k][j], pair.pressure_angles)
            })
        });
        let least = widths.map(|w| w.into_iter().fold(f64::INFINITY, f64::min));
        let blade_points = least.map(|w| 0.5 * w + OVERLAP);
        let toe_dedenda = [0, 1].map(|k| of.dedendum(k, ends[k][0]));
        Slots {
            widths,
            thicknesses,
            top_lands,
            blade_points,
            edge_radii: EdgeRadii::of(pair, toe_dedenda, least, blade_points),
        }
    }
}

impl<'a> Pair<'a> {
    fn of(pair: &'a BlankPair) -> Pair<'a> {
        let [drive, coast] = pair.pressure_angles;
        let tangents = drive.tan() + coast.tan();
        let pitch = PI * pair.normal_module;
        let ([s1, s2], [f1, f2]) = (pair.thicknesses, pair.dedenda);
        // (64).
        let half = (0.5 * (drive + coast)).tan();
        let wheel_slot =
            pitch - s2 - 0.5 * (f1 + f2) * tangents - (pair.addenda[0] - pair.addenda[1]) * half;
        Pair {
            pair,
            mean: pair.blanks.map(|b| b.mean_cone_distance),
            dedendum_angles: pair.blanks.map(|b| b.pitch_angle - b.root_angle),
            tangents,
            pitch,
            play: pitch - s1 - s2,
            wheel_slot,
        }
    }

    /// Cone distance on the wheel of a place of the pinion (16).
    fn on_wheel(&self, r1: f64) -> f64 {
        cone_distance_on_wheel(self.mean[1], r1 - self.mean[0], self.pair.offset_angles[1])
    }

    /// Offset angle in the pitch plane at a cone distance of the wheel (33).
    fn offset_angle(&self, r2: f64) -> f64 {
        (self.mean[1] * self.pair.offset_angles[1].sin() / r2).asin()
    }

    /// Cone distance on a member of a place on another: (16), (55).
    fn on(&self, member: usize, from: usize, r: f64) -> f64 {
        match (member, from) {
            (1, 0) => self.on_wheel(r),
            (0, 1) => {
                let zeta = self.pair.offset_angles[1];
                self.mean[0] + r * self.offset_angle(r).cos() - self.mean[1] * zeta.cos()
            }
            _ => r,
        }
    }

    /// Spiral angle of a member at a cone distance of the wheel (22), (34).
    fn spiral_angle(&self, member: usize, r2: f64) -> f64 {
        let mean = [self.mean[1], self.pair.spiral_angles[1]];
        let wheel = milled_spiral_angle(self.pair.cutter_radius, mean, r2);
        match member {
            0 => wheel + self.offset_angle(r2),
            _ => wheel,
        }
    }

    /// Dedendum of a member at its cone distance (58), (60).
    fn dedendum(&self, member: usize, r: f64) -> f64 {
        let slope = self.dedendum_angles[member].tan();
        self.pair.dedenda[member] + (r - self.mean[member]) * slope
    }

    /// Normal pitch at a cone distance of the wheel over that at the mean point.
    fn pitch_share(&self, r2: f64) -> f64 {
        let mean = self.mean[1] * self.pair.spiral_angles[1].cos();
        r2 * self.spiral_angle(1, r2).cos() / mean
    }

    /// Slot width of the wheel (75).
    fn wheel_slot(&self, r2: f64) -> f64 {
        let share = self.pitch_share(r2);
        let at_mean = self.pair.thicknesses[0] - self.pair.dedenda[1] * self.tangents + self.play;
        self.wheel_slot * (1.0 - share) + share * at_mean
    }

    /// Slot width of the pinion at a cone distance of the wheel (76).
    fn pinion_slot(&self, r2: f64) -> f64 {
        let share = self.pitch_share(r2);
        let depth = self.dedendum(0, self.on(0, 1, r2)) + self.dedendum(1, r2);
        share * (self.pitch + self.play) - depth * self.tangents - self.wheel_slot(r2)
    }

    /// Normal circular thickness of the pinion at a cone distance of the wheel (177).
    fn pinion_thickness(&self, r2: f64) -> f64 {
        self.dedendum(1, r2) * self.tangents + self.wheel_slot(r2)
            - self.pitch_share(r2) * self.play
    }

    /// Normal circular thickness of the wheel (178).
    fn wheel_thickness(&self, r2: f64) -> f64 {
        let dedendum = self.dedendum(0, self.on(0, 1, r2));
        dedendum * self.tangents + self.pinion_slot(r2) - self.pitch_share(r2) * self.play
    }
}

/// Top land of a tooth of involute flanks in the normal section (166)–(181).
fn top_land(radius: f64, addendum: f64, thickness: f64, pressure_angles: [f64; 2]) -> f64 {
    let tip = radius + addendum;
    let narrowing = pressure_angles.map(|alpha| {
        let at_tip = (radius * alpha.cos() / tip).acos();
        inv(alpha) - inv(at_tip)
    });
    (thickness / radius + narrowing[0] + narrowing[1]) * tip
}
