//! Structure elements of a bevel flank at a point: pressure angle, spiral angle, their change, curvatures of tooth line and profile.
//!
//! With the cone through the point about the axis k: e₃ along its generator, e₂ = k×r̂, e₁ = e₂×e₃ its outward normal. The curve in which
//! the flank cuts a surface of the unit normal m and the normal curvature k_m along the curve's tangent t has the geodesic curvature
//! `(W(t,t) − (n·m) k_m)/(n·(m×t))`: the cone gives the tooth line, the sphere about the apex the profile.

use super::frames::WorkFrame;
use crate::gear::kernel::envelope::FlankPoint;
use crate::gear::kernel::second_order::Curvature;
use crate::gear::kernel::vector::Vector;

/// Structure elements of a flank at a point, seen from the pitch apex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StructureElements {
    /// Distance L from the apex, m.
    pub cone_distance: f64,
    /// Angle δ of the cone through the point, rad.
    pub cone_angle: f64,
    /// Normal pressure angle α, rad: `sin α = n·e₁`.
    pub pressure_angle: f64,
    /// Spiral angle β, rad, of the tooth line towards the heel; positive for right hand.
    pub spiral_angle: f64,
    /// Diagonal coefficient dα/dL along the tooth line, rad/m.
    pub diagonal: f64,
    /// Lengthwise curvature χ of the tooth line in the developed cone, 1/m; positive where it bends towards growing azimuth.
    pub lengthwise_curvature: f64,
    /// Profile curvature ζ on the sphere about the apex, 1/m; positive where it bends towards growing azimuth.
    pub profile_curvature: f64,
    /// Normal curvature along the tooth line, 1/m; metal that bulges is negative.
    pub normal_curvature: f64,
    /// Geodesic torsion along the tooth line, 1/m.
    pub torsion: f64,
}

impl StructureElements {
    /// The structure elements at a point of a flank, the pitch apex so far beyond the crossing point, m; none at an undercut limit, on the
    /// axis, and where a flank touches its cone.
    pub fn of(point: &FlankPoint<WorkFrame>, pitch_apex: f64) -> Option<StructureElements> {
        let r = point.point.coordinates + pitch_apex * Vector::Z;
        let n = point.normal.components;
        let flank = point.second_order.envelope()?;
        let (rho, distance) = (f64::hypot(r.x, r.y), r.norm());
        let e3 = r.unit()?;
        let e2 = Vector::Z.cross(r).unit()?;
        let e1 = e2.cross(e3);
        let cos_delta = e3.z;
        let sin_alpha = n.dot(e1);
        let cos_alpha = (1.0 - sin_alpha * sin_alpha).sqrt();
        let along = towards(n.cross(e1).unit()?, e3);
        let across = along.dot(e2);
        let turn = n.dot(e2) * across * cos_delta / rho;
        let profile = towards(n.cross(e3).unit()?, e1);
        Some(StructureElements {
            cone_distance: distance,
            cone_angle: rho.atan2(r.z),
            pressure_angle: sin_alpha.asin(),
            spiral_angle: across.atan2(along.dot(e3)),
            diagonal: (turn - flank.between(along, e1)) / (cos_alpha * along.dot(e3)),
            // e₁×e₃ points to falling azimuth.
            lengthwise_curvature: -cut(&flank, n, e1, along, -across * across * cos_delta / rho),
            profile_curvature: cut(&flank, n, e3, profile, -1.0 / distance),
            normal_curvature: flank.normal(along),
            torsion: flank.torsion(along),
        })
    }
}

/// Geodesic curvature of the flank's cut with a surface of normal m whose normal curvature along t is k_m.
fn cut(flank: &Curvature, n: Vector, m: Vector, t: Vector, k_m: f64) -> f64 {
    (flank.normal(t) - n.dot(m) * k_m) / n.dot(m.cross(t))
}

/// The vector or its opposite, whichever points towards another.
fn towards(a: Vector, other: Vector) -> Vector {
    if a.dot(other) < 0.0 { -a } else { a }
}
