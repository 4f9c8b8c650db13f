//! Reads friction laws: Stribeck parameters, bearing friction, tooth friction.

use super::laws::{FrictionLaw, ToothFriction};
use super::model::{BearingFriction, Name};
use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;

/// Keys that say how a bearing is loaded, all of them with `friction`.
const LOADED: [&str; 3] = ["friction_radius", "radial_load", "carries"];

/// Reads a bearing's friction from `T₀`, `μ`, a radius and a load; absent by default.
pub fn read_bearing_friction(f: &mut TableReader) -> Option<BearingFriction> {
    let constant = f.optional_quantity(
        "friction_torque",
        QuantityKind::Torque,
        ValueRange::NotNegative,
    );
    let coefficient = f.optional_number("friction", ValueRange::NotNegative);
    let radius = f.optional_quantity(
        "friction_radius",
        QuantityKind::Length,
        ValueRange::Positive,
    );
    let load = f.optional_quantity("radial_load", QuantityKind::Force, ValueRange::NotNegative);
    let carries = f.optional_text("carries").map(|text| Name {
        text: text.to_string(),
        span: f.span_of("carries").clone(),
    });
    let share = f.optional_number("share", ValueRange::NotNegative);
    let law = read_unit_capacity_law(f);
    if f.has("friction") && !f.has("friction_radius") {
        f.report_missing("friction_radius", ", at which `friction` acts");
    }
    if let (false, Some(key)) = (f.has("friction"), LOADED.into_iter().find(|key| f.has(key))) {
        f.report_missing("friction", &format!(", and `{key}` is given"));
    }
    if f.has("share") && !f.has("carries") {
        f.report_missing("carries", ", the pair whose tooth force `share` refers to");
    }
    f.exclusive("radial_load", "carries");
    if constant.is_none() && coefficient.is_none() {
        return None;
    }
    let lever = coefficient.unwrap_or(0.0) * radius.unwrap_or(0.0);
    Some(BearingFriction {
        law,
        constant: constant.unwrap_or(0.0) + lever * load.unwrap_or(0.0),
        coefficient: match load {
            Some(_) => 0.0,
            None => lever,
        },
        loaded_by: carries.map(|pair| (pair, share.unwrap_or(1.0))),
    })
}

/// A law of the capacity one, and how much more sticking bears.
pub fn read_unit_capacity_law(f: &mut TableReader) -> FrictionLaw {
    let over = ValueRange::HalfOpen(1.0, 100.0, "at least 1 and below 100");
    let ratio = f.optional_number("breakaway_ratio", over).unwrap_or(1.0);
    read_stribeck_law(f, 1.0, ratio)
}

/// Reads the Stribeck law: the fall of breakaway to sliding friction, and the step width for methods without events.
pub fn read_stribeck_law(f: &mut TableReader, sliding: f64, breakaway: f64) -> FrictionLaw {
    let stribeck = f.optional_quantity("stribeck_speed", QuantityKind::Speed, ValueRange::Positive);
    let creep = f.optional_quantity("creep_speed", QuantityKind::Speed, ValueRange::Positive);
    FrictionLaw {
        sliding,
        breakaway,
        stribeck_velocity: stribeck.unwrap_or(0.0),
        regularisation_velocity: creep.unwrap_or(1e-4), // rad/s: a turn in 17 h
    }
}

/// Friction along the teeth of a pair; absent where no coefficient is given.
pub fn read_tooth_friction(
    f: &mut TableReader,
    inclined: bool,
    bevel: bool,
) -> Option<ToothFriction> {
    let coefficient = f.optional_number("friction", ValueRange::NotNegative);
    let along = f.choice("sliding", &[("mean", false), ("path", true)]);
    let tips = f.optional_quantities(
        "tip_diameters",
        QuantityKind::Length,
        ValueRange::Positive,
        Some(2),
    );
    let phase = f.optional_quantity("path_phase", QuantityKind::Angle, ValueRange::Any);
    let creep = f.optional_quantity("creep_speed", QuantityKind::Speed, ValueRange::Positive);
    let beside = ["sliding", "tip_diameters", "path_phase", "creep_speed"];
    if !f.has("friction") {
        if let Some(key) = beside.into_iter().find(|key| f.has(key)) {
            f.report_missing("friction", &format!(", and `{key}` is given"));
        }
        return None;
    }
    let path = along.unwrap_or(false);
    if f.has("path_phase") && !path {
        let hint = "add sliding = \"path\", or omit the phase";
        let message = "`path_phase` applies to friction along the path of contact only";
        f.report_key(Code::Conflict, "path_phase", message, hint);
    }
    if !["k", "characteristic", "gear"].iter().any(|key| f.has(key)) {
        f.report_missing("k", ", which gives the tooth force of `friction`");
    }
    if bevel {
        let message = "`friction` applies to gears on parallel axes only";
        let hint = "omit it, or state the loss as `friction_torque` of a [[bearing]]";
        f.report_key(Code::Conflict, "friction", message, hint);
    }
    if inclined && path {
        let message = "helical teeth pass the pitch point gradually";
        let hint = "use sliding = \"mean\", the mean friction over the mesh cycle";
        f.report_key(Code::Conflict, "sliding", message, hint);
    }
    Some(ToothFriction {
        law: FrictionLaw {
            sliding: 1.0,
            breakaway: 1.0,
            stribeck_velocity: 1.0,
            regularisation_velocity: creep.unwrap_or(1e-4), // rad/s: a turn in 17 h
        },
        coefficient: coefficient.unwrap_or(0.0),
        tips: tips.map(|d| [0.5 * d[0], 0.5 * d[1]]),
        path: path.then(|| phase.unwrap_or(0.0)),
    })
}
