//! Pitch cones of a hypoid pair from the wheel radius, a spiral angle and a condition: the limit curvature or a face-hobbing cutter.
//!
//! The pinion pitch angle is the unknown. With it, ζ_mp follows from `a sin Σ = (r₂ cos δ₁ + r₁ cos δ₂) sin ζ_mp` and δ₂ from
//! `cos Σ = cos δ₁ cos δ₂ cos ζ_mp − sin δ₁ sin δ₂`: ISO 23509:2016, Clause 7; every shaft angle, offset and its sign.

use std::f64::consts::FRAC_PI_2;

use super::face_hob::FaceHob;
use super::pitch_point::PitchPoint;
use crate::gear::kernel::crossed_axes::CrossedAxes;
use crate::gear::kernel::root::{greatest, sign_change};
use crate::gear::kernel::vector::Vector;
use crate::numeric::sorting::sort_ascending;

/// Data of the pitch cones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PitchConeDesign {
    /// Axes and ratio; the offset is not zero.
    pub axes: CrossedAxes,
    /// Radius of the wheel pitch cone at a reference point, m.
    pub wheel_radius: f64,
    /// Distance of the reference point from the pitch point along the wheel pitch cone, positive outwards, m.
    pub outwards: f64,
    /// Spiral angle and condition of the pitch point.
    pub tooth_line: ToothLine,
}

/// Spiral angle with the condition for the third coordinate of the pitch point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ToothLine {
    /// Limit curvature of the tooth line.
    Limit {
        /// Spiral angle β₁ of the pinion, rad.
        pinion_spiral_angle: f64,
        /// `1/ρ_lim`, the inverse of the cutter radius, 1/m.
        curvature: f64,
    },
    /// Face hobbing.
    Hobbed {
        /// Spiral angle β₂ of the wheel, rad.
        wheel_spiral_angle: f64,
        /// The cutter.
        cutter: FaceHob,
    },
}

/// Number of intervals of the pinion pitch angle searched for a sign change of the condition.
const PARTS: u32 = 64;
/// Number of intervals of a right angle searched for the smallest offset angle.
const OFFSET_PARTS: u32 = 48;
/// Margin of the pinion pitch angle at both ends of its range, relative to the maximum.
const MARGIN: f64 = 1e-3;

impl PitchConeDesign {
    /// Pitch point that satisfies the condition, with the pinion pitch angle nearest that without offset; `None` without a solution.
    pub fn solve(&self) -> Option<PitchPoint> {
        let residual = |angle: f64| self.residual(&self.pitch_point(angle)?);
        let [from, to] = self.range();
        let bound = |k: u32| from + (to - from) * f64::from(k) / f64::from(PARTS);
        let (sin, cos) = self.axes.shaft_angle.sin_cos();
        let without_offset = sin.atan2(1.0 / self.axes.ratio.abs() + cos);
        let distance = |angle: f64| (angle - without_offset).abs();
        let min_distance = |[a, b]: &[f64; 2]| distance(without_offset.clamp(*a, *b));
        let mut intervals: Vec<[f64; 2]> = (0..PARTS).map(|k| [bound(k), bound(k + 1)]).collect();
        sort_ascending(&mut intervals, min_distance);
        // Intervals beyond the nearest root contain no nearer one.
        let mut nearest: Option<f64> = None;
        for interval in intervals {
            if nearest.is_some_and(|angle| distance(angle) <= min_distance(&interval)) {
                break;
            }
            let angles = sign_change(interval, residual).into_iter().chain(nearest);
            nearest = angles.min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        }
        self.pitch_point(nearest?)
    }

    /// Smallest and largest limit curvature `1/ρ_lim` of pitch cones with this spiral angle, 1/m; `None` without such cones.
    pub fn limit_curvatures(&self) -> Option<[f64; 2]> {
        let extreme = |sign: f64| {
            let curvature = |angle: f64| Some(sign * self.pitch_point(angle)?.limit()?.curvature);
            greatest(self.range(), PARTS, curvature).map(|[_, max]| sign * max)
        };
        Some([extreme(-1.0)?, extreme(1.0)?])
    }

    /// Range of the pitch angle of external pinions, rad.
    fn range(&self) -> [f64; 2] {
        let greatest = self.axes.shaft_angle.min(FRAC_PI_2);
        [MARGIN * greatest, (1.0 - MARGIN) * greatest]
    }

    /// Pitch point of the smallest offset angle for a pinion pitch angle; `None` without such cones.
    fn pitch_point(&self, pinion: f64) -> Option<PitchPoint> {
        let CrossedAxes {
            offset: a,
            shaft_angle,
            ..
        } = self.axes;
        let (sin_s, cos_s) = shaft_angle.sin_cos();
        let f = |zeta: f64| {
            let (wheel, [r1, r2]) = self.radii(pinion, zeta)?;
            Some((r2 * pinion.cos() + r1 * wheel.cos()) * zeta.sin() - a * sin_s)
        };
        let bound = |k: u32| (FRAC_PI_2 * f64::from(k) / f64::from(OFFSET_PARTS)).copysign(a);
        let zeta = (0..OFFSET_PARTS).find_map(|k| sign_change([bound(k), bound(k + 1)], f))?;
        let (wheel, [r1, r2]) = self.radii(pinion, zeta)?;
        // t_zm1 and t_zm2 of Clause 7: coordinates of P along both axes.
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

    /// Wheel pitch angle and radii of the pitch point for the pinion pitch angle and the offset angle in the pitch plane; `None` if a
    /// spiral angle exceeds ±90° or no wheel cone touches.
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
        let is_valid = beta_1.abs() < FRAC_PI_2 && beta_2.abs() < FRAC_PI_2 && wheel > 0.0;
        let r2 = self.wheel_radius - self.outwards * wheel.sin();
        let r1 = r2 * self.axes.ratio.abs() * beta_2.cos() / beta_1.cos();
        is_valid.then_some((wheel, [r1, r2]))
    }

    /// Relative residual of the condition.
    fn residual(&self, p: &PitchPoint) -> Option<f64> {
        match self.tooth_line {
            ToothLine::Limit { curvature, .. } => {
                Some(self.wheel_radius * (p.limit()?.curvature - curvature))
            }
            ToothLine::Hobbed { cutter, .. } => cutter.misfit(p),
        }
    }
}
