//! A border of a regime as a function of the parts of its machine.

use super::course::Lanes;
use super::hold::Reaction;
use crate::motion::contact::Affine;
use crate::motion::train::BranchStand;
use crate::numeric::Complex;

/// `p = constant + c σ + direct inputs`, above zero while the regime holds.
#[derive(Debug)]
pub struct Border {
    /// Whose it is.
    pub branch: usize,
    /// What stands beyond.
    pub to: BranchStand,
    /// What it was made from.
    pub kind: Kind,
    /// Its constant.
    pub constant: f64,
    /// c, over harmonics and parts.
    pub row: Vec<f64>,
    /// |c|, part by part.
    pub sizes: Vec<f64>,
    /// What every part counts in each lane.
    pub lanes: Vec<Lanes>,
    /// Inputs that enter it by themselves, with what their value and their rate count.
    pub direct: Vec<(usize, [f64; 2])>,
    /// Over q and q̇, where some of these are held.
    pub dense: Option<[Vec<f64>; 2]>,
}

/// What a border is made from.
#[derive(Debug)]
pub enum Kind {
    /// Deflection and rate of its branch.
    Deflection(Affine),
    /// What it would have to hold.
    Reaction(Reaction),
}

impl Border {
    /// The lanes of a row c over the parts, of the row that gives ṗ, and of the sizes |c|.
    pub fn lanes(turning: &[Complex], row: &[f64], rate: &[f64], sizes: &[f64]) -> Vec<Lanes> {
        let pairs = row.chunks_exact(2).zip(rate.chunks_exact(2));
        let turning = turning.iter().zip(pairs).zip(sizes);
        let mut lanes: Vec<Lanes> = turning
            .map(|((lambda, (c, r)), size)| {
                let bent = Complex::new(c[0], -c[1]) * lambda * lambda;
                let (fast, bound) = (lambda.norm(), size * lambda.norm_sqr());
                let [x, y] = [bent.re, -bent.im];
                Lanes([c[0], r[0], c[1], r[1], x, y, bound, bound * fast])
            })
            .collect();
        let first = 2 * lanes.len();
        let others = row[first..].iter().zip(&rate[first..]);
        let other = |(&c, &r): (&f64, &f64)| Lanes([c, r, 0.0, 0.0, c, 0.0, c.abs(), c.abs()]);
        lanes.extend(others.map(other));
        lanes
    }

    /// Whether it is the other side of `crossed`, a border of the same branch that was just crossed.
    pub fn is_back_of(&self, crossed: &Border) -> bool {
        if self.branch != crossed.branch {
            return false;
        }
        let back = |a: &Affine, b: &Affine| {
            a.constant == -b.constant && a.deflection == -b.deflection && a.rate == -b.rate
        };
        match (&self.kind, &crossed.kind, self.to) {
            (Kind::Deflection(own), Kind::Deflection(other), BranchStand::Contact(..)) => {
                back(own, other)
            }
            // A pair that begins to slide does so from rest.
            (Kind::Deflection(_), _, BranchStand::Friction(_)) => true,
            _ => false,
        }
    }
}
