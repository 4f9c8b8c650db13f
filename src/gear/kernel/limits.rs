//! Limits of a flank: undercut where `D = 0` (first kind), and where `Φ = ∂f/∂x = 0` the contact lines have an envelope on the tool (second kind).

use super::envelope::{Envelope, FlankPoint};
use super::jet::Surface;
use super::root::sign_change;

/// Kind of a limit of a flank.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// First kind, `D = 0`: the flank has an edge of regression; beyond it metal is undercut.
    Undercut,
    /// Second kind, `Φ = 0`: contact lines meet their envelope on the tool; beyond it the tool does not touch.
    Second,
}

impl Limit {
    fn value<Frame>(self, point: &FlankPoint<Frame>) -> f64 {
        match self {
            Limit::Undercut => point.second_order.undercut,
            Limit::Second => point.second_order.second_limit,
        }
    }
}

/// Points of the limit on the line of constant θ of a flank, by rising x; `parts` intervals of the motion's range are compared in sign.
pub fn limit_points<S: Surface, To>(
    envelope: &Envelope<S, To>,
    limit: Limit,
    theta: f64,
    parts: usize,
) -> Vec<FlankPoint<To>> {
    let [from, to] = envelope.range;
    let value = |x: f64| Some(limit.value(&envelope.flank([x, theta])?));
    let place = |i: usize| from + (to - from) * i as f64 / parts as f64;
    (0..parts)
        .filter_map(|i| sign_change([place(i), place(i + 1)], value))
        .filter_map(|x| envelope.flank([x, theta]))
        .collect()
}
