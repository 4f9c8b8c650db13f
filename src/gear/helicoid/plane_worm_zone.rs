//! Contact zone of a plane-generated worm pair: both contact lines, the limit curve between plane and enveloped zone, undercut.

use std::f64::consts::{FRAC_PI_2, PI};

use super::plane_worm::{PlaneWorm, PlaneWormContact};
use crate::numeric::sorting::sort_ascending;

/// Intervals of a contact line over the face width, and of the limit curve over the wheel rotation.
const ROWS: u32 = 120;
/// Intervals of the generating rotation, over one revolution of the worm, for a contact line of the enveloped zone.
const GENERATING_INTERVALS: u32 = 600;
/// Intervals over the face width in the search for wheel rotations with contact.
const COARSE_ROWS: u32 = 40;
/// Wheel rotations in each direction, over 90°, at which contact is searched.
const TURNS: i32 = 360;

/// Dimensions of worm and wheel that bound their contact; lengths in the unit of [`PlaneWorm`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneWormZone {
    /// Length of the worm.
    pub length: f64,
    /// Face width of the wheel.
    pub face_width: f64,
    /// Tip radius of the worm in its throat; the tip surface is a torus about the wheel axis.
    pub worm_tip_radius: f64,
    /// Tip radius of the wheel.
    pub wheel_tip_radius: f64,
}

impl PlaneWormZone {
    /// Whether a contact lies within the dimensions of worm and wheel.
    pub fn contains(&self, pair: &PlaneWorm, contact: &PlaneWormContact) -> bool {
        let ring_radius = f64::hypot(
            pair.centre_distance - contact.worm_radius(),
            contact.point.z,
        );
        contact.point.z.abs() <= 0.5 * self.length
            && contact.point.y.abs() <= 0.5 * self.face_width
            && ring_radius >= pair.centre_distance - self.worm_tip_radius
            && contact.wheel_radius() <= self.wheel_tip_radius
    }

    /// Whether a contact within the dimensions touches from outside (negative relative curvature), so that the worm has a flank there.
    fn is_flank_contact(&self, pair: &PlaneWorm, contact: &PlaneWormContact) -> bool {
        contact.relative_curvature < 0.0 && self.contains(pair, contact)
    }

    /// First and last wheel rotation with contact on the plane zone, rad; `None` without contact.
    pub fn turns(&self, pair: &PlaneWorm) -> Option<[f64; 2]> {
        let turns = (-TURNS..=TURNS).map(|k| FRAC_PI_2 * f64::from(k) / f64::from(TURNS));
        let mut in_contact = turns.filter(|wheel_turn| {
            let line = pair.generating_line(*wheel_turn);
            let mut contacts = self
                .eta_values(COARSE_ROWS)
                .filter_map(|eta| line.first_contact(eta));
            contacts.any(|contact| self.is_flank_contact(pair, &contact))
        });
        let first = in_contact.next()?;
        Some([first, in_contact.next_back().unwrap_or(first)])
    }

    /// Contact line on the plane zone at a wheel rotation, rad.
    pub fn first_line(&self, pair: &PlaneWorm, wheel_turn: f64) -> Vec<PlaneWormContact> {
        let line = pair.generating_line(wheel_turn);
        (self.eta_values(ROWS))
            .filter_map(|eta| line.first_contact(eta))
            .filter(|contact| self.is_flank_contact(pair, contact))
            .collect()
    }

    /// Contact line on the enveloped zone at a wheel rotation, rad, sorted by η.
    pub fn second_line(&self, pair: &PlaneWorm, wheel_turn: f64) -> Vec<PlaneWormContact> {
        let line = pair.generating_line(wheel_turn);
        let half_turn = pair.ratio * PI;
        let mut line: Vec<PlaneWormContact> = uniform_grid(GENERATING_INTERVALS)
            .filter_map(|share| line.second_contact(wheel_turn + half_turn * share))
            .filter(|contact| self.is_flank_contact(pair, contact))
            .collect();
        sort_ascending(&mut line, |a| a.in_wheel.y);
        line
    }

    /// Limit curve between plane and enveloped zone over a range of wheel rotations, rad.
    pub fn limit(&self, pair: &PlaneWorm, [first, last]: [f64; 2]) -> Vec<PlaneWormContact> {
        let turns = (0..=ROWS).map(|k| first + (last - first) * f64::from(k) / f64::from(ROWS));
        turns
            .map(|phi| pair.generating_line(phi))
            .filter_map(|line| line.first_contact(line.limit()?[1]))
            .filter(|contact| self.contains(pair, contact))
            .collect()
    }

    /// Edge of regression of the worm on the contact line at a wheel rotation, rad; `None` where it lies outside the dimensions.
    pub fn undercut(&self, pair: &PlaneWorm, wheel_turn: f64) -> Option<PlaneWormContact> {
        let line = pair.generating_line(wheel_turn);
        let contact = line.first_contact(line.undercut()?)?;
        self.contains(pair, &contact).then_some(contact)
    }

    /// Uniform coordinates η over the face width.
    fn eta_values(&self, intervals: u32) -> impl Iterator<Item = f64> + use<> {
        let half = 0.5 * self.face_width;
        uniform_grid(intervals).map(move |x| half * x)
    }
}

/// Uniform grid on [−1, 1].
fn uniform_grid(intervals: u32) -> impl Iterator<Item = f64> {
    (0..=intervals).map(move |k| 2.0 * f64::from(k) / f64::from(intervals) - 1.0)
}
