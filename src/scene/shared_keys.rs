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

/// Range of a pressure angle.
pub const PRESSURE_ANGLE_RANGE: ValueRange =
    ValueRange::Open(0.0, PI / 4.0, "above 0° and below 45°");

/// Range of a helix or spiral angle.
pub const HELIX_ANGLE_RANGE: ValueRange =
    ValueRange::HalfOpen(0.0, FRAC_PI_2, "at least 0° and below 90°");

/// Default pressure angle, rad.
pub const DEFAULT_PRESSURE_ANGLE: f64 = PI / 9.0;

/// Maximum number of teeth of a gear whose flanks are described.
pub const MAX_TEETH: u32 = 100_000;

/// Maximum number of teeth, discs, segments or planets.
pub const MAX_COUNT: u32 = 1_000_000;

/// Reads the element's name; empty if it is missing or invalid, which is reported.
pub fn name(f: &mut TableReader) -> Name {
    let text = f.optional_text("name");
    f.require("name");
    let span = f.span_of("name").clone();
    let text = text.unwrap_or_default();
    let reason = if !f.has("name") {
        ""
    } else if text.trim().is_empty() {
        "a name cannot be empty"
    } else if text == "ground" {
        "`ground` is the fixed frame and is reserved"
    } else if text.len() > 80 {
        "a name of more than 80 bytes is too long for a table"
    } else if text.contains(|c: char| matches!(c, '.' | ',' | ':' | '"') || c.is_control())
        || text.trim() != text
    {
        "a name cannot contain . , : \" or a line end, nor begin or end with a space"
    } else {
        let text = text.to_string();
        return Name { text, span };
    };
    if !reason.is_empty()
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
            reason,
            &span,
            "write a degree of freedom as node.axis",
        );
    }
    Name {
        text: String::new(),
        span,
    }
}

/// Branch end that a text names.
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

/// Reads one branch end under `key`.
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

/// Reads a node under `key`.
pub fn read_node(f: &mut TableReader, key: &str) -> Name {
    let end = read_end(f, key);
    node(f, end, key)
}

/// Node of a branch end; ground is reported as an error.
fn node(f: &mut TableReader, end: BranchEnd, key: &str) -> Name {
    match end {
        BranchEnd::Node(name) => name,
        BranchEnd::Ground => {
            f.report_key(
                Code::Conflict,
                key,
                "`ground` cannot turn; a turning node is needed here",
                "name two bodies; fix a body to ground by a [[coupling]] without k",
            );
            Name {
                text: String::new(),
                span: f.span.clone(),
            }
        }
    }
}

/// Reads both branch ends under `between`.
pub fn read_ends(f: &mut TableReader) -> [BranchEnd; 2] {
    const TAKES: &str = "two nodes, such as [\"motor\", \"pinion\"]";
    let placeholder = [no_end(f), no_end(f)];
    let Some(item) = f.item("between", TAKES) else {
        f.report_missing("between", "");
        return placeholder;
    };
    let Value::List(list) = &item.value else {
        return f.wrong_type("between", item, TAKES).unwrap_or(placeholder);
    };
    let names: Vec<(&str, &Item)> = list
        .iter()
        .filter_map(|item| match &item.value {
            Value::String(text) => Some((text.as_str(), item)),
            _ => None,
        })
        .collect();
    let (&[(name_1, item_1), (name_2, item_2)], 2) = (&names[..], list.len()) else {
        let message = format!("`between` has {} names", names.len());
        f.report(
            Code::WrongType,
            message,
            &item.span,
            &format!("it takes {TAKES}"),
        );
        return placeholder;
    };
    if name_1 == name_2 {
        let message = format!("both ends are `{name_1}`");
        f.report(
            Code::Conflict,
            message,
            &item.span,
            &format!("it takes {TAKES}"),
        );
    }
    [end_from_text(name_1, item_1), end_from_text(name_2, item_2)]
}

/// Reads both branch ends under `between`, or one node under `at` that is joined to ground.
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

/// Reads two bodies under `between`.
pub fn read_body_pair(f: &mut TableReader) -> [Name; 2] {
    let [first, second] = read_ends(f);
    [node(f, first, "between"), node(f, second, "between")]
}

/// Reads at most one damping value; `suffix` distinguishes the contacts of an element, `stiffness` is the key of their stiffness.
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
    let stated_keys: Vec<&str> = keys
        .iter()
        .map(String::as_str)
        .filter(|key| f.has(key))
        .collect();
    if let [first, second, ..] = stated_keys[..] {
        f.exclusive(first, second);
    } else if let ([key], true) = (&stated_keys[..], rigid) {
        let message = format!("`{key}` damps a rigid element, which never deforms");
        let hint = format!("give {stiffness}, or omit `{key}`");
        f.report_key(Code::Conflict, key, message, &hint);
    }
    let viscous = viscous.map(BranchDamping::Viscous);
    viscous
        .or(ratio.map(BranchDamping::Ratio))
        .or(factor.map(BranchDamping::Factor))
        .unwrap_or_default()
}

/// Reads stiffness, damping and backlash of a translational contact; keys end in `suffix`.
pub fn read_contact(f: &mut TableReader, suffix: &str) -> ContactParameters {
    const UNITS: ContactUnits = ContactUnits {
        stiffness: QuantityKind::Stiffness,
        range: ValueRange::NotNegative,
        damping: QuantityKind::Damping,
        deflection: QuantityKind::Length,
        max_backlash: (1.0, "1 m"),
        characteristic: characteristic::force_deflection,
    };
    read_contact_in(f, suffix, UNITS)
}

/// Reads the contact parameters of teeth, whose stiffness may vary over the mesh cycle.
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

/// Reads stiffness, damping and backlash of a coupling.
pub fn read_coupling_contact(f: &mut TableReader) -> ContactParameters {
    const UNITS: ContactUnits = ContactUnits {
        stiffness: QuantityKind::TorsionalStiffness,
        range: ValueRange::Any,
        damping: QuantityKind::TorsionalDamping,
        deflection: QuantityKind::Angle,
        max_backlash: (100.0, "100 rad"),
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
    /// Maximum backlash, m or rad, and its text. A contact deflects by the distance of its sides less half the backlash; the maximum limits
    /// the rounding of the force to 1e-9 of the force at a deflection of 1 µm or 0.01°.
    max_backlash: (f64, &'static str),
    characteristic: fn(&mut TableReader) -> Option<Characteristic>,
}

/// Minimum backlash, m or rad; below it the two switching surfaces coincide in rounding.
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
    if contact.backlash > units.max_backlash.0 {
        let message = format!(
            "`{backlash}` must not exceed {}: the deflection of the contact would be lost in the digits of the play",
            units.max_backlash.1
        );
        let hint = "check its unit; omit contacts that never close";
        f.report_key(Code::OutOfRange, &backlash, message, hint);
    }
    if contact.backlash > 0.0 && contact.backlash < MIN_BACKLASH {
        let message = format!(
            "`{backlash}` is {:e} in SI units, below any physical backlash",
            contact.backlash
        );
        f.report_key(Code::OutOfRange, &backlash, message, "omit it, or write 0");
    }
    if f.has(&curve) {
        for key in ["damping_ratio", "loss_factor"].map(|key| format!("{key}{suffix}")) {
            if f.has(&key) {
                let message = format!("`{key}` needs a constant stiffness, but `{curve}` is given");
                f.report_key(Code::Conflict, &key, message, "give `c` instead");
            }
        }
        if contact.backlash > 0.0 {
            let message =
                format!("`{backlash}` and `{curve}` both define the behaviour at zero deflection");
            let hint = "include the play in the curve: a table whose second point has no force";
            f.report_key(Code::Conflict, &backlash, message, hint);
        }
    }
    contact
}

/// Reads the damping law of an opening contact.
pub fn read_contact_damping(f: &mut TableReader, suffix: &str) -> Option<ContactDamping> {
    f.choice(&format!("contact_damping{suffix}"), ContactDamping::WORDS)
}

/// Reads the hand of the first gear, by default right.
pub fn hand(f: &mut TableReader) -> Hand {
    stated_hand(f).unwrap_or_default()
}

/// Reads the hand of a gear; none if it is not stated.
pub fn stated_hand(f: &mut TableReader) -> Option<Hand> {
    f.choice("hand", &[("right", Hand::Right), ("left", Hand::Left)])
}

/// Reads the profile shift coefficient of a gear.
pub fn read_profile_shift(f: &mut TableReader) -> Option<f64> {
    f.optional_number("profile_shift", ValueRange::Open(-3.0, 3.0, "within ±3"))
}

/// Reads the lower and the upper deviation of the normal tooth thickness, m.
pub fn read_thickness(f: &mut TableReader) -> Option<[f64; 2]> {
    let values = f.optional_quantities("thickness", QuantityKind::Length, ValueRange::Any, Some(2));
    let thickness: [f64; 2] = values?.try_into().ok()?;
    if thickness[0] >= thickness[1] {
        let hint = "`thickness` takes the lower allowance first: [\"-120 µm\", \"-60 µm\"]";
        f.report_key(Code::OutOfRange, "thickness", "`thickness` falls", hint);
    }
    Some(thickness)
}

/// Reads the angle of the mesh about each axis, rad.
pub fn mesh_angles(f: &mut TableReader, default_angles: [f64; 2]) -> [f64; 2] {
    f.optional_quantities("mesh_angles", QuantityKind::Angle, ValueRange::Any, Some(2))
        .and_then(|angles| angles.try_into().ok())
        .unwrap_or(default_angles)
}

/// Angles of `count` positions equally spaced from zero, rad.
pub fn equally_spaced(count: u32) -> Vec<f64> {
    (0..count)
        .map(|i| TAU * f64::from(i) / f64::from(count))
        .collect()
}
