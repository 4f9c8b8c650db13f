//! Face-mill loads: chips by their greatest size, or the passes that `geardyn gear cut --chips` writes.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::csv_table::CsvTable;
use super::factors::read_interval;
use super::laws::{BladeSample, FaceMill, MillChips, StatedChips};
use super::named_gear_file::NamedFile;
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::TableReader;

/// Keys that state chips, which a file of passes replaces.
const STATED: [&str; 6] = [
    "blade_groups",
    "arc",
    "chip_width",
    "chip_thickness",
    "runout",
    "roll",
];

/// Reads one.
pub fn read(f: &mut TableReader) -> FaceMill {
    let forward = f.choice("sense", &[("forward", 1.0), ("backward", -1.0)]);
    f.require("sense");
    FaceMill {
        chips: match f.has("chips") {
            true => passes(f),
            false => {
                f.item("chips", "the name of a file of `geardyn gear cut --chips`");
                MillChips::Stated(stated(f))
            }
        },
        radius: f.quantity("radius", QuantityKind::Length, ValueRange::Positive),
        specific_force: f.quantity(
            "specific_force",
            QuantityKind::Pressure,
            ValueRange::Positive,
        ),
        exponent: f
            .optional_number(
                "exponent",
                ValueRange::HalfOpen(0.0, 1.0, "at least 0 and below 1"),
            )
            .unwrap_or(0.25),
        sense: forward.unwrap_or(1.0),
        slot: f.optional_quantity("slot", QuantityKind::Angle, ValueRange::Any),
        radial: f
            .optional_number("radial_share", ValueRange::Any)
            .unwrap_or(0.0),
        axial: f
            .optional_number("axial_share", ValueRange::Any)
            .unwrap_or(0.0),
    }
}

fn stated(f: &mut TableReader) -> StatedChips {
    let blades = f.optional_count("blade_groups", 1, 1000);
    f.require("blade_groups");
    StatedChips {
        blades: blades.unwrap_or(1),
        arc: f.quantity(
            "arc",
            QuantityKind::Angle,
            ValueRange::Open(0.0, TAU, "above 0° and below 360°"),
        ),
        width: f.quantity("chip_width", QuantityKind::Length, ValueRange::Positive),
        chip: f.quantity("chip_thickness", QuantityKind::Length, ValueRange::Positive),
        runout: f
            .optional_quantity("runout", QuantityKind::Length, ValueRange::NotNegative)
            .unwrap_or(0.0),
        roll: read_interval(f, "roll"),
    }
}

fn passes(f: &mut TableReader) -> MillChips {
    for key in STATED {
        if f.item(key, "what `chips` replaces").is_some() {
            let message = format!("`{key}` and `chips` exclude each other");
            let hint = "the file of `chips` has the passes of all blades: omit the key";
            f.report_key(Code::Conflict, key, message, hint);
        }
    }
    let start = f.optional_quantity("start", QuantityKind::Time, ValueRange::Any);
    let file = NamedFile::read(f, "chips");
    let read = file.as_ref().map(|file| read_passes(&file.source));
    let passes = match read {
        Some(Ok(passes)) => passes,
        Some(Err(errors)) => {
            for error in errors.as_slice() {
                f.errors.push(error.clone());
            }
            Vec::new()
        }
        None => Vec::new(),
    };
    MillChips::Passes {
        start: start.unwrap_or(0.0),
        passes,
        source: file.map(|file| file.source),
    }
}

const WRITTEN_BY: &str = "create the file by `geardyn gear cut FILE --chips CHIPS.csv`";

/// Relative difference of steps that printed digits leave.
const UNEVEN: f64 = 1e-4;

/// Places of a file, pass by pass.
fn read_passes(source: &Arc<SourceFile>) -> Result<Vec<Vec<BladeSample>>, Errors> {
    let names = [
        ("head", Some(QuantityKind::Angle)),
        ("slot", Some(QuantityKind::Angle)),
        ("edge", Some(QuantityKind::Length)),
        ("thickness", Some(QuantityKind::Length)),
        ("pass", None),
    ];
    let table = CsvTable::parse(source.clone(), &names)?;
    let numbers = &table.columns[4];
    let wrong = |row: usize, what: &str| {
        let error = Error::new(Code::OutOfRange, format!("row {}: {what}", row + 1));
        let error = error.with_hint(WRITTEN_BY);
        Err(table.locate(error).into())
    };
    let mut passes: Vec<Vec<BladeSample>> = Vec::new();
    for (i, pass) in numbers.iter().enumerate() {
        let [head, angle, edge, thickness] = [0, 1, 2, 3].map(|k| table.columns[k][i]);
        for (name, value) in [("edge", edge), ("thickness", thickness)] {
            if !(value >= 0.0) {
                return wrong(
                    i,
                    &format!("{name} is {} mm (must not be negative)", 1e3 * value),
                );
            }
        }
        let place = BladeSample {
            head,
            angle,
            edge,
            thickness,
        };
        match passes.last_mut() {
            Some(last) if i > 0 && numbers[i - 1] == *pass => {
                let steps = (
                    last.last().map(|p| head - p.head),
                    last.get(1).map(|p| p.head - last[0].head),
                );
                match steps {
                    (Some(step), _) if !(step > 0.0) => {
                        return wrong(i, "the head angle does not increase within the pass");
                    }
                    (Some(step), Some(first)) if (step / first - 1.0).abs() > UNEVEN => {
                        return wrong(
                            i,
                            "the head angle does not increase in equal steps within the pass",
                        );
                    }
                    _ => last.push(place),
                }
            }
            Some(last) if last.len() < 2 => {
                return wrong(i - 1, "the pass has only one point, hence no length");
            }
            last => {
                if last.is_some() && !(*pass > numbers[i - 1]) {
                    return wrong(i, "the number of the pass does not increase");
                }
                passes.push(vec![place]);
            }
        }
    }
    match passes.last() {
        Some(last) if last.len() >= 2 => Ok(passes),
        _ => {
            let error = Error::new(Code::OutOfRange, "the last pass has fewer than two points");
            Err(error
                .with_span(&SourceSpan::new(source.clone(), 0..0))
                .with_hint(WRITTEN_BY)
                .into())
        }
    }
}
