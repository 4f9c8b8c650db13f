//! Adaptive refinement of frequency lines for plots: modal circles, then bisection of chords.

use std::collections::VecDeque;

use crate::base::error::Error;
use crate::numeric::sorting::sort_ascending;
use crate::numeric::{Complex, ComplexMatrix};

/// Frequency responses on refined lines.
#[derive(Debug, Clone)]
pub struct RefinedResponse {
    /// Frequencies, rad/s, ascending.
    pub omega: Vec<f64>,
    /// Frequency responses, outputs by inputs, one matrix per frequency.
    pub values: Vec<ComplexMatrix>,
}

/// Largest distance of the midpoint from the chord, relative to the largest response.
const CHORD_TOLERANCE: f64 = 4e-3;

/// Largest deviation of the logarithmic magnitude at the midpoint, nepers; half a point on a plot of five decades.
const LEVEL_TOLERANCE: f64 = 0.03;

/// Number of points on either side of a modal circle, 10° apart.
const CIRCLE_POINTS: usize = 17;

/// Smallest interval that is bisected, relative to its frequency.
const MIN_INTERVAL: f64 = 1e-9;

/// Largest number of lines added by bisection.
fn max_added_lines(lines: usize) -> usize {
    2 * lines + 1000
}

/// Adds lines between `omega`, rad/s, with known `values`: on the modal circles of `peaks` (frequency and half-power width, rad/s), then by
/// bisection of intervals with curved response. `h` evaluates new lines; failed ones are omitted.
pub fn refine(
    omega: &[f64],
    values: Vec<ComplexMatrix>,
    peaks: &[(f64, f64)],
    h: impl Fn(f64) -> Result<ComplexMatrix, Error>,
) -> RefinedResponse {
    let (Some(&first), Some(&last)) = (omega.first(), omega.last()) else {
        return RefinedResponse {
            omega: Vec::new(),
            values,
        };
    };
    let mut lines: Vec<(f64, ComplexMatrix)> = omega.iter().copied().zip(values).collect();
    for &(centre, width) in peaks {
        for k in 0..=2 * CIRCLE_POINTS {
            let angle = (k as f64 - CIRCLE_POINTS as f64) * 10f64.to_radians();
            let line = centre + 0.5 * width * (0.5 * angle).tan();
            if first < line
                && line < last
                && let Ok(value) = h(line)
            {
                lines.push((line, value));
            }
        }
    }
    sort_lines(&mut lines);
    let largest = max_magnitudes(&lines);
    // Intervals by the indices of their ends; new lines are appended and sorted at the end.
    let mut intervals: VecDeque<(usize, usize)> = (1..lines.len()).map(|k| (k - 1, k)).collect();
    let mut n_left = max_added_lines(omega.len());
    while n_left > 0
        && let Some((a, b)) = intervals.pop_front()
    {
        let middle = 0.5 * (lines[a].0 + lines[b].0);
        if (lines[b].0 - lines[a].0).abs() < MIN_INTERVAL * middle.abs() {
            continue;
        }
        let Ok(value) = h(middle) else { continue };
        n_left -= 1;
        let is_flat = is_straight(&lines[a].1, &value, &lines[b].1, &largest);
        lines.push((middle, value));
        let index = lines.len() - 1;
        if !is_flat {
            intervals.extend([(a, index), (index, b)]);
        }
    }
    sort_lines(&mut lines);
    let (omega, values) = lines.into_iter().unzip();
    RefinedResponse { omega, values }
}

fn sort_lines(lines: &mut Vec<(f64, ComplexMatrix)>) {
    sort_ascending(lines, |a| a.0);
    lines.dedup_by(|a, b| a.0 == b.0);
}

/// Largest magnitude of every response.
fn max_magnitudes(lines: &[(f64, ComplexMatrix)]) -> Vec<f64> {
    let Some((_, first)) = lines.first() else {
        return Vec::new();
    };
    let (rows, columns) = (first.nrows(), first.ncols());
    let size = |o: usize, i: usize| {
        let sizes = lines.iter().map(|v| v.1[(o, i)].norm());
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
        let entry = |m: &ComplexMatrix| -> Complex { m[(k / columns, k % columns)] };
        let (a, m, b) = (entry(a), entry(middle), entry(b));
        let distance = (m - (a + b) * 0.5).norm();
        let level = |z: Complex| z.norm().max(1e-12 * largest).ln();
        let log_deviation = (level(m) - 0.5 * (level(a) + level(b))).abs();
        // NaN counts as straight.
        !(distance > CHORD_TOLERANCE * largest) && !(log_deviation > LEVEL_TOLERANCE)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mode of 0.1 % damping between two coarse lines: its circle is drawn within the chord tolerance, from few lines.
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
        let refined = refine(&omega, values, &[(natural, width)], response);
        let top = refined
            .values
            .iter()
            .map(|v| v[(0, 0)].norm())
            .fold(0.0, f64::max);
        assert!((top * 2.0 * zeta - 1.0).abs() < 1e-3, "{top}");
        assert!(refined.omega.len() < 1100);
        assert!(refined.omega.windows(2).all(|w| w[0] < w[1]));
        // Between adjacent lines the curve deviates from its chord by at most the tolerance.
        for k in 1..refined.omega.len() {
            let middle = 0.5 * (refined.omega[k - 1] + refined.omega[k]);
            let chord = (refined.values[k - 1][(0, 0)] + refined.values[k][(0, 0)]) * 0.5;
            let value = response(middle).map_or(Complex::ZERO, |m| m[(0, 0)]);
            assert!((value - chord).norm() < CHORD_TOLERANCE * top, "{middle}");
        }
    }
}
