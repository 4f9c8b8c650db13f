//! JSON output: one document, units in the keys, missing values as null.

use std::io::{self, Write};
use std::ops::Range;

use serde_json::{Value, json};

use super::{for_each_block, output_error};
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::recording::frequency_responses::{ChannelLabel, FrequencyResponses};
use crate::recording::signals::Recording;

/// Signals: `start` (date and time), `rate_hz`, `samples`, `duration_s`, `segments[]`, and `channels[]` with `name`, `unit`, `value[]`.
///
/// `geardyn` is the block of that name every document begins with.
///
/// # Errors
/// `output-failed`; those of reading a column.
pub fn write_recording(
    recording: &Recording,
    geardyn: &Value,
    to: &mut impl Write,
) -> Result<(), Error> {
    let (rate, duration) = (number(recording.rate_hz), number(recording.duration_s()));
    let samples = recording.samples;
    let (start, stretches) = (json!(recording.start), segments(recording));
    write!(
        to,
        "{{\"geardyn\":{geardyn},\"start\":{start},\"rate_hz\":{rate},\"samples\":{samples},\"duration_s\":{duration},\"segments\":{stretches},\"channels\":["
    )
    .map_err(output_error)?;
    for (at, channel) in recording.channels.iter().enumerate() {
        let (comma, name, unit) = (separator(at), json!(channel.name), json!(channel.unit));
        write!(to, "{comma}{{\"name\":{name},\"unit\":{unit},\"value\":[").map_err(output_error)?;
        let mut written = 0;
        for_each_block(channel, samples, |block| {
            for &value in block {
                write!(to, "{}{}", separator(written), number(value))?;
                written += 1;
            }
            Ok(())
        })?;
        write!(to, "]}}").map_err(output_error)?;
    }
    writeln!(to, "]}}").map_err(output_error)
}

/// The segments without gaps: first sample, number of samples, time of the first from the log's first sample.
pub fn segments(recording: &Recording) -> Value {
    let segment = |(k, s): (usize, &Range<usize>)| json!({ "from_sample": s.start, "samples": s.len(), "from_s": recording.time_s(k, 0) });
    recording.segments.iter().enumerate().map(segment).collect()
}

/// Frequency responses: `frequency_hz[]`, and `functions[]` with `input` (null where unknown), `output`, `value[]` of
/// `re` and `im`, `variance[]`, `coherence[]` and, of several inputs, `partial_coherence[]` (null where not measured); `averages`, `window_decay_1_s`.
///
/// # Errors
/// `output-failed`.
pub fn write_responses<W: Write>(
    responses: &FrequencyResponses,
    geardyn: &Value,
    to: &mut W,
) -> Result<(), Error> {
    let document = |to: &mut W| -> io::Result<()> {
        write!(
            to,
            "{{\"geardyn\":{geardyn},\"averages\":{},\"window_decay_1_s\":{},\"frequency_hz\":",
            responses.averages.map_or(Value::Null, number),
            number(responses.window_decay)
        )?;
        write_array(to, &responses.frequency_hz)?;
        write!(to, ",\"functions\":[")?;
        for (at, function) in responses.responses.iter().enumerate() {
            let input = function.input.as_ref().map_or(Value::Null, channel_label);
            let output = channel_label(&function.output);
            write!(
                to,
                "{}{{\"input\":{input},\"output\":{output},\"value\":[",
                separator(at)
            )?;
            for (k, Complex { re, im }) in function.values.iter().enumerate() {
                write!(
                    to,
                    "{}{{\"re\":{},\"im\":{}}}",
                    separator(k),
                    number(*re),
                    number(*im)
                )?;
            }
            write!(to, "]")?;
            for (key, values) in [
                ("variance", &function.variance),
                ("coherence", &function.coherence),
                ("partial_coherence", &function.partial_coherence),
            ] {
                write!(to, ",\"{key}\":")?;
                match values {
                    Some(values) => write_array(to, values)?,
                    None => write!(to, "null")?,
                }
            }
            write!(to, "}}")?;
        }
        writeln!(to, "]}}")
    };
    document(to).map_err(output_error)
}

fn channel_label(terminal: &ChannelLabel) -> Value {
    json!({ "name": terminal.name, "unit": terminal.unit })
}

fn write_array(to: &mut impl Write, values: &[f64]) -> io::Result<()> {
    write!(to, "[")?;
    for (at, &value) in values.iter().enumerate() {
        write!(to, "{}{}", separator(at), number(value))?;
    }
    write!(to, "]")
}

/// The shortest decimal that reads back to the same bits; null where it is no number.
fn number(value: f64) -> Value {
    json!(value)
}

fn separator(at: usize) -> &'static str {
    if at == 0 { "" } else { "," }
}
