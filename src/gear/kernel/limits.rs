//! Limits of a generated flank: undercut at `D = 0` (first kind), envelope of the contact lines on the tool at `Φ = ∂f/∂x = 0` (second).

use super::envelope::{Envelope, FlankPoint};
use super::jet::Surface;
use super::root::sign_change;

/// Kind of a flank limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// First kind, `D = 0`: edge of regression of the flank, with undercut beyond.
    Undercut,
    /// Second kind, `Φ = 0`: envelope of the contact lines on the tool. A tool point has two contacts on one side and none on the other;
    /// the flank itself continues through the limit.
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

/// Points of a limit on the straight line between two parameter pairs `[x, θ]` of a flank, in the order of the line, from sign changes over
/// `parts` equal intervals. θ is 0 for plane gears.
pub fn limit_points<S: Surface, To>(
    envelope: &Envelope<S, To>,
    limit: Limit,
    [from, to]: [[f64; 2]; 2],
    parts: usize,
) -> Vec<FlankPoint<To>> {
    let parameters = |share: f64| [0, 1].map(|k| from[k] + share * (to[k] - from[k]));
    let value = |share: f64| Some(limit.value(&envelope.flank(parameters(share))?));
    let end = |i: usize| i as f64 / parts as f64;
    let mut previous = value(end(0));
    let mut points = Vec::new();
    for i in 1..=parts {
        let current = value(end(i));
        if signs_differ(previous, current)
            && let Some(share) = sign_change([end(i - 1), end(i)], value)
        {
            points.extend(envelope.flank(parameters(share)));
        }
        previous = current;
    }
    points
}

/// Whether two values exist and have different signs.
fn signs_differ(a: Option<f64>, b: Option<f64>) -> bool {
    matches!((a, b), (Some(a), Some(b)) if (a < 0.0) != (b < 0.0))
}
