//! UFF 58: a data set for each channel or response, in text or in bytes (58b, little-endian), always in double precision.
//!
//! The format gives ten characters to a name and 13 columns to the abscissa. Whole names stand in the first line of the
//! header, the rate with all its digits in the fourth, and what lies behind frequency responses (averages, window, the band worth
//! fitting) in the second, fourth and fifth; this crate reads all of them again. Uniform lines are written as start and
//! increment where those give the same lines back, else one by one: in bytes exactly, in text with seven digits.

use std::io::{self, Write};

use super::{blocks, failed};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::recording::responses::{FrequencyResponse, FrequencyResponses, Terminal};
use crate::recording::signals::{Channel, Recording};
use crate::recording::uff::codes;

/// How the numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// As text, 13 digits.
    Text,
    /// As bytes.
    Binary,
}

/// Digits after the point of an abscissa in 13 columns, and of a double in 20.
const ABSCISSA_DIGITS: usize = 6;
const DOUBLE_DIGITS: usize = 12;

/// Characters of a line for people.
const ID: usize = 80;

/// The abscissa of a set.
#[derive(Clone, Copy)]
enum Abscissa<'a> {
    /// Start and increment.
    Even(f64, f64),
    /// Value by value.
    Uneven(&'a [f64]),
}

/// The head of a set.
struct Head<'a> {
    ids: [&'a str; 5],
    function: usize,
    output: &'a Terminal,
    input: Option<&'a Terminal>,
    is_complex: bool,
    count: usize,
    abscissa: Abscissa<'a>,
    abscissa_type: i64,
}

/// Signals as time responses.
///
/// # Errors
/// `conflict` where the record has gaps, for which an even abscissa has no place; `output-failed`; those of reading a column.
pub fn signals(recording: &Recording, form: Form, to: &mut impl Write) -> Result<(), Error> {
    if recording.stretches.len() > 1 {
        let message = format!(
            "the record has {} stretches, and an even UFF 58 has no place for the gaps between them",
            recording.stretches.len()
        );
        return Err(Error::new(Code::Conflict, message)
            .hint("bridge them: --fill-gaps; take a part: --after, --before; or write CSV"));
    }
    let long = |c: &&Channel| c.name.chars().count() > ID;
    if let Some(channel) = recording.channels.iter().find(long) {
        let message = format!("UFF 58 gives {ID} characters to a name: {}", channel.name);
        return Err(Error::new(Code::Conflict, message)
            .hint("rename the channel in the sidecar, or write CSV"));
    }
    let date = recording.start.as_deref().unwrap_or_default();
    let (before, after) = codes::RATE_LINE;
    let rate = format!("{before}{:?}{after}", recording.rate_hz);
    for channel in &recording.channels {
        let output = Terminal {
            name: channel.name.clone(),
            unit: channel.unit.clone(),
        };
        let head = Head {
            ids: [&channel.name, "", date, &rate, ""],
            function: codes::TIME_RESPONSE,
            output: &output,
            input: None,
            is_complex: false,
            count: recording.samples,
            abscissa: Abscissa::Even(recording.time_s(0, 0), recording.rate_hz.recip()),
            abscissa_type: codes::TIME,
        };
        head.write(form, to).map_err(failed)?;
        let mut values = Values::new(form, to);
        blocks(channel, recording.samples, |block| {
            block.iter().try_for_each(|&value| values.put(value))
        })?;
        values.end().map_err(failed)?;
    }
    Ok(())
}

/// Frequency responses, each followed by its coherence where there is one.
///
/// # Errors
/// `output-failed`.
pub fn responses(
    responses: &FrequencyResponses,
    form: Form,
    to: &mut impl Write,
) -> Result<(), Error> {
    let lines = &responses.frequency_hz;
    let abscissa = even(lines).unwrap_or(Abscissa::Uneven(lines));
    let said = |pair: Option<(f64, f64)>, [before, between, after]: [&str; 3]| {
        pair.map_or(String::new(), |(a, b)| {
            format!("{before}{a:?}{between}{b:?}{after}")
        })
    };
    let behind = responses.averages.map(|n| (n, responses.window_decay));
    let facts = [
        said(behind, codes::AVERAGES_LINE),
        said(responses.usable_hz, codes::USABLE_LINE),
        said(
            responses.line_independence.map(|share| (share, 1.0)),
            codes::INDEPENDENCE_LINE,
        ),
    ];
    for function in &responses.functions {
        one(function, abscissa, lines, &facts, form, to).map_err(failed)?;
    }
    Ok(())
}

fn one(
    function: &FrequencyResponse,
    abscissa: Abscissa<'_>,
    lines: &[f64],
    facts: &[String; 3],
    form: Form,
    to: &mut impl Write,
) -> io::Result<()> {
    let output = &function.output;
    let name = match &function.input {
        Some(input) => format!("{} / {}", output.name, input.name),
        None => output.name.clone(),
    };
    let head = Head {
        ids: [&name, &facts[2], "", &facts[0], &facts[1]],
        function: codes::FREQUENCY_RESPONSE,
        output,
        input: function.input.as_ref(),
        is_complex: true,
        count: lines.len(),
        abscissa,
        abscissa_type: codes::FREQUENCY,
    };
    let is_uneven = matches!(abscissa, Abscissa::Uneven(_));
    head.write(form, to)?;
    let mut values = Values::new(form, to);
    for (line, value) in lines.iter().zip(&function.value) {
        if is_uneven {
            values.put_abscissa(*line)?;
        }
        values.put(value.re)?;
        values.put(value.im)?;
        values.end_uneven(is_uneven)?;
    }
    values.end()?;
    let Some(coherence) = &function.coherence else {
        return Ok(());
    };
    let unitless = |terminal: &Terminal| Terminal {
        name: terminal.name.clone(),
        unit: String::new(),
    };
    let (output, input) = (unitless(output), function.input.as_ref().map(unitless));
    let head = Head {
        function: codes::COHERENCE,
        output: &output,
        input: input.as_ref(),
        is_complex: false,
        ..head
    };
    head.write(form, to)?;
    let mut values = Values::new(form, to);
    for (line, value) in lines.iter().zip(coherence) {
        if is_uneven {
            values.put_abscissa(*line)?;
        }
        values.put(*value)?;
        values.end_uneven(is_uneven)?;
    }
    values.end()
}

/// Start and increment of lines, where as written in the header they give the same bits back.
fn even(lines: &[f64]) -> Option<Abscissa<'static>> {
    let (&start, &last) = (lines.first()?, lines.last()?);
    let step = match lines.len() {
        1 => 1.0,
        n => (last - start) / (n - 1) as f64,
    };
    let written = |value: f64| exponent(value, ABSCISSA_DIGITS).parse::<f64>().ok();
    let (start, step) = (written(start)?, written(step)?);
    let mut all = lines.iter().enumerate();
    let same = all.all(|(k, &line)| start + k as f64 * step == line);
    same.then_some(Abscissa::Even(start, step))
}

impl Head<'_> {
    /// The opening mark, the number of the set and the eleven lines of its header.
    fn write(&self, form: Form, to: &mut impl Write) -> io::Result<()> {
        let is_even = matches!(self.abscissa, Abscissa::Even(..));
        let per_value = usize::from(!is_even) + 1 + usize::from(self.is_complex);
        writeln!(to, "    -1")?;
        match form {
            Form::Text => writeln!(to, "    58")?,
            Form::Binary => writeln!(
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
            writeln!(to, "{}", shown(id, ID))?;
        }
        let none = Terminal::default();
        let input = self.input.unwrap_or(&none);
        writeln!(
            to,
            "{:5}{:10}{:5}{:10} {:10}{:10}{:4} {:10}{:10}{:4}",
            self.function,
            0,
            0,
            0,
            shown(&self.output.name, 10),
            0,
            0,
            shown(&input.name, 10),
            0,
            0
        )?;
        let (start, step) = match self.abscissa {
            Abscissa::Even(start, step) => (start, step),
            Abscissa::Uneven(lines) => (lines.first().copied().unwrap_or(0.0), 0.0),
        };
        writeln!(
            to,
            "{:10}{:10}{:10}{:>13}{:>13}{:>13}",
            if self.is_complex { 6 } else { 4 },
            self.count,
            u8::from(is_even),
            exponent(start, ABSCISSA_DIGITS),
            exponent(step, ABSCISSA_DIGITS),
            exponent(0.0, ABSCISSA_DIGITS)
        )?;
        let (label, unit) = match self.abscissa_type {
            codes::TIME => ("Time", "s"),
            _ => ("Frequency", "Hz"),
        };
        let data_type = |terminal: &Terminal| codes::data_type(&terminal.unit);
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
    let (label, unit) = (shown(label, 20), shown(unit, 20));
    writeln!(
        to,
        "{data_type:10}{:5}{:5}{:5} {label:20} {unit:20}",
        0, 0, 0
    )
}

/// Text without line breaks, `NONE` where there is none, cut to its field.
fn shown(text: &str, width: usize) -> String {
    let line = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    match text.trim().is_empty() {
        true => "NONE".to_string(),
        false => line.take(width).collect(),
    }
}

/// `d.ddddE±dd`, as Fortran and C write it.
fn exponent(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "NaN".to_string();
    }
    let text = format!("{value:.digits$E}");
    let (mantissa, exponent) = text.split_once('E').unwrap_or((&text, "0"));
    let (sign, size) = match exponent.strip_prefix('-') {
        Some(size) => ('-', size),
        None => ('+', exponent),
    };
    format!("{mantissa}E{sign}{size:0>2}")
}

/// Numbers one after the other, four to a row of text.
struct Values<'a, W: Write> {
    form: Form,
    to: &'a mut W,
    in_row: usize,
}

impl<'a, W: Write> Values<'a, W> {
    fn new(form: Form, to: &'a mut W) -> Values<'a, W> {
        Values {
            form,
            to,
            in_row: 0,
        }
    }

    fn put(&mut self, value: f64) -> io::Result<()> {
        match self.form {
            Form::Binary => return self.to.write_all(&value.to_le_bytes()),
            Form::Text => write!(self.to, "{:>20}", exponent(value, DOUBLE_DIGITS))?,
        }
        self.in_row += 1;
        match self.in_row {
            4 => self.new_row(),
            _ => Ok(()),
        }
    }

    fn put_abscissa(&mut self, value: f64) -> io::Result<()> {
        match self.form {
            Form::Binary => self.to.write_all(&value.to_le_bytes()),
            Form::Text => write!(self.to, "{:>13}", exponent(value, ABSCISSA_DIGITS)),
        }
    }

    /// Ends the row of a value of an uneven abscissa: complex ones have a row each, real ones share it by two.
    fn end_uneven(&mut self, is_uneven: bool) -> io::Result<()> {
        match self.form == Form::Text && is_uneven && self.in_row == 2 {
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
