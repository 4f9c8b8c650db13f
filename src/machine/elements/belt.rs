//! A belt or chain: `δ = r₁θ₁ ∓ r₂θ₂` (− open, + crossed), `F = k δ` with the k of both strands together.

use crate::base::error::Error;
use crate::machine::builder::{MachineBuilder, branch_law};
use crate::machine::components::Gear;
use crate::machine::direction::Direction;
use crate::scene::model::Belt;

/// Puts the belt between its pulleys.
pub fn add(builder: &mut MachineBuilder, element: usize, belt: &Belt) -> Result<(), Error> {
    let [first, second] = [
        builder.theta(&belt.between[0])?,
        builder.theta(&belt.between[1])?,
    ];
    let [a, b] = belt.ratio_integers.map(|n| n as f64);
    let sense = if belt.crossed { 1.0 } else { -1.0 };
    let branch = builder.machine.branches.len();
    let direction = Direction::new(belt.radii[0] / a, [(first, a), (second, sense * b)]);
    builder.branch(
        element,
        None,
        direction,
        branch_law(belt.stiffness, belt.loss),
    );
    for turning in [first, second] {
        let gear = Gear {
            element,
            rotation_dof: turning,
            teeth: None,
            carrier: None,
            branches: vec![branch],
            mesh_geometries: Vec::new(),
        };
        builder.machine.gears.push(gear);
    }
    Ok(())
}
