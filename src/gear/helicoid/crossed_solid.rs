//! Crossed gears in space: the involute helicoids of both flanks, and the ellipse of each point of contact.

use std::f64::consts::TAU;

use super::crossed_interference::involute;
use super::crossed_pair::{CrossedContact, CrossedPair, CrossedPath};
use super::turning_pair::{
    CLEARANCE, ContactPosition, POSITIONS, Teeth, TurningMember, TurningPair,
};
use crate::gear::kernel::vector::Vector;

/// Points of an ellipse.
const AROUND: u32 = 24;
/// Radius of the bore, in root radii.
const BORE: f64 = 0.5;

impl CrossedPair {
    /// The pair over one pitch with its face widths, and ellipses under a coating of a thickness; none where a tooth is pointed.
    pub fn turning_pair(
        &self,
        path: &CrossedPath,
        face_widths: [f64; 2],
        coating: f64,
    ) -> Option<TurningPair> {
        let tips = [0, 1].map(|k| self.gears[k].tip_radius);
        let depth = tips[0] + tips[1] - self.centre_distance;
        let member = |k: usize| {
            let gear = self.gears[k];
            let (sense, root) = (
                self.sense(path, k),
                gear.tip_radius - (1.0 + CLEARANCE) * depth,
            );
            let axis = self.axis(k);
            let teeth = Teeth {
                count: gear.teeth,
                flank: |radius: f64, h: f64| {
                    let unwound = involute(gear.base_radius, radius);
                    let azimuth = h * gear.twist() - sense * unwound;
                    azimuth.is_finite().then_some(azimuth)
                },
                opposite_flank: -2.0 * sense * gear.base_half_angle,
                sense: -sense,
                ends: |_| [root, gear.tip_radius],
                bore: BORE * root,
                width: face_widths[k],
                steps: [12, 8, 3],
            };
            Some(TurningMember {
                teeth: gear.teeth,
                sector: teeth.sector()?,
                axes: [Vector::X, axis.cross(Vector::X), axis],
                centre: Vector::X * (k as f64 * self.centre_distance),
            })
        };
        let pitch = path.base_pitch;
        let [first, last] = path.ends_on_flanks();
        let position = |k: u32| {
            let place = first + pitch * f64::from(k) / f64::from(POSITIONS);
            let at = path.tangent_points[0] + path.direction * place;
            let phases = [self.phase(path, 0, at)?, self.phase(path, 1, at)?];
            let touching = (0..).map(|n| place + pitch * f64::from(n));
            let touching = touching.take_while(|place| *place <= last);
            let contacts = touching.filter_map(|place| self.contact(path, place));
            Some(ContactPosition {
                angles: [0, 1].map(|k| self.sense(path, k) * phases[k]),
                curves: contacts.map(|c| ellipse(&c, coating)).collect(),
            })
        };
        Some(TurningPair {
            members: [member(0)?, member(1)?],
            is_line_contact: false,
            facing: Some(path.direction),
            positions: (0..POSITIONS).filter_map(position).collect(),
        })
    }
}

/// Outline of the ellipse in the tangent plane.
fn ellipse(contact: &CrossedContact, coating: f64) -> Vec<Vector> {
    let [long, short] = contact.ellipse(coating);
    let [along, across] = contact.directions;
    let angles = (0..=AROUND).map(|k| TAU * f64::from(k) / f64::from(AROUND));
    let point = |a: f64| contact.point + along * (long * a.cos()) + across * (short * a.sin());
    angles.map(point).collect()
}
