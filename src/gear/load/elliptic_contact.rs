//! Elliptic contact of two curved bodies: `κ₁/κ₂ = ((a/b)² E(e) − K(e))/(K(e) − E(e))`, `p₀ = 3F/(2πab)`, approach `3F K(e)/(2π E* a)`.
//!
//! `e² = 1 − b²/a²`, the gap is `(κ₁ x² + κ₂ y²)/2`, `1/E* = Σ (1 − ν²)/E`: Johnson, Contact Mechanics (1985), eqs. 4.26–4.28, without
//! his approximations.

use std::f64::consts::{FRAC_PI_2, PI};

use super::hertz::plane_strain_sum;
use super::material::Material;

/// Bisections of ln(a/b): the last interval is rounding.
const BISECTIONS: usize = 60;
/// Largest ln(a/b) that is sought: beyond it the contact is a line.
const LONGEST: f64 = 12.0;

/// An elliptic contact under a force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EllipticContact {
    /// Longer and shorter semi-axis a, b, m.
    pub semi_axes: [f64; 2],
    /// Greatest pressure p₀, Pa.
    pub pressure: f64,
    /// Approach of the bodies, m.
    pub approach: f64,
}

impl EllipticContact {
    /// The contact of a force, N, at relative principal curvatures, 1/m; none where one of them is not positive or the ellipse is longer
    /// than 1e5 widths.
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
        let eccentric = 1.0 - 1.0 / (aspect * aspect);
        let shape = match eccentric > 1e-6 {
            true => (k - e) / eccentric,
            // Limit of a circle: (K − E)/e² → π/4.
            false => 0.5 * FRAC_PI_2,
        };
        let long = (3.0 * force * compliance * shape / (PI * low)).cbrt();
        let short = long / aspect;
        let pressure = 1.5 * force / (PI * long * short);
        (pressure.is_finite() && force > 0.0).then_some(EllipticContact {
            semi_axes: [long, short],
            pressure,
            approach: 1.5 * force * compliance * k / (PI * long),
        })
    }

    /// Aspect ratio a/b, which does not depend on the force.
    pub fn aspect(&self) -> f64 {
        self.semi_axes[0] / self.semi_axes[1]
    }
}

/// Depth below the middle of an ellipse of the greatest shear, in shorter semi-axes, and that shear over the greatest pressure, by b/a in
/// steps of 0.2 from a line to a circle, of Poisson's ratio 0.3: Johnson, Contact Mechanics (1985), table 4.1.
const SHEAR: [[f64; 2]; 6] = [
    [0.785, 0.300],
    [0.745, 0.322],
    [0.665, 0.325],
    [0.590, 0.323],
    [0.530, 0.317],
    [0.480, 0.310],
];

/// Depth of the greatest shear in half widths and its size over the greatest pressure at a ratio b/a, 0 for a line.
pub fn greatest_shear(ratio: f64) -> [f64; 2] {
    let place = ratio.clamp(0.0, 1.0) * (SHEAR.len() - 1) as f64;
    let before = (place.floor() as usize).min(SHEAR.len() - 2);
    let share = place - before as f64;
    [0, 1].map(|k| SHEAR[before][k] + share * (SHEAR[before + 1][k] - SHEAR[before][k]))
}

/// a/b of a ratio κ₁/κ₂ of curvatures up to 1; none where the ratio is not positive or the ellipse is too long.
pub fn aspect_ratio(curvature_ratio: f64) -> Option<f64> {
    let ratio = |ln_aspect: f64| {
        let aspect = ln_aspect.exp();
        let (k, e) = elliptic_integrals(1.0 / aspect);
        (k - e) / (aspect * aspect * e - k)
    };
    if !(curvature_ratio > ratio(LONGEST) && curvature_ratio <= 1.0) {
        return None;
    }
    let (mut low, mut high) = (0.0, LONGEST);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        // At a circle the ratio is 0/0: rounding there counts as 1.
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
