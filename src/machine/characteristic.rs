//! Nonlinear force–deflection characteristic, odd in δ: power law or monotone cubic table.
//!
//! Cubics: Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300, eq. (5) with their weights; beyond the last point a straight line goes on.

use crate::numeric::hermite_cubic::HermiteCubic;
pub use crate::scene::laws::Characteristic;

/// Secants that move less than this, relative, have settled: a few roundings of a dense solve.
pub const SECANT_TOLERANCE: f64 = 1e-12;

/// Rounds after which secants that still move never settle.
pub const MAX_SECANT_ITERATIONS: usize = 500;

impl Characteristic {
    /// F at δ, N or N·m.
    pub fn force(&self, delta: f64) -> f64 {
        let size = delta.abs();
        let force = match self {
            Characteristic::Power {
                factor, exponent, ..
            } => factor * size.powf(*exponent),
            Characteristic::Table(points) => segment_at(points, size).value(size),
        };
        force.copysign(delta)
    }

    /// dF/dδ at δ, N/m or N·m/rad.
    pub fn tangent(&self, delta: f64) -> f64 {
        let size = delta.abs();
        match self {
            Characteristic::Power {
                factor, exponent, ..
            } => factor * exponent * size.powf(exponent - 1.0),
            Characteristic::Table(points) => segment_at(points, size).slope(size),
        }
    }

    /// ∫F dδ from rest, J.
    pub fn potential_energy(&self, delta: f64) -> f64 {
        let size = delta.abs();
        match self {
            Characteristic::Power {
                factor, exponent, ..
            } => factor * size.powf(exponent + 1.0) / (exponent + 1.0),
            Characteristic::Table(points) => {
                let whole = (1..points.len())
                    .take_while(|&i| points[i].0 <= size)
                    .map(|i| segment_after(points, i - 1).area(points[i].0));
                whole.sum::<f64>() + segment_at(points, size).area(size)
            }
        }
    }

    /// δ that F takes, m or rad; the least one where the curve is flat.
    pub fn deflection(&self, force: f64) -> f64 {
        let size = force.abs();
        let delta = match self {
            Characteristic::Power {
                factor, exponent, ..
            } => (size / factor).powf(1.0 / exponent),
            Characteristic::Table(points) => {
                let at = points.partition_point(|p| p.1 < size);
                match at {
                    0 => 0.0,
                    at if at == points.len() => {
                        let last = points[at - 1];
                        last.0 + (size - last.1) / slope_at(points, at - 1)
                    }
                    at => segment_after(points, at - 1).solve(size),
                }
            }
        };
        delta.copysign(force)
    }

    /// F/δ where F acts; the tangent at rest where none does.
    pub fn secant(&self, force: f64) -> f64 {
        match self.deflection(force) {
            0.0 => self.tangent(0.0),
            delta => force / delta,
        }
    }

    /// Puts the secant where F acts in the place of the one before, and says by how much it moved, relative. What carries
    /// nothing rests wherever its secant puts it.
    pub fn update_secant(&self, secant: &mut f64, force: f64) -> f64 {
        let next = self.secant(force);
        if next <= 0.0 {
            return 0.0;
        }
        let moved = (next / *secant - 1.0).abs();
        *secant = next;
        moved
    }

    /// F/δ at the deflection it is rated at, the last of a table.
    pub fn rated_secant(&self) -> f64 {
        let delta = match self {
            Characteristic::Power { rated, .. } => *rated,
            Characteristic::Table(points) => points[points.len() - 1].0,
        };
        self.force(delta) / delta
    }

    /// The same with all forces times a factor.
    pub fn scale(&mut self, times: f64) {
        match self {
            Characteristic::Power { factor, .. } => *factor *= times,
            Characteristic::Table(points) => points.iter_mut().for_each(|p| p.1 *= times),
        }
    }
}

/// The piece after a point; a straight line after the last.
fn segment_after(points: &[(f64, f64)], at: usize) -> HermiteCubic {
    let slope = slope_at(points, at);
    if at + 1 == points.len() {
        let (x, y) = points[at];
        let width = x - points[at - 1].0;
        return HermiteCubic {
            ends: [(x, y), (x + width, y + width * slope)],
            slopes: [slope; 2],
        };
    }
    HermiteCubic {
        ends: [points[at], points[at + 1]],
        slopes: [slope, slope_at(points, at + 1)],
    }
}

/// The piece over a deflection.
fn segment_at(points: &[(f64, f64)], x: f64) -> HermiteCubic {
    segment_after(points, points.partition_point(|p| p.0 <= x).max(1) - 1)
}

/// The slope at a point: the weighted harmonic mean of both chords, which keeps the curve from turning back.
fn slope_at(points: &[(f64, f64)], at: usize) -> f64 {
    let chord = |i: usize| (points[i + 1].1 - points[i].1) / (points[i + 1].0 - points[i].0);
    let last = points.len() - 1;
    if at == 0 || at == last {
        // At rest the curve goes on backward as it came; behind the last point straight on.
        return chord(at.min(last - 1));
    }
    let (before, after) = (chord(at - 1), chord(at));
    if before == 0.0 || after == 0.0 {
        return 0.0;
    }
    let (h, k) = (
        points[at].0 - points[at - 1].0,
        points[at + 1].0 - points[at].0,
    );
    let (one, two) = (h + 2.0 * k, 2.0 * h + k);
    (one + two) / (one / before + two / after)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Characteristic {
        Characteristic::Table(vec![
            (0.0, 0.0),
            (0.01, 0.0),
            (0.02, 100.0),
            (0.05, 600.0),
            (0.06, 610.0),
        ])
    }

    /// Points are met, the curve rises, tangent and energy are derivative and integral, and the inverse comes back.
    #[test]
    fn law_of_a_table() {
        let law = table();
        assert_eq!(law.force(0.02), 100.0);
        assert_eq!(law.force(-0.05), -600.0);
        assert_eq!(law.force(0.005), 0.0);
        let mut last = 0.0;
        let mut area = 0.0;
        let h = 1e-5;
        for i in 0..8000 {
            let x = h * (i as f64 + 0.5);
            assert!(law.force(x) >= last, "{x}");
            last = law.force(x);
            area += h * last;
            let slope = (law.force(x + 1e-8) - law.force(x - 1e-8)) / 2e-8;
            assert!((slope - law.tangent(x)).abs() < 1e-2, "{x}");
            assert!((law.potential_energy(x + h / 2.0) - area).abs() < 1e-6 * (1.0 + area));
            if last > 1e-6 {
                assert!((law.deflection(last) - x).abs() < 1e-12, "{x}");
                assert_eq!(law.deflection(-last), -law.deflection(last));
            }
        }
    }

    /// `K δⁿ` against its closed forms.
    #[test]
    fn exact_power() {
        let law = Characteristic::Power {
            factor: 2e9,
            exponent: 1.5,
            rated: 1e-4,
        };
        assert!((law.force(-1e-4) + 2000.0).abs() < 1e-11);
        assert!((law.tangent(1e-4) - 3e7).abs() < 1e-7);
        assert!((law.potential_energy(1e-4) - 2e9 * 1e-10 / 2.5).abs() < 1e-15);
        assert!((law.deflection(2000.0) - 1e-4).abs() < 1e-18);
        assert!((law.rated_secant() - 2e7).abs() < 1e-7);
        assert_eq!(law.secant(0.0), 0.0);
    }
}
