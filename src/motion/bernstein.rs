//! The first crossing of zero of a function inside a step, by bounds that no double crossing slips through.
//!
//! The function is taken as its polynomial of degree 8 through Chebyshev's points; where the coefficients in Bernstein's
//! basis are all positive, so is the polynomial, else the stretch is halved by de Casteljau's rule (Farouki and Rajan 1987).

use std::f64::consts::PI;

use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::lu::Lu;

/// Its degree.
const DEGREE: usize = 8;

/// Values at its points, or its coefficients.
pub type Nine = [f64; DEGREE + 1];

/// How values at the points become coefficients.
pub struct Basis {
    lu: Lu,
    /// The points, shares of a step from 0 to 1.
    pub points: Nine,
}

/// What a border does in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Course {
    /// It stays above zero.
    Clear,
    /// It comes to zero within rounding and stays above.
    Grazed,
    /// It crosses first at this share of the step, falling by so much per step.
    Crossed(f64, f64),
}

impl Basis {
    /// The basis.
    ///
    /// # Errors
    /// None in fact: the points are distinct.
    pub fn new() -> Result<Basis, Error> {
        let points: Nine =
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
        Ok(Basis { lu, points })
    }

    /// Coefficients from values at the points.
    pub fn coefficients(&self, values: &Nine) -> Nine {
        let mut b = *values;
        self.lu.solve(&mut b);
        (b[0], b[DEGREE]) = (values[0], values[DEGREE]);
        b
    }
}

/// The course of a polynomial that starts above zero, or at zero within `noise`.
///
/// One that starts below zero has crossed at the start, unless `entered` says that it has just been crossed from there.
pub fn course(b: &Nine, noise: f64, entered: bool) -> Course {
    let mut b = *b;
    let rising = b[1] > b[0];
    if b[0] < -noise && !(entered && rising) {
        return Course::Crossed(0.0, fall(&b));
    }
    if b[0] <= noise {
        if b[1] < -noise && !entered {
            return Course::Crossed(0.0, fall(&b));
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
            return Course::Crossed(
                from + width * at,
                fall(&split(&b, at).1) / (1.0 - at) / width,
            );
        }
        if width < 1e-12 {
            if b[DEGREE] < -noise {
                return Course::Crossed(from, fall(&b) / width);
            }
            grazed = true;
            continue;
        }
        let (left, right) = split(&b, 0.5);
        stack.push((from + 0.5 * width, 0.5 * width, right));
        stack.push((from, 0.5 * width, left));
    }
    match grazed {
        true => Course::Grazed,
        false => Course::Clear,
    }
}

/// How much it falls per unit at its start.
fn fall(b: &Nine) -> f64 {
    DEGREE as f64 * (b[0] - b[1])
}

/// The coefficients left and right of a share.
fn split(b: &Nine, at: f64) -> (Nine, Nine) {
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
fn root(b: &Nine) -> f64 {
    let value = |at: f64| split(b, at).1[0];
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

    fn at(f: impl Fn(f64) -> f64) -> Course {
        let basis = Basis::new().unwrap();
        course(&basis.coefficients(&basis.points.map(f)), 1e-13, false)
    }

    #[test]
    fn roots_are_found_to_rounding() {
        let Course::Crossed(root, fall) = at(|x| 0.3 - x * x) else {
            panic!("no root");
        };
        assert!((root - 0.3f64.sqrt()).abs() < 1e-13, "{root}");
        assert!((fall - 2.0 * 0.3f64.sqrt()).abs() < 1e-10, "{fall}");
    }

    /// Both ends positive, twice below zero between, by 1e-9 of the range.
    #[test]
    fn double_crossings_are_seen() {
        let Course::Crossed(root, _) = at(|x| (x - 0.6) * (x - 0.6) - 1e-9) else {
            panic!("no root");
        };
        assert!((root - (0.6 - 1e-9f64.sqrt())).abs() < 1e-8, "{root}");
        assert_eq!(at(|x| (x - 0.6) * (x - 0.6) + 1e-9), Course::Clear);
        assert_eq!(at(|x| (x - 0.6) * (x - 0.6)), Course::Grazed);
    }

    #[test]
    fn a_start_on_the_border_counts_by_its_direction() {
        assert_eq!(at(|x| x), Course::Clear);
        assert!(matches!(at(|x| -x), Course::Crossed(0.0, _)));
        assert!(
            matches!(at(|x| x * (0.5 - x)), Course::Crossed(root, _) if (root - 0.5).abs() < 1e-12)
        );
    }
}
