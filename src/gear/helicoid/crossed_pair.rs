//! Pairs of involute helical gears on crossed axes: one contact normal, one straight path of contact, point contact.
//!
//! Axis 1 is z, axis 2 passes through (a, 0, 0) along (0, sin Σ, cos Σ); `i = −z₁/z₂`. The base helices alone give the normal:
//! `n·k₁ = sin β_b1`, `n·k₂ = −sin β_b2`, so neither the centre distance nor the shaft angle changes the ratio.

use std::f64::consts::PI;

use crate::gear::kernel::newton::solve;
use crate::gear::kernel::root::sign_change;
use crate::gear::kernel::vector::Vector;

/// A helical gear as its crossed mate sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossedGear {
    /// Number of teeth.
    pub teeth: u32,
    /// Helix angle β at the reference cylinder, positive for a right hand, rad.
    pub helix: f64,
    /// Reference radius r.
    pub radius: f64,
    /// Base radius r_b.
    pub base_radius: f64,
    /// Tip radius r_a.
    pub tip_radius: f64,
    /// Half of the angle of a tooth at the base cylinder, `s_t/(2r) + inv α_t`, rad.
    pub base_half_angle: f64,
}

/// Two gears that share normal module and normal pressure angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossedPair {
    /// Pinion and gear.
    pub gears: [CrossedGear; 2],
    /// Normal pressure angle α_n, rad.
    pub pressure_angle: f64,
    /// Centre distance a.
    pub centre_distance: f64,
    /// Shaft angle Σ, rad.
    pub shaft_angle: f64,
}

/// The path of contact: the line that touches both base cylinders.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossedPath {
    /// Common normal, along the path from gear 1 to gear 2.
    pub direction: Vector,
    /// Points T₁, T₂ where the path touches the base cylinders.
    pub tangent_points: [Vector; 2],
    /// Distance of T₁ from T₂ along the path.
    pub length: f64,
    /// First and last contact as distances from T₁: tip of gear 2, tip of gear 1.
    pub ends: [f64; 2],
    /// Advance of the contact along the path a radian of gear 1.
    pub advance: f64,
    /// Base pitch p_bn.
    pub base_pitch: f64,
    /// Unit vectors from the axes to T₁ and T₂.
    radials: [Vector; 2],
}

impl CrossedPath {
    /// First and last contact within T₁ and T₂: beyond them there is no flank to touch.
    pub fn ends_on_flanks(&self) -> [f64; 2] {
        [self.ends[0].max(0.0), self.ends[1].min(self.length)]
    }
}

/// Contact at a place of the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossedContact {
    /// The point in space.
    pub point: Vector,
    /// Radii of curvature of both flanks across their generators.
    pub radii: [f64; 2],
    /// Principal relative curvatures, the smaller first.
    pub curvatures: [f64; 2],
    /// Their directions, unit vectors.
    pub directions: [Vector; 2],
    /// Sliding velocity a radian of gear 1.
    pub sliding: f64,
}

impl CrossedContact {
    /// Semi-axes of the ellipse under a coating of a thickness: `√(2 δ/κ)`, the longer first.
    pub fn ellipse(&self, coating: f64) -> [f64; 2] {
        self.curvatures.map(|k| (2.0 * coating / k).sqrt())
    }
}

impl CrossedGear {
    /// `sin β_b = sin β cos α_n`.
    fn base_sine(&self, pressure_angle: f64) -> f64 {
        self.helix.sin() * pressure_angle.cos()
    }

    /// Turn a unit of height along the helix, rad.
    pub(super) fn twist(&self) -> f64 {
        self.helix.tan() / self.radius
    }
}

impl CrossedPair {
    /// Distance of the axes at which the reference cylinders touch.
    pub fn reference_centre_distance(&self) -> f64 {
        self.gears.iter().map(|g| g.radius).sum()
    }

    /// Direction of axis 2.
    pub(super) fn second_axis(&self) -> Vector {
        let (sine, cosine) = self.shaft_angle.sin_cos();
        Vector::new(0.0, sine, cosine)
    }

    /// Direction of the axis of a gear.
    pub(super) fn axis(&self, gear: usize) -> Vector {
        [Vector::Z, self.second_axis()][gear]
    }

    /// The path of contact; none where no common normal has these base helices at this shaft angle.
    pub fn path(&self) -> Option<CrossedPath> {
        let alpha = self.pressure_angle;
        let axes = [Vector::Z, self.second_axis()];
        let sines = [
            self.gears[0].base_sine(alpha),
            -self.gears[1].base_sine(alpha),
        ];
        // n = A k₁ + B k₂ − δ (1, 0, 0).
        let (sine, cosine) = self.shaft_angle.sin_cos();
        let square = sine * sine;
        let a = (sines[0] - sines[1] * cosine) / square;
        let b = (sines[1] - sines[0] * cosine) / square;
        let rest = 1.0 - a * sines[0] - b * sines[1];
        if !(rest > 0.0) {
            return None;
        }
        let direction = axes[0] * a + axes[1] * b - Vector::X * rest.sqrt();
        // Advance q = z m_n cos α_n/2 of a gear a radian, r_b cos β_b.
        let advances = self
            .gears
            .map(|g| g.base_radius * (1.0 - g.base_sine(alpha).powi(2)).sqrt());
        let second_origin = Vector::X * self.centre_distance;
        let rows = [
            direction.cross(axes[0]),
            direction.cross(axes[1]),
            direction,
        ];
        let right = [-advances[0], advances[1] + rows[1].dot(second_origin), 0.0];
        let [x, y, z] = solve(rows.map(Vector::array), right)?;
        let start = Vector::new(x, y, z);
        let origins = [Vector::ZERO, second_origin];
        let tangent = |k: usize| {
            let across = |v: Vector| v - axes[k] * v.dot(axes[k]);
            let (from, along) = (across(start - origins[k]), across(direction));
            let place = -from.dot(along) / along.dot(along);
            start + direction * place
        };
        let tangent_points = [tangent(0), tangent(1)];
        let radial = |k: usize| {
            let from = tangent_points[k] - origins[k];
            (from - axes[k] * from.dot(axes[k])).unit()
        };
        let length = (tangent_points[1] - tangent_points[0]).dot(direction);
        let sense = length.signum();
        let reach = |k: usize| {
            let g = &self.gears[k];
            let square = g.tip_radius * g.tip_radius - g.base_radius * g.base_radius;
            square.sqrt() / (1.0 - g.base_sine(alpha).powi(2)).sqrt()
        };
        Some(CrossedPath {
            direction: direction * sense,
            radials: [radial(0)?, radial(1)?],
            tangent_points,
            length: length.abs(),
            ends: [length.abs() - reach(1), reach(0)],
            advance: advances[0],
            base_pitch: PI * 2.0 * advances[0] / f64::from(self.gears[0].teeth),
        })
    }

    /// The contact at a distance from T₁ along the path; none outside the segment between both base cylinders.
    pub fn contact(&self, path: &CrossedPath, distance: f64) -> Option<CrossedContact> {
        let radii = [distance, path.length - distance];
        if !(radii[0] > 0.0 && radii[1] > 0.0) {
            return None;
        }
        let point = path.tangent_points[0] + path.direction * distance;
        // Relative curvature u₁u₁ᵀ/R₁ + u₂u₂ᵀ/R₂, u across the generators.
        let [k1, k2] = radii.map(|r| 1.0 / r);
        let cosine = path.radials[0].dot(path.radials[1]);
        let determinant = k1 * k2 * (1.0 - cosine * cosine);
        let half = 0.5 * (k1 + k2);
        let large = half + (half * half - determinant).max(0.0).sqrt();
        // Azimuth of the direction of the larger from u₁ to n×u₁, by the double angle.
        let [u1, u2] = path.radials;
        let across = path.direction.cross(u1);
        let sine = u2.dot(across);
        let (y, x) = (
            2.0 * k2 * sine * cosine,
            k1 + k2 * (cosine * cosine - sine * sine),
        );
        let (s, c) = (0.5 * y.atan2(x)).sin_cos();
        let ratio = -f64::from(self.gears[0].teeth) / f64::from(self.gears[1].teeth);
        let first = Vector::Z.cross(point);
        let second = self
            .second_axis()
            .cross(point - Vector::X * self.centre_distance);
        Some(CrossedContact {
            point,
            radii,
            curvatures: [determinant / large, large],
            directions: [across * c - u1 * s, u1 * c + across * s],
            sliding: (first - second * ratio).norm(),
        })
    }

    /// Place of the contact nearest the pitch point (r₁, 0, 0), as a distance from T₁.
    pub fn pitch_place(&self, path: &CrossedPath) -> f64 {
        let pitch_point = Vector::X * self.gears[0].radius;
        (pitch_point - path.tangent_points[0]).dot(path.direction)
    }

    /// Extent of the contact along each axis, symmetric about the common perpendicular of the axes.
    pub fn contact_widths(&self, path: &CrossedPath) -> [f64; 2] {
        let ends = path.ends_on_flanks();
        [Vector::Z, self.second_axis()].map(|axis| {
            let along = |place: f64| {
                let point = path.tangent_points[0] + path.direction * place;
                point.dot(axis).abs()
            };
            2.0 * along(ends[0]).max(along(ends[1]))
        })
    }

    /// Least and greatest shaft angle at which these base helices have a common normal, rad.
    pub fn shaft_angles(&self) -> [f64; 2] {
        let alpha = self.pressure_angle;
        let first = self.gears[0].base_sine(alpha).acos();
        let second = (-self.gears[1].base_sine(alpha)).acos();
        [
            (first - second).abs(),
            (first + second).min(2.0 * PI - first - second),
        ]
    }

    /// Tip radius of a gear at which its contact ends where the mate's flank begins.
    pub fn longest_tip_radius(&self, path: &CrossedPath, gear: usize) -> f64 {
        let of = &self.gears[gear];
        let cosine = (1.0 - of.base_sine(self.pressure_angle).powi(2)).sqrt();
        f64::hypot(of.base_radius, path.length * cosine)
    }

    /// Length of the path within both tip cylinders and the base pitch, as a ratio.
    pub fn contact_ratio(path: &CrossedPath) -> f64 {
        let [first, last] = path.ends;
        (last.min(path.length) - first.max(0.0)) / path.base_pitch
    }

    /// Backlash along the common normal; negative where the teeth overlap.
    ///
    /// Both flanks unwind on the path: `2 (T₁T₂ − λ₁ − λ₂)`, `λ = r_b cos β_b (σ + ζ_T/p − θ_T)`, with σ the azimuth of the flank at the base.
    pub fn normal_backlash(&self) -> Option<f64> {
        let path = self.path()?;
        let alpha = self.pressure_angle;
        let axes = [Vector::Z, self.second_axis()];
        let origins = [Vector::ZERO, Vector::X * self.centre_distance];
        let unwound = |k: usize| {
            let g = &self.gears[k];
            let from = path.tangent_points[k] - origins[k];
            let height = from.dot(axes[k]);
            // Azimuth counted from the other axis, about this one.
            let towards = Vector::X * if k == 0 { 1.0 } else { -1.0 };
            let azimuth = from.dot(axes[k].cross(towards)).atan2(from.dot(towards));
            let flank = match k {
                0 => g.base_half_angle,
                _ => g.base_half_angle - PI / f64::from(g.teeth),
            };
            let advance = g.base_radius * (1.0 - g.base_sine(alpha).powi(2)).sqrt();
            advance * (flank + height * g.twist() - azimuth)
        };
        Some(2.0 * (path.length - unwound(0) - unwound(1)))
    }

    /// Centre distance without backlash at a shaft angle, within a tenth of the reference distance.
    pub fn tight_centre_distance(&self) -> Option<f64> {
        let reference = self.reference_centre_distance();
        let backlash = |a: f64| {
            CrossedPair {
                centre_distance: a,
                ..*self
            }
            .normal_backlash()
        };
        sign_change([0.9 * reference, 1.2 * reference], backlash)
    }
}
