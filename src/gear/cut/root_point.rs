//! Bottom of the slot: points of the work beneath the plane in which the tips of the blades turn.
//!
//! A point P that the tip plane, with the normal n and a point c, leaves as metal lies `min n·(P − c)` over the roll beneath it. Settings
//! that change this height change the depth of the slot.

use super::setting::FlankSetup;
use crate::gear::bevel::flank::BevelFlank;
use crate::gear::bevel::frames::{CutterFrame, WorkFrame};
use crate::gear::hand::Hand;
use crate::gear::kernel::motion::Motion;
use crate::gear::kernel::pose::{Point, Pose};
use crate::gear::kernel::root::root;
use crate::gear::kernel::vector::Vector;

/// A point of the root line of a flank with its height beneath the tip plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RootPoint {
    /// Point, m.
    pub point: Point<WorkFrame>,
    /// Turn of the cradle near which the tip plane passes, rad.
    turn: f64,
    /// Height beneath the tip plane, m.
    pub height: f64,
}

/// The pass of the tip plane over a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TipPass {
    /// The point, m.
    pub(super) point: Vector,
    /// Height of the point beneath the plane, m.
    pub(super) height: f64,
    /// Normal of the plane, out of the cutter, in the work.
    pub(super) normal: Vector,
    /// Turn of the cradle, rad.
    pub(super) turn: f64,
}

/// Shares of the face of root points: toe, middle, heel.
const FACE_SHARES: [f64; 3] = [0.0, 0.5, 1.0];

/// Shares of the height at which the flank is sought over a root point, from below: an undercut flank ends above its root.
const HEIGHT_SHARES: [f64; 3] = [0.0, 0.25, 0.5];

/// Half the turn of the cradle in which the pass is sought, rad.
const ROLL: f64 = 0.3;

impl RootPoint {
    /// Points of the root line at toe, middle and heel, below the flank; none where the tip plane does not pass.
    pub fn of(flank: &BevelFlank) -> Option<[RootPoint; 3]> {
        let middle = flank.middle()?;
        let root_point = |face: f64| {
            let from = (middle, flank.section.at(0.5, 0.5));
            let above = |height: &f64| flank.follow(from, flank.section.at(face, *height));
            let at = HEIGHT_SHARES.iter().find_map(above)?;
            let over = flank.envelope.point(at)?.point.coordinates;
            let [z, radius] = flank.section.at(face, 0.0);
            let outwards = radius / f64::hypot(over.x, over.y);
            let point = Point::new(Vector::new(outwards * over.x, outwards * over.y, z));
            let pass = pass(&flank.envelope.motion, &point, at[2])?;
            Some(RootPoint {
                point,
                turn: pass.turn,
                height: pass.height,
            })
        };
        let [toe, mean, heel] = FACE_SHARES.map(root_point);
        Some([toe?, mean?, heel?])
    }

    /// The pass of the tip plane at other settings, the flank turned about the work's axis.
    pub(super) fn pass(&self, setup: &FlankSetup, hand: Hand, turn: f64) -> Option<TipPass> {
        let turned = Pose::<WorkFrame, WorkFrame>::turned(Vector::Z, turn);
        pass(
            &setup.machine.motion(hand).then(turned),
            &self.point,
            self.turn,
        )
    }

    /// Depth of the slot that other settings add here, m; none where their tip plane does not pass.
    pub fn depth_change(&self, setup: &FlankSetup, hand: Hand) -> Option<f64> {
        Some(self.height - self.pass(setup, hand, 0.0)?.height)
    }
}

/// The pass of the tip plane over a point near a turn of the cradle.
fn pass(
    motion: &Motion<WorkFrame, CutterFrame>,
    point: &Point<WorkFrame>,
    near: f64,
) -> Option<TipPass> {
    let r = point.coordinates;
    let turn = match motion.is_fixed() {
        true => 0.0,
        false => root([near - ROLL, near + ROLL], |x| {
            let state = motion.at(x);
            let n = state.pose.rotate(Vector::Z);
            let turning = state.velocity.w.cross(n);
            let change = turning.dot(state.velocity.at(r)) + n.dot(state.rate.at(r));
            Some([-n.dot(state.velocity.at(r)), -change])
        })?,
    };
    let pose = motion.at(turn).pose;
    Some(TipPass {
        point: r,
        height: pose.inverse().apply(r).z,
        normal: pose.rotate(Vector::Z),
        turn,
    })
}
