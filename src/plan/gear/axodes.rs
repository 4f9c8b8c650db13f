//! Axodes of a pair on two axes: throat radii, angles and screw pitch, and their picture.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::geometry::{Quantities, QuantityUnit};
use super::sheet::SheetPlot;
use crate::gear::kernel::crossed_axes::{Axodes, CrossedAxes};
use crate::gear::kernel::vector::Vector;

/// Suffix of the picture's file.
pub const SUFFIX: &str = "axodes";
/// Generators drawn on each axode.
const GENERATORS: u32 = 24;
/// Points of a circle.
const CIRCLE: u32 = 72;
/// Direction from which the axodes are seen, between the axes and above their plane.
const SEEN_FROM: [f64; 3] = [0.75, 0.45, -0.5];

/// Lists the axodes; nothing where the bodies do not turn against each other.
pub(super) fn quantities(axes: &CrossedAxes, all: &mut Quantities) {
    use QuantityUnit::{Degree, Millimetre};
    let Some(axodes) = axes.axodes() else { return };
    all.each(
        "throat radius of the axode",
        "r_A",
        Millimetre,
        axodes.throat_radii,
    );
    all.each("angle of the axode", "δ_A", Degree, axodes.angles);
    all.pair(
        "screw pitch (mm a radian)",
        "h",
        Millimetre,
        axodes.screw.pitch,
    );
}

/// The axodes with the screw axis between two places along it from its throat, seen obliquely; none for a pair that has none.
pub fn picture(axes: &CrossedAxes, range: [f64; 2]) -> Option<SheetPlot> {
    let axodes = axes.axodes()?;
    let mut curves = Vec::new();
    for (k, name) in ["axode 1", "axode 2"].into_iter().enumerate() {
        curves.push(curve(name, surface(axes, &axodes, k, range)));
    }
    let screw = axodes.screw;
    // Away from both axes' feet, towards the teeth.
    let direction = screw.direction * 1f64.copysign(screw.direction.z);
    let length = range[1] - range[0];
    let reach = [range[0] - 0.1 * length, range[1] + 0.1 * length];
    let ends = reach.map(|place| screw.point + direction * place);
    curves.push(curve("screw axis", ends.to_vec()));
    let mut lines = Vec::new();
    for (direction, foot) in axes.directions().into_iter().zip(axes.feet()) {
        lines.extend(reach.map(|place| foot + direction * place));
        lines.push(GAP);
    }
    curves.push(curve("axes", lines));
    Some(SheetPlot {
        suffix: SUFFIX,
        axes: ["oblique view, across, mm", "oblique view, up, mm"],
        equal_scales: true,
        curves,
        labels: Vec::new(),
    })
}

/// Ends a line of a curve.
const GAP: Vector = Vector::new(f64::NAN, f64::NAN, f64::NAN);

/// Generators of an axode and the circles at both ends: the screw axis turned about the axis of the body.
fn surface(axes: &CrossedAxes, axodes: &Axodes, body: usize, range: [f64; 2]) -> Vec<Vector> {
    let (axis, foot) = (axes.directions()[body], axes.feet()[body]);
    let screw = axodes.screw;
    let direction = screw.direction * 1f64.copysign(screw.direction.z);
    let turned = |point: Vector, angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let r = point - foot;
        let along = axis * r.dot(axis);
        foot + along + (r - along) * cos + axis.cross(r) * sin
    };
    let [first, last] = range.map(|place| screw.point + direction * place);
    let mut points = Vec::new();
    for k in 0..GENERATORS {
        let angle = TAU * f64::from(k) / f64::from(GENERATORS);
        points.extend([turned(first, angle), turned(last, angle), GAP]);
    }
    for from in [first, last] {
        points.extend((0..=CIRCLE).map(|k| turned(from, TAU * f64::from(k) / f64::from(CIRCLE))));
        points.push(GAP);
    }
    points
}

/// Points of space as a curve of the picture, mm: parallel projection, the plane of the axes' directions upright.
fn curve(name: &str, points: Vec<Vector>) -> (String, Vec<f64>, Vec<f64>) {
    let [x, y, z] = SEEN_FROM;
    let view = Vector::new(x, y, z);
    let up = Vector::X;
    let right = up.cross(view).unit().unwrap_or(Vector::Z);
    let above = view.cross(right).unit().unwrap_or(Vector::Y);
    let seen = points
        .into_iter()
        .map(|p| (1e3 * p.dot(right), 1e3 * p.dot(above)));
    let (across, upwards) = seen.unzip();
    (name.to_string(), across, upwards)
}

/// Axes of a worm pair at 90°: the wheel turns against the sense of its axis.
pub(super) fn worm_axes(centre_distance: f64, ratio: f64) -> CrossedAxes {
    CrossedAxes {
        offset: centre_distance,
        shaft_angle: FRAC_PI_2,
        ratio: -ratio,
    }
}
