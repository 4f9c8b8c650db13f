//! Zone where an hourglass worm and its wheel touch: both lines of contact in it, the curve between both parts of the tooth, undercut.

use std::f64::consts::{FRAC_PI_2, PI};

use super::plane_worm::{PlaneWorm, PlaneWormContact};
use crate::numeric::sorting::sort_rising;

/// Points of a line across the tooth, and of the curve between both parts.
const ROWS: u32 = 120;
/// Generating turns, over a turn of the worm, of the points of a second line.
const GENERATING_TURNS: u32 = 600;
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
            let line = pair.generating_line(*turn);
            let mut contacts = self
                .places(COARSE_ROWS)
                .filter_map(|eta| line.first_contact(eta));
            contacts.any(|contact| self.holds(pair, &contact))
        });
        let first = touching.next()?;
        Some([first, touching.next_back().unwrap_or(first)])
    }

    /// The line of contact of the plane part at a turn of the wheel.
    pub fn first_line(&self, pair: &PlaneWorm, wheel_turn: f64) -> Vec<PlaneWormContact> {
        let line = pair.generating_line(wheel_turn);
        (self.places(ROWS))
            .filter_map(|eta| line.first_contact(eta))
            .filter(|contact| self.holds(pair, contact))
            .collect()
    }

    /// The line of contact of the enveloped part at the same turn.
    pub fn second_line(&self, pair: &PlaneWorm, wheel_turn: f64) -> Vec<PlaneWormContact> {
        let line = pair.generating_line(wheel_turn);
        let half_turn = pair.ratio * PI;
        let mut line: Vec<PlaneWormContact> = shares(GENERATING_TURNS)
            .filter_map(|share| line.second_contact(wheel_turn + half_turn * share))
            .filter(|contact| self.holds(pair, contact))
            .collect();
        sort_rising(&mut line, |a| a.in_wheel.y);
        line
    }

    /// The curve between the plane part and the enveloped part, over turns of the wheel.
    pub fn limit(&self, pair: &PlaneWorm, [first, last]: [f64; 2]) -> Vec<PlaneWormContact> {
        let turns = (0..=ROWS).map(|k| first + (last - first) * f64::from(k) / f64::from(ROWS));
        turns
            .map(|turn| pair.generating_line(turn))
            .filter_map(|line| line.first_contact(line.limit()?[1]))
            .filter(|contact| self.reaches(pair, contact))
            .collect()
    }

    /// The worm's edge of regression on the line of a turn of the wheel, where it lies on the teeth.
    pub fn undercut(&self, pair: &PlaneWorm, wheel_turn: f64) -> Option<PlaneWormContact> {
        let line = pair.generating_line(wheel_turn);
        let contact = line.first_contact(line.undercut()?)?;
        self.reaches(pair, &contact).then_some(contact)
    }

    /// Places η across the tooth.
    fn places(&self, rows: u32) -> impl Iterator<Item = f64> + use<> {
        let half = 0.5 * self.face_width;
        shares(rows).map(move |share| half * share)
    }
}

/// Equal steps from −1 to 1.
fn shares(steps: u32) -> impl Iterator<Item = f64> {
    (0..=steps).map(move |k| 2.0 * f64::from(k) / f64::from(steps) - 1.0)
}
