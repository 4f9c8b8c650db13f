//! Dry friction: how the force falls once a pair slides, and what bearings and teeth rub with.

use super::laws::{Friction, ToothFriction};
use super::model::{BearingFriction, Name};
use crate::base::code::Code;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;

/// Keys that say how a bearing is loaded, all of them with `friction`.
const LOADED: [&str; 3] = ["friction_radius", "radial_load", "carries"];

/// What `T₀`, `μ`, a radius and a load make of a bearing's friction; absent where nothing is said of it.
pub fn of_bearing(f: &mut Fields) -> Option<BearingFriction> {
    let constant = f.optional_quantity("friction_torque", Kind::Torque, Range::NotNegative);
    let coefficient = f.optional_number("friction", Range::NotNegative);
    let radius = f.optional_quantity("friction_radius", Kind::Length, Range::Positive);
    let load = f.optional_quantity("radial_load", Kind::Force, Range::NotNegative);
    let carries = f.optional_text("carries").map(|text| Name {
        text: text.to_string(),
        place: f.place_of("carries").clone(),
    });
    let share = f.optional_number("share", Range::NotNegative);
    let law = of_one(f);
    if f.has("friction") && !f.has("friction_radius") {
        f.missing("friction_radius", ", at which `friction` acts");
    }
    if let (false, Some(key)) = (f.has("friction"), LOADED.into_iter().find(|key| f.has(key))) {
        f.missing("friction", &format!(", and `{key}` is given"));
    }
    if f.has("share") && !f.has("carries") {
        f.missing(
            "carries",
            ", the pair of whose tooth force `share` is a part",
        );
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
        carries: carries.map(|pair| (pair, share.unwrap_or(1.0))),
    })
}

/// A law of the capacity one, and how much more sticking bears.
pub fn of_one(f: &mut Fields) -> Friction {
    let over = Range::Within(1.0, 100.0, "at least 1 and below 100");
    let ratio = f.optional_number("breakaway_ratio", over).unwrap_or(1.0);
    falling(f, 1.0, ratio)
}

/// How fast breakaway falls to sliding, and how methods without events spread the step.
pub fn falling(f: &mut Fields, sliding: f64, breakaway: f64) -> Friction {
    let stribeck = f.optional_quantity("stribeck_speed", Kind::Speed, Range::Positive);
    let creep = f.optional_quantity("creep_speed", Kind::Speed, Range::Positive);
    Friction {
        sliding,
        breakaway,
        stribeck: stribeck.unwrap_or(0.0),
        creep: creep.unwrap_or(1e-4), // rad/s: a turn in 17 h
    }
}

/// Friction along the teeth of a pair; absent where no coefficient is given.
pub fn of_teeth(f: &mut Fields, inclined: bool, bevel: bool) -> Option<ToothFriction> {
    let coefficient = f.optional_number("friction", Range::NotNegative);
    let along = f.choice("sliding", &[("mean", false), ("path", true)]);
    let tips = f.optional_quantities("tip_diameters", Kind::Length, Range::Positive, Some(2));
    let phase = f.optional_quantity("path_phase", Kind::Angle, Range::Any);
    let creep = f.optional_quantity("creep_speed", Kind::Speed, Range::Positive);
    let beside = ["sliding", "tip_diameters", "path_phase", "creep_speed"];
    if !f.has("friction") {
        if let Some(key) = beside.into_iter().find(|key| f.has(key)) {
            f.missing("friction", &format!(", and `{key}` is given"));
        }
        return None;
    }
    let path = along.unwrap_or(false);
    if f.has("path_phase") && !path {
        let hint = "add sliding = \"path\", or leave the phase out";
        let message = "`path_phase` is of friction along the path of contact";
        f.refuse_key(Code::Conflict, "path_phase", message, hint);
    }
    if !f.has("k") && !f.has("characteristic") {
        f.missing("k", ", which gives the tooth force that `friction` goes by");
    }
    if bevel {
        let message = "`friction` is of gears on parallel axes";
        let hint = "leave it out, or put what it costs into a [[bearing]] with `friction_torque`";
        f.refuse_key(Code::Conflict, "friction", message, hint);
    }
    if inclined && path {
        let message = "teeth at a helix angle pass the pitch point bit by bit";
        let hint = "take sliding = \"mean\", their friction over the whole mesh cycle";
        f.refuse_key(Code::Conflict, "sliding", message, hint);
    }
    Some(ToothFriction {
        law: Friction {
            sliding: 1.0,
            breakaway: 1.0,
            stribeck: 1.0,
            creep: creep.unwrap_or(1e-4), // rad/s: a turn in 17 h
        },
        coefficient: coefficient.unwrap_or(0.0),
        tips: tips.map(|d| [0.5 * d[0], 0.5 * d[1]]),
        path: path.then(|| phase.unwrap_or(0.0)),
    })
}
