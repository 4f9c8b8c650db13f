//! Blanks of bevel gears: pitch, face and root cones on one axis and the ends of the teeth.
//!
//! Axial places are counted from the crossing point of the axes (of a hypoid pair from the foot of its common perpendicular) towards the
//! heel. Apexes lie `t_z`, `t_zF`, `t_zR` beyond it: ISO 23509-1:2025.

use super::blank_fault::{End, ToothFault};
use super::tooth_section::ToothSection;

/// Cone to which the ends of the teeth are perpendicular.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EndCone {
    /// Pitch cone.
    #[default]
    Pitch,
    /// Root cone.
    Root,
}

/// The blank of a bevel gear; angles in rad, lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blank {
    /// Pitch angle δ.
    pub pitch_angle: f64,
    /// Face angle δ_a.
    pub face_angle: f64,
    /// Root angle δ_f.
    pub root_angle: f64,
    /// Mean cone distance R_m along the pitch cone.
    pub mean_cone_distance: f64,
    /// Face width b along the pitch cone.
    pub face_width: f64,
    /// Share of the face width outside the mean point, c_be.
    pub outer_share: f64,
    /// Pitch apex beyond the crossing point, t_z.
    pub pitch_apex: f64,
    /// Face apex beyond the crossing point, t_zF.
    pub face_apex: f64,
    /// Root apex beyond the crossing point, t_zR.
    pub root_apex: f64,
    /// Cone to which the ends are perpendicular.
    pub ends: EndCone,
}

impl Blank {
    /// A blank whose cones have one apex at the crossing point, its ends perpendicular to the pitch cone.
    pub fn of_one_apex(
        [pitch_angle, face_angle, root_angle]: [f64; 3],
        mean_cone_distance: f64,
        face_width: f64,
    ) -> Blank {
        Blank {
            pitch_angle,
            face_angle,
            root_angle,
            mean_cone_distance,
            face_width,
            outer_share: 0.5,
            pitch_apex: 0.0,
            face_apex: 0.0,
            root_apex: 0.0,
            ends: EndCone::Pitch,
        }
    }

    /// `[z, radius]` on the pitch cone at a cone distance.
    pub fn on_pitch_cone(&self, distance: f64) -> [f64; 2] {
        let (sin, cos) = self.pitch_angle.sin_cos();
        [distance * cos - self.pitch_apex, distance * sin]
    }

    /// `[z, radius]` of the mean point.
    pub fn mean_point(&self) -> [f64; 2] {
        self.on_pitch_cone(self.mean_cone_distance)
    }

    /// Addendum and dedendum at the mean point, perpendicular to the pitch cone, m.
    pub fn mean_depths(&self) -> [f64; 2] {
        let above = |angle, apex| {
            self.across(self.mean_point(), self.pitch_angle, angle, apex)
                .0
        };
        let dedendum = -above(self.root_angle, self.root_apex);
        [above(self.face_angle, self.face_apex), dedendum]
    }

    /// Inner and outer cone distance R_i, R_e, m.
    pub fn cone_distances(&self) -> [f64; 2] {
        [self.outer_share - 1.0, self.outer_share]
            .map(|share| self.mean_cone_distance + share * self.face_width)
    }

    /// The axial section of a tooth.
    ///
    /// # Errors
    /// Cones between which no tooth lies.
    pub fn section(&self) -> Result<ToothSection, ToothFault> {
        let [inner, outer] = self.cone_distances();
        if !(inner > 0.0) {
            return Err(ToothFault::BeyondApex {
                inner_cone_distance: inner,
            });
        }
        let cone = match self.ends {
            EndCone::Pitch => self.pitch_angle,
            EndCone::Root => self.root_angle,
        };
        let corners = |end: End, distance: f64| {
            let from = self.on_pitch_cone(distance);
            let root = self.across(from, cone, self.root_angle, self.root_apex);
            let tip = self.across(from, cone, self.face_angle, self.face_apex);
            let is_outside = |radius: f64| radius > 0.0 && radius.is_finite();
            if !is_outside(root.1[1]) || !is_outside(tip.1[1]) {
                return Err(ToothFault::AtAxis { end });
            }
            let depth = tip.0 - root.0;
            match depth > 0.0 {
                true => Ok([root.1, tip.1]),
                false => Err(ToothFault::NoDepth { end, depth }),
            }
        };
        Ok(ToothSection {
            corners: [corners(End::Toe, inner)?, corners(End::Heel, outer)?],
        })
    }

    /// Height above a point of the pitch cone, perpendicular to a cone of the angle `normal`, at which another cone is met, and the place
    /// `[z, radius]` there.
    fn across(&self, from: [f64; 2], normal: f64, angle: f64, apex: f64) -> (f64, [f64; 2]) {
        let (dz, dr) = (-normal.sin(), normal.cos());
        let (sin, cos) = angle.sin_cos();
        // The cone: (z + apex) sin − r cos = 0.
        let height = -((from[0] + apex) * sin - from[1] * cos) / (dz * sin - dr * cos);
        (height, [from[0] + height * dz, from[1] + height * dr])
    }
}
