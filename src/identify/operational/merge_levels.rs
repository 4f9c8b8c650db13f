//! Merging of the modes of overlapping decimation levels: each mode once, by its estimate of smaller standard deviation.

use super::harmonics::HarmonicIndicator;
use super::jackknife::half_band_hz;
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::mac::mac;
use crate::numeric::sorting::sort_ascending;
use crate::numeric::statistics::Z_95;

/// Minimum MAC between estimates of one mode.
const SAME_SHAPE: f64 = 0.9;

/// Minimum MAC between an uncertain estimate and the well-determined mode that it duplicates.
const UNCERTAIN_MAC: f64 = 0.8;

/// Maximum frequency distance of duplicates within a level, in half-power half-bandwidths of each.
const DUPLICATE_BANDWIDTHS: f64 = 0.5;

/// Maximum frequency distance of duplicates, in sums of both standard deviations.
const DUPLICATE_SIGMA: f64 = 1.5;

/// MAC above which shapes are indistinguishable.
const INDISTINCT_MAC: f64 = 0.99;

/// Minimum frequency distance, in sums of both standard deviations, of two resolved modes of a level that are one mode at another.
const MIN_SEPARATION: f64 = 2.0;

/// Mode identified by operational modal analysis (output only).
#[derive(Debug, Clone)]
pub struct OperationalMode {
    /// Pole, covariance and shape with a largest component of 1.
    pub mode: ModalParameters,
    /// Model order at which the pole has the smallest scatter.
    pub order: usize,
    /// Share of all orders with the pole, 0 to 1.
    pub presence: f64,
    /// Standard deviation of the frequency over the orders, Hz.
    pub scatter_hz: f64,
    /// Evidence that the mode is a harmonic of the running speed.
    pub harmonic: HarmonicIndicator,
}

/// Two modes at one decimation level that are one mode at another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnresolvedPair {
    /// Natural frequencies of the two modes, Hz.
    pub pair_hz: (f64, f64),
    /// Natural frequency of the single mode, Hz.
    pub single_hz: f64,
    /// Whether the result has both modes, because their distance exceeds their uncertainty.
    pub is_resolved: bool,
}

/// Whether two estimates of one level are the same mode: close frequencies with similar shapes, or indistinguishable shapes with
/// overlapping half-power bands and overlapping 95 % intervals of the frequencies.
pub(super) fn is_same(a: &ModalParameters, b: &ModalParameters) -> bool {
    let distance = (a.frequency_hz() - b.frequency_hz()).abs();
    let (stds, similarity) = (std(a) + std(b), mac(&a.shape, &b.shape));
    let is_close = distance < DUPLICATE_BANDWIDTHS * half_band_hz(a).min(half_band_hz(b))
        && distance < DUPLICATE_SIGMA * stds;
    let is_unresolved = distance < half_band_hz(a) + half_band_hz(b) && distance < Z_95 * stds;
    (is_close && similarity > SAME_SHAPE) || (is_unresolved && similarity > INDISTINCT_MAC)
}

/// Whether an estimate is too uncertain to be distinguished from a well-determined mode.
pub(super) fn is_indistinct(uncertain: &ModalParameters, certain: &ModalParameters) -> bool {
    /// Minimum ratio of the standard deviations.
    const UNCERTAIN_RATIO: f64 = 3.0;
    /// Maximum frequency distance, in sums of both standard deviations.
    const MAX_DISTANCE_SIGMA: f64 = 3.0;
    let distance = (uncertain.frequency_hz() - certain.frequency_hz()).abs();
    std(uncertain) > UNCERTAIN_RATIO * std(certain)
        && distance < MAX_DISTANCE_SIGMA * (std(uncertain) + std(certain))
        && mac(&uncertain.shape, &certain.shape) > UNCERTAIN_MAC
}

/// Merges the modes of all decimation levels, given in descending order of sample rate; the result is in ascending order of frequency.
pub(super) fn merge_levels(
    levels: Vec<Vec<OperationalMode>>,
) -> (Vec<OperationalMode>, Vec<UnresolvedPair>) {
    let mut modes: Vec<OperationalMode> = Vec::new();
    let mut pairs = Vec::new();
    for level in levels {
        modes = merge_two(modes, level, &mut pairs);
    }
    sort_ascending(&mut modes, frequency);
    (modes, pairs)
}

/// Matches the modes of two lists one to one in ascending order of distance. Where one list has two resolved modes for one of the other,
/// its estimates are used.
fn merge_two(
    a: Vec<OperationalMode>,
    b: Vec<OperationalMode>,
    pairs: &mut Vec<UnresolvedPair>,
) -> Vec<OperationalMode> {
    let mut matches: Vec<(usize, usize, f64)> = Vec::new();
    for (i, j) in (0..a.len()).flat_map(|i| (0..b.len()).map(move |j| (i, j))) {
        if let Some(distance) = distance(&a[i].mode, &b[j].mode) {
            matches.push((i, j, distance));
        }
    }
    sort_ascending(&mut matches, |x| x.2);
    let (mut mate_of_a, mut mate_of_b) = (vec![None; a.len()], vec![None; b.len()]);
    for &(i, j, _) in &matches {
        if mate_of_a[i].is_none() && mate_of_b[j].is_none() {
            (mate_of_a[i], mate_of_b[j]) = (Some(j), Some(i));
        }
    }
    // An unmatched mode close to a matched one: this list has two modes where the other has one. The pair is resolved if its distance
    // exceeds its uncertainty; otherwise the single mode is used.
    let mut resolved = (vec![false; a.len()], vec![false; b.len()]);
    let mut extra = (vec![false; a.len()], vec![false; b.len()]);
    for &(i, j, _) in &matches {
        let (pair, single) = match (mate_of_a[i], mate_of_b[j]) {
            (None, Some(k)) => ((&a[k], &a[i]), &b[j]),
            (Some(k), None) => ((&b[k], &b[j]), &a[i]),
            _ => continue,
        };
        let separation = (frequency(pair.0) - frequency(pair.1)).abs();
        let is_resolved = separation > MIN_SEPARATION * (std(&pair.0.mode) + std(&pair.1.mode));
        match (mate_of_a[i], mate_of_b[j]) {
            (None, Some(k)) if is_resolved => resolved.0[k] = true,
            (None, _) => extra.0[i] = true,
            (Some(k), _) if is_resolved => resolved.1[k] = true,
            (Some(_), _) => extra.1[j] = true,
        }
        pairs.push(UnresolvedPair {
            pair_hz: (frequency(pair.0), frequency(pair.1)),
            single_hz: frequency(single),
            is_resolved,
        });
    }
    let is_kept_a = |i: usize| match mate_of_a[i] {
        None => !extra.0[i],
        Some(j) if resolved.0[i] != resolved.1[j] => resolved.0[i],
        Some(j) => std(&a[i].mode) <= std(&b[j].mode),
    };
    let keep_a: Vec<bool> = (0..a.len()).map(is_kept_a).collect();
    let keep_b: Vec<bool> = (mate_of_b.iter().zip(&extra.1))
        .map(|(i, extra)| i.map_or(!extra, |i: usize| !keep_a[i]))
        .collect();
    let selected = |modes: Vec<OperationalMode>, selected: Vec<bool>| {
        let flagged = modes.into_iter().zip(selected);
        flagged.filter(|x| x.1).map(|x| x.0)
    };
    let modes: Vec<OperationalMode> = selected(a, keep_a).chain(selected(b, keep_b)).collect();
    let is_uncertain = |m: &OperationalMode| modes.iter().any(|k| is_indistinct(&m.mode, &k.mode));
    let uncertain: Vec<bool> = modes.iter().map(is_uncertain).collect();
    (modes.into_iter().zip(uncertain))
        .filter(|m| !m.1)
        .map(|m| m.0)
        .collect()
}

/// Frequency distance of two estimates relative to the limit for one mode; `None` beyond it, or with different shapes.
fn distance(a: &ModalParameters, b: &ModalParameters) -> Option<f64> {
    let distance = (a.frequency_hz() - b.frequency_hz()).abs();
    let limit = half_band_hz(a)
        .max(half_band_hz(b))
        .max(DUPLICATE_SIGMA * (std(a) + std(b)));
    let is_match = distance < limit && mac(&a.shape, &b.shape) > SAME_SHAPE;
    is_match.then(|| distance / limit)
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

    /// 6.136 ± 0.055 and 6.206 ± 0.065 Hz with equal shapes are one mode; with another shape or disjoint intervals they are two.
    #[test]
    fn law_estimates_of_one_shape_with_overlapping_intervals_are_one() {
        let shape = [1.0, 0.5, -0.3];
        let mode = estimate(6.206, 0.022, 0.033, shape);
        assert!(is_same(&mode, &estimate(6.136, 0.033, 0.028, shape)));
        assert!(!is_same(
            &mode,
            &estimate(6.136, 0.033, 0.028, [1.0, -0.5, 0.3])
        ));
        let disjoint = estimate(6.136, 0.033, 0.001, shape);
        assert!(!is_same(&estimate(6.206, 0.022, 0.001, shape), &disjoint));
    }
}
