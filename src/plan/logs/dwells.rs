//! Frequency responses from a stepped sine: one line for each frequency that the input dwells on.

use super::blocks;
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::base::words::counted;
use crate::recording::responses::{FrequencyResponses, Terminal};
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::settling::Dwell;
use crate::spectrum::stepped::{self, Stepped, dwell, dwells, hold};

/// So many dwells, over this share of what was looked at, make a stepped sine of an input that nobody calls one.
const FEWEST: usize = 6;
const SHARE: f64 = 0.5;

/// Whether the input dwells on one frequency after another.
pub fn looks_stepped(input: &[f64], rate_hz: f64) -> bool {
    let found = dwells(input, rate_hz);
    let covered: usize = found.iter().map(|d| d.range.len()).sum();
    // The same frequency twice is no step.
    const APART: f64 = 1e-3;
    let steps = (found.windows(2))
        .filter(|pair| (pair[1].frequency_hz / pair[0].frequency_hz - 1.0).abs() > APART)
        .count();
    steps + 1 >= FEWEST
        && covered as f64 > SHARE * input.len() as f64
        && hold(input, rate_hz, &found)
}

/// The responses at the frequencies dwelt on, and how they were had; the first channel drives. Dwells are found in it where `dwells_s`,
/// from when to when in s, is empty.
///
/// # Errors
/// Dwells outside of the record; an input that dwells on nothing; more samples than can be held at once.
pub fn responses(
    recording: &Recording,
    channels: &[&Channel],
    dwells_s: &[(f64, f64)],
) -> Result<(FrequencyResponses, String, Vec<Warning>), Error> {
    let rate = recording.rate_hz;
    let all = blocks::whole(recording, channels, "a stepped sine")?;
    let found = match dwells_s.is_empty() {
        true => everywhere(recording, &all[0]),
        false => given(recording, &all[0], dwells_s)?,
    };
    let terminals: Vec<Terminal> = (channels.iter())
        .map(|c| Terminal {
            name: c.name.clone(),
            unit: c.unit.clone(),
        })
        .collect();
    let outputs: Vec<(&Terminal, &[f64])> = (terminals[1..].iter())
        .zip(all[1..].iter().map(Vec::as_slice))
        .collect();
    let Stepped {
        responses,
        unsettled_hz,
    } = stepped::stepped(rate, (&terminals[0], &all[0]), &outputs, &found)?;
    let lines = &responses.frequency_hz;
    let ends = lines.first().zip(lines.last());
    let longest = found.iter().map(|d| d.range.len()).max().unwrap_or(0);
    let shortest = found.iter().map(|d| d.range.len()).min().unwrap_or(0);
    let how = format!(
        "stepped sine: {} of {:.4} to {:.4} s, {} from {:.4} to {:.4} Hz; a sine fitted to what has settled of each, with the variance of what it leaves near its frequency",
        counted(found.len(), "dwell"),
        shortest as f64 / rate,
        longest as f64 / rate,
        counted(lines.len(), "frequency"),
        ends.map_or(0.0, |e| *e.0),
        ends.map_or(0.0, |e| *e.1)
    );
    let usable_hz = ends.map(|(low, high)| (*low, *high));
    let responses = FrequencyResponses {
        usable_hz,
        line_independence: Some(1.0),
        ..responses
    };
    Ok((
        responses,
        how,
        unsettled(&unsettled_hz).into_iter().collect(),
    ))
}

/// Says on which dwells the outputs had not settled.
fn unsettled(places_hz: &[f64]) -> Option<Warning> {
    let (low, high) = (places_hz.first()?, places_hz.last()?);
    let message = format!(
        "on {} from {low:.4} to {high:.4} Hz the response still rings at the end: its value is told from how it rings out, and as uncertain",
        counted(places_hz.len(), "dwell"),
    );
    Some(Warning {
        code: "unsettled",
        message,
        hint: Some("dwell longer there: several times the decay of the resonance".into()),
    })
}

/// Dwells of every stretch without a gap.
fn everywhere(recording: &Recording, input: &[f64]) -> Vec<Dwell> {
    let of = |stretch: &std::ops::Range<usize>| {
        let start = stretch.start;
        let found = dwells(&input[stretch.clone()], recording.rate_hz).into_iter();
        found.map(move |d| Dwell {
            range: d.range.start + start..d.range.end + start,
            ..d
        })
    };
    recording.stretches.iter().flat_map(of).collect()
}

/// Dwells between the times asked for, s from the log's first sample.
fn given(
    recording: &Recording,
    input: &[f64],
    dwells_s: &[(f64, f64)],
) -> Result<Vec<Dwell>, Error> {
    let rate = recording.rate_hz;
    let one = |&(from, to): &(f64, f64)| {
        let place =
            (recording.stretches.iter().zip(&recording.starts)).find_map(|(stretch, start)| {
                let at = |time: f64| stretch.start as f64 + (time * rate - start).round();
                let (first, last) = (at(from), at(to));
                let is_inside = first >= stretch.start as f64 && last <= stretch.end as f64;
                is_inside.then_some(first as usize..last as usize)
            });
        let Some(range) = place else {
            let message = format!(
                "the dwell from {from} to {to} s does not lie in the record, which covers {:.4} s{}",
                recording.duration_s(),
                match recording.stretches.len() {
                    1 => String::new(),
                    n => format!(" in {n} stretches"),
                }
            );
            return Err(Error::new(Code::OutOfRange, message)
                .hint("--dwells takes times in s from the first sample: 0.5:2.5,3:5"));
        };
        dwell(input, rate, range)
    };
    dwells_s.iter().map(one).collect()
}
