//! A sparse direction `w = scale · Σ coefficient · e_freedom` in the space of all freedoms.
//!
//! The scale (half a module, a base radius) is kept apart so that the coefficients of torsional branches stay whole numbers: what can turn freely is then decided in exact fractions.

use crate::numeric::Complex;

/// A sparse direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// Common factor; 1 for shafts, m or m/rad for meshes.
    pub scale: f64,
    /// Freedom and coefficient, sorted by freedom, none twice, none zero.
    pub terms: Vec<(usize, f64)>,
}

impl Direction {
    /// Sums terms of one freedom and leaves out zeros.
    pub fn new(scale: f64, terms: impl IntoIterator<Item = (usize, f64)>) -> Direction {
        let mut all: Vec<(usize, f64)> = terms.into_iter().collect();
        all.sort_by_key(|&(freedom, _)| freedom);
        let mut terms: Vec<(usize, f64)> = Vec::with_capacity(all.len());
        for (freedom, coefficient) in all {
            match terms.last_mut() {
                Some((last, sum)) if *last == freedom => *sum += coefficient,
                _ => terms.push((freedom, coefficient)),
            }
        }
        terms.retain(|&(_, coefficient)| coefficient != 0.0);
        Direction { scale, terms }
    }

    /// The unit direction of one freedom.
    pub fn of(freedom: usize) -> Direction {
        Direction {
            scale: 1.0,
            terms: vec![(freedom, 1.0)],
        }
    }

    /// `wᵀ q`.
    pub fn dot(&self, q: &[f64]) -> f64 {
        self.scale
            * self
                .terms
                .iter()
                .map(|&(freedom, a)| a * q[freedom])
                .sum::<f64>()
    }

    /// `wᵀ q` of a complex q.
    pub fn dot_complex(&self, q: &[Complex]) -> Complex {
        let sum = self.terms.iter().map(|&(freedom, a)| q[freedom] * a);
        sum.fold(Complex::ZERO, |s, x| s + x) * self.scale
    }

    /// Freedom and `scale · coefficient`.
    pub fn scaled(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.terms
            .iter()
            .map(|&(freedom, a)| (freedom, self.scale * a))
    }
}
