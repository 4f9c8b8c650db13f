//! Hourglass worm and wheel in space: transverse sections of the thread, the tooth of plane and enveloped part, both lines of contact.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::plane_worm::{PlaneWorm, PlaneWormContact};
use super::plane_worm_zone::PlaneWormZone;
use super::turning_pair::{CLEARANCE, ContactPosition, POSITIONS, Teeth, TurningPair};
use super::worm_solid::{LEAST_BORE, MOST_SLICES, RIM, every, worm_and_wheel};
use crate::gear::kernel::newton::newton;
use crate::gear::kernel::root::sign_change;
use crate::gear::kernel::vector::Vector;

/// Every so many points of a line of contact are shown.
const SHOWN: usize = 4;
/// Steps from the curve between both parts to a place of the enveloped part.
const STEPS: u32 = 12;

impl PlaneWorm {
    /// The pair without backlash over one pitch; none where a flank does not reach its tip.
    pub fn turning(&self, zone: &PlaneWormZone, [starts, teeth]: [u32; 2]) -> Option<TurningPair> {
        let a = self.centre_distance;
        let [worm_tip, wheel_tip] = [zone.worm_tip_radius, zone.wheel_tip_radius];
        let turns = zone.turns(self)?;
        let depth = worm_tip + wheel_tip - a;
        let clearance = CLEARANCE * depth;
        let below = |radius: f64, h: f64| a - (radius * radius - h * h).max(0.0).sqrt();
        // Threads as thick as spaces in the middle of the worm.
        let reference = worm_tip - 0.5 * depth;
        let other_flank = 2.0 * self.worm_azimuth(reference, 0.0)? - PI / f64::from(starts);
        let worm = Teeth {
            count: starts,
            flank: |radius: f64, z: f64| self.worm_azimuth(radius, z),
            other_flank,
            sense: -1.0,
            ends: |z: f64| [below(wheel_tip + clearance, z), below(a - worm_tip, z)],
            bore: 0.0,
            width: zone.length,
            steps: [MOST_SLICES as usize, 6, 15],
        };
        let wheel = Teeth {
            count: teeth,
            flank: |radius: f64, h: f64| {
                let place = self.tooth_place(radius, -h, turns)?;
                Some(PI + (-place.z).atan2(place.x))
            },
            other_flank: self.ratio * other_flank,
            sense: 1.0,
            ends: |h: f64| [below(worm_tip, h) - clearance, wheel_tip],
            bore: (a - worm_tip - clearance - RIM * depth)
                .max(LEAST_BORE * (a - worm_tip - clearance)),
            width: zone.face_width,
            steps: [16, 9, 3],
        };
        let pitch = self.ratio * TAU / f64::from(starts);
        let position = |k: u32| {
            let turn = pitch * f64::from(k) / f64::from(POSITIONS);
            let [first, last] = turns.map(|end| (end - turn) / pitch);
            let places =
                (first.ceil() as i64..=last.floor() as i64).map(|n| turn + pitch * n as f64);
            let lines =
                places.flat_map(|turn| [zone.first_line(self, turn), zone.second_line(self, turn)]);
            ContactPosition {
                angles: [turn / self.ratio, turn],
                curves: lines
                    .filter(|line| line.len() > 1)
                    .map(|line| shown(&line))
                    .collect(),
            }
        };
        let sectors = [worm.sector()?, wheel.sector()?];
        let positions = (0..POSITIONS).map(position).collect();
        Some(worm_and_wheel(sectors, [starts, teeth], a, positions))
    }

    /// Azimuth of the worm's flank at a radius and a height, rad; none where the plane makes no flank.
    pub fn worm_azimuth(&self, radius: f64, z: f64) -> Option<f64> {
        // On a generating line the height is linear in η.
        let at = |turn: f64| {
            let line = self.generating_line(turn);
            let [zero, one] =
                [0.0, self.base_radius].map(|eta| Some(line.first_contact(eta)?.point.z));
            let (zero, one) = (zero?, one?);
            line.first_contact(self.base_radius * (z - zero) / (one - zero))
        };
        let beyond = |turn: f64| Some(at(turn)?.worm_radius() - radius);
        const PARTS: u32 = 180;
        let place = |k: u32| FRAC_PI_2 * (2.0 * f64::from(k) / f64::from(PARTS) - 1.0);
        let found = (0..PARTS).filter_map(|k| at(sign_change([place(k), place(k + 1)], beyond)?));
        let flanks = found.filter(|c| c.relative_curvature < 0.0 && c.point.x > 0.0);
        let c = flanks.min_by(|a, b| a.point.y.abs().total_cmp(&b.point.y.abs()))?;
        Some(c.point.y.atan2(c.point.x) - c.wheel_turn / self.ratio)
    }

    /// The place (ξ, η, ζ) of the tooth at a radius and η: on the plane behind the curve between both parts, on the enveloped part before it.
    pub fn tooth_place(&self, radius: f64, eta: f64, turns: [f64; 2]) -> Option<Vector> {
        let tan = self.plane_angle.tan();
        let plane = |eta: f64| {
            let zeta = self.base_radius + eta * tan;
            Vector::new((radius * radius - zeta * zeta).sqrt(), eta, zeta)
        };
        let limit = |turn: f64| self.generating_line(turn).limit();
        let missed = |turn: f64| {
            let [xi, eta] = limit(turn)?;
            Some(f64::hypot(xi, self.base_radius + eta * tan) - radius)
        };
        let turn = sign_change(turns, missed)?;
        let joint = limit(turn)?[1];
        if eta >= joint {
            return Some(plane(eta));
        }
        // The worm's line of a turn at a place touches again at (R, η); from the curve outwards.
        let again = |[turn, place]: [f64; 2]| self.generating_line(turn).touching_again(place);
        let mut x = [turn, joint];
        for k in 1..=STEPS {
            let target = joint + (eta - joint) * f64::from(k) / f64::from(STEPS);
            if k == 1 {
                x[1] = 2.0 * joint - target;
            }
            let value = |x: [f64; 2]| {
                let c = again(x)?;
                Some([c.wheel_radius() - radius, c.in_wheel.y - target])
            };
            let scales = [0.1, 0.1 * self.base_radius];
            x = newton(x, scales, |x| {
                const STEP: f64 = 1e-6;
                let now = value(x)?;
                let mut rows = [[0.0; 2]; 2];
                for j in 0..2 {
                    let mut moved = x;
                    moved[j] += STEP * scales[j];
                    let moved = value(moved)?;
                    (0..2).for_each(|i| rows[i][j] = (moved[i] - now[i]) / (STEP * scales[j]));
                }
                Some((now, rows))
            })?;
        }
        Some(again(x)?.in_wheel)
    }
}

/// Points of a line of contact in space.
fn shown(line: &[PlaneWormContact]) -> Vec<Vector> {
    every(line, SHOWN).map(|c| c.point).collect()
}
