//! Samples of the requested channels: validated, longest segment, decimated to the band.

use super::sample_blocks;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::recording::channel_names;
use crate::recording::preprocess::unknown_channel;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::decimate::{DecimationOptions, decimate};

/// Channels of one segment, whole in memory.
#[derive(Debug)]
pub struct SegmentSamples {
    /// Samples by channel.
    pub samples: Vec<Vec<f64>>,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Description of the preparation, as text.
    pub method_text: String,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// The top of the band as a share of the rate after decimation: the edge of the filter's pass band.
const PASS_BAND_SHARE: f64 = 0.4;

/// The place of each channel named.
///
/// # Errors
/// `no-channel`.
pub fn channel_indices(recording: &Recording, words: &[String]) -> Result<Vec<usize>, Error> {
    let known: Vec<String> = recording.channels.iter().map(|c| c.name.clone()).collect();
    words
        .iter()
        .map(|word| {
            channel_names::find_channel(word, &known).ok_or_else(|| unknown_channel(word, &known))
        })
        .collect()
}

/// Sizes whose squares, summed over any log and multiplied with each other, neither overflow nor vanish.
const AMPLITUDE_RANGE: (f64, f64) = (1e-60, 1e60);

/// Refuses channels named twice, without signal, of a size that cannot be squared, or with one signal under two names.
///
/// # Errors
/// `conflict`, `no-signal`, `out-of-range`; samples that cannot be read.
pub fn check_channels(
    recording: &Recording,
    inputs: &[usize],
    outputs: &[usize],
) -> Result<(), Error> {
    let chosen: Vec<usize> = inputs.iter().chain(outputs).copied().collect();
    let name = |at: usize| recording.channels[at].name.as_str();
    for (k, &at) in chosen.iter().enumerate() {
        if chosen[..k].contains(&at) {
            let (message, hint) = match inputs.contains(&at) && outputs.contains(&at) {
                true => (
                    format!("{} is named as input and as output", name(at)),
                    "a response of a channel to itself is 1 at every frequency",
                ),
                false => (
                    format!("{} is named twice", name(at)),
                    "name each channel once",
                ),
            };
            return Err(Error::new(Code::Conflict, message).with_hint(hint));
        }
    }
    let channels: Vec<&Channel> = chosen.iter().map(|&c| &recording.channels[c]).collect();
    let mut ranges = vec![(f64::INFINITY, f64::NEG_INFINITY); channels.len()];
    let pairs: Vec<(usize, usize)> = (0..inputs.len())
        .flat_map(|i| (inputs.len()..chosen.len()).map(move |o| (i, o)))
        .collect();
    let mut is_same = vec![true; pairs.len()];
    let mut related = vec![PairSums::default(); pairs.len()];
    sample_blocks::for_each_block(recording, &channels, |block, _| {
        for (range, samples) in ranges.iter_mut().zip(block) {
            *range = samples
                .iter()
                .fold(*range, |(l, h), &x| (l.min(x), h.max(x)));
        }
        for (same, &(i, o)) in is_same.iter_mut().zip(&pairs) {
            *same = *same && block[i] == block[o];
        }
        for (sums, &(i, o)) in related.iter_mut().zip(&pairs) {
            sums.add(block[i], block[o]);
        }
    })?;
    for (&at, &(low, high)) in chosen.iter().zip(&ranges) {
        let largest = low.abs().max(high.abs());
        if largest > AMPLITUDE_RANGE.1 || (largest > 0.0 && largest < AMPLITUDE_RANGE.0) {
            let message = format!(
                "{} reaches {largest:.3e}: its power cannot be formed in double precision",
                name(at)
            );
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("check the unit of the channel, or state another in the sidecar"));
        }
        if low >= high {
            let message = format!("{} is {low} in every sample", name(at));
            return Err(Error::new(Code::NoSignal, message).with_hint(
                "a constant signal has no dynamics: check whether the sensor was connected",
            ));
        }
    }
    if let Some(at) = is_same.iter().position(|same| *same) {
        let (i, o) = (name(chosen[pairs[at].0]), name(chosen[pairs[at].1]));
        let message = format!("{i} and {o} are equal sample by sample");
        return Err(Error::new(Code::Conflict, message)
            .with_hint("check whether one signal was recorded under two names"));
    }
    for (sums, &(i, o)) in related.iter().zip(&pairs) {
        if let Some((factor, offset)) = sums.regression_line() {
            let (i, o) = (name(chosen[i]), name(chosen[o]));
            let message = format!(
                "{o} is {factor:.6} times {i} plus {offset:.6} sample by sample: their relation has no dynamics"
            );
            return Err(Error::new(Code::Conflict, message)
                .with_hint("check whether one signal was recorded under two names, or one computed from the other"));
        }
    }
    Ok(())
}

/// Sums of two signals x and y less their first samples: count, x, y, xx, xy, yy.
#[derive(Clone, Default)]
struct PairSums {
    first: Option<(f64, f64)>,
    sums: [f64; 6],
}

impl PairSums {
    fn add(&mut self, x: &[f64], y: &[f64]) {
        let Some((&x0, &y0)) = x.first().zip(y.first()) else {
            return;
        };
        let (x0, y0) = *self.first.get_or_insert((x0, y0));
        for (x, y) in x.iter().zip(y) {
            let (x, y) = (x - x0, y - y0);
            let terms = [1.0, x, y, x * x, x * y, y * y];
            (self.sums.iter_mut().zip(terms)).for_each(|(s, t)| *s += t);
        }
    }

    /// Slope and offset of y over x, where nothing else is in y.
    fn regression_line(&self) -> Option<(f64, f64)> {
        /// Relative rounding residual of y: samples as text have nine digits or more.
        const ROUNDING_RESIDUAL: f64 = 1e-14;
        let (x0, y0) = self.first?;
        let [n, x, y, xx, xy, yy] = self.sums;
        let (xx, xy, yy) = (xx - x * x / n, xy - x * y / n, yy - y * y / n);
        let slope = xy / xx;
        let left = yy - slope * xy;
        (n > 2.0 && left <= ROUNDING_RESIDUAL * yy)
            .then(|| (slope, y0 - slope * x0 + (y - slope * x) / n))
    }
}

/// The longest segment of the channels, decimated where the band asks for it.
///
/// # Errors
/// More samples than can be held at once; a band beyond half the rate.
pub fn load_segment(
    recording: &Recording,
    places: &[usize],
    band_hz: Option<(f64, f64)>,
    what: &str,
) -> Result<SegmentSamples, Error> {
    let channels: Vec<&Channel> = places.iter().map(|&c| &recording.channels[c]).collect();
    let mut samples = sample_blocks::load_channels(recording, &channels, what)?;
    let rate = recording.rate_hz;
    let mut diagnostics = Vec::new();
    let longest = recording.segments.iter().max_by_key(|s| s.len()).cloned();
    if let Some(segment) = longest.filter(|s| s.len() < recording.samples) {
        let file = recording.sample_time(segment.start).file;
        let message = format!(
            "{what} uses the longest segment without a gap: {:.4} s{} of {:.4} s",
            segment.len() as f64 / rate,
            file.as_ref()
                .map_or(String::new(), |f| format!(", of {f},")),
            recording.duration_s()
        );
        diagnostics.push(Diagnostic {
            code: "one-segment",
            message,
            hint: Some(
                match file {
                    Some(_) => "the other files are not used: identify them separately and compare",
                    None => "interpolate short gaps: --fill-gaps",
                }
                .to_string(),
            ),
        });
        samples
            .iter_mut()
            .for_each(|s| *s = s[segment.clone()].to_vec());
    }
    let factor = match band_hz {
        Some((_, top)) if top > rate / 2.0 => {
            let message = format!(
                "the band reaches up to {top} Hz; the sample rate of {rate} Hz limits it to {} Hz",
                rate / 2.0
            );
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("lower the top of the band: --band"));
        }
        Some((_, top)) => ((PASS_BAND_SHARE * rate / top).floor() as usize).max(1),
        None => 1,
    };
    let mut how = format!(
        "{} samples of {} at {rate:.4} Hz",
        samples.first().map_or(0, Vec::len),
        match places.len() {
            1 => "1 channel".to_string(),
            n => format!("{n} channels"),
        }
    );
    if factor > 1 {
        samples = samples
            .iter()
            .map(|s| decimate(s, factor, DecimationOptions::default()))
            .collect::<Result<_, Error>>()?;
        how += &format!(
            ", decimated by {factor} to {:.4} Hz for the band",
            rate / factor as f64
        );
    }
    Ok(SegmentSamples {
        samples,
        rate_hz: rate / factor as f64,
        method_text: how,
        diagnostics,
    })
}
