//! Keys shared by many tables: names, ends, damping, contact parameters.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::characteristic;
use super::laws::{Characteristic, ContactDamping};
use super::model::{BranchDamping, BranchEnd, ContactParameters, Hand, Name};
use super::waveforms;
use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;
use crate::base::tables::read_table;
use crate::base::toml::{Item, Value};

/// A pressure angle.
pub const PRESSURE_ANGLE_RANGE: ValueRange =
    ValueRange::Open(0.0, PI / 4.0, "above 0° and below 45°");

/// A helix or spiral angle.
pub const HELIX_ANGLE_RANGE: ValueRange =
    ValueRange::HalfOpen(0.0, FRAC_PI_2, "at least 0° and below 90°");

/// Pressure angle where none is given, rad.
pub const DEFAULT_PRESSURE_ANGLE: f64 = PI / 9.0;

/// The largest number of teeth of a gear whose flanks are described.
pub const MAX_TEETH: u32 = 100_000;

/// The largest number of teeth, discs, segments or planets.
pub const MAX_COUNT: u32 = 1_000_000;

/// The element's name; empty where it is missing or wrong, which is then noted.
pub fn name(f: &mut TableReader) -> Name {
    let text = f.optional_text("name");
    f.require("name");
    let place = f.span_of("name").clone();
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
        "a name cannot contain . , : \" or a line end, nor begin or end with a space"
    } else {
        let text = text.to_string();
        return Name { text, span: place };
    };
    if !why.is_empty()
        && matches!(
            f.item("name", "text in quotes"),
            Some(Item {
                value: Value::String(_),
                ..
            })
        )
    {
        f.report(
            Code::OutOfRange,
            why,
            &place,
            "nodes and degrees of freedom are written node.axis",
        );
    }
    Name {
        text: String::new(),
        span: place,
    }
}

/// The end a text names.
fn end_from_text(text: &str, item: &Item) -> BranchEnd {
    match text {
        "ground" => BranchEnd::Ground,
        node => BranchEnd::Node(Name {
            text: node.to_string(),
            span: item.span.clone(),
        }),
    }
}

/// Placeholder for a missing or wrong end.
fn no_end(f: &TableReader) -> BranchEnd {
    BranchEnd::Node(Name {
        text: String::new(),
        span: f.span.clone(),
    })
}

/// One end under a key of its own.
pub fn read_end(f: &mut TableReader, key: &str) -> BranchEnd {
    const TAKES: &str = "the name of a node, or \"ground\"";
    match f.item(key, TAKES) {
        Some(item) => match &item.value {
            Value::String(text) => end_from_text(text, item),
            _ => f.wrong_type(key, item, TAKES).unwrap_or(no_end(f)),
        },
        None => {
            f.report_missing(key, "");
            no_end(f)
        }
    }
}

/// A node under a key of its own.
pub fn read_node(f: &mut TableReader, key: &str) -> Name {
    let end = read_end(f, key);
    node(f, end, key)
}

/// The node of an end that cannot be ground.
fn node(f: &mut TableReader, end: BranchEnd, key: &str) -> Name {
    match end {
        BranchEnd::Node(name) => name,
        BranchEnd::Ground => {
            f.report_key(
                Code::Conflict,
                key,
                "`ground` cannot turn, and a node that can is needed here",
                "name two bodies; a [[coupling]] without k holds a body to ground",
            );
            Name {
                text: String::new(),
                span: f.span.clone(),
            }
        }
    }
}

/// Both ends under `between`.
pub fn read_ends(f: &mut TableReader) -> [BranchEnd; 2] {
    const TAKES: &str = "two nodes, such as [\"motor\", \"pinion\"]";
    let nothing = [no_end(f), no_end(f)];
    let Some(item) = f.item("between", TAKES) else {
        f.report_missing("between", "");
        return nothing;
    };
    let Value::List(list) = &item.value else {
        return f.wrong_type("between", item, TAKES).unwrap_or(nothing);
    };
    let named: Vec<(&str, &Item)> = list
        .iter()
        .filter_map(|item| match &item.value {
            Value::String(text) => Some((text.as_str(), item)),
            _ => None,
        })
        .collect();
    let (&[(one, first), (two, second)], 2) = (&named[..], list.len()) else {
        let message = format!("`between` has {} names", named.len());
        f.report(
            Code::WrongType,
            message,
            &item.span,
            &format!("it takes {TAKES}"),
        );
        return nothing;
    };
    if one == two {
        let message = format!("both ends are `{one}`, so nothing can deform between them");
        f.report(
            Code::Conflict,
            message,
            &item.span,
            &format!("it takes {TAKES}"),
        );
    }
    [end_from_text(one, first), end_from_text(two, second)]
}

/// Both ends under `between`, or `at` for one node against ground.
pub fn read_ends_or_node(f: &mut TableReader) -> [BranchEnd; 2] {
    f.exclusive("at", "between");
    if f.has("between") {
        f.item("at", "the name of a node");
        read_ends(f)
    } else {
        f.item("between", "two nodes");
        [BranchEnd::Node(read_node(f, "at")), BranchEnd::Ground]
    }
}

/// Two bodies under `between`.
pub fn read_body_pair(f: &mut TableReader) -> [Name; 2] {
    let [one, two] = read_ends(f);
    [node(f, one, "between"), node(f, two, "between")]
}

/// At most one loss; `suffix` tells several contacts of one element apart, `read_stiffness_variation` is the key it goes with.
pub fn read_damping(
    f: &mut TableReader,
    suffix: &str,
    damping: QuantityKind,
    stiffness: &str,
    rigid: bool,
) -> BranchDamping {
    let keys = ["c", "damping_ratio", "loss_factor"].map(|key| format!("{key}{suffix}"));
    let viscous = f.optional_quantity(&keys[0], damping, ValueRange::NotNegative);
    let ratio = f.optional_number(&keys[1], ValueRange::NotNegative);
    let factor = f.optional_number(&keys[2], ValueRange::NotNegative);
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
        f.report_key(Code::Conflict, key, message, &hint);
    }
    let viscous = viscous.map(BranchDamping::Viscous);
    viscous
        .or(ratio.map(BranchDamping::Ratio))
        .or(factor.map(BranchDamping::Factor))
        .unwrap_or_default()
}

/// Stiffness, losses and play along a line; keys end in `suffix`.
pub fn read_contact(f: &mut TableReader, suffix: &str) -> ContactParameters {
    const UNITS: ContactUnits = ContactUnits {
        stiffness: QuantityKind::Stiffness,
        range: ValueRange::NotNegative,
        damping: QuantityKind::Damping,
        deflection: QuantityKind::Length,
        max_play: (1.0, "1 m"),
        characteristic: characteristic::force_deflection,
    };
    read_contact_in(f, suffix, UNITS)
}

/// The same between teeth, whose stiffness may change over the mesh cycle.
pub fn read_mesh_contact(f: &mut TableReader, suffix: &str) -> ContactParameters {
    let contact = read_contact(f, suffix);
    let wave = read_table(
        f,
        &format!("k_wave{suffix}"),
        waveforms::read_stiffness_variation,
    )
    .flatten();
    if contact.characteristic.is_some() && wave.is_some() {
        let [wave, curve] = ["k_wave", "characteristic"].map(|key| format!("{key}{suffix}"));
        f.exclusive(&curve, &wave);
    }
    ContactParameters { wave, ..contact }
}

/// Stiffness, losses and lost motion of a coupling.
pub fn read_coupling_contact(f: &mut TableReader) -> ContactParameters {
    const UNITS: ContactUnits = ContactUnits {
        stiffness: QuantityKind::TorsionalStiffness,
        range: ValueRange::Any,
        damping: QuantityKind::TorsionalDamping,
        deflection: QuantityKind::Angle,
        max_play: (100.0, "100 rad"),
        characteristic: characteristic::torque_twist,
    };
    read_contact_in(f, "", UNITS)
}

/// Units of an element's contact parameters.
struct ContactUnits {
    stiffness: QuantityKind,
    range: ValueRange,
    damping: QuantityKind,
    deflection: QuantityKind,
    /// The largest play. A contact's deflection is what the distance of its sides exceeds half the play by: this much keeps its force to
    /// 1e-9 of what a micrometre, or a hundredth of a degree, of it exerts.
    max_play: (f64, &'static str),
    characteristic: fn(&mut TableReader) -> Option<Characteristic>,
}

/// Smallest play of a machine, m or rad; switching surfaces so near to each other are lost in rounding.
const MIN_BACKLASH: f64 = 1e-30;

fn read_contact_in(f: &mut TableReader, suffix: &str, units: ContactUnits) -> ContactParameters {
    let [k, curve, backlash] =
        ["k", "characteristic", "backlash"].map(|key| format!("{key}{suffix}"));
    let stiffness = f.optional_quantity(&k, units.stiffness, units.range);
    let characteristic = read_table(f, &curve, units.characteristic).flatten();
    f.exclusive(&k, &curve);
    let rigid = ![&k, &curve, "maxwell", &format!("gear{suffix}")]
        .iter()
        .any(|key| f.has(key));
    let contact = ContactParameters {
        stiffness: stiffness.or(characteristic.as_ref().map(Characteristic::rated_secant)),
        loss: read_damping(f, suffix, units.damping, &format!("`{k}`"), rigid),
        backlash: f
            .optional_quantity(&backlash, units.deflection, ValueRange::NotNegative)
            .unwrap_or(0.0),
        damping_model: read_contact_damping(f, suffix),
        wave: None,
        characteristic,
        flanks: None,
    };
    if contact.backlash > units.max_play.0 {
        let message = format!(
            "`{backlash}` must not exceed {}: the deflection of the contact would be lost in the digits of the play",
            units.max_play.1
        );
        let hint = "check its unit; what never touches is left out";
        f.report_key(Code::OutOfRange, &backlash, message, hint);
    }
    if contact.backlash > 0.0 && contact.backlash < MIN_BACKLASH {
        let message = format!(
            "`{backlash}` is {:e} in SI units, less than any play",
            contact.backlash
        );
        f.report_key(
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
                f.report_key(Code::Conflict, &key, message, "give `c` instead");
            }
        }
        if contact.backlash > 0.0 {
            let message = format!("`{backlash}` and `{curve}` both say what happens about rest");
            let hint = "put the play into the curve: a table whose second point still has no force";
            f.report_key(Code::Conflict, &backlash, message, hint);
        }
    }
    contact
}

/// Reads the damping law of a contact as it opens.
pub fn read_contact_damping(f: &mut TableReader, suffix: &str) -> Option<ContactDamping> {
    f.choice(&format!("contact_damping{suffix}"), ContactDamping::WORDS)
}

/// The hand of the first gear.
pub fn hand(f: &mut TableReader) -> Hand {
    stated_hand(f).unwrap_or_default()
}

/// The hand of a gear where it is stated.
pub fn stated_hand(f: &mut TableReader) -> Option<Hand> {
    f.choice("hand", &[("right", Hand::Right), ("left", Hand::Left)])
}

/// Reads the profile shift coefficient of a gear.
pub fn read_profile_shift(f: &mut TableReader) -> Option<f64> {
    f.optional_number("profile_shift", ValueRange::Open(-3.0, 3.0, "within ±3"))
}

/// Reads the lower and the upper deviation of the normal tooth thickness, m.
pub fn read_thickness(f: &mut TableReader) -> Option<[f64; 2]> {
    let read = f.optional_quantities("thickness", QuantityKind::Length, ValueRange::Any, Some(2));
    let thickness: [f64; 2] = read?.try_into().ok()?;
    if thickness[0] >= thickness[1] {
        let hint = "`thickness` takes the lower allowance first: [\"-120 µm\", \"-60 µm\"]";
        f.report_key(Code::OutOfRange, "thickness", "`thickness` falls", hint);
    }
    Some(thickness)
}

/// Reads the angle of the mesh round each axis, rad.
pub fn mesh_angles(f: &mut TableReader, usual: [f64; 2]) -> [f64; 2] {
    f.optional_quantities("mesh_angles", QuantityKind::Angle, ValueRange::Any, Some(2))
        .and_then(|angles| angles.try_into().ok())
        .unwrap_or(usual)
}

/// Angles of `count` places equally spaced from zero, rad.
pub fn equally_spaced(count: u32) -> Vec<f64> {
    (0..count)
        .map(|i| TAU * f64::from(i) / f64::from(count))
        .collect()
}
