//! What many tables share: names, ends, losses, contacts.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::characteristic;
use super::laws::{Characteristic, Losses};
use super::model::{Contact, End, Hand, Loss, Name};
use super::tables::one;
use super::waves;
use crate::base::code::Code;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;
use crate::base::toml::{Item, Value};

/// A pressure angle.
pub const PRESSURE: Range = Range::Between(0.0, PI / 4.0, "above 0° and below 45°");

/// A helix or spiral angle.
pub const HELIX: Range = Range::Within(0.0, FRAC_PI_2, "at least 0° and below 90°");

/// Pressure angle where none is given, rad.
pub const USUAL_PRESSURE: f64 = PI / 9.0;

/// The largest number of teeth, discs, segments or planets.
pub const MOST: u32 = 1_000_000;

/// The element's name; empty where it is missing or wrong, which is then noted.
pub fn name(f: &mut Fields) -> Name {
    let text = f.optional_text("name");
    f.need("name");
    let place = f.place_of("name").clone();
    let text = text.unwrap_or_default();
    let why = if !f.has("name") {
        ""
    } else if text.trim().is_empty() {
        "a name cannot be empty"
    } else if text == "ground" {
        "`ground` is the fixed frame, and no element can be called so"
    } else if text.len() > 80 {
        "a name of more than 80 bytes is too long for a table"
    } else if text.contains(|c: char| matches!(c, '.' | ',' | ':' | '"') || c.is_control())
        || text.trim() != text
    {
        "a name cannot hold any of . , : \" or begin or end with a space"
    } else {
        let text = text.to_string();
        return Name { text, place };
    };
    if !why.is_empty()
        && matches!(
            f.item("name", "text in quotes"),
            Some(Item {
                value: Value::Text(_),
                ..
            })
        )
    {
        f.refuse(
            Code::OutOfRange,
            why,
            &place,
            "nodes and freedoms are written node.axis",
        );
    }
    Name {
        text: String::new(),
        place,
    }
}

/// The end a text names.
fn end(text: &str, item: &Item) -> End {
    match text {
        "ground" => End::Ground,
        node => End::Node(Name {
            text: node.to_string(),
            place: item.place.clone(),
        }),
    }
}

/// What a missing or wrong end is read as.
fn no_end(f: &Fields) -> End {
    End::Node(Name {
        text: String::new(),
        place: f.place.clone(),
    })
}

/// One end under a key of its own.
pub fn one_end(f: &mut Fields, key: &str) -> End {
    const TAKES: &str = "the name of a node, or \"ground\"";
    match f.item(key, TAKES) {
        Some(item) => match &item.value {
            Value::Text(text) => end(text, item),
            _ => f.wrong_type(key, item, TAKES).unwrap_or(no_end(f)),
        },
        None => {
            f.missing(key, "");
            no_end(f)
        }
    }
}

/// A node under a key of its own.
pub fn one_node(f: &mut Fields, key: &str) -> Name {
    let end = one_end(f, key);
    node(f, end, key)
}

/// The node of an end that cannot be ground.
fn node(f: &mut Fields, end: End, key: &str) -> Name {
    match end {
        End::Node(name) => name,
        End::Ground => {
            f.refuse_key(
                Code::Conflict,
                key,
                "`ground` cannot turn, and a node that can is needed here",
                "name two bodies; a [[coupling]] without k holds a body to ground",
            );
            Name {
                text: String::new(),
                place: f.place.clone(),
            }
        }
    }
}

/// Both ends under `between`.
pub fn ends(f: &mut Fields) -> [End; 2] {
    const TAKES: &str = "two nodes, such as [\"motor\", \"pinion\"]";
    let nothing = [no_end(f), no_end(f)];
    let Some(item) = f.item("between", TAKES) else {
        f.missing("between", "");
        return nothing;
    };
    let Value::List(list) = &item.value else {
        return f.wrong_type("between", item, TAKES).unwrap_or(nothing);
    };
    let named: Vec<(&str, &Item)> = list
        .iter()
        .filter_map(|item| match &item.value {
            Value::Text(text) => Some((text.as_str(), item)),
            _ => None,
        })
        .collect();
    let (&[(one, first), (two, second)], 2) = (&named[..], list.len()) else {
        let message = format!("`between` has {} names", named.len());
        f.refuse(
            Code::WrongType,
            message,
            &item.place,
            &format!("it takes {TAKES}"),
        );
        return nothing;
    };
    if one == two {
        let message = format!("both ends are `{one}`, so nothing can deform between them");
        f.refuse(
            Code::Conflict,
            message,
            &item.place,
            &format!("it takes {TAKES}"),
        );
    }
    [end(one, first), end(two, second)]
}

/// Both ends under `between`, or `at` for one node against ground.
pub fn ends_or_at(f: &mut Fields) -> [End; 2] {
    f.exclusive("at", "between");
    if f.has("between") {
        f.item("at", "the name of a node");
        ends(f)
    } else {
        f.item("between", "two nodes");
        [End::Node(one_node(f, "at")), End::Ground]
    }
}

/// Two bodies under `between`.
pub fn bodies(f: &mut Fields) -> [Name; 2] {
    let [one, two] = ends(f);
    [node(f, one, "between"), node(f, two, "between")]
}

/// At most one loss; `suffix` tells several contacts of one element apart, `stiffness` is the key it goes with.
pub fn loss(f: &mut Fields, suffix: &str, damping: Kind, stiffness: &str, rigid: bool) -> Loss {
    let keys = ["c", "damping_ratio", "loss_factor"].map(|key| format!("{key}{suffix}"));
    let viscous = f.optional_quantity(&keys[0], damping, Range::NotNegative);
    let ratio = f.optional_number(&keys[1], Range::NotNegative);
    let factor = f.optional_number(&keys[2], Range::NotNegative);
    let given: Vec<&str> = keys
        .iter()
        .map(String::as_str)
        .filter(|key| f.has(key))
        .collect();
    if let [one, other, ..] = given[..] {
        f.exclusive(one, other);
    } else if let ([key], true) = (&given[..], rigid) {
        let message = format!("`{key}` damps a rigid element, which never deforms");
        let hint = format!("give {stiffness}, or leave `{key}` out");
        f.refuse_key(Code::Conflict, key, message, &hint);
    }
    let viscous = viscous.map(Loss::Viscous);
    viscous
        .or(ratio.map(Loss::Ratio))
        .or(factor.map(Loss::Factor))
        .unwrap_or_default()
}

/// Stiffness, losses and play along a line; keys end in `suffix`.
pub fn along(f: &mut Fields, suffix: &str) -> Contact {
    const UNITS: Units = Units {
        stiffness: Kind::Stiffness,
        range: Range::NotNegative,
        damping: Kind::Damping,
        deflection: Kind::Length,
        most: (1.0, "1 m"),
        characteristic: characteristic::along_tooth,
    };
    resisting(f, suffix, UNITS)
}

/// The same between teeth, whose stiffness may change over the mesh cycle.
pub fn contact(f: &mut Fields, suffix: &str) -> Contact {
    let contact = along(f, suffix);
    let wave = one(f, &format!("k_wave{suffix}"), waves::stiffness).flatten();
    if contact.characteristic.is_some() && wave.is_some() {
        let [wave, curve] = ["k_wave", "characteristic"].map(|key| format!("{key}{suffix}"));
        f.exclusive(&curve, &wave);
    }
    Contact { wave, ..contact }
}

/// Stiffness, losses and lost motion of a coupling.
pub fn coupled(f: &mut Fields) -> Contact {
    const UNITS: Units = Units {
        stiffness: Kind::TorsionalStiffness,
        range: Range::Any,
        damping: Kind::TorsionalDamping,
        deflection: Kind::Angle,
        most: (100.0, "100 rad"),
        characteristic: characteristic::torsional,
    };
    resisting(f, "", UNITS)
}

/// What an element measures its resistance in.
struct Units {
    stiffness: Kind,
    range: Range,
    damping: Kind,
    deflection: Kind,
    /// The largest play. A contact's deflection is what the distance of its sides exceeds half the play by: this much keeps its force to
    /// 1e-9 of what a micrometre, or a hundredth of a degree, of it exerts.
    most: (f64, &'static str),
    characteristic: fn(&mut Fields) -> Option<Characteristic>,
}

/// Plays below this are no lengths or angles of a machine, m or rad; borders so near to each other are lost in rounding.
const LEAST_PLAY: f64 = 1e-30;

fn resisting(f: &mut Fields, suffix: &str, units: Units) -> Contact {
    let [k, curve, backlash] =
        ["k", "characteristic", "backlash"].map(|key| format!("{key}{suffix}"));
    let stiffness = f.optional_quantity(&k, units.stiffness, units.range);
    let characteristic = one(f, &curve, units.characteristic).flatten();
    f.exclusive(&k, &curve);
    let rigid = !f.has(&k) && !f.has(&curve) && !f.has("maxwell");
    let contact = Contact {
        stiffness: stiffness.or(characteristic.as_ref().map(Characteristic::rated)),
        loss: loss(f, suffix, units.damping, &format!("`{k}`"), rigid),
        backlash: f
            .optional_quantity(&backlash, units.deflection, Range::NotNegative)
            .unwrap_or(0.0),
        losses: losses(f, suffix),
        wave: None,
        characteristic,
    };
    if contact.backlash > units.most.0 {
        let message = format!(
            "`{backlash}` must not exceed {}: the deflection of the contact would be lost in the digits of the play",
            units.most.1
        );
        let hint = "look at its unit; what never touches is left out";
        f.refuse_key(Code::OutOfRange, &backlash, message, hint);
    }
    if contact.backlash > 0.0 && contact.backlash < LEAST_PLAY {
        let message = format!(
            "`{backlash}` is {:e} in SI units, less than any play",
            contact.backlash
        );
        f.refuse_key(
            Code::OutOfRange,
            &backlash,
            message,
            "leave it out, or write 0",
        );
    }
    if f.has(&curve) {
        for key in ["damping_ratio", "loss_factor"].map(|key| format!("{key}{suffix}")) {
            if f.has(&key) {
                let message = format!("`{key}` goes with one stiffness, and `{curve}` has many");
                f.refuse_key(Code::Conflict, &key, message, "give `c` instead");
            }
        }
        if contact.backlash > 0.0 {
            let message = format!("`{backlash}` and `{curve}` both say what happens about rest");
            let hint = "put the play into the curve: a table whose second point still has no force";
            f.refuse_key(Code::Conflict, &backlash, message, hint);
        }
    }
    contact
}

/// What the damper of a contact does where it opens.
pub fn losses(f: &mut Fields, suffix: &str) -> Option<Losses> {
    f.choice(&format!("contact_damping{suffix}"), Losses::WORDS)
}

/// The hand of the first gear.
pub fn hand(f: &mut Fields) -> Hand {
    f.choice("hand", &[("right", Hand::Right), ("left", Hand::Left)])
        .unwrap_or_default()
}

/// Where the mesh stands round each axis, rad.
pub fn mesh_angles(f: &mut Fields, usual: [f64; 2]) -> [f64; 2] {
    f.optional_quantities("mesh_angles", Kind::Angle, Range::Any, Some(2))
        .and_then(|angles| angles.try_into().ok())
        .unwrap_or(usual)
}

/// Angles of `count` places equally spaced from zero, rad.
pub fn equally_spaced(count: u32) -> Vec<f64> {
    (0..count)
        .map(|i| TAU * f64::from(i) / f64::from(count))
        .collect()
}
