//! Segments of a recording without sensor faults: time of stuck sensors is removed, clipped time only if enough of the record remains.

use std::ops::Range;

use crate::base::error::{Diagnostic, Error};
use crate::recording::faults::{self, Faults};
use crate::recording::signals::Recording;

/// Shortest segment used, relative to the longest segment of the record; blocks for averages have this length.
const MIN_SEGMENT_SHARE: f64 = 1.0 / 16.0;

/// Minimum length of the longest unclipped segment relative to the longest segment, for methods that use only one segment.
const MIN_LONGEST_SHARE: f64 = 0.5;

/// Maximum share of a record lost by removing clipped samples, including segments too short to use.
const MAX_CLIPPED_SHARE: f64 = 0.5;

/// Recording with its sensor faults.
#[derive(Debug)]
pub struct CheckedRecording {
    /// The recording without the time in which a sensor was stuck.
    pub recording: Recording,
    /// Diagnostics of stuck channels.
    pub stuck: Vec<Diagnostic>,
    faults: Faults,
}

/// Segments that a method uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SegmentUse {
    /// The method takes blocks of all segments.
    Blocks,
    /// The method takes the longest segment.
    Longest,
}

/// Removes the time in which an output sensor was stuck while another channel varied.
///
/// # Errors
/// The samples cannot be read.
pub fn without_faults(
    recording: &Recording,
    inputs: &[usize],
    outputs: &[usize],
) -> Result<CheckedRecording, Error> {
    let faults = faults::find(recording, inputs, outputs)?;
    let ranges = faults.stuck_ranges();
    let remaining = faults::without(recording, ranges.clone());
    let is_removed = !ranges.is_empty() && !remaining.segments.is_empty();
    Ok(CheckedRecording {
        stuck: faults.stuck_warnings(recording, is_removed),
        recording: match is_removed {
            true => remaining,
            false => recording.clone(),
        },
        faults,
    })
}

impl CheckedRecording {
    /// Truncates the recording to its first `samples` samples.
    pub fn truncated(&self, samples: usize) -> CheckedRecording {
        let mut recording = self.recording.clone();
        recording.segments.retain(|s| s.start < samples);
        recording.segment_starts.truncate(recording.segments.len());
        for segment in &mut recording.segments {
            segment.end = segment.end.min(samples);
        }
        recording.samples = recording.samples.min(samples);
        CheckedRecording {
            recording,
            stuck: self.stuck.clone(),
            faults: self.faults.clone(),
        }
    }

    /// Removes clipped samples as well if the remainder suffices, and returns the diagnostics. A response is then cut where it is large;
    /// between the cuts the relation of input and output is unchanged, so that response estimates are unbiased.
    pub fn unclipped(&self, segment_use: SegmentUse) -> (Recording, Vec<Diagnostic>) {
        let Some(clipped) = self.faults.clipping_text(&self.recording) else {
            return (self.recording.clone(), self.stuck.clone());
        };
        let remaining = faults::without(&self.recording, self.faults.clipped_ranges());
        let longest = |r: &[Range<usize>]| r.iter().map(Range::len).max().unwrap_or(0) as f64;
        let (before, after) = (&self.recording.segments, &remaining.segments);
        let is_enough = match segment_use {
            SegmentUse::Longest => longest(after) >= MIN_LONGEST_SHARE * longest(before),
            SegmentUse::Blocks => {
                let block = MIN_SEGMENT_SHARE * longest(before);
                let blocks = |r: &Range<usize>| r.len() as f64 / block;
                let usable: f64 = after.iter().map(blocks).map(f64::floor).sum();
                let total: f64 = before.iter().map(blocks).sum();
                usable >= (1.0 - MAX_CLIPPED_SHARE) * total
            }
        };
        let mut diagnostics = self.stuck.clone();
        if !is_enough {
            diagnostics.extend(self.clipped_warnings());
            return (self.recording.clone(), diagnostics);
        }
        let samples = |r: &[Range<usize>]| r.iter().map(Range::len).sum::<usize>();
        let message = format!(
            "{clipped}: {:.4} s removed, the rest has {} segments",
            (samples(before) - samples(after)) as f64 / self.recording.rate_hz,
            after.len()
        );
        diagnostics.push(warning(
            message,
            "measure with a larger range; a longer record gives longer segments",
        ));
        (remaining, diagnostics)
    }

    /// Sample ranges in which a channel, by index, clipped.
    pub fn clipped_ranges_of(&self, channel: usize) -> Vec<Range<usize>> {
        self.faults.clipped_ranges_of(channel)
    }

    /// Warnings of clipping that remains in the record.
    pub fn clipped_warnings(&self) -> Vec<Diagnostic> {
        let words = self.faults.clipping_text(&self.recording);
        let diagnostic = |words: String| {
            let message = format!("{words}: modes and damping may be wrong beyond their intervals");
            warning(message, "measure again with a larger range")
        };
        words.map(diagnostic).into_iter().collect()
    }
}

/// Warnings of clipped and stuck channels in a spectrum, which uses all samples: removing the largest would bias it low.
///
/// # Errors
/// The samples cannot be read.
pub fn spectrum_warnings(
    recording: &Recording,
    channels: &[usize],
) -> Result<Vec<Diagnostic>, Error> {
    let mut faults = faults::find(recording, channels, &[])?;
    faults.stuck = faults::find_stuck(recording, channels)?.stuck;
    let mut warnings = faults.stuck_warnings(recording, false);
    if let Some(words) = faults.clipping_text(recording) {
        let message = format!(
            "{words}: levels are too low, and harmonics and differences of strong lines may be artefacts"
        );
        warnings.push(warning(message, "measure again with a larger range"));
    }
    Ok(warnings)
}

fn warning(message: String, hint: &str) -> Diagnostic {
    Diagnostic {
        code: "clipped",
        message,
        hint: Some(hint.to_string()),
    }
}
