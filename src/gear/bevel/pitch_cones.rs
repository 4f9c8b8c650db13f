//! Pitch cones of a hypoid pair from the wheel's radius, a spiral angle and a condition: the limit curvature of the tooth line or a cutter that hobs.
//!
//! Newton's method for the three coordinates of the pitch point, iterated until a step is 3e-8 of its scale: errors below 1e-10; every
//! shaft angle, offset and its sign.

use super::face_hob::FaceHob;
use super::pitch_point::PitchPoint;
use crate::gear::kernel::crossed_axes::CrossedAxes;
use crate::gear::kernel::newton::newton;
use crate::gear::kernel::root::sign_change;
use crate::gear::kernel::vector::Vector;

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

/// Places of the pitch point along the offset at which Newton's method starts, in offsets: it lies near the axis of the pinion.
const STARTS: [f64; 4] = [0.1, 0.0, 0.05, 0.2];
/// Farthest place of the pitch point from the axis of the pinion along the offset, in offsets.
const FARTHEST: f64 = 2.0;
/// Parts of the way to it in which a change of sign is sought where Newton's method fails.
const PARTS: i32 = 64;
/// Step of central differences, in radii of the wheel: error of the derivatives about 1e-10, which slows the last step only.
const DIFFERENCE: f64 = 1e-5;

impl PitchConeDesign {
    /// The pitch point; none where no pitch cones meet the condition.
    pub fn solve(&self) -> Option<PitchPoint> {
        let near = STARTS.iter().find_map(|share| self.newton_from(*share));
        near.or_else(|| self.by_bracket())
    }

    /// Limit curvatures `1/ρ_lim` that pitch cones of this spiral angle reach, least and greatest; none where there are no cones.
    pub fn limit_curvatures(&self) -> Option<[f64; 2]> {
        let shares = (-PARTS..=PARTS).map(|k| FARTHEST * f64::from(k) / f64::from(PARTS));
        let found = shares.filter_map(|share| Some(self.at_share(share)?.limit()?.curvature));
        found.fold(None, |range: Option<[f64; 2]>, k| {
            let [low, high] = range.unwrap_or([k; 2]);
            Some([low.min(k), high.max(k)])
        })
    }

    /// Estimate of y and z of the pitch point: that of a bevel pair.
    fn estimate(&self) -> [f64; 2] {
        let r2 = self.wheel_radius - self.outwards;
        let offset_angle = (self.axes.offset / r2).clamp(-1.0, 1.0).asin();
        let [pinion, wheel] = match self.tooth_line {
            ToothLine::Limit {
                pinion_spiral_angle: beta,
                ..
            } => [beta, beta - offset_angle],
            ToothLine::Hobbed {
                wheel_spiral_angle: beta,
                ..
            } => [beta + offset_angle, beta],
        };
        let r1 = r2 * wheel.cos() * self.axes.ratio.abs() / pinion.cos();
        let (sin, cos) = self.axes.shaft_angle.sin_cos();
        [r1, r1 * (r2 / r1 + cos) / sin]
    }

    fn newton_from(&self, share: f64) -> Option<PitchPoint> {
        let [y, z] = self.estimate();
        let r2 = self.wheel_radius;
        let scales = [0.2 * self.axes.offset.abs(), 0.5 * y, 0.5 * r2];
        let h = DIFFERENCE * r2;
        let found = newton([share * self.axes.offset, y, z], scales, |x| {
            let mut rows = [[0.0; 3]; 3];
            for j in 0..3 {
                let step = |sign: f64| {
                    let mut moved = x;
                    moved[j] += sign * h;
                    self.residual(moved)
                };
                let [plus, minus] = [step(1.0)?, step(-1.0)?];
                (0..3).for_each(|i| rows[i][j] = (plus[i] - minus[i]) / (2.0 * h));
            }
            Some((self.residual(x)?, rows))
        })?;
        let point = PitchPoint::at(&self.axes, Vector::new(found[0], found[1], found[2]))?;
        self.accepted(point)
    }

    /// Residuals at a place: radius, spiral angle, condition.
    fn residual(&self, [x, y, z]: [f64; 3]) -> Option<[f64; 3]> {
        let p = PitchPoint::at(&self.axes, Vector::new(x, y, z))?;
        let radius = p.radii[1] + self.outwards * p.pitch_angles[1].sin();
        let spiral = match self.tooth_line {
            ToothLine::Limit {
                pinion_spiral_angle,
                ..
            } => p.spiral_angles[0] - pinion_spiral_angle,
            ToothLine::Hobbed {
                wheel_spiral_angle, ..
            } => p.spiral_angles[1] - wheel_spiral_angle,
        };
        Some([radius / self.wheel_radius - 1.0, spiral, self.misfit(&p)?])
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

    /// The pitch point at a place along the offset with the stated radius and spiral angle.
    fn at_share(&self, share: f64) -> Option<PitchPoint> {
        let x = share * self.axes.offset;
        let [y, z] = self.estimate();
        let h = DIFFERENCE * self.wheel_radius;
        let found = newton([y, z], [0.5 * y, 0.5 * self.wheel_radius], |[y, z]| {
            let value = |y: f64, z: f64| {
                let r = self.residual([x, y, z])?;
                Some([r[0], r[1]])
            };
            let slopes = [
                [value(y + h, z)?, value(y - h, z)?],
                [value(y, z + h)?, value(y, z - h)?],
            ];
            let slope = |i: usize, j: usize| (slopes[j][0][i] - slopes[j][1][i]) / (2.0 * h);
            Some((
                value(y, z)?,
                [[slope(0, 0), slope(0, 1)], [slope(1, 0), slope(1, 1)]],
            ))
        })?;
        let point = PitchPoint::at(&self.axes, Vector::new(x, found[0], found[1]))?;
        self.accepted(point)
    }

    /// The change of sign of the condition nearest the axis of the pinion.
    fn by_bracket(&self) -> Option<PitchPoint> {
        let off = |share: f64| self.misfit(&self.at_share(share)?);
        let part = FARTHEST / f64::from(PARTS);
        let brackets = (0..PARTS).flat_map(|k| {
            let near = f64::from(k) * part;
            [[near, near + part], [-near - part, -near]]
        });
        let found = brackets
            .into_iter()
            .find_map(|bracket| sign_change(bracket, off));
        self.at_share(found?)
    }

    /// A pitch point whose cones are those of gears: P near the axis of the pinion on the side of the wheel, the pinion's cone external.
    fn accepted(&self, found: PitchPoint) -> Option<PitchPoint> {
        let share = found.point.x / self.axes.offset;
        let external = found.pitch_angles[0] < std::f64::consts::FRAC_PI_2;
        (share.abs() <= FARTHEST && found.point.y > 0.0 && external).then_some(found)
    }
}
