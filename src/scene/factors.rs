//! `factors` of a load or a clutch: plain numbers over time that are multiplied.

use super::laws::LoadHistory;
use super::waveforms;
use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;
use crate::base::tables;

/// Which way a factor changes over time.
#[derive(Clone, Copy)]
enum FactorTag {
    Constant,
    Step,
    Ramp,
    Harmonic,
    Table,
}

const WORDS: &[(&str, FactorTag)] = &[
    ("constant", FactorTag::Constant),
    ("step", FactorTag::Step),
    ("ramp", FactorTag::Ramp),
    ("harmonic", FactorTag::Harmonic),
    ("table", FactorTag::Table),
];

/// All factors, one at least.
pub fn factors(f: &mut TableReader) -> Vec<LoadHistory> {
    let all = tables::read_tables(f, "factors", factor);
    f.require("factors");
    if f.has("factors") && all.is_empty() {
        let hint = "write factors = [{ kind = \"step\", time = \"0.5 s\" }, …]";
        f.report_key(Code::OutOfRange, "factors", "`factors` is empty", hint);
    }
    all
}

fn factor(f: &mut TableReader) -> LoadHistory {
    let word = f.choice("kind", WORDS).unwrap_or(FactorTag::Constant);
    let value = |f: &mut TableReader| f.optional_number("value", ValueRange::Any).unwrap_or(1.0);
    match word {
        FactorTag::Constant => LoadHistory::Constant(value(f)),
        FactorTag::Step => LoadHistory::Step {
            torque: value(f),
            time: f.quantity("time", QuantityKind::Time, ValueRange::Any),
        },
        FactorTag::Ramp => LoadHistory::Ramp {
            from: f.optional_number("from", ValueRange::Any).unwrap_or(0.0),
            to: value(f),
            between: read_interval(f, "between"),
        },
        FactorTag::Harmonic => LoadHistory::Harmonic {
            mean: f.optional_number("mean", ValueRange::Any).unwrap_or(0.0),
            amplitude: value(f),
            omega: f.quantity("frequency", QuantityKind::Frequency, ValueRange::Positive),
            phase: f
                .optional_quantity("phase", QuantityKind::Angle, ValueRange::Any)
                .unwrap_or(0.0),
        },
        FactorTag::Table => {
            let times = f.optional_quantities("times", QuantityKind::Time, ValueRange::Any, None);
            f.require("times");
            let values = waveforms::read_number_list(f, "values", ValueRange::Any);
            LoadHistory::Table(paired(f, ("times", times), ("values", values)))
        }
    }
}

/// Two instants, the second after the first.
pub fn read_interval(f: &mut TableReader, key: &str) -> [f64; 2] {
    let times = f.optional_quantities(key, QuantityKind::Time, ValueRange::Any, Some(2));
    f.require(key);
    let Some(&[start, end]) = times.as_deref() else {
        return [0.0, 1.0];
    };
    if end <= start {
        f.report_key(
            Code::OutOfRange,
            key,
            format!("`{key}` ends before it begins"),
            "give the beginning before the end",
        );
    }
    [start, end]
}

/// Points of a table by two lists of one length, the first rising.
pub fn points(
    f: &mut TableReader,
    (along, of): (&str, QuantityKind),
    (key, kind): (&str, QuantityKind),
) -> Vec<(f64, f64)> {
    let x = f.optional_quantities(along, of, ValueRange::Any, None);
    f.require(along);
    let y = f.optional_quantities(key, kind, ValueRange::Any, None);
    f.require(key);
    paired(f, (along, x), (key, y))
}

fn paired(
    f: &mut TableReader,
    (along, x): (&str, Option<Vec<f64>>),
    (key, y): (&str, Option<Vec<f64>>),
) -> Vec<(f64, f64)> {
    let (Some(x), Some(y)) = (x, y) else {
        return vec![(0.0, 0.0)];
    };
    if x.len() != y.len() || x.is_empty() {
        let message = format!("`{along}` has {} values and `{key}` {}", x.len(), y.len());
        f.report_key(
            Code::WrongType,
            key,
            message,
            "give the same number of both, at least one",
        );
    }
    if x.windows(2).any(|pair| pair[1] < pair[0]) {
        f.report_key(
            Code::OutOfRange,
            along,
            format!("`{along}` decreases"),
            "give the points in increasing order",
        );
    }
    x.into_iter().zip(y).collect()
}
