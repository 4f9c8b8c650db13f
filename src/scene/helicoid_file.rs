//! Reads a gear file of a helicoid and the disk tool that cuts it: `helicoid`, `tool`.

use std::sync::Arc;

use super::worm_file::{ThreadTable, thread};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::ValueRange;
use crate::base::flags::Flags;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::TableReader;
use crate::base::tables::{read_file, read_heading, read_table};
use crate::gear::helicoid::worm_thread::WormThread;

/// A helicoid and its tool as their file describes them.
#[derive(Debug, Clone)]
pub struct HelicoidFile {
    /// Title in the file.
    pub title: String,
    /// The thread.
    pub thread: WormThread,
    /// 1 for a right hand, −1 for a left one.
    pub hand: f64,
    /// Least and greatest radius of the flank, m.
    pub radii: [f64; 2],
    /// Radius of the tool at the reference cylinder, m.
    pub tool_radius: f64,
    /// Angle of the axes, rad.
    pub axis_angle: f64,
    /// The thread as the wheel grinds it at another radius.
    pub reground: Option<WormThread>,
    /// Values that the file leaves to their defaults, in words.
    pub defaults: Vec<String>,
    /// Place of `helicoid`.
    pub span: SourceSpan,
    /// The file.
    pub source: Arc<SourceFile>,
}

/// Dedendum by default, in modules.
const DEDENDUM: f64 = 1.2;

/// Reads one; no flag of a load applies.
///
/// # Errors
/// Everything wrong in it and in the flags.
pub fn read(source: &Arc<SourceFile>, flags: &Flags) -> Result<HelicoidFile, Errors> {
    flags.read("a helicoid", None, &[], |_| ())?;
    let (title, span, helicoid, tool) = read_file(source, "the gear file", |f| {
        let title = read_heading(f);
        let span = f.span_of("helicoid").clone();
        let helicoid = read_table(f, "helicoid", helicoid).flatten();
        f.require("helicoid");
        let tool = read_table(f, "tool", tool);
        f.require("tool");
        (title, span, helicoid, tool)
    })?;
    let missing = || Error::new(Code::MissingKey, "the tool is not described").with_span(&span);
    let ((table, diameters), (tool_radius, axis_angle, reground_radius)) =
        helicoid.zip(tool).ok_or_else(missing)?;
    let ThreadTable {
        thread,
        hand,
        mut defaults,
    } = table;
    let (reference, module) = (thread.reference_radius(), thread.module);
    let usual = [reference - DEDENDUM * module, reference + module];
    let names = ["root_diameter", "tip_diameter"];
    let mut radii = usual;
    for k in 0..2 {
        match diameters[k] {
            Some(diameter) => radii[k] = 0.5 * diameter,
            None => defaults.push(format!("helicoid.{}: {:.4} mm", names[k], 2e3 * usual[k])),
        }
    }
    let axis_angle = axis_angle.unwrap_or_else(|| {
        let angle = thread.lead_angle();
        defaults.push(format!(
            "tool.axis_angle: the lead angle, {:.4} deg",
            angle.to_degrees()
        ));
        angle
    });
    let reground = reground_radius.map(|radius| {
        let message = "`tool.reground_radius` applies to ground threads only";
        let hint = "use type = \"ZK\" or \"ZC\", or omit reground_radius";
        let none = || Error::new(Code::Conflict, message).with_span(&span);
        thread
            .reground(radius)
            .ok_or_else(|| none().with_hint(hint))
    });
    let reground = reground.transpose()?;
    if !(0.0 < radii[0] && radii[0] < reference && reference < radii[1]) {
        let message = format!(
            "the flank from {:.3} to {:.3} mm diameter does not contain the reference diameter {:.3} mm",
            2e3 * radii[0],
            2e3 * radii[1],
            2e3 * reference
        );
        return Err(Error::new(Code::OutOfRange, message)
            .with_span(&span)
            .with_hint("check root_diameter and tip_diameter")
            .into());
    }
    Ok(HelicoidFile {
        title,
        thread,
        hand,
        radii,
        tool_radius,
        axis_angle,
        reground,
        defaults,
        span,
        source: source.clone(),
    })
}

fn helicoid(f: &mut TableReader) -> Option<(ThreadTable, [Option<f64>; 2])> {
    let table = thread(f);
    let diameters = ["root_diameter", "tip_diameter"]
        .map(|key| f.optional_quantity(key, QuantityKind::Length, ValueRange::Positive));
    Some((table?, diameters))
}

fn tool(f: &mut TableReader) -> (f64, Option<f64>, Option<f64>) {
    f.choice("kind", &[("disk", ())]);
    f.require("kind");
    const ANGLE_RANGE: ValueRange = ValueRange::Open(0.0, 1.5, "above 0° and below 86°");
    (
        f.quantity("radius", QuantityKind::Length, ValueRange::Positive),
        f.optional_quantity("axis_angle", QuantityKind::Angle, ANGLE_RANGE),
        f.optional_quantity(
            "reground_radius",
            QuantityKind::Length,
            ValueRange::Positive,
        ),
    )
}
