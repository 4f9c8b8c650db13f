//! UFF 58 output, text or binary (58b), double precision: a data set per channel or response, after the geometry of the test.
//!
//! The format gives ten characters to a name and 13 columns to the abscissa. Whole names stand in the first line of the
//! header, the rate with all its digits in the fourth, and what lies behind frequency responses (averages, window, the band worth
//! fitting) in the second, fourth and fifth; this crate reads all of them again. Uniform lines are written as start and
//! increment where those give the same lines back, else one by one: in bytes exactly, in text with seven digits.

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
    /// As text, 13 digits.
    Text,
    /// As bytes.
    Binary,
}

/// Digits after the point of an abscissa in 13 columns, and of a double in 20.
const ABSCISSA_DIGITS: usize = 6;
const DOUBLE_DIGITS: usize = 12;

/// Characters of a line for people.
const ID_LINE_LEN: usize = 80;

/// The abscissa of a set.
#[derive(Clone, Copy)]
enum AbscissaSpacing<'a> {
    /// Start and increment.
    Even(f64, f64),
    /// Value by value.
    Uneven(&'a [f64]),
}

/// The head of a set.
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

/// Signals as time responses, with their points and directions.
///
/// # Errors
/// `conflict` where the record has gaps, for which an even abscissa has no place, or where a direction is along no axis;
/// `output-failed`; those of reading a column.
pub fn write_recording(
    recording: &Recording,
    geometry: &Geometry,
    form: UffFormat,
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
    let long = |c: &&Channel| c.name.chars().count() > ID_LINE_LEN;
    if let Some(channel) = recording.channels.iter().find(long) {
        let message = format!(
            "UFF 58 gives {ID_LINE_LEN} characters to a name: {}",
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
            abscissa: AbscissaSpacing::Even(recording.time_s(0, 0), recording.rate_hz.recip()),
            abscissa_type: codes::TIME,
        };
        head.write(form, to).map_err(output_error)?;
        let mut values = ValueWriter::new(form, to);
        for_each_block(channel, recording.samples, |block| {
            block
                .iter()
                .try_for_each(|&value| values.write_value(value))
        })?;
        values.end().map_err(output_error)?;
    }
    Ok(())
}

/// Frequency responses with their points and directions, each followed by its coherence where there is one.
///
/// # Errors
/// `conflict` where a direction is along no axis; `output-failed`.
pub fn write_responses(
    responses: &FrequencyResponses,
    geometry: &Geometry,
    form: UffFormat,
    to: &mut impl Write,
) -> Result<(), Error> {
    let lines = &responses.frequency_hz;
    let abscissa = even_abscissa(lines).unwrap_or(AbscissaSpacing::Uneven(lines));
    let said = |pair: Option<(f64, f64)>, [before, between, after]: [&str; 3]| {
        pair.map_or(String::new(), |(a, b)| {
            format!("{before}{a:?}{between}{b:?}{after}")
        })
    };
    let behind = responses.averages.map(|n| (n, responses.window_decay));
    let facts = [
        said(behind, codes::AVERAGES_LINE),
        said(responses.usable_band_hz, codes::USABLE_LINE),
        said(
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
        write_data_set(function, [output?, input?], lines, &facts, form, to)
            .map_err(output_error)?;
    }
    Ok(())
}

fn write_data_set(
    function: &FrequencyResponse,
    places: [(i32, i32); 2],
    (abscissa, lines): (AbscissaSpacing<'_>, &[f64]),
    facts: &[String; 3],
    form: UffFormat,
    to: &mut impl Write,
) -> io::Result<()> {
    let output = &function.output;
    let name = match &function.input {
        Some(input) => format!("{} / {}", output.name, input.name),
        None => output.name.clone(),
    };
    let head = DataSetHeader {
        ids: [&name, &facts[2], "", &facts[0], &facts[1]],
        function: codes::FREQUENCY_RESPONSE,
        output,
        input: function.input.as_ref(),
        places,
        is_complex: true,
        count: lines.len(),
        abscissa,
        abscissa_type: codes::FREQUENCY,
    };
    let is_uneven = matches!(abscissa, AbscissaSpacing::Uneven(_));
    head.write(form, to)?;
    let mut values = ValueWriter::new(form, to);
    for (line, value) in lines.iter().zip(&function.values) {
        if is_uneven {
            values.put_abscissa(*line)?;
        }
        values.write_value(value.re)?;
        values.write_value(value.im)?;
        values.end_uneven(is_uneven)?;
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
    head.write(form, to)?;
    let mut values = ValueWriter::new(form, to);
    for (line, value) in lines.iter().zip(coherence) {
        if is_uneven {
            values.put_abscissa(*line)?;
        }
        values.write_value(*value)?;
        values.end_uneven(is_uneven)?;
    }
    values.end()
}

/// Start and increment of lines, where as written in the header they give the same bits back.
fn even_abscissa(lines: &[f64]) -> Option<AbscissaSpacing<'static>> {
    let (&start, &last) = (lines.first()?, lines.last()?);
    let step = match lines.len() {
        1 => 1.0,
        n => (last - start) / (n - 1) as f64,
    };
    let written = |value: f64| format_exponent(value, ABSCISSA_DIGITS).parse::<f64>().ok();
    let (start, step) = (written(start)?, written(step)?);
    let mut all = lines.iter().enumerate();
    let same = all.all(|(k, &line)| start + k as f64 * step == line);
    same.then_some(AbscissaSpacing::Even(start, step))
}

impl DataSetHeader<'_> {
    /// The opening mark, the number of the set and the eleven lines of its header.
    fn write(&self, format: UffFormat, to: &mut impl Write) -> io::Result<()> {
        let is_even = matches!(self.abscissa, AbscissaSpacing::Even(..));
        let per_value = usize::from(!is_even) + 1 + usize::from(self.is_complex);
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
            AbscissaSpacing::Even(start, step) => (start, step),
            AbscissaSpacing::Uneven(lines) => (lines.first().copied().unwrap_or(0.0), 0.0),
        };
        writeln!(
            to,
            "{:10}{:10}{:10}{:>13}{:>13}{:>13}",
            if self.is_complex { 6 } else { 4 },
            self.count,
            u8::from(is_even),
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

/// Text without line breaks, `NONE` where there is none, cut to its field.
fn field_text(text: &str, width: usize) -> String {
    let line = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    match text.trim().is_empty() {
        true => "NONE".to_string(),
        false => line.take(width).collect(),
    }
}

/// Numbers one after the other, four to a row of text.
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
            4 => self.new_row(),
            _ => Ok(()),
        }
    }

    fn put_abscissa(&mut self, value: f64) -> io::Result<()> {
        match self.format {
            UffFormat::Binary => self.to.write_all(&value.to_le_bytes()),
            UffFormat::Text => write!(self.to, "{:>13}", format_exponent(value, ABSCISSA_DIGITS)),
        }
    }

    /// Ends the row of a value of an uneven abscissa: complex ones have a row each, real ones share it by two.
    fn end_uneven(&mut self, is_uneven: bool) -> io::Result<()> {
        match self.format == UffFormat::Text && is_uneven && self.in_row == 2 {
            true => self.new_row(),
            false => Ok(()),
        }
    }

    fn new_row(&mut self) -> io::Result<()> {
        self.in_row = 0;
        writeln!(self.to)
    }

    /// Ends the last row and the set.
    fn end(mut self) -> io::Result<()> {
        if self.in_row > 0 {
            self.new_row()?;
        }
        writeln!(self.to, "    -1")
    }
}
