//! Waves over a period: rectangular, Fourier, tabulated.

use super::laws::Shape;
use super::model::StiffnessWave;
use crate::base::code::Code;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;
use crate::base::toml::Value;

/// The most terms or points of a wave.
const MOST: usize = 100_000;

/// Which kind a wave is of.
#[derive(Clone, Copy)]
enum Word {
    Rectangular,
    Fourier,
    Table,
}

const WORDS: &[(&str, Word)] = &[
    ("rectangular", Word::Rectangular),
    ("fourier", Word::Fourier),
    ("table", Word::Table),
];

/// The stiffness over a mesh cycle, as factors of `k`.
pub fn stiffness(f: &mut Fields) -> Option<StiffnessWave> {
    let word = f.choice("kind", WORDS);
    f.need("kind");
    let lead = f
        .optional_quantity("phase", Kind::Angle, Range::Any)
        .unwrap_or(0.0);
    let shape = match word? {
        Word::Rectangular => {
            let factor = |f: &mut Fields, key: &str| {
                let value = f.optional_number(key, Range::NotNegative);
                f.need(key);
                value
            };
            let (high, low) = (factor(f, "high"), factor(f, "low"));
            let duty = f.optional_number("share", Range::Between(0.0, 1.0, "above 0 and below 1"));
            f.need("share");
            Shape::Rectangular {
                high: high?,
                low: low?,
                duty: duty?,
            }
        }
        Word::Fourier => {
            let mean = f.optional_number("mean", Range::Positive).unwrap_or(1.0);
            let amplitudes = numbers(f, "amplitudes", Range::Any)?;
            let phases =
                f.optional_quantities("phases", Kind::Angle, Range::Any, Some(amplitudes.len()));
            let terms = with_phases(&amplitudes, phases);
            Shape::Fourier { mean, terms }
        }
        Word::Table => Shape::Table(numbers(f, "values", Range::NotNegative)?),
    };
    if shape.least() <= 0.0 {
        let key = match &shape {
            Shape::Rectangular { high, low, .. } if high < low => "high",
            Shape::Rectangular { .. } => "low",
            Shape::Fourier { .. } => "amplitudes",
            Shape::Table(_) => "values",
        };
        let hint = "below zero a spring pushes instead of pulling, and at zero nothing carries though teeth are in mesh: keep every factor above zero, of a Fourier series the amplitudes together below the mean";
        let message = format!("`{key}` lets the wave go down to zero or below");
        f.refuse_key(Code::OutOfRange, key, message, hint);
        return None;
    }
    Some(StiffnessWave { shape, lead })
}

/// A list of bare numbers that must be there and not be empty.
pub fn numbers(f: &mut Fields, key: &str, range: Range) -> Option<Vec<f64>> {
    const TAKES: &str = "a list of bare numbers";
    f.need(key);
    let item = f.item(key, TAKES)?;
    let Value::List(list) = &item.value else {
        return f.wrong_type(key, item, TAKES);
    };
    if list.is_empty() || list.len() > MOST {
        f.refuse_key(
            Code::OutOfRange,
            key,
            format!("`{key}` has {} values", list.len()),
            "give one to a hundred thousand",
        );
        return None;
    }
    let values: Vec<f64> = list
        .iter()
        .filter_map(|item| f.number_of(key, item, range))
        .collect();
    (values.len() == list.len()).then_some(values)
}

/// n, a, φ of amplitudes counted from one, with phases where these are given.
pub fn with_phases(amplitudes: &[f64], phases: Option<Vec<f64>>) -> Vec<(u32, f64, f64)> {
    let phase = |at: usize| phases.as_ref().map_or(0.0, |p| p[at]);
    amplitudes
        .iter()
        .enumerate()
        .map(|(at, &a)| (at as u32 + 1, a, phase(at)))
        .collect()
}
