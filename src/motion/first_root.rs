//! First root of a polynomial by safe steps `h < (d + √(d² + 2 M p))/M`.
//!
//! With `p ≥ 0`, slope d and `|p″| ≤ M`, the lower bound `p + d h − M h²/2` is positive for `h < (d + √(d² + 2 M p))/M`: a step of that
//! length passes no root, and the steps converge quadratically to the first root from one side. If `d < 0` and `M p < d²/4`, there is
//! exactly one root within `2p/|d|`, since `p′ < d/2` there, and Newton's method finds it.

use super::problem::IntegrationStats;

/// Polynomial in x, `|x| ≤ 1`, with the rounding error of its value.
#[derive(Debug, Clone, Copy)]
pub struct BoundedPolynomial<'a> {
    /// Coefficients in ascending powers of x.
    pub coefficients: &'a [f64],
    /// Bound of the rounding error of a value.
    pub noise: f64,
    /// True if the start is a root that was just crossed, where the polynomial rises.
    pub starts_at_root: bool,
}

/// First root in the range `[from, to]`; its start if the value there is negative, or zero and falling.
///
/// A root touched within the rounding error and not crossed is passed by a step over which the value changes by at most that error, and
/// counted as grazing.
pub fn first_root(
    surface: BoundedPolynomial,
    [from, to]: [f64; 2],
    stats: &mut IntegrationStats,
) -> Option<f64> {
    let p = surface.coefficients;
    let (range, curvature) = derivative_bounds(p);
    if !surface.starts_at_root && p.first().is_some_and(|&constant| constant > range) {
        return None;
    }
    let min_step = (2.0 * surface.noise / curvature).sqrt();
    let (mut x, mut crossed) = (from, surface.starts_at_root);
    loop {
        stats.evaluations += 1;
        let (value, slope) = value_and_slope(p, x);
        let at_root =
            value <= surface.noise && (crossed || (value >= -surface.noise && slope > 0.0));
        // The value falls by more than its rounding error.
        let crosses = slope < 0.0 && slope * slope > 4.0 * curvature * surface.noise;
        let step = if at_root && !crosses {
            stats.grazings += u64::from(2.0 * slope < curvature * min_step);
            2.0 * slope / curvature
        } else if value <= surface.noise {
            return Some(x);
        } else if slope < 0.0 && 4.0 * curvature * value < slope * slope {
            return newton(p, x, x - 2.0 * value / slope).filter(|&root| root <= to);
        } else {
            let root_term = (slope * slope + 2.0 * curvature * value).sqrt();
            match slope > 0.0 {
                true => (slope + root_term) / curvature,
                false => 2.0 * value / (root_term - slope),
            }
        };
        x += step.max(min_step);
        if !(x < to) {
            return None;
        }
        crossed = false;
    }
}

/// Bounds of `|p(x) − p(0)|` and of `|p″|` over `|x| ≤ 1`.
fn derivative_bounds(p: &[f64]) -> (f64, f64) {
    const LANES: usize = 4;
    let (mut range, mut curvature) = ([0.0; LANES], [0.0; LANES]);
    let mut power: [f64; LANES] = [0.0, 1.0, 2.0, 3.0];
    let (blocks, tail) = p.as_chunks::<LANES>();
    let mut last = [0.0; LANES];
    last[..tail.len()].copy_from_slice(tail);
    for block in blocks.iter().chain([&last]) {
        for lane in 0..LANES {
            let (k, size) = (power[lane], block[lane].abs());
            range[lane] += size;
            curvature[lane] += k * (k - 1.0) * size;
            power[lane] += LANES as f64;
        }
    }
    let constant = p.first().map_or(0.0, |a| a.abs());
    (range.iter().sum::<f64>() - constant, curvature.iter().sum())
}

/// Value p and slope p′ by Horner's rule over the even and the odd powers, `p = E(x²) + x O(x²)`.
pub fn value_and_slope(p: &[f64], x: f64) -> (f64, f64) {
    let square = x * x;
    let pairs = p.chunks_exact(2);
    let (mut even, mut odd) = (pairs.remainder().first().copied().unwrap_or(0.0), 0.0);
    let (mut even_slope, mut odd_slope) = (0.0, 0.0);
    for pair in pairs.rev() {
        even_slope = even_slope * square + even;
        odd_slope = odd_slope * square + odd;
        even = even * square + pair[0];
        odd = odd * square + pair[1];
    }
    let slope = odd + 2.0 * x * (even_slope + x * odd_slope);
    (even + x * odd, slope)
}

/// Root between `from` and `limit` of a polynomial that falls monotonically there.
fn newton(p: &[f64], from: f64, limit: f64) -> Option<f64> {
    let mut x = from;
    for _ in 0..MAX_NEWTON {
        let (value, slope) = value_and_slope(p, x);
        let next = (x - value / slope).clamp(from, limit);
        if (next - x).abs() <= f64::EPSILON {
            return Some(next);
        }
        x = next;
    }
    Some(x)
}

/// Maximum of Newton iterations; each at least halves the error and convergence is quadratic, so that six reach 2⁻⁵³.
const MAX_NEWTON: usize = 12;
