//! Hits cut out of a record: those that fail are set aside, and the block that the others fill.

use std::ops::Range;

use super::decay::{NOISE_FACTOR, decay_length, levels, rms};
use super::{ImpactOptions, MIN_NOISE_SAMPLES, RejectReason};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::fft::next_fast_len;
use crate::numeric::sorting::sort_falling;
use crate::spectrum::force_pulses::{ForcePulse, is_clipped, median, pulses_to};

/// A second pulse of this share of the first makes a hit double.
const DOUBLE_HIT_SHARE: f64 = 0.1;

/// An exponential window brings what is left at the end of the block down to this share.
const END_LEVEL: f64 = 0.01;

/// A peak of so many steps of resolution is not met twice by chance: of two peaks within 10 % less often than once in 400.
const MIN_PEAK_LEVELS: f64 = 4096.0;

/// Block length over the time for which the response exceeds the noise: what lies below the noise of one sample still counts in the sum
/// over many, and cutting it off biases the low modes.
const BLOCK_PER_DECAY: usize = 3;

/// A hit with its surroundings, in samples of the record.
pub(super) struct HitBlock {
    pub(super) pulse: ForcePulse,
    /// First sample of the block.
    pub(super) start: usize,
    /// First sample of the next hit's block, or end of the segment.
    pub(super) limit: usize,
    /// Before the block, back to the last hit.
    pub(super) quiet: Range<usize>,
    /// Level of every channel between hits.
    pub(super) baseline: Vec<f64>,
    pub(super) rejected: Option<RejectReason>,
}

pub(super) struct ImpactRecord<'a> {
    pub(super) rate_hz: f64,
    pub(super) channels: Vec<&'a [f64]>,
    pub(super) force_share: Option<f64>,
    pub(super) cuts: Vec<HitBlock>,
}

impl ImpactRecord<'_> {
    /// Adds the hits of a segment.
    pub(super) fn cut(&mut self, segment: &Range<usize>, options: &ImpactOptions) {
        let found = pulses_to(&self.channels[0][segment.clone()], options.both_sides);
        let level = |channel: &&[f64]| median(&channel[segment.clone()]);
        let mut baseline: Vec<f64> = self.channels.iter().map(level).collect();
        baseline[0] = found.baseline;
        let apart = (options.double_within_s * self.rate_hz) as usize;
        let first = self.cuts.len();
        let mut strokes = found.pulses.into_iter().peekable();
        let mut quiet_from = segment.start;
        while let Some(pulse) = strokes.next() {
            let mut stroke = vec![pulse];
            while let Some(next) = strokes.next_if(|p| {
                stroke
                    .last()
                    .is_some_and(|l| p.samples.start < l.samples.end + apart)
            }) {
                stroke.push(next);
            }
            let begin = segment.start + stroke[0].samples.start;
            let end = segment.start + stroke.last().map_or(0, |p| p.samples.end);
            sort_falling(&mut stroke, |a| a.height.abs());
            let is_double = stroke.get(1).is_some_and(|second| {
                second.height.abs() > DOUBLE_HIT_SHARE * stroke[0].height.abs()
            });
            let mut pulse = stroke.swap_remove(0);
            pulse.peak += segment.start;
            pulse.samples = begin..pulse.samples.end + segment.start;
            let lead = (2 * pulse.samples.len()).max(8);
            let start = begin.saturating_sub(lead).max(segment.start);
            self.cuts.push(HitBlock {
                rejected: if is_double {
                    Some(RejectReason::Double)
                } else {
                    (begin == segment.start).then_some(RejectReason::LateStart)
                },
                quiet: quiet_from.min(start)..start,
                start,
                limit: segment.end,
                baseline: baseline.clone(),
                pulse,
            });
            quiet_from = end;
        }
        for at in first + 1..self.cuts.len() {
            self.cuts[at - 1].limit = self.cuts[at].start;
        }
        // What still rings from the hit before is no noise: the later half of the quiet counts.
        for cut in &mut self.cuts[first..] {
            cut.quiet.start += cut.quiet.len() / 2;
        }
    }

    /// Sets clipped hits aside: a bounce of a clipped force is judged by a height that is not its own.
    pub(super) fn reject_overloads(&mut self, options: &ImpactOptions) {
        let limits: Vec<[Option<f64>; 2]> = (0..self.channels.len())
            .map(|at| match options.both_sides {
                true => [None; 2],
                false => self.shared_extremes(at),
            })
            .collect();
        let is_over = |at: usize, samples: &[f64]| match options.overload.get(at) {
            Some(Some(level)) => samples.iter().any(|x| x.abs() >= *level),
            _ => {
                let is_on_limit = |x: &f64| limits[at].contains(&Some(*x));
                is_clipped(samples) || samples.iter().any(is_on_limit)
            }
        };
        for cut in &mut self.cuts {
            let is_known = |r: &Range<usize>| r.start < cut.limit && cut.start < r.end;
            let clipped = (0..self.channels.len()).find(|&at| {
                let known = options.clipped.get(at);
                known.is_some_and(|ranges| ranges.iter().any(is_known))
                    || is_over(at, &self.channels[at][cut.start..cut.limit])
            });
            if let Some(at) = clipped {
                cut.rejected = Some(RejectReason::Clipped(at));
            }
        }
    }

    /// Largest and smallest value of a channel where it is a limit: two hits and more end at it exactly, and one rests on it.
    ///
    /// Hits differ in strength, so that in a signal of many levels no two have the same peak by chance.
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
            let rests = |block: &[f64]| block.windows(2).any(|p| p == [extreme; 2]);
            let blocks = || self.cuts.iter().map(|cut| &samples[cut.start..cut.limit]);
            (extreme - self.cuts[0].baseline[channel]).abs() > MIN_PEAK_LEVELS * resolution
                && blocks().filter(|b| b.contains(&extreme)).count() > 1
                && blocks().any(rests)
        };
        [low, high].map(|extreme| is_limit(extreme).then_some(extreme))
    }

    pub(super) fn accepted(&self) -> impl Iterator<Item = &HitBlock> {
        self.cuts.iter().filter(|cut| cut.rejected.is_none())
    }

    /// A response about its level.
    pub(super) fn response(&self, channel: usize, cut: &HitBlock, range: Range<usize>) -> Vec<f64> {
        let level = cut.baseline[channel];
        let samples = &self.channels[channel][range];
        samples.iter().map(|x| x - level).collect()
    }

    /// The block's length, and the rate of the exponential window it needs; hits that do not fill it are set aside.
    pub(super) fn choose_block(&mut self, options: &ImpactOptions) -> Result<(usize, f64), Error> {
        let noise: Vec<f64> = (0..self.channels.len())
            .map(|channel| self.noise(channel))
            .collect();
        let mut free: Vec<usize> = self.accepted().map(|cut| cut.limit - cut.start).collect();
        free.sort_unstable();
        // So long that three quarters of the hits fill it at least, by the largest product of length and hits.
        let worth = |&at: &usize| free[at] * (free.len() - at);
        let Some(at) = (0..(free.len() / 4 + 1).min(free.len()))
            .rev()
            .max_by_key(worth)
        else {
            return Err(self.no_valid_hit());
        };
        let most = free[at];
        let mut decayed = 0;
        for cut in self.accepted() {
            for channel in 1..self.channels.len() {
                let response = self.response(channel, cut, cut.start..cut.limit);
                decayed = decayed.max(decay_length(&response, noise[channel]));
            }
        }
        let wanted = options.block.unwrap_or(if decayed == 0 {
            most
        } else {
            decayed.saturating_mul(BLOCK_PER_DECAY).min(most)
        });
        let block = match options.block {
            Some(n) => n,
            None => (16..=wanted.max(16))
                .rev()
                .find(|&n| next_fast_len(n) == n)
                .unwrap_or(16),
        };
        for cut in &mut self.cuts {
            if cut.rejected.is_none() && cut.limit - cut.start < block {
                cut.rejected = Some(RejectReason::CutShort);
            }
        }
        if self.accepted().next().is_none() {
            return Err(self.no_valid_hit());
        }
        if let Some(end) = options.end {
            return Ok((block, -end.ln() * self.rate_hz / block as f64));
        }
        let mut left: f64 = 0.0;
        for cut in self.accepted() {
            for channel in 1..self.channels.len() {
                let response = self.response(channel, cut, cut.start..cut.start + block);
                let levels = levels(&response);
                let largest = levels.iter().copied().fold(0.0, f64::max);
                let last = levels.last().copied().unwrap_or(0.0);
                if last > NOISE_FACTOR * noise[channel] && largest > 0.0 {
                    left = left.max(last / largest);
                }
            }
        }
        let sigma = if left > END_LEVEL {
            (left / END_LEVEL).ln() * self.rate_hz / block as f64
        } else {
            0.0
        };
        Ok((block, sigma))
    }

    /// The least root mean square of a channel before a hit; 0 where nothing is quiet.
    fn noise(&self, channel: usize) -> f64 {
        let before = self
            .cuts
            .iter()
            .filter(|c| c.quiet.len() >= MIN_NOISE_SAMPLES);
        let level = before
            .map(|cut| rms(&self.response(channel, cut, cut.quiet.clone())))
            .fold(f64::INFINITY, f64::min);
        if level.is_finite() { level } else { 0.0 }
    }

    fn no_valid_hit(&self) -> Error {
        let faults: Vec<RejectReason> = self.cuts.iter().filter_map(|c| c.rejected).collect();
        let name = |at: usize| match at {
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
        let all = |label: &str| {
            faults.len() == self.cuts.len() && faults.iter().all(|f| f.label() == label)
        };
        Error::new(
            Code::TooShort,
            format!(
                "none of {} hits is fit for use: {}",
                self.cuts.len(),
                reasons.join(", ")
            ),
        )
        .with_hint(match () {
            () if all(RejectReason::LateStart.label()) => "record from before the hit; check with `geardyn check` whether the file holds finished responses",
            () if all(RejectReason::Clipped(0).label()) => "measure again with a larger range, or hit more gently; where a channel only seems to clip, state its overload level: --overload NAME=LEVEL",
            _ => "a shorter block, or stated overload levels, let more of them through",
        })
    }
}
