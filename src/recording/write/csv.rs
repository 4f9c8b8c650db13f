//! CSV output: a header of names and units, then a row per sample or spectral line.
//!
//! Numbers are the shortest decimals that read back to the same bits; a sample that is missing is a blank cell.

use std::io::{self, Write};

use super::{BUFFER_LEN, output_error};
use crate::base::error::Error;
use crate::recording::frequency_responses::{FrequencyResponse, FrequencyResponses};
use crate::recording::signals::Recording;

/// Signals: time from the log's first sample, then a column for each channel; a gap is a step of the time.
///
/// # Errors
/// `output-failed`; those of reading a column.
pub fn write_recording(recording: &Recording, to: &mut impl Write) -> Result<(), Error> {
    let names = recording
        .channels
        .iter()
        .map(|c| column_heading(&c.name, &c.unit));
    let head: Vec<String> = std::iter::once("time [s]".to_string())
        .chain(names)
        .collect();
    writeln!(to, "{}", head.join(",")).map_err(output_error)?;
    let mut blocks = vec![vec![0.0; BUFFER_LEN]; recording.channels.len()];
    for (k, segment) in recording.segments.iter().enumerate() {
        let mut start = 0;
        while start < segment.len() {
            let length = BUFFER_LEN.min(segment.len() - start);
            for (channel, block) in recording.channels.iter().zip(&mut blocks) {
                let samples = &channel.samples;
                samples.read(segment.start + start, &mut block[..length])?;
            }
            let mut rows = 0..length;
            rows.try_for_each(|row| {
                write!(to, "{:?}", recording.time_s(k, start + row))?;
                blocks
                    .iter()
                    .try_for_each(|block| write_cell(to, block[row]))?;
                writeln!(to)
            })
            .map_err(output_error)?;
            start += length;
        }
    }
    Ok(())
}

/// Frequency responses: frequency, then real and imaginary part of each and its coherence where there is one.
///
/// # Errors
/// `output-failed`.
pub fn write_responses<W: Write>(responses: &FrequencyResponses, to: &mut W) -> Result<(), Error> {
    let mut head = vec!["frequency [Hz]".to_string()];
    for function in &responses.responses {
        let (name, unit) = response_label(function);
        head.push(column_heading(&format!("Re {name}"), &unit));
        head.push(column_heading(&format!("Im {name}"), &unit));
        if function.coherence.is_some() {
            head.push(column_heading(&format!("coherence {name}"), ""));
        }
    }
    writeln!(to, "{}", head.join(",")).map_err(output_error)?;
    let row = |to: &mut W, k: usize, frequency: f64| -> io::Result<()> {
        write!(to, "{frequency:?}")?;
        for function in &responses.responses {
            write_cell(to, function.values[k].re)?;
            write_cell(to, function.values[k].im)?;
            if let Some(coherence) = &function.coherence {
                write_cell(to, coherence[k])?;
            }
        }
        writeln!(to)
    };
    let mut lines = responses.frequency_hz.iter().enumerate();
    lines
        .try_for_each(|(k, &frequency)| row(to, k, frequency))
        .map_err(output_error)
}

/// `output / input` and its unit.
fn response_label(function: &FrequencyResponse) -> (String, String) {
    let output = &function.output;
    match &function.input {
        None => (output.name.clone(), output.unit.clone()),
        Some(input) => {
            let unit = match (output.unit.as_str(), input.unit.as_str()) {
                (above, "") => above.to_string(),
                ("", below) => format!("1/({below})"),
                (above, below) if below.contains(['/', '·', '*']) => format!("{above}/({below})"),
                (above, below) => format!("{above}/{below}"),
            };
            (format!("{} / {}", output.name, input.name), unit)
        }
    }
}

/// A comma and a number; nothing after the comma where it is missing.
fn write_cell(to: &mut impl Write, value: f64) -> io::Result<()> {
    match value.is_finite() {
        true => write!(to, ",{value:?}"),
        false => write!(to, ","),
    }
}

/// `name [unit]`, quoted where it holds what would break the row.
fn column_heading(name: &str, unit: &str) -> String {
    let text = match unit {
        "" => name.to_string(),
        unit => format!("{name} [{unit}]"),
    };
    match text.contains([',', '"', '\n', '\r', ';', '\t']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text,
    }
}
