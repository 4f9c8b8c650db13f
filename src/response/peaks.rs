//! Response peaks located between frequency lines, with half-power bandwidth.
//!
//! Near a lightly damped mode `1/|H|²` is a parabola over frequency, and `√(1/|H|² − 1/|H|²_max)` a straight line on either side: a peak is
//! found by parabolic interpolation of the first, its half-power frequencies by secants of the second, from few solutions each.

use crate::base::error::Error;
use crate::numeric::sorting::sort_rising;

/// A peak of a frequency response with its half-power band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResponsePeak {
    /// Peak frequency, rad/s.
    pub omega: f64,
    /// Peak height.
    pub height: f64,
    /// Half-power frequencies, where the height has fallen to 1/√2 on either side, rad/s; absent where a neighbouring peak interferes.
    pub half_power: Option<(f64, f64)>,
}

impl ResponsePeak {
    /// `ζ = (ω₂ − ω₁) / (ω₂ + ω₁)`, right for a single lightly damped mode.
    pub fn damping(&self) -> Option<f64> {
        self.half_power
            .map(|(low, high)| (high - low) / (high + low))
    }
}

/// Relative, of a peak's place: the height there is right to its square.
const FREQUENCY_TOLERANCE: f64 = 1e-8;

/// A search for a half-power frequency ends at a step this small, of its distance from the peak: the error is then of higher order.
const PLACE_TOLERANCE: f64 = 1e-7;

/// A search for a peak ends where the parabola promises no more than this, of `1/h²`: its place is right to 3e-7 of its width.
const HEIGHT_TOLERANCE: f64 = 1e-13;

/// The peaks of `height` over lines and frequencies near which there may be some, ascending.
///
/// Every natural frequency is looked at with two neighbours, so that no narrow peak falls between lines.
///
/// # Errors
/// Those of `height`.
pub fn find_peaks(
    lines: &[(f64, f64)],
    near: &[f64],
    mut height: impl FnMut(f64) -> Result<f64, Error>,
) -> Result<Vec<ResponsePeak>, Error> {
    // As far from a natural frequency as the damping of some per mille moves its peak.
    const NEIGHBOUR_OFFSET: f64 = 2e-3;
    let (Some(first), Some(last)) = (lines.first(), lines.last()) else {
        return Ok(Vec::new());
    };
    let mut all = lines.to_vec();
    for &omega in near {
        for place in [
            omega * (1.0 - NEIGHBOUR_OFFSET),
            omega,
            omega * (1.0 + NEIGHBOUR_OFFSET),
        ] {
            if place > first.0 && place < last.0 {
                all.push((place, height(place)?));
            }
        }
    }
    sort_rising(&mut all, |a| a.0);
    all.dedup_by(|a, b| a.0 == b.0);
    let mut found = Vec::new();
    for k in 1..all.len().saturating_sub(1) {
        if !(all[k].1 >= all[k - 1].1 && all[k].1 > all[k + 1].1) {
            continue;
        }
        let (omega, top) = refine_maximum(all[k - 1], all[k], all[k + 1], &mut height)?;
        let target = top * std::f64::consts::FRAC_1_SQRT_2;
        let below = half_power_frequency(
            &mut all[..k].iter().rev(),
            (omega, top),
            target,
            &mut height,
        )?;
        let above =
            half_power_frequency(&mut all[k + 1..].iter(), (omega, top), target, &mut height)?;
        found.push(ResponsePeak {
            omega,
            height: top,
            half_power: below.zip(above),
        });
    }
    Ok(found)
}

/// The highest place between two neighbours, by successive parabolic interpolation of `1/h²` (Brent, Algorithms for Minimization
/// without Derivatives (1973), §5.2), with golden sections where a step does not shorten the longer side.
fn refine_maximum(
    low: (f64, f64),
    best: (f64, f64),
    high: (f64, f64),
    height: &mut impl FnMut(f64) -> Result<f64, Error>,
) -> Result<(f64, f64), Error> {
    const GOLDEN_RATIO: f64 = 0.381_966_011_250_105; // (3 − √5) / 2
    let (mut low, mut best, mut high) = (low, best, high);
    let mut before = f64::INFINITY;
    while high.0 - low.0 > FREQUENCY_TOLERANCE * high.0 {
        let vertex = parabola_vertex(low, best, high);
        let vertex = vertex.filter(|v| low.0 < v.0 && v.0 < high.0);
        if vertex.is_some_and(|v| v.1 <= HEIGHT_TOLERANCE) {
            break;
        }
        let step = |v: &(f64, f64)| (v.0 - best.0).abs();
        let shorter = vertex.filter(|v| step(v) < 0.5 * before);
        before = shorter.as_ref().map_or(f64::INFINITY, step);
        let place = match shorter {
            Some((place, _)) => place,
            None if high.0 - best.0 > best.0 - low.0 => best.0 + GOLDEN_RATIO * (high.0 - best.0),
            None => best.0 - GOLDEN_RATIO * (best.0 - low.0),
        };
        let point = (place, height(place)?);
        match (point.1 > best.1, place > best.0) {
            (true, true) => (low, best) = (best, point),
            (true, false) => (high, best) = (best, point),
            (false, true) => high = point,
            (false, false) => low = point,
        }
    }
    Ok(best)
}

/// Place where the parabola through `1/h²` at three places is least, and how far below the middle one, relative; none where they lie on a line
/// or bend the other way.
fn parabola_vertex(low: (f64, f64), best: (f64, f64), high: (f64, f64)) -> Option<(f64, f64)> {
    let rise = |point: (f64, f64)| ((best.1 / point.1).powi(2) - 1.0) / (point.0 - best.0);
    let (left, right) = (rise(low), rise(high));
    let bend = (right - left) / (high.0 - low.0);
    let slope = left - bend * (low.0 - best.0);
    let step = -0.5 * slope / bend;
    (bend > 0.0 && step.is_finite()).then_some((best.0 + step, bend * step * step))
}

/// Frequency at which the height falls to `target` before it rises again.
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
        return falling_to(last, point, (top, target), height).map(Some);
    }
    Ok(None)
}

/// Place between two others where the height falls to `target`: secants of `√((top/h)² − 1)`, the side that stays halved (Illinois; Dowell &
/// Jarratt 1971, BIT 11, 168).
fn falling_to(
    over: (f64, f64),
    under: (f64, f64),
    (top, target): ((f64, f64), f64),
    height: &mut impl FnMut(f64) -> Result<f64, Error>,
) -> Result<f64, Error> {
    const MAX_STEPS: usize = 100;
    let fall = |h: f64| ((top.1 / h).powi(2) - 1.0).max(0.0).sqrt();
    let wanted = fall(target);
    let off = |h: f64| fall(h) - wanted;
    let (mut a, mut b) = ((over.0, off(over.1)), (under.0, off(under.1)));
    let mut place = f64::INFINITY;
    for _ in 0..MAX_STEPS {
        // A height of zero has no secant.
        let next = match b.1.is_finite() {
            true => b.0 - b.1 * (b.0 - a.0) / (b.1 - a.1),
            false => 0.5 * (a.0 + b.0),
        };
        if (next - place).abs() <= PLACE_TOLERANCE * (next - top.0).abs() {
            return Ok(next);
        }
        place = next;
        let value = off(height(place)?);
        match (value > 0.0, b.1 > 0.0) {
            _ if value == 0.0 => return Ok(place),
            (true, true) | (false, false) => {
                (b, a.1) = ((place, value), 0.5 * a.1);
            }
            _ => (a, b) = (b, (place, value)),
        }
    }
    Ok(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The peak of `1 / |1 − x² + 2iζx|` is at √(1 − 2ζ²), 1/(2ζ√(1 − ζ²)) high; half power within ζ² of ζ.
    #[test]
    fn exact_one_mode() {
        let zeta = 0.004_f64;
        let height = |x: f64| Ok(1.0 / (1.0 - x * x).hypot(2.0 * zeta * x));
        // Lines that miss it by far.
        let lines: Vec<(f64, f64)> = [0.3, 0.7, 1.4, 2.0]
            .iter()
            .map(|&x| (x, height(x).unwrap_or(0.0)))
            .collect();
        let found = find_peaks(&lines, &[1.0], height).unwrap_or_default();
        assert_eq!(found.len(), 1);
        assert!((found[0].omega - (1.0 - 2.0 * zeta * zeta).sqrt()).abs() < 1e-7);
        assert!((found[0].height * 2.0 * zeta * (1.0 - zeta * zeta).sqrt() - 1.0).abs() < 1e-12);
        assert!((found[0].damping().unwrap_or(0.0) / zeta - 1.0).abs() < 1e-4);
    }

    /// One mode from no damping to speak of to 20 %: place, height and damping from 13 heights, 18 where it is heavy.
    #[test]
    fn exact_few_solutions_a_peak() {
        for (zeta, most) in [(1e-7, 13), (1e-5, 13), (1e-3, 13), (0.02, 13), (0.2, 18)] {
            let mut count = 0;
            let at = |x: f64| 1.0 / (1.0 - x * x).hypot(2.0 * zeta * x);
            let lines: Vec<(f64, f64)> = (1..40)
                .map(|k| 0.0613 * f64::from(k))
                .map(|x| (x, at(x)))
                .collect();
            let height = |x: f64| {
                count += 1;
                Ok(at(x))
            };
            let found = find_peaks(&lines, &[1.0], height).unwrap_or_default();
            assert_eq!(found.len(), 1);
            let (peak, square) = (found[0], 1.0 - 2.0 * zeta * zeta);
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
            assert!(count <= most, "{zeta}: {count}");
        }
    }
}
