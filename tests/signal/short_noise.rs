//! Noise on a structure, in records of few averages: intervals hold the poles of the system as often as they say.

use std::f64::consts::TAU;

use geardyn::IdentificationResult;
use geardyn::internals::identify::modal_parameters::ModalParameters;
use geardyn::internals::numeric::Complex;
use geardyn::prelude::*;

use crate::support::noise::normal;

/// Frequency, Hz, and damping ratio: half-power widths of 2.0 to 2.4 Hz.
const TRUTH: [(f64, f64); 4] = [
    (60.0, 0.020),
    (100.0, 0.010),
    (150.0, 0.0075),
    (220.0, 0.005),
];

const RATE_HZ: f64 = 1000.0;

/// Noise of each output over its standard deviation.
const NOISE: f64 = 0.01;

/// A record of a noise test.
#[derive(Clone, Copy, Debug)]
struct Test {
    seconds: f64,
    outputs: usize,
    /// Requested distance of lines, Hz; local parabolas by default.
    resolution_hz: Option<f64>,
}

fn record(test: Test, seed: u64) -> (Vec<f64>, Vec<Vec<f64>>) {
    let mut rng = fastrand::Rng::with_seed(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    // The structure rings before the record begins.
    let before = (3.0 * RATE_HZ) as usize;
    let n = (test.seconds * RATE_HZ) as usize;
    let input: Vec<f64> = (0..before + n).map(|_| normal(&mut rng)).collect();
    let mut outputs = vec![vec![0.0; n]; test.outputs];
    for (k, (f, d)) in TRUTH.into_iter().enumerate() {
        let w = TAU * f;
        let pole = Complex::new(-d * w, w * (1.0 - d * d).sqrt());
        let step = (pole / RATE_HZ).exp();
        let residue = Complex::new(0.0, -1.0) * d.sqrt();
        let mut state = Complex::new(0.0, 0.0);
        for (j, u) in input.iter().enumerate() {
            state = state * step + u;
            if j < before {
                continue;
            }
            let value = (residue * state).re;
            for (o, y) in outputs.iter_mut().enumerate() {
                let sign = if (o + k) % 2 == 0 { 1.0 } else { -1.0 };
                y[j - before] += sign * (1.0 + 0.5 * ((3 * o + 5 * k) as f64).sin()) * value;
            }
        }
    }
    for y in &mut outputs {
        let size = (y.iter().map(|y| y * y).sum::<f64>() / n as f64).sqrt();
        y.iter_mut()
            .for_each(|y| *y += NOISE * size * normal(&mut rng));
    }
    (input[before..].to_vec(), outputs)
}

fn identified(test: Test, seed: u64) -> IdentificationResult {
    let (input, outputs) = record(test, seed);
    let names: Vec<String> = (1..=test.outputs).map(|o| format!("y{o}")).collect();
    let mut channels: Vec<(&str, &str, &[f64])> = vec![("u", "N", &input)];
    channels.extend((names.iter().zip(&outputs)).map(|(n, y)| (n.as_str(), "m", y.as_slice())));
    let recording = Recording::from_arrays(RATE_HZ, &channels).unwrap();
    let mut study = IdentifyStudy {
        band_hz: Some((20.0, 300.0)),
        ..IdentifyStudy::default()
    };
    study.estimate.frequency_resolution_hz = test.resolution_hz;
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    recording.identify(&["u"], &names, &study).unwrap()
}

/// What several runs found.
#[derive(Debug, Default)]
struct Score {
    modes: usize,
    found: usize,
    others: usize,
    /// Offsets of frequencies and dampings over their standard deviations, where these are stated.
    offsets: [Vec<f64>; 2],
}

impl Score {
    /// Frequencies and dampings inside their intervals.
    fn held(&self) -> [usize; 2] {
        let inside = |z: &Vec<f64>| z.iter().filter(|z| z.abs() < 1.96).count();
        [inside(&self.offsets[0]), inside(&self.offsets[1])]
    }
}

fn score(test: Test, seeds: std::ops::Range<u64>) -> Score {
    let mut score = Score::default();
    for seed in seeds {
        let result = identified(test, seed);
        let all = result.modes.iter().chain(&result.weak);
        let all: Vec<&ModalParameters> = all.map(|m| &m.mode).collect();
        let mut own = 0;
        for (f, d) in TRUTH {
            score.modes += 1;
            let off = |m: &ModalParameters| (m.frequency_hz() - f).abs();
            let near = all.iter().filter(|m| off(m) < 0.02 * f);
            let Some(m) = near.min_by(|a, b| off(a).total_cmp(&off(b))) else {
                continue;
            };
            own += 1;
            if let (Some(of_f), Some(of_d)) = (m.frequency_std_hz(), m.damping_std()) {
                score.offsets[0].push((m.frequency_hz() - f) / of_f);
                score.offsets[1].push((m.damping_ratio() - d) / of_d);
            }
        }
        score.found += own;
        score.others += all.len() - own;
    }
    score
}

/// A record of so many half overlapped blocks.
fn blocks(blocks: usize, resolution_hz: f64, outputs: usize) -> Test {
    Test {
        seconds: 0.5 * (blocks + 1) as f64 / resolution_hz,
        outputs,
        resolution_hz: Some(resolution_hz),
    }
}

/// A record without a requested distance of lines.
fn parabolas(seconds: f64, outputs: usize) -> Test {
    Test {
        seconds,
        outputs,
        resolution_hz: None,
    }
}

/// Leakage of Hann blocks makes damping appear larger by a per cent, the same in every average: intervals hold it (they held 85 % of the
/// dampings).
#[test]
fn law_intervals_hold_the_leakage_of_blocks() {
    let found = score(blocks(16, 0.5, 1), 0..12);
    assert_eq!((found.modes, found.found, found.others), (48, 48, 0));
    let held = found.held();
    assert!(held[0] >= 46 && held[1] >= 46, "{held:?}");
}

/// One block of a second, whose lines are weighed by variances of six to eight degrees of freedom (88 % of the frequencies had been held).
#[test]
fn law_intervals_hold_weights_of_few_averages() {
    let found = score(parabolas(1.0, 1), 0..40);
    assert_eq!((found.modes, found.found, found.others), (160, 160, 0));
    let held = found.held();
    // 152 expected; below 144 is chance once in 250
    assert!(held[0] >= 144 && held[1] >= 144, "{held:?}");
}

/// The average of three blocks says too little of its own variance for an interval (it held 61 to 91 %): none is stated, and a warning says so.
#[test]
fn law_three_blocks_state_no_interval() {
    let found = identified(blocks(3, 0.5, 1), 3);
    assert_eq!(found.modes.len(), 4);
    assert!(
        found
            .modes
            .iter()
            .all(|m| m.mode.frequency_std_hz().is_none())
    );
    let few = found.diagnostics.iter().find(|d| d.code == "few-averages");
    let message = few.map(|d| d.message.as_str()).unwrap_or_default();
    assert!(message.contains("none are given"), "{message}");
    let four = identified(blocks(4, 0.5, 1), 3);
    assert!(
        four.modes
            .iter()
            .all(|m| m.mode.frequency_std_hz().is_some())
    );
}

/// Coverage by the number of averages, lines in the half-power width and responses, 800 modes a cell.
#[test]
#[ignore = "study: an hour"]
fn study_coverage_of_short_noise() {
    for outputs in [1, 6] {
        for resolution in [0.5, 0.2] {
            for count in [2, 3, 4, 6, 8, 16] {
                show(blocks(count, resolution, outputs));
            }
        }
        for seconds in [1.0, 2.0, 4.0, 6.0, 10.0, 20.0] {
            show(parabolas(seconds, outputs));
        }
    }
}

fn show(test: Test) {
    let found = score(test, 0..200);
    let share = |n: usize| 100.0 * n as f64 / found.offsets[0].len().max(1) as f64;
    let mean = |z: &[f64]| z.iter().sum::<f64>() / z.len().max(1) as f64;
    let [frequencies, dampings] = found.held().map(share);
    eprintln!(
        "{test:?}: {} of {} found, {} others, {} intervals, frequencies {frequencies:.1} %, dampings {dampings:.1} %, offsets in standard deviations {:+.2}, {:+.2}",
        found.found,
        found.modes,
        found.others,
        found.offsets[0].len(),
        mean(&found.offsets[0]),
        mean(&found.offsets[1]),
    );
}
