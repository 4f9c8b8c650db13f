//! Nonlinear force–deflection characteristic, odd in δ: power law or monotone cubic table.
//!
//! Cubics: Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300, eq. (5) with their weights; linear extrapolation beyond the last point.

use crate::numeric::hermite_cubic::HermiteCubic;
pub use crate::scene::laws::Characteristic;

/// Relative change of a secant below which the iteration has converged: a few roundings of a dense solve.
pub const SECANT_TOLERANCE: f64 = 1e-12;

/// Maximum number of secant iterations.
pub const MAX_SECANT_ITERATIONS: usize = 500;

impl Characteristic {
    /// Force F at the deflection δ (m or rad), N or N·m.
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

    /// Tangent stiffness dF/dδ at δ, N/m or N·m/rad.
    pub fn tangent(&self, delta: f64) -> f64 {
        let size = delta.abs();
        match self {
            Characteristic::Power {
                factor, exponent, ..
            } => factor * exponent * size.powf(exponent - 1.0),
            Characteristic::Table(points) => segment_at(points, size).slope(size),
        }
    }

    /// Potential energy `∫ F dδ` from δ = 0, J.
    pub fn potential_energy(&self, delta: f64) -> f64 {
        let size = delta.abs();
        match self {
            Characteristic::Power {
                factor, exponent, ..
            } => factor * size.powf(exponent + 1.0) / (exponent + 1.0),
            Characteristic::Table(points) => {
                let segment_energies = (1..points.len())
                    .take_while(|&i| points[i].0 <= size)
                    .map(|i| segment_after(points, i - 1).area(points[i].0));
                segment_energies.sum::<f64>() + segment_at(points, size).area(size)
            }
        }
    }

    /// Deflection δ at the force F, m or rad; the smallest one if the curve is flat there.
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

    /// Secant stiffness F/δ at the force F; the tangent at δ = 0 if F = 0.
    pub fn secant(&self, force: f64) -> f64 {
        match self.deflection(force) {
            0.0 => self.tangent(0.0),
            delta => force / delta,
        }
    }

    /// Replaces `secant` by the secant stiffness at the force F and returns its relative change; a characteristic without stiffness there
    /// leaves it unchanged and returns 0.
    pub fn update_secant(&self, secant: &mut f64, force: f64) -> f64 {
        let next = self.secant(force);
        if next <= 0.0 {
            return 0.0;
        }
        let change = (next / *secant - 1.0).abs();
        *secant = next;
        change
    }

    /// Secant stiffness at the rated deflection, the last one of a table.
    pub fn rated_secant(&self) -> f64 {
        let delta = match self {
            Characteristic::Power { rated, .. } => *rated,
            Characteristic::Table(points) => points[points.len() - 1].0,
        };
        self.force(delta) / delta
    }

    /// Multiplies all forces by a factor.
    pub fn scale(&mut self, gain: f64) {
        match self {
            Characteristic::Power { factor, .. } => *factor *= gain,
            Characteristic::Table(points) => points.iter_mut().for_each(|p| p.1 *= gain),
        }
    }
}

/// Segment after the point `at`; a straight line after the last.
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

/// Segment that contains the deflection x.
fn segment_at(points: &[(f64, f64)], x: f64) -> HermiteCubic {
    segment_after(points, points.partition_point(|p| p.0 <= x).max(1) - 1)
}

/// Slope at the point `at`: the weighted harmonic mean of both chords, which keeps the curve monotone.
fn slope_at(points: &[(f64, f64)], at: usize) -> f64 {
    let chord = |i: usize| (points[i + 1].1 - points[i].1) / (points[i + 1].0 - points[i].0);
    let last = points.len() - 1;
    if at == 0 || at == last {
        // The curve is odd at δ = 0 and linear beyond the last point.
        return chord(at.min(last - 1));
    }
    let (chord_1, chord_2) = (chord(at - 1), chord(at));
    if chord_1 == 0.0 || chord_2 == 0.0 {
        return 0.0;
    }
    let (h, k) = (
        points[at].0 - points[at - 1].0,
        points[at + 1].0 - points[at].0,
    );
    let (w1, w2) = (h + 2.0 * k, 2.0 * h + k);
    (w1 + w2) / (w1 / chord_1 + w2 / chord_2)
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

    /// The curve passes through the points and increases; tangent and energy are its derivative and integral, deflection its inverse.
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
