//! Motions: a product of exponentials `exp(S₁ q₁(x)) … exp(Sₙ qₙ(x)) H` of joints with laws, with its exact velocity and acceleration.
//!
//! Every screw Sᵢ is given in the outer frame where all qᵢ = 0, H is the pose there (Brockett 1984, Robotic manipulators and the product
//! of exponentials formula).

use std::marker::PhantomData;

use super::law::Law;
use super::pose::{Exponential, Pose, Transform};
use super::twist::Twist;
use super::vector::Vector;

/// The motion of the frame `From` in the frame `To` over one parameter x.
///
/// It is written from the tool outwards: each joint and pose acts on the result of those before it.
#[derive(Debug, Clone)]
pub struct Motion<To, From> {
    /// The joints, the innermost first.
    joints: Vec<Joint>,
    /// The pose where all joints are at zero.
    home: Transform,
    frames: PhantomData<(To, From)>,
}

#[derive(Debug, Clone)]
struct Joint {
    screw: Twist,
    exponential: Exponential,
    law: Law,
}

impl Joint {
    fn new(screw: Twist, law: Law) -> Joint {
        Joint {
            exponential: Exponential::of(&screw),
            screw,
            law,
        }
    }
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
        Motion::fixed(Pose::new(Transform::IDENTITY))
    }
}

impl<To, From> Motion<To, From> {
    /// A body fixed at a pose, as a formate cutter.
    pub fn fixed(pose: Pose<To, From>) -> Motion<To, From> {
        Motion {
            joints: Vec::new(),
            home: *pose.transform(),
            frames: PhantomData,
        }
    }

    /// This motion followed by a joint: the body moves by `exp(screw law(x))`, the screw given in `To`.
    pub fn joint(mut self, screw: Twist, law: Law) -> Motion<To, From> {
        self.joints.push(Joint::new(screw, law));
        self
    }

    /// This motion seen from another frame.
    pub fn then<Outer>(self, pose: Pose<Outer, To>) -> Motion<Outer, From> {
        self.followed_by(Motion::fixed(pose))
    }

    /// The product of two motions over the same parameter, `outer` acting on the result of this one.
    pub fn followed_by<Outer>(self, outer: Motion<Outer, To>) -> Motion<Outer, From> {
        let inner = self.joints.into_iter();
        let carried = inner.map(|j| Joint::new(outer.home.carry(&j.screw), j.law));
        Motion {
            joints: carried.chain(outer.joints).collect(),
            home: outer.home.after(&self.home),
            frames: PhantomData,
        }
    }

    /// The motion of `To` seen from `From`.
    pub fn inverse(&self) -> Motion<From, To> {
        let home = self.home.inverse();
        let backwards = |joint: &Joint| {
            let screw = home.carry(&joint.screw);
            Joint::new(screw.times(-1.0), joint.law.clone())
        };
        Motion {
            joints: self.joints.iter().rev().map(backwards).collect(),
            home,
            frames: PhantomData,
        }
    }

    /// Whether nothing moves.
    pub fn is_fixed(&self) -> bool {
        self.joints.is_empty()
    }

    /// The pose at x.
    pub fn pose(&self, x: f64) -> Pose<To, From> {
        Pose::new(self.at(x).pose)
    }

    /// Pose, velocity and its rate at x.
    ///
    /// From the outermost joint inwards, P being the product so far and `k = P S`: `rate += q″ k + q′ [velocity, k]`, `velocity += q′ k`.
    #[inline]
    pub fn at(&self, x: f64) -> MotionState {
        let mut inwards = self.joints.iter().rev();
        let Some(outermost) = inwards.next() else {
            return MotionState {
                pose: self.home,
                velocity: Twist::default(),
                rate: Twist::default(),
            };
        };
        let [q, d, dd] = outermost.law.at(x);
        let mut product = outermost.exponential.at(q);
        let mut velocity = outermost.screw.times(d);
        let mut rate = outermost.screw.times(dd);
        for joint in inwards {
            let [q, d, dd] = joint.law.at(x);
            let k = product.carry(&joint.screw);
            rate = rate.plus(dd, &k).plus(d, &velocity.bracket(&k));
            velocity = velocity.plus(d, &k);
            product = product.after(&joint.exponential.at(q));
        }
        MotionState {
            pose: product.after(&self.home),
            velocity,
            rate,
        }
    }
}

impl MotionState {
    /// Acceleration of the body's point at r: `w×v + rate(r)`.
    #[inline]
    pub fn acceleration(&self, r: Vector) -> Vector {
        self.velocity.w.cross(self.velocity.at(r)) + self.rate.at(r)
    }
}
