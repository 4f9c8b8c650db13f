//! Axial profiles `g(ρ)` of helicoids `z = g(ρ) + p χ`, with their sections.

use super::grinding_wheel::GrindingWheel;
use super::profile_point::{LAST_STEP, NEWTON_STEPS, ProfilePoint};

/// Axial profile of a flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AxialProfile {
    /// A line of the axial plane.
    Straight {
        /// Slope dg/dρ.
        slope: f64,
    },
    /// The involute helicoid of a base cylinder.
    Involute {
        /// Base radius r_b.
        base_radius: f64,
    },
    /// A line of a plane across the thread, `s = offset + slope x`, with s along the normal of the thread at its reference cylinder.
    NormalLine {
        /// Lead angle of the plane's normal, rad.
        lead_angle: f64,
        /// Value of s at x = 0.
        offset: f64,
        /// Slope ds/dx.
        slope: f64,
    },
    /// Ground by a wheel.
    Ground(GrindingWheel),
}

/// A helicoid `z = g(ρ) + p χ`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Helicoid {
    /// Lead parameter p, the advance a radian.
    pub lead: f64,
    /// Axial profile.
    pub profile: AxialProfile,
    /// Axial position, added to the profile.
    pub shift: f64,
}

impl Helicoid {
    /// The same helicoid through the axial height at a radius; none where the flank does not reach that radius.
    pub fn through(self, radius: f64, height: f64) -> Option<Helicoid> {
        let shift = self.shift + height - self.at(radius)?.height;
        Some(Helicoid { shift, ..self })
    }

    /// The profile at a radius; none where the flank does not reach it.
    #[inline]
    pub fn at(&self, radius: f64) -> Option<ProfilePoint> {
        let p = self.lead;
        let mut at = match self.profile {
            AxialProfile::Straight { slope } => ProfilePoint {
                height: slope * radius,
                slope,
                curvature: 0.0,
            },
            AxialProfile::Involute { base_radius: b } => involute(p, b, radius)?,
            AxialProfile::NormalLine {
                lead_angle,
                offset,
                slope,
            } => normal_line(p, lead_angle, [offset, slope], radius)?,
            AxialProfile::Ground(wheel) => wheel.profile(p, radius)?,
        };
        at.height += self.shift;
        Some(at)
    }

    /// Azimuth of the transverse section z = 0 at a radius, rad.
    pub fn transverse_azimuth(&self, radius: f64) -> Option<f64> {
        Some(-self.at(radius)?.height / self.lead)
    }

    /// Coordinates `[x, s]` of the normal section at a radius: the plane of x and of the direction at the lead angle γ to the axis.
    ///
    /// χ solves `ρ sin χ cos γ + (g + p χ) sin γ = 0`.
    pub fn normal_section(&self, lead_angle: f64, radius: f64) -> Option<[f64; 2]> {
        let g = self.at(radius)?.height;
        let (sine, cosine) = lead_angle.sin_cos();
        let mut chi = 0.0f64;
        for _ in 0..NEWTON_STEPS {
            let value = radius * chi.sin() * cosine + (g + self.lead * chi) * sine;
            let step = value / (radius * chi.cos() * cosine + self.lead * sine);
            chi -= step;
            if step.abs() < LAST_STEP {
                break;
            }
        }
        let along = (g + self.lead * chi) * cosine - radius * chi.sin() * sine;
        Some([radius * chi.cos(), along])
    }
}

/// `g′ = p √(ρ² − r_b²)/(ρ r_b)`; none within the base cylinder.
fn involute(p: f64, base: f64, radius: f64) -> Option<ProfilePoint> {
    let root = (radius * radius - base * base).sqrt();
    let (tangent, over) = (root / base, 1.0 / (radius * root));
    (root > 0.0).then(|| ProfilePoint {
        height: p * (tangent - (base / radius).acos()),
        slope: p * tangent * root * over,
        curvature: p * base * root * over * over,
    })
}

/// The line `c(x) = (x, −s sin γ, s cos γ)`, for which `ρ = |xy|`, `g = z − p atan2(y, x)`.
fn normal_line(
    p: f64,
    lead_angle: f64,
    [offset, slope]: [f64; 2],
    radius: f64,
) -> Option<ProfilePoint> {
    let (sine, cosine) = lead_angle.sin_cos();
    // ρ² = x² + sin²γ (offset + slope x)².
    let (a, b) = (1.0 + (slope * sine).powi(2), offset * slope * sine * sine);
    let c = (offset * sine).powi(2) - radius * radius;
    let root = (b * b - a * c).sqrt();
    if !(root > 0.0) {
        return None;
    }
    let x = (root - b) / a;
    let s = offset + slope * x;
    let y = -s * sine;
    let dy = -slope * sine;
    let d_radius = (x + y * dy) / radius;
    let d_azimuth = (x * dy - y) / (radius * radius);
    let d_height = slope * cosine - p * d_azimuth;
    let dd_radius = (1.0 + dy * dy - d_radius * d_radius) / radius;
    let dd_height = 2.0 * p * d_azimuth * d_radius / radius;
    Some(ProfilePoint {
        height: s * cosine - p * y.atan2(x),
        slope: d_height / d_radius,
        curvature: (dd_height * d_radius - d_height * dd_radius) / d_radius.powi(3),
    })
}
