//! Headerless tables of frequency responses, distinguished from signals over time: a response to an impulse begins with the impulse, so that
//! the inverse transform of `Re + i Im` over the frequencies lies at positive times. That of two signals lies on either side alike.

use std::f64::consts::{PI, TAU};

use crate::numeric::Complex;
use crate::numeric::fft::{ComplexFft, prev_fast_len};
use crate::numeric::sorting::sort_rising;

/// Lines that tell a response from chance: the shares of noise lie at 0.5 ± 0.04.
const MIN_LINES: usize = 128;

/// Fewer lines than this tell nothing.
const MIN_FEW_LINES: usize = 32;

/// Times to either side of zero that the window smears, in lines of the transform.
const SMEAR_SAMPLES: usize = 2;

/// The most that a response has at negative times: the beam responses tried have 0.004, lightly damped modes on few lines 0.22,
/// signals over time 0.4 to 0.6.
const MAX_BEFORE: f64 = 0.25;

/// The same on few lines: one in two thousand pairs of noise has less.
const MAX_BEFORE_FEW: f64 = 0.1;

/// The most that three neighbouring times may hold: two probes at right angles to a shaft look like a response of one instant.
const MAX_AT_ONCE: f64 = 0.5;

/// The next likely form of the columns has at least so many times as much at negative times.
const MIN_CONTRAST: f64 = 2.0;

/// Magnitudes in dB span more than this.
const MIN_DECIBEL_RANGE: f64 = 6.0;

/// The most of ±π or ±180° that printing rounds a phase to.
const ROUNDED_UP: f64 = 1.01;

/// Complex form in which two columns hold a response.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ComplexColumns {
    /// Real and imaginary part.
    Cartesian,
    /// Magnitude and phase.
    Polar {
        /// The magnitude is `20 lg |H|`.
        decibel: bool,
        /// The phase is in degrees, not in radians.
        degrees: bool,
    },
}

impl ComplexColumns {
    /// Endings of the names of the two columns.
    pub(super) fn endings(self) -> [&'static str; 2] {
        match self {
            ComplexColumns::Cartesian => ["re", "im"],
            ComplexColumns::Polar { decibel, degrees } => [
                if decibel { "mag_dB" } else { "mag" },
                if degrees { "phase_deg" } else { "phase_rad" },
            ],
        }
    }

    fn value(self, one: f64, two: f64) -> Complex {
        let ComplexColumns::Polar { decibel, degrees } = self else {
            return Complex::new(one, two);
        };
        let size = if decibel { 10f64.powf(one / 20.0) } else { one };
        let phase = if degrees { two.to_radians() } else { two };
        Complex::from_polar(size, phase)
    }
}

/// Content of two columns over even lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ColumnPair {
    /// A frequency response.
    Response(ComplexColumns),
    /// A frequency response or two signals, or a response in one of two forms.
    Uncertain,
    /// Two signals over time.
    Signals,
}

/// Content of two columns over even lines, by their numbers.
pub(super) fn column_pair(one: &[f64], two: &[f64]) -> ColumnPair {
    if one.iter().chain(two).any(|x| !x.is_finite()) {
        return ColumnPair::Signals;
    }
    let mut likely: Vec<(f64, f64, ComplexColumns)> = forms(one, two)
        .into_iter()
        .filter_map(|form| {
            let values = one.iter().zip(two).map(|(a, b)| form.value(*a, *b));
            let (before, at_once) = time_shares(values.collect())?;
            (before < MAX_BEFORE).then_some((before, at_once, form))
        })
        .collect();
    sort_rising(&mut likely, |a| a.0);
    let is_few = one.len() < MIN_LINES;
    match likely[..] {
        [(before, at_once, form), ref others @ ..] if at_once < MAX_AT_ONCE => {
            let is_alone = others.iter().all(|o| o.0 >= MIN_CONTRAST * before);
            match (is_few, is_alone) {
                (false, true) => return ColumnPair::Response(form),
                (false, false) => return ColumnPair::Uncertain,
                (true, _) if before < MAX_BEFORE_FEW => return ColumnPair::Uncertain,
                (true, _) => {}
            }
        }
        // A response without delay, or an angle that runs back.
        [(_, _, ComplexColumns::Polar { .. }), ..] if !is_few && half_turn(two).is_some() => {
            return ColumnPair::Uncertain;
        }
        _ => {}
    }
    match is_phase(two) {
        true => ColumnPair::Uncertain,
        false => ColumnPair::Signals,
    }
}

/// Forms that two columns can have by their ranges.
fn forms(one: &[f64], two: &[f64]) -> Vec<ComplexColumns> {
    let (least, most) = range(one);
    let largest = two.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let is_within = largest <= ROUNDED_UP * PI;
    // An unwrapped phase in radians leaves ±π in small steps.
    let is_continuous = two.windows(2).all(|w| (w[1] - w[0]).abs() < PI);
    let phases = [(true, !is_within), (false, is_within || is_continuous)];
    let sizes = [
        (false, least >= 0.0),
        (true, most - least > MIN_DECIBEL_RANGE),
    ];
    let mut forms = vec![ComplexColumns::Cartesian];
    for (decibel, _) in sizes.into_iter().filter(|s| s.1) {
        for (degrees, _) in phases.into_iter().filter(|p| p.1) {
            forms.push(ComplexColumns::Polar { decibel, degrees });
        }
    }
    forms
}

fn range(values: &[f64]) -> (f64, f64) {
    let empty = (f64::INFINITY, f64::NEG_INFINITY);
    let widen = |(least, most): (f64, f64), x: &f64| (least.min(*x), most.max(*x));
    values.iter().fold(empty, widen)
}

/// Half a turn in the unit of values that fill ±π or ±180.
fn half_turn(values: &[f64]) -> Option<f64> {
    const MIN_FILLED: f64 = 0.9;
    let largest = values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let fills = |half: &f64| (MIN_FILLED * half..ROUNDED_UP * half).contains(&largest);
    [PI, 180.0].into_iter().find(fills)
}

/// Whether values that fill ±π or ±180 jump by about a turn, or lie at 0 and at half a turn for the most part, as the phase of lightly
/// damped modes does.
fn is_phase(values: &[f64]) -> bool {
    const MIN_JUMP: f64 = 1.8;
    const NEAR: f64 = 0.06;
    let Some(half) = half_turn(values) else {
        return false;
    };
    let jumps = |w: &[f64]| (w[1] - w[0]).abs() > MIN_JUMP * half;
    let share_near = |at: f64| {
        let near = |x: &&f64| (x.abs() - at).abs() < NEAR * half;
        values.iter().filter(near).count() as f64 / values.len() as f64
    };
    let (at_zero, at_half) = (share_near(0.0), share_near(half));
    values.windows(2).any(jumps) || (at_zero + at_half > 0.6 && at_zero.min(at_half) > 0.05)
}

/// Shares of the inverse transform of values over even lines: at negative times, and at most in three neighbouring times.
fn time_shares(mut values: Vec<Complex>) -> Option<(f64, f64)> {
    if values.len() < MIN_FEW_LINES {
        return None;
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
    let at_once = after.windows(3).map(|w| w.iter().sum::<f64>());
    let at_once = at_once.fold(0.0, f64::max);
    (all > 0.0 && all.is_finite()).then(|| (before / all, at_once / all))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(count: u32, of: impl Fn(f64) -> (f64, f64)) -> ColumnPair {
        let (one, two): (Vec<f64>, Vec<f64>) = (0..count).map(|k| of(f64::from(k))).unzip();
        column_pair(&one, &two)
    }

    /// Receptance, or accelerance where `power` is 2, of a mode at a fifth of 1024 lines.
    fn mode(k: f64, damping: f64, power: i32) -> Complex {
        let r = k / 200.0;
        (-r * r).powi(power / 2) / Complex::new(1.0 - r * r, 2.0 * damping * r)
    }

    /// A mode in all ways of writing it.
    #[test]
    fn exact_responses_are_causal() {
        let polar =
            |decibel, degrees| ColumnPair::Response(ComplexColumns::Polar { decibel, degrees });
        let level = |h: Complex| 20.0 * h.norm().log10();
        for (damping, power) in [(0.02, 0), (0.02, 2), (0.005, 0)] {
            let h = |k: f64| mode(k + 1.0, damping, power);
            let found = lines(1024, |k| (h(k).re, h(k).im));
            assert_eq!(found, ColumnPair::Response(ComplexColumns::Cartesian));
            let found = lines(1024, |k| (h(k).norm(), h(k).arg().to_degrees()));
            assert_eq!(found, polar(false, true));
            let found = lines(1024, |k| (h(k).norm(), h(k).arg()));
            assert_eq!(found, polar(false, false));
            // Levels re 1 and re 1e-6.
            for above in [0.0, 120.0] {
                let found = lines(1024, |k| (above + level(h(k)), h(k).arg().to_degrees()));
                assert_eq!(found, polar(true, true), "{damping} {power} {above}");
                let found = lines(1024, |k| (above + level(h(k)), h(k).arg()));
                assert_eq!(found, polar(true, false), "{damping} {power} {above}");
            }
        }
    }

    /// Probes at right angles, noise, a decay over time and a ramp are no responses; a phase on few lines is uncertain.
    #[test]
    fn exact_signals_are_not_causal() {
        let signals = [
            lines(1024, |k| ((0.3 * k).sin(), (0.3 * k).cos())),
            lines(1024, |k| ((0.3 * k).cos(), (0.3 * k).sin())),
            lines(1024, |k| {
                let hit = if k == 20.0 { 1.0 } else { 0.0 };
                (hit, (-0.01 * k).exp() * (0.4 * k).sin())
            }),
            lines(512, |k| (20.0 + 0.001 * k, 3.0 * k)),
            lines(64, |k| ((0.7 * k).sin(), (0.31 * k).cos())),
        ];
        assert!(
            signals.iter().all(|s| *s == ColumnPair::Signals),
            "{signals:?}"
        );
        let mut random = fastrand::Rng::with_seed(7);
        let noise: Vec<f64> = (0..2048).map(|_| random.f64() - 0.5).collect();
        assert_eq!(
            column_pair(&noise[..1024], &noise[1024..]),
            ColumnPair::Signals
        );
        for count in [40, 100] {
            let found = lines(count, |k| {
                let h = mode(10.0 * k + 5.0, 0.01, 0);
                (20.0 * h.norm().log10(), h.arg().to_degrees())
            });
            assert_eq!(found, ColumnPair::Uncertain, "{count}");
        }
    }
}
