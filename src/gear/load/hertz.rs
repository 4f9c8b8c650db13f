//! Line contact of two flanks under a line load w: approach in proportion to w, and greatest pressure `p_H = √(w E*/(π ρ))`.
//!
//! `1/E* = Σ (1 − ν²)/E`, ρ the relative radius of curvature, b the half width of the contact.

use std::f64::consts::PI;

use super::material::Material;

/// A model of the approach of two flanks, taken as proportional to the load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactModel {
    /// `2/(π E*)` everywhere: Yang and Sun, J. Mech. Trans. Autom. Des. 107 (1985), eq. 8. Two to five times too stiff for steel teeth.
    Constant,
    /// `Σ (1 − ν²)/(π E) (2 ln(2 h/b) − ν/(1 − ν))` with the half width b of one line load, h the depth of the tooth's middle: Weber and
    /// Banaschek 1953; Johnson, Contact Mechanics (1985), eq. 5.57.
    Logarithmic {
        /// Line load that sets the half width, N/m.
        line_load: f64,
    },
}

impl Default for ContactModel {
    /// The half width of 300 N/mm: the middle of the loads for which ISO 6336-1:2006 fitted c′; a tenth or ten times the load changes
    /// the stiffness of a steel pair by −10 % or +12 %.
    fn default() -> ContactModel {
        ContactModel::Logarithmic { line_load: 300e3 }
    }
}

/// Flanks that touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankContact {
    /// Relative radius of curvature ρ, m.
    pub radius: f64,
    /// Distance from the flank to the middle of its tooth along the normal, m.
    pub depths: [f64; 2],
}

impl ContactModel {
    /// Approach for a unit line load, m²/N.
    pub fn compliance(&self, contact: &FlankContact, materials: &[Material; 2]) -> f64 {
        match *self {
            ContactModel::Constant => 2.0 / PI * plane_strain_sum(materials),
            ContactModel::Logarithmic { line_load } => {
                let half_width = half_width(line_load, contact.radius, materials);
                let side = |i: usize| {
                    let nu = materials[i].poisson;
                    let depth = (2.0 * contact.depths[i] / half_width).ln();
                    materials[i].plane_strain_compliance() / PI * (2.0 * depth - nu / (1.0 - nu))
                };
                // A tooth thinner than the contact is wide, at a point of a tip, adds nothing.
                side(0).max(0.0) + side(1).max(0.0)
            }
        }
    }
}

/// Half width b of the contact, `b² = 4 w ρ/(π E*)`, m: Johnson, Contact Mechanics (1985), eq. 4.43.
pub fn half_width(line_load: f64, radius: f64, materials: &[Material; 2]) -> f64 {
    (4.0 / PI * line_load * radius * plane_strain_sum(materials)).sqrt()
}

/// Greatest pressure p_H, Pa: Johnson, Contact Mechanics (1985), eq. 4.45.
pub fn line_pressure(line_load: f64, radius: f64, materials: &[Material; 2]) -> f64 {
    (line_load / (PI * radius * plane_strain_sum(materials))).sqrt()
}

/// 1/E*, 1/Pa.
pub(super) fn plane_strain_sum(materials: &[Material; 2]) -> f64 {
    materials
        .iter()
        .map(Material::plane_strain_compliance)
        .sum()
}
