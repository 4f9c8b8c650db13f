//! First zero of a polynomial of degree 8 in Bernstein form; no double crossing is missed.
//!
//! The polynomial interpolates a function at nine Chebyshev points of [0, 1]. If all Bernstein coefficients are positive, the polynomial is
//! positive; otherwise the interval is bisected by de Casteljau's algorithm (Farouki and Rajan 1987).

use std::f64::consts::PI;

use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::lu::Lu;

/// Degree of the polynomial.
const DEGREE: usize = 8;

/// Values at the interpolation points, or Bernstein coefficients.
pub type Coefficients = [f64; DEGREE + 1];

/// Conversion of values at the interpolation points to Bernstein coefficients.
pub struct BernsteinBasis {
    lu: Lu,
    /// Interpolation points, ascending from 0 to 1 as fractions of a step.
    pub points: Coefficients,
}

/// Sign behaviour of a switching function within a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ZeroCrossing {
    /// Positive throughout.
    NoCrossing,
    /// Touches zero within rounding without a crossing.
    Grazing,
    /// First crossing: fraction of the step in [0, 1] and descent rate per step there.
    Crossed(f64, f64),
}

impl BernsteinBasis {
    /// Basis with the LU factorisation of its collocation matrix.
    ///
    /// # Errors
    /// Those of the factorisation; it does not fail, as the points are distinct.
    pub fn new() -> Result<BernsteinBasis, Error> {
        let points: Coefficients =
            std::array::from_fn(|j| 0.5 - 0.5 * (PI * j as f64 / DEGREE as f64).cos());
        let mut binomials = [1.0; DEGREE + 1];
        for j in 1..=DEGREE {
            binomials[j] = binomials[j - 1] * (DEGREE + 1 - j) as f64 / j as f64;
        }
        let value = |i: usize, j: usize| {
            let x: f64 = points[i];
            binomials[j] * x.powi(j as i32) * (1.0 - x).powi((DEGREE - j) as i32)
        };
        let lu = Lu::new(&Matrix::from_fn(DEGREE + 1, DEGREE + 1, value))?;
        Ok(BernsteinBasis { lu, points })
    }

    /// Bernstein coefficients from values at the interpolation points.
    pub fn coefficients(&self, values: &Coefficients) -> Coefficients {
        let mut b = *values;
        self.lu.solve(&mut b);
        (b[0], b[DEGREE]) = (values[0], values[DEGREE]);
        b
    }
}

/// First zero crossing of a polynomial that starts above zero, or at zero within `noise`.
///
/// A polynomial that starts below zero crosses at the start, unless it rises and `entered` states that the surface was just crossed.
pub fn zero_crossing(b: &Coefficients, noise: f64, entered: bool) -> ZeroCrossing {
    let mut b = *b;
    let rising = b[1] > b[0];
    if b[0] < -noise && !(entered && rising) {
        return ZeroCrossing::Crossed(0.0, initial_slope(&b));
    }
    if b[0] <= noise {
        if b[1] < -noise && !entered {
            return ZeroCrossing::Crossed(0.0, initial_slope(&b));
        }
        b[0] = b[0].max(0.0);
        b[1] = b[1].max(0.0);
    }
    let mut grazes = false;
    let mut stack = vec![(0.0, 1.0, b)];
    while let Some((from, width, b)) = stack.pop() {
        let minimum = b.iter().copied().fold(f64::INFINITY, f64::min);
        if minimum >= -noise {
            grazes |= minimum < noise && from > 0.0 && from + width < 1.0;
            continue;
        }
        let changes = b
            .windows(2)
            .filter(|p| (p[0] > 0.0) != (p[1] > 0.0))
            .count();
        if changes == 1 && b[0] > 0.0 && b[DEGREE] < 0.0 {
            let x = root(&b);
            return ZeroCrossing::Crossed(
                from + width * x,
                initial_slope(&subdivide(&b, x).1) / (1.0 - x) / width,
            );
        }
        if width < 1e-12 {
            if b[DEGREE] < -noise {
                return ZeroCrossing::Crossed(from, initial_slope(&b) / width);
            }
            grazes = true;
            continue;
        }
        let (left, right) = subdivide(&b, 0.5);
        stack.push((from + 0.5 * width, 0.5 * width, right));
        stack.push((from, 0.5 * width, left));
    }
    match grazes {
        true => ZeroCrossing::Grazing,
        false => ZeroCrossing::NoCrossing,
    }
}

/// Descent rate at the start of the interval, per unit interval.
fn initial_slope(b: &Coefficients) -> f64 {
    DEGREE as f64 * (b[0] - b[1])
}

/// Coefficients of the parts left and right of `x`, by de Casteljau.
fn subdivide(b: &Coefficients, x: f64) -> (Coefficients, Coefficients) {
    let (mut left, mut right) = (*b, *b);
    for level in 1..=DEGREE {
        for j in 0..=DEGREE - level {
            right[j] = (1.0 - x) * right[j] + x * right[j + 1];
        }
        left[level] = right[0];
    }
    (left, right)
}

/// Single root between a positive start and a negative end.
fn root(b: &Coefficients) -> f64 {
    let value = |x: f64| subdivide(b, x).1[0];
    let (mut low, mut high) = (0.0, 1.0);
    let (mut above, mut below) = (b[0], b[DEGREE]);
    for _ in 0..100 {
        // Illinois method: the value at the retained end is halved.
        let mut x = low + (high - low) * above / (above - below);
        if !(x > low && x < high) {
            x = 0.5 * (low + high);
        }
        let y = value(x);
        if y > 0.0 {
            (low, above) = (x, y);
            below *= 0.5;
        } else {
            (high, below) = (x, y);
            above *= 0.5;
        }
        if y == 0.0 || high - low <= 4.0 * f64::EPSILON {
            break;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crossing(f: impl Fn(f64) -> f64) -> ZeroCrossing {
        let basis = BernsteinBasis::new().unwrap();
        zero_crossing(&basis.coefficients(&basis.points.map(f)), 1e-13, false)
    }

    #[test]
    fn roots_are_found_to_rounding() {
        let ZeroCrossing::Crossed(root, fall) = crossing(|x| 0.3 - x * x) else {
            panic!("no root");
        };
        assert!((root - 0.3f64.sqrt()).abs() < 1e-13, "{root}");
        assert!((fall - 2.0 * 0.3f64.sqrt()).abs() < 1e-10, "{fall}");
    }

    /// Positive ends with two crossings between them, to a depth of 1e-9.
    #[test]
    fn double_crossings_are_seen() {
        let ZeroCrossing::Crossed(root, _) = crossing(|x| (x - 0.6) * (x - 0.6) - 1e-9) else {
            panic!("no root");
        };
        assert!((root - (0.6 - 1e-9f64.sqrt())).abs() < 1e-8, "{root}");
        assert_eq!(
            crossing(|x| (x - 0.6) * (x - 0.6) + 1e-9),
            ZeroCrossing::NoCrossing
        );
        assert_eq!(crossing(|x| (x - 0.6) * (x - 0.6)), ZeroCrossing::Grazing);
    }

    #[test]
    fn a_start_on_the_border_counts_by_its_direction() {
        assert_eq!(crossing(|x| x), ZeroCrossing::NoCrossing);
        assert!(matches!(crossing(|x| -x), ZeroCrossing::Crossed(0.0, _)));
        assert!(
            matches!(crossing(|x| x * (0.5 - x)), ZeroCrossing::Crossed(root, _) if (root - 0.5).abs() < 1e-12)
        );
    }
}
