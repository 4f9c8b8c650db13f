//! FRFs from hammer hits: clipped, double and truncated hits rejected, the others averaged by H1.
//!
//! Halvorsen & Brown, Impulse technique for structural frequency response testing, Sound and Vibration 11 (1977), pp. 8–21. The
//! force is zeroed behind its pulse. Where a response has not decayed at the end of the block, `exp(−σt)` lies on force and
//! response alike: the response found is the structure's with every pole moved left by σ, exactly.

use std::f64::consts::PI;
use std::ops::Range;

use super::force_aliasing::PulseSampling;
use super::force_pulses::{ForcePulse, is_clipped, median, pulses_to};
use super::frf::{Estimator, FrfEstimate, estimate, required_pairs};
use super::spectra::{CrossSpectrum, Spectra};
use super::welch::{WelchEstimator, WelchOptions};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::{RealFft, next_fast_len};
use crate::numeric::sorting::sort_falling;

/// Options for extracting and accepting hits.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpactOptions {
    /// Samples of a block; `None`: until the responses have decayed, or the next hit.
    pub block: Option<usize>,
    /// Pulses closer than this are one stroke that bounced, s.
    pub double_within_s: f64,
    /// Share of the block over which the force is kept; `None`: the pulse and some widths behind it.
    pub force_share: Option<f64>,
    /// Final value of an exponential window on force and responses at the end of the block, 1 for none; `None`: as the responses need it.
    pub end: Option<f64>,
    /// Pulses to both sides count, as of the differences of a force that steps.
    pub both_sides: bool,
    /// Levels at which channels overload, force first; where `None` or missing, flat tops are looked for, and levels that hits share.
    pub overload: Vec<Option<f64>>,
    /// Samples known to be clipped, by channel, force first.
    pub clipped: Vec<Vec<Range<usize>>>,
}

impl Default for ImpactOptions {
    /// Blocks as the data want them; bounces within 0.1 s, sooner than a hand strikes again.
    fn default() -> ImpactOptions {
        ImpactOptions {
            block: None,
            double_within_s: 0.1,
            force_share: None,
            end: None,
            both_sides: false,
            overload: Vec::new(),
            clipped: Vec::new(),
        }
    }
}

/// Why a hit was set aside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RejectReason {
    /// The hammer struck twice.
    Double,
    /// A channel clipped: 0 is the force, 1, 2, … are the responses.
    Clipped(usize),
    /// The next hit, or the end of the segment, comes before the block is full.
    CutShort,
    /// The segment begins within the pulse.
    LateStart,
}

impl RejectReason {
    /// In one word or two.
    pub fn label(self) -> &'static str {
        match self {
            RejectReason::Double => "double",
            RejectReason::Clipped(_) => "clipped",
            RejectReason::CutShort => "cut short",
            RejectReason::LateStart => "begun late",
        }
    }

    /// In words, with the name of the channel that clipped.
    pub fn description(self, channel: impl Fn(usize) -> String) -> String {
        match self {
            RejectReason::Double => "the hammer struck twice".to_string(),
            RejectReason::Clipped(at) => format!("{} clipped", channel(at)),
            RejectReason::CutShort => {
                "the next hit or the end comes before the block is full".to_string()
            }
            RejectReason::LateStart => "the record begins within the pulse".to_string(),
        }
    }
}

/// One hit.
#[derive(Debug, Clone, PartialEq)]
pub struct Hit {
    /// Sample of its largest force.
    pub sample: usize,
    /// Largest force over the level between hits.
    pub peak: f64,
    /// Why it was set aside; `None` where it was used.
    pub rejected: Option<RejectReason>,
}

/// Frequency responses from hits.
#[derive(Debug, Clone)]
pub struct ImpactEstimate {
    /// Every hit, used or not.
    pub hits: Vec<Hit>,
    /// Samples of a block.
    pub block: usize,
    /// Power of the force by line, averaged over the hits used.
    pub force_power: Vec<f64>,
    /// Sampling of the pulses; a step is known between its samples as well, and counts as resolved.
    pub sampling: PulseSampling,
    /// The responses hit by hit, where there are several.
    pub by_hit: Vec<HitResponses>,
    /// Channel 0 is the force, 1, 2, … are the responses. With a single hit the variance is that of the noise before it, and there
    /// is no coherence. `window_decay` is σ.
    pub estimate: FrfEstimate,
}

/// Frequency responses to one hit, or to a few that follow each other where there are many.
#[derive(Debug, Clone, PartialEq)]
pub struct HitResponses {
    /// Places of the hits among all.
    pub hits: Vec<usize>,
    /// `Σ X* Y / Σ |X|²` over these hits, by response and line; zero where the force has no power.
    pub value: Vec<Vec<Complex>>,
}

/// Most responses hit by hit: more hits are joined to groups, alike in size to within one.
const MAX_BY_HIT: usize = 64;

/// Fewest groups of hits, however many responses there are: seven degrees of freedom of their scatter.
const MIN_GROUPS: usize = 8;

/// A second pulse of this share of the first makes a hit double.
const DOUBLE_HIT_SHARE: f64 = 0.1;

/// A response has decayed at this share of its beginning, or in the noise, whichever is larger.
const DECAY_LEVEL: f64 = 1e-3;

/// An exponential window brings what is left at the end of the block down to this share.
const END_LEVEL: f64 = 0.01;

/// The noise's level times this is still noise: of the root mean square of 20 samples or more, three times never happens.
const NOISE_FACTOR: f64 = 3.0;

/// A peak of so many steps of resolution is not met twice by chance: of two peaks within 10 % less often than once in 400.
const MIN_PEAK_LEVELS: f64 = 4096.0;

/// Segments of a decay whose levels are compared.
const DECAY_SEGMENTS: usize = 64;

/// Block length over the time for which the response exceeds the noise: what lies below the noise of one sample still counts in the sum
/// over many, and cutting it off biases the low modes.
const BLOCK_PER_DECAY: usize = 3;

/// Behind a pulse the force is kept for so many of its widths, and faded out over the next two.
const FORCE_WINDOW_WIDTHS: usize = 4;

/// Fewer samples before a hit do not tell its noise.
const MIN_NOISE_SAMPLES: usize = 32;

/// Frequency responses to the hits of `force`, over the segments of a record.
///
/// # Errors
/// `NoSignal`: no pulse in the force. `TooShort`: no hit fit for use, with the reason of each. `OutOfRange`: options that cannot be.
///
/// # Panics
/// Channels of unequal length, stretches beyond them: mistakes of the caller.
pub fn estimate_from_hits(
    rate_hz: f64,
    force: &[f64],
    responses: &[&[f64]],
    segments: &[Range<usize>],
    options: &ImpactOptions,
) -> Result<ImpactEstimate, Error> {
    if options.block.is_some_and(|n| n < 16) || options.double_within_s.is_nan() {
        return Err(Error::new(
            Code::OutOfRange,
            "a block of a hit needs 16 samples or more, and bounces a time",
        ));
    }
    let mut record = ImpactRecord {
        rate_hz,
        channels: std::iter::once(force)
            .chain(responses.iter().copied())
            .collect(),
        force_share: options.force_share,
        cuts: Vec::new(),
    };
    for segment in segments {
        record.cut(segment, options);
    }
    if record.cuts.is_empty() {
        return Err(
            Error::new(Code::NoSignal, "the force holds no hit").with_hint(
                "name the channel of the hammer's force, or estimate with a steady input instead",
            ),
        );
    }
    record.reject_overloads(options);
    let (block, sigma) = record.choose_block(options)?;
    let HitSums {
        mut estimate,
        force_power,
        by_hit,
    } = record.estimate(block, sigma)?;
    let sampling = match options.both_sides {
        true => PulseSampling::Resolved,
        false => PulseSampling::new(&force_power),
    };
    estimate.diagnostics.extend(sampling.warning(rate_hz));
    let hit = |cut: &HitBlock| Hit {
        sample: cut.pulse.peak,
        peak: cut.pulse.height,
        rejected: cut.rejected,
    };
    Ok(ImpactEstimate {
        hits: record.cuts.iter().map(hit).collect(),
        block,
        force_power,
        sampling,
        by_hit,
        estimate,
    })
}

/// Sums over all hits, and over each.
struct HitSums {
    estimate: FrfEstimate,
    force_power: Vec<f64>,
    by_hit: Vec<HitResponses>,
}

/// A hit with its surroundings, in samples of the record.
struct HitBlock {
    pulse: ForcePulse,
    /// First sample of the block.
    start: usize,
    /// First sample of the next hit's block, or end of the segment.
    limit: usize,
    /// Before the block, back to the last hit.
    quiet: Range<usize>,
    /// Level of every channel between hits.
    baseline: Vec<f64>,
    rejected: Option<RejectReason>,
}

struct ImpactRecord<'a> {
    rate_hz: f64,
    channels: Vec<&'a [f64]>,
    force_share: Option<f64>,
    cuts: Vec<HitBlock>,
}

impl ImpactRecord<'_> {
    /// Adds the hits of a segment.
    fn cut(&mut self, segment: &Range<usize>, options: &ImpactOptions) {
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
    fn reject_overloads(&mut self, options: &ImpactOptions) {
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

    fn accepted(&self) -> impl Iterator<Item = &HitBlock> {
        self.cuts.iter().filter(|cut| cut.rejected.is_none())
    }

    /// A response about its level.
    fn response(&self, channel: usize, cut: &HitBlock, range: Range<usize>) -> Vec<f64> {
        let level = cut.baseline[channel];
        let samples = &self.channels[channel][range];
        samples.iter().map(|x| x - level).collect()
    }

    /// The block's length, and the rate of the exponential window it needs; hits that do not fill it are set aside.
    fn choose_block(&mut self, options: &ImpactOptions) -> Result<(usize, f64), Error> {
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

    fn estimate(&self, block: usize, sigma: f64) -> Result<HitSums, Error> {
        let window: Vec<f64> = (0..block)
            .map(|j| (-sigma * j as f64 / self.rate_hz).exp())
            .collect();
        let mut fft = RealFft::new(block);
        let zero = Complex::new(0.0, 0.0);
        let mut lines = vec![vec![zero; fft.lines()]; self.channels.len()];
        let outputs: Vec<usize> = (1..self.channels.len()).collect();
        let hits = self.accepted().count();
        let mut spectra = Spectra {
            rate_hz: self.rate_hz,
            frequency_hz: (0..fft.lines())
                .map(|k| k as f64 * self.rate_hz / block as f64)
                .collect(),
            psd: vec![vec![0.0; fft.lines()]; self.channels.len()],
            cross: required_pairs(&[0], &outputs)
                .into_iter()
                .map(|pair| CrossSpectrum {
                    pair,
                    values: vec![zero; fft.lines()],
                })
                .collect(),
            bandwidth_hz: self.rate_hz / block as f64,
            blocks: hits,
            averages: Some(hits as f64),
            window_decay: sigma,
            window: None,
        };
        let groups = (MAX_BY_HIT / outputs.len().max(1))
            .max(MIN_GROUPS)
            .min(hits);
        let group = |nth: usize| nth * groups / hits;
        let mut by_hit: Vec<HitResponses> = Vec::new();
        let mut power = vec![0.0; fft.lines()];
        let places = (0..self.cuts.len()).filter(|&at| self.cuts[at].rejected.is_none());
        for (nth, place) in places.enumerate() {
            let cut = &self.cuts[place];
            let fade = force_window(cut, block, self.force_share);
            for (channel, lines) in lines.iter_mut().enumerate() {
                let mut samples = self.response(channel, cut, cut.start..cut.start + block);
                for j in 0..block {
                    samples[j] *= window[j] * if channel == 0 { fade[j] } else { 1.0 };
                }
                fft.forward(&mut samples, lines);
                let psd = spectra.psd[channel].iter_mut().zip(lines.iter());
                psd.for_each(|(s, x)| *s += x.norm_sqr() / hits as f64);
            }
            for CrossSpectrum {
                pair,
                values: value,
            } in &mut spectra.cross
            {
                let ends = lines[pair.0].iter().zip(&lines[pair.1]);
                for (s, (x, y)) in value.iter_mut().zip(ends) {
                    *s += x.conj() * y / hits as f64;
                }
            }
            if nth == 0 || group(nth) != group(nth - 1) {
                power.fill(0.0);
                by_hit.push(HitResponses {
                    hits: Vec::new(),
                    value: vec![vec![zero; fft.lines()]; outputs.len()],
                });
            }
            if let Some(own) = by_hit.last_mut() {
                own.add(place, &lines, &mut power);
                if nth + 1 == hits || group(nth + 1) != group(nth) {
                    own.divide(&power);
                }
            }
        }
        let mut found = estimate(&spectra, &[0], &outputs, Estimator::H1)?;
        if let (1, Some(cut)) = (hits, self.accepted().next()) {
            self.error_by_noise(cut, &window, &spectra, &mut found)?;
        }
        Ok(HitSums {
            estimate: found,
            force_power: spectra.psd.swap_remove(0),
            by_hit,
        })
    }

    /// The variance of a single hit's responses: `(E|N_y|² + |H|² E|N_f|²)/|F|²` by the noise before the hit, or, where the record
    /// begins too near it, by what is left once the responses have decayed.
    fn error_by_noise(
        &self,
        cut: &HitBlock,
        window: &[f64],
        spectra: &Spectra,
        found: &mut FrfEstimate,
    ) -> Result<(), Error> {
        let after = cut.start + window.len()..cut.limit;
        let quiet = if cut.quiet.len() >= MIN_NOISE_SAMPLES {
            cut.quiet.clone()
        } else if spectra.window_decay == 0.0 && after.len() >= MIN_NOISE_SAMPLES {
            after
        } else {
            return Ok(());
        };
        let samples: Vec<&[f64]> = self
            .channels
            .iter()
            .map(|channel| &channel[quiet.clone()])
            .collect();
        let mut estimator = WelchEstimator::new(
            self.rate_hz,
            samples.len(),
            &[],
            &WelchOptions {
                block: (quiet.len() / 8).clamp(MIN_NOISE_SAMPLES / 2, window.len()),
                ..WelchOptions::default()
            },
        )?;
        estimator.push(&samples);
        let noise_psd = estimator.finish()?;
        let energy: f64 = window.iter().map(|w| w * w).sum();
        let fade = force_window(cut, window.len(), self.force_share);
        let weights = window.iter().zip(&fade);
        let force_energy: f64 = weights.map(|(w, f)| (w * f).powi(2)).sum();
        let noise = |channel: usize, energy: f64, f: f64| {
            0.5 * self.rate_hz
                * energy
                * interpolate(&noise_psd.frequency_hz, &noise_psd.psd[channel], f)
        };
        for function in &mut found.functions {
            let error = |(line, h): (usize, &Complex)| {
                let f = spectra.frequency_hz[line];
                let variance =
                    noise(function.output, energy, f) + h.norm_sqr() * noise(0, force_energy, f);
                variance / spectra.psd[0][line]
            };
            let variance = function.values.iter().enumerate().map(error);
            function.variance = Some(variance.collect());
        }
        Ok(())
    }
}

impl HitResponses {
    /// Adds the transforms of a hit, force first; `power` sums that of the force.
    fn add(&mut self, place: usize, lines: &[Vec<Complex>], power: &mut [f64]) {
        self.hits.push(place);
        for (value, y) in self.value.iter_mut().zip(&lines[1..]) {
            for ((sum, x), y) in value.iter_mut().zip(&lines[0]).zip(y) {
                *sum += x.conj() * y;
            }
        }
        power
            .iter_mut()
            .zip(&lines[0])
            .for_each(|(p, x)| *p += x.norm_sqr());
    }

    fn divide(&mut self, power: &[f64]) {
        for (h, p) in self.value.iter_mut().flat_map(|v| v.iter_mut().zip(power)) {
            *h = if *p > 0.0 {
                *h / p
            } else {
                Complex::new(0.0, 0.0)
            };
        }
    }
}

/// Force window: one over the requested share, or over the pulse and some widths behind it, then a quarter of a cosine down to zero.
fn force_window(cut: &HitBlock, block: usize, share: Option<f64>) -> Vec<f64> {
    let width = cut.pulse.samples.len();
    let kept = match share {
        Some(share) => (share * block as f64) as usize,
        None => cut.pulse.samples.end - cut.start + FORCE_WINDOW_WIDTHS * width,
    };
    let fade = 2 * width;
    (0..block)
        .map(|j| {
            let x = j.saturating_sub(kept) as f64 / fade as f64;
            if x < 1.0 {
                (0.5 * PI * x).cos().powi(2)
            } else {
                0.0
            }
        })
        .collect()
}

/// Root mean squares of the segments of a decay.
/// Root mean square of up to 64 segments of equal length.
pub fn levels(samples: &[f64]) -> Vec<f64> {
    let segment = samples.len().div_ceil(DECAY_SEGMENTS).max(1);
    samples.chunks(segment).map(rms).collect()
}

fn rms(samples: &[f64]) -> f64 {
    (samples.iter().map(|x| x * x).sum::<f64>() / samples.len().max(1) as f64).sqrt()
}

/// Samples until a response stays in the noise, or below a thousandth of its largest level; all where it never does.
pub fn decay_length(samples: &[f64], noise: f64) -> usize {
    let levels = levels(samples);
    let largest = levels.iter().copied().fold(0.0, f64::max);
    let limit = (DECAY_LEVEL * largest).max(NOISE_FACTOR * noise);
    let segment = samples.len().div_ceil(DECAY_SEGMENTS).max(1);
    let last = levels.iter().rposition(|&level| level > limit);
    last.map_or(0, |at| ((at + 1) * segment).min(samples.len()))
}

/// Straight between the lines of a table.
fn interpolate(x: &[f64], y: &[f64], at: f64) -> f64 {
    let next = x.partition_point(|&x| x < at).clamp(1, x.len() - 1);
    let share = (at - x[next - 1]) / (x[next] - x[next - 1]);
    y[next - 1] + share * (y[next] - y[next - 1])
}
