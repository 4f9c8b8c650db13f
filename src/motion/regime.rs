//! Regime: the discrete state of a model in which its right-hand side is smooth.

use super::contact::ContactState;
use super::friction::FrictionState;

/// State of all contacts, friction pairs, signal lines and waves.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Regime {
    /// Line number of every drive, then of every branch's imposed e; where friction of teeth goes along their path of contact, then of
    /// every branch: which piece of the path holds it.
    pub pieces: Vec<u32>,
    /// State of every branch.
    pub states: Vec<ElementState>,
    /// Piece of each wave that imposes a displacement over an angle, by branch; empty where the waves go by the state.
    pub wave_pieces: Vec<Vec<u32>>,
}

/// State of a branch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ElementState {
    /// It has nothing to switch, or is dry friction whose step is spread over the creep speed.
    Smooth,
    /// A contact, and which piece of its stiffness wave carries it.
    Contact(ContactState, u32),
    /// A friction pair whose switches are located.
    Friction(FrictionState),
}

impl Regime {
    /// Friction pairs that stick.
    pub fn sticking_pairs(&self) -> Vec<usize> {
        let stuck = |s: &ElementState| *s == ElementState::Friction(FrictionState::Stick);
        (0..self.states.len())
            .filter(|&at| stuck(&self.states[at]))
            .collect()
    }
}
