//! Linearity check: shift of natural frequencies with the excitation level.
//!
//! The shift of a pole in each group of responses relative to their mean ([`super::pole_shift`]) is regressed on the level of the group.

use std::f64::consts::TAU;

use super::modal_parameters::ModalParameters;
use super::pole_shift::{ShiftBasis, power};
use crate::numeric::Complex;
use crate::numeric::statistics::student_t_quantile;

/// Half width of the band evaluated about a mode, in half-power half-bandwidths.
const MODE_HALF_WIDTHS: f64 = 3.0;

/// Minimum number of spectral lines: with fewer a pole shift is not distinguishable from a change of the residue.
const MIN_LINES: usize = 6;

/// Minimum ratio of the highest to the lowest level for a linearity check.
const MIN_LEVEL_RATIO: f64 = 1.2;

/// Significance level of the test for dependence on the level, over all modes of a test (Bonferroni).
const SIGNIFICANCE: f64 = 0.01;

/// Frequency responses at one excitation level: from one hit, several similar hits, or a segment of a record.
pub struct LevelGroup<'a> {
    /// Peak force of the hits or rms input of the segment, in the unit of the input.
    pub level: f64,
    /// Frequency responses by response channel and spectral line.
    pub responses: &'a [Vec<Complex>],
}

/// `1/(jω − p)` and `1/(jω − p)²` at ω, rad/s, with the bias of the response estimator.
pub type PoleTerms<'a> = dyn Fn(f64, Complex) -> (Complex, Complex) + 'a;

/// Natural frequencies that depend significantly on the level.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelDependence {
    /// Lowest and highest level, in the unit of the input.
    pub levels: [f64; 2],
    /// Shifts of the dependent modes.
    pub shifts: Vec<LevelShift>,
}

/// Change of a natural frequency from the lowest to the highest level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelShift {
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Relative change of the natural frequency.
    pub change: f64,
    /// Half width of its 95 % confidence interval: Student's t of the scatter, and the misfit of the pole-shift model.
    pub bound: f64,
}

/// Natural frequencies that depend on the level; `None` without a significant dependence, or with fewer than three groups or equal levels.
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
    let critical_t = student_t_quantile(1.0 - 0.5 * SIGNIFICANCE / modes.len().max(1) as f64, dofs);
    let interval = student_t_quantile(0.975, dofs);
    let level_shift = |mode: &ModalParameters| {
        let (shifts, misfit) = shifts(frequency_hz, groups, mode.pole, pole_terms)?;
        let f = mode.frequency_hz();
        let relative: Vec<f64> = shifts.iter().map(|dp| dp.im / TAU / f).collect();
        let (slope, deviation) = regression(&levels, &relative)?;
        let change = slope * (high - low);
        let scatter = interval * deviation * (high - low);
        (slope.abs() > critical_t * deviation).then(|| LevelShift {
            frequency_hz: f,
            change,
            bound: scatter.hypot(change * misfit),
        })
    };
    let shifts: Vec<LevelShift> = modes.iter().filter_map(level_shift).collect();
    (!shifts.is_empty()).then_some(LevelDependence {
        levels: [low, high],
        shifts,
    })
}

/// Shift of a pole, rad/s, in each group, and the rms residual beyond noise relative to the rms shift term; `None` with too few lines in
/// the band of the mode.
fn shifts(
    frequency_hz: &[f64],
    groups: &[LevelGroup],
    pole: Complex,
    pole_terms: &PoleTerms,
) -> Option<(Vec<Complex>, f64)> {
    let half_band = MODE_HALF_WIDTHS * pole.re.abs();
    let is_in_band = |k: &usize| (TAU * frequency_hz[*k] - pole.im).abs() <= half_band;
    let lines: Vec<usize> = (0..frequency_hz.len()).filter(is_in_band).collect();
    if lines.len() < MIN_LINES {
        return None;
    }
    let decay_rate = pole.re.abs();
    let terms = (lines.iter()).map(|k| pole_terms(TAU * frequency_hz[*k], pole));
    let basis = ShiftBasis::new(terms, decay_rate);
    let outputs = groups.first()?.responses.len();
    let mut shifts = vec![Complex::new(0.0, 0.0); groups.len()];
    let (mut weight, mut shift_power, mut residual_power) = (0.0, 0.0, 0.0);
    for o in 0..outputs {
        let mean = |k: &usize| -> Complex {
            groups.iter().map(|g| g.responses[o][*k]).sum::<Complex>() / groups.len() as f64
        };
        let mean: Vec<Complex> = lines.iter().map(mean).collect();
        let residue = basis.residue(&mean);
        weight += residue.norm_sqr();
        for (shift, group) in shifts.iter_mut().zip(groups) {
            let deviation = |(k, m): (&usize, &Complex)| group.responses[o][*k] - m;
            let mut deviation: Vec<Complex> = lines.iter().zip(&mean).map(deviation).collect();
            let coefficient = basis.split_shift(&mut deviation);
            *shift += residue.conj() * coefficient;
            shift_power += coefficient.norm_sqr() * basis.shift_power();
            residual_power += power_above_noise(&deviation);
        }
    }
    let scale = decay_rate / weight;
    let misfit = (residual_power / f64::max(shift_power, f64::MIN_POSITIVE)).sqrt();
    (weight > 0.0).then(|| (shifts.iter().map(|s| s * scale).collect(), misfit))
}

/// Power of values over adjacent lines minus the noise power estimated from their differences.
fn power_above_noise(values: &[Complex]) -> f64 {
    let differences = values.windows(2).map(|w| (w[1] - w[0]).norm_sqr());
    let factor = values.len() as f64 / (values.len() as f64 - 1.0);
    (power(values) - 0.5 * factor * differences.sum::<f64>()).max(0.0)
}

/// Least-squares slope of y over x and its standard deviation; `None` for constant x.
fn regression(x: &[f64], y: &[f64]) -> Option<(f64, f64)> {
    let n = x.len() as f64;
    let mean = |v: &[f64]| v.iter().sum::<f64>() / n;
    let (mx, my) = (mean(x), mean(y));
    let xx: f64 = x.iter().map(|x| (x - mx).powi(2)).sum();
    let xy: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    let slope = xy / xx;
    let residual: f64 = (x.iter().zip(y))
        .map(|(x, y)| (y - my - slope * (x - mx)).powi(2))
        .sum();
    (xx > 0.0).then(|| (slope, (residual / (n - 2.0) / xx).sqrt()))
}

/// Terms `1/(jω − p)` and `1/(jω − p)²` as averaged over Hann-windowed blocks of length `block_s`, s, under white-noise excitation.
/// Fourier transforms of `e^{pt}` and `t e^{pt}` times the window autocorrelation `(1 − x)(2 + cos 2πx)/3 + sin(2πx)/2π`, x = t/block_s.
pub fn averaged_terms(omega: f64, pole: Complex, block_s: f64) -> (Complex, Complex) {
    /// Intervals of the trapezoidal rule; the phase of the integrand changes by less than 0.02 rad per interval.
    const POINTS: usize = 4096;
    /// Integration limit in time constants; `e^{−20}` is 2e-9.
    const TIME_CONSTANTS: f64 = 20.0;
    let end = block_s.min(TIME_CONSTANTS / pole.re.abs());
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
        let (x, end_weight) = (t / block_s, if k == POINTS { 0.5 } else { 1.0 });
        let (sin, cos) = (TAU * x).sin_cos();
        let weight = end_weight * ((1.0 - x) * (2.0 + cos) / 3.0 + sin / TAU);
        first += decay * weight;
        second += decay * weight * t;
    }
    (first * dt, second * dt)
}

#[cfg(test)]
mod tests {
    use super::super::pole_shift::partial_fraction;
    use super::*;

    /// A natural frequency that decreases by 0.1 % from 100 to 200 N with 0.01 % scatter is detected to 10 %; scatter alone, or a narrow
    /// range of levels, gives no shift.
    #[test]
    fn exact_shift_with_level() {
        let lines: Vec<f64> = (0..400).map(|k| 80.0 + 0.1 * f64::from(k)).collect();
        let (f, damping) = (100.0, 0.01);
        let groups = |decrease: f64, range: f64| -> Vec<(f64, Vec<Vec<Complex>>)> {
            let mut random = fastrand::Rng::with_seed(4);
            let group = |g: usize| {
                let share = g as f64 / 7.0;
                let scatter = 1e-4 * (random.f64() - 0.5);
                let omega = TAU * f * (1.0 - decrease * share + scatter);
                let pole = Complex::new(-damping * omega, omega);
                let gain = Complex::new(3.0 + 0.1 * share, 1.0);
                let value = |&f: &f64| gain / (Complex::new(0.0, TAU * f) - pole) + 0.01;
                (
                    100.0 * (1.0 + range * share),
                    vec![lines.iter().map(value).collect()],
                )
            };
            (0..8).map(group).collect()
        };
        let mode = ModalParameters {
            pole: Complex::new(-damping * TAU * f, TAU * f),
            pole_covariance: None,
            shape: Vec::new(),
        };
        let detect = |decrease: f64, range: f64| {
            let groups = groups(decrease, range);
            let views: Vec<LevelGroup> = groups
                .iter()
                .map(|(level, responses)| LevelGroup {
                    level: *level,
                    responses,
                })
                .collect();
            let modes = std::slice::from_ref(&mode);
            level_dependence(&lines, &views, modes, &partial_fraction)
        };
        let dependence = detect(1e-3, 1.0).unwrap();
        assert_eq!(dependence.levels, [100.0, 200.0]);
        assert!(
            (dependence.shifts[0].change + 1e-3).abs() < 1e-4,
            "{dependence:?}"
        );
        assert!(detect(0.0, 1.0).is_none() && detect(1e-3, 0.1).is_none());
    }
}
