//! `[[bearing]]`, `[[damper]]`, `[speed]` and `[damping]`.

use super::friction;
use super::laws::ContactDamping;
use super::model::{Axis, Bearing, BranchDamping, Damper, GlobalDamping, MeanSpeed, Name};
use super::shared_keys;
use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;
use crate::base::toml::Value;

/// A bearing: any terms of a stiffness and a damping matrix.
pub fn bearing(f: &mut TableReader) -> Bearing {
    let name = shared_keys::name(f);
    let between = shared_keys::read_ends_or_node(f);
    let stiffness = read_matrix_terms(f, "k", stiffness_kind);
    let damping = read_matrix_terms(f, "c", damping_kind);
    let loss = loss(f, &stiffness);
    let any = f.has_prefix("k_") || f.has_prefix("c_") || f.has_prefix("friction");
    if !any {
        f.report_missing("k_radial", " nor any other stiffness, damping or friction");
    }
    let friction = friction::read_bearing_friction(f);
    Bearing {
        name,
        between,
        stiffness,
        damping,
        loss,
        friction,
    }
}

/// A ratio or a factor for every term of the stiffness; its dampers are terms of their own.
fn loss(f: &mut TableReader, stiffness: &[(Axis, Axis, f64)]) -> BranchDamping {
    let ratio = f.optional_number("damping_ratio", ValueRange::NotNegative);
    let factor = f.optional_number("loss_factor", ValueRange::NotNegative);
    f.exclusive("damping_ratio", "loss_factor");
    for key in ["damping_ratio", "loss_factor"] {
        if f.has(key) && f.has_prefix("c_") {
            let message =
                format!("`{key}` and a damper `c_…` both define the losses of the bearing");
            f.report_key(Code::Conflict, key, message, "give one of them");
        } else if f.has(key) && stiffness.iter().any(|(row, column, _)| row != column) {
            let message = format!("`{key}` applies to springs along the axes, not to cross terms");
            f.report_key(Code::Conflict, key, message, "give dampers `c_…` instead");
        } else if f.has(key) && !f.has_prefix("k_") {
            f.report_missing(
                "k_radial",
                &format!(" nor any other stiffness, which `{key}` needs"),
            );
        }
    }
    let ratio = ratio.map(BranchDamping::Ratio);
    ratio
        .or(factor.map(BranchDamping::Factor))
        .unwrap_or_default()
}

/// Terms whose keys start with `letter`; `radial` and `tilt` represent two each.
fn read_matrix_terms(
    f: &mut TableReader,
    letter: &str,
    kind: fn(Axis, Axis) -> QuantityKind,
) -> Vec<(Axis, Axis, f64)> {
    let mut terms = Vec::new();
    for (word, axes) in [
        ("radial", [Axis::X, Axis::Y]),
        ("tilt", [Axis::TiltX, Axis::TiltY]),
    ] {
        let both = format!("{letter}_{word}");
        let value = f.optional_quantity(&both, kind(axes[0], axes[0]), ValueRange::Any);
        terms.extend(value.iter().flat_map(|v| axes.map(|axis| (axis, axis, *v))));
        for axis in axes {
            f.exclusive(&both, &format!("{letter}_{}", axis.name()));
        }
    }
    for row in Axis::ALL {
        for column in Axis::ALL {
            let key = if row == column {
                format!("{letter}_{}", row.name())
            } else {
                format!("{letter}_{}_{}", row.name(), column.name())
            };
            let value = f.optional_quantity(&key, kind(row, column), ValueRange::Any);
            terms.extend(value.map(|v| (row, column, v)));
        }
    }
    terms
}

fn stiffness_kind(row: Axis, column: Axis) -> QuantityKind {
    match (row.is_rotation(), column.is_rotation()) {
        (false, false) => QuantityKind::Stiffness,
        (false, true) => QuantityKind::ForcePerAngle,
        (true, false) => QuantityKind::TorquePerLength,
        (true, true) => QuantityKind::TorsionalStiffness,
    }
}

fn damping_kind(row: Axis, column: Axis) -> QuantityKind {
    match (row.is_rotation(), column.is_rotation()) {
        (false, false) => QuantityKind::Damping,
        (false, true) => QuantityKind::ForceRatePerAngle,
        (true, false) => QuantityKind::TorqueRatePerLength,
        (true, true) => QuantityKind::TorsionalDamping,
    }
}

/// A damper on rotation.
pub fn damper(f: &mut TableReader) -> Damper {
    Damper {
        name: shared_keys::name(f),
        between: shared_keys::read_ends_or_node(f),
        coefficient: f.quantity("c", QuantityKind::TorsionalDamping, ValueRange::NotNegative),
    }
}

/// Mean speeds, whose keys are nodes.
pub fn speeds(f: &mut TableReader) -> Vec<MeanSpeed> {
    let mut speeds = Vec::new();
    for (entry, speed) in f.all_quantities(QuantityKind::Speed, ValueRange::Any) {
        if entry.key == "ground" {
            let hint = "name a node that turns";
            f.report(
                Code::Conflict,
                "`ground` does not turn",
                &entry.key_span,
                hint,
            );
            continue;
        }
        let at = Name {
            text: entry.key.clone(),
            span: entry.key_span.clone(),
        };
        speeds.push(MeanSpeed { at, speed });
    }
    speeds
}

/// Damping of the whole machine.
pub fn damping(f: &mut TableReader) -> GlobalDamping {
    let mass = f.optional_quantity(
        "rayleigh_mass",
        QuantityKind::PerSecond,
        ValueRange::NotNegative,
    );
    let stiffness = f.optional_quantity(
        "rayleigh_stiffness",
        QuantityKind::Time,
        ValueRange::NotNegative,
    );
    let modal = match f.item("modal", "a ratio, or a list of ratios in order of modes") {
        None => Vec::new(),
        Some(item) => match &item.value {
            Value::List(list) => list
                .iter()
                .filter_map(|item| f.number_of("modal", item, ValueRange::NotNegative))
                .collect(),
            _ => Vec::from_iter(f.number_of("modal", item, ValueRange::NotNegative)),
        },
    };
    GlobalDamping {
        mass: mass.unwrap_or(0.0),
        stiffness: stiffness.unwrap_or(0.0),
        modal,
        contacts: f.choice("contacts", ContactDamping::WORDS),
        span: Some(f.span.clone()),
    }
}
