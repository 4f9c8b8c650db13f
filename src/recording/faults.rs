//! Faults of sensors within a recording: where a channel clipped, and where it was stuck.

use std::ops::Range;

use super::clipping::{self, ClippingDetector};
use super::signals::Recording;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;

/// Samples to either side of a clipped one that the sensor needs to recover.
const RECOVERY: usize = 2;

/// A run of equal samples shorter than this, in samples and as a share of the record, is not called stuck.
const MIN_RUN: usize = 64;
const MIN_SHARE: f64 = 0.02;

/// A run that chance makes less often than once in e²⁰ records.
const MAX_RUN_EXPONENT: f64 = 20.0;

/// Channels that repeat their last sample more often than this are switches, tachos or coarsely quantised, and are not judged.
const MAX_REPEAT_SHARE: f64 = 0.9;

/// Runs that together take this share of a record are the channel's rest, unless it moves as usual until one begins.
const MAX_REST_SHARE: f64 = 0.5;

/// Just before or after a run of a stuck sensor its differences are this share of the usual ones at least: what decays comes to rest slowly.
const MIN_JUMP_RATIO: f64 = 0.3;

/// Another channel moves during a run if its differences there are this share of those outside.
const MIN_MOTION_RATIO: f64 = 0.1;

/// Intervals in which a channel rested on its limit.
#[derive(Debug, Clone, PartialEq)]
pub struct ClippedInterval {
    /// Index among the channels of the recording.
    pub channel: usize,
    /// Number of clipped tops.
    pub tops: usize,
    /// The limit, in the unit of the channel.
    pub level: f64,
    /// Samples on a limit, runs that nearly touch joined.
    pub ranges: Vec<Range<usize>>,
}

/// Interval in which a channel held one value.
#[derive(Debug, Clone, PartialEq)]
pub struct StuckInterval {
    /// Index among the channels of the recording.
    pub channel: usize,
    /// The value, in the unit of the channel.
    pub value: f64,
    /// Sample range of the interval.
    pub range: Range<usize>,
    /// Another channel moved meanwhile: the sensor failed, not the motion.
    pub is_proven: bool,
}

/// Faults of some channels.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Faults {
    /// At most one for each channel.
    pub clipped: Vec<ClippedInterval>,
    /// Each run of its own.
    pub stuck: Vec<StuckInterval>,
}

/// Looks for clipping of `inputs` and `outputs`, and for stuck sensors among `outputs`: an input may rest.
///
/// # Errors
/// The samples cannot be read.
pub fn find(recording: &Recording, inputs: &[usize], outputs: &[usize]) -> Result<Faults, Error> {
    let mut found = Faults::default();
    for &channel in inputs.iter().chain(outputs) {
        let seen = scan(recording, channel)?;
        if seen.low >= seen.high {
            continue;
        }
        found.clipped.extend(clipped(recording, channel, &seen)?);
        if outputs.contains(&channel) {
            found.stuck.extend(stuck(recording, channel, &seen)?);
        }
    }
    for stuck in &mut found.stuck {
        let others = inputs.iter().chain(outputs);
        for &other in others.filter(|&&other| other != stuck.channel) {
            let [outside, inside] = differences(recording, other, &stuck.range)?;
            stuck.is_proven |= outside > 0.0 && inside >= MIN_MOTION_RATIO * outside;
        }
    }
    Ok(found)
}

/// Intervals in which the channels hold one value although they move before or after.
///
/// # Errors
/// The samples cannot be read.
pub fn find_stuck(recording: &Recording, channels: &[usize]) -> Result<Faults, Error> {
    let mut found = Faults::default();
    for &channel in channels {
        let seen = scan(recording, channel)?;
        found.stuck.extend(stuck(recording, channel, &seen)?);
    }
    Ok(found)
}

/// Statistics of one pass over a channel.
struct ChannelScan {
    low: f64,
    high: f64,
    /// The smallest step from one sample to the next that is none.
    resolution: f64,
    samples: usize,
    /// Samples equal to the one before.
    repeats: usize,
    /// Runs of [`MIN_RUN`] equal samples and more, and their value.
    runs: Vec<(Range<usize>, f64)>,
}

fn scan(recording: &Recording, channel: usize) -> Result<ChannelScan, Error> {
    let mut seen = ChannelScan {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
        resolution: f64::INFINITY,
        samples: 0,
        repeats: 0,
        runs: Vec::new(),
    };
    let mut run: Option<(Range<usize>, f64)> = None;
    let close = |run: &mut Option<(Range<usize>, f64)>, runs: &mut Vec<(Range<usize>, f64)>| {
        runs.extend(run.take().filter(|r| r.0.len() >= MIN_RUN));
    };
    recording.each_block(&recording.channels[channel], |at, block, ends| {
        for (k, &x) in block.iter().enumerate() {
            (seen.low, seen.high) = (seen.low.min(x), seen.high.max(x));
            seen.samples += 1;
            match &mut run {
                Some((range, value)) if *value == x => {
                    range.end += 1;
                    seen.repeats += 1;
                }
                _ => {
                    if let Some((_, value)) = &run {
                        seen.resolution = seen.resolution.min((x - value).abs());
                    }
                    close(&mut run, &mut seen.runs);
                    run = Some((at + k..at + k + 1, x));
                }
            }
        }
        if ends {
            close(&mut run, &mut seen.runs);
        }
    })?;
    Ok(seen)
}

impl ChannelScan {
    /// The runs that chance does not make, by how often the channel repeats its last sample outside of them.
    fn stuck(&self, channel: usize, samples: usize) -> Vec<StuckInterval> {
        let least = MIN_RUN.max((MIN_SHARE * samples as f64) as usize);
        let long: Vec<_> = self.runs.iter().filter(|r| r.0.len() >= least).collect();
        let inside: usize = long.iter().map(|r| r.0.len()).sum();
        let outside = self.samples.saturating_sub(inside).max(1) as f64;
        let repeats = (self.repeats + long.len()).saturating_sub(inside) as f64;
        let share = (repeats / outside).max(1.0 / outside);
        let surprise = |length: usize| -(length as f64) * share.ln() - outside.ln();
        let is_stuck = |r: &&&(Range<usize>, f64)| {
            share < MAX_REPEAT_SHARE && surprise(r.0.len()) > MAX_RUN_EXPONENT
        };
        let stuck = |r: &&(Range<usize>, f64)| StuckInterval {
            channel,
            value: r.1,
            range: r.0.clone(),
            is_proven: false,
        };
        long.iter().filter(is_stuck).map(stuck).collect()
    }
}

/// Clipping of a channel: what its samples show, or its stated overload level.
fn clipped(
    recording: &Recording,
    channel: usize,
    seen: &ChannelScan,
) -> Result<Option<ClippedInterval>, Error> {
    let mut extremes = ClippingDetector::new((seen.low, seen.high), seen.resolution);
    recording.each_block(&recording.channels[channel], |_, block, _| {
        extremes.push(block)
    })?;
    let stated = recording.channels[channel].overload_level;
    let by_shape = clipping::clipping_by_side(&extremes);
    let over = |x: f64| {
        stated.is_some_and(|level| x.abs() >= level)
            || by_shape.iter().flatten().any(|side| x == side.1)
    };
    let mut found = ClippedInterval {
        channel,
        tops: 0,
        level: f64::NAN,
        ranges: Vec::new(),
    };
    recording.each_block(&recording.channels[channel], |at, block, _| {
        for (k, &x) in block.iter().enumerate().filter(|(_, x)| over(**x)) {
            let own = (at + k).saturating_sub(RECOVERY)..at + k + 1 + RECOVERY;
            match found.ranges.last_mut() {
                Some(last) if last.end >= own.start => last.end = own.end,
                _ => found.ranges.push(own),
            }
            if !(x.abs() < found.level.abs()) {
                found.level = x;
            }
        }
    })?;
    let tops = clipping::clipped_tops(&extremes).map_or(0, |tops| tops.0);
    found.tops = tops.max(if stated.is_some() {
        found.ranges.len()
    } else {
        0
    });
    Ok((found.tops > 0).then_some(found))
}

/// Root mean squares of the differences from sample to sample, outside and within a range: a drift is no motion.
fn differences(
    recording: &Recording,
    channel: usize,
    within: &Range<usize>,
) -> Result<[f64; 2], Error> {
    let mut sums = [(0.0, 0.0); 2];
    recording.each_block(&recording.channels[channel], |at, block, _| {
        for (k, pair) in block.windows(2).enumerate() {
            let sum = &mut sums[usize::from(within.contains(&(at + k)))];
            *sum = (sum.0 + (pair[1] - pair[0]).powi(2), sum.1 + 1.0);
        }
    })?;
    Ok(sums.map(|sum: (f64, f64)| (sum.0 / sum.1.max(1.0)).sqrt()))
}

/// The runs of a channel that its sensor makes: the channel moves as usual until the run begins, or from its end on. Of what rests for
/// half of the record and more only motion before a run tells a sensor that failed from one that waits for an event.
fn stuck(
    recording: &Recording,
    channel: usize,
    seen: &ChannelScan,
) -> Result<Vec<StuckInterval>, Error> {
    let mut found = seen.stuck(channel, recording.samples);
    let held: usize = found.iter().map(|s| s.range.len()).sum();
    let rests = held as f64 >= MAX_REST_SHARE * seen.samples as f64;
    let mut moving = Vec::new();
    for stuck in &found {
        let Range { start, end } = stuck.range;
        let [usual, _] = differences(recording, channel, &stuck.range)?;
        let near = [
            start.saturating_sub(MIN_RUN)..start,
            end..(end + MIN_RUN).min(recording.samples),
        ];
        let mut level: f64 = 0.0;
        for range in near.into_iter().take(if rests { 1 } else { 2 }) {
            let mut block = vec![0.0; range.len()];
            recording.channels[channel]
                .samples
                .read(range.start, &mut block)?;
            let squares: f64 = block.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum();
            level = level.max((squares / block.len().max(1) as f64).sqrt());
        }
        moving.push(level >= MIN_JUMP_RATIO * usual);
    }
    let mut is_moving = moving.into_iter();
    found.retain(|_| is_moving.next().unwrap_or(false));
    Ok(found)
}

impl Faults {
    /// The samples of stuck sensors, where another channel proves them.
    pub fn stuck_ranges(&self) -> Vec<Range<usize>> {
        let proven = self.stuck.iter().filter(|s| s.is_proven);
        proven.map(|s| s.range.clone()).collect()
    }

    /// The samples at which a channel, by its index, clipped.
    pub fn clipped_ranges_of(&self, channel: usize) -> Vec<Range<usize>> {
        let own = self.clipped.iter().filter(|c| c.channel == channel);
        own.flat_map(|c| c.ranges.clone()).collect()
    }

    /// The samples at which any channel clipped.
    pub fn clipped_ranges(&self) -> Vec<Range<usize>> {
        self.clipped.iter().flat_map(|c| c.ranges.clone()).collect()
    }

    /// Warnings about stuck sensors; `is_left_out` where their time was not analysed.
    pub fn stuck_warnings(&self, recording: &Recording, is_left_out: bool) -> Vec<Diagnostic> {
        let warning = |s: &StuckInterval| {
            let channel = &recording.channels[s.channel];
            let (from, to) = (
                recording.moment(s.range.start),
                recording.moment(s.range.end - 1),
            );
            let file = from.file.map_or(String::new(), |f| format!(" of {f}"));
            let treated = match (is_left_out && s.is_proven, s.is_proven) {
                (true, _) => "; this time is left out",
                (false, true) => ", while another channel moves",
                (false, false) => "",
            };
            let message = format!(
                "{} holds {} {} from {:.4} to {:.4} s{file}, {:.1} % of the record{treated}",
                channel.name,
                s.value,
                channel.unit,
                from.time_s,
                to.time_s,
                100.0 * s.range.len() as f64 / recording.samples as f64
            );
            Diagnostic {
                code: "stuck",
                message: message.replace("  ", " "),
                hint: Some(
                    "check the sensor and its cable; leave the time out: --after, --before".into(),
                ),
            }
        };
        self.stuck.iter().map(warning).collect()
    }

    /// Number of times and level at which each channel clipped, as text; nothing where none did.
    pub fn clipped_in_words(&self, recording: &Recording) -> Option<String> {
        let one = |c: &ClippedInterval| {
            let channel = &recording.channels[c.channel];
            let unit = match channel.unit.as_str() {
                "" => String::new(),
                unit => format!(" {unit}"),
            };
            let times = pluralise(c.tops, "time");
            format!("{} clipped {times} at {:.4}{unit}", channel.name, c.level)
        };
        let all: Vec<String> = self.clipped.iter().map(one).collect();
        (!all.is_empty()).then(|| all.join(", "))
    }
}

/// The same recording without some samples: segments end there.
pub fn without(recording: &Recording, mut left_out: Vec<Range<usize>>) -> Recording {
    left_out.sort_by_key(|r| r.start);
    let (mut segments, mut starts) = (Vec::new(), Vec::new());
    for (segment, start) in recording.segments.iter().zip(&recording.segment_starts) {
        let mut keep = |from: usize, to: usize| {
            if from < to {
                segments.push(from..to);
                starts.push(start + (from - segment.start) as f64);
            }
        };
        let mut from = segment.start;
        for hole in &left_out {
            keep(from, hole.start.clamp(from, segment.end));
            from = from.max(hole.end.min(segment.end));
        }
        keep(from, segment.end);
    }
    Recording {
        segments,
        segment_starts: starts,
        ..recording.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recorded(channels: &[Vec<f64>]) -> Recording {
        let names: Vec<String> = (0..channels.len()).map(|k| format!("a{k}")).collect();
        let channels: Vec<(&str, &str, &[f64])> = (names.iter().zip(channels))
            .map(|(name, samples)| (name.as_str(), "g", samples.as_slice()))
            .collect();
        Recording::from_arrays(1000.0, &channels).unwrap()
    }

    fn noise(seed: u64, count: usize) -> Vec<f64> {
        let mut random = fastrand::Rng::with_seed(seed);
        (0..count)
            .map(|_| ((random.f64() - 0.5) * 1000.0).round())
            .collect()
    }

    /// A sensor that holds one value for a third of the record, while the other goes on; none where both rest, or where steps are coarse.
    #[test]
    fn exact_stuck() {
        let (moving, mut stuck) = (noise(1, 9000), noise(2, 9000));
        stuck[3000..6000].fill(77.0);
        let found = find(&recorded(&[moving.clone(), stuck.clone()]), &[0], &[1]).unwrap();
        assert_eq!(found.stuck.len(), 1);
        assert_eq!(found.stuck[0].range, 3000..6000);
        assert!(found.stuck[0].is_proven && found.stuck[0].value == 77.0);
        // One that fails for good.
        stuck[2000..].fill(-12.0);
        let found = find(&recorded(&[moving.clone(), stuck]), &[0], &[1]).unwrap();
        assert_eq!(found.stuck.len(), 1);
        assert!(found.stuck[0].is_proven && found.stuck[0].range == (2000..9000));
        // What decays into its last digit, and what rests before an event, is not stuck.
        let decay =
            |k: i32| (1e5 * (0.3 * f64::from(k)).sin() * (-4e-3 * f64::from(k)).exp()).round();
        let decay: Vec<f64> = (0..9000).map(decay).collect();
        let rest = [vec![0.0; 5000], moving[..4000].to_vec()].concat();
        for calm in [decay, rest] {
            let found = find(&recorded(&[moving.clone(), calm]), &[0], &[1]).unwrap();
            assert_eq!(found.stuck, []);
        }
        let coarse: Vec<f64> = (0..9000)
            .map(|k| (0.002 * f64::from(k)).sin().round())
            .collect();
        let found = find(&recorded(&[moving, coarse]), &[0], &[1]).unwrap();
        assert_eq!(found.stuck, []);
    }

    /// Segments end at what is left out, and keep their time.
    #[test]
    fn exact_without() {
        let recording = recorded(&[noise(3, 100)]);
        let kept = without(&recording, vec![90..120, 10..20, 15..30]);
        assert_eq!(kept.segments, [0..10, 30..90]);
        assert_eq!(kept.segment_starts, [0.0, 30.0]);
    }
}
