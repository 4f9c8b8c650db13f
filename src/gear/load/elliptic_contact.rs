//! Elliptic contact of two curved bodies: `κ₁/κ₂ = ((a/b)² E(e) − K(e))/(K(e) − E(e))`, `p₀ = 3F/(2πab)`, approach `3F K(e)/(2π E* a)`.
//!
//! Here `e² = 1 − b²/a²`, the gap is `(κ₁ x² + κ₂ y²)/2` and `1/E* = Σ (1 − ν²)/E`: Johnson, Contact Mechanics (1985), eqs. 4.26–4.28,
//! without the approximations of that text.

use std::f64::consts::{FRAC_PI_2, PI};

use super::hertz::plane_strain_sum;
use super::material::Material;

/// Bisections of ln(a/b), to rounding.
const BISECTIONS: usize = 60;
/// Maximum ln(a/b); a longer ellipse is treated as line contact.
const MAX_LN_ASPECT: f64 = 12.0;

/// Elliptic contact under a normal force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EllipticContact {
    /// Major and minor semi-axes a, b, m.
    pub semi_axes: [f64; 2],
    /// Maximum pressure p₀, Pa.
    pub pressure: f64,
    /// Approach of the bodies, m.
    pub approach: f64,
}

impl EllipticContact {
    /// Contact under a force, N, at relative principal curvatures, 1/m; `None` where a curvature is not positive or the aspect ratio a/b
    /// exceeds 1e5.
    pub fn new(
        curvatures: [f64; 2],
        force: f64,
        materials: &[Material; 2],
    ) -> Option<EllipticContact> {
        let low = curvatures[0].min(curvatures[1]);
        let high = curvatures[0].max(curvatures[1]);
        let aspect = aspect_ratio(low / high)?;
        let (k, e) = elliptic_integrals(1.0 / aspect);
        let compliance = plane_strain_sum(materials);
        // Johnson, eq. 4.26b: (κ₁ + κ₂)/2 · a³ = 3 F/(4π E*) · (a/b)² E-terms; here by the equation of κ₁ alone.
        let eccentricity_squared = 1.0 - 1.0 / (aspect * aspect);
        let shape = match eccentricity_squared > 1e-6 {
            true => (k - e) / eccentricity_squared,
            // Limit of a circle: (K − E)/e² → π/4.
            false => 0.5 * FRAC_PI_2,
        };
        let major = (3.0 * force * compliance * shape / (PI * low)).cbrt();
        let minor = major / aspect;
        let pressure = 1.5 * force / (PI * major * minor);
        (pressure.is_finite() && force > 0.0).then_some(EllipticContact {
            semi_axes: [major, minor],
            pressure,
            approach: 1.5 * force * compliance * k / (PI * major),
        })
    }

    /// Aspect ratio a/b, independent of the force.
    pub fn aspect(&self) -> f64 {
        self.semi_axes[0] / self.semi_axes[1]
    }
}

/// Depth of the maximum shear stress below the centre of an ellipse, in minor semi-axes, and this stress relative to the maximum pressure,
/// by b/a in steps of 0.2 from line to circle, for Poisson's ratio 0.3: Johnson, Contact Mechanics (1985), table 4.1.
const SHEAR: [[f64; 2]; 6] = [
    [0.785, 0.300],
    [0.745, 0.322],
    [0.665, 0.325],
    [0.590, 0.323],
    [0.530, 0.317],
    [0.480, 0.310],
];

/// Depth of the maximum shear stress in half widths, and the stress relative to the maximum pressure, at a ratio b/a, 0 for a line.
pub fn greatest_shear(ratio: f64) -> [f64; 2] {
    let position = ratio.clamp(0.0, 1.0) * (SHEAR.len() - 1) as f64;
    let row = (position.floor() as usize).min(SHEAR.len() - 2);
    let share = position - row as f64;
    [0, 1].map(|k| SHEAR[row][k] + share * (SHEAR[row + 1][k] - SHEAR[row][k]))
}

/// Aspect ratio a/b for a curvature ratio κ₁/κ₂ up to 1; `None` where the ratio is not positive or a/b too large.
pub fn aspect_ratio(curvature_ratio: f64) -> Option<f64> {
    let ratio = |ln_aspect: f64| {
        let aspect = ln_aspect.exp();
        let (k, e) = elliptic_integrals(1.0 / aspect);
        (k - e) / (aspect * aspect * e - k)
    };
    if !(curvature_ratio > ratio(MAX_LN_ASPECT) && curvature_ratio <= 1.0) {
        return None;
    }
    let (mut low, mut high) = (0.0, MAX_LN_ASPECT);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        // For a circle the ratio is 0/0; a rounding result is taken as 1.
        match ratio(middle) < curvature_ratio {
            true => high = middle,
            false => low = middle,
        }
    }
    Some((0.5 * (low + high)).exp())
}

/// Complete elliptic integrals K and E of the complementary modulus `k' = b/a`, by the arithmetic–geometric mean (Abramowitz and Stegun
/// 1964, 17.6).
fn elliptic_integrals(complementary: f64) -> (f64, f64) {
    let (mut a, mut g) = (1.0, complementary);
    let mut c_squared = 1.0 - complementary * complementary;
    let (mut sum, mut factor) = (0.5 * c_squared, 0.5);
    while c_squared > f64::EPSILON * f64::EPSILON {
        let c = 0.5 * (a - g);
        (a, g) = (0.5 * (a + g), (a * g).sqrt());
        factor *= 2.0;
        c_squared = c * c;
        sum += factor * c_squared;
    }
    let k = FRAC_PI_2 / a;
    (k, k * (1.0 - sum))
}
