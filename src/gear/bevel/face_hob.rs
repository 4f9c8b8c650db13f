//! Face hobbing on the crown gear of a wheel: lead angle of the cutter, epicycloid of the tooth line, places of the cutter on the pitch plane.
//!
//! Numbers in brackets are formulas of ISO 23509:2016.

use super::pitch_point::PitchPoint;

/// A cutter of blade groups that roll with the work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceHob {
    /// Cutter radius r_c0.
    pub radius: f64,
    /// Blade groups over teeth of the wheel, z₀/z₂.
    pub groups: f64,
    /// Rule by which the pitch cones fit the cutter.
    pub rule: ConeRule,
}

/// Rules for the pitch cones of face-hobbed pairs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConeRule {
    /// Method 2 (Oerlikon): both pitch apexes and the centre of the cutter lie on a line of the pitch plane.
    ApexLine,
    /// Method 3 (Klingelnberg): (99)–(105).
    CrownGears,
}

/// The tooth line of a face-hobbed wheel on its pitch plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Epicycloid {
    /// Cutter radius r_c0.
    pub radius: f64,
    /// Distance of the centres of crown gear and cutter ρ_P0.
    pub centre_distance: f64,
    /// Radius of the base circle ρ_b.
    pub base_radius: f64,
}

impl FaceHob {
    /// Lead angle of the cutter ν, `sin ν = z₀ m_mn/(2 r_c0)`: (42), (98), (176), rad.
    fn lead_angle(&self, wheel_radius: f64, wheel_spiral: f64) -> f64 {
        (self.groups * wheel_radius * wheel_spiral.cos() / self.radius).asin()
    }

    /// Residual of the rule at a pitch point, relative; none where the cutter does not reach it.
    pub fn misfit(&self, at: &PitchPoint) -> Option<f64> {
        let [r1, r2] = at.cone_distances;
        let [beta_1, beta_2] = at.spiral_angles;
        let nu = self.lead_angle(at.radii[1], beta_2);
        let zeta = beta_1 - beta_2;
        let off = match self.rule {
            ConeRule::ApexLine => {
                // From P: wheel apex along −x, pinion apex and cutter centre turned from it by ζ_mp and λ = 90° − β₂ + ν.
                let (sin, cos) = (beta_2 - nu).sin_cos();
                let cutter = [r2 - self.radius * sin, self.radius * cos];
                let pinion = [r2 - r1 * zeta.cos(), r1 * zeta.sin()];
                (cutter[0] * pinion[1] - cutter[1] * pinion[0]) / (r2 * self.radius)
            }
            ConeRule::CrownGears => {
                let theta = (at.pitch_angles[1].sin() * at.axial_offset_angle().tan()).atan();
                let cutter = (beta_2 - nu).cos();
                let a3 = self.radius * cutter * cutter;
                let a4 = r2 * (beta_2 + theta).cos() * beta_2.cos();
                let a5 = zeta.sin() * theta.cos() * nu.cos();
                let a6 = r2 * beta_2.cos() + self.radius * nu.sin();
                let a7 = beta_1.cos() * (beta_2 + theta).cos()
                    - (beta_2 + theta - nu).sin() * zeta.sin() / cutter;
                r1 * (a5 * a6 + a3 * a7) / (a3 * a4) - 1.0
            }
        };
        off.is_finite().then_some(off)
    }

    /// The tooth line of a wheel by its mean cone distance, pitch angle and mean spiral angle: (177), (178).
    pub fn epicycloid(&self, mean: f64, pitch_angle: f64, spiral_angle: f64) -> Epicycloid {
        let nu = self.lead_angle(mean * pitch_angle.sin(), spiral_angle);
        let r = self.radius;
        let square = mean * mean + r * r - 2.0 * mean * r * (spiral_angle - nu).sin();
        let centre_distance = square.sqrt();
        Epicycloid {
            radius: r,
            centre_distance,
            base_radius: centre_distance / (1.0 + self.groups * pitch_angle.sin()),
        }
    }
}

impl Epicycloid {
    /// Spiral angle of the wheel at a cone distance: (179)–(182), rad; NaN where the tooth line does not reach it.
    pub fn spiral_angle(&self, distance: f64) -> f64 {
        let (rho, r) = (self.centre_distance, self.radius);
        let phi = ((distance * distance + rho * rho - r * r) / (2.0 * distance * rho)).acos();
        let (sin, cos) = phi.sin_cos();
        (distance - self.base_radius * cos).atan2(self.base_radius * sin)
    }
}
