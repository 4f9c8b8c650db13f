//! Reads a gear file of a worm pair, with the tables `pair`, `worm` and `wheel`, and the keys of a thread.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use super::shared_keys::{DEFAULT_PRESSURE_ANGLE, PRESSURE_ANGLE_RANGE};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::ValueRange;
use crate::base::flags::Flags;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::TableReader;
use crate::base::tables::{read_file, read_heading, read_table};
use crate::gear::helicoid::worm_thread::{FlankType, WormThread};
use crate::gear::helicoid::worm_zone::WormZone;

/// Worm and wheel as described in their file.
#[derive(Debug, Clone)]
pub struct WormFile {
    /// Title in the file.
    pub title: String,
    /// Thread of the worm.
    pub thread: WormThread,
    /// 1 for right hand, −1 for left hand.
    pub hand: f64,
    /// Length of the worm, m.
    pub length: f64,
    /// Number of teeth of the wheel.
    pub teeth: u32,
    /// Profile shift coefficient of the wheel.
    pub profile_shift: f64,
    /// Face width of the wheel, m.
    pub face_width: f64,
    /// Tip diameter of the worm and throat diameter of the wheel, m.
    pub tip_diameters: [f64; 2],
    /// Outer diameter of the wheel, m.
    pub outer_diameter: f64,
    /// Values set by default, as text.
    pub defaults: Vec<String>,
    /// Source span of `worm`.
    pub span: SourceSpan,
    /// Source file.
    pub source: Arc<SourceFile>,
}

impl WormFile {
    /// Centre distance `a = r₁ + m (z₂/2 + x₂)`, m.
    pub fn centre_distance(&self) -> f64 {
        let half = 0.5 * f64::from(self.teeth) + self.profile_shift;
        self.thread.reference_radius() + self.thread.module * half
    }

    /// Lead angle and normal pressure angle on the pitch cylinder of the worm, rad: `tan γ′ = p/(r₁ + x m)`, and of the involute helicoid
    /// `cos α′ = cos γ cos α_n/cos γ′`.
    pub fn pitch_angles(&self) -> [f64; 2] {
        let thread = &self.thread;
        if self.profile_shift == 0.0 {
            return [thread.lead_angle(), thread.pressure_angle];
        }
        let radius = thread.reference_radius() + self.profile_shift * thread.module;
        let lead = thread.lead().atan2(radius);
        let cosine = thread.lead_angle().cos() * thread.pressure_angle.cos() / lead.cos();
        [lead, cosine.min(1.0).acos()]
    }

    /// Zone in which worm and wheel can be in contact.
    pub fn zone(&self) -> WormZone {
        let [worm_tip, throat] = self.tip_diameters.map(|d| 0.5 * d);
        WormZone {
            radii: [self.centre_distance() - throat, worm_tip],
            length: self.length,
            face_width: self.face_width,
            outer_radius: 0.5 * self.outer_diameter,
        }
    }
}

/// Maximum number of starts of a worm.
pub(super) const MAX_STARTS: u32 = 30;
/// Maximum number of teeth of a wheel.
pub(super) const MAX_WHEEL_TEETH: u32 = 1000;
const QUOTIENT_RANGE: ValueRange = ValueRange::Open(3.0, 200.0, "above 3 and below 200");

/// Reads a worm-pair file; load flags do not apply.
///
/// # Errors
/// All errors in the file and in the flags.
pub fn read(source: &Arc<SourceFile>, flags: &Flags) -> Result<WormFile, Errors> {
    flags.read("a worm pair", None, &[], |_| ())?;
    let (title, span, worm, wheel) = read_file(source, "the gear file", |f| {
        let title = read_heading(f);
        let span = f.span_of("worm").clone();
        read_table(f, "pair", pair);
        let worm = read_table(f, "worm", worm).flatten();
        f.require("worm");
        let wheel = read_table(f, "wheel", wheel);
        f.require("wheel");
        (title, span, worm, wheel)
    })?;
    let missing = || Error::new(Code::MissingKey, "the gears are not described").with_span(&span);
    let ((thread, length, worm_tip), wheel) = worm.zip(wheel).ok_or_else(missing)?;
    let module = thread.thread.module;
    let mut defaults = thread.defaults;
    let mut or_default = |value: Option<f64>, default: f64, name: &str, what: &str| {
        value.unwrap_or_else(|| {
            defaults.push(format!("{name}: {:.4} mm, {what}", 1e3 * default));
            default
        })
    };
    let addendum = "an addendum of one module";
    let default = 2.0 * (thread.thread.reference_radius() + module);
    let worm_tip = or_default(worm_tip, default, "worm.tip_diameter", addendum);
    let default = module * (f64::from(wheel.teeth) + 2.0 * (wheel.profile_shift + 1.0));
    let throat = or_default(wheel.tip_diameter, default, "wheel.tip_diameter", addendum);
    let outer_diameter = or_default(
        wheel.outer_diameter,
        throat + module,
        "wheel.outer_diameter",
        "a module above the throat",
    );
    let file = WormFile {
        title,
        thread: thread.thread,
        hand: thread.hand,
        length,
        teeth: wheel.teeth,
        profile_shift: wheel.profile_shift,
        face_width: wheel.face_width,
        tip_diameters: [worm_tip, throat],
        outer_diameter,
        defaults,
        span,
        source: source.clone(),
    };
    let overlap = 0.5 * (worm_tip + throat) - file.centre_distance();
    if overlap > 0.0 && throat < 2.0 * file.centre_distance() {
        return Ok(file);
    }
    let message = format!(
        "a worm of {:.3} mm tip diameter does not reach a wheel of {:.3} mm throat diameter at {:.3} mm",
        1e3 * worm_tip,
        1e3 * throat,
        1e3 * file.centre_distance()
    );
    Err(Error::new(Code::OutOfRange, message)
        .with_span(&file.span)
        .with_hint("check tip_diameter, teeth, module and profile_shift")
        .into())
}

fn pair(f: &mut TableReader) {
    f.choice("kind", &[("worm", ())]);
    f.require("kind");
    check_shaft_angle(f);
}

/// Checks that the shaft angle of a worm pair is 90°.
pub(super) fn check_shaft_angle(f: &mut TableReader) {
    let angle = f.optional_quantity("shaft_angle", QuantityKind::Angle, ValueRange::Any);
    if angle.is_some_and(|a| (a - FRAC_PI_2).abs() > 1e-9) {
        let message = "worm pairs at other shaft angles than 90° are not computed";
        let hint = "take 90 deg; helical gears at any angle are kind = \"crossed\"";
        f.report_key(Code::OutOfRange, "shaft_angle", message, hint);
    }
}

fn worm(f: &mut TableReader) -> Option<(ThreadTable, f64, Option<f64>)> {
    let thread = thread(f);
    let length = f.quantity("length", QuantityKind::Length, ValueRange::Positive);
    let tip = f.optional_quantity("tip_diameter", QuantityKind::Length, ValueRange::Positive);
    Some((thread?, length, tip))
}

/// Contents of `wheel`.
struct WheelTable {
    teeth: u32,
    profile_shift: f64,
    face_width: f64,
    tip_diameter: Option<f64>,
    outer_diameter: Option<f64>,
}

fn wheel(f: &mut TableReader) -> WheelTable {
    const SHIFT_RANGE: ValueRange = ValueRange::Open(-5.0, 5.0, "above −5 and below 5");
    let teeth = f.optional_count("teeth", 10, MAX_WHEEL_TEETH);
    f.require("teeth");
    let length = |f: &mut TableReader, key: &str| {
        f.optional_quantity(key, QuantityKind::Length, ValueRange::Positive)
    };
    WheelTable {
        teeth: teeth.unwrap_or(10),
        profile_shift: f
            .optional_number("profile_shift", SHIFT_RANGE)
            .unwrap_or(0.0),
        face_width: f.quantity("face_width", QuantityKind::Length, ValueRange::Positive),
        tip_diameter: length(f, "tip_diameter"),
        outer_diameter: length(f, "outer_diameter"),
    }
}

/// Thread as described by its keys.
pub(super) struct ThreadTable {
    /// The thread.
    pub thread: WormThread,
    /// 1 for right hand, −1 for left hand.
    pub hand: f64,
    /// Values set by default, as text.
    pub defaults: Vec<String>,
}

#[derive(Clone, Copy, PartialEq)]
enum ThreadType {
    Za,
    Zi,
    Zn,
    Zk,
    Zc,
}

/// Reads the keys of a thread; `None` if one is missing or invalid.
pub(super) fn thread(f: &mut TableReader) -> Option<ThreadTable> {
    let types = [
        ("ZA", ThreadType::Za),
        ("ZI", ThreadType::Zi),
        ("ZN", ThreadType::Zn),
        ("ZK", ThreadType::Zk),
        ("ZC", ThreadType::Zc),
    ];
    let mut defaults = Vec::new();
    let kind = f.choice("type", &types);
    f.require("type");
    let starts = f.optional_count("starts", 1, MAX_STARTS);
    f.require("starts");
    let module = f.quantity("module", QuantityKind::Length, ValueRange::Positive);
    let quotient = f.optional_number("diameter_quotient", QUOTIENT_RANGE);
    f.require("diameter_quotient");
    let angle = f.optional_quantity("pressure_angle", QuantityKind::Angle, PRESSURE_ANGLE_RANGE);
    let pressure_angle = angle.unwrap_or_else(|| {
        let usual = DEFAULT_PRESSURE_ANGLE.to_degrees();
        defaults.push(format!("pressure_angle: {usual:.0} deg, normal"));
        DEFAULT_PRESSURE_ANGLE
    });
    let hand = f.choice("hand", &[("right", 1.0), ("left", -1.0)]);
    let hand = hand.unwrap_or_else(|| {
        defaults.push("hand: right".into());
        1.0
    });
    let across = only_for(f, "across", kind == Some(ThreadType::Zn), "ZN", |f| {
        f.choice("across", &[("space", true), ("thread", false)])
    });
    let has_tool_radius = matches!(kind, Some(ThreadType::Zk | ThreadType::Zc));
    let length = |f: &mut TableReader, key: &str| {
        f.optional_quantity(key, QuantityKind::Length, ValueRange::Positive)
    };
    let tool_radius = only_for(f, "tool_radius", has_tool_radius, "ZK and ZC", |f| {
        let radius = length(f, "tool_radius");
        f.require("tool_radius");
        radius
    });
    let arc_radius = only_for(f, "arc_radius", kind == Some(ThreadType::Zc), "ZC", |f| {
        let radius = length(f, "arc_radius");
        f.require("arc_radius");
        radius
    });
    let flank = match kind? {
        ThreadType::Za => FlankType::Za,
        ThreadType::Zi => FlankType::Zi,
        ThreadType::Zn => match across {
            Some(false) => FlankType::ZnThread,
            Some(true) => FlankType::ZnSpace,
            None => {
                defaults.push("across: space".into());
                FlankType::ZnSpace
            }
        },
        ThreadType::Zk => FlankType::Zk {
            wheel_radius: tool_radius?,
        },
        ThreadType::Zc => FlankType::Zc {
            wheel_radius: tool_radius?,
            arc_radius: arc_radius?,
        },
    };
    let thread = WormThread {
        flank,
        starts: starts?,
        module,
        diameter_quotient: quotient?,
        pressure_angle,
    };
    // No thread is possible with a lead angle near 90°.
    if !(thread.lead_angle() < 0.45 * PI) {
        let message = format!("the lead angle is {:.1}°", thread.lead_angle().to_degrees());
        let hint =
            "take fewer starts or a larger diameter quotient: tan γ = starts/diameter_quotient";
        f.report_key(Code::OutOfRange, "starts", message, hint);
        return None;
    }
    Some(ThreadTable {
        thread,
        hand,
        defaults,
    })
}

/// Reads a key that only some flank types have; an error for the others.
fn only_for<T>(
    f: &mut TableReader,
    key: &str,
    applies: bool,
    types: &str,
    read: impl Fn(&mut TableReader) -> Option<T>,
) -> Option<T> {
    if applies {
        return read(f);
    }
    if f.has(key) {
        f.item(key, "nothing");
        let message = format!("`{key}` applies to the flank types {types} only");
        f.report_key(Code::Conflict, key, message, "remove it, or change `type`");
    }
    None
}
