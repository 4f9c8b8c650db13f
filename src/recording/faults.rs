//! Sensor faults of a recording: clipped samples and stuck-at faults of its channels.

use std::ops::Range;

use super::clipping::{self, ClippingDetector};
use super::signals::Recording;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;

/// Overload recovery: samples rejected on each side of a clipped sample.
const RECOVERY: usize = 2;

/// Minimum length of a stuck-at run, in samples and as a share of the record.
const MIN_RUN: usize = 64;
const MIN_SHARE: f64 = 0.02;

/// Significance of a run: at most one by chance in e²⁰ records.
const MIN_NEG_LOG_PROBABILITY: f64 = 20.0;

/// Maximum share of repeated samples; above it a channel is a switch, a tacho or coarsely quantised, and is not judged.
const MAX_REPEAT_SHARE: f64 = 0.9;

/// Total share of runs from which a channel is at rest, unless it moves as usual up to the start of a run.
const MAX_REST_SHARE: f64 = 0.5;

/// Minimum ratio of the rms difference just before or after a stuck-at run to the usual one: a decay comes to rest slowly.
const MIN_JUMP_RATIO: f64 = 0.3;

/// Minimum ratio of the rms difference of another channel during a run to that outside it: the channel moves.
const MIN_MOTION_RATIO: f64 = 0.1;

/// Clipping of a channel.
#[derive(Debug, Clone, PartialEq)]
pub struct ClippedInterval {
    /// Index among the channels of the recording.
    pub channel: usize,
    /// Number of clipped peaks.
    pub tops: usize,
    /// Clipping level, in the unit of the channel.
    pub level: f64,
    /// Clipped sample ranges with their recovery; overlapping ranges are merged.
    pub ranges: Vec<Range<usize>>,
}

/// Stuck-at fault: interval of constant value of a channel.
#[derive(Debug, Clone, PartialEq)]
pub struct StuckInterval {
    /// Index among the channels of the recording.
    pub channel: usize,
    /// Constant value, in the unit of the channel.
    pub value: f64,
    /// Sample range of the interval.
    pub range: Range<usize>,
    /// True if another channel moves in the interval: the sensor failed.
    pub is_proven: bool,
}

/// Sensor faults of a recording.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Faults {
    /// Clipping, at most one entry per channel.
    pub clipped: Vec<ClippedInterval>,
    /// Stuck-at intervals, one entry per run.
    pub stuck: Vec<StuckInterval>,
}

/// Detects clipping of `inputs` and `outputs`, and stuck-at faults of `outputs`: an input may rest.
///
/// # Errors
/// The samples cannot be read.
pub fn find(recording: &Recording, inputs: &[usize], outputs: &[usize]) -> Result<Faults, Error> {
    let mut faults = Faults::default();
    for &channel in inputs.iter().chain(outputs) {
        let scan = scan(recording, channel)?;
        if scan.low >= scan.high {
            continue;
        }
        faults.clipped.extend(clipped(recording, channel, &scan)?);
        if outputs.contains(&channel) {
            faults.stuck.extend(stuck(recording, channel, &scan)?);
        }
    }
    for stuck in &mut faults.stuck {
        let others = inputs.iter().chain(outputs);
        for &other in others.filter(|&&other| other != stuck.channel) {
            let [rms_outside, rms_inside] = differences(recording, other, &stuck.range)?;
            stuck.is_proven |= rms_outside > 0.0 && rms_inside >= MIN_MOTION_RATIO * rms_outside;
        }
    }
    Ok(faults)
}

/// Detects stuck-at faults: constant intervals of channels that move before or after.
///
/// # Errors
/// The samples cannot be read.
pub fn find_stuck(recording: &Recording, channels: &[usize]) -> Result<Faults, Error> {
    let mut faults = Faults::default();
    for &channel in channels {
        let scan = scan(recording, channel)?;
        faults.stuck.extend(stuck(recording, channel, &scan)?);
    }
    Ok(faults)
}

/// Sample statistics of a channel.
struct ChannelScan {
    low: f64,
    high: f64,
    /// Smallest nonzero difference of neighbouring samples.
    resolution: f64,
    samples: usize,
    /// Number of samples equal to the previous one.
    repeats: usize,
    /// Range and value of each run of at least [`MIN_RUN`] equal samples.
    runs: Vec<(Range<usize>, f64)>,
}

fn scan(recording: &Recording, channel: usize) -> Result<ChannelScan, Error> {
    let mut scan = ChannelScan {
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
    recording.each_block(&recording.channels[channel], |offset, block, is_last| {
        for (k, &x) in block.iter().enumerate() {
            (scan.low, scan.high) = (scan.low.min(x), scan.high.max(x));
            scan.samples += 1;
            match &mut run {
                Some((range, value)) if *value == x => {
                    range.end += 1;
                    scan.repeats += 1;
                }
                _ => {
                    if let Some((_, value)) = &run {
                        scan.resolution = scan.resolution.min((x - value).abs());
                    }
                    close(&mut run, &mut scan.runs);
                    run = Some((offset + k..offset + k + 1, x));
                }
            }
        }
        if is_last {
            close(&mut run, &mut scan.runs);
        }
    })?;
    Ok(scan)
}

impl ChannelScan {
    /// Runs that are improbable by the share of repeated samples outside the long runs.
    fn stuck(&self, channel: usize, samples: usize) -> Vec<StuckInterval> {
        let shortest = MIN_RUN.max((MIN_SHARE * samples as f64) as usize);
        let long: Vec<_> = self.runs.iter().filter(|r| r.0.len() >= shortest).collect();
        let n_inside: usize = long.iter().map(|r| r.0.len()).sum();
        let n_outside = self.samples.saturating_sub(n_inside).max(1) as f64;
        let repeats = (self.repeats + long.len()).saturating_sub(n_inside) as f64;
        let share = (repeats / n_outside).max(1.0 / n_outside);
        let neg_log_probability = |length: usize| -(length as f64) * share.ln() - n_outside.ln();
        let is_stuck = |r: &&&(Range<usize>, f64)| {
            share < MAX_REPEAT_SHARE && neg_log_probability(r.0.len()) > MIN_NEG_LOG_PROBABILITY
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

/// Clipping of a channel by its sample distribution or its stated overload level.
fn clipped(
    recording: &Recording,
    channel: usize,
    scan: &ChannelScan,
) -> Result<Option<ClippedInterval>, Error> {
    let mut extremes = ClippingDetector::new((scan.low, scan.high), scan.resolution);
    recording.each_block(&recording.channels[channel], |_, block, _| {
        extremes.push(block)
    })?;
    let stated = recording.channels[channel].overload_level;
    let by_shape = clipping::clipping_by_side(&extremes);
    let is_clipped = |x: f64| {
        stated.is_some_and(|level| x.abs() >= level)
            || by_shape.iter().flatten().any(|side| x == side.1)
    };
    let mut clipping = ClippedInterval {
        channel,
        tops: 0,
        level: f64::NAN,
        ranges: Vec::new(),
    };
    recording.each_block(&recording.channels[channel], |offset, block, _| {
        for (k, &x) in block.iter().enumerate().filter(|(_, x)| is_clipped(**x)) {
            let range = (offset + k).saturating_sub(RECOVERY)..offset + k + 1 + RECOVERY;
            match clipping.ranges.last_mut() {
                Some(last) if last.end >= range.start => last.end = range.end,
                _ => clipping.ranges.push(range),
            }
            if !(x.abs() < clipping.level.abs()) {
                clipping.level = x;
            }
        }
    })?;
    let tops = clipping::clipped_tops(&extremes).map_or(0, |tops| tops.0);
    clipping.tops = tops.max(if stated.is_some() {
        clipping.ranges.len()
    } else {
        0
    });
    Ok((clipping.tops > 0).then_some(clipping))
}

/// Root-mean-square differences of neighbouring samples outside and within a range, insensitive to drift.
fn differences(
    recording: &Recording,
    channel: usize,
    within: &Range<usize>,
) -> Result<[f64; 2], Error> {
    let mut sums = [(0.0, 0.0); 2];
    recording.each_block(&recording.channels[channel], |offset, block, _| {
        for (k, pair) in block.windows(2).enumerate() {
            let sum = &mut sums[usize::from(within.contains(&(offset + k)))];
            *sum = (sum.0 + (pair[1] - pair[0]).powi(2), sum.1 + 1.0);
        }
    })?;
    Ok(sums.map(|sum: (f64, f64)| (sum.0 / sum.1.max(1.0)).sqrt()))
}

/// Stuck-at runs of a channel: the channel moves as usual up to the start of the run, or from its end. If it rests for half of the
/// record or more, only motion before a run counts: a trigger channel rests until an event.
fn stuck(
    recording: &Recording,
    channel: usize,
    scan: &ChannelScan,
) -> Result<Vec<StuckInterval>, Error> {
    let mut intervals = scan.stuck(channel, recording.samples);
    let n_constant: usize = intervals.iter().map(|s| s.range.len()).sum();
    let is_at_rest = n_constant as f64 >= MAX_REST_SHARE * scan.samples as f64;
    let mut moving = Vec::new();
    for interval in &intervals {
        let Range { start, end } = interval.range;
        let [usual_rms, _] = differences(recording, channel, &interval.range)?;
        let neighbours = [
            start.saturating_sub(MIN_RUN)..start,
            end..(end + MIN_RUN).min(recording.samples),
        ];
        let mut rms: f64 = 0.0;
        for range in neighbours.into_iter().take(if is_at_rest { 1 } else { 2 }) {
            let mut block = vec![0.0; range.len()];
            recording.channels[channel]
                .samples
                .read(range.start, &mut block)?;
            let squares: f64 = block.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum();
            rms = rms.max((squares / block.len().max(1) as f64).sqrt());
        }
        moving.push(rms >= MIN_JUMP_RATIO * usual_rms);
    }
    let mut is_moving = moving.into_iter();
    intervals.retain(|_| is_moving.next().unwrap_or(false));
    Ok(intervals)
}

impl Faults {
    /// Sample ranges of proven stuck-at faults.
    pub fn stuck_ranges(&self) -> Vec<Range<usize>> {
        let proven = self.stuck.iter().filter(|s| s.is_proven);
        proven.map(|s| s.range.clone()).collect()
    }

    /// Clipped sample ranges of a channel, by index.
    pub fn clipped_ranges_of(&self, channel: usize) -> Vec<Range<usize>> {
        let intervals = self.clipped.iter().filter(|c| c.channel == channel);
        intervals.flat_map(|c| c.ranges.clone()).collect()
    }

    /// Clipped sample ranges of all channels.
    pub fn clipped_ranges(&self) -> Vec<Range<usize>> {
        self.clipped.iter().flat_map(|c| c.ranges.clone()).collect()
    }

    /// Warnings about stuck-at faults; `is_excluded`: proven intervals are not analysed.
    pub fn stuck_warnings(&self, recording: &Recording, is_excluded: bool) -> Vec<Diagnostic> {
        let warning = |s: &StuckInterval| {
            let channel = &recording.channels[s.channel];
            let (start, end) = (
                recording.sample_time(s.range.start),
                recording.sample_time(s.range.end - 1),
            );
            let file = start.file.map_or(String::new(), |f| format!(" of {f}"));
            let treated = match (is_excluded && s.is_proven, s.is_proven) {
                (true, _) => "; this time is left out",
                (false, true) => ", while another channel varies",
                (false, false) => "",
            };
            let message = format!(
                "{} holds {} {} from {:.4} to {:.4} s{file}, {:.1} % of the record{treated}",
                channel.name,
                s.value,
                channel.unit,
                start.time_s,
                end.time_s,
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

    /// Number of clipped peaks and level per channel, as text; `None` without clipping.
    pub fn clipping_text(&self, recording: &Recording) -> Option<String> {
        let text = |c: &ClippedInterval| {
            let channel = &recording.channels[c.channel];
            let unit = match channel.unit.as_str() {
                "" => String::new(),
                unit => format!(" {unit}"),
            };
            let times = pluralise(c.tops, "time");
            format!("{} clipped {times} at {:.4}{unit}", channel.name, c.level)
        };
        let texts: Vec<String> = self.clipped.iter().map(text).collect();
        (!texts.is_empty()).then(|| texts.join(", "))
    }
}

/// Recording without the excluded sample ranges; its segments end at them.
pub fn without(recording: &Recording, mut excluded: Vec<Range<usize>>) -> Recording {
    excluded.sort_by_key(|r| r.start);
    let (mut segments, mut starts) = (Vec::new(), Vec::new());
    for (segment, start) in recording.segments.iter().zip(&recording.segment_starts) {
        let mut push = |first: usize, end: usize| {
            if first < end {
                segments.push(first..end);
                starts.push(start + (first - segment.start) as f64);
            }
        };
        let mut first = segment.start;
        for range in &excluded {
            push(first, range.start.clamp(first, segment.end));
            first = first.max(range.end.min(segment.end));
        }
        push(first, segment.end);
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

    /// A channel is constant for a third of the record while the other moves; no fault where both rest or quantisation is coarse.
    #[test]
    fn exact_stuck() {
        let (moving, mut stuck) = (noise(1, 9000), noise(2, 9000));
        stuck[3000..6000].fill(77.0);
        let faults = find(&recorded(&[moving.clone(), stuck.clone()]), &[0], &[1]).unwrap();
        assert_eq!(faults.stuck.len(), 1);
        assert_eq!(faults.stuck[0].range, 3000..6000);
        assert!(faults.stuck[0].is_proven && faults.stuck[0].value == 77.0);
        // A permanent failure.
        stuck[2000..].fill(-12.0);
        let faults = find(&recorded(&[moving.clone(), stuck]), &[0], &[1]).unwrap();
        assert_eq!(faults.stuck.len(), 1);
        assert!(faults.stuck[0].is_proven && faults.stuck[0].range == (2000..9000));
        // A decay into the last digit and a rest before an event are no faults.
        let decay =
            |k: i32| (1e5 * (0.3 * f64::from(k)).sin() * (-4e-3 * f64::from(k)).exp()).round();
        let decay: Vec<f64> = (0..9000).map(decay).collect();
        let pre_trigger = [vec![0.0; 5000], moving[..4000].to_vec()].concat();
        for still in [decay, pre_trigger] {
            let faults = find(&recorded(&[moving.clone(), still]), &[0], &[1]).unwrap();
            assert_eq!(faults.stuck, []);
        }
        let coarse: Vec<f64> = (0..9000)
            .map(|k| (0.002 * f64::from(k)).sin().round())
            .collect();
        let faults = find(&recorded(&[moving, coarse]), &[0], &[1]).unwrap();
        assert_eq!(faults.stuck, []);
    }

    /// Segments end at exclusions and keep their time.
    #[test]
    fn exact_without() {
        let recording = recorded(&[noise(3, 100)]);
        let remaining = without(&recording, vec![90..120, 10..20, 15..30]);
        assert_eq!(remaining.segments, [0..10, 30..90]);
        assert_eq!(remaining.segment_starts, [0.0, 30.0]);
    }
}
