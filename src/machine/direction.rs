//! Sparse direction vector `w = scale · Σ coefficient · e_dof`.
//!
//! The scale (half a module, a base radius) is kept apart so that the coefficients of torsional branches stay whole numbers: what can turn freely is then decided in exact fractions.

use crate::numeric::Complex;

/// A sparse direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// Common factor; 1 for shafts, m or m/rad for meshes.
    pub scale: f64,
    /// Degree of freedom and coefficient, sorted by degree of freedom, none twice, none zero.
    pub terms: Vec<(usize, f64)>,
}

impl Direction {
    /// Sums terms of one degree of freedom and leaves out zeros.
    pub fn new(scale: f64, terms: impl IntoIterator<Item = (usize, f64)>) -> Direction {
        let mut all: Vec<(usize, f64)> = terms.into_iter().collect();
        all.sort_by_key(|&(dof, _)| dof);
        let mut terms: Vec<(usize, f64)> = Vec::with_capacity(all.len());
        for (dof, coefficient) in all {
            match terms.last_mut() {
                Some((last, sum)) if *last == dof => *sum += coefficient,
                _ => terms.push((dof, coefficient)),
            }
        }
        terms.retain(|&(_, coefficient)| coefficient != 0.0);
        Direction { scale, terms }
    }

    /// The unit direction of one degree of freedom.
    pub fn unit(dof: usize) -> Direction {
        Direction {
            scale: 1.0,
            terms: vec![(dof, 1.0)],
        }
    }

    /// `wᵀ q`.
    pub fn dot(&self, q: &[f64]) -> f64 {
        self.scale * self.terms.iter().map(|&(dof, a)| a * q[dof]).sum::<f64>()
    }

    /// `wᵀ q` of a complex q.
    pub fn dot_complex(&self, q: &[Complex]) -> Complex {
        let sum = self.terms.iter().map(|&(dof, a)| q[dof] * a);
        sum.fold(Complex::ZERO, |s, x| s + x) * self.scale
    }

    /// Degree of freedom and `scale · coefficient`.
    pub fn entries(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.terms.iter().map(|&(dof, a)| (dof, self.scale * a))
    }
}
