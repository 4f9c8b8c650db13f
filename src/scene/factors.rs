//! `factors` of a load or a clutch: plain numbers over time that are multiplied.

use super::laws::History;
use super::{tables, waves};
use crate::base::code::Code;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;

/// Which way a factor changes over time.
#[derive(Clone, Copy)]
enum Word {
    Constant,
    Step,
    Ramp,
    Harmonic,
    Table,
}

const WORDS: &[(&str, Word)] = &[
    ("constant", Word::Constant),
    ("step", Word::Step),
    ("ramp", Word::Ramp),
    ("harmonic", Word::Harmonic),
    ("table", Word::Table),
];

/// All factors, one at least.
pub fn factors(f: &mut Fields) -> Vec<History> {
    let all = tables::each(f, "factors", factor);
    f.need("factors");
    if f.has("factors") && all.is_empty() {
        let hint = "write factors = [{ kind = \"step\", time = \"0.5 s\" }, …]";
        f.refuse_key(Code::OutOfRange, "factors", "`factors` lists nothing", hint);
    }
    all
}

fn factor(f: &mut Fields) -> History {
    let word = f.choice("kind", WORDS).unwrap_or(Word::Constant);
    let value = |f: &mut Fields| f.optional_number("value", Range::Any).unwrap_or(1.0);
    match word {
        Word::Constant => History::Constant(value(f)),
        Word::Step => History::Step {
            torque: value(f),
            time: f.quantity("time", Kind::Time, Range::Any),
        },
        Word::Ramp => History::Ramp {
            from: f.optional_number("from", Range::Any).unwrap_or(0.0),
            to: value(f),
            between: between(f, "between"),
        },
        Word::Harmonic => History::Harmonic {
            mean: f.optional_number("mean", Range::Any).unwrap_or(0.0),
            amplitude: value(f),
            omega: f.quantity("frequency", Kind::Frequency, Range::Positive),
            phase: f
                .optional_quantity("phase", Kind::Angle, Range::Any)
                .unwrap_or(0.0),
        },
        Word::Table => {
            let times = f.optional_quantities("times", Kind::Time, Range::Any, None);
            f.need("times");
            let values = waves::numbers(f, "values", Range::Any);
            History::Table(paired(f, ("times", times), ("values", values)))
        }
    }
}

/// Two instants, the second after the first.
pub fn between(f: &mut Fields, key: &str) -> [f64; 2] {
    let times = f.optional_quantities(key, Kind::Time, Range::Any, Some(2));
    f.need(key);
    let Some(&[start, end]) = times.as_deref() else {
        return [0.0, 1.0];
    };
    if end <= start {
        f.refuse_key(
            Code::OutOfRange,
            key,
            format!("`{key}` ends before it begins"),
            "give the begin and then the end",
        );
    }
    [start, end]
}

/// Points of a table by two lists of one length, the first rising.
pub fn points(
    f: &mut Fields,
    (along, of): (&str, Kind),
    (key, kind): (&str, Kind),
) -> Vec<(f64, f64)> {
    let x = f.optional_quantities(along, of, Range::Any, None);
    f.need(along);
    let y = f.optional_quantities(key, kind, Range::Any, None);
    f.need(key);
    paired(f, (along, x), (key, y))
}

fn paired(
    f: &mut Fields,
    (along, x): (&str, Option<Vec<f64>>),
    (key, y): (&str, Option<Vec<f64>>),
) -> Vec<(f64, f64)> {
    let (Some(x), Some(y)) = (x, y) else {
        return vec![(0.0, 0.0)];
    };
    if x.len() != y.len() || x.is_empty() {
        let message = format!("`{along}` has {} values and `{key}` {}", x.len(), y.len());
        f.refuse_key(
            Code::WrongType,
            key,
            message,
            "give as many of one as of the other, one at least",
        );
    }
    if x.windows(2).any(|pair| pair[1] < pair[0]) {
        f.refuse_key(
            Code::OutOfRange,
            along,
            format!("`{along}` runs backward"),
            "give the points in rising order",
        );
    }
    x.into_iter().zip(y).collect()
}
