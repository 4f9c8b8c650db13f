//! Reads `[cut]` of a bevel-gear file: blades, generating roll, run-out of the cutter head, angle errors of the generator.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::SourceSpan;
use crate::base::table_reader::TableReader;
use crate::base::tables::{read_table, read_tables};
use crate::gear::cut::cutter_head::{BladeFeed, BladeOffset};

/// Cut by discrete blades as described in `[cut]`.
#[derive(Debug, Clone)]
pub struct CutStudy {
    /// Index of the member that is cut: 0 pinion, 1 gear; both by default.
    pub member: Option<usize>,
    /// Number of blades that cut a flank.
    pub blades: u32,
    /// Speed of the cutter, rad/s.
    pub cutter_speed: f64,
    /// Speed of the cradle, rad/s; `None` if no member is cut with a roll.
    pub cradle_speed: Option<f64>,
    /// Offsets of the blades; empty for an exact head.
    pub offsets: Vec<BladeOffset>,
    /// Angle errors of the drive chain of the generator.
    pub errors: Vec<ChainError>,
    /// Angle history of a spindle.
    pub history: Option<SpindleHistory>,
    /// Grid of the maps: rows along the height, columns along the face.
    pub grid: [usize; 2],
    /// Source span of the table.
    pub span: SourceSpan,
}

/// Rotating part of a generator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CutTarget {
    /// Cradle.
    Cradle,
    /// Work.
    Work,
    /// Cutter.
    Cutter,
}

/// Harmonic angle error of a rotating part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChainError {
    /// The part.
    pub target: CutTarget,
    /// Amplitude, rad.
    pub amplitude: f64,
    /// Cycles per revolution of the part.
    pub cycles: f64,
    /// Phase at cradle angle φ_c = 0, rad.
    pub phase: f64,
}

/// Angle of a spindle over time in a CSV file of `geardyn simulate`.
#[derive(Debug, Clone)]
pub struct SpindleHistory {
    /// Path of the file.
    pub path: PathBuf,
    /// Name of the column.
    pub column: String,
    /// Part whose angle the column holds.
    pub target: CutTarget,
    /// Source span of the table.
    pub span: SourceSpan,
}

impl CutTarget {
    /// Name of the part in a file.
    pub fn name(self) -> &'static str {
        match self {
            CutTarget::Cradle => "cradle",
            CutTarget::Work => "work",
            CutTarget::Cutter => "cutter",
        }
    }
}

impl CutStudy {
    /// Feed of a flank; the cradle does not turn if the member is cut without a roll.
    pub fn feed(&self, rolls: bool) -> BladeFeed {
        let cradle_speed = self.cradle_speed.filter(|_| rolls).unwrap_or(0.0);
        BladeFeed {
            blades: self.blades,
            cradle_per_turn: TAU * cradle_speed / self.cutter_speed,
        }
    }
}

const TARGETS: [(&str, CutTarget); 3] = [
    ("cradle", CutTarget::Cradle),
    ("work", CutTarget::Work),
    ("cutter", CutTarget::Cutter),
];
const RUN_OUT: ValueRange = ValueRange::Open(-1e-3, 1e-3, "within ±1 mm");
const AMPLITUDE: ValueRange = ValueRange::HalfOpen(0.0, 1e-2, "at least 0 and below 0.01 rad");
const CRADLE_SPEED: ValueRange = ValueRange::Open(-10.0, 10.0, "within ±10 rad/s");
const CYCLES: ValueRange = ValueRange::HalfOpen(0.0, 1e5, "at least 0 and below 100 000");
const PHASE: ValueRange = ValueRange::Open(-100.0, 100.0, "within ±100 rad");
/// Maximum rotation of the cradle from blade to blade, rad; larger steps leave no flank.
const MAX_STEP: f64 = 0.1;
/// Default grid: rows along the height, columns along the face.
const GRID: [u32; 2] = [61, 61];
/// Maximum number of rows or columns.
const MAX_NODES: u32 = 400;

/// Reads the table; `None` if a key is missing or invalid.
pub fn cut(f: &mut TableReader) -> Option<CutStudy> {
    let span = f.span.clone();
    let member = f.choice("member", &[("pinion", 0), ("gear", 1)]);
    let blades = f.optional_count("blades", 1, 1000);
    f.require("blades");
    let cutter_speed =
        f.optional_quantity("cutter_speed", QuantityKind::Speed, ValueRange::Positive);
    f.require("cutter_speed");
    let cradle_speed = f.optional_quantity("cradle_speed", QuantityKind::Speed, CRADLE_SPEED);
    let offsets = offsets(f, blades);
    let errors = read_tables(f, "error", chain_error);
    let history = read_table(f, "spindle_history", history).flatten();
    let rows = f.optional_count("rows", 3, MAX_NODES).unwrap_or(GRID[0]);
    let columns = f.optional_count("columns", 3, MAX_NODES).unwrap_or(GRID[1]);
    let study = CutStudy {
        member,
        blades: blades?,
        cutter_speed: cutter_speed?,
        cradle_speed,
        offsets: offsets?,
        errors: errors.into_iter().collect::<Option<_>>()?,
        history,
        grid: [rows, columns].map(|n| n as usize),
        span,
    };
    let step = study.feed(true).step();
    if cradle_speed.is_some() && !(step > 0.0 && step <= MAX_STEP) {
        let message = format!(
            "the cradle turns by {:.3}° from blade to blade (limits: above 0°, at most {:.1}°)",
            step.to_degrees(),
            MAX_STEP.to_degrees()
        );
        let hint = match step > 0.0 {
            true => "lower `cradle_speed`, or take more `blades` or a higher `cutter_speed`",
            false => {
                "give the speed of the cradle during cutting; without a roll omit `cradle_speed`"
            }
        };
        f.report_key(Code::OutOfRange, "cradle_speed", message, hint);
    }
    Some(study)
}

/// Offsets of the blades by their radial and axial run-out, m; `None` if a list is invalid.
fn offsets(f: &mut TableReader, blades: Option<u32>) -> Option<Vec<BladeOffset>> {
    let count = blades.map(|n| n as usize);
    let mut list = |key: &str| match f.has(key) {
        true => f.optional_quantities(key, QuantityKind::Length, RUN_OUT, count),
        false => {
            f.item(key, "a list of lengths, one for each blade");
            Some(Vec::new())
        }
    };
    let (radial, axial) = (list("radial_run_out"), list("axial_run_out"));
    let (radial, axial) = (radial?, axial?);
    let at = |list: &[f64], k: usize| list.get(k).copied().unwrap_or(0.0);
    let offset = |k: usize| BladeOffset {
        radial: at(&radial, k),
        axial: at(&axial, k),
    };
    Some((0..radial.len().max(axial.len())).map(offset).collect())
}

fn chain_error(f: &mut TableReader) -> Option<ChainError> {
    let target = f.choice("target", &TARGETS);
    f.require("target");
    let amplitude = f.optional_quantity("amplitude", QuantityKind::Angle, AMPLITUDE);
    f.require("amplitude");
    let cycles = f.optional_number("cycles", CYCLES);
    f.require("cycles");
    let phase = f.optional_quantity("phase", QuantityKind::Angle, PHASE);
    Some(ChainError {
        target: target?,
        amplitude: amplitude?,
        cycles: cycles?,
        phase: phase.unwrap_or(0.0),
    })
}

fn history(f: &mut TableReader) -> Option<SpindleHistory> {
    let folder = Path::new(&f.span.source().path).parent();
    let folder = folder.unwrap_or(Path::new("")).to_path_buf();
    let file = f.optional_text("file");
    f.require("file");
    let column = f.optional_text("column");
    f.require("column");
    let target = f.choice("target", &TARGETS);
    Some(SpindleHistory {
        path: folder.join(file?),
        column: column?.to_string(),
        target: target.unwrap_or(CutTarget::Work),
        span: f.span.clone(),
    })
}
