//! Motions: a product of joints `exp(S q(x))` and fixed poses, with its exact velocity and acceleration.

use std::marker::PhantomData;

use super::law::Law;
use super::pose::{Pose, Transform};
use super::twist::Twist;
use super::vector::Vector;

/// The motion of the frame `From` in the frame `To` over one parameter x.
///
/// It is written from the tool outwards: each joint acts on the result of those before it.
#[derive(Debug, Clone)]
pub struct Motion<To, From> {
    /// Links from the moving body outwards; no two fixed ones are neighbours.
    links: Vec<Link>,
    frames: PhantomData<(To, From)>,
}

#[derive(Debug, Clone)]
enum Link {
    Fixed(Transform),
    Joint { screw: Twist, law: Law },
}

/// A motion at one value of its parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionState {
    /// Pose of the moving body.
    pub pose: Transform,
    /// Velocity of the moving body over the parameter, in outer coordinates.
    pub velocity: Twist,
    /// Rate of the velocity field at a fixed place.
    pub rate: Twist,
}

impl<Frame> Motion<Frame, Frame> {
    /// A body that stays where it is.
    pub fn identity() -> Motion<Frame, Frame> {
        Motion {
            links: Vec::new(),
            frames: PhantomData,
        }
    }
}

impl<To, From> Motion<To, From> {
    /// A body fixed at a pose, as a formate cutter.
    pub fn fixed(pose: Pose<To, From>) -> Motion<To, From> {
        Motion {
            links: vec![Link::Fixed(*pose.transform())],
            frames: PhantomData,
        }
    }

    /// This motion followed by a joint: the body moves by `exp(screw law(x))`, the screw given in `To`.
    pub fn joint(mut self, screw: Twist, law: Law) -> Motion<To, From> {
        self.links.push(Link::Joint { screw, law });
        self
    }

    /// This motion seen from another frame.
    pub fn then<Outer>(self, pose: Pose<Outer, To>) -> Motion<Outer, From> {
        self.followed_by(Motion::fixed(pose))
    }

    /// The product of two motions over the same parameter, `outer` acting on the result of this one.
    pub fn followed_by<Outer>(mut self, outer: Motion<Outer, To>) -> Motion<Outer, From> {
        for link in outer.links {
            match (self.links.last_mut(), link) {
                (Some(Link::Fixed(inner)), Link::Fixed(outer)) => *inner = outer.after(inner),
                (_, link) => self.links.push(link),
            }
        }
        Motion {
            links: self.links,
            frames: PhantomData,
        }
    }

    /// The motion of `To` seen from `From`.
    pub fn inverse(&self) -> Motion<From, To> {
        let links = self.links.iter().rev().map(|link| match link {
            Link::Fixed(transform) => Link::Fixed(transform.inverse()),
            Link::Joint { screw, law } => Link::Joint {
                screw: Twist::default().plus(-1.0, screw),
                law: law.clone(),
            },
        });
        Motion {
            links: links.collect(),
            frames: PhantomData,
        }
    }

    /// Whether nothing moves.
    pub fn is_fixed(&self) -> bool {
        !self.links.iter().any(|l| matches!(l, Link::Joint { .. }))
    }

    /// The pose at x.
    pub fn pose(&self, x: f64) -> Pose<To, From> {
        Pose::new(self.at(x).pose)
    }

    /// Pose, velocity and its rate at x.
    ///
    /// From the outermost joint inwards, P being the pose so far and `k = P S`: `rate += q″ k + q′ [velocity, k]`, `velocity += q′ k`.
    pub fn at(&self, x: f64) -> MotionState {
        let mut state = MotionState {
            pose: Transform::IDENTITY,
            velocity: Twist::default(),
            rate: Twist::default(),
        };
        for link in self.links.iter().rev() {
            match link {
                Link::Fixed(transform) => state.pose = state.pose.after(transform),
                Link::Joint { screw, law } => {
                    let [q, d, dd] = law.at(x);
                    let k = state.pose.carry(screw);
                    let turned = state.velocity.bracket(&k);
                    state.rate = state.rate.plus(dd, &k).plus(d, &turned);
                    state.velocity = state.velocity.plus(d, &k);
                    state.pose = state.pose.after(&Transform::exp(screw, q));
                }
            }
        }
        state
    }
}

impl MotionState {
    /// Acceleration of the body's point at r: `w×v + rate(r)`.
    #[inline]
    pub fn acceleration(&self, r: Vector) -> Vector {
        self.velocity.w.cross(self.velocity.at(r)) + self.rate.at(r)
    }
}
