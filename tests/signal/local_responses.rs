//! Frequency responses by local polynomials against a recursion whose response is known in closed form.

use std::f64::consts::TAU;

use crate::support::verification::within;
use geardyn::internals::numeric::Complex;
use geardyn::internals::spectrum::frf::{self, Estimator};
use geardyn::internals::spectrum::local_polynomial::{LocalPolynomialEstimator, min_half_width};
use geardyn::internals::spectrum::welch::{WelchEstimator, WelchOptions};

const RATE: f64 = 1000.0;

/// `y_t = c₁ y_{t−1} + c₂ y_{t−2} + u_t` of a mode.
struct Mode {
    c: [f64; 2],
}

impl Mode {
    fn new(frequency_hz: f64, damping: f64) -> Mode {
        let omega = TAU * frequency_hz / RATE;
        let size = (-damping * omega).exp();
        let angle = omega * (1.0 - damping * damping).sqrt();
        Mode {
            c: [2.0 * size * angle.cos(), -size * size],
        }
    }

    /// The answer to an input, with what came before it.
    fn answer(&self, input: &[f64], before: [f64; 2]) -> Vec<f64> {
        let [mut last, mut older] = before;
        let step = |u: &f64| {
            let y = self.c[0] * last + self.c[1] * older + u;
            (last, older) = (y, last);
            y
        };
        input.iter().map(step).collect()
    }

    fn response(&self, frequency_hz: f64) -> Complex {
        let z = Complex::new(0.0, -TAU * frequency_hz / RATE).exp();
        (1.0 - z * self.c[0] - z * z * self.c[1]).inv()
    }
}

fn noise(samples: usize, seed: u64) -> Vec<f64> {
    // Neighbouring seeds of this generator give numbers that are correlated by a quarter.
    let mut rng = fastrand::Rng::with_seed(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    (0..samples).map(|_| rng.f64() - 0.5).collect()
}

/// Largest error over the largest response, on lines inside a band.
fn error(lines: &[f64], value: &[Complex], truth: impl Fn(f64) -> Complex) -> f64 {
    let inside = |f: &f64| (20.0..80.0).contains(f);
    let off = lines.iter().zip(value).filter(|(f, _)| inside(f));
    let worst = off.map(|(&f, h)| (h - truth(f)).norm()).fold(0.0, f64::max);
    let largest = lines.iter().filter(|f| inside(f)).map(|&f| truth(f).norm());
    worst / largest.fold(0.0, f64::max)
}

/// A record that begins in the middle of a decay: windows of an average smear the peak, local polynomials do not.
#[test]
fn exact_without_leakage() {
    let mode = Mode::new(50.0, 0.01);
    let u = noise(16_000, 1);
    let y = mode.answer(&u, [3.0, -2.0]);
    let half = min_half_width(1, 1, 8);
    let mut local = LocalPolynomialEstimator::new(RATE, 1, 1, u.len(), half, (0.0, 500.0)).unwrap();
    local.push(&[&u, &y]);
    let found = local.finish().unwrap();
    let sharp = error(&found.frequency_hz, &found.functions[0].values, |f| {
        mode.response(f)
    });
    // Windows of 15 lines of 1/16 Hz reach to a = 7/8 of the half-power half-bandwidth: of 1/(1 + jx) a parabola misses
    // (3/35) a⁴ = 5 % at most, one over a pole a tenth of it: what is left is that of windows farther from the pole.
    within("responses, of the largest", sharp, 0.01);
    let options = WelchOptions {
        block: 1024,
        ..WelchOptions::default()
    };
    let mut estimator =
        WelchEstimator::new(RATE, 2, &frf::required_pairs(&[0], &[1]), &options).unwrap();
    estimator.push(&[&u, &y]);
    let averaged = frf::estimate(&estimator.finish().unwrap(), &[0], &[1], Estimator::H1).unwrap();
    let blunt = error(&averaged.frequency_hz, &averaged.functions[0].values, |f| {
        mode.response(f)
    });
    assert!(blunt > 5.0 * sharp, "{blunt} {sharp}");
}

/// A resonance five times narrower than a window, and two in one window.
#[test]
fn exact_of_resonances_narrower_than_windows() {
    let modes = [
        Mode::new(50.0, 0.002),
        Mode::new(60.0, 0.002),
        Mode::new(60.3, 0.002),
    ];
    let u = noise(16_000, 12);
    let mut y = vec![0.0; u.len()];
    for mode in &modes {
        let answer = mode.answer(&u, [3.0, -2.0]);
        y.iter_mut().zip(answer).for_each(|(y, a)| *y += a);
    }
    let half = min_half_width(1, 1, 8);
    let mut local = LocalPolynomialEstimator::new(RATE, 1, 1, u.len(), half, (0.0, 500.0)).unwrap();
    local.push(&[&u, &y]);
    let found = local.finish().unwrap();
    let truth = |f: f64| modes.iter().map(|m| m.response(f)).sum();
    let off = error(&found.frequency_hz, &found.functions[0].values, truth);
    within("responses, of the largest", off, 0.01);
}

/// Noise on the output scatters the responses as their variance says.
#[test]
fn law_variance_is_that_of_the_errors() {
    let mode = Mode::new(50.0, 0.05);
    let (mut sum, mut count) = (0.0, 0.0);
    for seed in 0..4 {
        let u = noise(16_384, 2 * seed);
        let mut y = mode.answer(&u, [0.0; 2]);
        (y.iter_mut().zip(noise(16_384, 2 * seed + 1))).for_each(|(y, e)| *y += e);
        let half = min_half_width(1, 1, 8);
        let mut local =
            LocalPolynomialEstimator::new(RATE, 1, 1, u.len(), half, (10.0, 400.0)).unwrap();
        local.push(&[&u, &y]);
        let found = local.finish().unwrap();
        let f = &found.functions[0];
        let variance = f.variance.as_ref().unwrap();
        for (k, &at) in found.frequency_hz.iter().enumerate() {
            sum += (f.values[k] - mode.response(at)).norm_sqr() / variance[k];
            count += 1.0;
        }
    }
    // Of a variance from 9 freedoms the inverse is 9/8 in the mean.
    let mean = sum / count;
    assert!((mean / 1.125 - 1.0).abs() < 0.15, "{mean}");
}

/// A sweep: where it begins and ends, transients and responses are not told apart, and what is added for noise would be all there is.
#[test]
fn law_sweeps_are_followed_from_their_beginning() {
    let mode = Mode::new(40.0, 0.01);
    let (from, to, samples) = (5.0, 400.0, 30_000);
    let length = samples as f64 / RATE;
    let u: Vec<f64> = (0..samples)
        .map(|i| i as f64 / RATE)
        .map(|t| (TAU * (from * t + 0.5 * (to - from) / length * t * t)).cos())
        .collect();
    let size = 1e-3 * mode.response(40.0).norm();
    let y: Vec<f64> = (mode.answer(&u, [0.0; 2]).iter())
        .zip(noise(samples, 3))
        .map(|(y, e)| y + size * e)
        .collect();
    let half = min_half_width(1, 1, 5);
    let mut local = LocalPolynomialEstimator::new(RATE, 1, 1, u.len(), half, (0.0, 500.0)).unwrap();
    local.push(&[&u, &y]);
    let found = local.finish().unwrap();
    let largest = mode.response(40.0).norm();
    let variance = found.functions[0].variance.as_ref().unwrap();
    let (mut near, mut all) = (0, 0);
    let values = found.functions[0].values.iter().zip(variance);
    for (f, (h, variance)) in found.frequency_hz.iter().zip(values) {
        if !(7.0..60.0).contains(f) {
            continue;
        }
        let off = (h - mode.response(*f)).norm();
        all += 1;
        near += i32::from(off < 0.01 * largest);
        assert!(
            off < 0.01 * largest + 6.0 * variance.sqrt(),
            "{f} Hz: {off}"
        );
    }
    assert!(f64::from(near) > 0.97 * f64::from(all), "{near} of {all}");
}

/// Two inputs, two blocks: each response apart, and their partial coherence high where each drives.
#[test]
fn exact_of_two_inputs() {
    let (first, second) = (Mode::new(40.0, 0.03), Mode::new(60.0, 0.03));
    let (u, v) = (noise(32_768, 5), noise(32_768, 6));
    let y: Vec<f64> = (first.answer(&u, [0.0; 2]).iter())
        .zip(second.answer(&v, [0.0; 2]))
        .map(|(a, b)| a - 2.0 * b)
        .collect();
    let block = u.len() / 2;
    let half = min_half_width(2, 2, 8);
    let mut local = LocalPolynomialEstimator::new(RATE, 2, 1, block, half, (0.0, 500.0)).unwrap();
    for part in [0..block, block..2 * block] {
        local.push(&[&u[part.clone()], &v[part.clone()], &y[part]]);
    }
    let found = local.finish().unwrap();
    let lines = &found.frequency_hz;
    let one = error(lines, &found.functions[0].values, |f| first.response(f));
    let two = error(lines, &found.functions[1].values, |f| {
        second.response(f) * -2.0
    });
    assert!(one < 0.01 && two < 0.01, "{one} {two}");
    assert!(found.multiple_coherence[0].iter().all(|c| *c > 0.99));
}

/// Noise fills half the lines, what repeats eight times every eighth.
#[test]
fn law_evenness_tells_what_repeats() {
    let evenness = |u: &[f64]| {
        let half = min_half_width(1, 1, 8);
        let mut local =
            LocalPolynomialEstimator::new(RATE, 1, 1, u.len(), half, (0.0, 500.0)).unwrap();
        local.push(&[u, u]);
        local.input_flatness((10.0, 400.0))
    };
    let even = evenness(&noise(16_384, 3));
    assert!((even - 0.5).abs() < 0.1, "{even}");
    let period = noise(2048, 4);
    let repeated = evenness(&period.repeat(8));
    assert!(repeated < 0.15, "{repeated}");
}
