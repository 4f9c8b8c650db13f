//! The parts of a recording in which its sensors worked: time of stuck sensors is left out, and clipped time where enough is left.

use std::ops::Range;

use crate::base::error::{Diagnostic, Error};
use crate::recording::faults::{self, Faults};
use crate::recording::signals::Recording;

/// Smallest segment used, as a share of the longest segment of the record; blocks for averages are as long.
const MIN_SEGMENT_SHARE: f64 = 1.0 / 16.0;

/// The same for methods that take the longest segment alone.
const MIN_LONGEST_SHARE: f64 = 0.5;

/// Clipped samples and what falls between them take no more than this share of a record away.
const MAX_CLIPPED_SHARE: f64 = 0.5;

/// A recording whose faults are known.
#[derive(Debug)]
pub struct CheckedRecording {
    /// Without the time in which a sensor was stuck.
    pub recording: Recording,
    /// Diagnostics of stuck channels.
    pub stuck: Vec<Diagnostic>,
    faults: Faults,
}

/// Use that a method makes of segments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SegmentUse {
    /// It takes blocks of all of them.
    Blocks,
    /// It takes the longest.
    Longest,
}

/// Leaves out the time in which a sensor of the outputs was stuck while another channel moved.
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
    let kept = faults::without(recording, ranges.clone());
    let is_left_out = !ranges.is_empty() && !kept.segments.is_empty();
    Ok(CheckedRecording {
        stuck: faults.stuck_warnings(recording, is_left_out),
        recording: match is_left_out {
            true => kept,
            false => recording.clone(),
        },
        faults,
    })
}

impl CheckedRecording {
    /// Truncates the recording to its first samples.
    pub fn beginning(&self, samples: usize) -> CheckedRecording {
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

    /// Recording without clipped samples as well, where the rest suffices; with the diagnostics. A response is then cut where it is large,
    /// but
    /// between the cuts input and output keep their relation, so that the responses are unbiased.
    pub fn unclipped(&self, by: SegmentUse) -> (Recording, Vec<Diagnostic>) {
        let Some(clipped) = self.faults.clipped_in_words(&self.recording) else {
            return (self.recording.clone(), self.stuck.clone());
        };
        let kept = faults::without(&self.recording, self.faults.clipped_ranges());
        let longest = |r: &[Range<usize>]| r.iter().map(Range::len).max().unwrap_or(0) as f64;
        let (before, after) = (&self.recording.segments, &kept.segments);
        let enough = match by {
            SegmentUse::Longest => longest(after) >= MIN_LONGEST_SHARE * longest(before),
            SegmentUse::Blocks => {
                let block = MIN_SEGMENT_SHARE * longest(before);
                let used = |r: &Range<usize>| r.len() as f64 / block;
                let whole: f64 = after.iter().map(used).map(f64::floor).sum();
                let all: f64 = before.iter().map(used).sum();
                whole >= (1.0 - MAX_CLIPPED_SHARE) * all
            }
        };
        let mut diagnostics = self.stuck.clone();
        if !enough {
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
        (kept, diagnostics)
    }

    /// Samples at which a channel, by its index, clipped.
    pub fn clipped_ranges_of(&self, channel: usize) -> Vec<Range<usize>> {
        self.faults.clipped_ranges_of(channel)
    }

    /// Warnings about clipping that remains in the record.
    pub fn clipped_warnings(&self) -> Vec<Diagnostic> {
        let words = self.faults.clipped_in_words(&self.recording);
        let of = |words: String| {
            let message = format!("{words}: modes and damping may be wrong beyond their intervals");
            warning(message, "measure again with a larger range")
        };
        words.map(of).into_iter().collect()
    }
}

/// Warnings about clipped and stuck channels in a spectrum, which takes all samples: to leave out the largest would lower it.
///
/// # Errors
/// The samples cannot be read.
pub fn spectrum_warnings(
    recording: &Recording,
    places: &[usize],
) -> Result<Vec<Diagnostic>, Error> {
    let mut faults = faults::find(recording, places, &[])?;
    faults.stuck = faults::find_stuck(recording, places)?.stuck;
    let mut all = faults.stuck_warnings(recording, false);
    if let Some(words) = faults.clipped_in_words(recording) {
        let message = format!(
            "{words}: levels are too low, and multiples and differences of strong lines may be made by it"
        );
        all.push(warning(message, "measure again with a larger range"));
    }
    Ok(all)
}

fn warning(message: String, hint: &str) -> Diagnostic {
    Diagnostic {
        code: "clipped",
        message,
        hint: Some(hint.to_string()),
    }
}
