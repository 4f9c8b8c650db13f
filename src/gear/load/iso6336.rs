//! Tooth stiffness by ISO 6336-1:2006, clause 9: `c′ = c′_th C_M C_R C_B cos β`, `c_γα = c′ (0.75 ε_α + 0.25)`.
//!
//! c′ is the largest stiffness of one tooth pair for a unit face width, c_γα the mean of the mesh, c_γβ that of the contact along the
//! face. Both are for steel; other materials scale by their mean modulus. Pa is N/m for a metre of width: 1 N/(mm µm) = 1 GPa.

use crate::gear::cylindrical::pair::Pair;

use super::material::Material;

/// C_M: measured over theoretical stiffness of solid discs.
const MEASURED_OVER_THEORY: f64 = 0.8;
/// c_γβ over c_γα.
const ALONG_FACE: f64 = 0.85;
/// Least specific load F_t K_A/b the approximation holds for, N/m.
pub const LEAST_LINE_LOAD: f64 = 100e3;

/// Coefficients of q′ for the smaller gear (first) and the larger: 1, 1/z_n1, 1/z_n2, x_1, x_1/z_n1, x_2, x_2/z_n2, x_1², x_2².
const FLEXIBILITY: [f64; 9] = [
    0.04723, 0.15551, 0.25791, -0.00635, -0.11654, -0.00193, -0.24188, 0.00529, 0.00182,
];

/// Web and rim of a gear blank, for C_R.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Web {
    /// Web thickness over face width, b_s/b.
    pub thickness_ratio: f64,
    /// Rim thickness in normal modules, s_R/m_n.
    pub rim_modules: f64,
}

/// Stiffness of a pair by ISO 6336-1:2006.
#[derive(Debug, Clone, PartialEq)]
pub struct IsoStiffness {
    /// Theoretical single stiffness c′_th of solid discs, Pa.
    pub theoretical: f64,
    /// Gear blank factor C_R.
    pub blank_factor: f64,
    /// Basic rack factor C_B.
    pub rack_factor: f64,
    /// Single stiffness c′, Pa.
    pub single: f64,
    /// Mean mesh stiffness c_γα, Pa.
    pub mesh: f64,
    /// Mesh stiffness for the load distribution along the face c_γβ, Pa.
    pub along_face: f64,
    /// Statements of the quantities outside the ranges of the approximation.
    pub outside_range: Vec<String>,
}

impl IsoStiffness {
    /// The stiffness of a pair; the webs are those of its gears, `None` of a solid disc.
    pub fn new(pair: &Pair, materials: &[Material; 2], webs: [Option<Web>; 2]) -> IsoStiffness {
        let [first, second] = &pair.members;
        // The approximation was fitted with the smaller gear first.
        let ordered = match second.gear.internal || first.gear.teeth <= second.gear.teeth {
            true => [first, second],
            false => [second, first],
        };
        let gear = &first.gear;
        let base_helix = (gear.helix.sin() * gear.pressure_angle.cos()).asin();
        let virtual_ratio = (base_helix.cos().powi(2) * gear.helix.cos()).recip();
        let inverse_teeth = ordered.map(|m| match m.gear.internal {
            true => 0.0,
            false => (virtual_ratio * f64::from(m.gear.teeth)).recip(),
        });
        let [x1, x2] = ordered.map(|m| m.gear.profile_shift);
        let [n1, n2] = inverse_teeth;
        let terms = [1.0, n1, n2, x1, x1 * n1, x2, x2 * n2, x1 * x1, x2 * x2];
        let flexibility: f64 = FLEXIBILITY.iter().zip(terms).map(|(c, t)| c * t).sum();
        let theoretical = 1e9 / flexibility;
        let blank_factor = 0.5
            * webs
                .map(|w| w.as_ref().map_or(1.0, Web::factor))
                .iter()
                .sum::<f64>();
        let alpha_deg = gear.pressure_angle.to_degrees();
        let rack = |dedendum: f64| 1.0 + 0.5 * (1.2 - dedendum);
        let racks = rack(first.rack.dedendum) + rack(second.rack.dedendum);
        let rack_factor = 0.5 * racks * (1.0 - 0.02 * (20.0 - alpha_deg));
        let [e1, e2] = materials.map(|m| m.young);
        let modulus = 2.0 * e1 * e2 / (e1 + e2) / Material::default().young;
        let single = theoretical
            * MEASURED_OVER_THEORY
            * blank_factor
            * rack_factor
            * gear.helix.cos()
            * modulus;
        let ratio = pair.contact_ratios().transverse;
        let mesh = single * (0.75 * ratio + 0.25);
        IsoStiffness {
            theoretical,
            blank_factor,
            rack_factor,
            single,
            mesh,
            along_face: ALONG_FACE * mesh,
            outside_range: outside_range([x1, x2], ratio, gear.helix.to_degrees().abs()),
        }
    }
}

impl Web {
    /// `C_R = 1 + ln(b_s/b)/(5 e^{s_R/(5 m_n)})`, b_s/b taken between 0.2 and 1.2, s_R/m_n as 1 or more.
    fn factor(&self) -> f64 {
        let thickness = self.thickness_ratio.clamp(0.2, 1.2);
        let rim = self.rim_modules.max(1.0);
        1.0 + thickness.ln() / (5.0 * (rim / 5.0).exp())
    }
}

fn outside_range([x1, x2]: [f64; 2], contact_ratio: f64, helix_deg: f64) -> Vec<String> {
    let mut outside = Vec::new();
    if x1 < x2 {
        outside.push(format!(
            "profile shift {x1:.4} of the smaller gear is below {x2:.4} of the larger (limit of q′: x_1 ≥ x_2)"
        ));
    }
    if !(-0.5..=2.0).contains(&(x1 + x2)) {
        outside.push(format!(
            "sum of profile shifts is {:.4} (limits of q′: −0.5 to 2)",
            x1 + x2
        ));
    }
    if contact_ratio < 1.2 {
        outside.push(format!(
            "transverse contact ratio is {contact_ratio:.3} (limit of c_γα: 1.2; below it the mean is up to 10 % smaller)"
        ));
    }
    if helix_deg > 30.0 {
        outside.push(format!(
            "helix angle is {helix_deg:.2} deg (limit of c′: 30 deg)"
        ));
    }
    outside
}
