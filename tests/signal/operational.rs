//! Modes from responses alone: simulated structures whose modes are known, exact covariances, measured logs, bad records.

use std::f64::consts::{PI, TAU};

use geardyn::internals::base::code::Code;
use geardyn::internals::identify::operational::fdd::{self, fdd};
use geardyn::internals::identify::operational::harmonics::RunningSpeed;
use geardyn::internals::identify::operational::merge_levels::OperationalMode;
use geardyn::internals::identify::operational::realisation::Weighting;
use geardyn::internals::identify::operational::response_channels::ResponseChannels;
use geardyn::internals::identify::operational::ssi::{self, SsiEstimate, SsiOptions};
use geardyn::internals::plan::logs::identification::{IdentificationInput, identify};
use geardyn::internals::plan::logs::identify_study::IdentifyStudy;
use geardyn::internals::recording::signals::Recording;

use crate::support::noise::normal;

/// Modes (Hz, damping ratio) with the shape of a string of `channels` points, each driven by noise of its own.
struct Structure {
    rate: f64,
    modes: Vec<(f64, f64)>,
    channels: usize,
    /// Noise of the sensors over the response.
    sensor_noise: f64,
}

impl Structure {
    fn shape(&self, mode: usize, channel: usize) -> f64 {
        let (m, c) = ((mode + 1) as f64, (channel + 1) as f64);
        match mode < self.channels {
            true => (PI * m * c / (self.channels + 1) as f64).sin(),
            // A string of so few points has no more shapes.
            false => (1.7 * m * c + 0.5 * m).sin(),
        }
    }

    fn respond(&self, seed: u64, samples: usize) -> Vec<Vec<f64>> {
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut channels = vec![vec![0.0; samples]; self.channels];
        for (m, &(f, zeta)) in self.modes.iter().enumerate() {
            let w = TAU * f / self.rate;
            let r = (-zeta * w).exp();
            let (a, b) = (2.0 * r * (w * f64::sqrt(1.0 - zeta * zeta)).cos(), r * r);
            let (mut x1, mut x2) = (0.0, 0.0);
            let size = (zeta * w).sqrt() * w.sin(); // about equal power for every mode
            let settle = (10.0 / (zeta * w)) as usize;
            for t in 0..settle + samples {
                let x = a * x1 - b * x2 + size * normal(&mut rng);
                (x1, x2) = (x, x1);
                if t >= settle {
                    (0..self.channels)
                        .for_each(|c| channels[c][t - settle] += self.shape(m, c) * x);
                }
            }
        }
        for channel in &mut channels {
            channel
                .iter_mut()
                .for_each(|y| *y += self.sensor_noise * normal(&mut rng) + 3.0);
        }
        channels
    }
}

fn slices(channels: &[Vec<f64>]) -> Vec<&[f64]> {
    channels.iter().map(Vec::as_slice).collect()
}

fn frame() -> Structure {
    Structure {
        rate: 100.0,
        modes: vec![(4.0, 0.01), (11.0, 0.02), (12.5, 0.01), (31.0, 0.005)],
        channels: 5,
        sensor_noise: 0.2,
    }
}

fn identified(y: &[Vec<f64>], rate: f64, weighting: Weighting) -> SsiEstimate {
    let y = slices(y);
    let channels = ResponseChannels::new(&y, rate).unwrap();
    let options = SsiOptions {
        weighting,
        ..SsiOptions::default()
    };
    ssi::identify(&channels, &options).unwrap()
}

fn frequencies(modes: &[OperationalMode]) -> Vec<(f64, f64, f64)> {
    let one = |m: &OperationalMode| {
        (
            m.mode.frequency_hz(),
            m.mode.frequency_std_hz().unwrap(),
            m.mode.damping_ratio(),
        )
    };
    modes.iter().map(one).collect()
}

/// No hint given: the four modes and nothing else, within four of their own standard deviations, from covariances and by projection.
#[test]
fn law_modes_of_a_frame_are_found() {
    let frame = frame();
    let y = frame.respond(1, 20_000);
    for weighting in [Weighting::Covariances, Weighting::Projection] {
        let found = identified(&y, frame.rate, weighting);
        let modes = &found.modes;
        assert_eq!(modes.len(), 4, "{weighting:?} {:?}", frequencies(modes));
        for (k, (m, &(f, zeta))) in modes.iter().zip(&frame.modes).enumerate() {
            let (sf, sz) = (
                m.mode.frequency_std_hz().unwrap(),
                m.mode.damping_std().unwrap(),
            );
            assert!(
                (m.mode.frequency_hz() - f).abs() < 4.0 * sf && sf < 0.01 * f,
                "{f}: {m:?}"
            );
            assert!(
                (m.mode.damping_ratio() - zeta).abs() < 4.0 * sz && sz < zeta,
                "{f}: {m:?}"
            );
            assert!(!m.harmonic.is_harmonic(), "{f}: {:?}", m.harmonic);
            let exact: Vec<f64> = (0..5).map(|c| frame.shape(k, c)).collect();
            let product: geardyn::internals::numeric::Complex = (m.mode.shape.iter().zip(&exact))
                .map(|(a, b)| a.conj() * b)
                .sum();
            let lengths = m.mode.shape.iter().map(|x| x.norm_sqr()).sum::<f64>()
                * exact.iter().map(|x| x * x).sum::<f64>();
            assert!(
                product.norm_sqr() / lengths > 0.97,
                "{f}: {:?}",
                m.mode.shape
            );
        }
    }
}

/// Eighteen channels at 512 Hz, for which block rows by the number of channels had spanned half a period of the lowest mode: all modes,
/// nothing else; and a band only chooses among them.
#[test]
fn law_many_channels_at_a_high_rate() {
    let structure = Structure {
        rate: 512.0,
        modes: vec![(4.0, 0.02), (13.0, 0.015), (47.0, 0.01), (120.0, 0.008)],
        channels: 18,
        sensor_noise: 0.2,
    };
    let y = structure.respond(5, 16_000);
    let found = identified(&y, structure.rate, Weighting::Covariances);
    let all = frequencies(&found.modes);
    assert_eq!(all.len(), 4, "{all:?}");
    for (&(f, _), (g, std, _)) in structure.modes.iter().zip(&all) {
        assert!((f - g).abs() < 4.0 * std && *std < 0.02 * f, "{f}: {all:?}");
    }
    let views = slices(&y);
    let channels = ResponseChannels::new(&views, structure.rate).unwrap();
    let options = SsiOptions {
        band_hz: Some((30.0, 60.0)),
        ..SsiOptions::default()
    };
    let banded = ssi::identify(&channels, &options).unwrap();
    let inside = |m: &&(f64, f64, f64)| m.0 > 30.0 && m.0 < 60.0;
    let again: Vec<_> = frequencies(&banded.modes);
    assert_eq!(
        again.iter().filter(inside).collect::<Vec<_>>(),
        all.iter().filter(inside).collect::<Vec<_>>()
    );
}

/// What a study over records counts.
#[derive(Debug, Default)]
struct Count {
    modes: usize,
    found: usize,
    spurious: usize,
    covered_f: usize,
    covered_zeta: usize,
}

/// Over records of so many samples: modes found, others, and how often 95 % intervals hold the truth.
fn count(structure: &Structure, samples: usize, seeds: std::ops::Range<u64>) -> Count {
    let mut count = Count::default();
    for seed in seeds {
        let y = structure.respond(500 + seed, samples);
        let mut left = identified(&y, structure.rate, Weighting::Covariances).modes;
        for &(f, zeta) in &structure.modes {
            count.modes += 1;
            let off = |m: &OperationalMode| (m.mode.frequency_hz() - f).abs();
            let nearest = (0..left.len()).min_by(|&a, &b| off(&left[a]).total_cmp(&off(&left[b])));
            let Some(k) = nearest.filter(|&k| off(&left[k]) < 0.02 * f) else {
                continue;
            };
            let mode = left.remove(k).mode;
            let covers = |x: f64, truth: f64, std: Option<f64>| {
                usize::from((x - truth).abs() < 1.96 * std.unwrap())
            };
            count.found += 1;
            count.covered_f += covers(mode.frequency_hz(), f, mode.frequency_std_hz());
            count.covered_zeta += covers(mode.damping_ratio(), zeta, mode.damping_std());
        }
        count.spurious += left.len();
    }
    eprintln!("{count:?}");
    count
}

fn two_modes() -> Structure {
    Structure {
        rate: 50.0,
        modes: vec![(4.0, 0.02), (11.0, 0.015)],
        channels: 2,
        sensor_noise: 0.2,
    }
}

/// Six records of two modes: of 24 intervals of 95 % no more than four miss (probability 0.2 % if they hold), and nothing else is found.
/// One mode of the twelve is rejected with the present limits of the selection.
#[test]
fn law_intervals_cover() {
    let count = count(&two_modes(), 10_000, 0..6);
    assert!(count.found >= 11 && count.spurious == 0, "{count:?}");
    assert!(count.covered_f + count.covered_zeta >= 20, "{count:?}");
}

/// Number of modes of a record, and what is said of close pairs.
fn close_pairs(structure: &Structure, seed: u64, samples: usize) -> (usize, Vec<String>) {
    let y = structure.respond(seed, samples);
    let names: Vec<String> = (0..y.len()).map(|k| format!("a{k}")).collect();
    let channels: Vec<(&str, &str, &[f64])> = (names.iter().zip(&y))
        .map(|(name, y)| (name.as_str(), "", y.as_slice()))
        .collect();
    let recording = Recording::from_arrays(structure.rate, &channels).unwrap();
    let study = IdentifyStudy {
        outputs: names.clone(),
        ..IdentifyStudy::default()
    };
    let found = identify(IdentificationInput::Signals(&recording), &study).unwrap();
    let pairs = found.diagnostics.iter().filter(|d| d.code == "close-pair");
    (
        found.modes.len(),
        pairs.map(|d| d.message.clone()).collect(),
    )
}

/// Two modes 0.02 Hz apart, a tenth of their half-bandwidth, that every sample rate shows as one: a warning names that one. Single modes
/// have none.
#[test]
fn law_a_merged_pair_is_warned_of() {
    let pair = Structure {
        rate: 100.0,
        modes: vec![(4.0, 0.01), (11.0, 0.02), (20.0, 0.01), (20.02, 0.01)],
        channels: 5,
        sensor_noise: 0.2,
    };
    for seed in [500, 502] {
        let (modes, pairs) = close_pairs(&pair, seed, 20_000);
        assert_eq!((modes, pairs.len()), (3, 1), "{pairs:?}");
        assert!(pairs[0].starts_with("20.0"), "{pairs:?}");
    }
    for seed in 500..503 {
        for (structure, samples) in [(frame(), 20_000), (two_modes(), 10_000)] {
            let (_, pairs) = close_pairs(&structure, seed, samples);
            assert!(pairs.is_empty(), "{seed}: {pairs:?}");
        }
    }
}

/// The figures of docs/performance.md.
#[test]
#[ignore = "study: minutes; modes found, made up and covered over records of five structures"]
fn law_choice_and_coverage_over_records() {
    let seven = Structure {
        rate: 1024.0,
        modes: vec![
            (23.0, 0.02),
            (58.0, 0.01),
            (112.0, 0.004),
            (112.56, 0.005),
            (190.0, 0.008),
            (345.0, 0.003),
            (346.7, 0.003),
        ],
        channels: 3,
        sensor_noise: 0.05,
    };
    let mast = Structure {
        rate: 1651.0,
        modes: vec![
            (3.10, 0.008),
            (3.16, 0.008),
            (9.7, 0.006),
            (14.2, 0.007),
            (22.1, 0.005),
            (31.0, 0.006),
            (40.5, 0.004),
            (55.0, 0.005),
            (78.0, 0.004),
            (102.0, 0.004),
            (131.0, 0.003),
            (170.0, 0.004),
            (215.0, 0.003),
            (262.0, 0.003),
            (320.0, 0.003),
            (388.0, 0.003),
        ],
        channels: 22,
        sensor_noise: 0.1,
    };
    for (what, structure, samples, records) in [
        ("two modes, 2 channels", two_modes(), 10_000, 60),
        ("frame, 5 channels", frame(), 20_000, 30),
        ("frame, 5 channels, 50 s", frame(), 5_000, 30),
        ("seven modes, 3 channels", seven, 61_440, 30),
        ("mast, 22 channels", mast, 123_825, 12),
    ] {
        eprint!("{what}: ");
        let count = count(&structure, samples, 0..records);
        assert!(
            count.found * 10 >= count.modes * 9 && count.spurious * 50 <= count.modes,
            "{what}: {count:?}"
        );
        let share = |covered: usize| covered as f64 / count.found as f64;
        assert!(share(count.covered_f) > 0.9 && share(count.covered_zeta) > 0.9);
    }
}

/// Frequency-domain decomposition: frequencies to 1 %, damping to a quarter, shapes; no mode taken for a sine.
#[test]
fn law_decomposition_of_a_frame() {
    let frame = frame();
    let y = frame.respond(7, 60_000);
    let y = slices(&y);
    let channels = ResponseChannels::new(&y, frame.rate).unwrap();
    let found = fdd(&channels, &fdd::FddOptions::default()).unwrap();
    for (k, &(f, zeta)) in frame.modes.iter().enumerate() {
        let peak = found
            .peaks
            .iter()
            .find(|p| (p.frequency_hz / f - 1.0).abs() < 0.01);
        let peak = peak.unwrap_or_else(|| panic!("no peak at {f} Hz"));
        let mode = peak.mode.as_ref().unwrap();
        assert!(
            (mode.frequency_hz() / f - 1.0).abs() < 0.005,
            "{f}: {}",
            mode.frequency_hz()
        );
        assert!(
            (mode.damping_ratio() / zeta - 1.0).abs() < 0.25,
            "{f}: {}",
            mode.damping_ratio()
        );
        assert!(!peak.harmonic.is_harmonic(), "{f}: {:?}", peak.harmonic);
        let exact = |c: usize| frame.shape(k, c);
        let best = (0..5)
            .max_by(|&a, &b| exact(a).abs().total_cmp(&exact(b).abs()))
            .unwrap();
        for c in 0..5 {
            let ratio = peak.shape[c] / peak.shape[best];
            assert!(
                (ratio - exact(c) / exact(best)).norm() < 0.2,
                "{f}: {:?}",
                peak.shape
            );
        }
    }
}

/// A sine among the modes is marked by both methods, and the modes are not; by its order too.
#[test]
fn law_a_running_line_is_marked() {
    let frame = frame();
    let mut y = frame.respond(9, 40_000);
    for channel in &mut y {
        for (t, x) in channel.iter_mut().enumerate() {
            *x += 0.5 * (TAU * 24.3 * t as f64 / frame.rate).sin();
        }
    }
    let y = slices(&y);
    let channels = ResponseChannels::new(&y, frame.rate).unwrap();
    let found = fdd(&channels, &fdd::FddOptions::default()).unwrap();
    let line = found
        .peaks
        .iter()
        .find(|p| (p.frequency_hz - 24.3).abs() < 0.05)
        .unwrap();
    assert!(line.harmonic.is_sine(), "{:?}", line.harmonic);
    let subspace = ssi::identify(&channels, &SsiOptions::default()).unwrap();
    for m in &subspace.modes {
        let f = m.mode.frequency_hz();
        assert_eq!(
            m.harmonic.is_sine(),
            (f - 24.3).abs() < 0.1,
            "{f} Hz: {:?}",
            m.harmonic
        );
    }
    let running = RunningSpeed {
        speed_hz: 8.1,
        orders: vec![1.0, 3.0],
        tolerance: 0.005,
    };
    let options = fdd::FddOptions {
        running_speed: Some(running),
        ..fdd::FddOptions::default()
    };
    let found = fdd(&channels, &options).unwrap();
    let orders: Vec<f64> = found
        .peaks
        .iter()
        .filter_map(|p| p.harmonic.order)
        .collect();
    assert_eq!(orders, [3.0]);
}

#[test]
fn refuses_what_holds_no_modes() {
    let (a, b) = (
        vec![1.0; 500],
        (0..500).map(f64::from).map(f64::sin).collect::<Vec<_>>(),
    );
    let code =
        |samples: &[&[f64]], rate: f64| ResponseChannels::new(samples, rate).unwrap_err().code;
    assert_eq!(code(&[], 1.0), Code::NoChannel);
    assert_eq!(code(&[&[]], 1.0), Code::EmptyLog);
    assert_eq!(code(&[&b, &a], 1.0), Code::NoSignal);
    assert_eq!(code(&[&b, &b[1..]], 1.0), Code::OutOfRange);
    assert_eq!(code(&[&b], f64::NAN), Code::OutOfRange);
    assert_eq!(code(&[&[1.0, f64::NAN, 2.0]], 1.0), Code::NotANumber);
    let (long, short) = ([&b[..], &b[..]], [&b[..30]]);
    let whole = ResponseChannels::new(&long, 100.0).unwrap();
    let cut = ResponseChannels::new(&short, 100.0).unwrap();
    let check = |channels: &ResponseChannels, band_hz: Option<(f64, f64)>, code: Code| {
        let options = SsiOptions {
            band_hz,
            ..SsiOptions::default()
        };
        let error = ssi::identify(channels, &options).unwrap_err();
        assert_eq!(error.code, code, "{error}");
        assert!(error.hint.is_some());
    };
    check(&cut, None, Code::TooShort);
    check(&whole, Some((45.0, 49.0)), Code::OutOfRange);
    let too_long = fdd::FddOptions {
        segment: Some(400),
        ..fdd::FddOptions::default()
    };
    assert_eq!(fdd(&whole, &too_long).unwrap_err().code, Code::TooShort);
    let nowhere = fdd::FddOptions {
        band_hz: Some((70.0, 80.0)),
        ..fdd::FddOptions::default()
    };
    assert_eq!(fdd(&whole, &nowhere).unwrap_err().code, Code::OutOfRange);
}

/// The lines of a long record, and of many channels, are as many as can be held and looked at.
#[test]
fn law_lines_are_bounded() {
    let mut rng = fastrand::Rng::with_seed(8);
    let long: Vec<f64> = (0..1_500_000).map(|_| rng.f64() - 0.5).collect();
    let one = [&long[..]];
    let channels = ResponseChannels::new(&one, 1000.0).unwrap();
    let found = fdd(&channels, &fdd::FddOptions::default()).unwrap();
    assert!(found.frequency_hz.len() <= (1 << 16) + 1);
    let many: Vec<&[f64]> = (0..60)
        .map(|k| &long[20_000 * k..20_000 * (k + 1)])
        .collect();
    let channels = ResponseChannels::new(&many, 1000.0).unwrap();
    let found = fdd(&channels, &fdd::FddOptions::default()).unwrap();
    assert!(found.frequency_hz.len() * many.len().pow(2) <= (1 << 24) + many.len().pow(2));
}

/// Two equal channels, a pure sine, one channel: an answer or an error with a hint, never a panic.
#[test]
fn survives_poor_records() {
    let sine: Vec<f64> = (0..3000).map(|t| (0.3 * f64::from(t)).sin()).collect();
    for samples in [vec![&sine[..]], vec![&sine[..], &sine[..]]] {
        let channels = ResponseChannels::new(&samples, 10.0).unwrap();
        for weighting in [Weighting::Covariances, Weighting::Projection] {
            let options = SsiOptions {
                weighting,
                ..SsiOptions::default()
            };
            let found = ssi::identify(&channels, &options).unwrap();
            assert!(found.modes.len() <= 1, "{:?}", frequencies(&found.modes));
        }
        let found = fdd(&channels, &fdd::FddOptions::default()).unwrap();
        assert!(found.peaks.iter().any(|p| p.harmonic.is_sine()));
    }
}

/// Columns of a delimited text file, by their place.
fn columns(file: &str, delimiter: char, header: usize, wanted: &[usize]) -> Vec<Vec<f64>> {
    let folder =
        std::env::var("GEARDYN_RECORDINGS").expect("GEARDYN_RECORDINGS names the folder of logs");
    let text = std::fs::read_to_string(std::path::Path::new(&folder).join(file)).unwrap();
    let mut channels = vec![Vec::new(); wanted.len()];
    for line in text.lines().skip(header) {
        let cells: Vec<&str> = line.split(delimiter).collect();
        for (channel, &k) in channels.iter_mut().zip(wanted) {
            channel.push(cells[k].trim().parse().unwrap());
        }
    }
    channels
}

/// A phone on a slab: the first mode by the peaks of the spectra (z axis), at the rate its stamps give.
/// Source: measured slab of CESSIPy (commit d8f1138a), its published modes.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_cessipy_slab() {
    let y = columns(
        "cessipy_smartphone/Example02_Smartphone_Data.csv",
        ',',
        1,
        &[3],
    );
    let y = slices(&y);
    let channels = ResponseChannels::new(&y, 425.0796).unwrap();
    let options = fdd::FddOptions {
        band_hz: Some((5.0, 100.0)),
        ..fdd::FddOptions::default()
    };
    let found = fdd(&channels, &options).unwrap();
    for p in &found.peaks {
        eprintln!(
            "{:.3} Hz, {:.1} times its valleys, {:?}",
            p.frequency_hz, p.prominence, p.harmonic
        );
    }
    let fine = fdd::FddOptions {
        segment: Some(2048),
        ..options.clone()
    };
    for p in fdd(&channels, &fine).unwrap().peaks {
        eprintln!(
            "2048: {:.3} Hz, {:.1}, {:?}",
            p.frequency_hz,
            p.prominence,
            p.mode.map(|m| (m.frequency_hz(), m.damping_ratio()))
        );
    }
    let strongest = found
        .peaks
        .iter()
        .max_by(|a, b| a.prominence.total_cmp(&b.prominence))
        .unwrap();
    assert!(
        (strongest.frequency_hz - 17.85).abs() < 0.1,
        "{}",
        strongest.frequency_hz
    );
}
