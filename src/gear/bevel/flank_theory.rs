//! Contact of two flanks at a pitch point from the normal and the curvature of one: contact line, induced curvature, surface of action.
//!
//! The gear carries the known flank. With `n` at the pressure angle, `b = n×τ`, `v` and `w` of the gear seen from the pinion:
//! `p = −W v + n×w`, `Φ = −n·q`, `D = p·v − Φ`; the contact line is perpendicular to p, the induced curvature is `p pᵀ/D`. The surface of
//! action is tangent to the contact line and to `v₂ − Φ p/p²`: Baxter 1961.

use super::pitch_point::PitchPoint;
use crate::gear::kernel::vector::Vector;

/// Flank of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TheoryFlank {
    /// Concave pinion on convex gear.
    Drive,
    /// Convex pinion on concave gear.
    Coast,
}

/// The known flank at the pitch point; curvatures are positive where the gear is concave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownFlank {
    /// Which flank.
    pub flank: TheoryFlank,
    /// Normal pressure angle α > 0, rad.
    pub pressure_angle: f64,
    /// Normal curvature along the tooth.
    pub curvature: f64,
    /// Geodesic torsion along the tooth, `τᵀ W (n×τ)`.
    pub torsion: f64,
}

/// Contact at the pitch point; lengths are a radian of the pinion where they are speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankTheory {
    /// Components of p along the tooth τ and along `b = n×τ`.
    pub p: [f64; 2],
    /// Φ: zero on the limit of the second kind, at the limit pressure angle.
    pub second_limit: f64,
    /// D: zero on the limit of the first kind; there the limit curvature is met as well.
    pub undercut: f64,
    /// Angle of the contact line with the sliding velocity, from τ towards b, rad.
    pub contact_line: f64,
    /// Cuts of the surface of action: with the pitch plane, from τ towards `t×τ`; with the section across the tooth, from `t×τ` towards t;
    /// rad.
    pub action_cuts: [f64; 2],
}

impl KnownFlank {
    /// The flank of a face-mill cutter: its curvature along the tooth is `cos α/r_c`.
    pub fn of_cutter(flank: TheoryFlank, pressure_angle: f64, cutter_radius: f64) -> KnownFlank {
        let size = pressure_angle.cos() / cutter_radius;
        KnownFlank {
            flank,
            pressure_angle,
            curvature: match flank {
                TheoryFlank::Drive => -size,
                TheoryFlank::Coast => size,
            },
            torsion: 0.0,
        }
    }

    /// The normal out of the pinion's metal.
    fn normal(&self, at: &PitchPoint) -> Vector {
        let side = match self.flank {
            TheoryFlank::Drive => -1.0,
            TheoryFlank::Coast => 1.0,
        };
        let (sin, cos) = self.pressure_angle.sin_cos();
        at.lateral() * (side * cos) + at.normal * sin
    }

    /// The contact with the conjugate pinion; none where p vanishes.
    pub fn contact(&self, at: &PitchPoint) -> Option<FlankTheory> {
        let normal = self.normal(at);
        let across = normal.cross(at.tooth);
        // The normal points out of the pinion, so that the gear's curvature changes its sign; torsion does not.
        let curvature = -self.curvature;
        let v = -at.sliding;
        let w = -at.axes.relative().w;
        let turned = normal.cross(w);
        let p = [
            turned.dot(at.tooth) - curvature * v,
            turned.dot(across) - self.torsion * v,
        ];
        let second_limit = -normal.dot(at.axes.rate(at.point));
        let square = p[0] * p[0] + p[1] * p[1];
        let gradient = at.tooth * p[0] + across * p[1];
        let line = normal.cross(gradient);
        let gear = at.axes.turns()[1].at(at.point);
        let action = line.cross(gear - gradient * (second_limit / square));
        let cut = |plane: Vector, from: Vector, towards: Vector| {
            let along = action.cross(plane);
            (along.dot(towards) / along.dot(from)).atan()
        };
        let found = FlankTheory {
            p,
            second_limit,
            undercut: p[0] * v - second_limit,
            contact_line: (-p[0] / p[1]).atan(),
            action_cuts: [
                cut(at.normal, at.tooth, at.lateral()),
                cut(at.tooth, at.lateral(), at.normal),
            ],
        };
        (square > 0.0 && found.undercut.is_finite()).then_some(found)
    }
}

impl FlankTheory {
    /// Induced normal curvature in the section at an angle from the tooth towards b: pinion less gear, negative where they touch from
    /// outside.
    pub fn induced_curvature(&self, section: f64) -> f64 {
        let (sin, cos) = section.sin_cos();
        (self.p[0] * cos + self.p[1] * sin).powi(2) / self.undercut
    }

    /// Induced geodesic torsion in the section at an angle from the tooth towards b.
    pub fn induced_torsion(&self, section: f64) -> f64 {
        let (sin, cos) = section.sin_cos();
        let along = self.p[0] * cos + self.p[1] * sin;
        along * (self.p[1] * cos - self.p[0] * sin) / self.undercut
    }
}
