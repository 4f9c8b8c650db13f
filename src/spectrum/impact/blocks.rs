//! Hits of an impact record: detection, rejection, and choice of the block length.

use std::ops::Range;

use super::decay::{NOISE_FACTOR, decay_length, levels, rms};
use super::{ImpactOptions, MIN_NOISE_SAMPLES, RejectReason};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::fft::next_fast_len;
use crate::numeric::sorting::sort_descending;
use crate::spectrum::force_pulses::{ForcePulse, is_clipped, median, pulses_to};

/// Height of a second pulse relative to the largest above which a hit is double.
const DOUBLE_HIT_SHARE: f64 = 0.1;

/// Level at the end of the block, relative to the largest, to which an exponential window reduces the response.
const END_LEVEL: f64 = 0.01;

/// Peak height in quantisation steps above which equal peaks are no coincidence: of two peaks within 10 % less often than once in 400.
const MIN_PEAK_LEVELS: f64 = 4096.0;

/// Block length relative to the time for which the response exceeds the noise. The response below the noise of one sample still adds to
/// the sum over many, and truncating it biases the low modes.
const BLOCK_PER_DECAY: usize = 3;

/// Hit with its block, in samples of the record.
pub(super) struct HitBlock {
    pub(super) pulse: ForcePulse,
    /// First sample of the block.
    pub(super) start: usize,
    /// First sample of the next hit's block, or end of the segment.
    pub(super) limit: usize,
    /// Later half of the samples between the previous hit and the block.
    pub(super) pre_hit: Range<usize>,
    /// Baseline of every channel between hits.
    pub(super) baseline: Vec<f64>,
    pub(super) rejected: Option<RejectReason>,
}

pub(super) struct ImpactRecord<'a> {
    pub(super) rate_hz: f64,
    pub(super) channels: Vec<&'a [f64]>,
    pub(super) force_share: Option<f64>,
    pub(super) hits: Vec<HitBlock>,
}

impl ImpactRecord<'_> {
    /// Adds the hits of a segment.
    pub(super) fn add_hits(&mut self, segment: &Range<usize>, options: &ImpactOptions) {
        let detection = pulses_to(&self.channels[0][segment.clone()], options.both_signs);
        let level = |channel: &&[f64]| median(&channel[segment.clone()]);
        let mut baseline: Vec<f64> = self.channels.iter().map(level).collect();
        baseline[0] = detection.baseline;
        let max_gap = (options.bounce_time_s * self.rate_hz) as usize;
        let first_hit = self.hits.len();
        let mut pulses = detection.pulses.into_iter().peekable();
        let mut previous_end = segment.start;
        while let Some(pulse) = pulses.next() {
            let mut group = vec![pulse];
            while let Some(next) = pulses.next_if(|p| {
                group
                    .last()
                    .is_some_and(|l| p.samples.start < l.samples.end + max_gap)
            }) {
                group.push(next);
            }
            let begin = segment.start + group[0].samples.start;
            let end = segment.start + group.last().map_or(0, |p| p.samples.end);
            sort_descending(&mut group, |a| a.height.abs());
            let is_double = group.get(1).is_some_and(|second| {
                second.height.abs() > DOUBLE_HIT_SHARE * group[0].height.abs()
            });
            let mut pulse = group.swap_remove(0);
            pulse.peak += segment.start;
            pulse.samples = begin..pulse.samples.end + segment.start;
            let lead = (2 * pulse.samples.len()).max(8);
            let start = begin.saturating_sub(lead).max(segment.start);
            self.hits.push(HitBlock {
                rejected: if is_double {
                    Some(RejectReason::Double)
                } else {
                    (begin == segment.start).then_some(RejectReason::LateStart)
                },
                pre_hit: previous_end.min(start)..start,
                start,
                limit: segment.end,
                baseline: baseline.clone(),
                pulse,
            });
            previous_end = end;
        }
        for index in first_hit + 1..self.hits.len() {
            self.hits[index - 1].limit = self.hits[index].start;
        }
        // The response to the previous hit may still decay: only the later half counts as noise.
        for hit in &mut self.hits[first_hit..] {
            hit.pre_hit.start += hit.pre_hit.len() / 2;
        }
    }

    /// Rejects clipped hits, also those rejected as double, since the height of a clipped pulse is unknown.
    pub(super) fn reject_overloads(&mut self, options: &ImpactOptions) {
        let limits: Vec<[Option<f64>; 2]> = (0..self.channels.len())
            .map(|channel| match options.both_signs {
                true => [None; 2],
                false => self.shared_extremes(channel),
            })
            .collect();
        let is_over = |channel: usize, samples: &[f64]| match options.overload.get(channel) {
            Some(Some(level)) => samples.iter().any(|x| x.abs() >= *level),
            _ => {
                let is_on_limit = |x: &f64| limits[channel].contains(&Some(*x));
                is_clipped(samples) || samples.iter().any(is_on_limit)
            }
        };
        for hit in &mut self.hits {
            let overlaps = |r: &Range<usize>| r.start < hit.limit && hit.start < r.end;
            let clipped = (0..self.channels.len()).find(|&channel| {
                let clipped_ranges = options.clipped.get(channel);
                clipped_ranges.is_some_and(|ranges| ranges.iter().any(overlaps))
                    || is_over(channel, &self.channels[channel][hit.start..hit.limit])
            });
            if let Some(channel) = clipped {
                hit.rejected = Some(RejectReason::Clipped(channel));
            }
        }
    }

    /// Smallest and largest value of a channel where it is a clipping limit: two or more hits reach it exactly, and one stays at it.
    ///
    /// Hits differ in strength, so that two equal peaks in a signal of many levels are no coincidence.
    fn shared_extremes(&self, channel: usize) -> [Option<f64>; 2] {
        let samples = self.channels[channel];
        let mut resolution = f64::INFINITY;
        for pair in samples.windows(2).filter(|pair| pair[0] != pair[1]) {
            resolution = resolution.min((pair[1] - pair[0]).abs());
        }
        let (low, high) = (samples.iter()).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
            (l.min(*x), h.max(*x))
        });
        let is_limit = |extreme: f64| {
            let stays = |block: &[f64]| block.windows(2).any(|p| p == [extreme; 2]);
            let blocks = || self.hits.iter().map(|hit| &samples[hit.start..hit.limit]);
            (extreme - self.hits[0].baseline[channel]).abs() > MIN_PEAK_LEVELS * resolution
                && blocks().filter(|b| b.contains(&extreme)).count() > 1
                && blocks().any(stays)
        };
        [low, high].map(|extreme| is_limit(extreme).then_some(extreme))
    }

    pub(super) fn accepted(&self) -> impl Iterator<Item = &HitBlock> {
        self.hits.iter().filter(|hit| hit.rejected.is_none())
    }

    /// Response of a channel less its baseline.
    pub(super) fn response(&self, channel: usize, hit: &HitBlock, range: Range<usize>) -> Vec<f64> {
        let level = hit.baseline[channel];
        let samples = &self.channels[channel][range];
        samples.iter().map(|x| x - level).collect()
    }

    /// Block length, samples, and decay rate of the exponential window, 1/s; rejects hits that do not fill the block.
    pub(super) fn choose_block(&mut self, options: &ImpactOptions) -> Result<(usize, f64), Error> {
        let noise: Vec<f64> = (0..self.channels.len())
            .map(|channel| self.noise(channel))
            .collect();
        let mut lengths: Vec<usize> = self.accepted().map(|hit| hit.limit - hit.start).collect();
        lengths.sort_unstable();
        // At least three quarters of the hits fill the block; the product of length and hits is maximal.
        let samples_used = |&index: &usize| lengths[index] * (lengths.len() - index);
        let Some(index) = (0..(lengths.len() / 4 + 1).min(lengths.len()))
            .rev()
            .max_by_key(samples_used)
        else {
            return Err(self.no_valid_hit());
        };
        let longest = lengths[index];
        let mut decay = 0;
        for hit in self.accepted() {
            for channel in 1..self.channels.len() {
                let response = self.response(channel, hit, hit.start..hit.limit);
                decay = decay.max(decay_length(&response, noise[channel]));
            }
        }
        let length = options.block.unwrap_or(if decay == 0 {
            longest
        } else {
            decay.saturating_mul(BLOCK_PER_DECAY).min(longest)
        });
        let block = match options.block {
            Some(n) => n,
            None => (16..=length.max(16))
                .rev()
                .find(|&n| next_fast_len(n) == n)
                .unwrap_or(16),
        };
        for hit in &mut self.hits {
            if hit.rejected.is_none() && hit.limit - hit.start < block {
                hit.rejected = Some(RejectReason::CutShort);
            }
        }
        if self.accepted().next().is_none() {
            return Err(self.no_valid_hit());
        }
        if let Some(end) = options.end {
            return Ok((block, -end.ln() * self.rate_hz / block as f64));
        }
        let mut end_ratio: f64 = 0.0;
        for hit in self.accepted() {
            for channel in 1..self.channels.len() {
                let response = self.response(channel, hit, hit.start..hit.start + block);
                let levels = levels(&response);
                let largest = levels.iter().copied().fold(0.0, f64::max);
                let last = levels.last().copied().unwrap_or(0.0);
                if last > NOISE_FACTOR * noise[channel] && largest > 0.0 {
                    end_ratio = end_ratio.max(last / largest);
                }
            }
        }
        let sigma = if end_ratio > END_LEVEL {
            (end_ratio / END_LEVEL).ln() * self.rate_hz / block as f64
        } else {
            0.0
        };
        Ok((block, sigma))
    }

    /// Least rms of a channel before a hit; 0 if too few samples precede every hit.
    fn noise(&self, channel: usize) -> f64 {
        let candidates = self
            .hits
            .iter()
            .filter(|c| c.pre_hit.len() >= MIN_NOISE_SAMPLES);
        let level = candidates
            .map(|hit| rms(&self.response(channel, hit, hit.pre_hit.clone())))
            .fold(f64::INFINITY, f64::min);
        if level.is_finite() { level } else { 0.0 }
    }

    fn no_valid_hit(&self) -> Error {
        let faults: Vec<RejectReason> = self.hits.iter().filter_map(|c| c.rejected).collect();
        let name = |channel: usize| match channel {
            0 => "the force".to_string(),
            _ => "a response".to_string(),
        };
        let mut reasons: Vec<(String, usize)> = Vec::new();
        for text in faults.iter().map(|f| f.description(name)) {
            match reasons.iter_mut().find(|r| r.0 == text) {
                Some(reason) => reason.1 += 1,
                None => reasons.push((text, 1)),
            }
        }
        let reasons: Vec<String> = (reasons.iter())
            .map(|(text, count)| format!("{count} × {text}"))
            .collect();
        let only = |label: &str| {
            faults.len() == self.hits.len() && faults.iter().all(|f| f.label() == label)
        };
        Error::new(
            Code::TooShort,
            format!(
                "all {} hits were rejected: {}",
                self.hits.len(),
                reasons.join(", ")
            ),
        )
        .with_hint(match () {
            () if only(RejectReason::LateStart.label()) => "record from before the hit; check with `geardyn check` whether the file contains frequency responses",
            () if only(RejectReason::Clipped(0).label()) => "measure again with a larger range, or hit more gently; equal peaks without flat tops are accepted with a stated overload level: --overload NAME=LEVEL",
            _ => "use a shorter block, or state the overload levels",
        })
    }
}
