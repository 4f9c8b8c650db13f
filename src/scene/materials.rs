//! The materials a file can name.

use crate::base::table_reader::TableReader;

/// Material properties of shafts and discs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Shear modulus, Pa.
    pub shear_modulus: f64,
    /// Density, kg/m³.
    pub density: f64,
}

const fn material(shear_gpa: f64, density: f64) -> Material {
    Material {
        shear_modulus: shear_gpa * 1e9,
        density,
    }
}

/// Every material by name.
///
/// Shear moduli of steel, cast iron and bronze: Budynas and Nisbett, Shigley's Mechanical Engineering Design, Table A-5
/// (carbon steel, gray cast iron, phosphor bronze), as are the densities of the latter two (70.6 and 80.1 kN/m³).
/// Density of steel: EN 1993-1-2:2005, 3.2.2(1). Aluminium: EN 1999-1-1:2007, 3.2.5.
pub const MATERIALS: &[(&str, Material)] = &[
    ("steel", material(79.3, 7850.0)),
    ("cast_iron", material(41.4, 7200.0)),
    ("bronze", material(41.4, 8170.0)),
    ("aluminium", material(27.0, 2700.0)),
];

/// The material under `material`.
pub fn read_material(f: &mut TableReader) -> Option<Material> {
    f.choice("material", MATERIALS)
}
