//! Linearity by amplitude: whether responses of different level place a resonance differently.
//!
//! The shift of a pole in each group of responses against their mean ([`super::pole_shift`]) is compared with the levels of the groups.

use std::f64::consts::TAU;

use super::modal_parameters::ModalParameters;
use super::pole_shift::{ShiftBasis, power};
use crate::numeric::Complex;
use crate::numeric::statistics::student_t_quantile;

/// Lines within so many half-power half-widths of a mode tell its shift.
const MODE_HALF_WIDTHS: f64 = 3.0;

/// Fewer lines do not part a shift from a change of the residue.
const MIN_LINES: usize = 6;

/// Groups whose levels differ by less than this factor say nothing of linearity.
const MIN_LEVEL_RATIO: f64 = 1.2;

/// Shifts are called dependent on the level where chance makes them so in one test of a hundred, over all its modes.
const SIGNIFICANCE: f64 = 0.01;

/// The responses at one level: of one hit, of a few alike, of a part of a record.
pub struct LevelGroup<'a> {
    /// Largest force of a hit or rms input of a part, in its unit.
    pub level: f64,
    /// By response and line.
    pub value: &'a [Vec<Complex>],
}

/// `1/(jω − p)` and `1/(jω − p)²` at ω, rad/s, as the estimate of the responses shows them.
pub type PoleTerms<'a> = dyn Fn(f64, Complex) -> (Complex, Complex) + 'a;

/// Resonances that shift with the level.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelDependence {
    /// Lowest and highest level.
    pub levels: [f64; 2],
    /// Modes that shift.
    pub shifts: Vec<LevelShift>,
}

/// Change of a natural frequency from the lowest to the highest level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelShift {
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Relative change.
    pub change: f64,
    /// Half its 95 % interval: Student's of the scatter, and the share of the change that is no shift of a pole.
    pub bound: f64,
}

/// The resonances that shift with the level; none where none does, or three groups of different level are lacking.
pub fn level_dependence(
    frequency_hz: &[f64],
    groups: &[LevelGroup],
    modes: &[ModalParameters],
    pole_terms: &PoleTerms,
) -> Option<LevelDependence> {
    let levels: Vec<f64> = groups.iter().map(|g| g.level).collect();
    let low = levels.iter().copied().fold(f64::INFINITY, f64::min);
    let high = levels.iter().copied().fold(0.0, f64::max);
    if groups.len() < 3 || !(high >= MIN_LEVEL_RATIO * low && low > 0.0) {
        return None;
    }
    let dofs = groups.len() as f64 - 2.0;
    let sure = student_t_quantile(1.0 - 0.5 * SIGNIFICANCE / modes.len().max(1) as f64, dofs);
    let interval = student_t_quantile(0.975, dofs);
    let shifted = |mode: &ModalParameters| {
        let (shifts, misfit) = shifts(frequency_hz, groups, mode.pole, pole_terms)?;
        let f = mode.frequency_hz();
        let relative: Vec<f64> = shifts.iter().map(|dp| dp.im / TAU / f).collect();
        let (slope, deviation) = line(&levels, &relative)?;
        let change = slope * (high - low);
        let scatter = interval * deviation * (high - low);
        (slope.abs() > sure * deviation).then(|| LevelShift {
            frequency_hz: f,
            change,
            bound: scatter.hypot(change * misfit),
        })
    };
    let shifts: Vec<LevelShift> = modes.iter().filter_map(shifted).collect();
    (!shifts.is_empty()).then_some(LevelDependence {
        levels: [low, high],
        shifts,
    })
}

/// The shift of a pole, rad/s, in each group, and what is left of the differences between groups beyond noise as a share of the shifts;
/// nothing where too few lines are near it.
fn shifts(
    frequency_hz: &[f64],
    groups: &[LevelGroup],
    pole: Complex,
    pole_terms: &PoleTerms,
) -> Option<(Vec<Complex>, f64)> {
    let reach = MODE_HALF_WIDTHS * pole.re.abs();
    let near = |k: &usize| (TAU * frequency_hz[*k] - pole.im).abs() <= reach;
    let lines: Vec<usize> = (0..frequency_hz.len()).filter(near).collect();
    if lines.len() < MIN_LINES {
        return None;
    }
    let decay_rate = pole.re.abs();
    let terms = (lines.iter()).map(|k| pole_terms(TAU * frequency_hz[*k], pole));
    let basis = ShiftBasis::new(terms, decay_rate);
    let responses = groups.first()?.value.len();
    let mut all = vec![Complex::new(0.0, 0.0); groups.len()];
    let (mut weight, mut shifted, mut left) = (0.0, 0.0, 0.0);
    for o in 0..responses {
        let mean = |k: &usize| -> Complex {
            groups.iter().map(|g| g.value[o][*k]).sum::<Complex>() / groups.len() as f64
        };
        let mean: Vec<Complex> = lines.iter().map(mean).collect();
        let residue = basis.residue(&mean);
        weight += residue.norm_sqr();
        for (shift, group) in all.iter_mut().zip(groups) {
            let departure = |(k, m): (&usize, &Complex)| group.value[o][*k] - m;
            let mut departure: Vec<Complex> = lines.iter().zip(&mean).map(departure).collect();
            let part = basis.split_shift(&mut departure);
            *shift += residue.conj() * part;
            shifted += part.norm_sqr() * basis.shift_power();
            left += beyond_noise(&departure);
        }
    }
    let scale = decay_rate / weight;
    let misfit = (left / f64::max(shifted, f64::MIN_POSITIVE)).sqrt();
    (weight > 0.0).then(|| (all.iter().map(|s| s * scale).collect(), misfit))
}

/// Power of values over neighbouring lines beyond that of noise, which their differences tell.
fn beyond_noise(values: &[Complex]) -> f64 {
    let steps = values.windows(2).map(|w| (w[1] - w[0]).norm_sqr());
    let share = values.len() as f64 / (values.len() as f64 - 1.0);
    (power(values) - 0.5 * share * steps.sum::<f64>()).max(0.0)
}

/// Slope of y over x and its standard deviation, by least squares; nothing where x does not change.
fn line(x: &[f64], y: &[f64]) -> Option<(f64, f64)> {
    let n = x.len() as f64;
    let mean = |v: &[f64]| v.iter().sum::<f64>() / n;
    let (mx, my) = (mean(x), mean(y));
    let xx: f64 = x.iter().map(|x| (x - mx).powi(2)).sum();
    let xy: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    let slope = xy / xx;
    let left: f64 = (x.iter().zip(y))
        .map(|(x, y)| (y - my - slope * (x - mx)).powi(2))
        .sum();
    (xx > 0.0).then(|| (slope, (left / (n - 2.0) / xx).sqrt()))
}

/// `1/(jω − p)` and `1/(jω − p)²` as averaged blocks under a Hann window show them for white noise: transforms of `e^{pt}` and `t e^{pt}`
/// times the autocorrelation of the window, `(1 − x)(2 + cos 2πx)/3 + sin(2πx)/2π` with x = t over the length of a block.
pub fn averaged_terms(omega: f64, pole: Complex, block_s: f64) -> (Complex, Complex) {
    /// Nodes of the trapezoidal rule; the integrand turns by less than a fiftieth of a radian between two.
    const POINTS: usize = 4096;
    /// `e^{−20}` is 2e-9.
    const DECAYS: f64 = 20.0;
    let end = block_s.min(DECAYS / pole.re.abs());
    let dt = end / POINTS as f64;
    let rate = pole - Complex::new(0.0, omega);
    let step = (rate * dt).exp();
    let (mut decay, mut first, mut second) = (
        Complex::new(1.0, 0.0),
        Complex::new(0.5, 0.0),
        Complex::new(0.0, 0.0),
    );
    for k in 1..=POINTS {
        decay *= step;
        let t = k as f64 * dt;
        let (x, half) = (t / block_s, if k == POINTS { 0.5 } else { 1.0 });
        let (sin, cos) = (TAU * x).sin_cos();
        let weight = half * ((1.0 - x) * (2.0 + cos) / 3.0 + sin / TAU);
        first += decay * weight;
        second += decay * weight * t;
    }
    (first * dt, second * dt)
}

#[cfg(test)]
mod tests {
    use super::super::pole_shift::partial_fraction;
    use super::*;

    /// One mode whose frequency falls by 0.1 % from 100 to 200 N, a tenth of that by chance: the shift to a few per cent; with chance
    /// alone, or hits of one level, nothing.
    #[test]
    fn exact_shift_with_level() {
        let lines: Vec<f64> = (0..400).map(|k| 80.0 + 0.1 * f64::from(k)).collect();
        let (f, damping) = (100.0, 0.01);
        let groups = |fall: f64, range: f64| -> Vec<(f64, Vec<Vec<Complex>>)> {
            let mut random = fastrand::Rng::with_seed(4);
            let one = |g: usize| {
                let share = g as f64 / 7.0;
                let chance = 1e-4 * (random.f64() - 0.5);
                let omega = TAU * f * (1.0 - fall * share + chance);
                let pole = Complex::new(-damping * omega, omega);
                let gain = Complex::new(3.0 + 0.1 * share, 1.0);
                let value = |&f: &f64| gain / (Complex::new(0.0, TAU * f) - pole) + 0.01;
                (
                    100.0 * (1.0 + range * share),
                    vec![lines.iter().map(value).collect()],
                )
            };
            (0..8).map(one).collect()
        };
        let mode = ModalParameters {
            pole: Complex::new(-damping * TAU * f, TAU * f),
            pole_covariance: None,
            shape: Vec::new(),
        };
        let found = |fall: f64, range: f64| {
            let all = groups(fall, range);
            let views: Vec<LevelGroup> = all
                .iter()
                .map(|(level, value)| LevelGroup {
                    level: *level,
                    value,
                })
                .collect();
            let modes = std::slice::from_ref(&mode);
            level_dependence(&lines, &views, modes, &partial_fraction)
        };
        let shifted = found(1e-3, 1.0).unwrap();
        assert_eq!(shifted.levels, [100.0, 200.0]);
        assert!(
            (shifted.shifts[0].change + 1e-3).abs() < 1e-4,
            "{shifted:?}"
        );
        assert!(found(0.0, 1.0).is_none() && found(1e-3, 0.1).is_none());
    }
}
