//! Frequency tables: real/imaginary, magnitude/phase or complex columns, converted to FRFs.

use std::f64::consts::PI;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::recording::channel_names;
use crate::recording::frequency_responses::{ChannelLabel, FrequencyResponse, FrequencyResponses};
use crate::recording::raw::RawChannel;
use crate::recording::sample_column::SampleColumn;

/// Part of a frequency response that a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ComplexPart {
    Real,
    Imaginary,
    Magnitude,
    Phase,
    Coherence,
}

/// Words in column names that denote a part, in lower case.
const PART_WORDS: &[(&str, ComplexPart)] = &[
    ("imaginary", ComplexPart::Imaginary),
    ("imag", ComplexPart::Imaginary),
    ("im", ComplexPart::Imaginary),
    ("real", ComplexPart::Real),
    ("re", ComplexPart::Real),
    ("magnitude", ComplexPart::Magnitude),
    ("mag", ComplexPart::Magnitude),
    ("amplitude", ComplexPart::Magnitude),
    ("ampl", ComplexPart::Magnitude),
    ("amp", ComplexPart::Magnitude),
    ("abs", ComplexPart::Magnitude),
    ("betrag", ComplexPart::Magnitude),
    ("幅值", ComplexPart::Magnitude),
    ("phase", ComplexPart::Phase),
    ("phi", ComplexPart::Phase),
    ("angle", ComplexPart::Phase),
    ("arg", ComplexPart::Phase),
    ("相位", ComplexPart::Phase),
    ("coherence", ComplexPart::Coherence),
    ("coh", ComplexPart::Coherence),
    ("kohärenz", ComplexPart::Coherence),
    ("相干", ComplexPart::Coherence),
];

/// Name without the word for the part, and the part: `H1_re` → `H1`, `Re(H1)` → `H1`.
fn split_part(name: &str) -> Option<(String, ComplexPart)> {
    let separators = |c: char| !c.is_alphanumeric();
    let mut words: Vec<&str> = name.split(separators).filter(|w| !w.is_empty()).collect();
    let part_of = |word: &str| {
        let word = word.to_lowercase();
        PART_WORDS
            .iter()
            .find(|(entry, _)| *entry == word)
            .map(|(_, part)| *part)
    };
    let at = words.iter().rposition(|word| part_of(word).is_some())?;
    let part = part_of(words.remove(at))?;
    // `Phase_deg`, `phase rad`: the unit is not part of the name.
    words.retain(|w| {
        !(part == ComplexPart::Phase && ["deg", "rad"].contains(&w.to_lowercase().as_str()))
    });
    words.retain(|w| !(part == ComplexPart::Magnitude && w.eq_ignore_ascii_case("db")));
    Some((words.join("_"), part))
}

/// Whether a column name denotes a part of a frequency response.
pub fn is_part(name: &str) -> bool {
    split_part(name).is_some()
}

/// One column of the table.
struct TableColumn {
    base: String,
    part: ComplexPart,
    unit: String,
    values: Vec<f64>,
    name: String,
}

fn values(column: &SampleColumn) -> Result<Vec<f64>, Error> {
    let mut values = vec![0.0; column.len()];
    column.read(0, &mut values)?;
    Ok(values)
}

/// Frequency responses of a table whose first column holds the frequencies.
///
/// # Errors
/// An unpaired column, frequencies that do not increase, a cell without a number.
pub fn responses(path: &str, channels: &[RawChannel]) -> Result<FrequencyResponses, Error> {
    let Some((first, rest)) = channels.split_first() else {
        return Err(Error::new(
            Code::EmptyLog,
            format!("{path} contains no columns"),
        ));
    };
    let scale = match first.unit.trim().to_lowercase().as_str() {
        "khz" => 1e3,
        "rad/s" => 0.5 / PI,
        _ => 1.0,
    };
    let frequency_hz: Vec<f64> = values(&first.samples)?.iter().map(|f| f * scale).collect();
    if let Some(at) = frequency_hz
        .windows(2)
        .position(|w| w[1].partial_cmp(&w[0]) != Some(std::cmp::Ordering::Greater))
    {
        let (here, next) = (frequency_hz[at], frequency_hz[at + 1]);
        return Err(Error::new(
            Code::CorruptFile,
            format!("frequency {next} Hz of {path} follows {here} Hz: the lines of a table rise"),
        )
        .with_hint("sort the table, or state which column is the time: --time COLUMN"));
    }
    let mut entries = Vec::new();
    for channel in rest {
        let Some((base, part)) = split_part(&channel.name) else {
            return Err(unpaired_column(path, &channel.name));
        };
        let values = values(&channel.samples)?;
        if let Some(line) = values.iter().position(|x| !x.is_finite()) {
            let hz = frequency_hz.get(line).copied().unwrap_or(f64::NAN);
            return Err(Error::new(
                Code::NotANumber,
                format!("`{}` has no number at {hz} Hz", channel.name),
            )
            .with_hint("remove or correct that line of the file"));
        }
        entries.push(TableColumn {
            base,
            part,
            unit: channel.unit.clone(),
            values,
            name: channel.name.clone(),
        });
    }
    let functions = pair(path, entries)?;
    if functions.is_empty() {
        return Err(unpaired_column(path, &first.name));
    }
    Ok(FrequencyResponses {
        frequency_hz,
        responses: functions,
        averages: None,
        window_decay: 0.0,
        usable_band_hz: None,
        independent_lines_per_line: None,
    })
}

fn unpaired_column(path: &str, name: &str) -> Error {
    Error::new(
        Code::UnknownFormat,
        format!("{path} is a table over frequency, and `{name}` has no partner: real goes with imaginary, magnitude with phase"),
    )
    .with_hint("name the columns such as `H1_re`, `H1_im`, or state which column is the time: --time COLUMN")
}

/// Pairs columns of parts to frequency responses: each with the first remaining counterpart of the same base name.
fn pair(path: &str, mut entries: Vec<TableColumn>) -> Result<Vec<FrequencyResponse>, Error> {
    let mut functions: Vec<(String, FrequencyResponse)> = Vec::new();
    while !entries.is_empty() {
        let entry = entries.remove(0);
        if entry.part == ComplexPart::Coherence {
            let is_match = |(base, f): &&mut (String, FrequencyResponse)| {
                *base == entry.base && f.coherence.is_none()
            };
            match functions.iter_mut().find(is_match) {
                Some((_, function)) => function.coherence = Some(entry.values),
                None => match functions.last_mut() {
                    Some((_, function))
                        if entry.base.is_empty() && function.coherence.is_none() =>
                    {
                        function.coherence = Some(entry.values);
                    }
                    _ => return Err(unpaired_column(path, &entry.name)),
                },
            }
            continue;
        }
        let partner = match entry.part {
            ComplexPart::Real => ComplexPart::Imaginary,
            ComplexPart::Imaginary => ComplexPart::Real,
            ComplexPart::Magnitude => ComplexPart::Phase,
            _ => ComplexPart::Magnitude,
        };
        let is_match = |mate: &TableColumn| mate.part == partner && mate.base == entry.base;
        let Some(at) = entries.iter().position(is_match) else {
            return Err(unpaired_column(path, &entry.name));
        };
        let mate = entries.remove(at);
        let is_second = matches!(entry.part, ComplexPart::Imaginary | ComplexPart::Phase);
        let (first, second) = if is_second {
            (&mate, &entry)
        } else {
            (&entry, &mate)
        };
        let value = match first.part {
            ComplexPart::Real => first
                .values
                .iter()
                .zip(&second.values)
                .map(|(re, im)| Complex::new(*re, *im))
                .collect(),
            _ => polar(first, second),
        };
        let name = if first.base.is_empty() {
            match functions.len() {
                0 => "H".to_string(),
                n => format!("H {}", n + 1),
            }
        } else {
            channel_names::split_unit(&first.base).0
        };
        let unit = if first.unit.eq_ignore_ascii_case("db") {
            String::new()
        } else {
            first.unit.clone()
        };
        functions.push((
            first.base.clone(),
            FrequencyResponse {
                output: ChannelLabel { name, unit },
                values: value,
                ..FrequencyResponse::default()
            },
        ));
    }
    Ok(functions
        .into_iter()
        .map(|(_, function)| function)
        .collect())
}

/// `|H| e^{iφ}`; `|H| = 10^(dB/20)`. Phases are in degrees if the column states so, or states no unit and exceeds ±π.
fn polar(magnitude: &TableColumn, phase: &TableColumn) -> Vec<Complex> {
    let states = |word: &str| {
        phase.unit.to_lowercase().contains(word) || phase.name.to_lowercase().contains(word)
    };
    let largest = phase.values.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    // Rounded values may exceed ±π in the last digit.
    let is_degrees = states("deg") || phase.unit == "°" || (!states("rad") && largest > 1.01 * PI);
    let is_decibel =
        magnitude.unit.eq_ignore_ascii_case("db") || magnitude.name.to_lowercase().ends_with("db");
    magnitude
        .values
        .iter()
        .zip(&phase.values)
        .map(|(&m, &p)| {
            let m = if is_decibel { 10_f64.powf(m / 20.0) } else { m };
            let p = if is_degrees { p.to_radians() } else { p };
            Complex::new(m * p.cos(), m * p.sin())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Column names as in exports.
    #[test]
    fn exact_parts_of_names() {
        let cases = [
            ("H1_re", "H1", ComplexPart::Real),
            ("Re(H1)", "H1", ComplexPart::Real),
            ("H1 imag", "H1", ComplexPart::Imaginary),
            ("Phase", "", ComplexPart::Phase),
            ("H2_phase_deg", "H2", ComplexPart::Phase),
            ("|H| mag", "H", ComplexPart::Magnitude),
            ("coherence_3", "3", ComplexPart::Coherence),
        ];
        for (name, base, part) in cases {
            assert_eq!(split_part(name), Some((base.to_string(), part)), "{name}");
        }
        assert_eq!(split_part("pressure"), None);
    }
}
