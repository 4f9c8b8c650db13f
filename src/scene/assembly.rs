//! Places of the axes of a bevel pair: errors of assembly, their tolerances, the deflection of the housing.

use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;
use crate::gear::contact::pair::Assembly;

/// Lengths of places on an axis.
pub(super) const SHIFT: ValueRange = ValueRange::Open(-1e3, 1e3, "within ±1 km");

/// Departures of the axes under which the loaded contact is compared with the nominal one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AxisDepartures {
    /// Tolerances of E, P, G, ΔΣ, each taken both ways; zero where there is none.
    pub tolerance: Assembly,
    /// Deflection of the housing.
    pub housing: Option<HousingDeflection>,
}

/// Deflection of a housing that is linear in the torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HousingDeflection {
    /// Torque at the pinion, N·m.
    pub torque: f64,
    /// Changes of E, P, G, ΔΣ under it.
    pub change: Assembly,
}

impl AxisDepartures {
    /// Whether the file asks for nothing.
    pub fn is_empty(&self) -> bool {
        *self == AxisDepartures::default()
    }
}

/// Keys of `[assembly]` and `[tolerance]`.
pub fn assembly(f: &mut TableReader) -> Assembly {
    const ERROR: ValueRange = ValueRange::Open(-0.5, 0.5, "within ±0.5 rad");
    let mut length = |key| f.optional_quantity(key, QuantityKind::Length, SHIFT);
    let [offset, pinion_axial, gear_axial] =
        ["offset", "pinion_axial", "gear_axial"].map(|key| length(key).unwrap_or(0.0));
    let shaft_angle = f.optional_quantity("shaft_angle_error", QuantityKind::Angle, ERROR);
    Assembly {
        shaft_angle: shaft_angle.unwrap_or(0.0),
        offset,
        pinion_axial,
        gear_axial,
    }
}

/// Keys of `[housing]`.
pub fn housing(f: &mut TableReader) -> Option<HousingDeflection> {
    let torque = f.optional_quantity("torque", QuantityKind::Torque, ValueRange::Positive);
    f.require("torque");
    let change = assembly(f);
    Some(HousingDeflection {
        torque: torque?,
        change,
    })
}
