//! Reads a wanted ease-off: `[ease_off]` with crownings, twist and a parabola of the transmission error, `[pattern]` with its place.

use std::sync::Arc;

use crate::base::code::Code;
use crate::base::error::Errors;
use crate::base::error_collector::{ErrorCollector, ValueRange};
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::TableReader;
use crate::base::tables::{read_heading, read_table};
use crate::base::toml;
use crate::gear::cut::target::EaseOffTarget;

/// A wanted ease-off as its file describes it.
#[derive(Debug, Clone)]
pub struct EaseOffTargetFile {
    /// Title in the file.
    pub title: String,
    /// The wanted ease-off.
    pub target: EaseOffTarget,
    /// Place of `[ease_off]`.
    pub span: SourceSpan,
    /// The file.
    pub source: Arc<SourceFile>,
}

/// Gaps of an ease-off.
const GAP: ValueRange = ValueRange::Open(-1e-3, 1e-3, "within ±1 mm");
/// Transmission error half a pitch from the pattern.
const PARABOLA: ValueRange = ValueRange::Open(
    -0.01,
    1e-12,
    "from −2000 arcsec to 0, below zero where the gear lags",
);
/// Shares of face and height.
const PLACE: ValueRange = ValueRange::Open(0.05, 0.95, "above 0.05 and below 0.95");

/// Reads one.
///
/// # Errors
/// Everything wrong in it.
pub fn read(source: &Arc<SourceFile>) -> Result<EaseOffTargetFile, Errors> {
    let document = toml::parse(source);
    let mut errors = ErrorCollector::default();
    errors.record_units(&document);
    let span = SourceSpan::new(source.clone(), 0..0);
    let mut f = TableReader::new(&document.root, span, "the target", &mut errors);
    let title = read_heading(&mut f);
    let span = f.span_of("ease_off").clone();
    let gaps = read_table(&mut f, "ease_off", ease_off);
    f.require("ease_off");
    let place = read_table(&mut f, "pattern", pattern);
    f.finish();
    let mut errors = errors.errors;
    errors.extend(document.syntax_error);
    Errors::into_result(errors, || EaseOffTargetFile {
        title,
        target: EaseOffTarget {
            place: place.unwrap_or(MIDDLE),
            ..gaps.unwrap_or(NOTHING)
        },
        source: source.clone(),
        span,
    })
}

/// Middle of the flank.
const MIDDLE: [f64; 2] = [0.5, 0.5];
/// The conjugate flank.
const NOTHING: EaseOffTarget = EaseOffTarget {
    place: MIDDLE,
    lengthwise_crowning: 0.0,
    profile_crowning: 0.0,
    twist: 0.0,
    te_parabola: 0.0,
};

fn ease_off(f: &mut TableReader) -> EaseOffTarget {
    let keys = [
        "lengthwise_crowning",
        "profile_crowning",
        "twist",
        "te_parabola",
    ];
    if !keys.iter().any(|key| f.has(key)) {
        let span = f.span.clone();
        let hint = "give at least one; 0 for the flank that is conjugate to the gear";
        f.report(
            Code::MissingKey,
            format!("{} has none of {}", f.title, keys.join(", ")),
            &span,
            hint,
        );
    }
    let mut gap = |key| f.optional_quantity(key, QuantityKind::Length, GAP);
    let lengthwise_crowning = gap("lengthwise_crowning").unwrap_or(0.0);
    let profile_crowning = gap("profile_crowning").unwrap_or(0.0);
    let twist = gap("twist").unwrap_or(0.0);
    let te_parabola = f.optional_quantity("te_parabola", QuantityKind::Angle, PARABOLA);
    EaseOffTarget {
        lengthwise_crowning,
        profile_crowning,
        twist,
        te_parabola: te_parabola.unwrap_or(0.0),
        ..NOTHING
    }
}

fn pattern(f: &mut TableReader) -> [f64; 2] {
    let mut share = |key, middle: f64| f.optional_number(key, PLACE).unwrap_or(middle);
    [share("face", MIDDLE[0]), share("height", MIDDLE[1])]
}
