//! Reads the readings of an unknown gear: `[measured_gear]` with spans in place of a module.

use std::sync::Arc;

use super::shared_keys::MAX_TEETH;
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::{ErrorCollector, ValueRange};
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::TableReader;
use crate::base::tables::{read_heading, read_table, read_tables};
use crate::base::toml;
use crate::gear::cylindrical::reverse::readings::{
    GearReadings, MateReadings, Reading, SpanReading,
};

/// Readings of an unknown gear as their file states them.
#[derive(Debug, Clone)]
pub struct GearReadingsFile {
    /// Title in the file.
    pub title: String,
    /// The readings.
    pub readings: GearReadings,
    /// Place of `[measured_gear]`.
    pub span: SourceSpan,
    /// The file.
    pub source: Arc<SourceFile>,
}

/// True if the file has `[measured_gear]` with `spans` and without `module`.
pub fn is_readings_file(source: &Arc<SourceFile>) -> bool {
    let document = toml::parse(source);
    let gear = document.root.table("measured_gear");
    gear.is_some_and(|(gear, _)| gear.get("spans").is_some() && gear.get("module").is_none())
}

/// Reads one.
///
/// # Errors
/// Everything wrong in it.
pub fn read(source: &Arc<SourceFile>) -> Result<GearReadingsFile, Errors> {
    let document = toml::parse(source);
    let table = document.root.table("measured_gear");
    if let Some(module) = table.and_then(|(table, _)| table.get("module")) {
        let message = "`module` is already known";
        let error = Error::new(Code::Conflict, message).with_span(&module.key_span);
        return Err(error
            .with_hint("omit it, or evaluate the charts of the gear with `geardyn measure`")
            .into());
    }
    let mut errors = ErrorCollector::default();
    errors.record_units(&document);
    let span = SourceSpan::new(source.clone(), 0..0);
    let mut f = TableReader::new(&document.root, span, "the readings", &mut errors);
    let title = read_heading(&mut f);
    let span = f.span_of("measured_gear").clone();
    let readings = read_table(&mut f, "measured_gear", gear).flatten();
    f.require("measured_gear");
    f.finish();
    let mut errors = errors.errors;
    errors.extend(document.syntax_error);
    Errors::into_result(errors, || ())?;
    let unknown = || Error::new(Code::MissingKey, "no readings are given").with_span(&span);
    Ok(GearReadingsFile {
        title,
        readings: readings.ok_or_else(unknown)?,
        source: source.clone(),
        span,
    })
}

/// Standard uncertainties of the readings, m and rad.
#[derive(Debug, Default, Clone, Copy)]
struct Uncertainties {
    span: Option<f64>,
    diameter: Option<f64>,
    helix_angle: Option<f64>,
    centre_distance: Option<f64>,
}

fn uncertainties(f: &mut TableReader) -> Uncertainties {
    let length = |f: &mut TableReader, key: &str| {
        f.optional_quantity(key, QuantityKind::Length, ValueRange::Positive)
    };
    Uncertainties {
        span: length(f, "span"),
        diameter: length(f, "diameter"),
        helix_angle: f.optional_quantity("helix_angle", QuantityKind::Angle, ValueRange::Positive),
        centre_distance: length(f, "centre_distance"),
    }
}

/// The mate as it is written.
struct MateTable {
    teeth: u32,
    internal: bool,
    spans: Vec<(u32, f64)>,
    centre_distance: Option<f64>,
}

fn gear(f: &mut TableReader) -> Option<GearReadings> {
    let before = f.errors.errors.len();
    let teeth = teeth(f);
    let internal = f.flag("internal");
    let spans = spans(f, teeth);
    if !f.has("spans") {
        let place = f.span.clone();
        let hint = "write spans = [{ teeth = 4, size = \"27.590 mm\" }, …] over two numbers of teeth or more";
        let message = "[measured_gear] has neither `spans` nor a `module`";
        f.report(Code::MissingKey, message, &place, hint);
    }
    let tip = diameter(f, "tip_diameter");
    let root = diameter(f, "root_diameter");
    let acute = ValueRange::Open(0.0, 80f64.to_radians(), "above 0 and below 80 deg");
    let helix = f.optional_quantity("tip_helix_angle", QuantityKind::Angle, acute);
    let deviation =
        f.optional_quantity("thickness_deviation", QuantityKind::Length, ValueRange::Any);
    let unread = f.errors.errors.len();
    let std = read_table(f, "uncertainty", uncertainties).unwrap_or_default();
    // What is given and wrong is not missing too.
    let all_read = f.errors.errors.len() == unread;
    let mate = read_table(f, "mate", mate);
    let of = |f: &mut TableReader, name: &str, value: Option<f64>, std: Option<f64>, unit: &str| {
        if value.is_some() && std.is_none() && all_read {
            let hint = format!(
                "write uncertainty = {{ {name} = \"{unit}\" }}: its standard uncertainty, which ranks the candidates"
            );
            let message = format!("the standard uncertainty of `{name}` is not given");
            f.report_key(Code::MissingKey, "uncertainty", message, &hint);
        }
        let (value, std) = (value?, std?);
        Some(Reading { value, std })
    };
    let first = spans.first().map(|(_, size)| *size);
    let of_spans = of(f, "span", first, std.span, "3 µm");
    let of_diameters = of(f, "diameter", tip.or(root), std.diameter, "20 µm");
    let tip_helix = of(f, "helix_angle", helix, std.helix_angle, "0.1 deg");
    let distance = mate.as_ref().and_then(|mate| mate.centre_distance);
    let centre_distance = of(f, "centre_distance", distance, std.centre_distance, "20 µm");
    if f.errors.errors.len() > before {
        return None;
    }
    let std = of_spans?.std;
    let diameter = |value: Option<f64>| {
        let std = of_diameters?.std;
        value.map(|value| Reading { value, std })
    };
    let sized = |spans: Vec<(u32, f64)>| {
        let reading = |(k, value)| SpanReading {
            k,
            size: Reading { value, std },
        };
        spans.into_iter().map(reading).collect()
    };
    Some(GearReadings {
        teeth,
        internal,
        spans: sized(spans),
        tip_diameter: diameter(tip),
        root_diameter: diameter(root),
        tip_helix,
        thickness_deviation: deviation,
        mate: mate.map(|mate| MateReadings {
            teeth: mate.teeth,
            internal: mate.internal,
            spans: sized(mate.spans),
            centre_distance,
        }),
    })
}

fn teeth(f: &mut TableReader) -> u32 {
    let teeth = f.optional_count("teeth", 3, MAX_TEETH);
    f.require("teeth");
    teeth.unwrap_or(MAX_TEETH)
}

fn diameter(f: &mut TableReader, key: &str) -> Option<f64> {
    f.optional_quantity(key, QuantityKind::Length, ValueRange::Positive)
}

fn mate(f: &mut TableReader) -> MateTable {
    let teeth = teeth(f);
    MateTable {
        teeth,
        internal: f.flag("internal"),
        spans: spans(f, teeth),
        centre_distance: diameter(f, "centre_distance"),
    }
}

/// Spans as teeth spanned and size, m.
fn spans(f: &mut TableReader, teeth: u32) -> Vec<(u32, f64)> {
    let read = read_tables(f, "spans", |f| {
        let k = f.optional_count("teeth", 1, teeth.saturating_sub(1));
        f.require("teeth");
        let size = f.quantity("size", QuantityKind::Length, ValueRange::Positive);
        k.map(|k| (k, size))
    });
    read.into_iter().flatten().collect()
}
