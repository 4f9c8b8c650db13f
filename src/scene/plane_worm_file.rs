//! Reads a gear file of a plane double-enveloping worm pair: `pair`, `worm` with `type = "plane-enveloping"`, `wheel`.

use std::sync::Arc;

use super::worm_file::{MAX_STARTS, MAX_WHEEL_TEETH, check_shaft_angle};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::ValueRange;
use crate::base::flags::Flags;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::TableReader;
use crate::base::tables::{read_file, read_heading, read_table};
use crate::base::toml::{self, Value};
use crate::gear::helicoid::plane_worm::PlaneWorm;
use crate::gear::helicoid::plane_worm_zone::PlaneWormZone;

/// The word of `worm.type`.
pub const PLANE_ENVELOPING: &str = "plane-enveloping";

/// A plane-generated worm and its wheel as their file describes them.
#[derive(Debug, Clone)]
pub struct PlaneWormFile {
    /// Title in the file.
    pub title: String,
    /// The pair.
    pub pair: PlaneWorm,
    /// Starts of the worm, teeth of the wheel.
    pub teeth: [u32; 2],
    /// 1 for a right hand, −1 for a left one.
    pub hand: f64,
    /// Length of the worm, m.
    pub length: f64,
    /// Face width of the wheel, m.
    pub face_width: f64,
    /// Tip diameter of the worm in its throat, and of the wheel, m.
    pub tip_diameters: [f64; 2],
    /// Values that the file leaves to their defaults, in words.
    pub defaults: Vec<String>,
    /// Place of `worm`.
    pub span: SourceSpan,
    /// The file.
    pub source: Arc<SourceFile>,
}

impl PlaneWormFile {
    /// The zone where worm and wheel can touch.
    pub fn zone(&self) -> PlaneWormZone {
        let [worm_tip_radius, wheel_tip_radius] = self.tip_diameters.map(|d| 0.5 * d);
        PlaneWormZone {
            length: self.length,
            face_width: self.face_width,
            worm_tip_radius,
            wheel_tip_radius,
        }
    }
}

/// Whether a file of a worm pair describes one.
pub fn is_plane_worm(source: &Arc<SourceFile>) -> bool {
    let root = toml::parse(source).root;
    let kind = root.table("worm").and_then(|(worm, _)| worm.get("type"));
    matches!(kind.map(|entry| &entry.item.value), Some(Value::String(kind)) if kind == PLANE_ENVELOPING)
}

/// Reads one; no flag of a load applies.
///
/// # Errors
/// Everything wrong in it and in the flags.
pub fn read(source: &Arc<SourceFile>, flags: &Flags) -> Result<PlaneWormFile, Errors> {
    flags.read("a worm pair", None, &[], |_| ())?;
    let (title, span, pair, worm, wheel) = read_file(source, "the gear file", |f| {
        let title = read_heading(f);
        let span = f.span_of("worm").clone();
        let pair = read_table(f, "pair", pair);
        let worm = read_table(f, "worm", worm).flatten();
        let wheel = read_table(f, "wheel", wheel).flatten();
        f.require("wheel");
        (title, span, pair, worm, wheel)
    })?;
    let missing = || Error::new(Code::MissingKey, "the gears are not described").with_span(&span);
    let (centre_distance, (worm, wheel)) = pair.zip(worm.zip(wheel)).ok_or_else(missing)?;
    let mut defaults = Vec::new();
    let hand = worm.hand.unwrap_or_else(|| {
        defaults.push("hand: right".into());
        1.0
    });
    let file = PlaneWormFile {
        title,
        pair: PlaneWorm {
            centre_distance,
            ratio: f64::from(worm.starts) / f64::from(wheel.teeth),
            base_radius: worm.base_radius,
            plane_angle: worm.plane_angle,
        },
        teeth: [worm.starts, wheel.teeth],
        hand,
        length: worm.length,
        face_width: wheel.face_width,
        tip_diameters: [worm.tip_diameter, wheel.tip_diameter],
        defaults,
        span,
        source: source.clone(),
    };
    let [worm_tip, wheel_tip] = file.tip_diameters.map(|d| 0.5 * d);
    let problem = if !(worm_tip + wheel_tip > centre_distance) {
        Some((
            format!(
                "a worm of {:.3} mm and a wheel of {:.3} mm tip diameter do not touch at {:.3} mm",
                2e3 * worm_tip,
                2e3 * wheel_tip,
                1e3 * centre_distance
            ),
            "increase tip_diameter or reduce centre_distance",
        ))
    } else if !(file.pair.base_radius < centre_distance - worm_tip) {
        Some((
            format!(
                "the base circle of {:.3} mm radius does not lie within the wheel's teeth, which begin at {:.3} mm",
                1e3 * file.pair.base_radius,
                1e3 * (centre_distance - worm_tip)
            ),
            "reduce base_radius: 0.6 to 0.65 of half the centre distance is usual",
        ))
    } else {
        None
    };
    match problem {
        None => Ok(file),
        Some((message, hint)) => Err(Error::new(Code::OutOfRange, message)
            .with_span(&file.span)
            .with_hint(hint)
            .into()),
    }
}

fn pair(f: &mut TableReader) -> f64 {
    f.choice("kind", &[("worm", ())]);
    check_shaft_angle(f);
    f.quantity(
        "centre_distance",
        QuantityKind::Length,
        ValueRange::Positive,
    )
}

/// `worm` as written.
struct WormTable {
    starts: u32,
    hand: Option<f64>,
    base_radius: f64,
    plane_angle: f64,
    length: f64,
    tip_diameter: f64,
}

fn worm(f: &mut TableReader) -> Option<WormTable> {
    const ANGLE: ValueRange = ValueRange::Open(0.0, 0.8, "above 0° and below 45°");
    f.choice("type", &[(PLANE_ENVELOPING, ())]);
    let starts = f.optional_count("starts", 1, MAX_STARTS);
    f.require("starts");
    let length =
        |f: &mut TableReader, key| f.quantity(key, QuantityKind::Length, ValueRange::Positive);
    let table = WormTable {
        starts: starts.unwrap_or(1),
        hand: f.choice("hand", &[("right", 1.0), ("left", -1.0)]),
        base_radius: length(f, "base_radius"),
        plane_angle: f.quantity("plane_angle", QuantityKind::Angle, ANGLE),
        length: length(f, "length"),
        tip_diameter: length(f, "tip_diameter"),
    };
    starts.map(|_| table)
}

/// `wheel` as written.
struct WheelTable {
    teeth: u32,
    face_width: f64,
    tip_diameter: f64,
}

fn wheel(f: &mut TableReader) -> Option<WheelTable> {
    let teeth = f.optional_count("teeth", 10, MAX_WHEEL_TEETH);
    f.require("teeth");
    let length =
        |f: &mut TableReader, key| f.quantity(key, QuantityKind::Length, ValueRange::Positive);
    let (face_width, tip_diameter) = (length(f, "face_width"), length(f, "tip_diameter"));
    Some(WheelTable {
        teeth: teeth?,
        face_width,
        tip_diameter,
    })
}
