//! Simulated logs in memory, identified with default settings: no mode lost or doubled, frequencies within what is stated.

use std::f64::consts::TAU;

use geardyn::internals::identify::modal_parameters::ModalParameters;
use geardyn::internals::numeric::Complex;
use geardyn::internals::plan::logs::frf_estimation::FrfStudy;
use geardyn::internals::plan::logs::identification::{IdentificationInput, identify};
use geardyn::internals::plan::logs::identification_result::IdentificationResult;
use geardyn::internals::plan::logs::identify_study::IdentifyStudy;
use geardyn::internals::plan::logs::method::IdentificationMethod;
use geardyn::internals::recording::frequency_responses::{
    ChannelLabel, FrequencyResponse, FrequencyResponses,
};
use geardyn::internals::recording::sample_column::SampleColumn;
use geardyn::internals::recording::signals::{Channel, Recording};

use crate::support::noise::normal;

const RATE: f64 = 1000.0;

/// Frequency, Hz, damping ratio, shape over two outputs, participation of two inputs.
type Mode = (f64, f64, [f64; 2], [f64; 2]);

/// One lightly damped mode, two close ones, one of more damping.
const MODES: [Mode; 4] = [
    (40.0, 0.005, [1.0, 0.6], [1.0, 0.5]),
    (95.0, 0.005, [0.8, -0.7], [0.6, -1.0]),
    (97.5, 0.005, [0.6, 1.0], [1.0, 0.8]),
    (180.0, 0.02, [1.0, -0.4], [-0.5, 1.0]),
];

/// Normal numbers by Box and Muller. Neighbouring seeds of this generator give numbers that are correlated by a quarter.
struct Normal(fastrand::Rng);

impl Normal {
    fn new(seed: u64) -> Normal {
        Normal(fastrand::Rng::with_seed(
            (seed + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15),
        ))
    }

    fn next(&mut self) -> f64 {
        normal(&mut self.0)
    }
}

/// Displacements of the modes under forces held between samples, begun at rest.
fn moved(modes: &[Mode], forces: &[Vec<f64>; 2]) -> [Vec<f64>; 2] {
    let mut moved = [vec![0.0; forces[0].len()], vec![0.0; forces[0].len()]];
    for &(frequency_hz, damping, shape, drives) in modes {
        let omega = TAU * frequency_hz;
        let p = Complex::new(-damping * omega, omega * (1.0 - damping * damping).sqrt());
        let z = (p / RATE).exp();
        let (gain, residue) = ((z - 1.0) / p, Complex::new(0.0, 2.0 * p.im).inv());
        let mut state = Complex::new(0.0, 0.0);
        for t in 0..forces[0].len() {
            let x = 2.0 * (residue * state).re;
            moved[0][t] += shape[0] * x;
            moved[1][t] += shape[1] * x;
            let force = forces[0][t] * drives[0] + forces[1][t] * drives[1];
            state = z * state + gain * force;
        }
    }
    moved
}

fn recording(channels: &[(&str, &str, &[f64])]) -> Recording {
    let samples = channels[0].2.len();
    let channel = |(name, unit, samples): &(&str, &str, &[f64])| Channel {
        name: (*name).to_string(),
        unit: (*unit).to_string(),
        samples: SampleColumn::from_slice(samples).into(),
        overload_level: None,
        overloads: 0,
    };
    Recording {
        path: "memory".to_string(),
        dialect: String::new(),
        metadata: Vec::new(),
        rate_hz: RATE,
        rate_std: 0.0,
        rate_source: String::new(),
        samples,
        segments: std::iter::once(0..samples).collect(),
        segment_starts: vec![0.0],
        start: None,
        files: Vec::new(),
        channels: channels.iter().map(channel).collect(),
        repairs: Vec::new(),
        diagnostics: Vec::new(),
    }
}

/// A record of two independent forces, each response with noise of 1 % of its rms.
fn two_forces(seed: u64, samples: usize) -> Recording {
    let mut random = Normal::new(seed);
    let forces = [0, 1].map(|_| (0..samples).map(|_| random.next()).collect::<Vec<f64>>());
    let mut moved = moved(&MODES, &forces);
    for x in &mut moved {
        let rms = (x.iter().map(|x| x * x).sum::<f64>() / samples as f64).sqrt();
        x.iter_mut().for_each(|x| *x += 0.01 * rms * random.next());
    }
    recording(&[
        ("f1", "N", &forces[0]),
        ("f2", "N", &forces[1]),
        ("x1", "m", &moved[0]),
        ("x2", "m", &moved[1]),
    ])
}

fn by_two_forces(recording: &Recording) -> IdentificationResult {
    let words = |all: [&str; 2]| all.map(str::to_string).to_vec();
    let study = IdentifyStudy {
        inputs: words(["f1", "f2"]),
        outputs: words(["x1", "x2"]),
        ..IdentifyStudy::default()
    };
    identify(IdentificationInput::Signals(recording), &study).unwrap()
}

/// How many of the frequencies lie within 1.96 of their standard deviations, and how many modes were lost or invented.
fn score(found: &IdentificationResult) -> (usize, bool) {
    let frequencies: Vec<f64> = found.modes.iter().map(|m| m.frequency_hz()).collect();
    let within = |(at, mode): (usize, &Mode)| {
        let near = found.modes.get(at)?;
        let off = (near.frequency_hz() - mode.0).abs();
        (off < 1.96 * near.mode.frequency_std_hz()?).then_some(())
    };
    let is_whole = frequencies.len() == MODES.len()
        && (frequencies.iter().zip(MODES)).all(|(f, m)| (f / m.0 - 1.0).abs() < 0.01);
    let inside = MODES.iter().enumerate().filter_map(within).count();
    if !is_whole {
        eprintln!("{} {frequencies:?}", found.method_text);
    }
    (inside, is_whole)
}

/// Averaged blocks had split the mode at 40 Hz into 39.92 and 40.24 Hz.
#[test]
fn exact_modes_of_two_forces_without_leakage() {
    let found = by_two_forces(&two_forces(0, 60_000));
    let (inside, is_whole) = score(&found);
    assert!(
        found.method_text.contains("local parabolas"),
        "{}",
        found.method_text
    );
    assert!(is_whole && inside >= 3, "{inside}");
}

/// Twenty records: no mode split, frequencies within the stated intervals as often as they should be.
#[test]
#[ignore = "twenty fits"]
fn law_frequencies_of_two_forces_lie_in_their_intervals() {
    let (mut inside, mut whole) = (0, 0);
    for seed in 100..120 {
        let (count, is_whole) = score(&by_two_forces(&two_forces(seed, 60_000)));
        whole += usize::from(is_whole);
        inside += count;
    }
    let share = inside as f64 / (20 * MODES.len()) as f64;
    eprintln!("{whole} of 20 with these modes and no other, {share} of the frequencies inside");
    assert!(whole == 20 && share >= 0.9, "{whole} {share}");
}

/// Two responses alone, of four modes under noise and of tones: one clear of the modes, one inside the band of a mode, a weak one. Each
/// has noise of 5 % of its rms.
fn running(seed: u64, tones: &[(f64, f64)]) -> Recording {
    const SAMPLES: usize = 60_000;
    let mut random = Normal::new(seed);
    let forces = [0, 1].map(|_| (0..SAMPLES).map(|_| random.next()).collect::<Vec<f64>>());
    let mut moved = moved(&MODES, &forces);
    for (channel, x) in moved.iter_mut().enumerate() {
        let rms = (x.iter().map(|x| x * x).sum::<f64>() / SAMPLES as f64).sqrt();
        for (t, x) in x.iter_mut().enumerate() {
            let phase = |f: f64| TAU * f * t as f64 / RATE + channel as f64;
            let sum: f64 = tones.iter().map(|&(f, a)| a * phase(f).sin()).sum();
            *x += rms * (0.05 * random.next() + sum);
        }
    }
    recording(&[("x1", "m", &moved[0]), ("x2", "m", &moved[1])])
}

fn by_responses(recording: &Recording) -> IdentificationResult {
    let study = IdentifyStudy {
        outputs: ["x1", "x2"].map(str::to_string).to_vec(),
        ..IdentifyStudy::default()
    };
    identify(IdentificationInput::Signals(recording), &study).unwrap()
}

const TONES: [(f64, f64); 3] = [(40.2, 1.0), (60.0, 0.05), (140.0, 2.0)];

/// Modes are found beside tones, even in their own band; tones stand apart with their frequencies, without any speed being stated.
fn check_running(seed: u64) {
    let found = by_responses(&running(seed, &TONES));
    let modes: Vec<f64> = found.modes.iter().map(|m| m.frequency_hz()).collect();
    let tones: Vec<f64> = found.harmonics.iter().map(|h| h.frequency_hz).collect();
    assert_eq!(
        tones.len(),
        TONES.len(),
        "seed {seed}: {tones:?}, modes {modes:?}"
    );
    for (found, (f, _)) in tones.iter().zip(TONES) {
        assert!((found - f).abs() < 0.003, "seed {seed}: {tones:?}");
    }
    for (f, ..) in MODES {
        let near = modes.iter().filter(|found| (*found / f - 1.0).abs() < 0.01);
        assert_eq!(near.count(), 1, "seed {seed}: {modes:?}");
    }
    let is_tone = |f: &&f64| TONES.iter().any(|t| (*f - t.0).abs() < 0.05);
    assert_eq!(
        modes.iter().filter(is_tone).count(),
        0,
        "seed {seed}: {modes:?}"
    );
}

/// A tone had been listed as a mode unless a speed was stated.
#[test]
fn law_tones_are_no_modes_of_responses_alone() {
    check_running(1);
}

/// Over many records: tones clear of the modes are all found, none is found where there is none, and of those inside the band of a mode
/// nearly half (9 of 20), its own noise hiding the others.
#[test]
#[ignore = "twenty records with tones, ten without"]
fn law_tones_are_told_from_narrow_modes() {
    let mut inside = 0;
    for seed in 10..30 {
        let found = by_responses(&running(seed, &TONES));
        let has = |f: f64| {
            found
                .harmonics
                .iter()
                .any(|h| (h.frequency_hz - f).abs() < 0.003)
        };
        assert!(
            has(TONES[1].0) && has(TONES[2].0),
            "seed {seed}: {:?}",
            found.harmonics
        );
        inside += usize::from(has(TONES[0].0));
    }
    let mut alarms = 0;
    for seed in 30..40 {
        let found = by_responses(&running(seed, &[]));
        alarms += found.harmonics.len();
        assert!(found.modes.len() >= MODES.len(), "seed {seed}");
    }
    eprintln!("{inside} of 20 inside the band of a mode, {alarms} where there is none");
    assert!(inside >= 7 && alarms <= 1, "{inside} {alarms}");
}

/// Modes of the stepped sine, and the frequencies it dwells on: coarse, finer about the modes, 60 Hz twice.
const STEPPED: [Mode; 3] = [
    (40.0, 0.02, [1.0, 0.6], [1.0, 0.0]),
    (95.0, 0.01, [0.8, -0.7], [1.0, 0.0]),
    (180.0, 0.02, [1.0, -0.4], [1.0, 0.0]),
];

/// Samples of each dwell.
const DWELL: usize = 2000;

fn steps() -> Vec<f64> {
    let is_clear = |f: &f64| STEPPED.iter().all(|m| (f - m.0).abs() > 0.05 * m.0);
    let coarse = (5..60).map(|k| 4.0 * f64::from(k)).filter(is_clear);
    let fine = |f: f64, by: f64| (-6..=6).map(move |k| f + by * f64::from(k));
    let all = coarse.chain(fine(40.0, 0.3)).chain(fine(95.0, 0.4));
    let mut all: Vec<f64> = all.chain(fine(180.0, 1.2)).collect();
    all.sort_by(f64::total_cmp);
    all.push(60.0);
    all
}

/// The exact answer to a sine, displacement over force.
fn exact(output: usize, frequency_hz: f64) -> Complex {
    let s = Complex::new(0.0, TAU * frequency_hz);
    let one = |&(f, d, shape, _): &Mode| {
        let omega = TAU * f;
        (s * s + 2.0 * d * omega * s + omega * omega).inv() * shape[output]
    };
    STEPPED.iter().map(one).sum()
}

/// A sine stepped without a pause, exactly answered by continuous modes, with noise of `noise` of each channel's rms.
fn stepped(seed: u64, noise: f64) -> Recording {
    let mut random = Normal::new(seed);
    let count = DWELL * steps().len();
    let mut force = Vec::with_capacity(count);
    let mut moved = [vec![0.0; count], vec![0.0; count]];
    let mut states = [Complex::new(0.0, 0.0); STEPPED.len()];
    let mut phase = 0.0_f64;
    for f in steps() {
        let turn = Complex::new(0.0, TAU * f);
        for _ in 0..DWELL {
            let t = force.len();
            force.push(phase.cos());
            for (state, &(f, d, shape, _)) in states.iter_mut().zip(&STEPPED) {
                let omega = TAU * f;
                let p = Complex::new(-d * omega, omega * (1.0 - d * d).sqrt());
                let x = 2.0 * (*state * Complex::new(0.0, 2.0 * p.im).inv()).re;
                moved[0][t] += shape[0] * x;
                moved[1][t] += shape[1] * x;
                let z = (p / RATE).exp();
                // ∫ exp(p(T − τ)) cos(phase + ωτ) dτ over a sample.
                let part = |s: Complex, phase: f64| {
                    Complex::new(0.0, phase).exp() * ((s / RATE).exp() - z) / (s - p)
                };
                *state = z * *state + 0.5 * (part(turn, phase) + part(-turn, -phase));
            }
            phase = (phase + turn.im / RATE) % TAU;
        }
    }
    for x in moved.iter_mut().chain([&mut force]) {
        let rms = (x.iter().map(|x| x * x).sum::<f64>() / count as f64).sqrt();
        x.iter_mut().for_each(|x| *x += noise * rms * random.next());
    }
    recording(&[
        ("force", "N", &force),
        ("x1", "m", &moved[0]),
        ("x2", "m", &moved[1]),
    ])
}

fn by_steps(recording: &Recording, estimate: FrfStudy) -> IdentificationResult {
    let study = IdentifyStudy {
        inputs: vec!["force".to_string()],
        outputs: ["x1", "x2"].map(str::to_string).to_vec(),
        estimate,
        ..IdentifyStudy::default()
    };
    identify(IdentificationInput::Signals(recording), &study).unwrap()
}

/// Unasked, a stepped sine is seen as one: its dwells, one line each, as far from the exact response as the variance says; its modes.
#[test]
fn exact_stepped_sine_and_its_modes() {
    let log = stepped(3, 0.02);
    let found = by_steps(&log, FrfStudy::default());
    assert!(
        found.method_text.starts_with("stepped sine"),
        "{}",
        found.method_text
    );
    let responses = found.responses.as_ref().unwrap();
    // 60 Hz was dwelt on twice.
    assert_eq!(responses.frequency_hz.len(), steps().len() - 1);
    let mut far = Vec::new();
    for (output, function) in responses.responses.iter().enumerate() {
        let variance = function.variance.as_ref().unwrap();
        for (line, &f) in responses.frequency_hz.iter().enumerate() {
            let step = steps().into_iter().map(|s| (s - f).abs());
            assert!(step.fold(f64::INFINITY, f64::min) < 1e-3, "{f}");
            far.push((function.values[line] - exact(output, f)).norm_sqr() / variance[line]);
        }
    }
    let mean = far.iter().sum::<f64>() / far.len() as f64;
    let beyond = far.iter().filter(|x| **x > 3.0).count() as f64 / far.len() as f64;
    assert!((0.7..1.5).contains(&mean), "{mean}");
    // Of a normal error 5 % lie beyond 3; of variances from 32 parts of noise somewhat more.
    assert!(beyond < 0.1, "{beyond}");
    assert_eq!(found.modes.len(), STEPPED.len(), "{:?}", found.modes);
    for (mode, (f, d, ..)) in found.modes.iter().zip(STEPPED) {
        let std = mode.mode.frequency_std_hz().unwrap();
        assert!((mode.frequency_hz() - f).abs() < 3.5 * std, "{mode:?}");
        assert!(std < 1e-3 * f, "{mode:?}");
        let off = (mode.damping_ratio().unwrap() - d).abs();
        assert!(off < 3.5 * mode.mode.damping_std().unwrap(), "{mode:?}");
    }
}

/// Dwells may be given: here a part of three of them.
#[test]
fn exact_given_dwells() {
    let log = stepped(4, 0.0);
    let dwells_s: Vec<(f64, f64)> = (0..40)
        .map(|k| (2.0 * f64::from(k) + 1.2, 2.0 * f64::from(k) + 2.0))
        .collect();
    let study = FrfStudy {
        dwells_s,
        ..FrfStudy::default()
    };
    let found = by_steps(&log, study);
    let lines = &found.responses.as_ref().unwrap().frequency_hz;
    assert_eq!(lines.len(), 40);
    for (line, step) in lines.iter().zip(steps()) {
        assert!((line - step).abs() < 1e-6, "{line} {step}");
    }
}

/// Half a minute of a swept sine: lines lie as far apart as the mode at 40 Hz is wide, and parabolas alone had made two of it.
#[test]
fn exact_modes_of_a_sweep() {
    const SAMPLES: usize = 30_000;
    let mut random = Normal::new(5);
    let sine = |t: usize| {
        let share = t as f64 / SAMPLES as f64;
        (TAU * (5.0 * share + 0.5 * 395.0 * share * share) * SAMPLES as f64 / RATE).sin()
    };
    let forces = [(0..SAMPLES).map(sine).collect(), vec![0.0; SAMPLES]];
    let mut moved = moved(&MODES, &forces);
    for x in &mut moved {
        let rms = (x.iter().map(|x| x * x).sum::<f64>() / SAMPLES as f64).sqrt();
        x.iter_mut().for_each(|x| *x += 0.002 * rms * random.next());
    }
    let log = recording(&[
        ("force", "N", &forces[0]),
        ("x1", "m", &moved[0]),
        ("x2", "m", &moved[1]),
    ]);
    let found = by_steps(&log, FrfStudy::default());
    assert!(
        found.method_text.contains("local parabolas"),
        "{}",
        found.method_text
    );
    let (inside, is_whole) = score(&found);
    let told: Vec<_> = found
        .modes
        .iter()
        .map(|m| {
            (
                m.frequency_hz(),
                m.damping_ratio(),
                m.mode.frequency_std_hz(),
            )
        })
        .collect();
    assert!(is_whole && inside >= 2, "{inside} {told:?}");
    for (mode, (f, d, ..)) in found.modes.iter().zip(MODES) {
        let std = (
            mode.mode.frequency_std_hz().unwrap(),
            mode.mode.damping_std().unwrap(),
        );
        assert!((mode.frequency_hz() - f).abs() < 4.0 * std.0, "{mode:?}");
        assert!(
            (mode.damping_ratio().unwrap() - d).abs() < 4.0 * std.1,
            "{mode:?}"
        );
        assert!(std.0 < 2e-3 * f, "{mode:?}");
    }
}

/// A free body whose receptances, of unknown kind and with noise in proportion to them, fall over five decades: its modes, and not none.
#[test]
fn exact_modes_of_a_free_body() {
    const FREE: [(f64, f64, [f64; 2]); 3] = [
        (60.0, 0.01, [1.0, -0.7]),
        (150.0, 0.008, [1.0, 0.5]),
        (300.0, 0.01, [1.0, 0.9]),
    ];
    let mut random = Normal::new(8);
    let lines: Vec<f64> = (1..=500).map(f64::from).collect();
    let mut functions = Vec::new();
    for output in 0..2 {
        let value = lines.iter().map(|&f| {
            let s = Complex::new(0.0, TAU * f);
            let mut sum = (s * s).inv();
            for (f, d, shape) in FREE {
                let omega = TAU * f;
                sum += shape[output] / (s * s + 2.0 * d * omega * s + omega * omega);
            }
            sum * (1.0 + 0.01 * Complex::new(random.next(), random.next()))
        });
        functions.push(FrequencyResponse {
            output: ChannelLabel {
                name: format!("H{output}"),
                unit: String::new(),
            },
            values: value.collect(),
            ..FrequencyResponse::default()
        });
    }
    let responses = FrequencyResponses {
        frequency_hz: lines,
        responses: functions,
        ..FrequencyResponses::default()
    };
    let found = identify(
        IdentificationInput::Responses(responses),
        &IdentifyStudy::default(),
    )
    .unwrap();
    let frequencies: Vec<f64> = found.modes.iter().map(|m| m.frequency_hz()).collect();
    assert_eq!(frequencies.len(), FREE.len(), "{frequencies:?}");
    for (mode, (f, ..)) in found.modes.iter().zip(FREE) {
        let std = mode.mode.frequency_std_hz().unwrap();
        assert!(
            (mode.frequency_hz() - f).abs() < 4.0 * std && std < 1e-3 * f,
            "{mode:?}"
        );
    }
}

/// Responses of a file with one and a half lines in the half-power band of a mode: said; with eight: not.
#[test]
fn law_coarse_lines_are_said() {
    let (f, d) = (40.0, 0.005);
    for (apart, is_coarse) in [(0.25, true), (0.05, false)] {
        let mut random = Normal::new(6);
        let lines: Vec<f64> = (0..80).map(|k| f + apart * (f64::from(k) - 39.6)).collect();
        let value = lines.iter().map(|line| {
            let (s, omega) = (Complex::new(0.0, TAU * line), TAU * f);
            let noise = 1.0 + 0.003 * Complex::new(random.next(), random.next());
            noise / (s * s + 2.0 * d * omega * s + omega * omega)
        });
        let function = FrequencyResponse {
            values: value.collect(),
            ..FrequencyResponse::default()
        };
        let responses = FrequencyResponses {
            frequency_hz: lines.clone(),
            responses: vec![function],
            ..FrequencyResponses::default()
        };
        let found = identify(
            IdentificationInput::Responses(responses),
            &IdentifyStudy::default(),
        )
        .unwrap();
        assert_eq!(found.modes.len(), 1, "{:?}", found.modes);
        let said = found.diagnostics.iter().any(|w| w.code == "coarse-lines");
        assert_eq!(said, is_coarse, "{:?}", found.diagnostics);
    }
}

/// A mode on an order of the speed, its sine taken out, is a mode, and said to lie there; peaks of noise are none.
#[test]
fn law_a_mode_on_an_order_is_kept() {
    // The third order beside the mode and right on it, between lines of the record and on one.
    for (seed, speed_hz) in [(2, 59.7), (3, 60.0)] {
        check_mode_on_an_order(seed, speed_hz);
    }
}

/// A mode on the third order of a stated speed in a record without any sine stays a mode, with its order: nothing shows a line there.
#[test]
fn law_an_order_without_a_sine_takes_no_mode() {
    let log = running(2, &[]);
    for method in [IdentificationMethod::SsiCov, IdentificationMethod::SsiData] {
        let study = IdentifyStudy {
            outputs: ["x1", "x2"].map(str::to_string).to_vec(),
            method: Some(method),
            speed_hz: Some(60.0),
            ..IdentifyStudy::default()
        };
        let found = identify(IdentificationInput::Signals(&log), &study).unwrap();
        let on: Vec<f64> = found.modes.iter().filter_map(|m| m.on_order).collect();
        assert_eq!(on, [3.0], "{:?}", found.modes);
        assert_eq!(found.modes.len(), MODES.len(), "{:?}", found.modes);
        assert!(found.harmonics.is_empty(), "{:?}", found.harmonics);
        assert!(found.diagnostics.iter().any(|w| w.code == "mode-on-order"));
    }
}

/// A mesh with sidebands of both shafts over three modes, no speed stated: the modes and nothing else, the sidebands as a series.
#[test]
fn law_sidebands_of_a_mesh_are_no_modes() {
    let sidebands = |k: i32| (212.4 + 8.3 * f64::from(k), 0.3 / (1.0 + f64::from(k.abs())));
    let mut lines: Vec<(f64, f64)> = (-4..=4).map(sidebands).collect();
    lines.extend([(8.3, 0.3), (16.6, 0.2), (424.8, 0.1)]);
    let log = running(4, &lines);
    let study = IdentifyStudy {
        outputs: ["x1", "x2"].map(str::to_string).to_vec(),
        method: Some(IdentificationMethod::SsiCov),
        ..IdentifyStudy::default()
    };
    let found = identify(IdentificationInput::Signals(&log), &study).unwrap();
    let frequencies: Vec<f64> = found.modes.iter().map(|m| m.frequency_hz()).collect();
    assert_eq!(frequencies.len(), MODES.len(), "{frequencies:?}");
    for (f, mode) in frequencies.iter().zip(MODES) {
        assert!((f / mode.0 - 1.0).abs() < 0.01, "{frequencies:?}");
    }
    assert!(found.harmonics.len() >= 11, "{:?}", found.harmonics);
    assert!(found.diagnostics.iter().any(|w| w.code == "evenly-spaced"));
}

fn check_mode_on_an_order(seed: u64, speed_hz: f64) {
    let orders = [(1.0, 0.5), (2.0, 0.4), (3.0, 0.1)];
    let log = running(seed, &orders.map(|(order, a)| (order * speed_hz, a)));
    for method in [IdentificationMethod::Fdd, IdentificationMethod::Efdd] {
        let study = IdentifyStudy {
            outputs: ["x1", "x2"].map(str::to_string).to_vec(),
            method: Some(method),
            speed_hz: Some(speed_hz),
            ..IdentifyStudy::default()
        };
        let found = identify(IdentificationInput::Signals(&log), &study).unwrap();
        let on: Vec<f64> = found.modes.iter().filter_map(|m| m.on_order).collect();
        assert_eq!(on, [3.0], "{:?}", found.modes);
        assert!(found.diagnostics.iter().any(|w| w.code == "mode-on-order"));
        let orders: Vec<_> = found.harmonics.iter().map(|h| h.order).collect();
        assert_eq!(orders, [Some(1.0), Some(2.0), Some(3.0)]);
        let frequencies: Vec<f64> = found.modes.iter().map(|m| m.frequency_hz()).collect();
        let near = |f: f64| move |found: &&f64| (*found / f - 1.0).abs() < 0.015;
        for f in [40.0, 180.0] {
            assert_eq!(
                frequencies.iter().filter(near(f)).count(),
                1,
                "{frequencies:?}"
            );
        }
        assert!(frequencies.len() <= MODES.len(), "{frequencies:?}");
    }
}

/// A record of one force in which one sample is missing off the middle: blocks of one length from both stretches. The modes lie in their
/// intervals, none is split, and nothing is said of leakage.
#[test]
fn exact_modes_beside_a_gap() {
    let (samples, missing) = (60_000, 29_000);
    let mut random = Normal::new(11);
    let force: Vec<f64> = (0..samples).map(|_| random.next()).collect();
    let forces = [force, vec![0.0; samples]];
    let mut moved = moved(&MODES, &forces);
    for x in &mut moved {
        let rms = (x.iter().map(|x| x * x).sum::<f64>() / samples as f64).sqrt();
        x.iter_mut().for_each(|x| *x += 0.01 * rms * random.next());
        x[missing] = 0.0;
    }
    let mut recording = recording(&[
        ("f", "N", &forces[0]),
        ("x1", "m", &moved[0]),
        ("x2", "m", &moved[1]),
    ]);
    recording.segments = vec![0..missing, missing + 1..samples];
    recording.segment_starts = vec![0.0, (missing + 1) as f64 / RATE];
    let asked = |input: &str, outputs: &[&str]| {
        let study = IdentifyStudy {
            inputs: vec![input.to_string()],
            outputs: outputs.iter().map(|o| (*o).to_string()).collect(),
            ..IdentifyStudy::default()
        };
        identify(IdentificationInput::Signals(&recording), &study).unwrap()
    };
    let found = asked("f", &["x1", "x2"]);
    let (inside, is_whole) = score(&found);
    assert!(is_whole && inside == MODES.len(), "{inside}");
    assert!(
        found.method_text.contains("2 blocks of"),
        "{}",
        found.method_text
    );
    assert!(
        found.method_text.contains("not used"),
        "{}",
        found.method_text
    );
    let codes = |found: &IdentificationResult| -> Vec<&str> {
        found.diagnostics.iter().map(|w| w.code).collect()
    };
    let said = codes(&found);
    assert!(!said.contains(&"leakage") && !said.contains(&"inverse-response"));
    // The other way round: poles of a force over a motion are zeros.
    let swapped = asked("x1", &["f"]);
    assert!(codes(&swapped).contains(&"inverse-response"));
}

/// A sample rate known to a share of itself stretches every frequency by it: its deviation adds to that of the fit, the damping ratio keeps its own.
#[test]
fn law_uncertain_sample_rate_enters_the_frequencies() {
    const STD: f64 = 1e-3;
    let exact = two_forces(3, 30_000);
    let uncertain = Recording {
        rate_std: STD,
        ..exact.clone()
    };
    let (a, b) = (by_two_forces(&exact), by_two_forces(&uncertain));
    assert_eq!(a.modes.len(), MODES.len());
    for (a, b) in a.modes.iter().zip(&b.modes) {
        let std = |m: &ModalParameters| m.frequency_std_hz().unwrap();
        let added = (std(&b.mode).powi(2) - std(&a.mode).powi(2)).sqrt();
        assert!((added / (STD * a.frequency_hz()) - 1.0).abs() < 1e-6);
        let damping = |m: &ModalParameters| m.damping_std().unwrap();
        assert!((damping(&b.mode) / damping(&a.mode) - 1.0).abs() < 1e-6);
    }
}
