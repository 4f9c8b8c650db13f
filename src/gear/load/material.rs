//! Elastic constants of a gear: `G = E/(2(1 + ν))`.

/// An isotropic elastic material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus E, Pa.
    pub young: f64,
    /// Poisson's ratio ν.
    pub poisson: f64,
}

impl Default for Material {
    /// Steel as ISO 6336-1:2006 has it: 206 000 N/mm², 0.3.
    fn default() -> Material {
        Material {
            young: 206e9,
            poisson: 0.3,
        }
    }
}

impl Material {
    /// Shear modulus G, Pa.
    pub fn shear_modulus(&self) -> f64 {
        self.young / (2.0 * (1.0 + self.poisson))
    }

    /// (1 − ν²)/E, 1/Pa.
    pub fn plane_strain_compliance(&self) -> f64 {
        (1.0 - self.poisson * self.poisson) / self.young
    }
}
