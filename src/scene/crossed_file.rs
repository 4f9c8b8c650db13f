//! Reads a gear file of a crossed helical pair: `pair`, `pinion`, `gear`, `[assembly]`, `[contact]`.

use std::f64::consts::PI;
use std::sync::Arc;

use super::shared_keys::{DEFAULT_PRESSURE_ANGLE, MAX_TEETH, PRESSURE_ANGLE_RANGE, read_thickness};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::ValueRange;
use crate::base::flags::Flags;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::TableReader;
use crate::base::tables::{read_file, read_heading, read_table};
use crate::gear::cylindrical::involute::InvoluteGear;
use crate::gear::helicoid::crossed_pair::{CrossedGear, CrossedPair};

/// A crossed pair as its file describes it.
#[derive(Debug, Clone)]
pub struct CrossedFile {
    /// Title in the file.
    pub title: String,
    /// Normal module, m.
    pub module: f64,
    /// Pinion and gear.
    pub gears: [InvoluteGear; 2],
    /// The pair as assembled; its mirror image where the sum of the helix angles, right hand positive, is below zero.
    pub pair: CrossedPair,
    /// −1 where `pair` is the mirror image at the plane y = 0, otherwise 1.
    pub mirror: f64,
    /// Face widths, m.
    pub face_widths: [Option<f64>; 2],
    /// Thickness of the coating, m.
    pub coating: f64,
    /// Values that the file leaves to their defaults, in words.
    pub defaults: Vec<String>,
    /// Place of `pair`.
    pub span: SourceSpan,
    /// The file.
    pub source: Arc<SourceFile>,
}

/// Thickness of marking compound by default, m.
const COATING: f64 = 6.35e-6;

/// Reads one; no flag of a load applies.
///
/// # Errors
/// Everything wrong in it and in the flags; helices that cannot mesh at the shaft angle.
pub fn read(source: &Arc<SourceFile>, flags: &Flags) -> Result<CrossedFile, Errors> {
    flags.read("a crossed pair", None, &[], |_| ())?;
    let (title, span, gears, displaced, coating) = read_file(source, "the gear file", |f| {
        let title = read_heading(f);
        let span = f.span_of("pair").clone();
        let pair = read_table(f, "pair", pair);
        let first = read_table(f, "pinion", member);
        f.require("pinion");
        let second = read_table(f, "gear", member);
        f.require("gear");
        let displaced = read_table(f, "assembly", assembly).unwrap_or_default();
        let coating = read_table(f, "contact", coating).flatten();
        (title, span, pair.zip(first.zip(second)), displaced, coating)
    })?;
    let missing = || Error::new(Code::MissingKey, "the gears are not described").with_span(&span);
    let (pair, (first, second)) = gears.ok_or_else(missing)?;
    let [offset, angle_error] = displaced;
    let mut defaults = Vec::new();
    let pressure_angle = pair.pressure_angle.unwrap_or_else(|| {
        let usual = DEFAULT_PRESSURE_ANGLE.to_degrees();
        defaults.push(format!("pair.pressure_angle: {usual:.0} deg"));
        DEFAULT_PRESSURE_ANGLE
    });
    let members = [first, second];
    let gears = members.each_ref().map(|member| InvoluteGear {
        teeth: member.teeth,
        module: pair.module,
        pressure_angle,
        helix: member.hand * member.helix_angle,
        profile_shift: member.profile_shift,
        internal: false,
    });
    let names = ["pinion", "gear"];
    let tips = [0, 1].map(|k| {
        members[k].tip_diameter.unwrap_or_else(|| {
            let height = pair.module * (1.0 + members[k].profile_shift);
            let diameter = gears[k].reference_diameter() + 2.0 * height;
            defaults.push(format!(
                "{}.tip_diameter: {:.4} mm, an addendum of one module",
                names[k],
                1e3 * diameter
            ));
            diameter
        })
    });
    let shaft_angle = pair.shaft_angle.unwrap_or_else(|| {
        let angle = (gears[0].helix + gears[1].helix).abs();
        defaults.push(format!(
            "pair.shaft_angle: the sum of the helix angles, {:.4} deg",
            angle.to_degrees()
        ));
        angle
    });
    let mirror = 1f64.copysign(gears[0].helix + gears[1].helix);
    let crossed = [0, 1].map(|k| {
        let gear = &gears[k];
        let alpha = gear.transverse_pressure_angle();
        CrossedGear {
            teeth: gear.teeth,
            helix: mirror * gear.helix,
            radius: 0.5 * gear.reference_diameter(),
            base_radius: 0.5 * gear.base_diameter(),
            tip_radius: 0.5 * tips[k],
            base_half_angle: (gear.nominal_thickness() + members[k].thickness_deviation)
                / (gear.helix.cos() * gear.reference_diameter())
                + alpha.tan()
                - alpha,
        }
    });
    let mut assembled = CrossedPair {
        gears: crossed,
        pressure_angle,
        centre_distance: 0.0,
        shaft_angle,
    };
    let located = |error: Error| error.with_span(&span);
    if assembled.path().is_none() || !(shaft_angle.sin() > 1e-3) {
        return Err(located(no_common_normal(&assembled)).into());
    }
    let distance = match pair.centre_distance {
        Some(distance) => distance,
        None => {
            let tight = assembled.tight_centre_distance().ok_or_else(|| {
                let message = "no centre distance gives zero backlash";
                let hint = "give `centre_distance`, or check helix angles, hands and shaft_angle";
                located(Error::new(Code::OutOfRange, message).with_hint(hint))
            })?;
            defaults.push(format!(
                "pair.centre_distance: {:.4} mm, without backlash",
                1e3 * tight
            ));
            tight
        }
    };
    assembled.centre_distance = distance + offset;
    assembled.shaft_angle += angle_error;
    if assembled.path().is_none() {
        return Err(located(no_common_normal(&assembled)).into());
    }
    if !(distance + offset > 0.0) {
        let message = format!("the axes are {:.4} mm apart", 1e3 * (distance + offset));
        let error = Error::new(Code::OutOfRange, message);
        return Err(located(error.with_hint("reduce [assembly] offset")).into());
    }
    if coating.is_none() {
        defaults.push("contact.coating: 6.35 µm".into());
    }
    Ok(CrossedFile {
        title,
        module: pair.module,
        gears,
        pair: assembled,
        mirror,
        face_widths: members.map(|m| m.face_width),
        coating: coating.unwrap_or(COATING),
        defaults,
        span,
        source: source.clone(),
    })
}

/// Helices that share no normal at a shaft angle.
fn no_common_normal(pair: &CrossedPair) -> Error {
    let [least, greatest] = pair.shaft_angles().map(f64::to_degrees);
    let message = format!(
        "the base helices have no common normal at a shaft angle of {:.4}°",
        pair.shaft_angle.to_degrees()
    );
    Error::new(Code::OutOfRange, message).with_hint(format!(
        "take a shaft angle above {least:.3}° and below {greatest:.3}°, or other helix angles and hands; parallel axes are kind = \"cylindrical\""
    ))
}

/// `pair` as written.
struct PairTable {
    module: f64,
    pressure_angle: Option<f64>,
    shaft_angle: Option<f64>,
    centre_distance: Option<f64>,
}

fn pair(f: &mut TableReader) -> PairTable {
    const SHAFT_RANGE: ValueRange = ValueRange::Open(0.0, PI, "above 0° and below 180°");
    f.choice("kind", &[("crossed", ())]);
    f.require("kind");
    let angle = QuantityKind::Angle;
    PairTable {
        module: f.quantity("module", QuantityKind::Length, ValueRange::Positive),
        pressure_angle: f.optional_quantity("pressure_angle", angle, PRESSURE_ANGLE_RANGE),
        shaft_angle: f.optional_quantity("shaft_angle", angle, SHAFT_RANGE),
        centre_distance: f.optional_quantity(
            "centre_distance",
            QuantityKind::Length,
            ValueRange::Positive,
        ),
    }
}

/// A member as written.
struct MemberTable {
    teeth: u32,
    helix_angle: f64,
    hand: f64,
    profile_shift: f64,
    tip_diameter: Option<f64>,
    face_width: Option<f64>,
    thickness_deviation: f64,
}

fn member(f: &mut TableReader) -> MemberTable {
    const HELIX_RANGE: ValueRange = ValueRange::HalfOpen(0.0, 1.5, "at least 0° and below 86°");
    const SHIFT_RANGE: ValueRange = ValueRange::Open(-5.0, 5.0, "above −5 and below 5");
    let length = QuantityKind::Length;
    let teeth = f.optional_count("teeth", 1, MAX_TEETH);
    f.require("teeth");
    let helix_angle = f.quantity("helix_angle", QuantityKind::Angle, HELIX_RANGE);
    let hand = f.choice("hand", &[("right", 1.0), ("left", -1.0)]);
    if helix_angle > 0.0 {
        f.require("hand");
    }
    MemberTable {
        teeth: teeth.unwrap_or(1),
        helix_angle,
        hand: hand.unwrap_or(1.0),
        profile_shift: f
            .optional_number("profile_shift", SHIFT_RANGE)
            .unwrap_or(0.0),
        tip_diameter: f.optional_quantity("tip_diameter", length, ValueRange::Positive),
        face_width: f.optional_quantity("face_width", length, ValueRange::Positive),
        thickness_deviation: read_thickness(f).map_or(0.0, |[low, high]| 0.5 * (low + high)),
    }
}

fn assembly(f: &mut TableReader) -> [f64; 2] {
    let offset = f.optional_quantity("offset", QuantityKind::Length, ValueRange::Any);
    let angle = f.optional_quantity("shaft_angle_error", QuantityKind::Angle, ValueRange::Any);
    [offset.unwrap_or(0.0), angle.unwrap_or(0.0)]
}

fn coating(f: &mut TableReader) -> Option<f64> {
    const RANGE: ValueRange = ValueRange::Open(1e-9, 1e-3, "above 1 nm and below 1 mm");
    f.optional_quantity("coating", QuantityKind::Length, RANGE)
}
