//! Response peaks located between frequency lines, with half-power bandwidth.

use crate::base::error::Error;

/// A peak.
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
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.dedup_by(|a, b| a.0 == b.0);
    let mut found = Vec::new();
    for k in 1..all.len().saturating_sub(1) {
        if !(all[k].1 >= all[k - 1].1 && all[k].1 > all[k + 1].1) {
            continue;
        }
        let (omega, top) = refine_maximum(all[k - 1].0, all[k], all[k + 1].0, &mut height)?;
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

/// The highest place between two neighbours, by golden section.
fn refine_maximum(
    mut low: f64,
    (mut best, mut top): (f64, f64),
    mut high: f64,
    height: &mut impl FnMut(f64) -> Result<f64, Error>,
) -> Result<(f64, f64), Error> {
    const GOLDEN_RATIO: f64 = 0.381_966_011_250_105; // (3 − √5) / 2
    while high - low > FREQUENCY_TOLERANCE * high {
        let above = high - best > best - low;
        let place = if above {
            best + GOLDEN_RATIO * (high - best)
        } else {
            best - GOLDEN_RATIO * (best - low)
        };
        let value = height(place)?;
        if value > top {
            if above {
                low = best
            } else {
                high = best
            }
            (best, top) = (place, value);
        } else if above {
            high = place;
        } else {
            low = place;
        }
    }
    Ok((best, top))
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
        let (mut over, mut under) = (last.0, point.0);
        while (over - under).abs() > FREQUENCY_TOLERANCE * FREQUENCY_TOLERANCE.sqrt() * over {
            let middle = 0.5 * (over + under);
            if middle == over || middle == under {
                break;
            }
            if height(middle)? > target {
                over = middle
            } else {
                under = middle
            }
        }
        return Ok(Some(0.5 * (over + under)));
    }
    Ok(None)
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
}
