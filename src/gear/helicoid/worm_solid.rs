//! Worm and wheel in space: the thread by its transverse sections, the wheel's tooth by its sections y = constant, the lines of contact.
//!
//! On a section the contact is explicit in the distance `u = ρ cos ψ` from the worm's axis; the wheel's flank at a radius is a root in u.

use std::f64::consts::{PI, TAU};

use super::turning_pair::{
    CLEARANCE, ContactPosition, POSITIONS, Teeth, TurningMember, TurningPair,
};
use super::worm_pair::{WormContact, WormPair};
use super::worm_zone::WormZone;
use crate::gear::bevel::solid::Sector;
use crate::gear::kernel::root::sign_change;
use crate::gear::kernel::vector::Vector;

/// Rim of the wheel below its root, in working depths.
pub(super) const RIM: f64 = 1.5;
/// Least radius of the bore of a wheel, of its root.
pub(super) const LEAST_BORE: f64 = 0.3;
/// Steps of a turn of the thread.
const STEPS_OF_TURN: f64 = 30.0;
/// Most steps along the worm.
pub(super) const MOST_SLICES: f64 = 120.0;
/// Every so many points of a line of contact are shown.
const SHOWN: usize = 4;

/// Axes of the wheel: x, z and the axis along −y, about which it turns by `i φ`.
const WHEEL_AXES: [Vector; 3] = [Vector::X, Vector::Z, Vector::new(0.0, -1.0, 0.0)];

/// A worm about z and its wheel at a centre distance, each by its sector, with the lines of contact of the moment.
pub(super) fn worm_and_wheel(
    [worm, wheel]: [Sector; 2],
    teeth: [u32; 2],
    centre_distance: f64,
    positions: Vec<ContactPosition>,
) -> TurningPair {
    TurningPair {
        members: [
            TurningMember {
                teeth: teeth[0],
                sector: worm,
                axes: [Vector::X, Vector::Y, Vector::Z],
                centre: Vector::ZERO,
            },
            TurningMember {
                teeth: teeth[1],
                sector: wheel,
                axes: WHEEL_AXES,
                centre: Vector::X * centre_distance,
            },
        ],
        is_line_contact: true,
        facing: None,
        positions,
    }
}

impl WormPair {
    /// The pair without backlash over one pitch of a worm of some starts and a wheel of some teeth; none where a flank does not reach its tip.
    pub fn turning_pair(&self, zone: &WormZone, [starts, teeth]: [u32; 2]) -> Option<TurningPair> {
        let (a, p) = (self.centre_distance, self.worm.lead);
        let [low, tip] = zone.radii;
        let clearance = CLEARANCE * (tip - low);
        // Threads as thick as spaces on the pitch cylinder.
        let reference = self.worm_pitch_radius().clamp(low, tip);
        let other_flank = 2.0 * self.worm.transverse_azimuth(reference)? - PI / f64::from(starts);
        let worm = Teeth {
            count: starts,
            flank: |radius: f64, z: f64| Some(z / p + self.worm.transverse_azimuth(radius)?),
            opposite_flank: other_flank,
            sense: -1.0,
            ends: |_| [low - clearance, tip],
            bore: 0.0,
            width: zone.length,
            steps: [
                (STEPS_OF_TURN * zone.length / (TAU * p)).clamp(4.0, MOST_SLICES) as usize,
                6,
                (STEPS_OF_TURN / (2.0 * f64::from(starts))) as usize,
            ],
        };
        let below = |radius: f64, y: f64| a - (radius * radius - y * y).max(0.0).sqrt();
        let wheel = Teeth {
            count: teeth,
            flank: |radius: f64, h: f64| self.wheel_azimuth(zone, radius, -h),
            opposite_flank: self.ratio * other_flank,
            sense: 1.0,
            ends: |h: f64| {
                [
                    below(tip, h) - clearance,
                    below(low, h).min(zone.outer_radius),
                ]
            },
            bore: (a - tip - clearance - RIM * (tip - low)).max(LEAST_BORE * (a - tip - clearance)),
            width: zone.face_width,
            steps: [16, 9, 3],
        };
        let pitch = TAU / f64::from(starts);
        let [first, last] = zone.turns(self)?;
        let position = |k: u32| {
            let turn = pitch * f64::from(k) / f64::from(POSITIONS);
            let pitches =
                ((first - turn) / pitch).ceil() as i64..=((last - turn) / pitch).floor() as i64;
            let lines = pitches.map(|n| zone.line(self, turn + pitch * n as f64));
            ContactPosition {
                angles: [turn, self.ratio * turn],
                curves: lines
                    .flat_map(|line| {
                        let pieces = line.pieces(low);
                        pieces.map(|piece| self.shown(piece)).collect::<Vec<_>>()
                    })
                    .collect(),
            }
        };
        let sectors = [worm.sector()?, wheel.sector()?];
        let positions = (0..POSITIONS).map(position).collect();
        Some(worm_and_wheel(sectors, [starts, teeth], a, positions))
    }

    /// Azimuth of the wheel's flank at a radius and a place y, rad; none below the flank.
    pub fn wheel_azimuth(&self, zone: &WormZone, radius: f64, y: f64) -> Option<f64> {
        let contact = |u: f64| self.contact(f64::hypot(u, y), y.atan2(u));
        let top = self.centre_distance - radius;
        let mut bottom = (zone.radii[1] * zone.radii[1] - y * y).sqrt();
        // Beyond the limit of the first kind the worm cuts the flank away.
        let undercut = |u: f64| Some(contact(u)?.undercut);
        if !(undercut(bottom)? < 0.0) {
            bottom = sign_change([top, bottom], undercut)?;
        }
        let u = sign_change([top, bottom], |u| Some(contact(u)?.wheel_radius() - radius))?;
        let place = contact(u)?.in_wheel();
        // Continuous where the wheel faces the worm.
        Some(PI + (-place.z).atan2(-place.x))
    }

    /// Points of a line of contact in space.
    fn shown(&self, line: &[WormContact]) -> Vec<Vector> {
        let centre = Vector::X * self.centre_distance;
        stride(line, SHOWN).map(|c| c.from_wheel + centre).collect()
    }
}

/// Every `step`-th item, and the last one.
pub(super) fn stride<T>(items: &[T], step: usize) -> impl Iterator<Item = &T> {
    let last = items.last().filter(|_| items.len() % step != 1);
    items.iter().step_by(step).chain(last)
}
