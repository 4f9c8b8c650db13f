//! Headerless tables of frequency responses, distinguished from signals over time: a response to an impulse begins with the impulse, so that
//! the inverse transform of `Re + i Im` over the frequencies lies at positive times. That of two signals lies on either side alike.

use std::f64::consts::{PI, TAU};

use crate::numeric::Complex;
use crate::numeric::fft::{ComplexFft, prev_fast_len};

/// Lines that tell a response from chance: the shares of noise lie at 0.5 ± 0.04.
const MIN_LINES: usize = 128;

/// Times to either side of zero that the window smears, in lines of the transform.
const SMEAR_SAMPLES: usize = 2;

/// The most that a response has at negative times: the beam responses tried have 0.004, lightly damped modes on few lines 0.22,
/// signals over time 0.4 to 0.6.
const MAX_BEFORE: f64 = 0.25;

/// The most that three neighbouring times may hold: two probes at right angles to a shaft look like a response of one instant.
const MAX_AT_ONCE: f64 = 0.5;

/// Complex form in which two columns hold a response.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ComplexColumns {
    /// Real and imaginary part.
    Cartesian,
    /// Magnitude and phase.
    Polar,
}

impl ComplexColumns {
    /// Endings of the names of the two columns.
    pub(super) fn endings(self) -> [&'static str; 2] {
        match self {
            ComplexColumns::Cartesian => ["re", "im"],
            ComplexColumns::Polar => ["mag", "phase"],
        }
    }
}

/// Complex form of a frequency response in two columns over even lines; `None` where they do not look like one.
pub(super) fn response(one: &[f64], two: &[f64]) -> Option<ComplexColumns> {
    let pairs = || one.iter().zip(two);
    if pairs().any(|(a, b)| !(a.is_finite() && b.is_finite())) {
        return None;
    }
    let cartesian = pairs().map(|(re, im)| Complex::new(*re, *im)).collect();
    if is_causal(cartesian) {
        return Some(ComplexColumns::Cartesian);
    }
    let largest = two.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    // Rounded printing may leave ±π by a digit; unwrapped phases run on and are degrees where they are large.
    let per_unit = if largest > 1.01 * PI { PI / 180.0 } else { 1.0 };
    let polar = pairs().map(|(size, phase)| Complex::from_polar(*size, phase * per_unit));
    let is_polar = one.iter().all(|x| *x >= 0.0) && is_causal(polar.collect());
    is_polar.then_some(ComplexColumns::Polar)
}

/// Whether the inverse transform of values over even lines lies at positive times, spread over more than an instant.
fn is_causal(mut values: Vec<Complex>) -> bool {
    if values.len() < MIN_LINES {
        return false;
    }
    let n = prev_fast_len(values.len());
    values.truncate(n);
    // Hann's window keeps the ends of the band from ringing over all times.
    for (k, value) in values.iter_mut().enumerate() {
        *value *= 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / n as f64).cos();
    }
    ComplexFft::new(n).inverse(&mut values);
    let power: Vec<f64> = values.iter().map(|v| v.norm_sqr()).collect();
    let after = &power[SMEAR_SAMPLES + 1..n / 2];
    let before: f64 = power[n / 2 + 1..n - SMEAR_SAMPLES].iter().sum();
    let all = before + after.iter().sum::<f64>();
    let instant = after.windows(3).map(|w| w.iter().sum::<f64>());
    let instant = instant.fold(0.0, f64::max);
    all > 0.0 && before < MAX_BEFORE * all && instant < MAX_AT_ONCE * all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mode, in both ways of writing it; probes at right angles, noise and a decay over time are none.
    #[test]
    fn exact_responses_are_causal() {
        let lines = |of: fn(f64) -> (f64, f64)| -> (Vec<f64>, Vec<f64>) {
            (0..1024).map(|k| of(f64::from(k))).unzip()
        };
        let mode = |k: f64| {
            let r = k / 200.0;
            let h = 1.0 / Complex::new(1.0 - r * r, 0.04 * r);
            (h.re, h.im)
        };
        let polar = |k: f64| {
            let r = k / 200.0;
            let h = 1.0 / Complex::new(1.0 - r * r, 0.04 * r);
            (h.norm(), h.arg().to_degrees())
        };
        let of = |(one, two): (Vec<f64>, Vec<f64>)| response(&one, &two);
        assert_eq!(of(lines(mode)), Some(ComplexColumns::Cartesian));
        assert_eq!(of(lines(polar)), Some(ComplexColumns::Polar));
        assert_eq!(of(lines(|k| ((0.3 * k).sin(), (0.3 * k).cos()))), None);
        assert_eq!(of(lines(|k| ((0.3 * k).cos(), (0.3 * k).sin()))), None);
        let decay = |k: f64| {
            let hit = if k == 20.0 { 1.0 } else { 0.0 };
            (hit, (-0.01 * k).exp() * (0.4 * k).sin())
        };
        assert_eq!(of(lines(decay)), None);
        let mut random = fastrand::Rng::with_seed(7);
        let noise: Vec<f64> = (0..2048).map(|_| random.f64() - 0.5).collect();
        assert_eq!(response(&noise[..1024], &noise[1024..]), None);
    }
}
