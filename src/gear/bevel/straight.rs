//! Straight and skew bevel flanks: octoids, made by the plane flank of a crown gear, and spherical involutes.
//!
//! The crown gear rolls on the pitch cone, `φ_w = φ_c/sin δ`; its tooth flank is a plane at the pressure angle. A spherical involute is the
//! same envelope with the base cone `sin δ_b = sin δ cos α` in place of the pitch cone and a plane perpendicular to the rolling plane:
//! Litvin and Fuentes, Gear Geometry and Applied Theory, 2nd ed. 2004, chapter 20.

use std::f64::consts::TAU;

use super::cutter::{Blade, BladeSurfaces};
use super::flank::BevelFlank;
use super::frames::WorkFrame;
use super::settings::{MachineSettings, Roll};
use super::tooth_section::ToothSection;
use crate::gear::hand::Hand;
use crate::gear::kernel::envelope::FlankPoint;
use crate::gear::kernel::tool::{Arc, Tool};
use crate::gear::kernel::twist::Twist;
use crate::gear::kernel::vector::Vector;

/// Profile of a straight bevel tooth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StraightProfile {
    /// Envelope of the plane flank of a crown gear.
    Octoid,
    /// Traced by a line of a plane that rolls on the base cone.
    SphericalInvolute,
}

/// Flanks of a straight bevel gear that its pitch cone and pressure angle determine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StraightFlanks {
    /// Profile.
    pub profile: StraightProfile,
    /// Pressure angle α, rad.
    pub pressure_angle: f64,
    /// Angle of a skew tooth line with the element of the pitch cone at the mean point, rad; 0 for straight teeth and spherical involutes.
    pub skew_angle: f64,
    /// Pitch angle δ, rad.
    pub pitch_angle: f64,
    /// Mean cone distance R_m, m.
    pub mean_cone_distance: f64,
    /// Pitch apex beyond the crossing point, m.
    pub pitch_apex: f64,
}

/// Depths of the tooth that the plane reaches above and below the cone on which it rolls.
const PLANE_DEPTHS: f64 = 6.0;

impl StraightFlanks {
    /// The flank of a side: the outside blade names the concave flank of spiral teeth, the inside blade the convex one.
    pub fn flank(&self, side: Blade, hand: Hand, section: ToothSection) -> BevelFlank {
        let h = hand.sign();
        let outwards = match side {
            Blade::Inside => h,
            Blade::Outside => -h,
        };
        let (rolling_angle, tilt, place) = match self.profile {
            StraightProfile::Octoid => (self.pitch_angle, self.pressure_angle, 0.0),
            StraightProfile::SphericalInvolute => {
                let base = self.base_angle();
                // Where the line of the rolling plane lies on the pitch cone.
                let place = (self.pitch_angle.cos() / base.cos()).min(1.0).acos();
                (base, 0.0, -outwards * place)
            }
        };
        let turned = |x: f64, y: f64| {
            let (sin, cos) = place.sin_cos();
            Vector::new(x * cos - y * sin, x * sin + y * cos, 0.0)
        };
        let (skew_sin, skew_cos) = self.skew_angle.sin_cos();
        let along = turned(skew_cos, h * skew_sin);
        let across = turned(-h * skew_sin, skew_cos);
        let mean = turned(self.mean_cone_distance, 0.0);
        let reach = PLANE_DEPTHS * section.depth();
        let line = Arc::straight(
            // A turn of the parameter θ runs over twice the cone distance, with the mean point in its middle.
            mean - along * (h * self.mean_cone_distance),
            across * (outwards * tilt.sin()) - Vector::Z * tilt.cos(),
            [-reach, reach],
        );
        let slide = Twist::slide(along * (h * 2.0 * self.mean_cone_distance / TAU));
        let plane = Tool::new(line, slide);
        let settings = MachineSettings {
            radial_distance: 0.0,
            cradle_angle: 0.0,
            blank_offset: 0.0,
            sliding_base: 0.0,
            helical_motion: 0.0,
            centre_to_back: self.pitch_apex,
            machine_root_angle: rolling_angle,
            tilt: 0.0,
            swivel: 0.0,
            roll: Some(Roll::constant(1.0 / rolling_angle.sin())),
        };
        let plane = match side {
            Blade::Inside => plane,
            Blade::Outside => plane.flipped(),
        };
        let surfaces = BladeSurfaces {
            blade: plane,
            toprem: None,
            edge: None,
        };
        BevelFlank::of_blade(surfaces, settings.motion(hand), section)
    }

    /// Whether a tool whose teeth reach the root cone touches at a point of the flank; beyond it the fillet begins. A spherical involute has
    /// no tool: it ends at its base cone.
    pub fn is_cut_above_root(&self, point: &FlankPoint<WorkFrame>, root_angle: f64) -> bool {
        let depth = -point.at[0] * self.pressure_angle.cos();
        let deepest = point.point.coordinates.norm() * (self.pitch_angle - root_angle).tan();
        self.profile == StraightProfile::Octoid && depth < deepest
    }

    /// Angle of the base cone, `sin δ_b = sin δ cos α`, rad.
    pub fn base_angle(&self) -> f64 {
        (self.pitch_angle.sin() * self.pressure_angle.cos()).asin()
    }
}
