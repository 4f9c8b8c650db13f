//! Shift-invert operator `(K − σM)⁻¹` for Lanczos, from a forest or sparse factorisation.

use super::forest::Forest;
use super::forest_factor::ForestFactor;
use super::sparse::LdlFactor;

/// A pivot this small, relative to its spring, means that σ is an eigenvalue of the machine or of a part of it.
const MIN_RELATIVE_PIVOT: f64 = 1e-9;

/// By how much the shift is then moved, relative, each time twice as far.
const SHIFT_PERTURBATION: f64 = 1e-7;

/// Maximum number of shift retries.
const MAX_SHIFT_RETRIES: usize = 8;

/// Operations that Lanczos requires of a factorised `K − σM`.
pub trait ShiftInvert {
    /// σ.
    fn shift(&self) -> f64;

    /// Overwrites f by `(K − σM)⁻¹ f`.
    fn solve(&self, f: &mut [f64]);

    /// Solves as `solve` does, and returns `yᵀKy` of the solution from the deformation of the springs; none, and f as it was, where they
    /// are not at hand.
    fn solve_with_energy(&self, _f: &mut [f64]) -> Option<f64> {
        None
    }
}

/// An elimination with the shift it was made for; 0 where it was made for K.
pub struct ShiftedForest<'f>(pub ForestFactor<'f>, pub f64);

impl ShiftInvert for ShiftedForest<'_> {
    fn shift(&self) -> f64 {
        self.1
    }

    fn solve(&self, f: &mut [f64]) {
        self.0.solve(f);
    }

    fn solve_with_energy(&self, f: &mut [f64]) -> Option<f64> {
        (self.1 == 0.0).then(|| self.0.solve_with_energy(f))
    }
}

impl<'f> ShiftedForest<'f> {
    /// K of a forest.
    pub fn unshifted(forest: &'f Forest) -> ShiftedForest<'f> {
        ShiftedForest(forest.factorise(), 0.0)
    }

    /// `K − σM` of a forest, with σ moved by some 1e-7 of itself where it falls on an eigenvalue.
    pub fn shifted(forest: &'f Forest, mass: &[f64], sigma: f64) -> ShiftedForest<'f> {
        let mut shifted = ShiftedForest(forest.factorise_shifted(mass, sigma), sigma);
        for attempt in 0..MAX_SHIFT_RETRIES {
            if shifted.0.smallest_pivot() > MIN_RELATIVE_PIVOT {
                break;
            }
            let moved = sigma * (1.0 + SHIFT_PERTURBATION * (1 << attempt) as f64);
            shifted = ShiftedForest(forest.factorise_shifted(mass, moved), moved);
        }
        shifted
    }
}

/// A sparse factorisation with `yᵀKy` measured from the springs, `Σ k (wᵀy)²`: the values then have half the lost digits back.
pub struct EnergyCorrected<'a> {
    /// The factorised `K − σM`.
    pub factor: &'a LdlFactor,
    /// `yᵀKy` as a sum over springs.
    pub energy: &'a dyn Fn(&[f64]) -> f64,
}

impl ShiftInvert for EnergyCorrected<'_> {
    fn shift(&self) -> f64 {
        self.factor.shift()
    }

    fn solve(&self, f: &mut [f64]) {
        self.factor.solve_in_place(f);
    }

    fn solve_with_energy(&self, f: &mut [f64]) -> Option<f64> {
        self.factor.solve_in_place(f);
        Some((self.energy)(f))
    }
}

impl ShiftInvert for LdlFactor {
    fn shift(&self) -> f64 {
        LdlFactor::shift(self)
    }

    fn solve(&self, f: &mut [f64]) {
        self.solve_in_place(f);
    }
}
