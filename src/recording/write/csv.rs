//! Comma-separated values: a line of names with their units in brackets, then a row for each sample or line.
//!
//! Numbers are the shortest decimals that read back to the same bits; a sample that is missing is a blank cell.

use std::io::{self, Write};

use super::{BLOCK, failed};
use crate::base::error::Error;
use crate::recording::responses::{FrequencyResponse, FrequencyResponses};
use crate::recording::signals::Recording;

/// Signals: time from the log's first sample, then a column for each channel; a gap is a step of the time.
///
/// # Errors
/// `output-failed`; those of reading a column.
pub fn signals(recording: &Recording, to: &mut impl Write) -> Result<(), Error> {
    let names = recording.channels.iter().map(|c| heading(&c.name, &c.unit));
    let head: Vec<String> = std::iter::once("time [s]".to_string())
        .chain(names)
        .collect();
    writeln!(to, "{}", head.join(",")).map_err(failed)?;
    let mut blocks = vec![vec![0.0; BLOCK]; recording.channels.len()];
    for (k, stretch) in recording.stretches.iter().enumerate() {
        let mut start = 0;
        while start < stretch.len() {
            let length = BLOCK.min(stretch.len() - start);
            for (channel, block) in recording.channels.iter().zip(&mut blocks) {
                let samples = &channel.samples;
                samples.read(stretch.start + start, &mut block[..length])?;
            }
            let mut rows = 0..length;
            rows.try_for_each(|row| {
                write!(to, "{:?}", recording.time_s(k, start + row))?;
                blocks.iter().try_for_each(|block| cell(to, block[row]))?;
                writeln!(to)
            })
            .map_err(failed)?;
            start += length;
        }
    }
    Ok(())
}

/// Frequency responses: frequency, then real and imaginary part of each and its coherence where there is one.
///
/// # Errors
/// `output-failed`.
pub fn responses<W: Write>(responses: &FrequencyResponses, to: &mut W) -> Result<(), Error> {
    let mut head = vec!["frequency [Hz]".to_string()];
    for function in &responses.functions {
        let (name, unit) = quotient(function);
        head.push(heading(&format!("Re {name}"), &unit));
        head.push(heading(&format!("Im {name}"), &unit));
        if function.coherence.is_some() {
            head.push(heading(&format!("coherence {name}"), ""));
        }
    }
    writeln!(to, "{}", head.join(",")).map_err(failed)?;
    let row = |to: &mut W, k: usize, frequency: f64| -> io::Result<()> {
        write!(to, "{frequency:?}")?;
        for function in &responses.functions {
            cell(to, function.value[k].re)?;
            cell(to, function.value[k].im)?;
            if let Some(coherence) = &function.coherence {
                cell(to, coherence[k])?;
            }
        }
        writeln!(to)
    };
    let mut lines = responses.frequency_hz.iter().enumerate();
    lines
        .try_for_each(|(k, &frequency)| row(to, k, frequency))
        .map_err(failed)
}

/// `output / input` and its unit.
fn quotient(function: &FrequencyResponse) -> (String, String) {
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
fn cell(to: &mut impl Write, value: f64) -> io::Result<()> {
    match value.is_finite() {
        true => write!(to, ",{value:?}"),
        false => write!(to, ","),
    }
}

/// `name [unit]`, quoted where it holds what would break the row.
fn heading(name: &str, unit: &str) -> String {
    let text = match unit {
        "" => name.to_string(),
        unit => format!("{name} [{unit}]"),
    };
    match text.contains([',', '"', '\n', '\r', ';', '\t']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text,
    }
}
