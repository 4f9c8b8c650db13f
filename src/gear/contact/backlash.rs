//! Backlash of an assembled bevel pair: the rotation of the gear, the pinion held, from contact on the first flanks to contact on the others.

use std::f64::consts::TAU;

use super::contact_path::ContactPath;
use super::pair::FlankPair;
use crate::gear::bevel::tooth::BevelTooth;

/// Positions in a pitch at which the backlash is computed.
const POSITIONS: usize = 12;

/// A pair of flanks on its path.
#[derive(Debug, Clone, Copy)]
pub struct FlankPath<'a> {
    /// The pair.
    pub pair: &'a FlankPair,
    /// Contacts of its flanks.
    pub path: &'a ContactPath,
    /// Sides of pinion and gear: concave 0, convex 1.
    pub sides: [usize; 2],
}

/// Least rotation of the gear, rad, over one pitch from the contact of the first flanks to that of the second; below zero where the teeth
/// jam. None where at some position no pair of teeth touches.
pub fn least_backlash(teeth: [&BevelTooth; 2], paths: [FlankPath; 2]) -> Option<f64> {
    let FlankPath { pair, path, .. } = paths[0];
    let push = (pair.turn(1).at(path.reference.point)).dot(path.reference.normal);
    let pitch = TAU / f64::from(pair.teeth[1]);
    let pinion_angle = |i: usize| pair.pitch() * i as f64 / POSITIONS as f64;
    let mut rotations = (0..POSITIONS).map(|i| {
        let [first, second] = paths.map(|of| of.gear_angle(teeth, pinion_angle(i)));
        let rotation = push.signum() * (second? - first?);
        Some(rotation - pitch * (rotation / pitch).round())
    });
    rotations.try_fold(f64::INFINITY, |least, rotation| Some(least.min(rotation?)))
}

impl FlankPath<'_> {
    /// Angle of the gear's tooth at which these flanks touch at an angle of the pinion's tooth.
    fn gear_angle(&self, teeth: [&BevelTooth; 2], pinion_angle: f64) -> Option<f64> {
        let [from_pinion, from_gear] = [0, 1].map(|k| teeth[k].turn_to_cut(self.sides[k]));
        let leading = self.pair.leading(self.path, pinion_angle - from_pinion)?;
        Some(leading.gear_angle(self.pair) + from_gear)
    }
}
