//! Tools: a curve swept by a screw, `r(u, θ) = exp(S θ) c(u)`, with the normal along `c′ × S(c)`.
//!
//! | curve | screw | tool |
//! |---|---|---|
//! | line | turn | cone of a blade, conical grinding wheel, plane wheel |
//! | arc | turn | edge radius of a cutter, ball, torus wheel |
//! | line | slide | flank of a rack |
//! | line, arc | screw | helicoid: worm, hob |

use std::f64::consts::TAU;
use std::marker::PhantomData;

use super::jet::{Jet, Surface};
use super::pose::Exponential;
use super::twist::Twist;
use super::vector::Vector;

/// A curve of space with its first two derivatives.
pub trait Curve {
    /// `[c, c′, c″]` at the parameter u.
    fn at(&self, u: f64) -> [Vector; 3];

    /// First and last parameter.
    fn range(&self) -> [f64; 2];
}

/// A straight line `point + u direction`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Point at u = 0.
    pub point: Vector,
    /// Direction; a unit vector makes u a length.
    pub direction: Vector,
    /// First and last u.
    pub range: [f64; 2],
}

impl Curve for Line {
    fn at(&self, u: f64) -> [Vector; 3] {
        [
            self.point + self.direction * u,
            self.direction,
            Vector::ZERO,
        ]
    }

    fn range(&self) -> [f64; 2] {
        self.range
    }
}

/// An arc `centre + radius (cos u first + sin u second)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// Centre.
    pub centre: Vector,
    /// Radius.
    pub radius: f64,
    /// Unit vector towards u = 0.
    pub first: Vector,
    /// Unit vector towards u = π/2.
    pub second: Vector,
    /// First and last u, rad.
    pub range: [f64; 2],
}

impl Arc {
    /// The circle of a radius about a centre, in the plane of two perpendicular unit vectors.
    pub fn circle(centre: Vector, radius: f64, first: Vector, second: Vector) -> Arc {
        Arc {
            centre,
            radius,
            first,
            second,
            range: [0.0, TAU],
        }
    }
}

impl Curve for Arc {
    fn at(&self, u: f64) -> [Vector; 3] {
        let (sin, cos) = u.sin_cos();
        let outward = (self.first * cos + self.second * sin) * self.radius;
        let along = (self.second * cos - self.first * sin) * self.radius;
        [self.centre + outward, along, -outward]
    }

    fn range(&self) -> [f64; 2] {
        self.range
    }
}

/// A curve swept by a screw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tool<C, Frame> {
    /// The curve c(u).
    pub curve: C,
    /// The screw S, a unit of θ.
    screw: Twist,
    exponential: Exponential,
    /// 1 where the normal points along `c′ × S(c)`, −1 where it points against it.
    side: f64,
    frame: PhantomData<Frame>,
}

impl<C: Curve, Frame> Tool<C, Frame> {
    /// The tool of a curve and a screw, with its normal along `c′ × S(c)`.
    pub fn new(curve: C, screw: Twist) -> Tool<C, Frame> {
        Tool {
            curve,
            exponential: Exponential::of(&screw),
            screw,
            side: 1.0,
            frame: PhantomData,
        }
    }

    /// The same tool with its normal on the other side. Normals point out of the metal of the work, into that of the tool.
    pub fn flipped(self) -> Tool<C, Frame> {
        Tool {
            side: -self.side,
            ..self
        }
    }
}

impl<C: Curve, Frame> Surface for Tool<C, Frame> {
    type Frame = Frame;

    /// `r_θ = S(r)`, `n_θ = w×n`; n_u from c″. None where the curve runs along the screw or has no tangent.
    fn jet(&self, [u, theta]: [f64; 2]) -> Option<Jet> {
        let [c, d, dd] = self.curve.at(u);
        let s = self.screw.at(c);
        let across = d.cross(s) * self.side;
        let length = across.norm();
        if !(length > 0.0) {
            return None;
        }
        let n = across * (1.0 / length);
        let change = (dd.cross(s) + d.cross(self.screw.w.cross(d))) * (self.side / length);
        let at_zero = Jet {
            r: c,
            n,
            dr: [d, s],
            dn: [change - n * n.dot(change), self.screw.w.cross(n)],
        };
        Some(match theta {
            0.0 => at_zero,
            _ => at_zero.moved(&self.exponential.at(theta)),
        })
    }

    fn range(&self) -> [f64; 2] {
        self.curve.range()
    }

    /// The curve's range; a radian, or for a slide the length of the curve.
    fn scales(&self) -> [f64; 2] {
        let [from, to] = self.curve.range();
        let length = (to - from).abs();
        let turns = self.screw.w.norm();
        let slides = || self.curve.at(0.5 * (from + to))[1].norm() * length / self.screw.s.norm();
        [length, if turns > 0.0 { 1.0 / turns } else { slides() }]
    }
}
