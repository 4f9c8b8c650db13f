//! Response peaks located between frequency lines, with half-power bandwidth.
//!
//! Near a lightly damped mode `1/|H|²` is a parabola over frequency, and `√(1/|H|² − 1/|H|²_max)` a straight line on either side. Parabolic
//! interpolation of the first locates a peak, secants of the second its half-power frequencies, with few solutions each.

use crate::base::error::Error;
use crate::numeric::sorting::sort_ascending;

/// A peak of a frequency response with its half-power band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResponsePeak {
    /// Peak frequency, rad/s.
    pub omega: f64,
    /// Peak height, unit of the response.
    pub height: f64,
    /// Half-power frequencies, rad/s, at 1/√2 of the height on either side; `None` if a neighbouring peak interferes.
    pub half_power: Option<(f64, f64)>,
}

impl ResponsePeak {
    /// Half-power damping ratio `ζ = (ω₂ − ω₁) / (ω₂ + ω₁)`, valid for an isolated lightly damped mode.
    pub fn damping(&self) -> Option<f64> {
        self.half_power
            .map(|(low, high)| (high - low) / (high + low))
    }
}

/// Relative tolerance of a peak frequency; the error of the height is its square.
const FREQUENCY_TOLERANCE: f64 = 1e-8;

/// Tolerance of a half-power search step, relative to the distance from the peak; the error is of higher order.
const STEP_TOLERANCE: f64 = 1e-7;

/// Relative decrease of `1/h²` below which a peak search ends; the frequency is then accurate to 3e-7 of the width.
const HEIGHT_TOLERANCE: f64 = 1e-13;

/// Finds the peaks of `height` (by ω, rad/s) over the lines (ω, height) and near the natural frequencies, rad/s; peaks by rising ω.
///
/// Every natural frequency is evaluated with two neighbours, so that no narrow peak falls between lines.
///
/// # Errors
/// Errors of `height`.
pub fn find_peaks(
    lines: &[(f64, f64)],
    natural: &[f64],
    mut height: impl FnMut(f64) -> Result<f64, Error>,
) -> Result<Vec<ResponsePeak>, Error> {
    // Relative offset of the neighbours; a damping ratio of some per mille shifts a peak by as much.
    const NEIGHBOUR_OFFSET: f64 = 2e-3;
    let (Some(first), Some(last)) = (lines.first(), lines.last()) else {
        return Ok(Vec::new());
    };
    let mut grid = lines.to_vec();
    for &omega in natural {
        for trial in [
            omega * (1.0 - NEIGHBOUR_OFFSET),
            omega,
            omega * (1.0 + NEIGHBOUR_OFFSET),
        ] {
            if trial > first.0 && trial < last.0 {
                grid.push((trial, height(trial)?));
            }
        }
    }
    sort_ascending(&mut grid, |a| a.0);
    grid.dedup_by(|a, b| a.0 == b.0);
    let mut peaks = Vec::new();
    for k in 1..grid.len().saturating_sub(1) {
        if !(grid[k].1 >= grid[k - 1].1 && grid[k].1 > grid[k + 1].1) {
            continue;
        }
        let (omega, top) = refine_maximum(grid[k - 1], grid[k], grid[k + 1], &mut height)?;
        let target = top * std::f64::consts::FRAC_1_SQRT_2;
        let below = half_power_frequency(
            &mut grid[..k].iter().rev(),
            (omega, top),
            target,
            &mut height,
        )?;
        let above =
            half_power_frequency(&mut grid[k + 1..].iter(), (omega, top), target, &mut height)?;
        peaks.push(ResponsePeak {
            omega,
            height: top,
            half_power: below.zip(above),
        });
    }
    Ok(peaks)
}

/// Refines a maximum between two neighbours by successive parabolic interpolation of `1/h²` (Brent, Algorithms for Minimization
/// without Derivatives (1973), §5.2), with golden sections if a step does not halve.
fn refine_maximum(
    low: (f64, f64),
    best: (f64, f64),
    high: (f64, f64),
    height: &mut impl FnMut(f64) -> Result<f64, Error>,
) -> Result<(f64, f64), Error> {
    const GOLDEN_RATIO: f64 = 0.381_966_011_250_105; // (3 − √5) / 2
    let (mut low, mut best, mut high) = (low, best, high);
    let mut previous = f64::INFINITY;
    while high.0 - low.0 > FREQUENCY_TOLERANCE * high.0 {
        let vertex = parabola_vertex(low, best, high);
        let vertex = vertex.filter(|v| low.0 < v.0 && v.0 < high.0);
        if vertex.is_some_and(|v| v.1 <= HEIGHT_TOLERANCE) {
            break;
        }
        let step = |v: &(f64, f64)| (v.0 - best.0).abs();
        let accepted = vertex.filter(|v| step(v) < 0.5 * previous);
        previous = accepted.as_ref().map_or(f64::INFINITY, step);
        let omega = match accepted {
            Some((omega, _)) => omega,
            None if high.0 - best.0 > best.0 - low.0 => best.0 + GOLDEN_RATIO * (high.0 - best.0),
            None => best.0 - GOLDEN_RATIO * (best.0 - low.0),
        };
        let point = (omega, height(omega)?);
        match (point.1 > best.1, omega > best.0) {
            (true, true) => (low, best) = (best, point),
            (true, false) => (high, best) = (best, point),
            (false, true) => high = point,
            (false, false) => low = point,
        }
    }
    Ok(best)
}

/// Minimum of the parabola through `1/h²` at three frequencies, with its relative depth below the middle one; `None` if the parabola has
/// no minimum.
fn parabola_vertex(lower: (f64, f64), best: (f64, f64), upper: (f64, f64)) -> Option<(f64, f64)> {
    let secant = |point: (f64, f64)| ((best.1 / point.1).powi(2) - 1.0) / (point.0 - best.0);
    let (left, right) = (secant(lower), secant(upper));
    let curvature = (right - left) / (upper.0 - lower.0);
    let slope = left - curvature * (lower.0 - best.0);
    let step = -0.5 * slope / curvature;
    (curvature > 0.0 && step.is_finite()).then_some((best.0 + step, curvature * step * step))
}

/// Frequency at which the height falls to `target`; `None` if it rises before.
fn half_power_frequency(
    points: &mut dyn Iterator<Item = &(f64, f64)>,
    top: (f64, f64),
    target: f64,
    height: &mut impl FnMut(f64) -> Result<f64, Error>,
) -> Result<Option<f64>, Error> {
    let mut last = top;
    for &point in points {
        if point.1 > last.1 {
            return Ok(None);
        }
        if point.1 > target {
            last = point;
            continue;
        }
        return secant_search(last, point, (top, target), height).map(Some);
    }
    Ok(None)
}

/// Frequency between two others at which the height falls to `target`, by the Illinois method (Dowell & Jarratt 1971, BIT 11, 168) on
/// `√((top/h)² − 1)`.
fn secant_search(
    above: (f64, f64),
    below: (f64, f64),
    (top, target): ((f64, f64), f64),
    height: &mut impl FnMut(f64) -> Result<f64, Error>,
) -> Result<f64, Error> {
    const MAX_STEPS: usize = 100;
    let fall = |h: f64| ((top.1 / h).powi(2) - 1.0).max(0.0).sqrt();
    let level = fall(target);
    let excess = |h: f64| fall(h) - level;
    let (mut a, mut b) = ((above.0, excess(above.1)), (below.0, excess(below.1)));
    let mut omega = f64::INFINITY;
    for _ in 0..MAX_STEPS {
        // A height of zero gives no secant; bisect.
        let next = match b.1.is_finite() {
            true => b.0 - b.1 * (b.0 - a.0) / (b.1 - a.1),
            false => 0.5 * (a.0 + b.0),
        };
        if (next - omega).abs() <= STEP_TOLERANCE * (next - top.0).abs() {
            return Ok(next);
        }
        omega = next;
        let value = excess(height(omega)?);
        match (value > 0.0, b.1 > 0.0) {
            _ if value == 0.0 => return Ok(omega),
            (true, true) | (false, false) => {
                (b, a.1) = ((omega, value), 0.5 * a.1);
            }
            _ => (a, b) = (b, (omega, value)),
        }
    }
    Ok(omega)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The peak of `1 / |1 − x² + 2iζx|` is 1/(2ζ√(1 − ζ²)) at √(1 − 2ζ²); half-power damping is ζ within ζ².
    #[test]
    fn exact_one_mode() {
        let zeta = 0.004_f64;
        let height = |x: f64| Ok(1.0 / (1.0 - x * x).hypot(2.0 * zeta * x));
        // Coarse lines far from the peak.
        let lines: Vec<(f64, f64)> = [0.3, 0.7, 1.4, 2.0]
            .iter()
            .map(|&x| (x, height(x).unwrap_or(0.0)))
            .collect();
        let peaks = find_peaks(&lines, &[1.0], height).unwrap_or_default();
        assert_eq!(peaks.len(), 1);
        assert!((peaks[0].omega - (1.0 - 2.0 * zeta * zeta).sqrt()).abs() < 1e-7);
        assert!((peaks[0].height * 2.0 * zeta * (1.0 - zeta * zeta).sqrt() - 1.0).abs() < 1e-12);
        assert!((peaks[0].damping().unwrap_or(0.0) / zeta - 1.0).abs() < 1e-4);
    }

    /// One mode with damping ratios from 1e-7 to 20 %: frequency, height and half-power band from at most 13 heights, 18 at 20 %.
    #[test]
    fn exact_few_solutions_a_peak() {
        for (zeta, max_count) in [(1e-7, 13), (1e-5, 13), (1e-3, 13), (0.02, 13), (0.2, 18)] {
            let mut count = 0;
            let magnitude = |x: f64| 1.0 / (1.0 - x * x).hypot(2.0 * zeta * x);
            let lines: Vec<(f64, f64)> = (1..40)
                .map(|k| 0.0613 * f64::from(k))
                .map(|x| (x, magnitude(x)))
                .collect();
            let height = |x: f64| {
                count += 1;
                Ok(magnitude(x))
            };
            let peaks = find_peaks(&lines, &[1.0], height).unwrap_or_default();
            assert_eq!(peaks.len(), 1);
            let (peak, square) = (peaks[0], 1.0 - 2.0 * zeta * zeta);
            assert!(
                (peak.omega - square.sqrt()).abs() < 1e-6 * zeta,
                "{zeta}: {}",
                peak.omega
            );
            let top = 1.0 / (2.0 * zeta * (1.0 - zeta * zeta).sqrt());
            assert!((peak.height / top - 1.0).abs() < 1e-12 + 1e-16 / zeta);
            // x² = 1 − 2ζ² ∓ 2ζ√(1 − ζ²)
            let half = 2.0 * zeta * (1.0 - zeta * zeta).sqrt();
            let (low, high) = peak.half_power.unwrap_or_default();
            assert!(
                (low - (square - half).sqrt()).abs() < 1e-6 * zeta,
                "{zeta}: {low}"
            );
            assert!(
                (high - (square + half).sqrt()).abs() < 1e-6 * zeta,
                "{zeta}: {high}"
            );
            assert!(count <= max_count, "{zeta}: {count}");
        }
    }
}
