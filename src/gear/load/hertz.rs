//! Line contact of two flanks: linearised approach `δ = 2/π Σ(1 − ν²)/E · w` and greatest pressure `p_H = √(w E*/(π ρ))` of a line load w.

use std::f64::consts::PI;

use super::material::Material;

/// Approach of two flanks for a unit line load, m²/N: `2/π Σ(1 − ν²)/E`, for equal materials 4 (1 − ν²)/(π E).
///
/// Yang and Sun, A rotary model for spur gear dynamics, J. Mech. Trans. Autom. Des. 107 (1985), eq. 8: the approach is taken as
/// proportional to the load; exact theory has a logarithm of it.
pub fn approach_compliance(materials: &[Material; 2]) -> f64 {
    2.0 / PI * plane_strain_sum(materials)
}

/// Greatest pressure p_H under a line load (N/m) at a relative radius of curvature (m), Pa.
///
/// Johnson, Contact Mechanics (1985), eq. 4.45, `1/E* = Σ(1 − ν²)/E`.
pub fn line_pressure(line_load: f64, radius: f64, materials: &[Material; 2]) -> f64 {
    (line_load / (PI * radius * plane_strain_sum(materials))).sqrt()
}

fn plane_strain_sum(materials: &[Material; 2]) -> f64 {
    materials.iter().map(Material::plane_strain_compliance).sum()
}
