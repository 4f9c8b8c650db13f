//! Tolerance limits from a user's table: by quantity, grade, module, diameter, face width.

use super::deviation::GearDeviation;

/// One line of a table: a limit for sizes above the first and up to the second of each pair. Lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToleranceLimit {
    /// Limited quantity.
    pub quantity: GearDeviation,
    /// At which grade.
    pub grade: u32,
    /// Normal modules.
    pub modules: (f64, f64),
    /// Reference diameters.
    pub diameters: (f64, f64),
    /// Face widths.
    pub widths: (f64, f64),
    /// The limit.
    pub limit: f64,
}

/// Relative rounding of the conversion from millimetres.
const ROUNDING: f64 = 1e-9;

impl ToleranceLimit {
    fn applies_to(&self, quantity: GearDeviation, sizes: [f64; 3]) -> bool {
        let ranges = [self.modules, self.diameters, self.widths];
        let within = |((low, high), x): ((f64, f64), f64)| {
            x > low * (1.0 + ROUNDING) && x <= high * (1.0 + ROUNDING)
        };
        let same = std::mem::discriminant(&self.quantity) == std::mem::discriminant(&quantity);
        same && ranges.into_iter().zip(sizes).all(within)
    }
}

/// The limit a table has for a quantity of a gear of a module, a diameter and a face width.
pub fn find_limit(
    table: &[ToleranceLimit],
    quantity: GearDeviation,
    grade: u32,
    sizes: [f64; 3],
) -> Option<f64> {
    let holds = |line: &&ToleranceLimit| line.grade == grade && line.applies_to(quantity, sizes);
    table.iter().find(holds).map(|line| line.limit)
}

/// The finest grade of a table whose limit holds a value.
pub fn grade_of(
    table: &[ToleranceLimit],
    quantity: GearDeviation,
    value: f64,
    sizes: [f64; 3],
) -> Option<u32> {
    let holds = |line: &&ToleranceLimit| {
        line.applies_to(quantity, sizes) && value.abs() <= line.limit * (1.0 + ROUNDING)
    };
    table.iter().filter(holds).map(|line| line.grade).min()
}
