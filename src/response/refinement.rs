//! Adaptive refinement of frequency lines for plots: modal circles, then bisection of chords.

use std::collections::VecDeque;

use crate::base::error::Error;
use crate::numeric::sorting::sort_rising;
use crate::numeric::{Complex, ComplexMatrix};

/// Responses on lines that follow them.
#[derive(Debug, Clone)]
pub struct RefinedResponse {
    /// rad/s, rising.
    pub omega: Vec<f64>,
    /// All outputs by all inputs at each.
    pub values: Vec<ComplexMatrix>,
}

/// A piece is straight where its middle lies so near the chord, over the largest value of the response.
const CHORD_TOLERANCE: f64 = 4e-3;

/// And where the middle's size is the chord's to this, in natural logarithms: half a point of a plot of five decades.
const LEVEL_TOLERANCE: f64 = 0.03;

/// Angles on a peak's circle, to either side.
const CIRCLE_POINTS: usize = 17;

/// A piece shorter than this is not halved, relative.
const MIN_INTERVAL: f64 = 1e-9;

/// Lines added to `lines` at most, next to those of the peaks.
fn max_added_lines(lines: usize) -> usize {
    2 * lines + 1000
}

/// Puts lines between `omega`, on which `values` are known, where `at` needs them: near `peaks` (place and half-power width, rad/s) and
/// wherever a piece is not straight. Where `at` has no answer nothing is put.
pub fn refine(
    omega: &[f64],
    values: Vec<ComplexMatrix>,
    peaks: &[(f64, f64)],
    at: impl Fn(f64) -> Result<ComplexMatrix, Error>,
) -> RefinedResponse {
    let (Some(&first), Some(&last)) = (omega.first(), omega.last()) else {
        return RefinedResponse {
            omega: Vec::new(),
            values,
        };
    };
    let mut all: Vec<(f64, ComplexMatrix)> = omega.iter().copied().zip(values).collect();
    for &(place, width) in peaks {
        for k in 0..=2 * CIRCLE_POINTS {
            let angle = (k as f64 - CIRCLE_POINTS as f64) * 10f64.to_radians();
            let near = place + 0.5 * width * (0.5 * angle).tan();
            if first < near
                && near < last
                && let Ok(value) = at(near)
            {
                all.push((near, value));
            }
        }
    }
    sorted(&mut all);
    let largest = max_magnitudes(&all);
    // Pieces by the numbers of their ends; new lines are put behind and sorted in at the end.
    let mut open: VecDeque<(usize, usize)> = (1..all.len()).map(|k| (k - 1, k)).collect();
    let mut left = max_added_lines(omega.len());
    while left > 0
        && let Some((a, b)) = open.pop_front()
    {
        let middle = 0.5 * (all[a].0 + all[b].0);
        if (all[b].0 - all[a].0).abs() < MIN_INTERVAL * middle.abs() {
            continue;
        }
        let Ok(value) = at(middle) else { continue };
        left -= 1;
        let straight = is_straight(&all[a].1, &value, &all[b].1, &largest);
        all.push((middle, value));
        let new = all.len() - 1;
        if !straight {
            open.extend([(a, new), (new, b)]);
        }
    }
    sorted(&mut all);
    let (omega, values) = all.into_iter().unzip();
    RefinedResponse { omega, values }
}

fn sorted(all: &mut Vec<(f64, ComplexMatrix)>) {
    sort_rising(all, |a| a.0);
    all.dedup_by(|a, b| a.0 == b.0);
}

/// The largest size of every response.
fn max_magnitudes(all: &[(f64, ComplexMatrix)]) -> Vec<f64> {
    let Some((_, first)) = all.first() else {
        return Vec::new();
    };
    let (rows, columns) = (first.nrows(), first.ncols());
    let size = |o: usize, i: usize| {
        let sizes = all.iter().map(|v| v.1[(o, i)].norm());
        sizes.filter(|x| x.is_finite()).fold(0.0, f64::max)
    };
    (0..rows)
        .flat_map(|o| (0..columns).map(move |i| (o, i)))
        .map(|(o, i)| size(o, i))
        .collect()
}

fn is_straight(
    a: &ComplexMatrix,
    middle: &ComplexMatrix,
    b: &ComplexMatrix,
    largest: &[f64],
) -> bool {
    let columns = middle.ncols();
    largest.iter().enumerate().all(|(k, &largest)| {
        let of = |m: &ComplexMatrix| -> Complex { m[(k / columns, k % columns)] };
        let (a, m, b) = (of(a), of(middle), of(b));
        let off = (m - (a + b) * 0.5).norm();
        let level = |z: Complex| z.norm().max(1e-12 * largest).ln();
        let bent = (level(m) - 0.5 * (level(a) + level(b))).abs();
        // What is no number bends nothing.
        !(off > CHORD_TOLERANCE * largest) && !(bent > LEVEL_TOLERANCE)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mode of 0.1 % damping between two lines of a coarse grid: its circle is drawn within the chord's bound, from few lines.
    #[test]
    fn exact_circle_between_lines() {
        let (natural, zeta) = (10.37_f64, 1e-3);
        let response = |w: f64| {
            let x = w / natural;
            let z = Complex::ONE / Complex::new(1.0 - x * x, 2.0 * zeta * x);
            Ok(ComplexMatrix::from_fn(1, 1, |_, _| z))
        };
        let omega: Vec<f64> = (0..21).map(f64::from).collect();
        let values: Vec<ComplexMatrix> = omega.iter().filter_map(|w| response(*w).ok()).collect();
        let width = 2.0 * zeta * natural;
        let found = refine(&omega, values, &[(natural, width)], response);
        let top = found
            .values
            .iter()
            .map(|v| v[(0, 0)].norm())
            .fold(0.0, f64::max);
        assert!((top * 2.0 * zeta - 1.0).abs() < 1e-3, "{top}");
        assert!(found.omega.len() < 1100);
        assert!(found.omega.windows(2).all(|w| w[0] < w[1]));
        // Between any two lines the curve leaves its chord by no more than the bound.
        for k in 1..found.omega.len() {
            let middle = 0.5 * (found.omega[k - 1] + found.omega[k]);
            let chord = (found.values[k - 1][(0, 0)] + found.values[k][(0, 0)]) * 0.5;
            let there = response(middle).map_or(Complex::ZERO, |m| m[(0, 0)]);
            assert!((there - chord).norm() < CHORD_TOLERANCE * top, "{middle}");
        }
    }
}
