//! Reads `[measured_gear]` and `[[chart]]` of a measured-gear file: gear data, required accuracy, charts.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::gear_file::{self, GearFile};
use super::shared_keys::{MAX_TEETH, read_profile_shift, read_thickness};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::{ErrorCollector, ValueRange};
use crate::base::flags::Flags;
use crate::base::load;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::TableReader;
use crate::base::tables::{read_heading, read_table, read_tables};
use crate::base::toml::{self, Value};
use crate::gear::cylindrical::involute::InvoluteGear;
use crate::gear::cylindrical::modification::{Modification, Relief};
use crate::gear::cylindrical::pair::Pair;
use crate::gear::measurement::accuracy_grades::AccuracyGrades;
use crate::gear::measurement::iso1328::Edition;
use crate::gear::measurement::pitch::PitchMethod;

/// Measured gear with its charts, as described in its file.
#[derive(Debug, Clone)]
pub struct MeasuredGear {
    /// Title in the file.
    pub title: String,
    /// Basic dimensions of the gear.
    pub gear: InvoluteGear,
    /// Face width, m.
    pub face_width: Option<f64>,
    /// Tip diameter, m.
    pub tip_diameter: Option<f64>,
    /// Total contact ratio with its mate.
    pub contact_ratio: Option<f64>,
    /// Short-wave component of the design itself, m.
    pub designed_short_wave: Option<f64>,
    /// Allowed normal thickness deviations, lower and upper, m.
    pub thickness: Option<[f64; 2]>,
    /// Required accuracy.
    pub requirement: Option<AccuracyRequirement>,
    /// Charts.
    pub charts: Vec<MeasuredChart>,
    /// Gear file that determines the gear; `None` if the keys describe it.
    pub gear_file: Option<Arc<SourceFile>>,
    /// Source file.
    pub source: Arc<SourceFile>,
}

/// Required accuracy of a gear.
#[derive(Debug, Clone)]
pub struct AccuracyRequirement {
    /// Edition of ISO 1328-1; `None` for JB 179-60, whose limits come from a table file.
    pub edition: Option<Edition>,
    /// Accuracy grades.
    pub accuracy: AccuracyGrades,
    /// Table file with the limits, relative to the folder of this file.
    pub table: Option<PathBuf>,
}

/// Chart or list of readings.
#[derive(Debug, Clone)]
pub struct MeasuredChart {
    /// Measured quantity, with the settings of its evaluation.
    pub kind: ChartKind,
    /// Log file of the chart, relative to the folder of this file.
    pub file: PathBuf,
    /// Names of the columns for neither flank, for the left flanks and for the right flanks.
    pub columns: [Vec<String>; 3],
    /// Unit of the columns if their names do not include it.
    pub unit: Option<String>,
    /// Standard uncertainty of one reading, m.
    pub std: Option<f64>,
    /// Source span of the table.
    pub span: SourceSpan,
}

/// Kind of measured chart.
#[derive(Debug, Clone)]
pub enum ChartKind {
    /// Pitch deviations, single and over `k` pitches.
    Pitch {
        /// Method of the readings.
        method: PitchMethod,
        /// Number of pitches for F_pk.
        k: Option<u32>,
    },
    /// Profile or helix traces.
    Trace(TraceSettings),
    /// Runout by a ball in every tooth space.
    Runout,
    /// Deviations of base pitches.
    BasePitch,
    /// Span measurements over `k` teeth.
    Span {
        /// Number of spanned teeth.
        k: Option<u32>,
    },
    /// Dimensions over balls or pins.
    Balls {
        /// Diameter of the ball or pin, m.
        diameter: f64,
    },
    /// Chordal tooth thicknesses at the reference cylinder.
    Chord,
    /// Constant-chord tooth thicknesses.
    ConstantChord,
    /// Centre distance in double-flank contact with a master gear.
    DoubleFlank,
    /// Transmission error in single-flank contact with a master gear.
    SingleFlank {
        /// Number of recorded revolutions.
        turns: u32,
        /// True for lengths along the line of action, false for the reference circle; `None` if angles were recorded.
        along_action: Option<bool>,
        /// Angle of the gear at which tooth 1 comes into contact, rad.
        first_contact: Option<f64>,
    },
}

/// Settings for the evaluation of traces.
#[derive(Debug, Clone)]
pub struct TraceSettings {
    /// True for a profile trace, false for a helix trace.
    pub is_profile: bool,
    /// Column of the position along the trace.
    pub along: String,
    /// Unit of that column if its name does not include it.
    pub along_unit: Option<String>,
    /// Evaluation range, m; the whole trace by default.
    pub evaluation: Option<[f64; 2]>,
    /// Range to which the mean line is extended for the slope deviation, m.
    pub active: Option<[f64; 2]>,
    /// Design modifications of the flank.
    pub design: Vec<Modification>,
    /// Position along the trace at which the evaluated relief begins, m.
    pub relief_from: Option<f64>,
    /// Filter that removes shorter wavelengths before the evaluation.
    pub filter: Option<TraceFilter>,
}

/// Gaussian filter of a trace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TraceFilter {
    /// Cut-off wavelength, m.
    Cutoff(f64),
    /// Cut-off at 1/30 of the evaluation range, at least 25 µm.
    OfRange,
}

/// Whether a TOML file describes a measured gear.
pub fn is_measured_gear(source: &Arc<SourceFile>) -> bool {
    toml::parse(source).root.get("measured_gear").is_some()
}

/// Reads a measured-gear file.
///
/// # Errors
/// All errors in the file.
pub fn read(source: &Arc<SourceFile>) -> Result<MeasuredGear, Errors> {
    let document = toml::parse(source);
    let mut collector = ErrorCollector::default();
    collector.record_units(&document);
    let span = SourceSpan::new(source.clone(), 0..0);
    let mut f = TableReader::new(&document.root, span, "the measured gear", &mut collector);
    let title = read_heading(&mut f);
    f.item(
        "truth",
        "the known answer of a simulated gear, which geardyn does not read",
    );
    let gear = read_table(&mut f, "measured_gear", gear);
    f.require("measured_gear");
    let gear_table = gear.as_ref().and_then(Option::as_ref);
    let flank = gear_table.map(|gear| gear.flank).unwrap_or_default();
    let charts = read_tables(&mut f, "chart", |f| chart(f, flank));
    if charts.is_empty() {
        let hint = "write [[chart]] with its kind, its file and its columns";
        f.report_key(Code::MissingKey, "chart", "nothing is measured", hint);
    }
    let charts: Vec<MeasuredChart> = charts.into_iter().flatten().collect();
    f.finish();
    let mut errors = collector.errors;
    errors.extend(document.syntax_error);
    let folder = Path::new(&source.path).parent().unwrap_or(Path::new(""));
    let Some(gear) = gear.flatten() else {
        let error = Error::new(Code::MissingKey, "the gear is not described")
            .with_span(&SourceSpan::new(source.clone(), 0..0));
        return Errors::into_result(errors, || ()).and(Err(error.into()));
    };
    Errors::into_result(errors, || MeasuredGear {
        title,
        source: source.clone(),
        charts: charts
            .into_iter()
            .map(|chart| MeasuredChart {
                file: folder.join(&chart.file),
                ..chart
            })
            .collect(),
        requirement: gear.requirement.map(|requirement| AccuracyRequirement {
            table: requirement.table.map(|table| folder.join(table)),
            ..requirement
        }),
        gear: gear.gear,
        face_width: gear.face_width,
        tip_diameter: gear.tip_diameter,
        contact_ratio: gear.contact_ratio,
        designed_short_wave: gear.designed_short_wave,
        thickness: gear.thickness,
        gear_file: gear.gear_file,
    })
}

/// Gear data for the evaluation of profile charts.
#[derive(Debug, Default, Clone, Copy)]
struct FlankData {
    internal: bool,
    /// Lengths of roll of the active profile from the gear file, m.
    active: Option<[f64; 2]>,
    /// Tip relief from the gear file.
    tip_relief: Option<Relief>,
}

/// Contents of `[measured_gear]`.
struct GearTable {
    gear: InvoluteGear,
    flank: FlankData,
    gear_file: Option<Arc<SourceFile>>,
    face_width: Option<f64>,
    tip_diameter: Option<f64>,
    contact_ratio: Option<f64>,
    designed_short_wave: Option<f64>,
    thickness: Option<[f64; 2]>,
    requirement: Option<AccuracyRequirement>,
}

/// Keys that a gear file determines.
const GEAR_FILE_KEYS: [&str; 9] = [
    "teeth",
    "internal",
    "module",
    "pressure_angle",
    "helix_angle",
    "profile_shift",
    "face_width",
    "tip_diameter",
    "contact_ratio",
];

fn gear(f: &mut TableReader) -> Option<GearTable> {
    let errors = f.errors.errors.len();
    f.accept_former("helix", "helix_angle");
    if f.has("gear") {
        let table = gear_of_file(f);
        let thickness = read_thickness(f);
        let designed_short_wave = short_wave(f);
        let requirement = read_requirement(f);
        return table
            .filter(|_| f.errors.errors.len() == errors)
            .map(|table| GearTable {
                thickness: thickness.or(table.thickness),
                designed_short_wave,
                requirement,
                ..table
            });
    }
    let teeth = f.optional_count("teeth", 3, MAX_TEETH);
    f.require("teeth");
    let module = f.quantity("module", QuantityKind::Length, ValueRange::Positive);
    let below_45_deg = ValueRange::Open(0.0, 45f64.to_radians(), "between 0 and 45 deg");
    let pressure_angle = f.optional_quantity("pressure_angle", QuantityKind::Angle, below_45_deg);
    let within_80_deg = ValueRange::Open(-80f64.to_radians(), 80f64.to_radians(), "within ±80 deg");
    let helix = f.optional_quantity("helix_angle", QuantityKind::Angle, within_80_deg);
    let internal = f.flag("internal");
    let shift = read_profile_shift(f);
    let mut positive =
        |key: &str| f.optional_quantity(key, QuantityKind::Length, ValueRange::Positive);
    let (face_width, tip_diameter) = (positive("face_width"), positive("tip_diameter"));
    let thickness = read_thickness(f);
    let contact_ratio = f.optional_number("contact_ratio", ValueRange::Positive);
    let designed_short_wave = short_wave(f);
    let requirement = read_requirement(f);
    if f.errors.errors.len() > errors {
        return None;
    }
    Some(GearTable {
        gear: InvoluteGear {
            teeth: teeth?,
            module,
            pressure_angle: pressure_angle.unwrap_or(20f64.to_radians()),
            helix: helix.unwrap_or(0.0),
            profile_shift: shift.unwrap_or(0.0),
            internal,
        },
        flank: FlankData {
            internal,
            ..FlankData::default()
        },
        gear_file: None,
        face_width,
        tip_diameter,
        contact_ratio,
        designed_short_wave,
        thickness,
        requirement,
    })
}

fn short_wave(f: &mut TableReader) -> Option<f64> {
    f.optional_quantity(
        "designed_short_wave",
        QuantityKind::Length,
        ValueRange::NotNegative,
    )
}

/// Reads a member of the gear file named in `gear`; keys determined by that file are errors.
fn gear_of_file(f: &mut TableReader) -> Option<GearTable> {
    let path = f.optional_text("gear")?;
    let members = [("pinion", 0), ("gear", 1)];
    let member = f.choice("member", &members);
    f.require("member");
    for key in GEAR_FILE_KEYS {
        if f.has(key) {
            f.item(key, "nothing");
            let message = format!("`{key}` is determined by the gear file {path}");
            let hint = format!("omit `{key}` or `gear`");
            f.report_key(Code::Conflict, key, message, &hint);
        }
    }
    let folder = Path::new(&f.span.source().path).parent();
    let path = folder.unwrap_or(Path::new("")).join(path);
    let span = f.span_of("gear").clone();
    let read = || -> Result<(GearFile, Pair), Errors> {
        let file = gear_file::read(&load::load(&path)?, &Flags::default())?;
        let pair = file.pair()?;
        Ok((file, pair))
    };
    let (file, pair) = match read() {
        Ok(read) => read,
        Err(errors) => {
            for error in errors.as_slice() {
                match error.span {
                    Some(_) => f.errors.push(error.clone()),
                    None => f.push(error.clone(), &span),
                }
            }
            return None;
        }
    };
    let (k, gear) = (member?, pair.members[member?]);
    let active = (pair.path_length() > 0.0).then(|| {
        let points = pair.path_points();
        let rolls = [points.a.roll[k], points.e.roll[k]];
        [rolls[0].min(rolls[1]), rolls[0].max(rolls[1])]
    });
    Some(GearTable {
        gear: gear.gear,
        flank: FlankData {
            internal: gear.gear.internal,
            active,
            tip_relief: file.modifications[k].tip_relief,
        },
        face_width: Some(gear.face_width),
        tip_diameter: Some(gear.tip_diameter()),
        contact_ratio: Some(pair.contact_ratios().total),
        designed_short_wave: None,
        thickness: Some(gear.thickness_deviation).filter(|d| d[0] < d[1]),
        requirement: None,
        gear_file: Some(file.source),
    })
}

fn read_requirement(f: &mut TableReader) -> Option<AccuracyRequirement> {
    let standards = [
        ("ISO 1328-1:1995", Some(Edition::Y1995)),
        ("ISO 1328-1:2013", Some(Edition::Y2013)),
        ("JB 179-60", None),
    ];
    let standard = f.choice("standard", &standards);
    let table = f.optional_text("limits").map(PathBuf::from);
    let item = f.item("accuracy", "a grade or a notation: 6, \"8-7-7 Dc\"")?;
    let read = match &item.value {
        Value::Integer(grade) => AccuracyGrades::parse(&grade.to_string()),
        Value::String(text) => AccuracyGrades::parse(text),
        _ => return f.wrong_type("accuracy", item, "a grade or a notation: 6, \"8-7-7 Dc\""),
    };
    let accuracy = match read {
        Ok(accuracy) => accuracy,
        Err(error) => {
            f.report_key(
                error.code,
                "accuracy",
                error.message,
                &error.hint.unwrap_or_default(),
            );
            return None;
        }
    };
    if !f.has("standard") {
        f.report_missing("standard", "of the required grade");
    }
    let edition = standard?;
    if edition.is_none() && table.is_none() {
        let hint = "its tables are not part of geardyn: write them into a table file (docs/reference/measured-gears.md) \
                    and name it in `limits`; omit `accuracy` for the values only";
        let message = "JB 179-60 needs a table of limits";
        f.report_key(Code::MissingKey, "standard", message, hint);
    }
    if edition.is_some() && table.is_some() {
        let message = "`limits` applies to JB 179-60 only; those of ISO 1328 are computed";
        f.report_key(
            Code::Conflict,
            "limits",
            message,
            "omit it, or write standard = \"JB 179-60\"",
        );
    }
    Some(AccuracyRequirement {
        edition,
        accuracy,
        table,
    })
}

#[derive(Clone, Copy)]
enum ChartTag {
    Pitch,
    Profile,
    Helix,
    Runout,
    BasePitch,
    Span,
    Balls,
    Chord,
    ConstantChord,
    DoubleFlank,
    SingleFlank,
}

fn chart(f: &mut TableReader, flank: FlankData) -> Option<MeasuredChart> {
    let errors = f.errors.errors.len();
    let words = [
        ("pitch", ChartTag::Pitch),
        ("profile", ChartTag::Profile),
        ("helix", ChartTag::Helix),
        ("runout", ChartTag::Runout),
        ("base_pitch", ChartTag::BasePitch),
        ("span", ChartTag::Span),
        ("balls", ChartTag::Balls),
        ("chord", ChartTag::Chord),
        ("constant_chord", ChartTag::ConstantChord),
        ("double_flank", ChartTag::DoubleFlank),
        ("single_flank", ChartTag::SingleFlank),
    ];
    let tag = f.choice("kind", &words);
    f.require("kind");
    let file = f.optional_text("file").map(PathBuf::from);
    f.require("file");
    let columns = ["column", "left", "right"].map(|key| column_names(f, key));
    if columns.iter().all(Vec::is_empty) {
        f.report_missing("column", ", nor `left` or `right`");
    }
    let unit = f.optional_text("unit").map(str::to_string);
    let std = f.optional_quantity("uncertainty", QuantityKind::Length, ValueRange::NotNegative);
    let kind = tag.map(|tag| read_kind(f, tag, flank));
    let span = f.span.clone();
    (f.errors.errors.len() == errors).then_some(())?;
    Some(MeasuredChart {
        kind: kind?,
        file: file?,
        columns,
        unit,
        std,
        span,
    })
}

/// Reads one column name or a list of them.
fn column_names(f: &mut TableReader, key: &str) -> Vec<String> {
    match f.item(key, "a column's name, or a list of them") {
        None => Vec::new(),
        Some(item) => match &item.value {
            Value::String(text) => vec![text.clone()],
            _ => f.texts(key),
        },
    }
}

fn read_kind(f: &mut TableReader, tag: ChartTag, flank: FlankData) -> ChartKind {
    match tag {
        ChartTag::Pitch => {
            let methods = [
                ("comparator", PitchMethod::Comparator),
                ("index", PitchMethod::Index),
            ];
            let method = f.choice("method", &methods);
            f.require("method");
            ChartKind::Pitch {
                method: method.unwrap_or(PitchMethod::Index),
                k: f.optional_count("k", 2, MAX_TEETH),
            }
        }
        ChartTag::Profile => ChartKind::Trace(trace(f, Some(flank))),
        ChartTag::Helix => ChartKind::Trace(trace(f, None)),
        ChartTag::Runout => ChartKind::Runout,
        ChartTag::BasePitch => ChartKind::BasePitch,
        ChartTag::Span => ChartKind::Span {
            k: f.optional_count("teeth", 1, MAX_TEETH),
        },
        ChartTag::Balls => ChartKind::Balls {
            diameter: f.quantity("diameter", QuantityKind::Length, ValueRange::Positive),
        },
        ChartTag::Chord => ChartKind::Chord,
        ChartTag::ConstantChord => ChartKind::ConstantChord,
        ChartTag::DoubleFlank => ChartKind::DoubleFlank,
        ChartTag::SingleFlank => ChartKind::SingleFlank {
            turns: f.optional_count("turns", 1, MAX_TEETH).unwrap_or(1),
            along_action: f.choice(
                "on",
                &[("line_of_action", true), ("reference_circle", false)],
            ),
            first_contact: f.optional_quantity(
                "first_contact",
                QuantityKind::Angle,
                ValueRange::Any,
            ),
        },
    }
}

/// Reads the settings of a profile trace (`profile` given) or a helix trace.
fn trace(f: &mut TableReader, profile: Option<FlankData>) -> TraceSettings {
    let flank = profile.unwrap_or_default();
    let (is_profile, internal) = (profile.is_some(), flank.internal);
    let along = f.optional_text("along").map(str::to_string);
    f.require("along");
    let along_unit = f.optional_text("along_unit").map(str::to_string);
    let mut range = |key: &str| -> Option<[f64; 2]> {
        let pair: [f64; 2] = f
            .optional_quantities(key, QuantityKind::Length, ValueRange::Any, Some(2))?
            .try_into()
            .ok()?;
        if pair[0] >= pair[1] {
            let message = format!("`{key}` does not increase");
            f.report_key(Code::OutOfRange, key, message, "give [from, to]");
        }
        Some(pair)
    };
    let evaluation = range("evaluation").or(flank.active);
    let active = range("active").or(flank.active);
    let mut design = Vec::new();
    let mut amount = |key: &str| -> Option<f64> {
        f.optional_quantity(key, QuantityKind::Length, ValueRange::NotNegative)
    };
    let (tip, crowning) = (amount("tip_relief"), amount("crowning"));
    let relief_from = f.optional_quantity("relief_from", QuantityKind::Length, ValueRange::Any);
    let file_relief = flank
        .tip_relief
        .filter(|_| tip.is_none() && relief_from.is_none());
    let tip = tip.or(file_relief.map(|relief| relief.amount));
    let relief_from = relief_from.or(file_relief.map(|relief| relief.from));
    let ends = active.or(evaluation);
    if let (Some(amount), Some([from, to])) = (crowning, ends) {
        design.push(Modification::Crowning { from, to, amount });
    }
    if let (Some(amount), Some(from), Some([low, high])) = (tip, relief_from, ends) {
        // The tip has the largest length of roll, of an internal gear the smallest.
        let to = if is_profile && internal { low } else { high };
        design.push(Modification::Relief { from, to, amount });
    }
    let lacks_range = (crowning.is_some() || tip.is_some()) && ends.is_none();
    if lacks_range {
        f.report_missing("active", ", between whose ends the design is stated");
    }
    if tip.is_some() && relief_from.is_none() {
        f.report_missing("relief_from", ", where the designed tip relief begins");
    }
    if let (Some(from), Some([low, high])) = (relief_from, ends)
        && !(low < from && from < high)
    {
        let message = "the relief begins outside the trace's range";
        f.report_key(
            Code::OutOfRange,
            "relief_from",
            message,
            "give a place between the ends of `active`",
        );
    }
    let is_of_range = f.has("filter")
        && f.span_of("filter").text().trim_matches(['"', '\'']) == "ISO 1328-1:2013";
    let filter = match is_of_range {
        true => {
            f.item("filter", "a length, or \"ISO 1328-1:2013\"");
            Some(TraceFilter::OfRange)
        }
        false => f
            .optional_quantity("filter", QuantityKind::Length, ValueRange::Positive)
            .map(TraceFilter::Cutoff),
    };
    TraceSettings {
        filter,
        is_profile,
        along: along.unwrap_or_default(),
        along_unit,
        evaluation,
        active,
        design,
        relief_from,
    }
}
