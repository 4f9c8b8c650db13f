//! Contact of two flanks at the pitch point from normal and curvature of one flank: contact line, induced curvature, surface of action.
//!
//! The flank of the gear is given. With the normal n at the pressure angle, `b = n×τ`, velocity v and angular velocity w of the gear
//! relative to the pinion: `p = −W v + n×w`, `Φ = −n·q`, `D = p·v − Φ`. The contact line is perpendicular to p, the induced curvature is
//! `p pᵀ/D`. The surface of action is tangent to the contact line and to `v₂ − Φ p/p²`: Baxter 1961.

use super::pitch_point::PitchPoint;
use crate::gear::kernel::vector::Vector;

/// Flank pair in contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ContactSide {
    /// Concave pinion, convex gear.
    #[default]
    Drive,
    /// Convex pinion, concave gear.
    Coast,
}

impl ContactSide {
    /// Indices of the flanks of pinion and gear: 0 concave, 1 convex.
    pub fn flanks(self) -> [usize; 2] {
        match self {
            ContactSide::Drive => [0, 1],
            ContactSide::Coast => [1, 0],
        }
    }

    /// Opposite side.
    pub fn other(self) -> ContactSide {
        match self {
            ContactSide::Drive => ContactSide::Coast,
            ContactSide::Coast => ContactSide::Drive,
        }
    }

    /// Name: drive or coast.
    pub fn name(self) -> &'static str {
        match self {
            ContactSide::Drive => "drive",
            ContactSide::Coast => "coast",
        }
    }
}

/// Given flank of the gear at the pitch point; curvatures are positive for a concave gear flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownFlank {
    /// Drive or coast flank.
    pub flank: ContactSide,
    /// Normal pressure angle α > 0, rad.
    pub pressure_angle: f64,
    /// Normal curvature along the tooth, per unit length.
    pub curvature: f64,
    /// Geodesic torsion along the tooth, `τᵀ W (n×τ)`, per unit length.
    pub torsion: f64,
}

/// Contact of both flanks at the pitch point; velocities are lengths per radian of the pinion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankTheory {
    /// Components of p along the tooth line τ and along `b = n×τ`.
    pub p: [f64; 2],
    /// Limit function Φ: zero at the limit of the second kind, at the limit pressure angle.
    pub second_limit: f64,
    /// Undercut function D: zero at the limit of the first kind and at the limit curvature.
    pub undercut: f64,
    /// Angle of the contact line to the sliding velocity, from τ towards b, rad.
    pub contact_line: f64,
    /// Angles of the intersections of the surface of action, rad: with the pitch plane, from τ towards `t×τ`; with the section across the
    /// tooth, from `t×τ` towards t.
    pub action_angles: [f64; 2],
}

impl KnownFlank {
    /// Flank cut by a face-mill cutter of radius r_c: the curvature along the tooth is `cos α/r_c`.
    pub fn of_cutter(flank: ContactSide, pressure_angle: f64, cutter_radius: f64) -> KnownFlank {
        let size = pressure_angle.cos() / cutter_radius;
        KnownFlank {
            flank,
            pressure_angle,
            curvature: match flank {
                ContactSide::Drive => -size,
                ContactSide::Coast => size,
            },
            torsion: 0.0,
        }
    }

    /// Unit normal, out of the material of the pinion.
    fn normal(&self, pitch_point: &PitchPoint) -> Vector {
        let side = match self.flank {
            ContactSide::Drive => -1.0,
            ContactSide::Coast => 1.0,
        };
        let (sin, cos) = self.pressure_angle.sin_cos();
        pitch_point.lateral() * (side * cos) + pitch_point.normal * sin
    }

    /// Contact with the conjugate pinion flank; `None` where p vanishes.
    pub fn contact(&self, pitch_point: &PitchPoint) -> Option<FlankTheory> {
        let normal = self.normal(pitch_point);
        let binormal = normal.cross(pitch_point.tooth);
        // The normal points out of the pinion, which reverses the sign of the curvature of the gear; the torsion keeps its sign.
        let curvature = -self.curvature;
        let v = -pitch_point.sliding;
        let w = -pitch_point.axes.relative().w;
        let n_cross_w = normal.cross(w);
        let p = [
            n_cross_w.dot(pitch_point.tooth) - curvature * v,
            n_cross_w.dot(binormal) - self.torsion * v,
        ];
        let second_limit = -normal.dot(pitch_point.axes.rate(pitch_point.point));
        let square = p[0] * p[0] + p[1] * p[1];
        let gradient = pitch_point.tooth * p[0] + binormal * p[1];
        let line = normal.cross(gradient);
        let gear_velocity = pitch_point.axes.turns()[1].at(pitch_point.point);
        let action = line.cross(gear_velocity - gradient * (second_limit / square));
        let intersection = |plane: Vector, from: Vector, towards: Vector| {
            let trace = action.cross(plane);
            (trace.dot(towards) / trace.dot(from)).atan()
        };
        let theory = FlankTheory {
            p,
            second_limit,
            undercut: p[0] * v - second_limit,
            contact_line: (-p[0] / p[1]).atan(),
            action_angles: [
                intersection(pitch_point.normal, pitch_point.tooth, pitch_point.lateral()),
                intersection(pitch_point.tooth, pitch_point.lateral(), pitch_point.normal),
            ],
        };
        (square > 0.0 && theory.undercut.is_finite()).then_some(theory)
    }
}

impl FlankTheory {
    /// Induced normal curvature in the section at an angle (rad) from the tooth towards b: pinion minus gear, negative for contact from
    /// outside.
    pub fn induced_curvature(&self, section: f64) -> f64 {
        let (sin, cos) = section.sin_cos();
        (self.p[0] * cos + self.p[1] * sin).powi(2) / self.undercut
    }

    /// Induced geodesic torsion in the section at an angle (rad) from the tooth towards b.
    pub fn induced_torsion(&self, section: f64) -> f64 {
        let (sin, cos) = section.sin_cos();
        let p_along = self.p[0] * cos + self.p[1] * sin;
        p_along * (self.p[1] * cos - self.p[0] * sin) / self.undercut
    }
}
