//! Causality test that distinguishes headerless tables of frequency responses from signals over time: the inverse transform of
//! `Re + i Im` lies at positive times for a causal impulse response, and equally on both sides for two signals.

use std::f64::consts::{PI, TAU};

use crate::numeric::Complex;
use crate::numeric::fft::{ComplexFft, prev_fast_len};
use crate::numeric::sorting::sort_ascending;

/// Minimum number of lines for a decision: the share of noise at negative times is then 0.5 ± 0.04.
const MIN_LINES: usize = 128;

/// Minimum number of lines for the transform.
const MIN_FEW_LINES: usize = 32;

/// Samples to either side of time zero that the window smears, excluded from the shares.
const SMEAR_SAMPLES: usize = 2;

/// Maximum energy share of a response at negative times: measured beam responses have 0.004, lightly damped modes on few lines
/// 0.22, signals over time 0.4 to 0.6.
const MAX_ACAUSAL: f64 = 0.25;

/// Maximum energy share at negative times on few lines; one in two thousand pairs of noise has less.
const MAX_ACAUSAL_FEW: f64 = 0.1;

/// Maximum energy share of three neighbouring times: two probes at right angles to a shaft resemble a pure delay.
const MAX_INSTANT: f64 = 0.5;

/// Minimum ratio of the energy shares at negative times of the second-best and the best form of the columns.
const MIN_CONTRAST: f64 = 2.0;

/// Minimum range of magnitudes in dB.
const MIN_DECIBEL_RANGE: f64 = 6.0;

/// Maximum of a rounded phase relative to ±π or ±180°.
const ROUNDING: f64 = 1.01;

/// Complex form of the two columns of a response.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ComplexColumns {
    /// Real and imaginary part.
    Cartesian,
    /// Magnitude and phase.
    Polar {
        /// Whether the magnitude is `20 lg |H|`, dB.
        decibel: bool,
        /// Whether the phase is in degrees, else in radians.
        degrees: bool,
    },
}

impl ComplexColumns {
    /// Suffixes of the names of the two columns.
    pub(super) fn suffixes(self) -> [&'static str; 2] {
        match self {
            ComplexColumns::Cartesian => ["re", "im"],
            ComplexColumns::Polar { decibel, degrees } => [
                if decibel { "mag_dB" } else { "mag" },
                if degrees { "phase_deg" } else { "phase_rad" },
            ],
        }
    }

    fn value(self, a: f64, b: f64) -> Complex {
        let ComplexColumns::Polar { decibel, degrees } = self else {
            return Complex::new(a, b);
        };
        let size = if decibel { 10f64.powf(a / 20.0) } else { a };
        let phase = if degrees { b.to_radians() } else { b };
        Complex::from_polar(size, phase)
    }
}

/// Content of two columns over uniform lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ColumnPair {
    /// A frequency response.
    Response(ComplexColumns),
    /// Either a response or two signals, or a response in one of several forms.
    Uncertain,
    /// Two signals over time.
    Signals,
}

/// Classifies two columns over uniform lines by their values.
pub(super) fn column_pair(first: &[f64], second: &[f64]) -> ColumnPair {
    if first.iter().chain(second).any(|x| !x.is_finite()) {
        return ColumnPair::Signals;
    }
    let mut causal: Vec<(f64, f64, ComplexColumns)> = forms(first, second)
        .into_iter()
        .filter_map(|form| {
            let values = first.iter().zip(second).map(|(a, b)| form.value(*a, *b));
            let (acausal, instant) = time_shares(values.collect())?;
            (acausal < MAX_ACAUSAL).then_some((acausal, instant, form))
        })
        .collect();
    sort_ascending(&mut causal, |a| a.0);
    let is_few = first.len() < MIN_LINES;
    match causal[..] {
        [(acausal, instant, form), ref rivals @ ..] if instant < MAX_INSTANT => {
            let is_clear = rivals.iter().all(|o| o.0 >= MIN_CONTRAST * acausal);
            match (is_few, is_clear) {
                (false, true) => return ColumnPair::Response(form),
                (false, false) => return ColumnPair::Uncertain,
                (true, _) if acausal < MAX_ACAUSAL_FEW => return ColumnPair::Uncertain,
                (true, _) => {}
            }
        }
        // Either a response without delay or a wrapped angle.
        [(_, _, ComplexColumns::Polar { .. }), ..] if !is_few && half_turn(second).is_some() => {
            return ColumnPair::Uncertain;
        }
        _ => {}
    }
    match is_phase(second) {
        true => ColumnPair::Uncertain,
        false => ColumnPair::Signals,
    }
}

/// Forms of two columns that are compatible with their ranges.
fn forms(first: &[f64], second: &[f64]) -> Vec<ComplexColumns> {
    let (least, most) = range(first);
    let largest = second.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let is_within = largest <= ROUNDING * PI;
    // An unwrapped phase in radians exceeds ±π in small steps.
    let is_continuous = second.windows(2).all(|w| (w[1] - w[0]).abs() < PI);
    let phases = [(true, !is_within), (false, is_within || is_continuous)];
    let scales = [
        (false, least >= 0.0),
        (true, most - least > MIN_DECIBEL_RANGE),
    ];
    let mut forms = vec![ComplexColumns::Cartesian];
    for (decibel, _) in scales.into_iter().filter(|s| s.1) {
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

/// Half a revolution, π or 180, in the unit of values that fill ±π or ±180.
fn half_turn(values: &[f64]) -> Option<f64> {
    const MIN_FILLED: f64 = 0.9;
    let largest = values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let fills = |half: &f64| (MIN_FILLED * half..ROUNDING * half).contains(&largest);
    [PI, 180.0].into_iter().find(fills)
}

/// Whether values that fill ±π or ±180 are a phase: they jump by about a revolution, or concentrate at 0 and at half a revolution,
/// as the phase of lightly damped modes.
fn is_phase(values: &[f64]) -> bool {
    const MIN_JUMP: f64 = 1.8;
    const TOLERANCE: f64 = 0.06;
    let Some(half) = half_turn(values) else {
        return false;
    };
    let jumps = |w: &[f64]| (w[1] - w[0]).abs() > MIN_JUMP * half;
    let share_at = |at: f64| {
        let is_close = |x: &&f64| (x.abs() - at).abs() < TOLERANCE * half;
        values.iter().filter(is_close).count() as f64 / values.len() as f64
    };
    let (at_zero, at_half) = (share_at(0.0), share_at(half));
    values.windows(2).any(jumps) || (at_zero + at_half > 0.6 && at_zero.min(at_half) > 0.05)
}

/// Energy shares of the inverse transform of values over uniform lines: at negative times, and the maximum in three neighbouring times.
fn time_shares(mut values: Vec<Complex>) -> Option<(f64, f64)> {
    if values.len() < MIN_FEW_LINES {
        return None;
    }
    let n = prev_fast_len(values.len());
    values.truncate(n);
    // The Hann window suppresses ringing from the ends of the band.
    for (k, value) in values.iter_mut().enumerate() {
        *value *= 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / n as f64).cos();
    }
    ComplexFft::new(n).inverse(&mut values);
    let power: Vec<f64> = values.iter().map(|v| v.norm_sqr()).collect();
    let causal = &power[SMEAR_SAMPLES + 1..n / 2];
    let acausal: f64 = power[n / 2 + 1..n - SMEAR_SAMPLES].iter().sum();
    let total = acausal + causal.iter().sum::<f64>();
    let instant = causal.windows(3).map(|w| w.iter().sum::<f64>());
    let instant = instant.fold(0.0, f64::max);
    (total > 0.0 && total.is_finite()).then(|| (acausal / total, instant / total))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(count: u32, columns: impl Fn(f64) -> (f64, f64)) -> ColumnPair {
        let (a, b): (Vec<f64>, Vec<f64>) = (0..count).map(|k| columns(f64::from(k))).unzip();
        column_pair(&a, &b)
    }

    /// Receptance, or accelerance if `power` is 2, of a mode at a fifth of 1024 lines.
    fn mode(k: f64, damping: f64, power: i32) -> Complex {
        let r = k / 200.0;
        (-r * r).powi(power / 2) / Complex::new(1.0 - r * r, 2.0 * damping * r)
    }

    /// One mode in every complex form.
    #[test]
    fn exact_responses_are_causal() {
        let polar =
            |decibel, degrees| ColumnPair::Response(ComplexColumns::Polar { decibel, degrees });
        let level = |h: Complex| 20.0 * h.norm().log10();
        for (damping, power) in [(0.02, 0), (0.02, 2), (0.005, 0)] {
            let h = |k: f64| mode(k + 1.0, damping, power);
            let pair = lines(1024, |k| (h(k).re, h(k).im));
            assert_eq!(pair, ColumnPair::Response(ComplexColumns::Cartesian));
            let pair = lines(1024, |k| (h(k).norm(), h(k).arg().to_degrees()));
            assert_eq!(pair, polar(false, true));
            let pair = lines(1024, |k| (h(k).norm(), h(k).arg()));
            assert_eq!(pair, polar(false, false));
            // Levels re 1 and re 1e-6.
            for above in [0.0, 120.0] {
                let pair = lines(1024, |k| (above + level(h(k)), h(k).arg().to_degrees()));
                assert_eq!(pair, polar(true, true), "{damping} {power} {above}");
                let pair = lines(1024, |k| (above + level(h(k)), h(k).arg()));
                assert_eq!(pair, polar(true, false), "{damping} {power} {above}");
            }
        }
    }

    /// Probes at right angles, noise, a decay over time and a ramp are signals; a phase on few lines is uncertain.
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
            let pair = lines(count, |k| {
                let h = mode(10.0 * k + 5.0, 0.01, 0);
                (20.0 * h.norm().log10(), h.arg().to_degrees())
            });
            assert_eq!(pair, ColumnPair::Uncertain, "{count}");
        }
    }
}
