//! Event functions `p = constant + c σ` of a regime over its modal parts.

use super::stick::StickReserve;
use crate::motion::contact::Affine;
use crate::motion::dynamic_model::ElementState;

/// `p = constant + c σ + direct inputs`, above zero while the regime holds.
#[derive(Debug)]
pub struct EventFunction {
    /// Whose it is.
    pub branch: usize,
    /// State beyond the switching surface.
    pub to: ElementState,
    /// Quantity that the event function is made from.
    pub kind: EventQuantity,
    /// Constant term.
    pub constant: f64,
    /// c, over harmonics and parts.
    pub row: Vec<f64>,
    /// |c|, part by part.
    pub sizes: Vec<f64>,
    /// Which evaluator of the machine reads it.
    pub evaluator: usize,
    /// +1, or −1 where the evaluator reads its negative.
    pub sign: f64,
    /// Inputs that enter it by themselves, with what their value and their rate count.
    pub direct: Vec<(usize, [f64; 2])>,
    /// Over q and q̇, where some of these are held.
    pub dense: Option<[Vec<f64>; 2]>,
}

/// Quantity that a switching function is made from.
#[derive(Debug)]
pub enum EventQuantity {
    /// Deflection and rate of its branch.
    Deflection(Affine),
    /// Reaction that a sticking pair would have to hold.
    Reaction(StickReserve),
}

impl EventFunction {
    /// Whether it is the other side of `crossed`, a switching surface of the same branch that was just crossed.
    pub fn is_reverse_of(&self, crossed: &EventFunction) -> bool {
        if self.branch != crossed.branch {
            return false;
        }
        let back = |a: &Affine, b: &Affine| {
            a.constant == -b.constant && a.deflection == -b.deflection && a.rate == -b.rate
        };
        match (&self.kind, &crossed.kind, self.to) {
            (
                EventQuantity::Deflection(own),
                EventQuantity::Deflection(other),
                ElementState::Contact(..),
            ) => back(own, other),
            // A pair that begins to slide does so from rest.
            (EventQuantity::Deflection(_), _, ElementState::Friction(_)) => true,
            _ => false,
        }
    }
}
