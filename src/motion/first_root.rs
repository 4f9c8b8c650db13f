//! First root of a polynomial by safe steps `h < (d + √(d² + 2 M p))/M`.
//!
//! With `p ≥ 0`, slope d and `|p″| ≤ M` ahead, the worst parabola `p + d h − M h²/2` stays above zero for
//! `h < (d + √(d² + 2 M p))/M`: nothing is lost by going that far, and the steps close in on a root quadratically from one
//! side. Once `d < 0` and `M p < d²/4` there is exactly one root within `2p/|d|`, since there `p′ < d/2`: Newton's method
//! takes it.

use super::problem::IntegrationStats;

/// A polynomial in x, `|x| ≤ 1`, and what is known of its value.
#[derive(Debug, Clone, Copy)]
pub struct BoundedPolynomial<'a> {
    /// By rising powers.
    pub coefficients: &'a [f64],
    /// Values below this are rounding.
    pub noise: f64,
    /// It is exactly zero at the start and rises: it was just crossed.
    pub starts_at_root: bool,
}

/// The first root in a range; at its start where the value there is below zero, or at it and falling.
///
/// A switching surface touched within its noise and not crossed is passed by a step that cannot lose more than that noise, and
/// counted as grazed.
pub fn first_root(
    surface: BoundedPolynomial,
    [from, to]: [f64; 2],
    stats: &mut IntegrationStats,
) -> Option<f64> {
    let p = surface.coefficients;
    let (swing, curvature) = derivative_bounds(p);
    if !surface.starts_at_root && p.first().is_some_and(|&middle| middle > swing) {
        return None;
    }
    let floor = (2.0 * surface.noise / curvature).sqrt();
    let (mut x, mut fresh) = (from, surface.starts_at_root);
    loop {
        stats.evaluations += 1;
        let (value, slope) = value_and_slope(p, x);
        let on_it = value <= surface.noise && (fresh || (value >= -surface.noise && slope > 0.0));
        // Falling so fast that it would lose more than its noise.
        let leaves = slope < 0.0 && slope * slope > 4.0 * curvature * surface.noise;
        let step = if on_it && !leaves {
            stats.grazings += u64::from(2.0 * slope < curvature * floor);
            2.0 * slope / curvature
        } else if value <= surface.noise {
            return Some(x);
        } else if slope < 0.0 && 4.0 * curvature * value < slope * slope {
            return newton(p, x, x - 2.0 * value / slope).filter(|&root| root <= to);
        } else {
            let reach = (slope * slope + 2.0 * curvature * value).sqrt();
            match slope > 0.0 {
                true => (slope + reach) / curvature,
                false => 2.0 * value / (reach - slope),
            }
        };
        x += step.max(floor);
        if !(x < to) {
            return None;
        }
        fresh = false;
    }
}

/// Bounds over `|x| ≤ 1` of `|p(x) − p(0)|` and of `|p″|`.
fn derivative_bounds(p: &[f64]) -> (f64, f64) {
    const LANES: usize = 4;
    let (mut swing, mut curvature) = ([0.0; LANES], [0.0; LANES]);
    let mut power: [f64; LANES] = [0.0, 1.0, 2.0, 3.0];
    let (fours, rest) = p.as_chunks::<LANES>();
    let mut last = [0.0; LANES];
    last[..rest.len()].copy_from_slice(rest);
    for four in fours.iter().chain([&last]) {
        for lane in 0..LANES {
            let (k, size) = (power[lane], four[lane].abs());
            swing[lane] += size;
            curvature[lane] += k * (k - 1.0) * size;
            power[lane] += LANES as f64;
        }
    }
    let constant = p.first().map_or(0.0, |a| a.abs());
    (swing.iter().sum::<f64>() - constant, curvature.iter().sum())
}

/// p and p′, by Horner's rule over the even and the odd powers: `p = E(x²) + x O(x²)`.
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

/// The only root between `from` and `limit`, where p falls throughout.
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

/// Newton's method halves its error at least and squares it soon; 2⁻⁵³ is reached in six steps from anywhere allowed.
const MAX_NEWTON: usize = 12;
