//! Solids of a plane-generated worm pair: transverse sections of the thread, wheel tooth with plane and enveloped zone, contact lines.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::plane_worm::{PlaneWorm, PlaneWormContact};
use super::plane_worm_zone::PlaneWormZone;
use super::turning_pair::{CLEARANCE, ContactPosition, POSITIONS, Teeth, TurningPair};
use super::worm_solid::{LEAST_BORE, MOST_SLICES, RIM, stride, worm_and_wheel};
use crate::gear::kernel::newton::newton;
use crate::gear::kernel::root::sign_change;
use crate::gear::kernel::vector::Vector;

/// Stride of the points of a contact line that are drawn.
const DRAWN_STRIDE: usize = 4;
/// Continuation steps from the limit curve to a point of the enveloped zone.
const STEPS: u32 = 12;

impl PlaneWorm {
    /// Solids of worm and wheel without backlash, with contact lines over one pitch; `None` where a flank does not reach its tip.
    pub fn turning_pair(
        &self,
        zone: &PlaneWormZone,
        [starts, teeth]: [u32; 2],
    ) -> Option<TurningPair> {
        let a = self.centre_distance;
        let [worm_tip, wheel_tip] = [zone.worm_tip_radius, zone.wheel_tip_radius];
        let range = zone.turns(self)?;
        let depth = worm_tip + wheel_tip - a;
        let clearance = CLEARANCE * depth;
        let torus = |radius: f64, h: f64| a - (radius * radius - h * h).max(0.0).sqrt();
        // Thread thickness equals space width at half depth in the throat of the worm.
        let reference = worm_tip - 0.5 * depth;
        let other_flank = 2.0 * self.worm_azimuth(reference, 0.0)? - PI / f64::from(starts);
        let worm = Teeth {
            count: starts,
            flank: |radius: f64, z: f64| self.worm_azimuth(radius, z),
            opposite_flank: other_flank,
            sense: -1.0,
            ends: |z: f64| [torus(wheel_tip + clearance, z), torus(a - worm_tip, z)],
            bore: 0.0,
            width: zone.length,
            steps: [MOST_SLICES as usize, 6, 15],
        };
        let wheel = Teeth {
            count: teeth,
            flank: |radius: f64, h: f64| {
                let point = self.tooth_point(radius, -h, range)?;
                Some(PI + (-point.z).atan2(point.x))
            },
            opposite_flank: self.ratio * other_flank,
            sense: 1.0,
            ends: |h: f64| [torus(worm_tip, h) - clearance, wheel_tip],
            bore: (a - worm_tip - clearance - RIM * depth)
                .max(LEAST_BORE * (a - worm_tip - clearance)),
            width: zone.face_width,
            steps: [16, 9, 3],
        };
        let pitch = self.ratio * TAU / f64::from(starts);
        let position = |k: u32| {
            let phi = pitch * f64::from(k) / f64::from(POSITIONS);
            let [first, last] = range.map(|end| (end - phi) / pitch);
            let turns = (first.ceil() as i64..=last.floor() as i64).map(|n| phi + pitch * n as f64);
            let lines =
                turns.flat_map(|phi| [zone.first_line(self, phi), zone.second_line(self, phi)]);
            ContactPosition {
                angles: [phi / self.ratio, phi],
                curves: lines
                    .filter(|line| line.len() > 1)
                    .map(|line| drawn_points(&line))
                    .collect(),
            }
        };
        let sectors = [worm.sector()?, wheel.sector()?];
        let positions = (0..POSITIONS).map(position).collect();
        Some(worm_and_wheel(sectors, [starts, teeth], a, positions))
    }

    /// Azimuth of the worm flank at a radius and an axial coordinate z, rad; `None` where the plane generates no flank.
    pub fn worm_azimuth(&self, radius: f64, z: f64) -> Option<f64> {
        // On a contact line z is linear in η.
        let contact = |phi: f64| {
            let line = self.generating_line(phi);
            let [z_0, z_1] =
                [0.0, self.base_radius].map(|eta| Some(line.first_contact(eta)?.point.z));
            let (z_0, z_1) = (z_0?, z_1?);
            line.first_contact(self.base_radius * (z - z_0) / (z_1 - z_0))
        };
        let excess = |phi: f64| Some(contact(phi)?.worm_radius() - radius);
        const N: u32 = 180;
        let node = |k: u32| FRAC_PI_2 * (2.0 * f64::from(k) / f64::from(N) - 1.0);
        let contacts = (0..N).filter_map(|k| contact(sign_change([node(k), node(k + 1)], excess)?));
        let flanks = contacts.filter(|c| c.relative_curvature < 0.0 && c.point.x > 0.0);
        let c = flanks.min_by(|a, b| a.point.y.abs().total_cmp(&b.point.y.abs()))?;
        Some(c.point.y.atan2(c.point.x) - c.wheel_turn / self.ratio)
    }

    /// Point (ξ, η, ζ) of the wheel tooth at a radius and η: on the plane zone where η is at least that of the limit curve, else enveloped.
    pub fn tooth_point(&self, radius: f64, eta: f64, range: [f64; 2]) -> Option<Vector> {
        let tan = self.plane_angle.tan();
        let plane_point = |eta: f64| {
            let zeta = self.base_radius + eta * tan;
            Vector::new((radius * radius - zeta * zeta).sqrt(), eta, zeta)
        };
        let limit = |phi: f64| self.generating_line(phi).limit();
        let excess = |phi: f64| {
            let [xi, eta] = limit(phi)?;
            Some(f64::hypot(xi, self.base_radius + eta * tan) - radius)
        };
        let phi = sign_change(range, excess)?;
        let limit_eta = limit(phi)?[1];
        if eta >= limit_eta {
            return Some(plane_point(eta));
        }
        // Second contact of a point of the contact line, continued from the limit curve to (R, η).
        let contact = |[phi, eta]: [f64; 2]| self.generating_line(phi).second_contact_at(eta);
        let mut x = [phi, limit_eta];
        for k in 1..=STEPS {
            let target = limit_eta + (eta - limit_eta) * f64::from(k) / f64::from(STEPS);
            if k == 1 {
                x[1] = 2.0 * limit_eta - target;
            }
            let residuals = |x: [f64; 2]| {
                let c = contact(x)?;
                Some([c.wheel_radius() - radius, c.in_wheel.y - target])
            };
            let scales = [0.1, 0.1 * self.base_radius];
            x = newton(x, scales, |x| {
                const STEP: f64 = 1e-6;
                let r = residuals(x)?;
                let mut jacobian = [[0.0; 2]; 2];
                for j in 0..2 {
                    let mut shifted = x;
                    shifted[j] += STEP * scales[j];
                    let shifted = residuals(shifted)?;
                    (0..2).for_each(|i| jacobian[i][j] = (shifted[i] - r[i]) / (STEP * scales[j]));
                }
                Some((r, jacobian))
            })?;
        }
        Some(contact(x)?.in_wheel)
    }
}

/// Every `DRAWN_STRIDE`-th point of a contact line.
fn drawn_points(line: &[PlaneWormContact]) -> Vec<Vector> {
    stride(line, DRAWN_STRIDE).map(|c| c.point).collect()
}
