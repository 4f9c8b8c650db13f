//! Pitch cones of a hypoid pair from the wheel's radius, a spiral angle and a condition: the limit curvature of the tooth line or a cutter that hobs.
//!
//! The pitch angle of the pinion is the one free quantity. With it, ζ_mp follows from `a sin Σ = (r₂ cos δ₁ + r₁ cos δ₂) sin ζ_mp` and δ₂ from
//! `cos Σ = cos δ₁ cos δ₂ cos ζ_mp − sin δ₁ sin δ₂`: ISO 23509:2016, Clause 7; every shaft angle, offset and its sign.

use std::f64::consts::FRAC_PI_2;

use super::face_hob::FaceHob;
use super::pitch_point::PitchPoint;
use crate::gear::kernel::crossed_axes::CrossedAxes;
use crate::gear::kernel::root::{greatest, sign_change};
use crate::gear::kernel::vector::Vector;
use crate::numeric::sorting::sort_rising;

/// Data of the pitch cones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PitchConeDesign {
    /// Axes and ratio; the offset is not zero.
    pub axes: CrossedAxes,
    /// Radius of the wheel's pitch cone at a place of it.
    pub wheel_radius: f64,
    /// Distance of that place from the pitch point along the wheel's pitch cone, outwards.
    pub outwards: f64,
    /// Spiral angle and its condition.
    pub tooth_line: ToothLine,
}

/// A spiral angle and the condition that fixes the third coordinate of the pitch point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ToothLine {
    /// The limit curvature of the tooth line.
    Limit {
        /// Spiral angle β₁ of the pinion, rad.
        pinion_spiral_angle: f64,
        /// `1/ρ_lim`, the inverse of the cutter radius.
        curvature: f64,
    },
    /// A cutter that hobs.
    Hobbed {
        /// Spiral angle β₂ of the wheel, rad.
        wheel_spiral_angle: f64,
        /// The cutter.
        cutter: FaceHob,
    },
}

/// Parts of the range of the pinion's pitch angle in which a change of sign of the condition is sought.
const PARTS: u32 = 64;
/// Parts of a right angle in which the least offset angle is sought.
const OFFSET_PARTS: u32 = 48;
/// Least pitch angle of the pinion, and its least distance from the greatest, in shares of the greatest.
const MARGIN: f64 = 1e-3;

impl PitchConeDesign {
    /// The pitch point; of several that meet the condition the one whose pitch angle is nearest that without offset. None where none does.
    pub fn solve(&self) -> Option<PitchPoint> {
        let off = |angle: f64| self.misfit(&self.at(angle)?);
        let [from, to] = self.range();
        let place = |k: u32| from + (to - from) * f64::from(k) / f64::from(PARTS);
        let (sin, cos) = self.axes.shaft_angle.sin_cos();
        let plain = sin.atan2(1.0 / self.axes.ratio.abs() + cos);
        let apart = |angle: f64| (angle - plain).abs();
        let least = |[a, b]: &[f64; 2]| apart(plain.clamp(*a, *b));
        let mut parts: Vec<[f64; 2]> = (0..PARTS).map(|k| [place(k), place(k + 1)]).collect();
        sort_rising(&mut parts, least);
        // A part further off than an angle found holds no nearer one.
        let mut nearest: Option<f64> = None;
        for part in parts {
            if nearest.is_some_and(|angle| apart(angle) <= least(&part)) {
                break;
            }
            let angles = sign_change(part, off).into_iter().chain(nearest);
            nearest = angles.min_by(|a, b| apart(*a).total_cmp(&apart(*b)));
        }
        self.at(nearest?)
    }

    /// Limit curvatures `1/ρ_lim` that pitch cones of this spiral angle reach, least and greatest; none where there are no cones.
    pub fn limit_curvatures(&self) -> Option<[f64; 2]> {
        let most = |sign: f64| {
            let curvature = |angle: f64| Some(sign * self.at(angle)?.limit()?.curvature);
            greatest(self.range(), PARTS, curvature).map(|[_, most]| sign * most)
        };
        Some([most(-1.0)?, most(1.0)?])
    }

    /// Pitch angles of external pinions, rad.
    fn range(&self) -> [f64; 2] {
        let greatest = self.axes.shaft_angle.min(FRAC_PI_2);
        [MARGIN * greatest, (1.0 - MARGIN) * greatest]
    }

    /// The pitch point by the pitch angle of the pinion, of the least offset angle; none where no cones have it.
    fn at(&self, pinion: f64) -> Option<PitchPoint> {
        let CrossedAxes {
            offset: a,
            shaft_angle,
            ..
        } = self.axes;
        let (sin_s, cos_s) = shaft_angle.sin_cos();
        let off = |zeta: f64| {
            let (wheel, [r1, r2]) = self.radii(pinion, zeta)?;
            Some((r2 * pinion.cos() + r1 * wheel.cos()) * zeta.sin() - a * sin_s)
        };
        let place = |k: u32| (FRAC_PI_2 * f64::from(k) / f64::from(OFFSET_PARTS)).copysign(a);
        let zeta = (0..OFFSET_PARTS).find_map(|k| sign_change([place(k), place(k + 1)], off))?;
        let (wheel, [r1, r2]) = self.radii(pinion, zeta)?;
        // t_zm1 and t_zm2 of Clause 7: heights of P along both axes.
        let zeta_m = (zeta.sin() * pinion.cos() / sin_s).asin();
        let across = r2 + r1 * wheel.cos() / pinion.cos();
        let height_2 = r1 * wheel.sin() / pinion.cos() + zeta_m.cos() * across * cos_s / sin_s;
        let height_1 = r2 * zeta_m.cos() * sin_s + height_2 * cos_s;
        let point = Vector::new(
            a - r2 * zeta_m.sin(),
            (height_2 - height_1 * cos_s) / sin_s,
            height_1,
        );
        PitchPoint::at(&self.axes, point)
    }

    /// Pitch angle of the wheel and radii of the pitch point by the pitch angle of the pinion and the offset angle in the pitch plane; none
    /// where a spiral angle leaves ±90° or no cone of the wheel touches.
    fn radii(&self, pinion: f64, zeta: f64) -> Option<(f64, [f64; 2])> {
        let [beta_1, beta_2] = match self.tooth_line {
            ToothLine::Limit {
                pinion_spiral_angle: beta,
                ..
            } => [beta, beta - zeta],
            ToothLine::Hobbed {
                wheel_spiral_angle: beta,
                ..
            } => [beta + zeta, beta],
        };
        let (along, up) = (pinion.cos() * zeta.cos(), pinion.sin());
        let wheel = (self.axes.shaft_angle.cos() / along.hypot(up)).acos() - up.atan2(along);
        let is_pair = beta_1.abs() < FRAC_PI_2 && beta_2.abs() < FRAC_PI_2 && wheel > 0.0;
        let r2 = self.wheel_radius - self.outwards * wheel.sin();
        let r1 = r2 * self.axes.ratio.abs() * beta_2.cos() / beta_1.cos();
        is_pair.then_some((wheel, [r1, r2]))
    }

    /// Residual of the condition, relative.
    fn misfit(&self, p: &PitchPoint) -> Option<f64> {
        match self.tooth_line {
            ToothLine::Limit { curvature, .. } => {
                Some(self.wheel_radius * (p.limit()?.curvature - curvature))
            }
            ToothLine::Hobbed { cutter, .. } => cutter.misfit(p),
        }
    }
}
