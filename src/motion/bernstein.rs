//! First zero of a degree-8 polynomial in Bernstein form; no double crossing is missed.
//!
//! The function is taken as its polynomial of degree 8 through Chebyshev's points; where the coefficients in Bernstein's
//! basis are all positive, so is the polynomial, else the interval is halved by de Casteljau's rule (Farouki and Rajan 1987).

use std::f64::consts::PI;

use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::lu::Lu;

/// Degree of the polynomial.
const DEGREE: usize = 8;

/// Values at its points, or its coefficients.
pub type Coefficients = [f64; DEGREE + 1];

/// Conversion of values at the points to Bernstein coefficients.
pub struct BernsteinBasis {
    lu: Lu,
    /// The points, shares of a step from 0 to 1.
    pub points: Coefficients,
}

/// Behaviour of a switching function in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ZeroCrossing {
    /// It stays above zero.
    NoCrossing,
    /// It comes to zero within rounding and stays above.
    Grazing,
    /// It crosses first at this share of the step, falling by so much per step.
    Crossed(f64, f64),
}

impl BernsteinBasis {
    /// The basis.
    ///
    /// # Errors
    /// None in fact: the points are distinct.
    pub fn new() -> Result<BernsteinBasis, Error> {
        let points: Coefficients =
            std::array::from_fn(|j| 0.5 - 0.5 * (PI * j as f64 / DEGREE as f64).cos());
        let mut choose = [1.0; DEGREE + 1];
        for j in 1..=DEGREE {
            choose[j] = choose[j - 1] * (DEGREE + 1 - j) as f64 / j as f64;
        }
        let value = |i: usize, j: usize| {
            let x: f64 = points[i];
            choose[j] * x.powi(j as i32) * (1.0 - x).powi((DEGREE - j) as i32)
        };
        let lu = Lu::new(&Matrix::from_fn(DEGREE + 1, DEGREE + 1, value))?;
        Ok(BernsteinBasis { lu, points })
    }

    /// Coefficients from values at the points.
    pub fn coefficients(&self, values: &Coefficients) -> Coefficients {
        let mut b = *values;
        self.lu.solve(&mut b);
        (b[0], b[DEGREE]) = (values[0], values[DEGREE]);
        b
    }
}

/// Zero crossing of a polynomial that starts above zero, or at zero within `noise`.
///
/// One that starts below zero has crossed at the start, unless `entered` says that it has just been crossed from there.
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
    let mut grazed = false;
    let mut stack = vec![(0.0, 1.0, b)];
    while let Some((from, width, b)) = stack.pop() {
        let least = b.iter().copied().fold(f64::INFINITY, f64::min);
        if least >= -noise {
            grazed |= least < noise && from > 0.0 && from + width < 1.0;
            continue;
        }
        let changes = b
            .windows(2)
            .filter(|p| (p[0] > 0.0) != (p[1] > 0.0))
            .count();
        if changes == 1 && b[0] > 0.0 && b[DEGREE] < 0.0 {
            let at = root(&b);
            return ZeroCrossing::Crossed(
                from + width * at,
                initial_slope(&subdivide(&b, at).1) / (1.0 - at) / width,
            );
        }
        if width < 1e-12 {
            if b[DEGREE] < -noise {
                return ZeroCrossing::Crossed(from, initial_slope(&b) / width);
            }
            grazed = true;
            continue;
        }
        let (left, right) = subdivide(&b, 0.5);
        stack.push((from + 0.5 * width, 0.5 * width, right));
        stack.push((from, 0.5 * width, left));
    }
    match grazed {
        true => ZeroCrossing::Grazing,
        false => ZeroCrossing::NoCrossing,
    }
}

/// Slope of descent at the start, per unit.
fn initial_slope(b: &Coefficients) -> f64 {
    DEGREE as f64 * (b[0] - b[1])
}

/// The coefficients left and right of a share.
fn subdivide(b: &Coefficients, at: f64) -> (Coefficients, Coefficients) {
    let (mut left, mut right) = (*b, *b);
    for round in 1..=DEGREE {
        for j in 0..=DEGREE - round {
            right[j] = (1.0 - at) * right[j] + at * right[j + 1];
        }
        left[round] = right[0];
    }
    (left, right)
}

/// The one root between a positive start and a negative end.
fn root(b: &Coefficients) -> f64 {
    let value = |at: f64| subdivide(b, at).1[0];
    let (mut low, mut high) = (0.0, 1.0);
    let (mut above, mut below) = (b[0], b[DEGREE]);
    for _ in 0..100 {
        // Illinois: the end that stays counts half.
        let mut at = low + (high - low) * above / (above - below);
        if !(at > low && at < high) {
            at = 0.5 * (low + high);
        }
        let here = value(at);
        if here > 0.0 {
            (low, above) = (at, here);
            below *= 0.5;
        } else {
            (high, below) = (at, here);
            above *= 0.5;
        }
        if here == 0.0 || high - low <= 4.0 * f64::EPSILON {
            break;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value_at(f: impl Fn(f64) -> f64) -> ZeroCrossing {
        let basis = BernsteinBasis::new().unwrap();
        zero_crossing(&basis.coefficients(&basis.points.map(f)), 1e-13, false)
    }

    #[test]
    fn roots_are_found_to_rounding() {
        let ZeroCrossing::Crossed(root, fall) = value_at(|x| 0.3 - x * x) else {
            panic!("no root");
        };
        assert!((root - 0.3f64.sqrt()).abs() < 1e-13, "{root}");
        assert!((fall - 2.0 * 0.3f64.sqrt()).abs() < 1e-10, "{fall}");
    }

    /// Both ends positive, twice below zero between, by 1e-9 of the range.
    #[test]
    fn double_crossings_are_seen() {
        let ZeroCrossing::Crossed(root, _) = value_at(|x| (x - 0.6) * (x - 0.6) - 1e-9) else {
            panic!("no root");
        };
        assert!((root - (0.6 - 1e-9f64.sqrt())).abs() < 1e-8, "{root}");
        assert_eq!(
            value_at(|x| (x - 0.6) * (x - 0.6) + 1e-9),
            ZeroCrossing::NoCrossing
        );
        assert_eq!(value_at(|x| (x - 0.6) * (x - 0.6)), ZeroCrossing::Grazing);
    }

    #[test]
    fn a_start_on_the_border_counts_by_its_direction() {
        assert_eq!(value_at(|x| x), ZeroCrossing::NoCrossing);
        assert!(matches!(value_at(|x| -x), ZeroCrossing::Crossed(0.0, _)));
        assert!(
            matches!(value_at(|x| x * (0.5 - x)), ZeroCrossing::Crossed(root, _) if (root - 0.5).abs() < 1e-12)
        );
    }
}
