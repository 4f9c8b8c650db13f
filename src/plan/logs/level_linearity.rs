//! Linearity check of a record without hits: H1 of segments of different input level, and the frequency shift of each mode between them.

use std::f64::consts::TAU;
use std::ops::Range;

use super::linearity::warning;
use super::sample_blocks;
use crate::base::error::{Diagnostic, Error};
use crate::identify::level_dependence::{LevelGroup, averaged_terms, level_dependence};
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::Complex;
use crate::recording::channel_statistics::standard_deviation;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::frf::{self, Estimator, FrfEstimate};
use crate::spectrum::welch::{WelchEstimator, WelchOptions};

/// Approximate number of segments of equal length in a record.
const SEGMENTS: usize = 8;

/// Blocks of a segment, without overlap: the largest number that resolves every mode, else the smallest.
const BLOCKS_PER_SEGMENT: [usize; 3] = [8, 4, 2];

/// Minimum block length, samples.
const MIN_BLOCK: usize = 64;

/// Minimum ratio of the highest to the lowest rms input of the segments.
const MIN_LEVEL_RATIO: f64 = 2.0;

/// Minimum mean coherence over the half-power band of a mode, at the most coherent output, in every segment.
const MIN_COHERENCE: f64 = 0.5;

/// Segments of equal length of a record, each a recording; none crosses a gap or the end of a file.
fn equal_segments(recording: &Recording) -> Vec<Recording> {
    let length = (recording.samples / SEGMENTS).max(1);
    let divide = |(segment, begin): (&Range<usize>, &f64)| {
        let (start, begin) = (segment.start, *begin);
        (0..segment.len() / length).map(move |k| Recording {
            segments: std::iter::once(start + k * length..start + (k + 1) * length).collect(),
            segment_starts: vec![begin + (k * length) as f64],
            ..recording.clone()
        })
    };
    let segments = recording.segments.iter().zip(&recording.segment_starts);
    segments.flat_map(divide).collect()
}

/// Warning of natural frequencies that shift with the level of a noise or sweep input; `None` where the level varies by less than a
/// factor of two, or no mode shifts.
///
/// # Errors
/// The samples cannot be read.
pub fn level_shift_warning(
    recording: &Recording,
    input: usize,
    outputs: &[usize],
    modes: &[ModalParameters],
) -> Result<Option<Diagnostic>, Error> {
    let block_length = |blocks: usize| recording.samples / SEGMENTS / blocks;
    let half_widths_hz = modes.iter().map(|m| m.pole.re.abs() / TAU);
    let narrowest_hz = half_widths_hz.fold(f64::INFINITY, f64::min);
    let resolves =
        |blocks: &&usize| block_length(**blocks) as f64 * narrowest_hz >= recording.rate_hz;
    let fewest = BLOCKS_PER_SEGMENT[BLOCKS_PER_SEGMENT.len() - 1];
    let n_blocks = BLOCKS_PER_SEGMENT.iter().find(resolves).copied();
    let block = block_length(n_blocks.unwrap_or(fewest));
    if modes.is_empty() || block < MIN_BLOCK {
        return Ok(None);
    }
    let channels: Vec<&Channel> = std::iter::once(&input)
        .chain(outputs)
        .map(|&c| &recording.channels[c])
        .collect();
    let segments = equal_segments(recording);
    let levels = (segments.iter())
        .map(|segment| standard_deviation(segment, channels[0]))
        .collect::<Result<Vec<f64>, _>>()?;
    let low = levels.iter().copied().fold(f64::INFINITY, f64::min);
    let high = levels.iter().copied().fold(0.0, f64::max);
    if !(low > 0.0 && high >= MIN_LEVEL_RATIO * low) {
        return Ok(None);
    }
    let estimates = (segments.iter())
        .map(|segment| responses(segment, &channels, block))
        .collect::<Result<Vec<_>, _>>()?;
    let values: Vec<Vec<Vec<Complex>>> = (estimates.iter())
        .map(|e| e.functions.iter().map(|f| f.values.clone()).collect())
        .collect();
    let groups: Vec<LevelGroup> = (levels.iter().zip(&values))
        .map(|(level, responses)| LevelGroup {
            level: *level,
            responses,
        })
        .collect();
    let is_determined = |mode: &&ModalParameters| estimates.iter().all(|e| is_coherent(e, mode));
    let modes: Vec<ModalParameters> = modes.iter().filter(is_determined).cloned().collect();
    let lines = estimates.first().map_or(&[][..], |e| &e.frequency_hz);
    let block_s = block as f64 / recording.rate_hz;
    let terms = |omega: f64, pole: Complex| averaged_terms(omega, pole, block_s);
    let dependence = level_dependence(lines, &groups, &modes, &terms);
    let origin = "from parts of the record with an rms input of";
    Ok(dependence.map(|shifts| warning(&shifts, origin, &channels[0].unit)))
}

/// H1 estimates from the first channel to the others.
fn responses(
    recording: &Recording,
    channels: &[&Channel],
    block: usize,
) -> Result<FrfEstimate, Error> {
    let options = WelchOptions {
        block,
        ..WelchOptions::default()
    };
    let outputs: Vec<usize> = (1..channels.len()).collect();
    let pairs = frf::required_pairs(&[0], &outputs);
    let mut estimator = WelchEstimator::new(recording.rate_hz, channels.len(), &pairs, &options)?;
    sample_blocks::for_each_block(recording, channels, |samples, _| estimator.push(samples))?;
    frf::estimate(&estimator.finish()?, &[0], &outputs, Estimator::H1)
}

/// Whether an output is coherent with the input over the half-power band of a mode.
fn is_coherent(estimate: &FrfEstimate, mode: &ModalParameters) -> bool {
    let half_width = mode.pole.re.abs();
    let near = |k: &usize| (TAU * estimate.frequency_hz[*k] - mode.pole.im).abs() <= half_width;
    let lines: Vec<usize> = (0..estimate.frequency_hz.len()).filter(near).collect();
    estimate.functions.iter().any(|f| {
        let sum: f64 = lines.iter().map(|&k| f.ordinary_coherence[k]).sum();
        sum >= MIN_COHERENCE * lines.len().max(1) as f64
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Force and response of a resonance at `f` under noise of standard deviation `level`, by exact steps of a piecewise constant force.
    fn noise_response(f: f64, level: f64, samples: usize, seed: u64) -> (Vec<f64>, Vec<f64>) {
        const RATE: f64 = 512.0;
        let pole = Complex::new(-0.01 * TAU * f, TAU * f);
        let step = (pole / RATE).exp();
        let mut random = fastrand::Rng::with_seed(seed * 7919);
        let (mut state, mut force, mut motion) = (Complex::new(0.0, 0.0), Vec::new(), Vec::new());
        for _ in 0..samples {
            let noise = (-2.0 * (1.0 - random.f64()).ln()).sqrt() * (TAU * random.f64()).cos();
            let u = level * noise;
            state = state * step + (step - 1.0) / pole * u;
            force.push(u);
            motion.push(state.im * TAU * f);
        }
        (force, motion)
    }

    fn shift_warning(shift: f64, ratio: f64, seed: u64) -> Option<Diagnostic> {
        shift_warning_of(65_536, shift, ratio, seed)
    }

    /// Warning of a record with `n` samples at each of two levels.
    fn shift_warning_of(n: usize, shift: f64, ratio: f64, seed: u64) -> Option<Diagnostic> {
        let (mut force, mut motion) = noise_response(60.0, 1.0, n, seed);
        let (loud_force, loud_motion) = noise_response(60.0 * (1.0 + shift), ratio, n, seed + 1);
        force.extend(loud_force);
        motion.extend(loud_motion);
        let channels: [(&str, &str, &[f64]); 2] = [("f", "N", &force), ("a", "m/s²", &motion)];
        let mut recording = Recording::from_arrays(512.0, &channels).unwrap();
        recording.segments = vec![0..n, n..2 * n];
        recording.segment_starts = vec![0.0; 2];
        let f = 60.0 * (1.0 + 0.5 * shift);
        let mode = ModalParameters {
            pole: Complex::new(-0.01 * TAU * f, TAU * f),
            pole_covariance: None,
            shape: Vec::new(),
        };
        level_shift_warning(&recording, 0, &[1], &[mode]).unwrap()
    }

    /// A frequency falls by 0.2 % under three times the force: mean over twelve records, and coverage of their intervals.
    #[test]
    fn exact_shift_between_two_levels() {
        let shifts: Vec<(f64, f64)> = (1..=12)
            .map(|seed| {
                let message = shift_warning(-0.002, 3.0, 10 * seed).unwrap().message;
                let percent = message.split("falls by ").nth(1).unwrap();
                let mut numbers = percent.trim_end_matches(" %").split(" ± ");
                let mut next = || numbers.next().unwrap().parse::<f64>().unwrap();
                (next(), next())
            })
            .collect();
        let mean = shifts.iter().map(|f| f.0).sum::<f64>() / 12.0;
        let covered = shifts.iter().filter(|f| (f.0 - 0.2).abs() <= f.1).count();
        assert!(
            (mean - 0.2).abs() < 0.01 && covered >= 10,
            "{mean} {covered} {shifts:?}"
        );
    }

    /// A record of half a minute, with few blocks per segment: a fall of 1 % gives a warning, a linear resonance none.
    #[test]
    fn law_short_records_tell_a_shift() {
        let warnings =
            (1..=8).filter(|seed| shift_warning_of(8192, -0.01, 3.0, 10 * seed).is_some());
        let alarms = (1..=20).filter(|seed| shift_warning_of(8192, 0.0, 3.0, 10 * seed).is_some());
        assert!(warnings.count() >= 7 && alarms.count() <= 1);
    }

    /// A linear resonance gives no warning, nor do levels of a ratio below two.
    #[test]
    fn law_linear_records_are_linear() {
        let alarms = (1..=20).filter(|seed| shift_warning(0.0, 3.0, 10 * seed).is_some());
        assert!(alarms.count() <= 1);
        assert!(shift_warning(-0.005, 1.5, 1).is_none());
    }
}
