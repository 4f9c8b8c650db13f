//! Tools: a curve swept by a screw, `r(u, θ) = exp(S θ) c(u)`, with the normal along `c′ × S(c)`.
//!
//! | curve | screw | tool |
//! |---|---|---|
//! | line | turn | cone of a blade, conical grinding wheel, plane wheel |
//! | arc | turn | curved blade and edge radius of a cutter, ball, torus wheel |
//! | line | slide | flank of a rack |
//! | line, arc | screw | helicoid: worm, hob |

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

/// An arc by its length u, `c(u) = c₀ + t sin(ku)/k + κ (1 − cos ku)/k²` with k = |κ|; a straight line where κ = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// Point c₀ at u = 0.
    pub point: Vector,
    /// Unit tangent t there; that of a straight line may have any length.
    pub direction: Vector,
    /// Curvature vector κ there, perpendicular to the tangent and towards the centre.
    pub curvature: Vector,
    /// First and last u.
    pub range: [f64; 2],
}

impl Arc {
    /// A straight line.
    pub fn straight(point: Vector, direction: Vector, range: [f64; 2]) -> Arc {
        Arc {
            point,
            direction,
            curvature: Vector::ZERO,
            range,
        }
    }

    /// The arc of a circle about a centre between two angles, rad, from `first` towards `second`, perpendicular unit vectors; u = 0 lies at
    /// `first`.
    pub fn about(
        centre: Vector,
        radius: f64,
        [first, second]: [Vector; 2],
        angles: [f64; 2],
    ) -> Arc {
        Arc {
            point: centre + first * radius,
            direction: second,
            curvature: first * (-1.0 / radius),
            range: angles.map(|angle| radius * angle),
        }
    }

    /// The same curve with its length measured from the point at u on, over a range of that length.
    pub fn measured_from(&self, u: f64, range: [f64; 2]) -> Arc {
        let [point, direction, curvature] = self.at(u);
        Arc {
            point,
            direction,
            curvature,
            range,
        }
    }
}

impl Curve for Arc {
    fn at(&self, u: f64) -> [Vector; 3] {
        let (t, kappa) = (self.direction, self.curvature);
        let k = kappa.norm();
        if k == 0.0 {
            return [self.point + t * u, t, kappa];
        }
        let (sin, cos) = (k * u).sin_cos();
        // 1 − cos ku without cancellation, for arcs of a small angle.
        let rise = 2.0 * ((0.5 * k * u).sin() / k).powi(2);
        [
            self.point + t * (sin / k) + kappa * rise,
            t * cos + kappa * (sin / k),
            kappa * cos - t * (k * sin),
        ]
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

impl<C, Frame> Tool<C, Frame> {
    /// The curve turns; else it slides.
    pub fn is_turned(&self) -> bool {
        self.screw.w.norm() > 0.0
    }
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
