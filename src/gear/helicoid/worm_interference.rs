//! Interference of a worm with its wheel: depth of points of the generated flank in the thread at every rotation of the worm.
//!
//! A point of the wheel flank lies on the worm flank at the rotation of its contact. At another rotation φ its height over the flank is
//! `z − g(ρ) − p (ψ − φ)`; a point at a height inside the thread is removed by the worm.

use super::worm_pair::{WormContact, WormPair};
use super::worm_zone::WormZone;
use crate::gear::kernel::root::greatest;

/// Point of the wheel flank that the worm removes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelInterference {
    /// Contact that generates the point.
    pub contact: WormContact,
    /// Rotation φ of the worm at the maximum depth, rad.
    pub worm_turn: f64,
    /// Depth of the point in the thread, normal to the worm flank, in the unit of the pair.
    pub depth: f64,
}

/// Scan intervals of the rotation of the worm for a point.
const TURNS: u32 = 96;

impl WormZone {
    /// Contact whose point lies deepest in the thread between two rotations of the worm, rad; `None` where no depth exceeds `tolerance`.
    /// `thickness`: axial thickness of the thread where the flank passes z = 0.
    pub fn interference<'a>(
        &self,
        pair: &WormPair,
        contacts: impl IntoIterator<Item = &'a WormContact>,
        turns: [f64; 2],
        [thickness, tolerance]: [f64; 2],
    ) -> Option<WheelInterference> {
        let removed = contacts.into_iter().filter_map(|contact| {
            let depth = |turn: f64| self.depth_in_thread(pair, contact, turn, thickness);
            let [worm_turn, depth] = greatest(turns, TURNS, depth)?;
            (depth > tolerance).then_some(WheelInterference {
                contact: *contact,
                worm_turn,
                depth,
            })
        });
        removed.max_by(|a, b| a.depth.total_cmp(&b.depth))
    }

    /// Depth in the thread of the wheel point of a contact at a rotation of the worm, rad; `None` where the worm does not reach the point.
    pub fn depth_in_thread(
        &self,
        pair: &WormPair,
        contact: &WormContact,
        turn: f64,
        thickness: f64,
    ) -> Option<f64> {
        let (s, c) = (-pair.ratio * turn).sin_cos();
        let r = contact.in_wheel();
        let (x, z) = (r.x * c + r.z * s + pair.centre_distance, r.z * c - r.x * s);
        let radius = f64::hypot(x, r.y);
        if !(radius <= self.radii[1] && z.abs() <= 0.5 * self.length) {
            return None;
        }
        let g = pair.worm.at(radius)?;
        let height = z - g.height - pair.worm.lead * (r.y.atan2(x) - turn);
        let tan_lead = pair.worm.lead / radius;
        let normal_length = (1.0 + g.slope * g.slope + tan_lead * tan_lead).sqrt();
        Some(height.min(thickness - 2.0 * g.height - height) / normal_length)
    }
}
