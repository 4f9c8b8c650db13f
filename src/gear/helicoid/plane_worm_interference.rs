//! Interference of a plane-generated worm with its wheel: depth of tooth points in the worm at every rotation.
//!
//! A point lies inside the worm where its height over the generating plane is positive at every generating rotation `φ₂*` of the wheel.
//! The depth is the minimum of these heights.

use super::plane_worm::PlaneWorm;
use super::plane_worm_zone::PlaneWormZone;
use crate::gear::kernel::root::greatest;
use crate::gear::kernel::vector::Vector;

/// Point of the wheel tooth that the worm removes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToothInterference {
    /// Point in the wheel frame: ξ, η, ζ.
    pub in_wheel: Vector,
    /// Rotation φ₂ of the wheel at the maximum depth, rad.
    pub wheel_turn: f64,
    /// Depth in the worm along the normal of the plane, in the unit of the pair.
    pub depth: f64,
}

/// Scan intervals of the rotation of the wheel for a point.
const TURNS: u32 = 48;
/// Scan intervals of the generating rotation over one revolution of the worm.
const GENERATING: u32 = 24;

impl PlaneWorm {
    /// Deepest point of the wheel in the worm between two rotations of the wheel, rad; `None` where no depth exceeds `tolerance`.
    pub fn interference(
        &self,
        zone: &PlaneWormZone,
        points: impl IntoIterator<Item = Vector>,
        turns: [f64; 2],
        tolerance: f64,
    ) -> Option<ToothInterference> {
        let removed = points.into_iter().filter_map(|in_wheel| {
            let depth = |turn: f64| self.depth_in_worm(zone, in_wheel, turn);
            let [wheel_turn, depth] = greatest(turns, TURNS, depth)?;
            (depth > tolerance).then_some(ToothInterference {
                in_wheel,
                wheel_turn,
                depth,
            })
        });
        removed.max_by(|a, b| a.depth.total_cmp(&b.depth))
    }

    /// Depth in the worm of a point of the wheel at a rotation of the wheel, rad: the minimum height over the plane within half a
    /// revolution of the worm; `None` where the plane does not sweep over the point.
    pub fn depth_in_worm(
        &self,
        zone: &PlaneWormZone,
        in_wheel: Vector,
        wheel_turn: f64,
    ) -> Option<f64> {
        let r = self.in_space(in_wheel, wheel_turn);
        let (sb, cb) = self.plane_angle.sin_cos();
        let negative_height = |turn: f64| {
            let (sin, cos) = ((turn - wheel_turn) / self.ratio).sin_cos();
            let rotated = Vector::new(r.x * cos - r.y * sin, r.x * sin + r.y * cos, r.z);
            let at = self.in_wheel(rotated, turn.sin_cos());
            let on_plane = at.y.abs() <= 0.5 * zone.face_width
                && at.x > 0.0
                && f64::hypot(at.x, at.z) <= zone.wheel_tip_radius;
            on_plane.then_some(at.y * sb - (at.z - self.base_radius) * cb)
        };
        let half_turn = self.ratio * std::f64::consts::PI;
        let range = [wheel_turn - half_turn, wheel_turn + half_turn];
        let [_, negative_height] = greatest(range, GENERATING, negative_height)?;
        Some(-negative_height)
    }
}
