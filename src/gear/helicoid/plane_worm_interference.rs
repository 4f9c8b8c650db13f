//! Interference of a plane-generated worm with its wheel: points of the tooth against the worm at every turn.
//!
//! The worm is what the plane leaves: a point lies in it where its height over the plane is positive at every generating turn
//! `φ₂*` of the wheel. Depth is the least of these heights.

use super::plane_worm::PlaneWorm;
use super::plane_worm_zone::PlaneWormZone;
use crate::gear::kernel::root::greatest;
use crate::gear::kernel::vector::Vector;

/// A point of the wheel's tooth that the worm cuts away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToothInterference {
    /// The point in the wheel: ξ, η, ζ.
    pub in_wheel: Vector,
    /// Turn φ₂ of the wheel at which the worm cuts deepest, rad.
    pub wheel_turn: f64,
    /// Depth along the normal of the plane.
    pub depth: f64,
}

/// Turns of the wheel at which a point is tried, and generating turns of each.
const TURNS: u32 = 48;
/// Generating turns tried, over a turn of the worm.
const GENERATING: u32 = 24;

impl PlaneWorm {
    /// The point of the wheel that lies deepest in the worm, between two turns of the wheel; none where all depths are below `tolerance`.
    pub fn interference(
        &self,
        zone: &PlaneWormZone,
        points: impl IntoIterator<Item = Vector>,
        turns: [f64; 2],
        tolerance: f64,
    ) -> Option<ToothInterference> {
        let found = points.into_iter().filter_map(|in_wheel| {
            let depth = |turn: f64| self.depth_in_worm(zone, in_wheel, turn);
            let [wheel_turn, depth] = greatest(turns, TURNS, depth)?;
            (depth > tolerance).then_some(ToothInterference {
                in_wheel,
                wheel_turn,
                depth,
            })
        });
        found.max_by(|a, b| a.depth.total_cmp(&b.depth))
    }

    /// Depth in the worm of a point of the wheel at a turn of the wheel: the least height over the plane within half a turn of the worm;
    /// none where the plane never passes the point.
    pub fn depth_in_worm(
        &self,
        zone: &PlaneWormZone,
        in_wheel: Vector,
        wheel_turn: f64,
    ) -> Option<f64> {
        let r = self.in_space(in_wheel, wheel_turn);
        let (sb, cb) = self.plane_angle.sin_cos();
        let below = |turn: f64| {
            let (sin, cos) = ((turn - wheel_turn) / self.ratio).sin_cos();
            let turned = Vector::new(r.x * cos - r.y * sin, r.x * sin + r.y * cos, r.z);
            let at = self.in_wheel(turned, turn.sin_cos());
            let on_plane = at.y.abs() <= 0.5 * zone.face_width
                && at.x > 0.0
                && f64::hypot(at.x, at.z) <= zone.wheel_tip_radius;
            on_plane.then_some(at.y * sb - (at.z - self.base_radius) * cb)
        };
        let half_turn = self.ratio * std::f64::consts::PI;
        let range = [wheel_turn - half_turn, wheel_turn + half_turn];
        let [_, below] = greatest(range, GENERATING, below)?;
        Some(-below)
    }
}
