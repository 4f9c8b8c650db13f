//! One list of modes from overlapping rungs: each mode once, by its more certain estimate.

use super::harmonics::HarmonicIndicator;
use super::jackknife::half_band_hz;
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::mac::mac;
use crate::numeric::sorting::sort_rising;
use crate::numeric::statistics::Z_95;

/// Estimates of one mode have shapes this much alike.
const SAME_SHAPE: f64 = 0.9;

/// Least MAC with a certain mode at which an estimate too uncertain to be separated from it is merged.
const MIN_MAC: f64 = 0.8;

/// Within a rung twins are nearer than this share of the half-power half-bandwidth of each, …
const DUPLICATE_BANDWIDTHS: f64 = 0.5;

/// … and than this many of both standard deviations together.
const DUPLICATE_SIGMA: f64 = 1.5;

/// Shapes with this MAC cannot be distinguished.
const ONE_SHAPE: f64 = 0.99;

/// Two modes of one rung that another does not part are two where they are further apart than this many of both standard deviations.
const RESOLVED: f64 = 2.0;

/// A mode identified from responses without a measured input.
#[derive(Debug, Clone)]
pub struct OperationalMode {
    /// Pole, covariance and shape, its largest component 1.
    pub mode: ModalParameters,
    /// Order of the model at which the pole scatters least.
    pub order: usize,
    /// Share of all orders with the pole.
    pub presence: f64,
    /// Standard deviation of the frequency over the orders, Hz.
    pub scatter_hz: f64,
    /// Whether it shows a line of running speed.
    pub harmonic: HarmonicIndicator,
}

/// Two modes on one rung where another shows one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnresolvedPair {
    /// Frequencies of the two, Hz.
    pub two_hz: (f64, f64),
    /// That of the one, Hz.
    pub one_hz: f64,
    /// The two are listed, for they are further apart than they are uncertain.
    pub are_two: bool,
}

/// Whether two estimates of one rung are one mode: near each other with shapes much alike, or of one shape where neither the half-power
/// bands nor the 95 % intervals of the frequencies part.
pub(super) fn is_twin(a: &ModalParameters, b: &ModalParameters) -> bool {
    let off = (a.frequency_hz() - b.frequency_hz()).abs();
    let (stds, similarity) = (std(a) + std(b), mac(&a.shape, &b.shape));
    let is_near = off < DUPLICATE_BANDWIDTHS * half_band_hz(a).min(half_band_hz(b))
        && off < DUPLICATE_SIGMA * stds;
    let is_unresolved = off < half_band_hz(a) + half_band_hz(b) && off < Z_95 * stds;
    (is_near && similarity > SAME_SHAPE) || (is_unresolved && similarity > ONE_SHAPE)
}

/// Whether an estimate is too uncertain to be another mode than a sure one.
pub(super) fn is_shadow(vague: &ModalParameters, sure: &ModalParameters) -> bool {
    /// Times as uncertain.
    const UNCERTAIN_RATIO: f64 = 3.0;
    /// Nearer than this many of both standard deviations.
    const SHADOW_STD: f64 = 3.0;
    let off = (vague.frequency_hz() - sure.frequency_hz()).abs();
    std(vague) > UNCERTAIN_RATIO * std(sure)
        && off < SHADOW_STD * (std(vague) + std(sure))
        && mac(&vague.shape, &sure.shape) > MIN_MAC
}

/// Joins the modes of all rungs, by falling rate.
pub(super) fn merge_levels(
    rungs: Vec<Vec<OperationalMode>>,
) -> (Vec<OperationalMode>, Vec<UnresolvedPair>) {
    let mut found: Vec<OperationalMode> = Vec::new();
    let mut pairs = Vec::new();
    for rung in rungs {
        found = two(found, rung, &mut pairs);
    }
    sort_rising(&mut found, frequency);
    (found, pairs)
}

/// Matches the modes of two lists one to one, the nearest first. Where one list has two modes about one of the other, its own estimates
/// count.
fn two(
    a: Vec<OperationalMode>,
    b: Vec<OperationalMode>,
    pairs: &mut Vec<UnresolvedPair>,
) -> Vec<OperationalMode> {
    let mut near: Vec<(usize, usize, f64)> = Vec::new();
    for (i, j) in (0..a.len()).flat_map(|i| (0..b.len()).map(move |j| (i, j))) {
        if let Some(distance) = distance(&a[i].mode, &b[j].mode) {
            near.push((i, j, distance));
        }
    }
    sort_rising(&mut near, |x| x.2);
    let (mut of_a, mut of_b) = (vec![None; a.len()], vec![None; b.len()]);
    for &(i, j, _) in &near {
        if of_a[i].is_none() && of_b[j].is_none() {
            (of_a[i], of_b[j]) = (Some(j), Some(i));
        }
    }
    // An unmatched mode next to a matched one: this list shows two where the other shows one. They are two where they are further apart
    // than their uncertainty; else the one counts.
    let mut more = (vec![false; a.len()], vec![false; b.len()]);
    let mut extra = (vec![false; a.len()], vec![false; b.len()]);
    for &(i, j, _) in &near {
        let (two, one) = match (of_a[i], of_b[j]) {
            (None, Some(k)) => ((&a[k], &a[i]), &b[j]),
            (Some(k), None) => ((&b[k], &b[j]), &a[i]),
            _ => continue,
        };
        let off = (frequency(two.0) - frequency(two.1)).abs();
        let are_two = off > RESOLVED * (std(&two.0.mode) + std(&two.1.mode));
        match (of_a[i], of_b[j]) {
            (None, Some(k)) if are_two => more.0[k] = true,
            (None, _) => extra.0[i] = true,
            (Some(k), _) if are_two => more.1[k] = true,
            (Some(_), _) => extra.1[j] = true,
        }
        pairs.push(UnresolvedPair {
            two_hz: (frequency(two.0), frequency(two.1)),
            one_hz: frequency(one),
            are_two,
        });
    }
    let keeps_a = |i: usize| match of_a[i] {
        None => !extra.0[i],
        Some(j) if more.0[i] != more.1[j] => more.0[i],
        Some(j) => std(&a[i].mode) <= std(&b[j].mode),
    };
    let kept_a: Vec<bool> = (0..a.len()).map(keeps_a).collect();
    let kept_b: Vec<bool> = (of_b.iter().zip(&extra.1))
        .map(|(i, extra)| i.map_or(!extra, |i: usize| !kept_a[i]))
        .collect();
    let kept = |all: Vec<OperationalMode>, kept: Vec<bool>| {
        let both = all.into_iter().zip(kept);
        both.filter(|x| x.1).map(|x| x.0)
    };
    let all: Vec<OperationalMode> = kept(a, kept_a).chain(kept(b, kept_b)).collect();
    let is_shadowed = |m: &OperationalMode| all.iter().any(|k| is_shadow(&m.mode, &k.mode));
    let shadowed: Vec<bool> = all.iter().map(is_shadowed).collect();
    (all.into_iter().zip(shadowed))
        .filter(|m| !m.1)
        .map(|m| m.0)
        .collect()
}

/// Distance of two estimates that may be one mode over the largest distance allowed.
fn distance(a: &ModalParameters, b: &ModalParameters) -> Option<f64> {
    let off = (a.frequency_hz() - b.frequency_hz()).abs();
    let may = half_band_hz(a)
        .max(half_band_hz(b))
        .max(DUPLICATE_SIGMA * (std(a) + std(b)));
    let is_same = off < may && mac(&a.shape, &b.shape) > SAME_SHAPE;
    is_same.then(|| off / may)
}

fn frequency(mode: &OperationalMode) -> f64 {
    mode.mode.frequency_hz()
}

fn std(mode: &ModalParameters) -> f64 {
    mode.frequency_std_hz().unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Complex;
    use std::f64::consts::TAU;

    fn estimate(frequency_hz: f64, damping: f64, std_hz: f64, shape: [f64; 3]) -> ModalParameters {
        let w = TAU * frequency_hz;
        ModalParameters {
            pole: Complex::new(-damping, (1.0 - damping * damping).sqrt()) * w,
            pole_covariance: Some([1e-4, (TAU * std_hz).powi(2), 0.0]),
            shape: shape.map(|x| Complex::new(x, 0.0)).to_vec(),
        }
    }

    /// 6.136 ± 0.055 and 6.206 ± 0.065 Hz of one shape are one mode; not with another shape, nor where their intervals part.
    #[test]
    fn law_estimates_of_one_shape_with_overlapping_intervals_are_one() {
        let shape = [1.0, 0.5, -0.3];
        let sure = estimate(6.206, 0.022, 0.033, shape);
        assert!(is_twin(&sure, &estimate(6.136, 0.033, 0.028, shape)));
        assert!(!is_twin(
            &sure,
            &estimate(6.136, 0.033, 0.028, [1.0, -0.5, 0.3])
        ));
        let parted = estimate(6.136, 0.033, 0.001, shape);
        assert!(!is_twin(&estimate(6.206, 0.022, 0.001, shape), &parted));
    }
}
