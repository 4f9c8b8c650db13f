//! Gap between the pitch cones of two blanks, `min (ρ cos δ₂ − h sin δ₂)` over the circle of mean points of the pinion, with the distance ρ from
//! the axis of the gear and the height h above its pitch apex.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::blank::Blank;
use crate::gear::kernel::crossed_axes::CrossedAxes;
use crate::gear::kernel::root::greatest;
use crate::gear::kernel::vector::Vector;

/// Parts of a turn at whose ends the gap is compared.
const PARTS: u32 = 64;

/// The gap between the pitch cones at the mean point of the pinion, m; below zero where they overlap.
pub fn pitch_cone_gap(axes: &CrossedAxes, [pinion, gear]: [&Blank; 2]) -> f64 {
    let ([_, axis], [_, foot]) = (axes.directions(), axes.feet());
    let [z, radius] = pinion.mean_point();
    let (sin, cos) = gear.pitch_angle.sin_cos();
    let into_gear = |angle: f64| {
        let place = Vector::new(radius * angle.cos(), radius * angle.sin(), z) - foot;
        let height = place.dot(axis) + gear.pitch_apex;
        height * sin - axis.cross(place).norm() * cos
    };
    let turn = [-FRAC_PI_2, TAU - FRAC_PI_2];
    let most = greatest(turn, PARTS, |angle| Some(into_gear(angle)));
    most.map_or(f64::NAN, |[_, overlap]| -overlap)
}
