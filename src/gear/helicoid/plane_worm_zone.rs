//! Zone where an hourglass worm and its wheel touch: both lines of contact in it, the curve between both parts of the tooth, undercut.

use std::f64::consts::FRAC_PI_2;

use super::plane_worm::{PlaneWorm, PlaneWormContact};
use crate::numeric::sorting::sort_rising;

/// Points of a line across the tooth, and of the curve between both parts.
const ROWS: u32 = 120;
/// Points across the tooth in the search for the turns of contact.
const COARSE_ROWS: u32 = 40;
/// Turns of the wheel each way, over 90°, at which contact is sought.
const TURNS: i32 = 360;

/// The sizes of worm and wheel that bound their contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneWormZone {
    /// Length of the worm.
    pub length: f64,
    /// Face width of the wheel.
    pub face_width: f64,
    /// Tip radius of the worm in its throat; its tip is a torus about the axis of the wheel.
    pub worm_tip_radius: f64,
    /// Tip radius of the wheel.
    pub wheel_tip_radius: f64,
}

impl PlaneWormZone {
    /// Whether a contact lies on worm and wheel.
    pub fn reaches(&self, pair: &PlaneWorm, contact: &PlaneWormContact) -> bool {
        let from_torus = f64::hypot(
            pair.centre_distance - contact.worm_radius(),
            contact.point.z,
        );
        contact.point.z.abs() <= 0.5 * self.length
            && contact.point.y.abs() <= 0.5 * self.face_width
            && from_torus >= pair.centre_distance - self.worm_tip_radius
            && contact.wheel_radius() <= self.wheel_tip_radius
    }

    /// Whether a contact lies on worm and wheel that touch from outside: the worm has a flank there.
    pub fn holds(&self, pair: &PlaneWorm, contact: &PlaneWormContact) -> bool {
        contact.relative_curvature < 0.0 && self.reaches(pair, contact)
    }

    /// First and last turn of the wheel at which the plane touches, rad; none where it never does.
    pub fn turns(&self, pair: &PlaneWorm) -> Option<[f64; 2]> {
        let places = (-TURNS..=TURNS).map(|k| FRAC_PI_2 * f64::from(k) / f64::from(TURNS));
        let mut touching = places.filter(|turn| {
            let mut line = self.places(COARSE_ROWS);
            line.any(|eta| {
                (pair.first_contact(*turn, eta)).is_some_and(|contact| self.holds(pair, &contact))
            })
        });
        let first = touching.next()?;
        Some([first, touching.next_back().unwrap_or(first)])
    }

    /// The line of contact of the plane part at a turn of the wheel.
    pub fn first_line(&self, pair: &PlaneWorm, wheel_turn: f64) -> Vec<PlaneWormContact> {
        let contacts = self.places(ROWS);
        contacts
            .filter_map(|eta| pair.first_contact(wheel_turn, eta))
            .filter(|contact| self.holds(pair, contact))
            .collect()
    }

    /// The line of contact of the enveloped part at the same turn.
    pub fn second_line(&self, pair: &PlaneWorm, wheel_turn: f64) -> Vec<PlaneWormContact> {
        let contacts = self.places(ROWS);
        let mut line: Vec<PlaneWormContact> = contacts
            .flat_map(|eta| pair.second_contacts(wheel_turn, eta))
            .filter(|contact| self.holds(pair, contact))
            .collect();
        sort_rising(&mut line, |a| a.in_wheel.y);
        line
    }

    /// The curve between the plane part and the enveloped part, over turns of the wheel.
    pub fn limit(&self, pair: &PlaneWorm, [first, last]: [f64; 2]) -> Vec<PlaneWormContact> {
        let turns = (0..=ROWS).map(|k| first + (last - first) * f64::from(k) / f64::from(ROWS));
        turns
            .filter_map(|turn| pair.first_contact(turn, pair.limit(turn)?[1]))
            .filter(|contact| self.reaches(pair, contact))
            .collect()
    }

    /// The worm's edge of regression on the line of a turn of the wheel, where it lies on the teeth.
    pub fn undercut(&self, pair: &PlaneWorm, wheel_turn: f64) -> Option<PlaneWormContact> {
        let half = 0.5 * self.face_width;
        let eta = pair.undercut(wheel_turn, [-half, half])?;
        let contact = pair.first_contact(wheel_turn, eta)?;
        self.reaches(pair, &contact).then_some(contact)
    }

    /// Places η across the tooth.
    fn places(&self, rows: u32) -> impl Iterator<Item = f64> + use<> {
        let half = 0.5 * self.face_width;
        (0..=rows).map(move |k| half * (2.0 * f64::from(k) / f64::from(rows) - 1.0))
    }
}
