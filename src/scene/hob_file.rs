//! Reads a gear file of a helical gear and the hob that cuts it: `helicoid` with `type = "gear"`, `tool` with `kind = "hob"`.

use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

use super::shared_keys::{DEFAULT_PRESSURE_ANGLE, MAX_TEETH, PRESSURE_ANGLE_RANGE};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::ValueRange;
use crate::base::flags::Flags;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::TableReader;
use crate::base::tables::{read_file, read_heading, read_table};
use crate::base::toml::{self, Value};
use crate::gear::cylindrical::involute::InvoluteGear;
use crate::gear::helicoid::hob::{Hobbing, axis_angle};
use crate::gear::helicoid::worm_thread::{FlankType, WormThread};
use crate::gear::kernel::crossed_axes::CrossedAxes;

/// A gear and its hob as their file describes them.
#[derive(Debug, Clone)]
pub struct HobFile {
    /// Title in the file.
    pub title: String,
    /// The gear, of a right hand where the file has a left one.
    pub gear: InvoluteGear,
    /// 1 for a right hand of the gear, −1 for a left one: then all is the mirror image.
    pub hand: f64,
    /// Thread of the hob as stated.
    pub hob: WormThread,
    /// The involute hob of the same data.
    pub involute_hob: WormThread,
    /// Diameter of the hob, m.
    pub hob_diameter: f64,
    /// Feed along the gear for a turn of it, m.
    pub feed: Option<f64>,
    /// Values that the file leaves to their defaults, in words.
    pub defaults: Vec<String>,
    /// Place of `tool`.
    pub span: SourceSpan,
    /// The file.
    pub source: Arc<SourceFile>,
}

impl HobFile {
    /// The hob in the gear; none where its thread does not exist.
    pub fn hobbing(&self, hob: &WormThread) -> Option<Hobbing> {
        let teeth = f64::from(self.gear.teeth);
        let radius = 0.5 * self.gear.reference_diameter();
        let shifted = radius + self.gear.profile_shift * self.gear.module;
        Some(Hobbing {
            space_flank: hob.helicoid()?,
            heights: [FRAC_PI_4 * hob.module; 2],
            axes: CrossedAxes {
                offset: 0.5 * self.hob_diameter + shifted,
                shaft_angle: axis_angle(hob.lead_angle(), self.gear.helix),
                ratio: -f64::from(hob.starts) / teeth,
            },
            gear_lead: radius / self.gear.helix.tan(),
        })
    }
}

/// Whether a file of a helicoid describes a gear with its hob.
pub fn is_hob(source: &Arc<SourceFile>) -> bool {
    let root = toml::parse(source).root;
    let kind = root.table("tool").and_then(|(tool, _)| tool.get("kind"));
    matches!(kind.map(|entry| &entry.item.value), Some(Value::String(kind)) if kind == "hob")
}

/// Reads one; no flag of a load applies.
///
/// # Errors
/// Everything wrong in it and in the flags.
pub fn read(source: &Arc<SourceFile>, flags: &Flags) -> Result<HobFile, Errors> {
    flags.read("a hob", None, &[], |_| ())?;
    let (title, span, gear, tool) = read_file(source, "the gear file", |f| {
        let title = read_heading(f);
        let span = f.span_of("tool").clone();
        let gear = read_table(f, "helicoid", gear).flatten();
        f.require("helicoid");
        let tool = read_table(f, "tool", tool).flatten();
        (title, span, gear, tool)
    })?;
    let missing =
        || Error::new(Code::MissingKey, "gear and hob are not described").with_span(&span);
    let (gear, tool) = gear.zip(tool).ok_or_else(missing)?;
    let mut defaults = Vec::new();
    let pressure_angle = gear.pressure_angle.unwrap_or_else(|| {
        defaults.push(format!(
            "helicoid.pressure_angle: {:.0} deg",
            DEFAULT_PRESSURE_ANGLE.to_degrees()
        ));
        DEFAULT_PRESSURE_ANGLE
    });
    let sine = f64::from(tool.starts) * gear.module / tool.diameter;
    if !(sine < 0.7) {
        let message = format!(
            "a hob of {} starts and {:.3} mm diameter has a lead angle of {:.1}°",
            tool.starts,
            1e3 * tool.diameter,
            sine.min(1.0).asin().to_degrees()
        );
        return Err(Error::new(Code::OutOfRange, message)
            .with_span(&span)
            .with_hint("take a larger diameter or fewer starts: sin γ₀ = starts·module/diameter")
            .into());
    }
    let axial_module = gear.module / sine.asin().cos();
    let thread = |flank: FlankType| WormThread {
        flank,
        starts: tool.starts,
        module: axial_module,
        diameter_quotient: tool.diameter / axial_module,
        pressure_angle,
    };
    Ok(HobFile {
        title,
        gear: InvoluteGear {
            teeth: gear.teeth,
            module: gear.module,
            pressure_angle,
            helix: gear.helix_angle,
            profile_shift: gear.profile_shift,
            internal: false,
        },
        hand: gear.hand,
        hob: thread(tool.flank),
        involute_hob: thread(FlankType::Zi),
        hob_diameter: tool.diameter,
        feed: tool.feed,
        defaults,
        span,
        source: source.clone(),
    })
}

/// `helicoid` as written.
struct GearTable {
    teeth: u32,
    module: f64,
    pressure_angle: Option<f64>,
    helix_angle: f64,
    hand: f64,
    profile_shift: f64,
}

fn gear(f: &mut TableReader) -> Option<GearTable> {
    const HELIX: ValueRange = ValueRange::Open(0.0, 1.3, "above 0° and below 74°");
    const SHIFT: ValueRange = ValueRange::Open(-5.0, 5.0, "above −5 and below 5");
    f.choice("type", &[("gear", ())]);
    f.require("type");
    let teeth = f.optional_count("teeth", 4, MAX_TEETH);
    f.require("teeth");
    let table = GearTable {
        teeth: teeth.unwrap_or(4),
        module: f.quantity("module", QuantityKind::Length, ValueRange::Positive),
        pressure_angle: f.optional_quantity(
            "pressure_angle",
            QuantityKind::Angle,
            PRESSURE_ANGLE_RANGE,
        ),
        helix_angle: f.quantity("helix_angle", QuantityKind::Angle, HELIX),
        hand: f
            .choice("hand", &[("right", 1.0), ("left", -1.0)])
            .unwrap_or(1.0),
        profile_shift: f.optional_number("profile_shift", SHIFT).unwrap_or(0.0),
    };
    f.require("hand");
    teeth.map(|_| table)
}

/// `tool` as written.
struct ToolTable {
    flank: FlankType,
    starts: u32,
    diameter: f64,
    feed: Option<f64>,
}

fn tool(f: &mut TableReader) -> Option<ToolTable> {
    f.choice("kind", &[("hob", ())]);
    let types = [
        ("ZI", FlankType::Zi),
        ("ZA", FlankType::Za),
        ("ZN", FlankType::ZnSpace),
    ];
    let flank = f.choice("type", &types);
    f.require("type");
    let starts = f.optional_count("starts", 1, 30);
    f.require("starts");
    let diameter = f.quantity("diameter", QuantityKind::Length, ValueRange::Positive);
    let feed = f.optional_quantity("feed", QuantityKind::Length, ValueRange::Positive);
    Some(ToolTable {
        flank: flank?,
        starts: starts?,
        diameter,
        feed,
    })
}
