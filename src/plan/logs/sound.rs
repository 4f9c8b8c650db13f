//! The parts of a recording in which its sensors worked: time of stuck sensors is left out, and clipped time where enough is left.

use std::ops::Range;

use crate::base::error::{Error, Warning};
use crate::recording::faults::{self, Faults};
use crate::recording::signals::Recording;

/// What is left of a record has a stretch of this share of its longest at least; blocks that averages would take are as long.
const BLOCKS: f64 = 1.0 / 16.0;

/// The same for methods that take the longest stretch alone.
const LONGEST: f64 = 0.5;

/// Clipped samples and what falls between them take no more than this share of a record away.
const TAKEN: f64 = 0.5;

/// A recording whose faults are known.
#[derive(Debug)]
pub struct Sound {
    /// Without the time in which a sensor was stuck.
    pub recording: Recording,
    /// What was stuck.
    pub stuck: Vec<Warning>,
    faults: Faults,
}

/// What a method makes of stretches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
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
) -> Result<Sound, Error> {
    let faults = faults::find(recording, inputs, outputs)?;
    let ranges = faults.stuck_ranges();
    let kept = faults::without(recording, ranges.clone());
    let is_left_out = !ranges.is_empty() && !kept.stretches.is_empty();
    Ok(Sound {
        stuck: faults.stuck_warnings(recording, is_left_out),
        recording: match is_left_out {
            true => kept,
            false => recording.clone(),
        },
        faults,
    })
}

impl Sound {
    /// Its first samples alone.
    pub fn beginning(&self, samples: usize) -> Sound {
        let mut recording = self.recording.clone();
        recording.stretches.retain(|s| s.start < samples);
        recording.starts.truncate(recording.stretches.len());
        for stretch in &mut recording.stretches {
            stretch.end = stretch.end.min(samples);
        }
        recording.samples = recording.samples.min(samples);
        Sound {
            recording,
            stuck: self.stuck.clone(),
            faults: self.faults.clone(),
        }
    }

    /// Without clipped samples as well, where what is left suffices; and what is said of it. A response is then cut where it is large, but
    /// between the cuts input and output keep their relation, so that the responses are unbiased.
    pub fn unclipped(&self, by: Use) -> (Recording, Vec<Warning>) {
        let Some(clipped) = self.faults.clipped_in_words(&self.recording) else {
            return (self.recording.clone(), self.stuck.clone());
        };
        let kept = faults::without(&self.recording, self.faults.clipped_ranges());
        let longest = |r: &[Range<usize>]| r.iter().map(Range::len).max().unwrap_or(0) as f64;
        let (before, after) = (&self.recording.stretches, &kept.stretches);
        let enough = match by {
            Use::Longest => longest(after) >= LONGEST * longest(before),
            Use::Blocks => {
                let block = BLOCKS * longest(before);
                let used = |r: &Range<usize>| r.len() as f64 / block;
                let whole: f64 = after.iter().map(used).map(f64::floor).sum();
                let all: f64 = before.iter().map(used).sum();
                whole >= (1.0 - TAKEN) * all
            }
        };
        let mut warnings = self.stuck.clone();
        if !enough {
            warnings.extend(self.clipped_warnings());
            return (self.recording.clone(), warnings);
        }
        let samples = |r: &[Range<usize>]| r.iter().map(Range::len).sum::<usize>();
        let message = format!(
            "{clipped}: {:.4} s left out, the rest lies in {} stretches",
            (samples(before) - samples(after)) as f64 / self.recording.rate_hz,
            after.len()
        );
        warnings.push(warning(
            message,
            "measure with a larger range; a longer record gives longer stretches",
        ));
        (kept, warnings)
    }

    /// What is said of clipping that stays in the record.
    pub fn clipped_warnings(&self) -> Vec<Warning> {
        let words = self.faults.clipped_in_words(&self.recording);
        let of = |words: String| {
            let message = format!("{words}: modes and damping may be wrong beyond their intervals");
            warning(message, "measure again with a larger range")
        };
        words.map(of).into_iter().collect()
    }
}

/// What is said of clipped and stuck channels in a spectrum, which takes all samples: to leave out the largest would lower it.
///
/// # Errors
/// The samples cannot be read.
pub fn of_spectrum(recording: &Recording, places: &[usize]) -> Result<Vec<Warning>, Error> {
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

fn warning(message: String, hint: &str) -> Warning {
    Warning {
        code: "clipped",
        message,
        hint: Some(hint.to_string()),
    }
}
