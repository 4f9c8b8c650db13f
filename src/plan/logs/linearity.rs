//! Linearity by amplitude: whether hits of different level place a resonance differently.
//!
//! Near a pole p the response of hit g departs from the mean by `A δp_g/(jω − p)² + a/(jω − p) + b`, to first order, with the A of the mean;
//! δp by least squares, its part along the other two terms taken off. The shifts are then compared with the levels of the hits. Shifts beyond
//! a quarter of the half-power width are understated.

use std::f64::consts::TAU;

use super::frf_estimation::EstimatedResponses;
use crate::base::error::Diagnostic;
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::Complex;
use crate::numeric::statistics::student_t_quantile;

/// Lines within so many half-power half-widths of a mode tell its shift.
const MODE_HALF_WIDTHS: f64 = 3.0;

/// Fewer lines do not part a shift from a change of the residue.
const MIN_LINES: usize = 6;

/// Hits of a test whose levels differ by less than this factor say nothing of linearity.
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

/// The check for the hits of a test; `modes` as measured, an exponential window on them.
pub fn check_test(
    estimated_responses: &EstimatedResponses,
    frequency_hz: &[f64],
    modes: &[ModalParameters],
    unit: &str,
) -> Option<Diagnostic> {
    let level = |hits: &[usize]| {
        let peaks = hits
            .iter()
            .filter_map(|&at| estimated_responses.hits.get(at));
        peaks.map(|h| h.peak.abs()).sum::<f64>() / hits.len().max(1) as f64
    };
    let groups: Vec<LevelGroup> = (estimated_responses.by_hit.iter())
        .map(|g| LevelGroup {
            level: level(&g.hits),
            value: &g.value,
        })
        .collect();
    let partial_fraction = |omega: f64, pole: Complex| {
        let first = Complex::new(1.0, 0.0) / (Complex::new(0.0, omega) - pole);
        (first, first * first)
    };
    level_dependence(
        frequency_hz,
        &groups,
        modes,
        ("from hits of", unit),
        &partial_fraction,
    )
}

/// `1/(jω − p)` and `1/(jω − p)²` at ω, rad/s, as the estimate of the responses shows them.
pub type PoleTerms<'a> = dyn Fn(f64, Complex) -> (Complex, Complex) + 'a;

/// Says which resonances shift with the level, by how much over the range of levels, and over which range none does.
pub fn level_dependence(
    frequency_hz: &[f64],
    groups: &[LevelGroup],
    modes: &[ModalParameters],
    (levels_of, unit): (&str, &str),
    pole_terms: &PoleTerms,
) -> Option<Diagnostic> {
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
        // Student's interval of the scatter; the share of the change that is no shift of a pole as a bound of what a shift means.
        let by = interval * deviation * (high - low);
        let by = by.hypot(change * misfit);
        (slope.abs() > sure * deviation).then(|| {
            format!(
                "{f:.4} Hz {} by {:.3} ± {:.3} %",
                if change < 0.0 { "falls" } else { "rises" },
                100.0 * change.abs(),
                100.0 * by
            )
        })
    };
    let all: Vec<String> = modes.iter().filter_map(shifted).collect();
    (!all.is_empty()).then(|| Diagnostic {
        code: "nonlinear",
        message: format!(
            "{levels_of} {low:.4} to {high:.4} {unit}: {}",
            all.join(", ")
        ),
        hint: Some("the structure is not linear at these levels: excite it at one level, or state the amplitude with the modes".into()),
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
    let one = Complex::new(1.0, 0.0);
    // Scaled to sizes about one.
    let size = pole.re.abs();
    let terms = lines
        .iter()
        .map(|k| pole_terms(TAU * frequency_hz[*k], pole));
    let (first, mut second): (Vec<Complex>, Vec<Complex>) =
        terms.map(|(a, b)| (a * size, b * size * size)).unzip();
    let mut basis = vec![vec![one; lines.len()], first.clone()];
    orthonormal(&mut basis);
    for b in &basis {
        take_off(&mut second, b);
    }
    let size: f64 = second.iter().map(Complex::norm_sqr).sum();
    let responses = groups.first()?.value.len();
    let mut all = vec![Complex::new(0.0, 0.0); groups.len()];
    let (mut weight, mut shifted, mut left) = (0.0, 0.0, 0.0);
    for o in 0..responses {
        let mean = |k: &usize| -> Complex {
            groups.iter().map(|g| g.value[o][*k]).sum::<Complex>() / groups.len() as f64
        };
        let mean: Vec<Complex> = lines.iter().map(mean).collect();
        // A of the mean: its part along 1/(jω − p) once a constant is taken off.
        let (mut own, mut level) = (first.clone(), vec![vec![one; lines.len()]]);
        orthonormal(&mut level);
        take_off(&mut own, &level[0]);
        let a = along(&own, &mean) / own.iter().map(Complex::norm_sqr).sum::<f64>();
        weight += a.norm_sqr() * size;
        for (shift, group) in all.iter_mut().zip(groups) {
            let part: Vec<Complex> = (lines.iter().zip(&mean))
                .map(|(k, m)| group.value[o][*k] - m)
                .collect();
            let own = along(&second, &part);
            *shift += a.conj() * own;
            shifted += own.norm_sqr() / size;
            let mut rest = part;
            for b in &basis {
                take_off(&mut rest, b);
            }
            let own = own / size;
            (rest.iter_mut().zip(&second)).for_each(|(x, s)| *x -= own * s);
            left += beyond_noise(&rest);
        }
    }
    // With first = |σ|/(jω − p), A δp/(jω − p)² is a (δp/|σ|) first².
    let scale = pole.re.abs() / weight;
    let misfit = (left / f64::max(shifted, f64::MIN_POSITIVE)).sqrt();
    (weight > 0.0).then(|| (all.iter().map(|s| s * scale).collect(), misfit))
}

/// Power of values over neighbouring lines beyond that of noise, which their differences tell.
fn beyond_noise(values: &[Complex]) -> f64 {
    let power: f64 = values.iter().map(Complex::norm_sqr).sum();
    let steps = values.windows(2).map(|w| (w[1] - w[0]).norm_sqr());
    let share = values.len() as f64 / (values.len() as f64 - 1.0);
    (power - 0.5 * share * steps.sum::<f64>()).max(0.0)
}

/// `⟨b, x⟩`, b conjugated.
pub(super) fn along(b: &[Complex], x: &[Complex]) -> Complex {
    b.iter().zip(x).map(|(b, x)| b.conj() * x).sum()
}

/// Takes the part of `x` along a unit vector off.
pub(super) fn take_off(x: &mut [Complex], unit: &[Complex]) {
    let part = along(unit, x);
    x.iter_mut().zip(unit).for_each(|(x, b)| *x -= part * b);
}

/// Gram and Schmidt.
pub(super) fn orthonormal(basis: &mut [Vec<Complex>]) {
    for k in 0..basis.len() {
        let (done, rest) = basis.split_at_mut(k);
        for b in done.iter() {
            take_off(&mut rest[0], b);
        }
        let size = rest[0].iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
        rest[0].iter_mut().for_each(|z| *z /= size);
    }
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

#[cfg(test)]
mod tests {
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
        let said = |fall: f64, range: f64| {
            let all = groups(fall, range);
            let views: Vec<LevelGroup> = all
                .iter()
                .map(|(level, value)| LevelGroup {
                    level: *level,
                    value,
                })
                .collect();
            let terms = |omega: f64, pole: Complex| {
                let first = Complex::new(1.0, 0.0) / (Complex::new(0.0, omega) - pole);
                (first, first * first)
            };
            let modes = std::slice::from_ref(&mode);
            level_dependence(&lines, &views, modes, ("from hits of", "N"), &terms)
        };
        let message = said(1e-3, 1.0).unwrap().message;
        assert!(message.contains("100.0000 to 200.0000 N"), "{message}");
        let percent = message.split("falls by ").nth(1).unwrap();
        let percent: f64 = percent.split(' ').next().unwrap().parse().unwrap();
        assert!((percent - 0.1).abs() < 0.01, "{message}");
        assert!(said(0.0, 1.0).is_none() && said(1e-3, 0.1).is_none());
    }
}
