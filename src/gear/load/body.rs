//! Gear body under a tooth: `δ_f = cos²β/E · [L (u/S)² + M (u/S) + P (1 + Q tan²β)]` for a unit line load.
//!
//! The load acts along its line at the angle β to the normal of the tooth's middle line and crosses that line at the height u above the
//! root circle; S is the thickness of the tooth at the root. Neighbouring teeth on the same body are not coupled.

use crate::base::code::Code;
use crate::base::error::Error;

use super::material::Material;

/// A model of the gear body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Body {
    /// No deflection below the root circle.
    Rigid,
    /// Half plane in plane strain: O'Donnell 1960 in the form of Cornell, J. Mech. Des. 103 (1981), eq. 6.
    #[default]
    HalfPlane,
    /// Elastic ring on a rigid shaft: Sainsot, Velex and Duverger, J. Mech. Des. 126 (2004), eqs. 19 and 20.
    Ring {
        /// Radius of the bore, m.
        bore_radius: f64,
    },
}

/// A tooth on its body and the place of the load on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FootLoad {
    /// Height u above the root circle at which the load's line crosses the middle of the tooth, m.
    pub height: f64,
    /// Angle β of the load to the normal of the middle line, rad.
    pub angle: f64,
    /// Radius of the root circle, m.
    pub root_radius: f64,
    /// Half the angle θ_f of the tooth at the root circle, rad; S = 2 r_f θ_f.
    pub root_half_angle: f64,
}

/// Rows A–F of L, M, P and Q in `A/θ_f² + B h² + C h/θ_f + D/θ_f + E h + F`, h = r_f/r_bore (Sainsot et al. 2004, table 1).
const RING: [[f64; 6]; 4] = [
    [-5.574e-5, -1.9986e-3, -2.3015e-4, 4.7702e-3, 0.0271, 6.8045],
    [60.111e-5, 28.100e-3, -83.431e-4, -9.9256e-3, 0.1624, 0.9086],
    [-50.952e-5, 185.50e-3, 0.0538e-4, 53.3e-3, 0.2895, 0.9236],
    [
        -6.2042e-5, 9.0889e-3, -4.0964e-4, 7.8297e-3, -0.1472, 0.6904,
    ],
];

/// Range of r_f/r_bore the ring's rows were fitted over.
const RING_RATIO: [f64; 2] = [1.4, 7.0];
/// Range of θ_f the ring's rows were fitted over, rad.
const RING_ANGLE: [f64; 2] = [0.01, 0.12];

impl Body {
    /// Name of the model in results.
    pub fn name(&self) -> &'static str {
        match self {
            Body::Rigid => "rigid",
            Body::HalfPlane => "half plane (Cornell 1981)",
            Body::Ring { .. } => "elastic ring (Sainsot 2004)",
        }
    }

    /// Deflection along the load's line for a unit line load, m²/N.
    pub fn compliance(&self, load: &FootLoad, material: &Material) -> f64 {
        let ratio = load.height / (2.0 * load.root_radius * load.root_half_angle);
        let (tangent, nu) = (load.angle.tan(), material.poisson);
        let ([l, m, p, q], modulus) = match *self {
            Body::Rigid => return 0.0,
            Body::HalfPlane => (
                [
                    16.67 / std::f64::consts::PI,
                    2.0 * (1.0 - 2.0 * nu) / (1.0 - nu),
                    1.534,
                    1.0 / (2.4 * (1.0 + nu)),
                ],
                material.plane_strain_compliance().recip(),
            ),
            Body::Ring { bore_radius } => (
                RING.map(|row| ring_term(row, load, bore_radius)),
                material.young,
            ),
        };
        let cosine = load.angle.cos();
        let bracket = l * ratio * ratio + m * ratio + p * (1.0 + q * tangent * tangent);
        cosine * cosine / modulus * bracket
    }

    /// # Errors
    /// `OutOfRange`: a bore that leaves no ring, or one so small that the fit of the ring's compliance grows without bound.
    pub fn check(&self, root_radius: f64) -> Result<(), Error> {
        let Body::Ring { bore_radius } = *self else {
            return Ok(());
        };
        let least = root_radius / RING_RATIO[1];
        if bore_radius >= least && bore_radius < root_radius {
            return Ok(());
        }
        let message = format!(
            "bore radius is {:.4} mm; the elastic ring is valid from {:.4} mm to below the root radius of {:.4} mm",
            1e3 * bore_radius,
            1e3 * least,
            1e3 * root_radius
        );
        let error = Error::new(Code::OutOfRange, message).with_key("bore_diameter");
        Err(error.with_hint("use the half plane for a solid body"))
    }

    /// Statement of the first quantity of a tooth's foot outside the range the model was fitted over, with the limits.
    pub fn outside_range(&self, root_radius: f64, root_half_angle: f64) -> Option<String> {
        let Body::Ring { bore_radius } = *self else {
            return None;
        };
        let ratio = root_radius / bore_radius;
        let inside = |value: f64, [low, high]: [f64; 2]| (low..=high).contains(&value);
        if !inside(ratio, RING_RATIO) {
            let [low, high] = RING_RATIO;
            return Some(format!(
                "root radius {:.3} mm is {ratio:.2} times the bore radius (elastic ring fitted from {low} to {high})",
                1e3 * root_radius
            ));
        }
        let [low, high] = RING_ANGLE;
        (!inside(root_half_angle, RING_ANGLE)).then(|| {
            format!("half angle of the tooth at the root is {root_half_angle:.4} rad (elastic ring fitted from {low} to {high})")
        })
    }
}

fn ring_term([a, b, c, d, e, f]: [f64; 6], load: &FootLoad, bore_radius: f64) -> f64 {
    let (theta, h) = (load.root_half_angle, load.root_radius / bore_radius);
    a / (theta * theta) + b * h * h + c * h / theta + d / theta + e * h + f
}
