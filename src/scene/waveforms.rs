//! Waves over a period: rectangular, Fourier, tabulated.

use super::laws::Waveform;
use super::model::StiffnessVariation;
use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;
use crate::base::toml::Value;

/// The most terms or points of a wave.
const MAX_COUNT: usize = 100_000;

/// Which kind a wave is of.
#[derive(Clone, Copy)]
enum WaveformTag {
    Rectangular,
    Fourier,
    Table,
}

const WORDS: &[(&str, WaveformTag)] = &[
    ("rectangular", WaveformTag::Rectangular),
    ("fourier", WaveformTag::Fourier),
    ("table", WaveformTag::Table),
];

/// The stiffness over a mesh cycle, as factors of `k`.
pub fn read_stiffness_variation(f: &mut TableReader) -> Option<StiffnessVariation> {
    let word = f.choice("kind", WORDS);
    f.require("kind");
    let lead = f
        .optional_quantity("phase", QuantityKind::Angle, ValueRange::Any)
        .unwrap_or(0.0);
    let waveform = match word? {
        WaveformTag::Rectangular => {
            let factor = |f: &mut TableReader, key: &str| {
                let value = f.optional_number(key, ValueRange::NotNegative);
                f.require(key);
                value
            };
            let (high, low) = (factor(f, "high"), factor(f, "low"));
            let duty =
                f.optional_number("share", ValueRange::Open(0.0, 1.0, "above 0 and below 1"));
            f.require("share");
            Waveform::Rectangular {
                high: high?,
                low: low?,
                duty: duty?,
            }
        }
        WaveformTag::Fourier => {
            let mean = f
                .optional_number("mean", ValueRange::Positive)
                .unwrap_or(1.0);
            let amplitudes = read_number_list(f, "amplitudes", ValueRange::Any)?;
            let phases = f.optional_quantities(
                "phases",
                QuantityKind::Angle,
                ValueRange::Any,
                Some(amplitudes.len()),
            );
            let terms = fourier_terms(&amplitudes, phases);
            Waveform::Fourier { mean, terms }
        }
        WaveformTag::Table => {
            Waveform::Table(read_number_list(f, "values", ValueRange::NotNegative)?)
        }
    };
    if waveform.lower_bound() <= 0.0 {
        let key = match &waveform {
            Waveform::Rectangular { high, low, .. } if high < low => "high",
            Waveform::Rectangular { .. } => "low",
            Waveform::Fourier { .. } => "amplitudes",
            Waveform::Table(_) => "values",
        };
        let hint = "the mesh stiffness must be positive: keep every factor above zero, in a Fourier series the sum of amplitudes below the mean";
        let message = format!("`{key}` makes the wave zero or negative");
        f.report_key(Code::OutOfRange, key, message, hint);
        return None;
    }
    Some(StiffnessVariation {
        waveform,
        phase: lead,
    })
}

/// A list of bare numbers that must be there and not be empty.
pub fn read_number_list(f: &mut TableReader, key: &str, range: ValueRange) -> Option<Vec<f64>> {
    const TAKES: &str = "a list of numbers without units";
    f.require(key);
    let item = f.item(key, TAKES)?;
    let Value::List(list) = &item.value else {
        return f.wrong_type(key, item, TAKES);
    };
    if list.is_empty() || list.len() > MAX_COUNT {
        f.report_key(
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
pub fn fourier_terms(amplitudes: &[f64], phases: Option<Vec<f64>>) -> Vec<(u32, f64, f64)> {
    let phase = |at: usize| phases.as_ref().map_or(0.0, |p| p[at]);
    amplitudes
        .iter()
        .enumerate()
        .map(|(at, &a)| (at as u32 + 1, a, phase(at)))
        .collect()
}
