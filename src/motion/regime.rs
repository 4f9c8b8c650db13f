//! Everything that jumps, frozen: in one regime the right-hand side is smooth.

use super::contact::Stand;
use super::friction::Slip;

/// How everything stands.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Regime {
    /// Of every drive, then of every branch's imposed e: which line carries it; where friction of teeth goes along their path of
    /// contact, then of every branch: which piece of the path holds it.
    pub pieces: Vec<u32>,
    /// Of every branch: how it stands.
    pub stands: Vec<BranchStand>,
}

/// How a branch stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BranchStand {
    /// It has nothing to switch, or is dry friction whose step is spread over the creep speed.
    Smooth,
    /// A contact, and which piece of its stiffness wave carries it.
    Contact(Stand, u32),
    /// A friction pair whose switches are located.
    Friction(Slip),
}

impl Regime {
    /// Friction pairs that stick.
    pub fn sticking(&self) -> Vec<usize> {
        let stuck = |s: &BranchStand| *s == BranchStand::Friction(Slip::Stick);
        (0..self.stands.len())
            .filter(|&at| stuck(&self.stands[at]))
            .collect()
    }
}
