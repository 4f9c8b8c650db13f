//! Writer of UFF 58, text or binary (58b), double precision: the test geometry, then one data set per channel or response.
//!
//! The format limits a name to ten characters and the abscissa to 13 columns. Therefore the first header line holds the full name
//! and the fourth the rate with all digits; for frequency responses the fourth holds the averages and the window, the fifth the
//! usable band and the second the independent lines per line. This crate reads them back. Uniform lines are written as start and
//! increment if these reproduce the lines exactly, else value by value: exactly in binary, with seven digits in text.

use std::io::{self, Write};

use super::uff_geometry::{format_exponent, node_and_direction, write_geometry};
use super::{for_each_block, output_error};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::recording::frequency_responses::{ChannelLabel, FrequencyResponse, FrequencyResponses};
use crate::recording::geometry::Geometry;
use crate::recording::signals::{Channel, Recording};
use crate::recording::uff::codes;

/// Number format of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UffFormat {
    /// Text, 13 significant digits.
    Text,
    /// Binary, little-endian.
    Binary,
}

/// Decimals of an abscissa in 13 columns, and of a double in 20 columns.
const ABSCISSA_DIGITS: usize = 6;
const DOUBLE_DIGITS: usize = 12;

/// Length of an identification line, characters.
const ID_LINE_LEN: usize = 80;

/// Abscissa of a data set.
#[derive(Clone, Copy)]
enum AbscissaSpacing<'a> {
    /// Start and increment.
    Uniform(f64, f64),
    /// Value by value.
    Nonuniform(&'a [f64]),
}

/// Header of a data set.
struct DataSetHeader<'a> {
    ids: [&'a str; 5],
    function: usize,
    output: &'a ChannelLabel,
    input: Option<&'a ChannelLabel>,
    /// Node and direction of output and input.
    places: [(i32, i32); 2],
    is_complex: bool,
    count: usize,
    abscissa: AbscissaSpacing<'a>,
    abscissa_type: i64,
}

/// Writes a recording as time responses, with their points and directions.
///
/// # Errors
/// `conflict` if the recording has gaps, which a uniform abscissa cannot represent, or if a direction is not along an axis;
/// `output-failed`; errors of reading a column.
pub fn write_recording(
    recording: &Recording,
    geometry: &Geometry,
    format: UffFormat,
    to: &mut impl Write,
) -> Result<(), Error> {
    if recording.segments.len() > 1 {
        let message = format!(
            "the record has {} segments, and an even UFF 58 has no place for the gaps between them",
            recording.segments.len()
        );
        return Err(Error::new(Code::Conflict, message)
            .with_hint("bridge them: --fill-gaps; take a part: --after, --before; or write CSV"));
    }
    let is_too_long = |c: &&Channel| c.name.chars().count() > ID_LINE_LEN;
    if let Some(channel) = recording.channels.iter().find(is_too_long) {
        let message = format!(
            "UFF 58 allows {ID_LINE_LEN} characters for a name: {}",
            channel.name
        );
        return Err(Error::new(Code::Conflict, message)
            .with_hint("rename the channel in the sidecar, or write CSV"));
    }
    write_geometry(geometry, to).map_err(output_error)?;
    let date = recording.start.as_deref().unwrap_or_default();
    let (before, after) = codes::RATE_LINE;
    let rate = format!("{before}{:?}{after}", recording.rate_hz);
    for channel in &recording.channels {
        let output = ChannelLabel {
            name: channel.name.clone(),
            unit: channel.unit.clone(),
        };
        let head = DataSetHeader {
            ids: [&channel.name, "", date, &rate, ""],
            function: codes::TIME_RESPONSE,
            output: &output,
            input: None,
            places: [node_and_direction(geometry, &channel.name)?, (0, 0)],
            is_complex: false,
            count: recording.samples,
            abscissa: AbscissaSpacing::Uniform(recording.time_s(0, 0), recording.rate_hz.recip()),
            abscissa_type: codes::TIME,
        };
        head.write(format, to).map_err(output_error)?;
        let mut values = ValueWriter::new(format, to);
        for_each_block(channel, recording.samples, |block| {
            block
                .iter()
                .try_for_each(|&value| values.write_value(value))
        })?;
        values.end().map_err(output_error)?;
    }
    Ok(())
}

/// Writes frequency responses with their points and directions, each followed by its coherence, if any.
///
/// # Errors
/// `conflict` if a direction is not along an axis; `output-failed`.
pub fn write_responses(
    responses: &FrequencyResponses,
    geometry: &Geometry,
    format: UffFormat,
    to: &mut impl Write,
) -> Result<(), Error> {
    let lines = &responses.frequency_hz;
    let abscissa = uniform_abscissa(lines).unwrap_or(AbscissaSpacing::Nonuniform(lines));
    let pair_text = |pair: Option<(f64, f64)>, [before, between, after]: [&str; 3]| {
        pair.map_or(String::new(), |(a, b)| {
            format!("{before}{a:?}{between}{b:?}{after}")
        })
    };
    let averaging = responses.averages.map(|n| (n, responses.window_decay));
    let id_lines = [
        pair_text(averaging, codes::AVERAGES_LINE),
        pair_text(responses.usable_band_hz, codes::USABLE_LINE),
        pair_text(
            responses
                .independent_lines_per_line
                .map(|share| (share, 1.0)),
            codes::INDEPENDENCE_LINE,
        ),
    ];
    write_geometry(geometry, to).map_err(output_error)?;
    for function in &responses.responses {
        let input = function.input.as_ref().map_or("", |i| &i.name);
        let places = [&function.output.name, input].map(|name| node_and_direction(geometry, name));
        let [output, input] = places;
        let lines = (abscissa, &lines[..]);
        write_data_set(function, [output?, input?], lines, &id_lines, format, to)
            .map_err(output_error)?;
    }
    Ok(())
}

fn write_data_set(
    function: &FrequencyResponse,
    places: [(i32, i32); 2],
    (abscissa, lines): (AbscissaSpacing<'_>, &[f64]),
    id_lines: &[String; 3],
    format: UffFormat,
    to: &mut impl Write,
) -> io::Result<()> {
    let output = &function.output;
    let name = match &function.input {
        Some(input) => format!("{} / {}", output.name, input.name),
        None => output.name.clone(),
    };
    let head = DataSetHeader {
        ids: [&name, &id_lines[2], "", &id_lines[0], &id_lines[1]],
        function: codes::FREQUENCY_RESPONSE,
        output,
        input: function.input.as_ref(),
        places,
        is_complex: true,
        count: lines.len(),
        abscissa,
        abscissa_type: codes::FREQUENCY,
    };
    let is_nonuniform = matches!(abscissa, AbscissaSpacing::Nonuniform(_));
    head.write(format, to)?;
    let mut values = ValueWriter::new(format, to);
    for (line, value) in lines.iter().zip(&function.values) {
        if is_nonuniform {
            values.write_abscissa(*line)?;
        }
        values.write_value(value.re)?;
        values.write_value(value.im)?;
        values.end_value(is_nonuniform)?;
    }
    values.end()?;
    let Some(coherence) = &function.coherence else {
        return Ok(());
    };
    let unitless = |terminal: &ChannelLabel| ChannelLabel {
        name: terminal.name.clone(),
        unit: String::new(),
    };
    let (output, input) = (unitless(output), function.input.as_ref().map(unitless));
    let head = DataSetHeader {
        function: codes::COHERENCE,
        output: &output,
        input: input.as_ref(),
        is_complex: false,
        ..head
    };
    head.write(format, to)?;
    let mut values = ValueWriter::new(format, to);
    for (line, value) in lines.iter().zip(coherence) {
        if is_nonuniform {
            values.write_abscissa(*line)?;
        }
        values.write_value(*value)?;
        values.end_value(is_nonuniform)?;
    }
    values.end()
}

/// Start and increment of lines, if their values as written in the header reproduce the lines bit by bit.
fn uniform_abscissa(lines: &[f64]) -> Option<AbscissaSpacing<'static>> {
    let (&start, &last) = (lines.first()?, lines.last()?);
    let step = match lines.len() {
        1 => 1.0,
        n => (last - start) / (n - 1) as f64,
    };
    let written = |value: f64| format_exponent(value, ABSCISSA_DIGITS).parse::<f64>().ok();
    let (start, step) = (written(start)?, written(step)?);
    let mut numbered_lines = lines.iter().enumerate();
    let is_exact = numbered_lines.all(|(k, &line)| start + k as f64 * step == line);
    is_exact.then_some(AbscissaSpacing::Uniform(start, step))
}

impl DataSetHeader<'_> {
    /// Writes the opening delimiter, the number of the data set and the eleven lines of its header.
    fn write(&self, format: UffFormat, to: &mut impl Write) -> io::Result<()> {
        let is_uniform = matches!(self.abscissa, AbscissaSpacing::Uniform(..));
        let per_value = usize::from(!is_uniform) + 1 + usize::from(self.is_complex);
        writeln!(to, "    -1")?;
        match format {
            UffFormat::Text => writeln!(to, "    58")?,
            UffFormat::Binary => writeln!(
                to,
                "    58b{:6}{:6}{:12}{:12}{:6}{:6}{:12}{:12}",
                1,
                2,
                11,
                8 * per_value * self.count,
                0,
                0,
                0,
                0
            )?,
        }
        for id in self.ids {
            writeln!(to, "{}", field_text(id, ID_LINE_LEN))?;
        }
        let none = ChannelLabel::default();
        let input = self.input.unwrap_or(&none);
        writeln!(
            to,
            "{:5}{:10}{:5}{:10} {:10}{:10}{:4} {:10}{:10}{:4}",
            self.function,
            0,
            0,
            0,
            field_text(&self.output.name, 10),
            self.places[0].0,
            self.places[0].1,
            field_text(&input.name, 10),
            self.places[1].0,
            self.places[1].1
        )?;
        let (start, step) = match self.abscissa {
            AbscissaSpacing::Uniform(start, step) => (start, step),
            AbscissaSpacing::Nonuniform(lines) => (lines.first().copied().unwrap_or(0.0), 0.0),
        };
        writeln!(
            to,
            "{:10}{:10}{:10}{:>13}{:>13}{:>13}",
            if self.is_complex { 6 } else { 4 },
            self.count,
            u8::from(is_uniform),
            format_exponent(start, ABSCISSA_DIGITS),
            format_exponent(step, ABSCISSA_DIGITS),
            format_exponent(0.0, ABSCISSA_DIGITS)
        )?;
        let (label, unit) = match self.abscissa_type {
            codes::TIME => ("Time", "s"),
            _ => ("Frequency", "Hz"),
        };
        let data_type = |terminal: &ChannelLabel| codes::data_type(&terminal.unit);
        axis(to, self.abscissa_type, label, unit)?;
        axis(
            to,
            data_type(self.output),
            &self.output.name,
            &self.output.unit,
        )?;
        axis(to, data_type(input), &input.name, &input.unit)?;
        axis(to, 0, "", "")
    }
}

fn axis(to: &mut impl Write, data_type: i64, label: &str, unit: &str) -> io::Result<()> {
    let (label, unit) = (field_text(label, 20), field_text(unit, 20));
    writeln!(
        to,
        "{data_type:10}{:5}{:5}{:5} {label:20} {unit:20}",
        0, 0, 0
    )
}

/// Text without control characters, cut to its field; `NONE` if it is empty.
fn field_text(text: &str, width: usize) -> String {
    let line = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    match text.trim().is_empty() {
        true => "NONE".to_string(),
        false => line.take(width).collect(),
    }
}

/// Writer of the values of a data set, four to a row of text.
struct ValueWriter<'a, W: Write> {
    format: UffFormat,
    to: &'a mut W,
    in_row: usize,
}

impl<'a, W: Write> ValueWriter<'a, W> {
    fn new(format: UffFormat, to: &'a mut W) -> ValueWriter<'a, W> {
        ValueWriter {
            format,
            to,
            in_row: 0,
        }
    }

    fn write_value(&mut self, value: f64) -> io::Result<()> {
        match self.format {
            UffFormat::Binary => return self.to.write_all(&value.to_le_bytes()),
            UffFormat::Text => write!(self.to, "{:>20}", format_exponent(value, DOUBLE_DIGITS))?,
        }
        self.in_row += 1;
        match self.in_row {
            4 => self.end_row(),
            _ => Ok(()),
        }
    }

    fn write_abscissa(&mut self, value: f64) -> io::Result<()> {
        match self.format {
            UffFormat::Binary => self.to.write_all(&value.to_le_bytes()),
            UffFormat::Text => write!(self.to, "{:>13}", format_exponent(value, ABSCISSA_DIGITS)),
        }
    }

    /// Ends the row after a value of a nonuniform abscissa: one complex value or two real values per row.
    fn end_value(&mut self, is_nonuniform: bool) -> io::Result<()> {
        match self.format == UffFormat::Text && is_nonuniform && self.in_row == 2 {
            true => self.end_row(),
            false => Ok(()),
        }
    }

    fn end_row(&mut self) -> io::Result<()> {
        self.in_row = 0;
        writeln!(self.to)
    }

    /// Ends the last row and the data set.
    fn end(mut self) -> io::Result<()> {
        if self.in_row > 0 {
            self.end_row()?;
        }
        writeln!(self.to, "    -1")
    }
}
