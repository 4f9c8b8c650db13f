//! Zone where a cylindrical worm and its wheel can touch: lines of contact in it, limits of both kinds.

use std::f64::consts::FRAC_PI_2;

use super::worm_pair::{WormContact, WormPair};
use crate::numeric::sorting::sort_ascending;

/// Radii of a line of contact.
const ROWS: usize = 40;
/// Azimuths and radii of a limit curve.
const LIMIT_POINTS: usize = 48;

/// The part of space where a worm and its wheel can touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WormZone {
    /// Least and greatest radius of the worm: tip of the wheel's throat, tip of the worm.
    pub radii: [f64; 2],
    /// Length of the worm.
    pub length: f64,
    /// Face width of the wheel.
    pub face_width: f64,
    /// Outer radius of the wheel.
    pub outer_radius: f64,
}

/// A line of contact.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactLine {
    /// Turn of the worm, rad.
    pub worm_turn: f64,
    /// Points, in the order of the azimuth.
    pub points: Vec<WormContact>,
}

impl ContactLine {
    /// Connected pieces of the line: between two points of the wheel's throat, at this distance from the worm's axis, it lies outside the wheel.
    pub fn pieces(&self, throat: f64) -> impl Iterator<Item = &[WormContact]> {
        (self.points).chunk_by(move |a, b| [a.radius, b.radius] != [throat; 2])
    }
}

impl WormZone {
    /// Whether a contact lies in the zone and does not cut into the wheel: its relative curvature is negative, as D is.
    pub fn holds(&self, contact: &WormContact) -> bool {
        self.reaches(contact) && contact.undercut < 0.0
    }

    /// Whether a place lies in the zone, on whichever side of a limit.
    pub fn reaches(&self, contact: &WormContact) -> bool {
        contact.from_wheel.z.abs() <= 0.5 * self.length
            && contact.from_wheel.y.abs() <= 0.5 * self.face_width
            && (self.radii[0]..=self.radii[1]).contains(&contact.radius)
            && contact.wheel_radius() <= self.outer_radius
    }

    /// Radius at a share of the height.
    fn radius(&self, share: f64) -> f64 {
        self.radii[0] + share * (self.radii[1] - self.radii[0])
    }

    /// First and last turn of the worm at which a flank touches in the zone, rad; none where it never touches.
    ///
    /// The field is sampled at 60 radii and 240 azimuths.
    pub fn turns(&self, pair: &WormPair) -> Option<[f64; 2]> {
        const RADII: usize = 60;
        const AZIMUTHS: usize = 240;
        let mut turns: Option<[f64; 2]> = None;
        for j in 0..=RADII {
            let radius = self.radius(j as f64 / RADII as f64);
            let widest = (0.5 * self.face_width / radius).min(1.0).asin();
            for k in 0..=AZIMUTHS {
                let azimuth = widest * (2.0 * k as f64 / AZIMUTHS as f64 - 1.0);
                let contact = pair.contact(radius, azimuth).filter(|c| self.holds(c));
                let Some(turn) = contact.map(|c| c.worm_turn) else {
                    continue;
                };
                let [first, last] = turns.unwrap_or([turn; 2]);
                turns = Some([first.min(turn), last.max(turn)]);
            }
        }
        turns
    }

    /// The line of contact of one tooth at a turn of the worm.
    pub fn line(&self, pair: &WormPair, worm_turn: f64) -> ContactLine {
        let mut points: Vec<WormContact> = (0..=ROWS)
            .map(|j| self.radius(j as f64 / ROWS as f64))
            .flat_map(|radius| {
                let azimuths = pair.line(worm_turn, radius);
                azimuths
                    .into_iter()
                    .filter_map(move |azimuth| pair.contact(radius, azimuth))
            })
            .filter(|contact| self.holds(contact))
            .collect();
        sort_ascending(&mut points, |a| a.azimuth);
        ContactLine { worm_turn, points }
    }

    /// Lines of contact of one tooth between two turns of the worm, at whole multiples of a step.
    pub fn lines(&self, pair: &WormPair, turns: [f64; 2], step: f64) -> Vec<ContactLine> {
        let [first, last] = [(turns[0] / step).ceil(), (turns[1] / step).floor()];
        (first as i64..=last as i64)
            .map(|k| self.line(pair, k as f64 * step))
            .filter(|line| !line.points.is_empty())
            .collect()
    }

    /// The limit of the first kind in the zone, over the azimuth.
    pub fn undercut(&self, pair: &WormPair) -> Vec<WormContact> {
        self.limit(|share| {
            let azimuth = FRAC_PI_2 * (2.0 * share - 1.0);
            pair.contact(pair.undercut(azimuth, self.radii)?, azimuth)
        })
    }

    /// The limit of the second kind in the zone, over the radius.
    pub fn second_limit(&self, pair: &WormPair) -> Vec<WormContact> {
        self.limit(|share| {
            let radius = self.radius(share);
            pair.contact(radius, pair.second_limit(radius)?)
        })
    }

    fn limit(&self, at: impl Fn(f64) -> Option<WormContact>) -> Vec<WormContact> {
        (0..=LIMIT_POINTS)
            .filter_map(|k| at(k as f64 / LIMIT_POINTS as f64))
            .filter(|contact| self.reaches(contact))
            .collect()
    }

    /// The first of some moves of the wheel away from the worm, with its throat, at which no limit of the first kind lies in the zone.
    pub fn free_of_undercut(
        &self,
        pair: &WormPair,
        mut moves: impl Iterator<Item = f64>,
    ) -> Option<f64> {
        moves.find(|by| {
            let moved = WormPair {
                centre_distance: pair.centre_distance + by,
                ..*pair
            };
            let zone = WormZone {
                outer_radius: self.outer_radius + by,
                ..*self
            };
            zone.undercut(&moved).is_empty()
        })
    }
}
