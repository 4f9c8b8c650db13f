//! Shapes of a deviation over the flank: which of them settings can correct.

use super::measured_flank::MeasuredFlank;
use super::node_sensitivities::NodeSensitivities;

/// A shape over `F` from −1 at the toe to 1 at the heel and `H` from −1 at the root to 1 at the tip.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    /// Name.
    pub name: &'static str,
    /// Formula.
    pub formula: &'static str,
    value: fn(f64, f64) -> f64,
}

/// Shapes by rising order.
pub const SHAPES: [Shape; 11] = [
    shape("slope along the face", "F", |f, _| f),
    shape("slope along the profile", "H", |_, h| h),
    shape("lengthwise crowning", "F²", |f, _| f * f),
    shape("twist", "F H", |f, h| f * h),
    shape("profile crowning", "H²", |_, h| h * h),
    shape("cubic along the face", "F³", |f, _| f * f * f),
    shape("twist of crowning", "F² H", |f, h| f * f * h),
    shape("crowning of twist", "F H²", |f, h| f * h * h),
    shape("cubic along the profile", "H³", |_, h| h * h * h),
    shape("three waves along the face", "cos 3π F", |f, _| {
        (3.0 * std::f64::consts::PI * f).cos()
    }),
    shape("two waves along the profile", "cos 2π H", |_, h| {
        (std::f64::consts::TAU * h).cos()
    }),
];

const fn shape(name: &'static str, formula: &'static str, value: fn(f64, f64) -> f64) -> Shape {
    Shape {
        name,
        formula,
        value,
    }
}

/// Share of a shape that no settings take away.
#[derive(Debug, Clone, Copy)]
pub struct ResidualShape {
    /// The shape.
    pub shape: Shape,
    /// Root mean square left over that of the shape, its mean turn taken off; none where the nodes show only a turn.
    pub share: Option<f64>,
}

/// Shares of every shape that the first `kept` directions leave on the nodes of flanks.
pub fn residual_shapes(
    flanks: &[MeasuredFlank],
    system: &NodeSensitivities,
    kept: usize,
) -> Vec<ResidualShape> {
    let rest = |shape: Shape| {
        let nodes = flanks.iter().flat_map(|flank| &flank.nodes);
        let values: Vec<f64> = nodes
            .map(|node| {
                let [face, height] = node.shares;
                (shape.value)(2.0 * face - 1.0, 2.0 * height - 1.0)
            })
            .collect();
        ResidualShape {
            share: system.residual_share(&values, kept),
            shape,
        }
    };
    SHAPES.map(rest).to_vec()
}
