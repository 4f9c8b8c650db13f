//! `(K − σM)⁻¹` from whatever factorised it, for iterations that need no more than that.

use super::elimination::Elimination;
use super::forest::Forest;
use super::sparse::Factor;

/// A pivot this small, relative to its spring, means that σ is an eigenvalue of the machine or of a part of it.
const TOO_NEAR: f64 = 1e-9;

/// By how much the shift is then moved, relative, each time twice as far.
const MOVE: f64 = 1e-7;

/// How often.
const MOST_MOVES: usize = 8;

/// What Lanczos needs of a factorised `K − σM`.
pub trait Inverse {
    /// σ.
    fn shift(&self) -> f64;

    /// Overwrites f by `(K − σM)⁻¹ f`.
    fn solve(&self, f: &mut [f64]);

    /// The same, and `yᵀKy` of the answer from the deformation of the springs; none, and f as it was, where they are not at hand.
    fn solve_with_energy(&self, _f: &mut [f64]) -> Option<f64> {
        None
    }
}

/// An elimination with the shift it was made for; 0 where it was made for K.
pub struct Shifted<'f>(pub Elimination<'f>, pub f64);

impl Inverse for Shifted<'_> {
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

impl<'f> Shifted<'f> {
    /// K of a forest.
    pub fn at_zero(forest: &'f Forest) -> Shifted<'f> {
        Shifted(forest.eliminate(), 0.0)
    }

    /// `K − σM` of a forest, with σ moved by some 1e-7 of itself where it falls on an eigenvalue.
    pub fn near(forest: &'f Forest, mass: &[f64], sigma: f64) -> Shifted<'f> {
        let mut shifted = Shifted(forest.eliminate_shifted(mass, sigma), sigma);
        for attempt in 0..MOST_MOVES {
            if shifted.0.smallest_pivot() > TOO_NEAR {
                break;
            }
            let moved = sigma * (1.0 + MOVE * (1 << attempt) as f64);
            shifted = Shifted(forest.eliminate_shifted(mass, moved), moved);
        }
        shifted
    }
}

/// A sparse factorisation with `yᵀKy` measured from the springs, `Σ k (wᵀy)²`: the values then have half the lost digits back.
pub struct Measured<'a> {
    /// The factorised `K − σM`.
    pub factor: &'a Factor,
    /// `yᵀKy` as a sum over springs.
    pub energy: &'a dyn Fn(&[f64]) -> f64,
}

impl Inverse for Measured<'_> {
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

impl Inverse for Factor {
    fn shift(&self) -> f64 {
        Factor::shift(self)
    }

    fn solve(&self, f: &mut [f64]) {
        self.solve_in_place(f);
    }
}
