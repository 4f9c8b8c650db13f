//! What turns with a shaft, from tacho to orders, averages and separation, against closed forms; and against NumPy and SciPy:
//! `data/reference/rotation.json`, made by `tools/rotation.py`.

use std::f64::consts::{PI, TAU};

use geardyn::internals::base::code::Code;
use geardyn::internals::numeric::Complex;
use geardyn::internals::spectrum::band::{FrequencyBand, analytic_signal, baseband};
use geardyn::internals::spectrum::cepstrum::Cepstrum;
use geardyn::internals::spectrum::decimate::{DecimationOptions, Decimator, decimate};
use geardyn::internals::spectrum::envelope::squared_envelope_spectrum;
use geardyn::internals::spectrum::kaiser_fir::kaiser_beta;
use geardyn::internals::spectrum::rotation::angle_curve::AngleCurve;
use geardyn::internals::spectrum::rotation::angular_resampling::{AngularSignal, resample};
use geardyn::internals::spectrum::rotation::orders::{
    OrderTrackOptions, order_spectrum, order_tracks,
};
use geardyn::internals::spectrum::rotation::separation::{SeparationOptions, separate};
use geardyn::internals::spectrum::rotation::synchronous_average::SynchronousAverage;
use geardyn::internals::spectrum::rotation::tacho::{EdgeDirection, find_tacho_pulses};
use geardyn::internals::spectrum::spectrogram::{SpectrogramOptions, spectrogram};
use geardyn::internals::spectrum::window::bessel_i0;
use serde_json::Value;

use crate::support::noise::normal;
use crate::support::verification::within;

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap())
        .collect()
}

fn reference() -> Value {
    serde_json::from_str(include_str!("../../data/reference/rotation.json")).unwrap()
}

fn assert_near(ours: &[f64], theirs: &[f64], tolerance: f64) {
    assert_eq!(ours.len(), theirs.len());
    let gaps = ours.iter().zip(theirs).map(|(a, b)| (a - b).abs());
    within("values, absolute", gaps.fold(0.0, f64::max), tolerance);
}

fn mean_square(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64
}

fn db(ratio: f64) -> f64 {
    20.0 * ratio.log10()
}

/// Analytic signal, cepstrum, spectrogram, decimation and splines.
/// Source: SciPy 1.17.1, NumPy 2.4.6 (tools/rotation.py).
#[test]
fn ref_scipy() {
    let r = reference();
    let (x, rate) = (numbers(&r["signal"]), r["rate_hz"].as_f64().unwrap());
    let z = analytic_signal(&x, rate, None).unwrap();
    assert_near(&z.iter().map(|z| z.re).collect::<Vec<_>>(), &x, 1e-13);
    assert_near(
        &z.iter().map(|z| z.im).collect::<Vec<_>>(),
        &numbers(&r["analytic_im"]),
        1e-13,
    );
    assert_near(
        &Cepstrum::new(&x, rate).unwrap().real,
        &numbers(&r["cepstrum"]),
        1e-12,
    );
    let settings = SpectrogramOptions {
        block: 48,
        step: 24,
        averages: 1,
    };
    let rows = spectrogram(&x, rate, settings).unwrap();
    let theirs = &r["spectrogram"];
    assert_near(
        &rows.iter().map(|row| row.time_s).collect::<Vec<_>>(),
        &numbers(&theirs["time_s"]),
        1e-15,
    );
    for (row, density) in rows.iter().zip(theirs["density"].as_array().unwrap()) {
        assert_near(&row.density, &numbers(density), 1e-15);
    }
    let decimated = decimate(&x, 5, DecimationOptions::default()).unwrap();
    assert_near(&decimated, &numbers(&r["decimated_by_5"]), 1e-13);
    let spline = &r["spline"];
    let curve = AngleCurve::new(numbers(&spline["time_s"]), numbers(&spline["angle"])).unwrap();
    let at = numbers(&spline["at_s"]);
    assert_near(
        &at.iter().map(|&t| curve.angle_at(t)).collect::<Vec<_>>(),
        &numbers(&spline["value"]),
        1e-11,
    );
    assert_near(
        &at.iter().map(|&t| curve.speed(t)).collect::<Vec<_>>(),
        &numbers(&spline["speed"]),
        1e-9,
    );
    for (name, ours) in [
        ("bessel_i0", bessel_i0 as fn(f64) -> f64),
        ("kaiser_beta", kaiser_beta),
    ] {
        for pair in r[name].as_array().unwrap() {
            let pair = numbers(pair);
            within(
                "Bessel function and window parameter",
                (ours(pair[0]) - pair[1]).abs() / pair[1].max(1.0),
                1e-14,
            );
        }
    }
}

/// Tones of the pass band keep amplitude and phase to 1e-4 and need no shift; what would fold is 80 dB down; one stage or several.
#[test]
fn law_decimation_bands() {
    let settings = DecimationOptions::default();
    for factor in [3, 10, 48, 120] {
        let n = 300 * factor;
        let settling = Decimator::new(factor, settings).unwrap().transient_len();
        assert!(settling < 60, "{settling}");
        let tone = |f: f64, j: f64| (TAU * f * j + 0.8).cos();
        let mut worst = (0.0_f64, f64::NEG_INFINITY);
        for i in 1..=24 {
            let part = f64::from(i) / 24.0;
            let keep = 0.5 * settings.pass / factor as f64 * part;
            let x: Vec<f64> = (0..n).map(|j| tone(keep, j as f64)).collect();
            let y = decimate(&x, factor, settings).unwrap();
            for j in settling..y.len() - settling {
                worst.0 = worst.0.max((y[j] - tone(keep, (j * factor) as f64)).abs());
            }
            let fold = 0.5 / factor as f64 + (0.5 - 0.5 / factor as f64) * (part - 1.0 / 24.0);
            let x: Vec<f64> = (0..n).map(|j| tone(fold, j as f64)).collect();
            let y = decimate(&x, factor, settings).unwrap();
            let inside = &y[settling..y.len() - settling];
            worst.1 = inside.iter().fold(worst.1, |w, y| w.max(db(y.abs())));
        }
        println!(
            "factor {factor}: ripple {:.1e}, aliases {:.1} dB, settling {settling}",
            worst.0, worst.1
        );
        assert!(worst.0 < 1e-4 && worst.1 < -80.0, "{factor}: {worst:?}");
    }
}

/// Zoom: a tone inside the band turns at its distance from the band's first line.
#[test]
fn exact_zoom() {
    let (n, rate, f) = (5000, 1000.0, 207.4);
    let x: Vec<f64> = (0..n)
        .map(|j| 3.0 * (TAU * f * f64::from(j) / rate + 0.2).cos())
        .collect();
    let zoom = baseband(
        &x,
        rate,
        FrequencyBand {
            low_hz: 200.0,
            high_hz: 210.0,
        },
    )
    .unwrap();
    assert!((zoom.origin_hz - 200.0).abs() < 1e-12);
    assert!(zoom.values.len() < 120);
    for (j, z) in zoom.values.iter().enumerate() {
        let t = j as f64 / zoom.rate_hz;
        let expected = Complex::from_polar(3.0, TAU * (f - 200.0) * t + 0.2);
        within("samples", (z - expected).norm(), 1e-11);
    }
}

/// Bursts of a resonance at 3 kHz, 87 a second, under twice their power of noise: the squared envelope has lines at 87 Hz and its harmonics.
#[test]
fn law_bursts_show_in_the_envelope() {
    let (n, rate, repeat) = (50_000, 25_000.0, 87.0);
    let mut rng = fastrand::Rng::with_seed(12);
    let burst = |t: f64| {
        let since = (t * repeat).fract() / repeat;
        (-since * 900.0).exp() * (TAU * 3000.0 * since).sin()
    };
    let x: Vec<f64> = (0..n)
        .map(|j| burst(f64::from(j) / rate) + 0.3 * normal(&mut rng))
        .collect();
    let lines = squared_envelope_spectrum(
        &x,
        rate,
        FrequencyBand {
            low_hz: 2400.0,
            high_hz: 3600.0,
        },
    )
    .unwrap();
    let mut sorted = lines.amplitude.clone();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[sorted.len() / 2];
    for k in 1..=5 {
        let at = lines
            .frequency_hz
            .iter()
            .position(|f| (f - repeat * f64::from(k)).abs() < 0.3)
            .unwrap();
        assert!(
            lines.amplitude[at] > 10.0 * median,
            "{k}: {} over {median}",
            lines.amplitude[at]
        );
    }
}

/// A run-up: θ(t) = w₀ t + ½ α t².
struct RunUp {
    start: f64,
    acceleration: f64,
}

impl RunUp {
    fn angle(&self, t: f64) -> f64 {
        self.start * t + 0.5 * self.acceleration * t * t
    }
}

/// Orders 1, 2.5 and 7 of a run-up from 10 to 50 turns a second, with an order far above the angular band: amplitudes and phases at
/// every speed are those put in. The angle comes from a tacho of smooth pulses.
#[test]
fn exact_orders_of_a_run_up() {
    let (rate, seconds) = (20_000.0, 8.0);
    let run = RunUp {
        start: TAU * 10.0,
        acceleration: TAU * 5.0,
    };
    let n = (rate * seconds) as usize;
    let time = |j: usize| j as f64 / rate;
    let tacho: Vec<f64> = (0..n).map(|j| (run.angle(time(j)) + 1.0).sin()).collect();
    let found = find_tacho_pulses(&tacho, rate, EdgeDirection::Rising, None).unwrap();
    assert!(found.missing.is_empty() && found.extra_pulses_s.is_empty());
    let curve = AngleCurve::from_pulses(&found, 1).unwrap();
    // zero angle is the first rising edge, where θ + 1 = 2π
    let theta = |t: f64| run.angle(t) + 1.0 - TAU;
    for i in 0..100 {
        let t = curve.time_range_s().0 + 7.7 * f64::from(i) / 100.0;
        assert!(
            (curve.angle_at(t) - theta(t)).abs() < 2e-5,
            "{t}: {}",
            curve.angle_at(t) - theta(t)
        );
    }
    let orders = [(1.0, 2.0, 0.3), (2.5, 0.5, -1.0), (7.0, 1.0, 2.0)];
    let x: Vec<f64> = (0..n)
        .map(|j| {
            let angle = theta(time(j));
            let wanted: f64 = orders
                .iter()
                .map(|(o, a, p)| a * (o * angle + p).cos())
                .sum();
            wanted + 3.0 * (61.0 * angle).cos() // would fold onto order 3 of 64 values a turn
        })
        .collect();
    let signal = resample(&x, rate, &curve, 64).unwrap();
    assert!(signal.revolutions() > 230, "{}", signal.revolutions());
    let tracks = order_tracks(
        &signal,
        &curve,
        &[1.0, 2.5, 7.0, 3.0],
        OrderTrackOptions {
            revolutions: 8,
            step: 4,
        },
    )
    .unwrap();
    for (track, (order, amplitude, phase)) in tracks.tracks.iter().zip(orders) {
        assert_eq!(track.order, order);
        let expected = Complex::from_polar(amplitude, phase);
        let worst = track
            .values
            .iter()
            .fold(0.0_f64, |w, z| w.max((z - expected).norm() / amplitude));
        println!("order {order}: off by {worst:.1e}");
        within("amplitude and phase of orders", worst, 3e-4);
    }
    assert!(
        tracks.tracks[3]
            .values
            .iter()
            .all(|z| z.norm() < 1e-3 * 3.0)
    );
    for (t, speed) in tracks.time_s.iter().zip(&tracks.speed) {
        assert!((speed / (run.start + run.acceleration * t) - 1.0).abs() < 1e-3);
    }
    let spectrum = order_spectrum(&signal, 10).unwrap();
    for (order, amplitude, phase) in orders {
        let line = (order * 10.0) as usize;
        assert!((spectrum.order[line] - order).abs() < 1e-12);
        within(
            "amplitude of the mean spectrum",
            (spectrum.amplitude[line] / amplitude - 1.0).abs(),
            3e-4,
        );
        assert!(
            (spectrum.coherent_amplitude[line] - Complex::from_polar(amplitude, phase)).norm()
                < 3e-4 * amplitude
        );
    }
    assert!(spectrum.amplitude[30] < 1e-3 * 3.0);
}

/// Steep pulses, 12 a turn, with jitter of 0.2 % of their distance, two of them missing and one extra: the mean speed is right to the
/// jitter over the run, and both faults are located.
#[test]
fn law_tacho_with_faults() {
    let (rate, n) = (50_000.0, 250_000);
    let mut rng = fastrand::Rng::with_seed(21);
    let speed = TAU * 24.7;
    let spacing = rate / (24.7 * 12.0);
    let mut x: Vec<f64> = (0..n).map(|_| 0.05 * normal(&mut rng)).collect();
    let mut place = |at: f64| {
        (0..20).for_each(|j| x[at as usize + j] += 5.0);
    };
    let at = |k: usize| 30.0 + spacing * k as f64;
    for k in 0..1480 {
        if k != 400 && k != 401 {
            place(at(k) + 0.002 * spacing * normal(&mut rng));
        }
    }
    place(at(900) + 0.5 * spacing);
    let found = find_tacho_pulses(&x, rate, EdgeDirection::Rising, None).unwrap();
    assert_eq!(found.missing.len(), 1);
    assert_eq!(found.missing[0].number, 2);
    assert!((found.missing[0].after_s - at(399) / rate).abs() < 2.0 / rate);
    assert_eq!(found.extra_pulses_s.len(), 1);
    assert!((found.extra_pulses_s[0] - (at(900) + 0.5 * spacing) / rate).abs() < 2.0 / rate);
    let curve = AngleCurve::from_pulses(&found, 12).unwrap();
    let (from, to) = curve.time_range_s();
    let mean = (curve.angle_at(to) - curve.angle_at(from)) / (to - from);
    assert!((mean / speed - 1.0).abs() < 1e-5, "{mean} {speed}");
}

/// A periodic signal and noise: the average is the signal within the standard error stated, the residual is the noise, and averaging over the
/// wrong shaft leaves nothing.
#[test]
fn law_average_over_turns() {
    let (rate, turns_s) = (8000.0, 12.3);
    let n = 160_000;
    let mut rng = fastrand::Rng::with_seed(31);
    let angle = |j: usize| TAU * turns_s * j as f64 / rate;
    let shape = |a: f64| (3.0 * a).cos() + 0.5 * (17.0 * a + 1.0).sin();
    let x: Vec<f64> = (0..n).map(|j| shape(angle(j)) + normal(&mut rng)).collect();
    let curve = AngleCurve::constant_speed(TAU * turns_s, n as f64 / rate).unwrap();
    let per_turn = 256;
    let average = SynchronousAverage::new(&resample(&x, rate, &curve, per_turn).unwrap()).unwrap();
    assert!(average.revolutions >= 240);
    assert!(
        (average.noise_reduction_db() - 10.0 * (average.revolutions as f64).log10()).abs() < 1e-12
    );
    let off: Vec<f64> = (0..per_turn)
        .map(|i| average.values[i] - shape(TAU * i as f64 / per_turn as f64))
        .collect();
    let (measured, stated) = (mean_square(&off).sqrt(), average.standard_error);
    println!(
        "average off by {measured:.4} rms, {stated:.4} stated; residual {:.4}",
        average.residual_rms
    );
    assert!((measured / stated - 1.0).abs() < 0.15);
    // noise of the sample rate's whole band, less what the angular band (0.39 of it) stops
    let band: f64 = per_turn as f64 * turns_s / rate * 0.925;
    assert!((average.residual_rms / band.sqrt() - 1.0).abs() < 0.03);
    let rest = average.subtract_from(&x, rate, &curve).unwrap();
    assert!(
        (mean_square(&rest[..n - 1000]) - 1.0).abs() < 0.03,
        "{}",
        mean_square(&rest)
    );
}

/// Two shafts at 20/31: each average holds its own part, and without it the other is left.
#[test]
fn exact_two_shafts() {
    let rate = 10_000.0;
    let n = 200_000;
    let run = RunUp {
        start: TAU * 20.0,
        acceleration: TAU * 0.5,
    };
    let t = |j: usize| j as f64 / rate;
    let knots: Vec<f64> = (0..2001).map(|i| f64::from(i) * 0.01).collect();
    let curve =
        AngleCurve::new(knots.clone(), knots.iter().map(|&t| run.angle(t)).collect()).unwrap();
    let second = curve.scaled_by_ratio(20, 31).unwrap();
    let (one, two) = (
        |a: f64| (4.0 * a).cos(),
        |a: f64| 0.7 * (5.0 * a + 0.4).sin(),
    );
    let x: Vec<f64> = (0..n)
        .map(|j| one(run.angle(t(j))) + two(run.angle(t(j)) * 20.0 / 31.0))
        .collect();
    let signal = resample(&x, rate, &curve, 128).unwrap();
    let cut = 31 * (signal.revolutions() / 31) * 128; // whole common periods
    let whole = AngularSignal {
        values: signal.values[..cut].to_vec(),
        ..signal
    };
    let average = SynchronousAverage::new(&whole).unwrap();
    let close = |average: &SynchronousAverage, shape: &dyn Fn(f64) -> f64| {
        let n = average.values.len();
        (0..n).all(|i| (average.values[i] - shape(TAU * i as f64 / n as f64)).abs() < 2e-4)
    };
    assert!(close(&average, &one));
    let rest = average.subtract_from(&x, rate, &curve).unwrap();
    let after = SynchronousAverage::new(&resample(&rest, rate, &second, 128).unwrap()).unwrap();
    assert!(close(&after, &two));
    assert!(after.residual_rms < 1e-3, "{}", after.residual_rms);
}

/// Tones (also between lines) and noise: each part has its own power.
#[test]
fn law_separation() {
    let n = 100_000;
    let mut rng = fastrand::Rng::with_seed(17);
    let mut before = 0.0;
    let tones: Vec<f64> = (0..n)
        .map(|j| {
            let t = f64::from(j);
            (TAU * 0.05123 * t).cos()
                + 0.5 * (TAU * 0.1301 * t + 1.0).cos()
                + 0.25 * (TAU * 0.3127 * t).sin()
        })
        .collect();
    let noise: Vec<f64> = (0..n)
        .map(|_| {
            before = 0.8 * before + 0.6 * normal(&mut rng); // coloured, of unit variance
            before
        })
        .collect();
    let x: Vec<f64> = tones.iter().zip(&noise).map(|(a, b)| a + b).collect();
    let parts = separate(
        &x,
        SeparationOptions {
            block: 2048,
            gap: 50,
        },
    )
    .unwrap();
    let off: Vec<f64> = parts
        .deterministic
        .iter()
        .zip(&tones)
        .map(|(a, b)| a - b)
        .collect();
    let (tone, random, error) = (
        mean_square(&parts.deterministic),
        mean_square(&parts.random),
        mean_square(&off),
    );
    println!(
        "tones {tone:.4} of {:.4}, random {random:.4} of {:.4}, error {error:.5}",
        mean_square(&tones),
        mean_square(&noise)
    );
    assert!((tone / mean_square(&tones) - 1.0).abs() < 0.03);
    assert!((random / mean_square(&noise) - 1.0).abs() < 0.03);
    assert!(error < 0.02);
    let ends = [&off[..2000], &off[off.len() - 2000..]].concat();
    assert!(mean_square(&ends) < 0.03, "{}", mean_square(&ends));
    let noise_alone = separate(
        &noise,
        SeparationOptions {
            block: 2048,
            gap: 50,
        },
    )
    .unwrap();
    assert!(
        mean_square(&noise_alone.deterministic) < 0.01,
        "{}",
        mean_square(&noise_alone.deterministic)
    );
    let sum = parts.deterministic.iter().zip(&parts.random).zip(&x);
    assert!(sum.into_iter().all(|((d, r), x)| (d + r - x).abs() < 1e-12));
}

#[test]
fn refuses_what_cannot_be() {
    let settings = |block, gap| SeparationOptions { block, gap };
    assert_eq!(
        separate(&[0.0; 100], settings(64, 10)).unwrap_err().code,
        Code::TooShort
    );
    assert_eq!(
        separate(&[0.0; 100], settings(7, 10)).unwrap_err().code,
        Code::OutOfRange
    );
    assert_eq!(
        separate(&[0.0; 9], settings(usize::MAX - 1, 1))
            .unwrap_err()
            .code,
        Code::TooShort
    );
    assert_eq!(
        find_tacho_pulses(&[0.0; 50], 1.0, EdgeDirection::Rising, None)
            .unwrap_err()
            .code,
        Code::NoSignal
    );
    let signal = AngularSignal {
        samples_per_rev: 4,
        first: -3,
        values: vec![1.0; 7],
    };
    assert_eq!(
        SynchronousAverage::new(&signal).unwrap_err().code,
        Code::TooShort
    );
    assert_eq!(order_spectrum(&signal, 2).unwrap_err().code, Code::TooShort);
    assert_eq!(
        order_spectrum(&signal, 0).unwrap_err().code,
        Code::OutOfRange
    );
    // silence is separated into silence
    let parts = separate(&[0.0; 1000], settings(64, 10)).unwrap();
    assert!(parts.deterministic.iter().all(|x| *x == 0.0));
    // an average that begins before angle zero puts each value at its own angle
    let ramp: Vec<f64> = (0..8).map(|i| f64::from((i + 1) % 4)).collect();
    let turned = AngularSignal {
        samples_per_rev: 4,
        first: -3,
        values: ramp,
    };
    assert_eq!(
        SynchronousAverage::new(&turned).unwrap().values,
        [0.0, 1.0, 2.0, 3.0]
    );
    assert!((turned.angle(3)).abs() < PI * f64::EPSILON);
}
