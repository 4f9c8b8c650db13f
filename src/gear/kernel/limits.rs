//! Limits of a flank: undercut where `D = 0` (first kind), and where `Φ = ∂f/∂x = 0` the contact lines have an envelope on the tool (second kind).

use super::envelope::{Envelope, FlankPoint};
use super::jet::Surface;
use super::root::sign_change;

/// Kind of a limit of a flank.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// First kind, `D = 0`: the flank has an edge of regression; beyond it metal is undercut.
    Undercut,
    /// Second kind, `Φ = 0`: contact lines meet their envelope on the tool. On one side of it a point of the tool touches twice, on the other
    /// never; the flank goes on through it.
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

/// Points of the limit on the straight line between two places `[x, θ]` of a flank, in the line's order; the signs at the ends of `parts`
/// equal parts are compared. In the plane θ is 0.
pub fn limit_points<S: Surface, To>(
    envelope: &Envelope<S, To>,
    limit: Limit,
    [from, to]: [[f64; 2]; 2],
    parts: usize,
) -> Vec<FlankPoint<To>> {
    let place = |share: f64| [0, 1].map(|k| from[k] + share * (to[k] - from[k]));
    let value = |share: f64| Some(limit.value(&envelope.flank(place(share))?));
    let end = |i: usize| i as f64 / parts as f64;
    let mut before = value(end(0));
    let mut found = Vec::new();
    for i in 1..=parts {
        let here = value(end(i));
        if differ(before, here)
            && let Some(share) = sign_change([end(i - 1), end(i)], value)
        {
            found.extend(envelope.flank(place(share)));
        }
        before = here;
    }
    found
}

/// Whether two values have different signs.
fn differ(a: Option<f64>, b: Option<f64>) -> bool {
    matches!((a, b), (Some(a), Some(b)) if (a < 0.0) != (b < 0.0))
}
