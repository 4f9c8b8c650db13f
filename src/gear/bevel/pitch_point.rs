//! The pitch point of a hypoid pair: pitch plane, pitch cones, spiral angles, limit pressure angle and limit curvature of the tooth line.
//!
//! The normal t of the pitch plane at P runs along the line through P that meets both axes, `t ∥ (k₁×P) × (k₂×(P − O₂))`; the tooth runs
//! along the sliding velocity. `n_lim ∥ τ × q` with `q = ω₁×v₂ − ω₂×v₁` is the normal for which the contact line stands still on both
//! flanks, `κ_lim = (n_lim×ω₁₂)·v/v²` the curvature that goes with it: Baxter 1961, Basic geometry and tooth contact of hypoid gears;
//! closed forms in ISO 23509:2016, (32) and (33).

use crate::gear::kernel::crossed_axes::CrossedAxes;
use crate::gear::kernel::vector::Vector;

/// A pitch point with its pitch plane and cones; the pinion is body 1. Mirrored where the hand is the other one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PitchPoint {
    /// Axes and ratio.
    pub axes: CrossedAxes,
    /// The point P.
    pub point: Vector,
    /// Unit normal t of the pitch plane, from the pinion to the gear.
    pub normal: Vector,
    /// Unit tangent τ of the tooth line, from toe to heel of the pinion.
    pub tooth: Vector,
    /// Sliding velocity along τ for a radian of the pinion; below zero where the gear has the larger spiral angle.
    pub sliding: f64,
    /// Pitch angles δ, rad; above 90° for an internal cone.
    pub pitch_angles: [f64; 2],
    /// Distances R of P from the pitch apexes.
    pub cone_distances: [f64; 2],
    /// Distances r of P from the axes.
    pub radii: [f64; 2],
    /// Places of P along the axes.
    pub heights: [f64; 2],
    /// Spiral angles β; their difference is the offset angle in the pitch plane, rad.
    pub spiral_angles: [f64; 2],
}

/// Limit normal of a pitch point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitNormal {
    /// Limit pressure angle α_lim with the sign of ISO 23509, rad.
    pub pressure_angle: f64,
    /// Limit curvature of the tooth line `1/ρ_lim`.
    pub curvature: f64,
}

/// The screw axis against the pitch plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScrewInPlane {
    /// Angle with the pitch plane, rad.
    pub angle: f64,
    /// Place at which it pierces the pitch plane, from P along the tooth and across it.
    pub pierces: [f64; 2],
}

/// Sliding below this share of the pinion's speed is none: the tooth line of a pair without offset is free.
const NO_SLIDING: f64 = 1e-9;

impl PitchPoint {
    /// The pitch point at a place; none on an axis, where the axes and the place lie in a plane, and where nothing slides.
    pub fn at(axes: &CrossedAxes, point: Vector) -> Option<PitchPoint> {
        let [k1, k2] = axes.directions();
        let [o1, o2] = axes.feet();
        let normal = k1.cross(point - o1).cross(k2.cross(point - o2)).unit()?;
        // The axes are met on either side of P: t points away from the axis of the pinion.
        let outward = (point - k1 * point.dot(k1)).dot(normal);
        let normal = normal * 1f64.copysign(outward);
        let relative = axes.relative().at(point);
        let along = (relative - normal * relative.dot(normal)).unit()?;
        let first = element(k1, o1, point, normal)?;
        let tooth = along * 1f64.copysign(along.dot(first.0));
        PitchPoint::with_tooth(axes, point, normal, tooth)
            .filter(|found| found.sliding.abs() > NO_SLIDING * found.radii[0])
    }

    /// The pitch point of a pair without offset, at a cone distance with the spiral angle of the pinion.
    pub fn of_bevel(axes: &CrossedAxes, distance: f64, spiral_angle: f64) -> Option<PitchPoint> {
        let [k1, k2] = axes.directions();
        let element = axes.relative().w.unit()?;
        let element = element * 1f64.copysign(element.dot(k1));
        // Towards the gear's side of the pinion's axis, where the pitch elements run between the axes.
        let normal = Vector::X.cross(element);
        let normal = normal * 1f64.copysign(normal.dot(k2 - k1 * k1.dot(k2)));
        let (sin, cos) = spiral_angle.sin_cos();
        let tooth = element * cos - normal.cross(element) * sin;
        PitchPoint::with_tooth(axes, element * distance, normal, tooth)
    }

    fn with_tooth(
        axes: &CrossedAxes,
        point: Vector,
        normal: Vector,
        tooth: Vector,
    ) -> Option<PitchPoint> {
        let ([k1, k2], [o1, o2]) = (axes.directions(), axes.feet());
        let cones = [
            element(k1, o1, point, normal)?,
            element(k2, o2, point, normal)?,
        ];
        let spiral = |e: Vector| {
            // An internal cone has its apex on the other side of P.
            let e = e * 1f64.copysign(e.dot(tooth));
            -normal.dot(e.cross(tooth)).atan2(e.dot(tooth))
        };
        let from_axis = |k: Vector, o: Vector| (k.cross(point - o)).norm();
        let found = PitchPoint {
            axes: *axes,
            point,
            normal,
            tooth,
            sliding: axes.relative().at(point).dot(tooth),
            pitch_angles: [cones[0].0.dot(k1), cones[1].0.dot(k2)].map(f64::acos),
            cone_distances: cones.map(|c| c.1),
            radii: [from_axis(k1, o1), from_axis(k2, o2)],
            heights: [k1.dot(point - o1), k2.dot(point - o2)],
            spiral_angles: cones.map(|c| spiral(c.0)),
        };
        found.is_finite().then_some(found)
    }

    fn is_finite(&self) -> bool {
        let lists = [self.pitch_angles, self.cone_distances, self.spiral_angles];
        self.sliding.is_finite() && lists.iter().flatten().all(|x| x.is_finite())
    }

    /// `t × τ`, across the tooth in the pitch plane.
    pub fn lateral(&self) -> Vector {
        self.normal.cross(self.tooth)
    }

    /// Offset angle in the pitch plane ζ_mp, rad.
    pub fn offset_angle(&self) -> f64 {
        self.spiral_angles[0] - self.spiral_angles[1]
    }

    /// Offset angle in the axial plane of the pinion ζ_m, `sin ζ_m = a/(r₂ + r₁ cos δ₂/cos δ₁)`: ISO 23509:2016 (113), rad.
    pub fn axial_offset_angle(&self) -> f64 {
        let ([r1, r2], [d1, d2]) = (self.radii, self.pitch_angles);
        (self.axes.offset / (r2 + r1 * d2.cos() / d1.cos())).asin()
    }

    /// The limit normal; none for a pair without sliding at P, where every curvature of the tooth line is free.
    pub fn limit(&self) -> Option<LimitNormal> {
        if !(self.sliding.abs() > NO_SLIDING * self.radii[0]) {
            return None;
        }
        let normal = self.tooth.cross(self.axes.rate(self.point)).unit()?;
        let normal = normal * 1f64.copysign(normal.dot(self.lateral()));
        let w = self.axes.relative().w;
        let curvature = -normal.cross(w).dot(self.tooth) / self.sliding;
        Some(LimitNormal {
            pressure_angle: -normal.dot(self.normal).atan2(normal.dot(self.lateral())),
            curvature,
        })
    }

    /// The screw axis against the pitch plane; none where it is parallel to the plane.
    pub fn screw_axis(&self) -> Option<ScrewInPlane> {
        let axis = self.axes.relative().screw_axis()?;
        let rise = axis.direction.dot(self.normal);
        let to_plane = (self.point - axis.point).dot(self.normal) / rise;
        let pierces = axis.point + axis.direction * to_plane - self.point;
        to_plane.is_finite().then(|| ScrewInPlane {
            angle: rise.abs().min(1.0).asin(),
            pierces: [pierces.dot(self.tooth), pierces.dot(self.lateral())],
        })
    }
}

/// Unit vector from the apex of a cone to P and its length: the apex is where the axis pierces the pitch plane.
fn element(axis: Vector, foot: Vector, point: Vector, normal: Vector) -> Option<(Vector, f64)> {
    let apex = foot + axis * ((point - foot).dot(normal) / axis.dot(normal));
    let along = point - apex;
    Some((along.unit()?, along.norm()))
}
