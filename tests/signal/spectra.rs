//! Averaged spectra, frequency responses and impact tests: against scipy, closed forms and repeated noise.

use std::f64::consts::TAU;

use geardyn::internals::base::code::Code;
use geardyn::internals::numeric::Complex;
use geardyn::internals::recording::frequency_responses::ChannelLabel;
use geardyn::internals::spectrum::force_pulses::is_impact;
use geardyn::internals::spectrum::frequency_smoothing::smoothed_spectra;
use geardyn::internals::spectrum::frf::{Estimator, estimate, required_pairs};
use geardyn::internals::spectrum::impact::{ImpactOptions, RejectReason, estimate_from_hits};
use geardyn::internals::spectrum::spectra::Spectra;
use geardyn::internals::spectrum::stepped_sine::{estimate_from_dwells, find_dwells};
use geardyn::internals::spectrum::tones;
use geardyn::internals::spectrum::welch::{Averaging, Detrend, WelchEstimator, WelchOptions};
use geardyn::internals::spectrum::window::Window;
use serde_json::Value;

fn options(block: usize, overlap: f64, window: Window) -> WelchOptions {
    WelchOptions {
        block,
        overlap,
        window,
        detrend: Detrend::None,
        averaging: Averaging::Linear,
    }
}

/// Normal numbers, by Box and Muller.
struct Noise(fastrand::Rng);

impl Noise {
    fn new(seed: u64) -> Noise {
        Noise(fastrand::Rng::with_seed(seed))
    }

    fn next(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.0.f64()).ln()).sqrt();
        radius * (TAU * self.0.f64()).cos()
    }

    fn take(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.next()).collect()
    }
}

fn welch(rate: f64, channels: &[&[f64]], pairs: &[(usize, usize)], with: &WelchOptions) -> Spectra {
    let mut estimator = WelchEstimator::new(rate, channels.len(), pairs, with).unwrap();
    estimator.push(channels);
    estimator.finish().unwrap()
}

fn add(a: &[f64], factor: f64, b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + factor * b).collect()
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap();
    list.iter().map(|x| x.as_f64().unwrap()).collect()
}

fn assert_all_close(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let largest = expected.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    for (k, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!(
            (a - b).abs() <= tolerance * largest,
            "{what}, {k}: {a} is not {b}"
        );
    }
}

fn reference() -> Value {
    serde_json::from_str(include_str!("../../data/reference/spectra.json")).unwrap()
}

/// Every window, sample by sample.
/// Source: SciPy 1.17.1 (tools/spectra.py).
#[test]
fn ref_scipy_windows() {
    let reference = reference();
    for (word, samples) in reference["windows"].as_object().unwrap() {
        let found = Window::parse(word).unwrap().samples(16);
        assert_all_close(&found, &numbers(samples), 1e-14, word);
    }
}

/// The signals of tools/spectra.py.
fn scipy_signals() -> (Vec<f64>, Vec<f64>) {
    let n = 1000_i64;
    let x: Vec<f64> = (0..n)
        .map(|j| ((37 * j * j + 11 * j) % 1009) as f64 / 1009.0 - 0.5)
        .collect();
    let y = (0..n)
        .map(|j| {
            let own = ((53 * j * j * j + 29 * j) % 997) as f64 / 997.0 - 0.5;
            let late = if j < 3 { 0.0 } else { 2.0 * x[j as usize - 3] };
            own + late + 0.25 + 0.001 * j as f64
        })
        .collect();
    (x, y)
}

/// Densities, cross density and coherence by averaged blocks.
/// Source: SciPy 1.17.1 (tools/spectra.py).
#[test]
fn ref_scipy_welch() {
    let reference = reference();
    let (x, y) = scipy_signals();
    for case in reference["welch"].as_array().unwrap() {
        let number = |key: &str| case[key].as_f64().unwrap();
        let word = case["window"].as_str().unwrap();
        let with = WelchOptions {
            overlap: number("overlap") / number("block"),
            detrend: match case["detrend"].as_str().unwrap() {
                "constant" => Detrend::Mean,
                "linear" => Detrend::Linear,
                _ => Detrend::None,
            },
            ..options(number("block") as usize, 0.0, Window::parse(word).unwrap())
        };
        let found = welch(512.0, &[&x, &y], &[(0, 1)], &with);
        assert_all_close(
            &found.frequency_hz,
            &numbers(&case["frequency_hz"]),
            1e-15,
            word,
        );
        assert_all_close(&found.psd[0], &numbers(&case["pxx"]), 1e-12, word);
        assert_all_close(&found.psd[1], &numbers(&case["pyy"]), 1e-12, word);
        let cross = found.cross(0, 1).unwrap();
        let re: Vec<f64> = cross.iter().map(|z| z.re).collect();
        let im: Vec<f64> = cross.iter().map(|z| z.im).collect();
        assert_all_close(&re, &numbers(&case["pxy"]["re"]), 1e-12, word);
        assert_all_close(&im, &numbers(&case["pxy"]["im"]), 1e-12, word);
        let coherence = found.coherence(1, 0).unwrap();
        // 0/0 at 0 Hz, where the mean is taken off and the window lets nothing else in.
        let skip = usize::from(word != "kaiser:8.6");
        assert_all_close(
            &coherence[skip..],
            &numbers(&case["coherence"])[skip..],
            1e-9,
            word,
        );
    }
}

/// Parseval: with touching rectangular blocks the density adds up to the mean square, even and odd lengths.
#[test]
fn exact_parseval() {
    let x = Noise::new(1).take(1260);
    for block in [60, 63] {
        let found = welch(100.0, &[&x], &[], &options(block, 0.0, Window::Rectangular));
        let sum: f64 = found.psd[0].iter().sum::<f64>() * 100.0 / block as f64;
        let square = x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64;
        assert!((sum / square - 1.0).abs() < 1e-12, "{sum} {square}");
        assert!((found.averages.unwrap() / found.blocks as f64 - 1.0).abs() < 1e-12);
    }
}

/// A tone on a line reads its amplitude and rms under every window; its offset at 0 Hz.
#[test]
fn exact_tone_amplitudes() {
    let wave = |j: usize| 5.0 + 3.0 * (TAU * 20.0 * j as f64 / 128.0).cos();
    let x: Vec<f64> = (0..1280).map(wave).collect();
    for word in [
        "rectangular",
        "hann",
        "hamming",
        "flat-top",
        "blackman-harris",
    ] {
        let found = welch(
            128.0,
            &[&x],
            &[],
            &options(128, 0.5, Window::parse(word).unwrap()),
        );
        assert!((found.amplitude(0)[20] - 3.0).abs() < 1e-12, "{word}");
        assert!((found.rms(0)[20] - 4.5_f64.sqrt()).abs() < 1e-12, "{word}");
        assert!((found.amplitude(0)[0] - 5.0).abs() < 1e-12, "{word}");
    }
}

/// The same bits however the stream is cut; blocks never span a gap.
#[test]
fn law_chunks_and_gaps() {
    let mut noise = Noise::new(2);
    let (x, y) = (noise.take(1000), noise.take(1000));
    let with = WelchOptions::default();
    let with = WelchOptions { block: 64, ..with };
    let whole = welch(1.0, &[&x, &y], &[(0, 1)], &with);
    let mut cut = WelchEstimator::new(1.0, 2, &[(0, 1)], &with).unwrap();
    let mut at = 0;
    for length in [0, 1, 63, 7, 200, 129, 600] {
        cut.push(&[&x[at..at + length], &y[at..at + length]]);
        at += length;
    }
    let cut = cut.finish().unwrap();
    assert_eq!(cut.psd, whole.psd);
    assert_eq!(cut.cross[0].values, whole.cross[0].values);
    let mut gapped = WelchEstimator::new(1.0, 1, &[], &with).unwrap();
    gapped.push(&[&x[..100]]);
    gapped.end_segment();
    gapped.push(&[&x[..100]]);
    assert_eq!(gapped.blocks(), 4);
    let gapped = gapped.finish().unwrap();
    // Two stretches of two blocks: 4/(1 + ρ), ρ = 1/36.
    assert!((gapped.averages.unwrap() - 4.0 * 36.0 / 37.0).abs() < 1e-12);
}

/// Welch's formula for K blocks: `K/(1 + 2 Σ (1 − j/K) ρ(j))`, as the sum carried along finds it.
#[test]
fn exact_averages_by_welch() {
    let x = vec![1.0; 64 * 10];
    let found = welch(1.0, &[&x], &[], &options(64, 0.75, Window::Hann));
    let w = Window::Hann.samples(64);
    let k = found.blocks as f64;
    let rho = |j: usize| geardyn::internals::spectrum::window::overlap_correlation(&w, 16 * j);
    let sum: f64 = (1..4).map(|j| (1.0 - j as f64 / k) * rho(j)).sum();
    assert_eq!(found.blocks, 37);
    assert!((found.averages.unwrap() - k / (1.0 + 2.0 * sum)).abs() < 1e-10);
}

/// Of repeated noise the densities scatter as the number of averages says, and χ² intervals hold the truth as often as they claim.
#[test]
fn law_random_error_of_densities() {
    let mut noise = Noise::new(3);
    let cases = [
        (0.5, Window::Hann, Averaging::Linear),
        (0.8, Window::FlatTop, Averaging::Linear),
        (0.6, Window::Kaiser(8.6), Averaging::Exponential(4.0)),
    ];
    for (overlap, window, averaging) in cases {
        let with = WelchOptions {
            averaging,
            ..options(64, overlap, window)
        };
        let (mut sum, mut squares, mut held, mut count) = (0.0, 0.0, 0.0, 0.0);
        let mut averages = 0.0;
        for _ in 0..400 {
            let found = welch(2.0, &[&noise.take(640)], &[], &with);
            averages = found.averages.unwrap();
            let (low, high) = found.confidence_factors(10, 0.9).unwrap();
            for &s in &found.psd[0][6..26] {
                sum += s;
                squares += s * s;
                held += f64::from(u8::from(s * low <= 1.0 && 1.0 <= s * high));
                count += 1.0;
            }
        }
        let mean: f64 = sum / count;
        let scatter = squares / count - mean * mean;
        assert!((mean - 1.0).abs() < 0.02, "{mean}");
        assert!(
            (scatter * averages - 1.0).abs() < 0.1,
            "{window:?} {scatter}"
        );
        assert!((held / count - 0.9_f64).abs() < 0.015, "{}", held / count);
    }
}

#[test]
fn refuses_and_survives_blocks() {
    let new = |rate, with: WelchOptions| {
        WelchEstimator::new(rate, 1, &[(0, 0)], &with)
            .err()
            .map(|e| e.code)
    };
    let plain = WelchOptions::default;
    assert_eq!(new(0.0, plain()), Some(Code::OutOfRange));
    assert_eq!(new(f64::NAN, plain()), Some(Code::OutOfRange));
    let bad = |change: fn(&mut WelchOptions)| {
        let mut with = plain();
        change(&mut with);
        new(1.0, with)
    };
    assert_eq!(bad(|w| w.block = 2), Some(Code::OutOfRange));
    assert_eq!(bad(|w| w.overlap = 1.0), Some(Code::OutOfRange));
    assert_eq!(
        bad(|w| w.window = Window::Kaiser(-1.0)),
        Some(Code::OutOfRange)
    );
    assert_eq!(
        bad(|w| w.averaging = Averaging::Exponential(0.5)),
        Some(Code::OutOfRange)
    );
    assert_eq!(
        bad(|w| w.averaging = Averaging::PeakHold),
        Some(Code::Conflict)
    );
    let finish = |x: &[f64], averaging| {
        let with = WelchOptions {
            averaging,
            ..options(16, 0.0, Window::Hann)
        };
        let mut estimator = WelchEstimator::new(1.0, 1, &[], &with).unwrap();
        estimator.push(&[x]);
        estimator.finish()
    };
    assert_eq!(
        finish(&[1.0; 15], Averaging::Linear).unwrap_err().code,
        Code::TooShort
    );
    let mut holed = [1.0; 48];
    holed[3] = f64::NAN;
    for averaging in [Averaging::Linear, Averaging::PeakHold] {
        assert_eq!(finish(&holed, averaging).unwrap_err().code, Code::Overflow);
    }
    let silent = finish(&[0.0; 48], Averaging::PeakHold).unwrap();
    assert!(silent.psd[0].iter().all(|&s| s == 0.0) && silent.averages.is_none());
}

/// Noise on the input lowers H1 by `1 + S_mm/S_uu` and leaves H2; noise on the output raises H2 by `1 + S_nn/S_vv` and leaves H1;
/// equal shares of noise on both sides leave Hv.
#[test]
fn law_bias_of_h1_h2_hv() {
    let mut noise = Noise::new(4);
    let n = 400_000;
    let u = noise.take(n);
    let y: Vec<f64> = u.iter().map(|u| -2.0 * u).collect();
    let (m, e) = (noise.take(n), noise.take(n));
    let mean = |input: f64, output: f64, estimator| {
        let (x, y) = (add(&u, input, &m), add(&y, output, &e));
        let spectra = welch(1.0, &[&x, &y], &[(0, 1)], &options(100, 0.5, Window::Hann));
        let found = estimate(&spectra, &[0], &[1], estimator).unwrap();
        let values = &found.functions[0].values[2..48];
        values.iter().sum::<Complex>() / values.len() as f64
    };
    let cases = [
        (0.5, 0.0, Estimator::H1, -2.0 / 1.25),
        (0.5, 0.0, Estimator::H2, -2.0),
        (0.0, 1.0, Estimator::H1, -2.0),
        (0.0, 1.0, Estimator::H2, -2.0 * 1.25),
        (0.5, 1.0, Estimator::Hv, -2.0),
        (0.5, 1.0, Estimator::H1, -2.0 / 1.25),
    ];
    for (input, output, estimator, expected) in cases {
        let found = mean(input, output, estimator);
        assert!(
            (found - expected).norm() < 0.005 * 2.0,
            "{estimator:?}: {found} is not {expected}"
        );
    }
}

/// Over repeated noise the stated variance is the scatter: one input by each estimator, with and without overlap.
#[test]
fn law_variance_of_one_input() {
    let mut noise = Noise::new(5);
    for (overlap, estimator, tolerance) in [
        (0.0, Estimator::H1, 0.04),
        (0.5, Estimator::H1, 0.08),
        (0.0, Estimator::H2, 0.12),
        (0.0, Estimator::Hv, 0.08),
    ] {
        let (mut scatter, mut stated) = (0.0, 0.0);
        // The truth: H1 has the noise on the output, H2 on the input, Hv on both.
        let (input, output) = match estimator {
            Estimator::H1 => (0.0, 1.0),
            Estimator::H2 => (0.5, 0.0),
            Estimator::Hv => (0.35, 0.7),
        };
        for _ in 0..300 {
            let u = noise.take(32 * 40);
            let x = add(&u, input, &noise.take(u.len()));
            let y: Vec<f64> = u.iter().map(|u| 2.0 * u).collect();
            let y = add(&y, output, &noise.take(u.len()));
            let spectra = welch(
                1.0,
                &[&x, &y],
                &[(0, 1)],
                &options(32, overlap, Window::Hann),
            );
            let found = estimate(&spectra, &[0], &[1], estimator).unwrap();
            let f = &found.functions[0];
            for line in 3..14 {
                scatter += (f.values[line] - 2.0).norm_sqr();
                stated += f.variance.as_ref().unwrap()[line];
            }
        }
        let ratio: f64 = stated / scatter;
        println!("{estimator:?} overlap {overlap}: stated over found {ratio:.3}");
        assert!((ratio - 1.0).abs() < tolerance, "{estimator:?}: {ratio}");
    }
}

/// Two correlated inputs with a common output: unbiased, scatter as stated, partial coherence apart from the ordinary one.
#[test]
fn law_variance_of_two_inputs() {
    let mut noise = Noise::new(6);
    let (mut scatter, mut stated) = ([0.0; 2], [0.0; 2]);
    let mut sum = [Complex::new(0.0, 0.0); 2];
    let truth = [3.0, -1.0];
    let (mut count, mut partial, mut ordinary) = (0.0, 0.0, 0.0);
    for _ in 0..300 {
        let a = noise.take(32 * 12);
        let b = add(&noise.take(a.len()), 0.8, &a);
        let y = add(&add(&noise.take(a.len()), truth[0], &a), truth[1], &b);
        // A second output that only the second input drives.
        let z = add(&noise.take(a.len()), 2.0, &b);
        let with = options(32, 0.0, Window::Hann);
        let spectra = welch(
            1.0,
            &[&a, &y, &b, &z],
            &required_pairs(&[0, 2], &[1, 3]),
            &with,
        );
        let found = estimate(&spectra, &[0, 2], &[1, 3], Estimator::H1).unwrap();
        for line in 3..14 {
            for x in 0..2 {
                let f = &found.functions[x];
                scatter[x] += (f.values[line] - truth[x]).norm_sqr();
                stated[x] += f.variance.as_ref().unwrap()[line];
                sum[x] += f.values[line];
            }
            count += 1.0;
            partial += found.functions[2].partial_coherence[line];
            ordinary += found.functions[2].ordinary_coherence[line];
        }
    }
    for x in 0..2 {
        assert!(
            (sum[x] / count - truth[x]).norm() < 0.03,
            "{}",
            sum[x] / count
        );
        let ratio: f64 = stated[x] / scatter[x];
        println!("input {x}: stated over found {ratio:.3}");
        assert!((ratio - 1.0).abs() < 0.06, "{ratio}");
    }
    // Of 12 averages less one spent on the other input, 1/11 of coherence is chance.
    let (partial, ordinary): (f64, f64) = (partial / count, ordinary / count);
    assert!(
        (partial - 1.0 / 11.0).abs() < 0.02 && ordinary > 0.2,
        "{partial} {ordinary}"
    );
}

/// Hv with two inputs and equal shares of noise on everything is unbiased where H1 is not.
#[test]
fn law_hv_of_two_inputs() {
    let mut noise = Noise::new(8);
    let n = 200_000;
    let (a, b) = (noise.take(n), noise.take(n));
    let y = add(&add(&vec![0.0; n], 3.0, &a), 1.0, &b);
    let size = 10.0_f64.sqrt();
    let noisy = |x: &[f64], level: f64, noise: &mut Noise| add(x, level, &noise.take(n));
    let (a, b, y) = (
        noisy(&a, 0.3, &mut noise),
        noisy(&b, 0.3, &mut noise),
        noisy(&y, 0.3 * size, &mut noise),
    );
    let with = options(50, 0.5, Window::Hann);
    let spectra = welch(1.0, &[&a, &b, &y], &required_pairs(&[0, 1], &[2]), &with);
    let mean = |estimator| {
        let found = estimate(&spectra, &[0, 1], &[2], estimator).unwrap();
        let values = &found.functions[0].values[2..24];
        values.iter().sum::<Complex>().re / values.len() as f64
    };
    assert!(
        (mean(Estimator::Hv) - 3.0).abs() < 0.03,
        "{}",
        mean(Estimator::Hv)
    );
    assert!((mean(Estimator::H1) - 3.0 / 1.09).abs() < 0.03);
}

#[test]
fn refuses_inputs_it_cannot_tell_apart() {
    let mut noise = Noise::new(7);
    let (a, y) = (noise.take(4000), noise.take(4000));
    let b: Vec<f64> = a.iter().map(|a| -3.0 * a).collect();
    let spectra = |block: usize| {
        let with = options(block, 0.5, Window::Hann);
        welch(1.0, &[&a, &b, &y], &required_pairs(&[0, 1], &[2]), &with)
    };
    let code = |spectra: &Spectra, inputs: &[usize], outputs: &[usize], estimator| {
        estimate(spectra, inputs, outputs, estimator)
            .unwrap_err()
            .code
    };
    let good = spectra(100);
    assert_eq!(code(&good, &[0, 1], &[2], Estimator::H1), Code::IllPosed);
    assert_eq!(code(&good, &[0, 1], &[2], Estimator::H2), Code::Conflict);
    assert_eq!(code(&good, &[0, 0], &[2], Estimator::H1), Code::Conflict);
    assert_eq!(code(&good, &[0], &[0], Estimator::H1), Code::Conflict);
    assert_eq!(code(&good, &[], &[2], Estimator::H1), Code::Conflict);
    assert_eq!(code(&good, &[0], &[9], Estimator::H1), Code::NoChannel);
    assert_eq!(code(&good, &[2], &[0, 9], Estimator::H1), Code::NoChannel);
    assert_eq!(
        code(&spectra(3000), &[0, 1], &[2], Estimator::H1),
        Code::TooShort
    );
    let one = estimate(&spectra(4000), &[0], &[2], Estimator::H1).unwrap();
    assert!(one.functions[0].variance.is_none() && one.diagnostics[0].code == "one-average");
    let zero = vec![0.0; 4000];
    let with = options(100, 0.5, Window::Hann);
    let silent = welch(1.0, &[&zero, &y], &[(0, 1)], &with);
    assert_eq!(code(&silent, &[0], &[1], Estimator::H1), Code::NoSignal);
    let mute = estimate(&silent, &[1], &[0], Estimator::Hv).unwrap();
    assert!(mute.functions[0].values.iter().all(|h| h.norm() == 0.0));
    assert!(mute.multiple_coherence[0].iter().all(|&c| c == 0.0));
}

/// A digital oscillator `y_j = a₁ y_{j−1} + a₂ y_{j−2} + f_j`, whose response is known exactly, also along `z = exp((σ + iω)/f_s)`.
struct Oscillator {
    a1: f64,
    a2: f64,
    rate: f64,
}

impl Oscillator {
    fn new(frequency: f64, damping: f64, rate: f64) -> Oscillator {
        let (w, t) = (TAU * frequency, 1.0 / rate);
        let shrink = (-damping * w * t).exp();
        let turn = (w * (1.0 - damping * damping).sqrt() * t).cos();
        Oscillator {
            a1: 2.0 * shrink * turn,
            a2: -shrink * shrink,
            rate,
        }
    }

    fn run(&self, force: &[f64]) -> Vec<f64> {
        let (mut y1, mut y2) = (0.0, 0.0);
        let step = |f: &f64| {
            let y = self.a1 * y1 + self.a2 * y2 + f;
            (y2, y1) = (y1, y);
            y
        };
        force.iter().map(step).collect()
    }

    fn response(&self, frequency: f64, sigma: f64) -> Complex {
        let back = (Complex::new(-sigma, -TAU * frequency) / self.rate).exp();
        (Complex::new(1.0, 0.0) - back * self.a1 - back * back * self.a2).inv()
    }
}

/// Half sines of the given peak and 20 samples at these samples.
fn blows(n: usize, at: &[(usize, f64)]) -> Vec<f64> {
    let mut force = vec![0.0; n];
    for &(start, peak) in at {
        for j in 0..20 {
            force[start + j] += peak * (TAU * (j as f64 + 0.5) / 40.0).sin();
        }
    }
    force
}

/// Without noise, hits average to the exact response; what is double, overloaded or cut short is set aside and says so.
#[test]
fn exact_hits_and_faults() {
    let system = Oscillator::new(80.0, 0.02, 4000.0);
    let force = blows(
        30_000,
        &[
            (2000, 1.0),
            (7000, 0.7),
            (12_000, 0.9),
            (12_150, 0.3),
            (17_000, 2.0),
            (22_000, 1.2),
            (29_000, 1.0),
        ],
    );
    let y = system.run(&force);
    let force: Vec<f64> = force.iter().map(|f: &f64| f.min(1.5)).collect();
    let whole = 0..force.len();
    let found = estimate_from_hits(
        4000.0,
        &force,
        &[&y],
        std::slice::from_ref(&whole),
        &ImpactOptions::default(),
    )
    .unwrap();
    let faults: Vec<Option<RejectReason>> = found.hits.iter().map(|hit| hit.rejected).collect();
    assert_eq!(
        faults,
        [
            None,
            None,
            Some(RejectReason::Double),
            Some(RejectReason::Clipped(0)),
            None,
            Some(RejectReason::CutShort)
        ]
    );
    assert!((found.hits[0].sample as f64 / 4000.0 - 2009.0 / 4000.0).abs() < 3e-4);
    assert_eq!(found.estimate.window_decay, 0.0);
    let f = &found.estimate.functions[0];
    let peak = system.response(80.0, 0.0).norm();
    for (line, &hz) in found.estimate.frequency_hz.iter().enumerate() {
        if hz > 5.0 && hz < 200.0 {
            let error = (f.values[line] - system.response(hz, 0.0)).norm();
            assert!(error < 2e-3 * peak, "{hz} Hz: {error}");
            assert!(found.estimate.multiple_coherence[0][line] > 0.9999);
        }
    }
}

/// A response cut off while it rings: the exponential window gives the response with its pole moved by σ.
#[test]
fn exact_exponential_window() {
    let system = Oscillator::new(80.0, 0.0005, 4000.0);
    let force = blows(9000, &[(500, 1.0)]);
    let y = system.run(&force);
    let whole = 0..force.len();
    let run = |block, end| {
        let options = ImpactOptions {
            block,
            end,
            ..ImpactOptions::default()
        };
        estimate_from_hits(
            4000.0,
            &force,
            &[&y],
            std::slice::from_ref(&whole),
            &options,
        )
        .unwrap()
    };
    // As asked: a thousandth at the end of a second; none.
    let asked = run(Some(4000), Some(1e-3)).estimate.window_decay;
    assert!((asked - 1e3f64.ln()).abs() < 1e-12, "{asked}");
    assert_eq!(run(Some(4000), Some(1.0)).estimate.window_decay, 0.0);
    let found = run(Some(4000), None);
    let sigma = found.estimate.window_decay;
    assert!(sigma > 3.0, "{sigma}");
    for (line, &hz) in found.estimate.frequency_hz.iter().enumerate() {
        if hz > 5.0 && hz < 200.0 {
            let exact = system.response(hz, sigma);
            let error = (found.estimate.functions[0].values[line] - exact).norm();
            assert!(
                error < 0.012 * system.response(80.0, sigma).norm(),
                "{hz}: {error}"
            );
        }
    }
    assert!(
        found
            .estimate
            .to_frequency_responses(&[ChannelLabel::default(), ChannelLabel::default()])
            .responses[0]
            .coherence
            .is_none()
    );
}

/// A single hit in noise: its stated variance is the scatter over repeated noise.
#[test]
fn law_variance_of_a_single_hit() {
    let system = Oscillator::new(300.0, 0.03, 4000.0);
    let force = blows(5000, &[(2000, 1.0)]);
    let y = system.run(&force);
    let mut noise = Noise::new(9);
    let (mut scatter, mut stated) = (0.0, 0.0);
    let options = ImpactOptions {
        block: Some(1000),
        ..ImpactOptions::default()
    };
    let whole = 0..force.len();
    for _ in 0..200 {
        let f = add(&force, 0.002, &noise.take(5000));
        let y = add(&y, 0.02, &noise.take(5000));
        let found =
            estimate_from_hits(4000.0, &f, &[&y], std::slice::from_ref(&whole), &options).unwrap();
        let h = &found.estimate.functions[0];
        for line in 10..50 {
            let hz = found.estimate.frequency_hz[line];
            scatter += (h.values[line] - system.response(hz, 0.0)).norm_sqr();
            stated += h.variance.as_ref().unwrap()[line];
        }
    }
    let ratio: f64 = stated / scatter;
    println!("single hit: stated over found {ratio:.3}");
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
}

#[test]
fn refuses_what_is_no_hit() {
    let code = |force: &[f64]| {
        let whole = 0..force.len();
        let run = estimate_from_hits(
            1.0,
            force,
            &[force],
            std::slice::from_ref(&whole),
            &ImpactOptions::default(),
        );
        run.unwrap_err().code
    };
    assert_eq!(code(&[0.0; 100]), Code::NoSignal);
    assert_eq!(code(&[]), Code::NoSignal);
    let mut late = vec![0.0; 1000];
    late[0] = 1.0;
    assert_eq!(code(&late), Code::TooShort);
}

/// A sweep between rests: H1 over groups of lines is the exact response, with a coherence that only its change within a group lowers; in noise its variance is the scatter.
#[test]
fn exact_sweep() {
    let system = Oscillator::new(80.0, 0.02, 1000.0);
    let n = 30_000;
    let chirp = |j: usize| {
        let t = j as f64 / 1000.0;
        if j < 24_000 {
            (TAU * (10.0 * t + 0.5 * 8.0 * t * t)).sin()
        } else {
            0.0
        }
    };
    let x: Vec<f64> = (0..n).map(chirp).collect();
    let y = system.run(&x);
    let mut noise = Noise::new(10);
    let (mut scatter, mut stated) = (0.0, 0.0);
    let mut run = |level: f64| {
        let y = add(&y, level, &noise.take(n));
        let spectra = smoothed_spectra(1000.0, &[&x, &y], &[(0, 1)], 5).unwrap();
        let found = estimate(&spectra, &[0], &[1], Estimator::H1).unwrap();
        for (line, &hz) in found.frequency_hz.iter().enumerate() {
            if hz > 20.0 && hz < 190.0 {
                let exact = system.response(hz, 0.0);
                let error = (found.functions[0].values[line] - exact).norm();
                if level == 0.0 {
                    assert!(error < 0.01 * exact.norm(), "{hz} {error}");
                    assert!(found.multiple_coherence[0][line] > 0.998, "{hz}");
                } else {
                    scatter += error * error;
                    stated += found.functions[0].variance.as_ref().unwrap()[line];
                }
            }
        }
    };
    run(0.0);
    // So much noise that the change of the response within a group is nothing beside it.
    (0..20).for_each(|_| run(5.0));
    let ratio: f64 = stated / scatter;
    println!("sweep: stated over found {ratio:.3}");
    assert!((ratio - 1.0).abs() < 0.08, "{ratio}");
}

/// Stepped sines, each begun without rest from the one before: the settled part of each gives the exact response.
#[test]
fn exact_stepped_sine() {
    let system = Oscillator::new(80.0, 0.05, 2000.0);
    let steps = [40.0, 41.0, 60.0, 75.0, 80.0, 85.0, 120.3, 200.0];
    let mut noise = Noise::new(11);
    let (mut x, mut phase) = (Vec::new(), 0.0_f64);
    for f in steps {
        for _ in 0..3000 {
            phase += TAU * f / 2000.0;
            x.push(phase.sin() + 0.001 * noise.next());
        }
    }
    let y = system.run(&x);
    let found_dwells = find_dwells(&x, 2000.0);
    assert_eq!(found_dwells.len(), steps.len(), "{found_dwells:?}");
    let (force, shake) = (ChannelLabel::default(), ChannelLabel::default());
    let found = estimate_from_dwells(2000.0, (&force, &x), &[(&shake, &y)], &found_dwells)
        .unwrap()
        .responses;
    for (line, f) in steps.iter().enumerate() {
        assert!((found.frequency_hz[line] - f).abs() < 1e-4, "{f}");
        let exact = system.response(*f, 0.0);
        let error = (found.responses[0].values[line] - exact).norm();
        assert!(error < 2e-3 * exact.norm(), "{f}: {}", error / exact.norm());
    }
}

/// A measured hit on a beam: the force is known as one, and the response peaks where other tools find the modes.
/// Source: measured beam of ladisk/ImageBasedModalAnalysisTutorial; modes by its least-squares complex frequency fit.
#[test]
#[ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"]
fn ref_beam_hit() {
    let folder = std::env::var("GEARDYN_RECORDINGS").unwrap();
    let path = std::path::Path::new(&folder).join("ladisk_beam_camera/acceleration.lvm");
    let text = std::fs::read_to_string(path).unwrap().replace(',', ".");
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(23)
        .filter(|line| !line.trim().is_empty())
        .map(|line| {
            line.split_whitespace()
                .map(|x| x.parse().unwrap())
                .collect()
        })
        .collect();
    let column = |c: usize| rows.iter().map(|row| row[c]).collect::<Vec<f64>>();
    let (response, force) = (column(0), column(1));
    assert!(is_impact(&force) && !is_impact(&response));
    let found = estimate_from_hits(
        50_000.0,
        &force,
        &[&response],
        &[0..force.len()],
        &ImpactOptions::default(),
    )
    .unwrap();
    println!(
        "{:?} block {} σ {}",
        found.hits, found.block, found.estimate.window_decay
    );
    assert!((found.hits[0].peak - 195.6).abs() < 2.0);
    let f = &found.estimate.functions[0];
    for mode in [695.8, 1898.0, 3671.2] {
        let near = (0..f.values.len())
            .filter(|&k| (found.estimate.frequency_hz[k] / mode - 1.0).abs() < 0.1);
        let peak = near
            .max_by(|&i, &j| f.values[i].norm().total_cmp(&f.values[j].norm()))
            .unwrap();
        let hz = found.estimate.frequency_hz[peak];
        println!("{mode}: {hz} Hz");
        assert!((hz / mode - 1.0).abs() < 0.003, "{mode} {hz}");
    }
}

/// Two channels of 10^7 samples: time against that of their bare transforms.
#[test]
#[ignore = "study: speed of averaged spectra"]
fn study_speed_against_bare_transforms() {
    let mut noise = Noise::new(12);
    let (x, y) = (noise.take(10_000_000), noise.take(10_000_000));
    let n = 4096;
    let start = std::time::Instant::now();
    let mut fft = geardyn::internals::numeric::fft::RealFft::new(n);
    let mut work = vec![0.0; n];
    let mut lines = vec![Complex::new(0.0, 0.0); fft.lines()];
    for channel in [&x, &y] {
        for at in (0..channel.len() - n).step_by(n / 2) {
            work.copy_from_slice(&channel[at..at + n]);
            fft.forward(&mut work, &mut lines);
        }
    }
    let bare = start.elapsed().as_secs_f64();
    let start = std::time::Instant::now();
    let with = WelchOptions::default();
    let mut all = WelchEstimator::new(1.0, 2, &[(0, 1)], &with).unwrap();
    for (x, y) in x.chunks(50_000).zip(y.chunks(50_000)) {
        all.push(&[x, y]);
    }
    all.finish().unwrap();
    let whole = start.elapsed().as_secs_f64();
    println!("bare {bare:.3} s, averaged with coherence {whole:.3} s");
}

/// Sines on a line of the record, between two, at multiples of the rate of blocks, on a mode, near zero and near half the rate, alone,
/// several at once and a few lines apart: each is found where it is and taken out, and nothing besides.
#[test]
fn exact_sines_anywhere() {
    const RATE: f64 = 1000.0;
    const SAMPLES: usize = 20_000;
    let line = RATE / SAMPLES as f64;
    let sets: [&[(f64, f64)]; 15] = [
        &[(180.0, 2.0)],
        &[(180.0, 1.0)],
        &[(180.0 + 0.5 * line, 2.0)],
        &[(180.0 + 0.25 * line, 9.0)],
        &[(179.1, 2.0)],
        &[(333.3, 0.2)],
        &[(RATE / 1024.0 * 64.0, 1.0)],
        &[(RATE / 1000.0 * 125.0, 1.0)],
        &[(5.5 * line, 3.0)],
        &[(0.5 * RATE - 5.0 * line, 3.0)],
        &[(60.0, 0.5), (120.0, 0.4), (180.0, 1.0)],
        &[(59.7, 0.5), (119.4, 0.4), (179.1, 1.0)],
        &[(160.0, 1.0), (161.0, 1.0), (400.0, 20.0)],
        &[(140.0, 5.0), (140.0 + 9.0 * line, 1.0)],
        &[(140.0, 5.0), (140.0 + 8.5 * line, 5.0), (142.0, 0.2)],
    ];
    // A mode at 180 Hz, 2 % damped, driven by noise, with noise of a tenth of it: of variance one.
    let mut noise = Noise::new(0x5eed);
    let (radius, angle) = ((-TAU * 0.02 * 0.18_f64).exp(), TAU * 0.18);
    let (mut a, mut b) = (0.0, 0.0);
    let mut next = || {
        (a, b) = (
            2.0 * radius * angle.cos() * a - radius * radius * b + noise.next(),
            a,
        );
        a + noise.next()
    };
    (0..1000).for_each(|_| _ = next());
    let mut clean: Vec<f64> = (0..SAMPLES).map(|_| next()).collect();
    let power = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>() / SAMPLES as f64;
    let rms = power(&clean).sqrt();
    clean.iter_mut().for_each(|x| *x /= rms);
    assert_eq!(tones::remove_tones(RATE, &mut [clean.clone()]).unwrap(), []);
    for set in sets {
        let with = |channel: usize| -> Vec<f64> {
            let phase = |f: f64, t: usize| TAU * f * t as f64 / RATE + channel as f64;
            let sines = |t| set.iter().map(move |&(f, a)| a * phase(f, t).sin());
            let add = |(t, x): (usize, &f64)| x + sines(t).sum::<f64>();
            clean.iter().enumerate().map(add).collect()
        };
        let mut channels = [with(0), with(1)];
        let found = tones::remove_tones(RATE, &mut channels).unwrap();
        assert_eq!(found.len(), set.len(), "{set:?}: {found:?}");
        for (tone, (f, a)) in found.iter().zip(set) {
            let off = (tone.frequency_hz - f).abs();
            assert!(off < 0.15 * line, "{set:?}: {found:?}");
            assert!((tone.amplitude[1] - a).abs() < 0.3, "{set:?}: {found:?}");
        }
        for left in &channels {
            let off: Vec<f64> = left.iter().zip(&clean).map(|(l, c)| l - c).collect();
            assert!(
                power(&off) < 0.01 * set.len() as f64,
                "{set:?}: {}",
                power(&off)
            );
        }
    }
}
