//! `[[bearing]]`, `[[damper]]`, `[speed]` and `[damping]`.

use super::common;
use super::friction;
use super::laws::Losses;
use super::model::{Axis, Bearing, Damper, GlobalDamping, Loss, MeanSpeed, Name};
use crate::base::code::Code;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;
use crate::base::toml::Value;

/// A bearing: any terms of a stiffness and a damping matrix.
pub fn bearing(f: &mut Fields) -> Bearing {
    let name = common::name(f);
    let between = common::ends_or_at(f);
    let stiffness = terms(f, "k", stiffness_kind);
    let damping = terms(f, "c", damping_kind);
    let loss = loss(f, &stiffness);
    let any = f.has_any("k_") || f.has_any("c_") || f.has_any("friction");
    if !any {
        f.missing("k_radial", " nor any other stiffness, damping or friction");
    }
    let friction = friction::of_bearing(f);
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
fn loss(f: &mut Fields, stiffness: &[(Axis, Axis, f64)]) -> Loss {
    let ratio = f.optional_number("damping_ratio", Range::NotNegative);
    let factor = f.optional_number("loss_factor", Range::NotNegative);
    f.exclusive("damping_ratio", "loss_factor");
    for key in ["damping_ratio", "loss_factor"] {
        if f.has(key) && f.has_any("c_") {
            let message = format!("`{key}` and a damper `c_…` are both losses of the bearing");
            f.refuse_key(Code::Conflict, key, message, "give one of them");
        } else if f.has(key) && stiffness.iter().any(|(row, column, _)| row != column) {
            let message = format!("`{key}` is of springs along the axes, and cross terms are none");
            f.refuse_key(Code::Conflict, key, message, "give dampers `c_…` instead");
        } else if f.has(key) && !f.has_any("k_") {
            f.missing(
                "k_radial",
                &format!(" nor any other stiffness, and `{key}` is of it"),
            );
        }
    }
    let ratio = ratio.map(Loss::Ratio);
    ratio.or(factor.map(Loss::Factor)).unwrap_or_default()
}

/// The terms whose keys start with `letter`; `radial` and `tilt` stand for two each.
fn terms(f: &mut Fields, letter: &str, kind: fn(Axis, Axis) -> Kind) -> Vec<(Axis, Axis, f64)> {
    let mut terms = Vec::new();
    for (word, axes) in [
        ("radial", [Axis::X, Axis::Y]),
        ("tilt", [Axis::TiltX, Axis::TiltY]),
    ] {
        let both = format!("{letter}_{word}");
        let value = f.optional_quantity(&both, kind(axes[0], axes[0]), Range::Any);
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
            let value = f.optional_quantity(&key, kind(row, column), Range::Any);
            terms.extend(value.map(|v| (row, column, v)));
        }
    }
    terms
}

fn stiffness_kind(row: Axis, column: Axis) -> Kind {
    match (row.turns(), column.turns()) {
        (false, false) => Kind::Stiffness,
        (false, true) => Kind::ForcePerAngle,
        (true, false) => Kind::TorquePerLength,
        (true, true) => Kind::TorsionalStiffness,
    }
}

fn damping_kind(row: Axis, column: Axis) -> Kind {
    match (row.turns(), column.turns()) {
        (false, false) => Kind::Damping,
        (false, true) => Kind::ForceRatePerAngle,
        (true, false) => Kind::TorqueRatePerLength,
        (true, true) => Kind::TorsionalDamping,
    }
}

/// A damper on rotation.
pub fn damper(f: &mut Fields) -> Damper {
    Damper {
        name: common::name(f),
        between: common::ends_or_at(f),
        coefficient: f.quantity("c", Kind::TorsionalDamping, Range::NotNegative),
    }
}

/// Mean speeds, whose keys are nodes.
pub fn speeds(f: &mut Fields) -> Vec<MeanSpeed> {
    let mut speeds = Vec::new();
    for (entry, speed) in f.every_quantity(Kind::Speed, Range::Any) {
        if entry.key == "ground" {
            let hint = "name a node that turns";
            f.refuse(
                Code::Conflict,
                "`ground` does not turn",
                &entry.key_place,
                hint,
            );
            continue;
        }
        let at = Name {
            text: entry.key.clone(),
            place: entry.key_place.clone(),
        };
        speeds.push(MeanSpeed { at, speed });
    }
    speeds
}

/// Damping of the whole machine.
pub fn damping(f: &mut Fields) -> GlobalDamping {
    let mass = f.optional_quantity("rayleigh_mass", Kind::PerSecond, Range::NotNegative);
    let stiffness = f.optional_quantity("rayleigh_stiffness", Kind::Time, Range::NotNegative);
    let modal = match f.item(
        "modal",
        "a ratio, or a list of ratios in rising order of modes",
    ) {
        None => Vec::new(),
        Some(item) => match &item.value {
            Value::List(list) => list
                .iter()
                .filter_map(|item| f.number_of("modal", item, Range::NotNegative))
                .collect(),
            _ => Vec::from_iter(f.number_of("modal", item, Range::NotNegative)),
        },
    };
    GlobalDamping {
        mass: mass.unwrap_or(0.0),
        stiffness: stiffness.unwrap_or(0.0),
        modal,
        contacts: f.choice("contacts", Losses::WORDS),
        place: Some(f.place.clone()),
    }
}
