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

/// Fewest dwells, over this share of the samples examined, of a stepped sine in an input that is not declared one.
const MIN_DWELLS: usize = 6;
const MIN_DWELL_SHARE: f64 = 0.5;

/// Whether the input dwells on one frequency after another.
pub fn is_stepped_sine(input: &[f64], rate_hz: f64) -> bool {
    let found = find_dwells(input, rate_hz);
    let covered: usize = found.iter().map(|d| d.range.len()).sum();
    // The same frequency twice is no step.
    const MIN_FREQUENCY_STEP: f64 = 1e-3;
    let steps = (found.windows(2))
        .filter(|pair| {
            (pair[1].frequency_hz / pair[0].frequency_hz - 1.0).abs() > MIN_FREQUENCY_STEP
        })
        .count();
    steps + 1 >= MIN_DWELLS
        && covered as f64 > MIN_DWELL_SHARE * input.len() as f64
        && dwells_hold_frequency(input, rate_hz, &found)
}

/// The responses at the frequencies dwelt on, and how they were had; the first channel drives. Dwells are found in it where `dwells_s`,
/// from when to when in s, is empty.
///
/// # Errors
/// Dwells outside of the record; an input that dwells on nothing; more samples than can be held at once.
pub fn estimate_responses(
    recording: &Recording,
    channels: &[&Channel],
    dwells_s: &[(f64, f64)],
) -> Result<(FrequencyResponses, String, Vec<Diagnostic>), Error> {
    let rate = recording.rate_hz;
    let all = sample_blocks::load_channels(recording, channels, "a stepped sine")?;
    let found = match dwells_s.is_empty() {
        true => channel_dwells(recording, &all[0]),
        false => dwells_at(recording, &all[0], dwells_s)?,
    };
    let terminals: Vec<ChannelLabel> = (channels.iter())
        .map(|c| ChannelLabel {
            name: c.name.clone(),
            unit: c.unit.clone(),
        })
        .collect();
    let outputs: Vec<(&ChannelLabel, &[f64])> = (terminals[1..].iter())
        .zip(all[1..].iter().map(Vec::as_slice))
        .collect();
    let SteppedSineEstimate {
        responses,
        unsettled_hz,
    } = stepped_sine::estimate_from_dwells(rate, (&terminals[0], &all[0]), &outputs, &found)?;
    let lines = &responses.frequency_hz;
    let ends = lines.first().zip(lines.last());
    let longest = found.iter().map(|d| d.range.len()).max().unwrap_or(0);
    let shortest = found.iter().map(|d| d.range.len()).min().unwrap_or(0);
    let how = format!(
        "stepped sine: {} of {:.4} to {:.4} s, {} from {:.4} to {:.4} Hz; a sine fitted to what has settled of each, with the variance of what it leaves near its frequency",
        pluralise(found.len(), "dwell"),
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
        how,
        settling_warning(&unsettled_hz).into_iter().collect(),
    ))
}

/// Says on which dwells the outputs had not settled.
fn settling_warning(places_hz: &[f64]) -> Option<Diagnostic> {
    let (low, high) = (places_hz.first()?, places_hz.last()?);
    let message = format!(
        "on {} from {low:.4} to {high:.4} Hz the response still rings at the end: its value is extrapolated from the decay, with that uncertainty",
        pluralise(places_hz.len(), "dwell"),
    );
    Some(Diagnostic {
        code: "unsettled",
        message,
        hint: Some("dwell longer there: several times the decay of the resonance".into()),
    })
}

/// Dwells of every segment without a gap.
fn channel_dwells(recording: &Recording, input: &[f64]) -> Vec<Dwell> {
    let of = |segment: &std::ops::Range<usize>| {
        let start = segment.start;
        let found = find_dwells(&input[segment.clone()], recording.rate_hz).into_iter();
        found.map(move |d| Dwell {
            range: d.range.start + start..d.range.end + start,
            ..d
        })
    };
    recording.segments.iter().flat_map(of).collect()
}

/// Dwells between the requested times, s from the log's first sample.
fn dwells_at(
    recording: &Recording,
    input: &[f64],
    dwells_s: &[(f64, f64)],
) -> Result<Vec<Dwell>, Error> {
    let rate = recording.rate_hz;
    let one = |&(from, to): &(f64, f64)| {
        let place = (recording.segments.iter().zip(&recording.segment_starts)).find_map(
            |(segment, start)| {
                let at = |time: f64| segment.start as f64 + (time * rate - start).round();
                let (first, last) = (at(from), at(to));
                let is_inside = first >= segment.start as f64 && last <= segment.end as f64;
                is_inside.then_some(first as usize..last as usize)
            },
        );
        let Some(range) = place else {
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
    dwells_s.iter().map(one).collect()
}
