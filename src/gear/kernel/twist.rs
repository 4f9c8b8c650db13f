//! Twists: the velocity field `v(r) = w×r + s` of a rigid body, its bracket and its screw axis.

use super::vector::Vector;

/// The velocity field `v(r) = w×r + s` of a rigid body, a unit of the motion's parameter.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twist {
    /// Angular velocity w.
    pub w: Vector,
    /// Velocity s of the point at the origin.
    pub s: Vector,
}

/// Axis of a twist: a turn about a line and a slide of `pitch` a radian along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScrewAxis {
    /// The point of the axis nearest the origin, `w×s/w²`.
    pub point: Vector,
    /// Unit direction, along w.
    pub direction: Vector,
    /// Advance a radian, `w·s/w²`.
    pub pitch: f64,
}

impl Twist {
    /// Unit turn about the line through `point` along the unit vector `direction`.
    pub fn turn(direction: Vector, point: Vector) -> Twist {
        Twist::screw(direction, point, 0.0)
    }

    /// Unit slide along the unit vector `direction`.
    pub fn slide(direction: Vector) -> Twist {
        Twist {
            w: Vector::ZERO,
            s: direction,
        }
    }

    /// Unit turn about the line through `point` along the unit vector `direction` with the advance `pitch` a radian; positive is right-handed.
    pub fn screw(direction: Vector, point: Vector, pitch: f64) -> Twist {
        Twist {
            w: direction,
            s: point.cross(direction) + direction * pitch,
        }
    }

    /// Velocity at the point r.
    #[inline]
    pub fn at(&self, r: Vector) -> Vector {
        self.w.cross(r) + self.s
    }

    /// The bracket [A, B]: the rate of B where its frame moves with A.
    #[inline]
    pub fn bracket(&self, b: &Twist) -> Twist {
        Twist {
            w: self.w.cross(b.w),
            s: self.w.cross(b.s) - b.w.cross(self.s),
        }
    }

    /// `factor A`.
    #[inline]
    pub fn times(&self, factor: f64) -> Twist {
        Twist {
            w: self.w * factor,
            s: self.s * factor,
        }
    }

    /// `A + factor B`.
    #[inline]
    pub fn plus(&self, factor: f64, b: &Twist) -> Twist {
        Twist {
            w: self.w + b.w * factor,
            s: self.s + b.s * factor,
        }
    }

    /// The screw axis; none for a slide.
    pub fn screw_axis(&self) -> Option<ScrewAxis> {
        let direction = self.w.unit()?;
        let square = self.w.dot(self.w);
        Some(ScrewAxis {
            point: self.w.cross(self.s) * (1.0 / square),
            direction,
            pitch: self.w.dot(self.s) / square,
        })
    }
}
