//! `[[shaft]]` and `[[coupling]]`.

use super::bodies::outer_and_bore;
use super::common::{self, MOST};
use super::materials;
use super::model::{BarMass, Coupling, Loss, Shaft, ShaftBody};
use super::tables;
use crate::base::code::Code;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;

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
pub fn shaft(f: &mut Fields) -> Shaft {
    let name = common::name(f);
    let between = common::ends(f);
    let stiffness = f.optional_quantity("k", Kind::TorsionalStiffness, Range::NotNegative);
    let bar = bar(f);
    let geometry = GEOMETRY.into_iter().find(|key| f.has(key));
    if let (true, Some(key)) = (f.has("k"), geometry) {
        let message = format!("`k` is given, and follows from `{key}` as well");
        let hint = "give k alone, or length, diameter and material";
        f.refuse_key(Code::Conflict, "k", message, hint);
    }
    let rigid = !f.has("k") && geometry.is_none();
    Shaft {
        name,
        between,
        body: stiffness.map(ShaftBody::Stiffness).or(bar),
        loss: common::loss(
            f,
            "",
            Kind::TorsionalDamping,
            "`k`, or length, diameter and material",
            rigid,
        ),
    }
}

/// A round bar, where any of its keys is given.
fn bar(f: &mut Fields) -> Option<ShaftBody> {
    let length = f.optional_quantity("length", Kind::Length, Range::Positive);
    let (outer, inner) = outer_and_bore(f);
    let material = materials::read(f);
    let shear_modulus = f.optional_quantity("shear_modulus", Kind::Pressure, Range::Positive);
    let density = f.optional_quantity("density", Kind::Density, Range::Positive);
    let segments = f.optional_count("segments", 1, MOST).unwrap_or(1);
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
    f.need("length");
    f.need("diameter");
    if !f.has("material") {
        if !f.has("shear_modulus") {
            f.missing("material", " or `shear_modulus`");
        } else if mass != BarMass::None && !f.has("density") {
            f.missing("density", ", which its mass needs");
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
pub fn coupling(f: &mut Fields) -> Coupling {
    let name = common::name(f);
    let between = common::ends(f);
    let maxwell = tables::each(f, "maxwell", |f| {
        [
            f.quantity("k", Kind::TorsionalStiffness, Range::Positive),
            f.quantity("c", Kind::TorsionalDamping, Range::Positive),
        ]
    });
    let contact = common::coupled(f);
    if contact.stiffness.is_some_and(|k| k < 0.0)
        && matches!(contact.loss, Loss::Ratio(_) | Loss::Factor(_))
    {
        let key = if f.has("damping_ratio") {
            "damping_ratio"
        } else {
            "loss_factor"
        };
        let message = format!("`{key}` has no meaning beside a negative stiffness");
        f.refuse_key(Code::Conflict, key, message, "give `c` instead");
    }
    Coupling {
        name,
        between,
        contact,
        maxwell,
    }
}
