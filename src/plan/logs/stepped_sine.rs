//! FRFs from a stepped sine: one spectral line per dwell.

use super::sample_blocks;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;
use crate::recording::frequency_responses::{ChannelLabel, FrequencyResponses};
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::settling::Dwell;
use crate::spectrum::stepped_sine::{
    self, SteppedSineEstimate, dwell_of_range, dwells_hold_frequency, find_dwells,
};

/// Minimum number of dwells, and their minimum share of the samples, by which an input is detected as a stepped sine.
const MIN_DWELLS: usize = 6;
const MIN_DWELL_SHARE: f64 = 0.5;

/// True if the input dwells on a sequence of frequencies.
pub fn is_stepped_sine(input: &[f64], rate_hz: f64) -> bool {
    let dwells = find_dwells(input, rate_hz);
    let covered: usize = dwells.iter().map(|d| d.range.len()).sum();
    // Smallest relative step between successive dwells.
    const MIN_FREQUENCY_STEP: f64 = 1e-3;
    let steps = (dwells.windows(2))
        .filter(|pair| {
            (pair[1].frequency_hz / pair[0].frequency_hz - 1.0).abs() > MIN_FREQUENCY_STEP
        })
        .count();
    steps + 1 >= MIN_DWELLS
        && covered as f64 > MIN_DWELL_SHARE * input.len() as f64
        && dwells_hold_frequency(input, rate_hz, &dwells)
}

/// FRFs at the dwell frequencies, with the method as text; the first channel is the input. `dwells_s` holds the start and end of each
/// dwell, s; if it is empty, the dwells are detected in the input.
///
/// # Errors
/// A dwell lies outside the record; no dwell is detected; the record exceeds the memory limit.
pub fn estimate_responses(
    recording: &Recording,
    channels: &[&Channel],
    dwells_s: &[(f64, f64)],
) -> Result<(FrequencyResponses, String, Vec<Diagnostic>), Error> {
    let rate = recording.rate_hz;
    let samples = sample_blocks::load_channels(recording, channels, "a stepped sine")?;
    let dwells = match dwells_s.is_empty() {
        true => channel_dwells(recording, &samples[0]),
        false => dwells_at(recording, &samples[0], dwells_s)?,
    };
    let labels: Vec<ChannelLabel> = (channels.iter())
        .map(|c| ChannelLabel {
            name: c.name.clone(),
            unit: c.unit.clone(),
        })
        .collect();
    let outputs: Vec<(&ChannelLabel, &[f64])> = (labels[1..].iter())
        .zip(samples[1..].iter().map(Vec::as_slice))
        .collect();
    let SteppedSineEstimate {
        responses,
        unsettled_hz,
    } = stepped_sine::estimate_from_dwells(rate, (&labels[0], &samples[0]), &outputs, &dwells)?;
    let lines = &responses.frequency_hz;
    let ends = lines.first().zip(lines.last());
    let longest = dwells.iter().map(|d| d.range.len()).max().unwrap_or(0);
    let shortest = dwells.iter().map(|d| d.range.len()).min().unwrap_or(0);
    let method_text = format!(
        "stepped sine: {} of {:.4} to {:.4} s, {} from {:.4} to {:.4} Hz; a sine fitted to the settled part of each, with the variance of the residual near its frequency",
        pluralise(dwells.len(), "dwell"),
        shortest as f64 / rate,
        longest as f64 / rate,
        pluralise(lines.len(), "frequency"),
        ends.map_or(0.0, |e| *e.0),
        ends.map_or(0.0, |e| *e.1)
    );
    let usable_hz = ends.map(|(low, high)| (*low, *high));
    let responses = FrequencyResponses {
        usable_band_hz: usable_hz,
        independent_lines_per_line: Some(1.0),
        ..responses
    };
    Ok((
        responses,
        method_text,
        settling_warning(&unsettled_hz).into_iter().collect(),
    ))
}

/// Warning for dwells at whose end the outputs had not settled.
fn settling_warning(unsettled_hz: &[f64]) -> Option<Diagnostic> {
    let (low, high) = (unsettled_hz.first()?, unsettled_hz.last()?);
    let message = format!(
        "on {} from {low:.4} to {high:.4} Hz the response still rings at the end: its value is extrapolated from the decay, with that uncertainty",
        pluralise(unsettled_hz.len(), "dwell"),
    );
    Some(Diagnostic {
        code: "unsettled",
        message,
        hint: Some("dwell longer there: several decay times of the resonance".into()),
    })
}

/// Dwells detected in each segment.
fn channel_dwells(recording: &Recording, input: &[f64]) -> Vec<Dwell> {
    let segment_dwells = |segment: &std::ops::Range<usize>| {
        let start = segment.start;
        let dwells = find_dwells(&input[segment.clone()], recording.rate_hz).into_iter();
        dwells.map(move |d| Dwell {
            range: d.range.start + start..d.range.end + start,
            ..d
        })
    };
    recording.segments.iter().flat_map(segment_dwells).collect()
}

/// Dwells between the requested times, s from the first sample of the log.
fn dwells_at(
    recording: &Recording,
    input: &[f64],
    dwells_s: &[(f64, f64)],
) -> Result<Vec<Dwell>, Error> {
    let rate = recording.rate_hz;
    let dwell = |&(from, to): &(f64, f64)| {
        let range_in_segment = (recording.segments.iter().zip(&recording.segment_starts)).find_map(
            |(segment, start)| {
                let sample = |time: f64| segment.start as f64 + (time * rate - start).round();
                let (first, last) = (sample(from), sample(to));
                let is_inside = first >= segment.start as f64 && last <= segment.end as f64;
                is_inside.then_some(first as usize..last as usize)
            },
        );
        let Some(range) = range_in_segment else {
            let message = format!(
                "the dwell from {from} to {to} s does not lie in the record, which covers {:.4} s{}",
                recording.duration_s(),
                match recording.segments.len() {
                    1 => String::new(),
                    n => format!(" in {n} segments"),
                }
            );
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("--dwells takes times in s from the first sample: 0.5:2.5,3:5"));
        };
        dwell_of_range(input, rate, range)
    };
    dwells_s.iter().map(dwell).collect()
}
