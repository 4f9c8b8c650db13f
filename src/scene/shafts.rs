//! `[[shaft]]` and `[[coupling]]`.

use super::bodies::outer_and_bore;
use super::materials;
use super::model::{BarMass, BranchDamping, Coupling, Shaft, ShaftBody};
use super::shared_keys::{self, MAX_COUNT};
use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;
use crate::base::tables;

/// Keys that describe a bar.
const GEOMETRY: [&str; 8] = [
    "length",
    "diameter",
    "bore",
    "material",
    "shear_modulus",
    "density",
    "segments",
    "mass",
];

/// A shaft length: stiffness given, from geometry, or rigid.
pub fn shaft(f: &mut TableReader) -> Shaft {
    let name = shared_keys::name(f);
    let between = shared_keys::read_ends(f);
    let stiffness = f.optional_quantity(
        "k",
        QuantityKind::TorsionalStiffness,
        ValueRange::NotNegative,
    );
    let bar = bar(f);
    let geometry = GEOMETRY.into_iter().find(|key| f.has(key));
    if let (true, Some(key)) = (f.has("k"), geometry) {
        let message = format!("`k` is given, but is also determined by `{key}`");
        let hint = "give k only, or length, diameter and material";
        f.report_key(Code::Conflict, "k", message, hint);
    }
    let rigid = !f.has("k") && geometry.is_none();
    Shaft {
        name,
        between,
        body: stiffness.map(ShaftBody::Stiffness).or(bar),
        loss: shared_keys::read_damping(
            f,
            "",
            QuantityKind::TorsionalDamping,
            "`k`, or length, diameter and material",
            rigid,
        ),
    }
}

/// A round bar, where any of its keys is given.
fn bar(f: &mut TableReader) -> Option<ShaftBody> {
    let length = f.optional_quantity("length", QuantityKind::Length, ValueRange::Positive);
    let (outer, inner) = outer_and_bore(f);
    let material = materials::read_material(f);
    let shear_modulus = f.optional_quantity(
        "shear_modulus",
        QuantityKind::Pressure,
        ValueRange::Positive,
    );
    let density = f.optional_quantity("density", QuantityKind::Density, ValueRange::Positive);
    let segments = f.optional_count("segments", 1, MAX_COUNT).unwrap_or(1);
    let kinds = [
        ("none", BarMass::None),
        ("lumped", BarMass::Lumped),
        ("consistent", BarMass::Consistent),
    ];
    let mass = f.choice("mass", &kinds).unwrap_or(BarMass::None);
    f.exclusive("material", "shear_modulus");
    f.exclusive("material", "density");
    if f.has("k") || !GEOMETRY.iter().any(|key| f.has(key)) {
        return None;
    }
    f.require("length");
    f.require("diameter");
    if !f.has("material") {
        if !f.has("shear_modulus") {
            f.report_missing("material", " or `shear_modulus`");
        } else if mass != BarMass::None && !f.has("density") {
            f.report_missing("density", ", which its mass needs");
        }
    }
    Some(ShaftBody::Bar {
        length: length?,
        outer: outer?,
        inner,
        shear_modulus: shear_modulus.or(material.map(|m| m.shear_modulus))?,
        density: density.or(material.map(|m| m.density)).unwrap_or(0.0),
        segments: segments as usize,
        mass,
    })
}

/// A torsional coupling.
pub fn coupling(f: &mut TableReader) -> Coupling {
    let name = shared_keys::name(f);
    let between = shared_keys::read_ends(f);
    let maxwell = tables::read_tables(f, "maxwell", |f| {
        [
            f.quantity("k", QuantityKind::TorsionalStiffness, ValueRange::Positive),
            f.quantity("c", QuantityKind::TorsionalDamping, ValueRange::Positive),
        ]
    });
    let contact = shared_keys::read_coupling_contact(f);
    if contact.stiffness.is_some_and(|k| k < 0.0)
        && matches!(
            contact.loss,
            BranchDamping::Ratio(_) | BranchDamping::Factor(_)
        )
    {
        let key = if f.has("damping_ratio") {
            "damping_ratio"
        } else {
            "loss_factor"
        };
        let message = format!("`{key}` is undefined for a negative stiffness");
        f.report_key(Code::Conflict, key, message, "give `c` instead");
    }
    Coupling {
        name,
        between,
        contact,
        maxwell,
    }
}
