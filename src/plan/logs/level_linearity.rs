//! Linearity by level of a record without hits: parts of different input level, H1 of each, and the shift of each mode between them.

use std::f64::consts::TAU;

use super::linearity::{LevelGroup, level_dependence};
use super::sample_blocks;
use crate::base::error::{Diagnostic, Error};
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::Complex;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::frf;
use crate::spectrum::spectra::Spectra;
use crate::spectrum::welch::{WelchEstimator, WelchOptions};

/// A record is cut into about so many parts of equal length.
const PARTS: usize = 8;

/// Blocks of a part, without overlap.
const BLOCKS_PER_PART: usize = 8;

/// The loudest part has at least so many times the rms input of the quietest.
const MIN_LEVEL_RATIO: f64 = 2.0;

/// Mean coherence over the half-power band, at the best output, below which a part says nothing of a mode.
const MIN_COHERENCE: f64 = 0.5;

/// Parts of a record with their samples; none crosses a gap or the end of a file.
fn parts(recording: &Recording) -> Vec<std::ops::Range<usize>> {
    let length = (recording.samples / PARTS).max(1);
    let of_segment = |segment: &std::ops::Range<usize>| {
        let count = segment.len() / length;
        let start = segment.start;
        (0..count).map(move |k| start + k * length..start + (k + 1) * length)
    };
    recording.segments.iter().flat_map(of_segment).collect()
}

/// Checks whether modes shift with the level of a noise or sweep input; `None` where the level varies by less than a factor of two, or
/// nothing shifts.
///
/// # Errors
/// The samples cannot be read.
pub fn check_record(
    recording: &Recording,
    input: usize,
    outputs: &[usize],
    modes: &[ModalParameters],
) -> Result<Option<Diagnostic>, Error> {
    let channels: Vec<&Channel> = std::iter::once(&input)
        .chain(outputs)
        .map(|&c| &recording.channels[c])
        .collect();
    let parts = parts(recording);
    let levels = levels(recording, &parts, channels[0])?;
    let low = levels.iter().copied().fold(f64::INFINITY, f64::min);
    let high = levels.iter().copied().fold(0.0, f64::max);
    let block = recording.samples / PARTS / BLOCKS_PER_PART;
    if modes.is_empty() || block < 64 || !(low > 0.0 && high >= MIN_LEVEL_RATIO * low) {
        return Ok(None);
    }
    let spectra = parts
        .iter()
        .map(|part| part_spectra(recording, part, &channels, block))
        .collect::<Result<Vec<_>, _>>()?;
    let values: Vec<Vec<Vec<Complex>>> = spectra.iter().map(responses).collect();
    let groups: Vec<LevelGroup> = (levels.iter().zip(&values))
        .map(|(level, value)| LevelGroup {
            level: *level,
            value,
        })
        .collect();
    let told = |mode: &&ModalParameters| spectra.iter().all(|s| is_coherent(s, mode));
    let modes: Vec<ModalParameters> = modes.iter().filter(told).cloned().collect();
    let lines = spectra.first().map_or(&[][..], |s| &s.frequency_hz);
    let what = "from parts of the record with an rms input of";
    let block_s = block as f64 / recording.rate_hz;
    let terms = |omega: f64, pole: Complex| averaged_terms(omega, pole, block_s);
    let unit = &channels[0].unit;
    Ok(level_dependence(
        lines,
        &groups,
        &modes,
        (what, unit),
        &terms,
    ))
}

/// `1/(jω − p)` and `1/(jω − p)²` as averaged blocks under a Hann window show them for white noise: transforms of `e^{pt}` and `t e^{pt}`
/// times the autocorrelation of the window, `(1 − x)(2 + cos 2πx)/3 + sin(2πx)/2π` with x = t over the length of a block.
fn averaged_terms(omega: f64, pole: Complex, block_s: f64) -> (Complex, Complex) {
    /// Of the trapezoidal rule; the integrand turns by less than a fiftieth of a radian between two.
    const POINTS: usize = 4096;
    /// `e^{−20}` is 2e-9.
    const DECAYS: f64 = 20.0;
    let end = block_s.min(DECAYS / pole.re.abs());
    let dt = end / POINTS as f64;
    let rate = pole - Complex::new(0.0, omega);
    let step = (rate * dt).exp();
    let (mut decay, mut first, mut second) = (
        Complex::new(1.0, 0.0),
        Complex::new(0.5, 0.0),
        Complex::new(0.0, 0.0),
    );
    for k in 1..=POINTS {
        decay *= step;
        let t = k as f64 * dt;
        let (x, half) = (t / block_s, if k == POINTS { 0.5 } else { 1.0 });
        let (sin, cos) = (TAU * x).sin_cos();
        let weight = half * ((1.0 - x) * (2.0 + cos) / 3.0 + sin / TAU);
        first += decay * weight;
        second += decay * weight * t;
    }
    (first * dt, second * dt)
}

/// Root mean square of the input in each part, its mean taken off.
fn levels(
    recording: &Recording,
    parts: &[std::ops::Range<usize>],
    input: &Channel,
) -> Result<Vec<f64>, Error> {
    let mut sums = vec![(0.0, 0.0, 0.0); parts.len()];
    recording.each_block(input, |start, samples, _| {
        for (k, x) in samples.iter().enumerate() {
            let at = parts.partition_point(|part| part.end <= start + k);
            if let Some(part) = parts.get(at).filter(|part| part.contains(&(start + k))) {
                let sum = &mut sums[at];
                *sum = (part.len() as f64, sum.1 + x, sum.2 + x * x);
            }
        }
    })?;
    let rms = |(n, sum, squares): (f64, f64, f64)| {
        let mean = sum / n;
        (squares / n - mean * mean).max(0.0).sqrt()
    };
    Ok(sums.into_iter().map(rms).collect())
}

/// Averaged spectra of one part.
fn part_spectra(
    recording: &Recording,
    part: &std::ops::Range<usize>,
    channels: &[&Channel],
    block: usize,
) -> Result<Spectra, Error> {
    let options = WelchOptions {
        block,
        ..WelchOptions::default()
    };
    let outputs: Vec<usize> = (1..channels.len()).collect();
    let pairs = frf::required_pairs(&[0], &outputs);
    let mut estimator = WelchEstimator::new(recording.rate_hz, channels.len(), &pairs, &options)?;
    let only = Recording {
        segments: vec![part.clone()],
        ..recording.clone()
    };
    sample_blocks::for_each_block(&only, channels, |samples, _| estimator.push(samples))?;
    estimator.finish()
}

/// H1 of every output, by line.
fn responses(spectra: &Spectra) -> Vec<Vec<Complex>> {
    let input = &spectra.psd[0];
    let h1 = |cross: &Vec<Complex>| cross.iter().zip(input).map(|(c, x)| c / *x).collect();
    spectra.cross.iter().map(|c| h1(&c.values)).collect()
}

/// Whether an output is coherent with the input over the half-power band of a mode.
fn is_coherent(spectra: &Spectra, mode: &ModalParameters) -> bool {
    let half_width = mode.pole.re.abs();
    let near = |k: &usize| (TAU * spectra.frequency_hz[*k] - mode.pole.im).abs() <= half_width;
    let lines: Vec<usize> = (0..spectra.frequency_hz.len()).filter(near).collect();
    spectra.cross.iter().any(|cross| {
        let (x, y) = cross.pair;
        let coherence = lines
            .iter()
            .map(|&k| cross.values[k].norm_sqr() / (spectra.psd[x][k] * spectra.psd[y][k]));
        coherence.sum::<f64>() >= MIN_COHERENCE * lines.len().max(1) as f64
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A resonance at `f` under noise of standard deviation `level`, by exact steps of a piecewise constant force.
    fn ring(f: f64, level: f64, samples: usize, seed: u64) -> (Vec<f64>, Vec<f64>) {
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

    fn checked(shift: f64, ratio: f64, seed: u64) -> Option<Diagnostic> {
        const N: usize = 65_536;
        let (mut force, mut motion) = ring(60.0, 1.0, N, seed);
        let (loud, louder) = ring(60.0 * (1.0 + shift), ratio, N, seed + 1);
        force.extend(loud);
        motion.extend(louder);
        let channels: [(&str, &str, &[f64]); 2] = [("f", "N", &force), ("a", "m/s²", &motion)];
        let mut recording = Recording::from_arrays(512.0, &channels).unwrap();
        recording.segments = vec![0..N, N..2 * N];
        recording.segment_starts = vec![0.0; 2];
        let f = 60.0 * (1.0 + 0.5 * shift);
        let mode = ModalParameters {
            pole: Complex::new(-0.01 * TAU * f, TAU * f),
            pole_covariance: None,
            shape: Vec::new(),
        };
        check_record(&recording, 0, &[1], &[mode]).unwrap()
    }

    /// A frequency that falls by 0.2 % where the force is three times as large: the mean of twelve records, and their intervals.
    #[test]
    fn exact_shift_between_two_levels() {
        let found: Vec<(f64, f64)> = (1..=12)
            .map(|seed| {
                let message = checked(-0.002, 3.0, 10 * seed).unwrap().message;
                let percent = message.split("falls by ").nth(1).unwrap();
                let mut numbers = percent.trim_end_matches(" %").split(" ± ");
                let mut next = || numbers.next().unwrap().parse::<f64>().unwrap();
                (next(), next())
            })
            .collect();
        let mean = found.iter().map(|f| f.0).sum::<f64>() / 12.0;
        let held = found.iter().filter(|f| (f.0 - 0.2).abs() <= f.1).count();
        assert!(
            (mean - 0.2).abs() < 0.01 && held >= 10,
            "{mean} {held} {found:?}"
        );
    }

    /// Nothing is reported of a linear resonance, nor of levels that are alike.
    #[test]
    fn law_linear_records_are_linear() {
        let alarms = (1..=20).filter(|seed| checked(0.0, 3.0, 10 * seed).is_some());
        assert!(alarms.count() <= 1);
        assert!(checked(-0.005, 1.5, 1).is_none());
    }
}
