//! Vectors of space: sums, multiples, `a·b`, `a×b`, `|a|`.

use std::f64::consts::TAU;
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// A vector of space in the coordinates of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Vector {
    /// First coordinate.
    pub x: f64,
    /// Second coordinate.
    pub y: f64,
    /// Third coordinate.
    pub z: f64,
}

/// An angle within ±π.
pub fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

impl Vector {
    /// The zero vector.
    pub const ZERO: Vector = Vector::new(0.0, 0.0, 0.0);
    /// The unit vector of the first axis.
    pub const X: Vector = Vector::new(1.0, 0.0, 0.0);
    /// The unit vector of the second axis.
    pub const Y: Vector = Vector::new(0.0, 1.0, 0.0);
    /// The unit vector of the third axis.
    pub const Z: Vector = Vector::new(0.0, 0.0, 1.0);

    /// The vector of three coordinates.
    pub const fn new(x: f64, y: f64, z: f64) -> Vector {
        Vector { x, y, z }
    }

    /// The coordinates.
    pub const fn array(self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }

    /// `a·b`.
    #[inline]
    pub fn dot(self, b: Vector) -> f64 {
        self.x * b.x + self.y * b.y + self.z * b.z
    }

    /// `a×b`.
    #[inline]
    pub fn cross(self, b: Vector) -> Vector {
        Vector::new(
            self.y * b.z - self.z * b.y,
            self.z * b.x - self.x * b.z,
            self.x * b.y - self.y * b.x,
        )
    }

    /// `|a|`.
    #[inline]
    pub fn norm(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// `a/|a|`; none for the zero vector and for one that is not finite.
    #[inline]
    pub fn unit(self) -> Option<Vector> {
        let norm = self.norm();
        (norm > 0.0 && norm.is_finite()).then(|| self * (1.0 / norm))
    }
}

impl Add for Vector {
    type Output = Vector;
    #[inline]
    fn add(self, b: Vector) -> Vector {
        Vector::new(self.x + b.x, self.y + b.y, self.z + b.z)
    }
}

impl AddAssign for Vector {
    #[inline]
    fn add_assign(&mut self, b: Vector) {
        *self = *self + b;
    }
}

impl Sub for Vector {
    type Output = Vector;
    #[inline]
    fn sub(self, b: Vector) -> Vector {
        Vector::new(self.x - b.x, self.y - b.y, self.z - b.z)
    }
}

impl Neg for Vector {
    type Output = Vector;
    #[inline]
    fn neg(self) -> Vector {
        Vector::new(-self.x, -self.y, -self.z)
    }
}

impl Mul<f64> for Vector {
    type Output = Vector;
    #[inline]
    fn mul(self, factor: f64) -> Vector {
        Vector::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl Mul<Vector> for f64 {
    type Output = Vector;
    #[inline]
    fn mul(self, a: Vector) -> Vector {
        a * self
    }
}
