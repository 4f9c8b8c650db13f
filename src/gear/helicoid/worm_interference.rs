//! Interference of a worm with its wheel: the flank that contact gives, against every turn of the worm.
//!
//! A point of the wheel's flank lies on the worm's flank at its own turn. At another turn φ it has the height `z − g(ρ) − p (ψ − φ)` over
//! the flank; where that lies in the thread the worm cuts the point away.

use super::worm_pair::{WormContact, WormPair};
use super::worm_zone::WormZone;
use crate::gear::kernel::root::greatest;

/// A point of the wheel's flank that the worm cuts away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelInterference {
    /// The contact that would make the point.
    pub contact: WormContact,
    /// Turn φ of the worm at which it cuts deepest, rad.
    pub worm_turn: f64,
    /// Depth of the point in the thread, normal to the worm's flank.
    pub depth: f64,
}

/// Turns of the worm at which a point is tried.
const TURNS: u32 = 96;

impl WormZone {
    /// The contact whose point lies deepest in the thread at another turn of the worm, between two turns; none where all depths are below
    /// `tolerance`. `thickness` is that of the thread along the axis where the flank passes z = 0.
    pub fn interference<'a>(
        &self,
        pair: &WormPair,
        contacts: impl IntoIterator<Item = &'a WormContact>,
        turns: [f64; 2],
        [thickness, tolerance]: [f64; 2],
    ) -> Option<WheelInterference> {
        let found = contacts.into_iter().filter_map(|contact| {
            let depth = |turn: f64| self.depth_in_thread(pair, contact, turn, thickness);
            let [worm_turn, depth] = greatest(turns, TURNS, depth)?;
            (depth > tolerance).then_some(WheelInterference {
                contact: *contact,
                worm_turn,
                depth,
            })
        });
        found.max_by(|a, b| a.depth.total_cmp(&b.depth))
    }

    /// Depth in the thread of the wheel's point that a contact makes, at a turn of the worm; none where the worm does not reach it.
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
        let at = pair.worm.at(radius)?;
        let height = z - at.height - pair.worm.lead * (r.y.atan2(x) - turn);
        let steep = pair.worm.lead / radius;
        let across = (1.0 + at.slope * at.slope + steep * steep).sqrt();
        Some(height.min(thickness - 2.0 * at.height - height) / across)
    }
}
