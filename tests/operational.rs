//! Modes from responses alone: simulated structures whose modes are known, exact covariances, measured logs, bad records.

#[path = "support/noise.rs"]
mod noise;

use std::f64::consts::{PI, TAU};

use geardyn::base::code::Code;
use geardyn::identify::operational::channels::Channels;
use geardyn::identify::operational::covariances::{Covariances, Gathering};
use geardyn::identify::operational::decomposition::{self, decompose};
use geardyn::identify::operational::harmonics::Running;
use geardyn::identify::operational::selection::{OperationalMode, default_rule, physical};
use geardyn::identify::operational::subspace::{self, Settings, Subspace};

use noise::normal;

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
        (PI * (mode + 1) as f64 * (channel + 1) as f64 / (self.channels + 1) as f64).sin()
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

fn chosen(found: &Subspace, channels: &Channels) -> Vec<OperationalMode> {
    physical(found, channels, &default_rule(found), None)
}

/// `R_τ = Σ_m φ_m g_mᵀ Re(c λ_m^τ)` of two modes at three channels.
fn exact_covariances(lags: usize, rate: f64) -> Covariances {
    let poles: [(f64, f64); 2] = [(6.0, 0.01), (17.0, 0.03)];
    let mut mean = vec![0.0; (lags + 1) * 9];
    for (m, (f, zeta)) in poles.iter().enumerate() {
        let w = TAU * f;
        for lag in 0..=lags {
            let t = lag as f64 / rate;
            let decay = (-zeta * w * t).exp();
            let turn = (w * f64::sqrt(1.0 - zeta * zeta) * t).cos();
            for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                let shape = |k: usize| ((m + 1) as f64 * (k + 1) as f64 * 0.7).sin();
                mean[(lag * 3 + r) * 3 + c] += shape(r) * shape(c) * decay * turn;
            }
        }
    }
    Covariances {
        channels: 3,
        references: vec![0, 1, 2],
        lags,
        samples: 1000,
        mean,
        deviations: Vec::new(),
    }
}

/// Exact covariances give exact poles and shapes.
#[test]
fn exact_from_exact_covariances() {
    let settings = Settings {
        highest_order: Some(4),
        ..Settings::default()
    };
    let found = subspace::of_covariances(&exact_covariances(39, 100.0), 100.0, &settings).unwrap();
    assert_eq!(found.block_rows, 20);
    let modes = &found.orders[1].modes;
    for (m, (mode, (f, zeta))) in modes.iter().zip([(6.0, 0.01), (17.0, 0.03)]).enumerate() {
        assert!((mode.frequency_hz() / f - 1.0).abs() < 1e-10, "{mode:?}");
        assert!((mode.damping_ratio() - zeta).abs() < 1e-10);
        let shape: Vec<f64> = (0..3)
            .map(|k| ((m + 1) as f64 * (k + 1) as f64 * 0.7).sin())
            .collect();
        let largest = shape
            .iter()
            .copied()
            .max_by(|a, b| a.abs().total_cmp(&b.abs()))
            .unwrap();
        for (found, exact) in mode.shape.iter().zip(&shape) {
            assert!((found - exact / largest).norm() < 1e-9);
        }
    }
}

/// The pole's variance is the square of what a small change of the covariances does to it, also where the order is too low or too high.
#[test]
fn law_variance_is_the_square_of_the_change() {
    let mut rng = fastrand::Rng::with_seed(3);
    let mut base = exact_covariances(23, 100.0);
    base.mean
        .iter_mut()
        .for_each(|x| *x += 1e-2 * normal(&mut rng));
    let change: Vec<f64> = base.mean.iter().map(|_| normal(&mut rng)).collect();
    let h = 1e-6;
    let moved = |sign: f64| {
        let mut moved = base.clone();
        // lag 0 only sets the scale of the channels, which is held
        let scaled = moved.mean.iter_mut().zip(&change).skip(9);
        scaled.for_each(|(x, c)| *x += sign * h * c);
        subspace::of_covariances(
            &moved,
            100.0,
            &Settings {
                highest_order: Some(8),
                ..Settings::default()
            },
        )
        .unwrap()
    };
    let (up, down) = (moved(1.0), moved(-1.0));
    let blocks = 8;
    let mut with = base.clone();
    with.deviations = vec![vec![0.0; base.mean.len()]; blocks];
    with.deviations[3] = change.iter().map(|c| c * h).collect();
    let found = subspace::of_covariances(
        &with,
        100.0,
        &Settings {
            highest_order: Some(8),
            ..Settings::default()
        },
    )
    .unwrap();
    let mut compared = 0;
    for (k, order) in found.orders.iter().enumerate() {
        for (m, mode) in order.modes.iter().enumerate() {
            let Some([re, im, both]) = mode.pole_covariance else {
                continue;
            };
            let d = (up.orders[k].modes[m].pole - down.orders[k].modes[m].pole) / 2.0;
            let correction = blocks as f64 / (blocks - 1) as f64;
            let size = d.norm_sqr() * correction;
            assert!(
                (re - d.re * d.re * correction).abs() < 1e-3 * size,
                "order {} {re} {}",
                order.order,
                d.re * d.re
            );
            assert!((im - d.im * d.im * correction).abs() < 1e-3 * size);
            assert!((both - d.re * d.im * correction).abs() < 1e-3 * size);
            compared += 1;
        }
    }
    assert!(compared >= 6, "{compared}");
}

/// No hint given: the four modes and nothing else, within four of their own standard deviations; from data within 1 %.
#[test]
fn law_modes_of_a_frame_are_found() {
    let frame = frame();
    let y = frame.respond(1, 20_000);
    let y = slices(&y);
    let channels = Channels::new(&y, frame.rate).unwrap();
    let found = subspace::from_covariances(&channels, &Settings::default()).unwrap();
    let modes = chosen(&found, &channels);
    let all: Vec<_> = modes
        .iter()
        .map(|m| {
            (
                m.mode.frequency_hz(),
                m.mode.frequency_std_hz(),
                m.mode.damping_ratio(),
                m.presence,
            )
        })
        .collect();
    assert_eq!(modes.len(), 4, "{all:?}");
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
            (m.mode.damping_ratio() - zeta).abs() < 4.0 * sz && sz < 0.5 * zeta,
            "{f}: {m:?}"
        );
        assert!(!m.harmonic.is_harmonic(), "{f}: {:?}", m.harmonic);
        let exact: Vec<f64> = (0..5).map(|c| frame.shape(k, c)).collect();
        let product: geardyn::numeric::Complex = m
            .mode
            .shape
            .iter()
            .zip(&exact)
            .map(|(a, b)| a.conj() * b)
            .sum();
        let lengths = m.mode.shape.iter().map(|x| x.norm_sqr()).sum::<f64>()
            * exact.iter().map(|x| x * x).sum::<f64>();
        assert!(
            product.norm_sqr() / lengths > 0.98,
            "{f}: {:?}",
            m.mode.shape
        );
    }
    let found = subspace::from_data(
        &channels,
        &Settings {
            block_rows: Some(15),
            ..Settings::default()
        },
    )
    .unwrap();
    let modes = chosen(&found, &channels);
    eprintln!(
        "from data: {:?}",
        modes
            .iter()
            .map(|m| (m.mode.frequency_hz(), m.mode.damping_ratio(), m.presence))
            .collect::<Vec<_>>()
    );
    for &(f, _) in &frame.modes {
        let near = modes
            .iter()
            .any(|m| (m.mode.frequency_hz() / f - 1.0).abs() < 0.01);
        assert!(near, "{f} Hz from data");
    }
}

/// How often 95 % intervals of frequency and damping hold the truth over records of `samples`, all modes together.
fn coverage(seeds: u64, samples: usize) -> [f64; 2] {
    let frame = Structure {
        rate: 50.0,
        modes: vec![(4.0, 0.02), (11.0, 0.015)],
        channels: 2,
        sensor_noise: 0.2,
    };
    let settings = Settings {
        block_rows: Some(25),
        highest_order: Some(8),
        ..Settings::default()
    };
    let (mut hits, mut count) = ([0.0; 2], 0.0);
    for seed in 0..seeds {
        let y = frame.respond(500 + seed, samples);
        let y = slices(&y);
        let channels = Channels::new(&y, frame.rate).unwrap();
        let found = subspace::from_covariances(&channels, &settings).unwrap();
        let modes = &found.orders.last().unwrap().modes;
        for &(f, zeta) in &frame.modes {
            let near = modes
                .iter()
                .filter(|m| m.pole_covariance.is_some())
                .min_by(|a, b| {
                    let apart = |m: &geardyn::identify::mode::IdentifiedMode| {
                        (m.frequency_hz() - f).abs() + m.damping_ratio()
                    };
                    apart(a).total_cmp(&apart(b))
                });
            let mode = near.unwrap();
            let is_in =
                |x: f64, truth: f64, std: f64| f64::from(u8::from((x - truth).abs() < 1.96 * std));
            hits[0] += is_in(mode.frequency_hz(), f, mode.frequency_std_hz().unwrap());
            hits[1] += is_in(mode.damping_ratio(), zeta, mode.damping_std().unwrap());
            count += 1.0;
        }
    }
    hits.map(|h| h / count)
}

/// 40 records of two modes: 95 % intervals hold the truth in 86 % or more (80 trials scatter by 2.4 %, the deviation itself comes from
/// some forty blocks).
#[test]
fn law_intervals_cover() {
    let found = coverage(40, 10_000);
    assert!(found.iter().all(|c| *c >= 0.86), "{found:?}");
}

#[test]
#[ignore = "study: coverage over 400 records of three lengths"]
fn law_intervals_cover_often() {
    for samples in [4_000, 10_000, 30_000] {
        let found = coverage(400, samples);
        eprintln!(
            "{samples} samples: frequency {:.3}, damping {:.3}",
            found[0], found[1]
        );
        assert!(
            found.iter().all(|c| (0.88..0.99).contains(c)),
            "{samples}: {found:?}"
        );
    }
}

#[test]
#[ignore = "study: how many modes of the frame are found or made up, over 30 records of two lengths"]
fn law_choice_over_records() {
    let frame = frame();
    for samples in [5_000, 20_000] {
        let mut counts = [[0; 2]; 2];
        for seed in 0..30 {
            let y = frame.respond(100 + seed, samples);
            let y = slices(&y);
            let channels = Channels::new(&y, frame.rate).unwrap();
            let by_data = Settings {
                block_rows: Some(15),
                ..Settings::default()
            };
            let both = [
                subspace::from_covariances(&channels, &Settings::default()).unwrap(),
                subspace::from_data(&channels, &by_data).unwrap(),
            ];
            for (count, found) in counts.iter_mut().zip(&both) {
                let modes = chosen(found, &channels);
                let is_at =
                    |m: &OperationalMode, f: f64| (m.mode.frequency_hz() / f - 1.0).abs() < 0.02;
                let hit = frame
                    .modes
                    .iter()
                    .filter(|(f, _)| modes.iter().any(|m| is_at(m, *f)))
                    .count();
                count[0] += hit;
                count[1] += modes.len() - hit;
            }
        }
        eprintln!(
            "{samples} samples: of 120 modes found, and beside them, [covariances, data]: {counts:?}"
        );
        assert!(counts[0][0] >= 110, "{counts:?}");
    }
}

/// Covariances of a stream are those of the whole.
#[test]
fn law_stream_and_whole_agree() {
    let y = frame().respond(4, 6000);
    let gather = |length: usize| {
        let mut gathering = Gathering::new(5, &[0, 2], 30).unwrap();
        for from in (0..6000).step_by(length) {
            let to = (from + length).min(6000);
            let stretch: Vec<&[f64]> = y.iter().map(|c| &c[from..to]).collect();
            gathering.push(&stretch).unwrap();
        }
        gathering.finish().unwrap()
    };
    let (whole, stream) = (gather(6000), gather(77));
    assert_eq!(whole.samples, stream.samples);
    // offsets are taken from stretches of other lengths, and taken out again up to the ends
    assert!(
        whole
            .mean
            .iter()
            .zip(&stream.mean)
            .all(|(a, b)| (a - b).abs() < 1e-3)
    );
}

/// Frequency-domain decomposition: frequencies to 1 %, damping to a quarter, shapes; no mode taken for a sine.
#[test]
fn law_decomposition_of_a_frame() {
    let frame = frame();
    let y = frame.respond(7, 60_000);
    let y = slices(&y);
    let channels = Channels::new(&y, frame.rate).unwrap();
    let found = decompose(&channels, &decomposition::Settings::default()).unwrap();
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
    let channels = Channels::new(&y, frame.rate).unwrap();
    let found = decompose(&channels, &decomposition::Settings::default()).unwrap();
    let line = found
        .peaks
        .iter()
        .find(|p| (p.frequency_hz - 24.3).abs() < 0.05)
        .unwrap();
    assert!(line.harmonic.is_sine(), "{:?}", line.harmonic);
    let subspace = subspace::from_covariances(&channels, &Settings::default()).unwrap();
    for m in chosen(&subspace, &channels) {
        let f = m.mode.frequency_hz();
        assert_eq!(
            m.harmonic.is_sine(),
            (f - 24.3).abs() < 0.1,
            "{f} Hz: {:?}",
            m.harmonic
        );
    }
    let running = Running {
        speed_hz: 8.1,
        orders: vec![1.0, 3.0],
        tolerance: 0.005,
    };
    let settings = decomposition::Settings {
        running: Some(running),
        ..decomposition::Settings::default()
    };
    let found = decompose(&channels, &settings).unwrap();
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
    let code = |samples: &[&[f64]], rate: f64| Channels::new(samples, rate).unwrap_err().code;
    assert_eq!(code(&[], 1.0), Code::NoChannel);
    assert_eq!(code(&[&[]], 1.0), Code::EmptyLog);
    assert_eq!(code(&[&b, &a], 1.0), Code::NoSignal);
    assert_eq!(code(&[&b, &b[1..]], 1.0), Code::OutOfRange);
    assert_eq!(code(&[&b], f64::NAN), Code::OutOfRange);
    assert_eq!(code(&[&[1.0, f64::NAN, 2.0]], 1.0), Code::NotANumber);
    let (long, short) = ([&b[..], &b[..]], [&b[..30]]);
    let whole = Channels::new(&long, 100.0).unwrap();
    let cut = Channels::new(&short, 100.0).unwrap();
    let check = |channels: &Channels, settings: &Settings, code: Code| {
        for result in [
            subspace::from_covariances(channels, settings),
            subspace::from_data(channels, settings),
        ] {
            let error = result.unwrap_err();
            assert_eq!(error.code, code, "{error}");
            assert!(error.hint.is_some());
        }
    };
    let plain = Settings::default();
    check(&cut, &plain, Code::TooShort);
    check(
        &whole,
        &Settings {
            references: vec![5],
            ..plain.clone()
        },
        Code::NoChannel,
    );
    check(
        &whole,
        &Settings {
            block_rows: Some(0),
            ..plain.clone()
        },
        Code::OutOfRange,
    );
    check(
        &whole,
        &Settings {
            highest_order: Some(0),
            ..plain.clone()
        },
        Code::OutOfRange,
    );
    check(
        &whole,
        &Settings {
            lowest_hz: Some(80.0),
            ..plain
        },
        Code::OutOfRange,
    );
    let too_long = decomposition::Settings {
        segment: Some(400),
        ..decomposition::Settings::default()
    };
    assert_eq!(
        decompose(&whole, &too_long).unwrap_err().code,
        Code::TooShort
    );
    let nowhere = decomposition::Settings {
        band_hz: Some((70.0, 80.0)),
        ..decomposition::Settings::default()
    };
    assert_eq!(
        decompose(&whole, &nowhere).unwrap_err().code,
        Code::OutOfRange
    );
}

/// Two equal channels, a pure sine, one channel: an answer or an error with a hint, never a panic.
#[test]
fn survives_poor_records() {
    let sine: Vec<f64> = (0..3000).map(|t| (0.3 * f64::from(t)).sin()).collect();
    for samples in [vec![&sine[..]], vec![&sine[..], &sine[..]]] {
        let channels = Channels::new(&samples, 10.0).unwrap();
        for settings in [
            Settings::default(),
            Settings {
                block_rows: Some(12),
                ..Settings::default()
            },
        ] {
            if let Ok(found) = subspace::from_covariances(&channels, &settings) {
                chosen(&found, &channels);
            }
            if let Ok(found) = subspace::from_data(&channels, &settings) {
                chosen(&found, &channels);
            }
        }
        let found = decompose(&channels, &decomposition::Settings::default()).unwrap();
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

/// Simulated five-storey frame of the koma package at 12 Hz: five modes without a hint.
/// Source: simulated frame of koma (commit e28269d5), exact modes.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_koma_shear_frame() {
    let y = columns(
        "koma_shearframe/koma_shearframe.csv",
        ';',
        1,
        &[0, 1, 2, 3, 4],
    );
    let y = slices(&y);
    let channels = Channels::new(&y, 12.0).unwrap();
    let found = subspace::from_covariances(&channels, &Settings::default()).unwrap();
    let modes = chosen(&found, &channels);
    for m in &modes {
        eprintln!(
            "{:.4} rad/s ± {:.4}, damping {:.5} ± {:.5}, in {:.2} of the orders, {:?}",
            m.mode.pole.norm(),
            m.mode.frequency_std_hz().unwrap_or(f64::NAN) * TAU,
            m.mode.damping_ratio(),
            m.mode.damping_std().unwrap_or(f64::NAN),
            m.presence,
            m.harmonic
        );
    }
    let expected = [1.136, 3.297, 5.149, 6.556, 7.441];
    assert_eq!(modes.len(), expected.len());
    for (m, w) in modes.iter().zip(expected) {
        assert!(
            (m.mode.pole.norm() / w - 1.0).abs() < 0.005,
            "{w}: {}",
            m.mode.pole.norm()
        );
    }
    let found = subspace::from_data(&channels, &Settings::default()).unwrap();
    let modes = chosen(&found, &channels);
    let all: Vec<f64> = modes.iter().map(|m| m.mode.pole.norm()).collect();
    eprintln!("from data: {all:.4?}");
    for w in expected {
        assert!(
            all.iter().any(|x| (x / w - 1.0).abs() < 0.01),
            "{w} from data"
        );
    }
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
    let channels = Channels::new(&y, 425.0796).unwrap();
    let settings = decomposition::Settings {
        band_hz: Some((5.0, 100.0)),
        ..decomposition::Settings::default()
    };
    let found = decompose(&channels, &settings).unwrap();
    for p in &found.peaks {
        eprintln!(
            "{:.3} Hz, {:.1} times its valleys, {:?}",
            p.frequency_hz, p.prominence, p.harmonic
        );
    }
    let fine = decomposition::Settings {
        segment: Some(2048),
        ..settings.clone()
    };
    for p in decompose(&channels, &fine).unwrap().peaks {
        eprintln!(
            "2048: {:.3} Hz, {:.1}, {:?}",
            p.frequency_hz,
            p.prominence,
            p.mode.map(|m| (m.frequency_hz(), m.damping_ratio()))
        );
    }
    for m in chosen(
        &subspace::from_covariances(&channels, &Settings::default()).unwrap(),
        &channels,
    ) {
        eprintln!(
            "ssi {:.4} Hz ± {:.4}, damping {:.5} ± {:.5}, in {:.2}",
            m.mode.frequency_hz(),
            m.mode.frequency_std_hz().unwrap_or(f64::NAN),
            m.mode.damping_ratio(),
            m.mode.damping_std().unwrap_or(f64::NAN),
            m.presence
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

/// A text log next to the folder of recordings, made from a file the tests cannot read themselves.
fn unpacked(file: &str) -> Option<String> {
    std::env::var("GEARDYN_UNPACKED")
        .ok()
        .map(|folder| format!("{folder}/{file}"))
}

/// A simulated suspension bridge, modes from five responses.
/// Source: ECheynet/SSICOV (commit 82ce27aa), its six exact modes.
#[test]
#[ignore = "study: BridgeData.mat as text in the folder GEARDYN_UNPACKED"]
fn ref_echeynet_bridge() {
    let path = unpacked("echeynet.txt").unwrap();
    let y = columns(&path, ' ', 0, &[0, 1, 2, 3, 4]);
    let y = slices(&y);
    let channels = Channels::new(&y, 15.0).unwrap();
    let found = subspace::from_covariances(&channels, &Settings::default()).unwrap();
    let modes = chosen(&found, &channels);
    for m in &modes {
        eprintln!(
            "{:.4} Hz ± {:.4}, damping {:.5} ± {:.5}, in {:.2}",
            m.mode.frequency_hz(),
            m.mode.frequency_std_hz().unwrap_or(f64::NAN),
            m.mode.damping_ratio(),
            m.mode.damping_std().unwrap_or(f64::NAN),
            m.presence
        );
    }
    for p in decompose(&channels, &decomposition::Settings::default())
        .unwrap()
        .peaks
    {
        eprintln!(
            "peak {:.4} Hz, {:.1}, damping {:?}",
            p.frequency_hz,
            p.prominence,
            p.mode.map(|m| m.damping_ratio())
        );
    }
    for f in [0.2046, 0.3189, 0.4391, 0.5852, 0.8643, 1.1944] {
        assert!(
            modes
                .iter()
                .any(|m| (m.mode.frequency_hz() / f - 1.0).abs() < 0.02),
            "{f} Hz"
        );
    }
}

/// A measured test bridge, modes from responses.
/// Source: imcs-compsim/munich-bridge-data (commit f1057c12).
#[test]
#[ignore = "study: the AllM log of munich_bridge as CSV in the folder GEARDYN_UNPACKED"]
fn ref_munich_bridge() {
    let path = unpacked("munich.csv").unwrap();
    let y = columns(&path, ',', 1, &[1]);
    let y = slices(&y);
    let channels = Channels::new(&y, 100.0).unwrap();
    let found = decompose(&channels, &decomposition::Settings::default()).unwrap();
    for p in &found.peaks {
        eprintln!(
            "peak {:.4} Hz, {:.1}, {:?}, {:?}",
            p.frequency_hz,
            p.prominence,
            p.mode.as_ref().map(|m| m.damping_ratio()),
            p.harmonic
        );
    }
    let found_by_subspace = subspace::from_covariances(&channels, &Settings::default()).unwrap();
    for m in chosen(&found_by_subspace, &channels) {
        eprintln!(
            "{:.4} Hz ± {:.4}, damping {:.5} ± {:.5}, in {:.2}",
            m.mode.frequency_hz(),
            m.mode.frequency_std_hz().unwrap_or(f64::NAN),
            m.mode.damping_ratio(),
            m.mode.damping_std().unwrap_or(f64::NAN),
            m.presence
        );
    }
    for f in [10.79, 12.65, 13.62, 16.26] {
        assert!(
            found.peaks.iter().any(|p| (p.frequency_hz - f).abs() < 0.1),
            "{f} Hz"
        );
    }
}
