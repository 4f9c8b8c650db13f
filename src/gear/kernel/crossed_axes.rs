//! Two axes that turn at a constant ratio: relative motion, instantaneous screw axis and axodes.
//!
//! Axis 1 is z through the origin; axis 2 passes through (a, 0, 0) along (0, sin Σ, cos Σ). `ω₁ = 1`, `ω₂ = i`, negative for external gears.
//! Litvin and Fuentes, Gear Geometry and Applied Theory, 2nd ed. 2004, sections 3.3–3.5.

use super::twist::{ScrewAxis, Twist};
use super::vector::Vector;

/// Two axes with the ratio of their turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossedAxes {
    /// Shortest distance a; below zero it runs against x.
    pub offset: f64,
    /// Shaft angle Σ, rad.
    pub shaft_angle: f64,
    /// Ratio `i = ω₂/ω₁` with its sign.
    pub ratio: f64,
}

/// Axodes of two bodies: hyperboloids `x² + y² = r² + z² tan²δ` that the screw axis sweeps on each; cones where the axes meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axodes {
    /// The screw axis in the fixed frame, along the relative angular velocity of body 1 seen from body 2.
    pub screw: ScrewAxis,
    /// Throat radii: distances of the screw axis from both axes.
    pub throat_radii: [f64; 2],
    /// Angles δ of the screw axis with both axes, from 0° to 90°, rad.
    pub angles: [f64; 2],
}

impl CrossedAxes {
    /// Unit vectors along both axes.
    pub fn directions(&self) -> [Vector; 2] {
        let (sin, cos) = self.shaft_angle.sin_cos();
        [Vector::Z, Vector::new(0.0, sin, cos)]
    }

    /// Points of both axes on their common perpendicular.
    pub fn feet(&self) -> [Vector; 2] {
        [Vector::ZERO, Vector::X * self.offset]
    }

    /// Turns of both bodies for a radian of the first.
    pub fn turns(&self) -> [Twist; 2] {
        let ([k1, k2], [o1, o2]) = (self.directions(), self.feet());
        [Twist::turn(k1, o1), Twist::turn(k2, o2).times(self.ratio)]
    }

    /// Motion of body 1 seen from body 2 for a radian of body 1.
    pub fn relative(&self) -> Twist {
        let [first, second] = self.turns();
        first.plus(-1.0, &second)
    }

    /// `q = ω₁×v₂ − ω₂×v₁` at a place: `Φ = n·q` of two bodies that turn at constant rates, `f = n·(v₁ − v₂)`.
    pub fn rate(&self, at: Vector) -> Vector {
        let [first, second] = self.turns();
        first.w.cross(second.at(at)) - second.w.cross(first.at(at))
    }

    /// The axodes; none where the bodies do not turn against each other.
    pub fn axodes(&self) -> Option<Axodes> {
        let screw = self.relative().screw_axis()?;
        let along = |k: Vector| {
            f64::atan2(
                screw.direction.cross(k).norm(),
                screw.direction.dot(k).abs(),
            )
        };
        Some(Axodes {
            throat_radii: [screw.point.x.abs(), (self.offset - screw.point.x).abs()],
            angles: self.directions().map(along),
            screw,
        })
    }
}
