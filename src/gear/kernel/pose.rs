//! Poses: `r′ = R r + t`, the exponential of a twist, and twists, points and directions carried to another frame.
//!
//! `Transform` is plain; `Pose`, `Point` and `Direction` name their frames, which are unit structs of the caller with
//! `#[derive(Debug, Clone, Copy, PartialEq)]`.

use std::marker::PhantomData;
use std::ops::Mul;

use super::twist::Twist;
use super::vector::Vector;

/// A rigid displacement `r′ = R r + t`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform {
    /// Columns of R: the images of the axes.
    pub rotation: [Vector; 3],
    /// Image t of the origin.
    pub translation: Vector,
}

impl Transform {
    /// No displacement.
    pub const IDENTITY: Transform = Transform {
        rotation: [Vector::X, Vector::Y, Vector::Z],
        translation: Vector::ZERO,
    };

    /// exp(q S): the displacement by the twist S over the amount q.
    pub fn exp(twist: &Twist, q: f64) -> Transform {
        Exponential::of(twist).at(q)
    }

    /// R a.
    #[inline]
    pub fn rotate(&self, a: Vector) -> Vector {
        let [x, y, z] = self.rotation;
        x * a.x + y * a.y + z * a.z
    }

    /// R r + t.
    #[inline]
    pub fn apply(&self, r: Vector) -> Vector {
        self.rotate(r) + self.translation
    }

    /// The displacement `inner` followed by this one.
    #[inline]
    pub fn after(&self, inner: &Transform) -> Transform {
        Transform {
            rotation: inner.rotation.map(|column| self.rotate(column)),
            translation: self.apply(inner.translation),
        }
    }

    /// The way back.
    pub fn inverse(&self) -> Transform {
        let [x, y, z] = self.rotation;
        let rotation = [
            Vector::new(x.x, y.x, z.x),
            Vector::new(x.y, y.y, z.y),
            Vector::new(x.z, y.z, z.z),
        ];
        let turned = Transform {
            rotation,
            translation: Vector::ZERO,
        };
        Transform {
            translation: -turned.rotate(self.translation),
            ..turned
        }
    }

    /// A twist of the inner frame in coordinates of the outer one: `w′ = R w`, `s′ = R s − w′×t`.
    #[inline]
    pub fn carry(&self, twist: &Twist) -> Twist {
        let w = self.rotate(twist.w);
        Twist {
            w,
            s: self.rotate(twist.s) - w.cross(self.translation),
        }
    }
}

/// A twist S prepared for its displacements exp(q S).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exponential {
    /// Unit direction e of the screw axis; zero for a slide.
    direction: Vector,
    /// The axis' point c nearest the origin.
    point: Vector,
    /// e×c.
    moment: Vector,
    /// Turn |w| for a unit of q.
    turn: f64,
    /// Slide along the axis for a unit of q.
    slide: Vector,
}

impl Exponential {
    /// The displacements of a twist.
    pub fn of(twist: &Twist) -> Exponential {
        match twist.screw_axis() {
            Some(axis) => {
                let turn = twist.w.norm();
                Exponential {
                    direction: axis.direction,
                    point: axis.point,
                    moment: axis.direction.cross(axis.point),
                    turn,
                    slide: axis.direction * (axis.pitch * turn),
                }
            }
            None => Exponential {
                direction: Vector::ZERO,
                point: Vector::ZERO,
                moment: Vector::ZERO,
                turn: 0.0,
                slide: twist.s,
            },
        }
    }

    /// exp(q S) by Rodrigues' formula, `t = (1 − cos) c − sin e×c + q slide`, with `1 − cos = 2 sin²(·/2)`.
    #[inline]
    pub fn at(&self, q: f64) -> Transform {
        if self.turn == 0.0 {
            return Transform {
                translation: self.slide * q,
                ..Transform::IDENTITY
            };
        }
        let (half_sin, half_cos) = (0.5 * q * self.turn).sin_cos();
        let (sin, versine) = (2.0 * half_sin * half_cos, 2.0 * half_sin * half_sin);
        let e = self.direction;
        let (d, o, cos) = (e * versine, e * sin, 1.0 - versine);
        Transform {
            rotation: [
                d * e.x + Vector::new(cos, o.z, -o.y),
                d * e.y + Vector::new(-o.z, cos, o.x),
                d * e.z + Vector::new(o.y, -o.x, cos),
            ],
            translation: self.point * versine - self.moment * sin + self.slide * q,
        }
    }
}

/// The pose of the frame `From` in the frame `To`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose<To, From> {
    transform: Transform,
    frames: PhantomData<(To, From)>,
}

/// A point in the coordinates of `Frame`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point<Frame> {
    /// Coordinates.
    pub coordinates: Vector,
    frame: PhantomData<Frame>,
}

/// A free vector, such as a normal, in the coordinates of `Frame`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Direction<Frame> {
    /// Components.
    pub components: Vector,
    frame: PhantomData<Frame>,
}

impl<To, From> Pose<To, From> {
    /// The pose of a transform, whose frames the caller states.
    pub fn new(transform: Transform) -> Pose<To, From> {
        Pose {
            transform,
            frames: PhantomData,
        }
    }

    /// Turned by `angle` about the unit vector `axis` through the origin, rad.
    pub fn turned(axis: Vector, angle: f64) -> Pose<To, From> {
        Pose::new(Transform::exp(&Twist::turn(axis, Vector::ZERO), angle))
    }

    /// Shifted by a vector.
    pub fn shifted(by: Vector) -> Pose<To, From> {
        Pose::new(Transform {
            translation: by,
            ..Transform::IDENTITY
        })
    }

    /// The plain transform.
    pub fn transform(&self) -> &Transform {
        &self.transform
    }

    /// The pose of `To` in `From`.
    pub fn inverse(&self) -> Pose<From, To> {
        Pose::new(self.transform.inverse())
    }
}

impl<To, Between, From> Mul<Pose<Between, From>> for Pose<To, Between> {
    type Output = Pose<To, From>;
    fn mul(self, inner: Pose<Between, From>) -> Pose<To, From> {
        Pose::new(self.transform.after(&inner.transform))
    }
}

impl<To, From> Mul<Point<From>> for Pose<To, From> {
    type Output = Point<To>;
    fn mul(self, point: Point<From>) -> Point<To> {
        Point::new(self.transform.apply(point.coordinates))
    }
}

impl<To, From> Mul<Direction<From>> for Pose<To, From> {
    type Output = Direction<To>;
    fn mul(self, direction: Direction<From>) -> Direction<To> {
        Direction::new(self.transform.rotate(direction.components))
    }
}

impl<Frame> Point<Frame> {
    /// The point at coordinates, whose frame the caller states.
    pub fn new(coordinates: Vector) -> Point<Frame> {
        Point {
            coordinates,
            frame: PhantomData,
        }
    }
}

impl<Frame> Direction<Frame> {
    /// The direction of components, whose frame the caller states.
    pub fn new(components: Vector) -> Direction<Frame> {
        Direction {
            components,
            frame: PhantomData,
        }
    }
}
