//! Reads `[[inertia]]` and `[[chain]]`: rigid bodies and rows of equal discs.

use std::f64::consts::PI;

use super::materials;
use super::model::{DiscChain, Inertia};
use super::shared_keys::{self, MAX_COUNT};
use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;

/// A body: inertia given, or a disc from which it follows.
pub fn read_inertia(f: &mut TableReader) -> Inertia {
    let name = shared_keys::name(f);
    let polar = f.optional_quantity("J", QuantityKind::Inertia, ValueRange::NotNegative);
    let mass = f.optional_quantity("mass", QuantityKind::Mass, ValueRange::NotNegative);
    let diametral = f.optional_quantity(
        "J_diametral",
        QuantityKind::Inertia,
        ValueRange::NotNegative,
    );
    let disc = disc(f);
    if let Some(key) = ["diameter", "bore", "width", "density", "material"]
        .into_iter()
        .find(|key| f.has(key))
    {
        for given in ["J", "mass", "J_diametral"] {
            if f.has(given) {
                let message = format!("`{given}` is given, but is also determined by `{key}`");
                let hint = "give J, mass and J_diametral, or the dimensions of the disc";
                f.report_key(Code::Conflict, given, message, hint);
            }
        }
    } else if !f.has("J") {
        f.report_missing("J", ", nor diameter, width and material to compute it");
    }
    match disc {
        Some((polar, mass, diametral)) => Inertia {
            name,
            polar,
            mass: Some(mass),
            diametral: Some(diametral),
        },
        None => Inertia {
            name,
            polar: polar.unwrap_or(f64::NAN),
            mass,
            diametral,
        },
    }
}

/// Polar inertia, mass and diametral inertia of a hollow cylinder.
///
/// `m = ρπ(D² − d²)w/4`, `J = m(D² + d²)/8`, `J_d = J/2 + mw²/12`.
fn disc(f: &mut TableReader) -> Option<(f64, f64, f64)> {
    let (outer, inner) = outer_and_bore(f);
    let width = f.optional_quantity("width", QuantityKind::Length, ValueRange::Positive);
    let density = f.optional_quantity("density", QuantityKind::Density, ValueRange::Positive);
    let material = materials::read_material(f);
    f.exclusive("material", "density");
    let keys = ["diameter", "bore", "width", "density", "material"];
    if !keys.iter().any(|key| f.has(key)) {
        return None;
    }
    f.require("diameter");
    f.require("width");
    if !f.has("density") {
        f.require("material");
    }
    let (outer, width) = (outer?, width?);
    let density = density.or(material.map(|m| m.density))?;
    let squares = outer * outer + inner * inner;
    let mass = density * PI / 4.0 * (outer - inner) * (outer + inner) * width;
    let polar = mass * squares / 8.0;
    Some((polar, mass, polar / 2.0 + mass * width * width / 12.0))
}

/// `diameter` and `bore`, the bore being less.
pub fn outer_and_bore(f: &mut TableReader) -> (Option<f64>, f64) {
    let outer = f.optional_quantity("diameter", QuantityKind::Length, ValueRange::Positive);
    let inner = f
        .optional_quantity("bore", QuantityKind::Length, ValueRange::NotNegative)
        .unwrap_or(0.0);
    if let Some(outer) = outer.filter(|outer| inner >= *outer) {
        let message = format!(
            "the bore of {} mm is not below the diameter of {} mm",
            1e3 * inner,
            1e3 * outer
        );
        f.report_key(
            Code::OutOfRange,
            "bore",
            message,
            "the bore is the inner diameter",
        );
    }
    (outer, inner)
}

/// Equal discs on equal shafts.
pub fn read_disc_chain(f: &mut TableReader) -> DiscChain {
    let name = shared_keys::name(f);
    let count = f.optional_count("count", 1, MAX_COUNT);
    f.require("count");
    let polar = f.quantity("J", QuantityKind::Inertia, ValueRange::NotNegative);
    let stiffness = f.quantity(
        "k",
        QuantityKind::TorsionalStiffness,
        ValueRange::NotNegative,
    );
    let held = [
        ("none", (false, false)),
        ("start", (true, false)),
        ("end", (false, true)),
        ("both", (true, true)),
    ];
    let (start_held, end_held) = f.choice("held", &held).unwrap_or_default();
    DiscChain {
        name,
        count: count.unwrap_or(1) as usize,
        polar,
        stiffness,
        start_fixed: start_held,
        end_fixed: end_held,
        loss: shared_keys::read_damping(f, "", QuantityKind::TorsionalDamping, "`k`", false),
    }
}
