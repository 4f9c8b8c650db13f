//! A border of a regime as a function of the parts of its machine.

use super::hold::Reaction;
use crate::motion::contact::Affine;
use crate::motion::train::BranchStand;

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
    /// Which sensor of the machine reads it.
    pub sensor: usize,
    /// +1, or −1 where the sensor reads its negative.
    pub sign: f64,
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
