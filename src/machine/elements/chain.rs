//! Equal discs on equal shafts: `J θ̈ᵢ = k (θᵢ₊₁ − θᵢ) − k (θᵢ − θᵢ₋₁)`.

use crate::machine::builder::{MachineBuilder, relative_rotation};
use crate::machine::components::BranchLaw;
use crate::scene::model::{Axis, DiscChain};

/// Names of its discs.
pub fn discs(chain: &DiscChain) -> impl Iterator<Item = String> + '_ {
    (1..=chain.count).map(|i| format!("{}.{i}", chain.name.text))
}

/// Puts discs and shafts.
pub fn add(builder: &mut MachineBuilder, element: usize, chain: &DiscChain) {
    let thetas: Vec<Option<usize>> = discs(chain)
        .map(|name| builder.dof_by_name(&name, Axis::Theta))
        .collect();
    for dof in thetas.iter().flatten() {
        builder.mass(element, *dof, chain.polar);
    }
    let held = |is: bool| is.then_some(None);
    let ends: Vec<Option<usize>> = held(chain.start_fixed)
        .into_iter()
        .chain(thetas)
        .chain(held(chain.end_fixed))
        .collect();
    for (at, pair) in ends.windows(2).enumerate() {
        let law = BranchLaw::Linear {
            stiffness: chain.stiffness,
            loss: chain.loss,
        };
        builder.branch(
            element,
            Some(format!("shaft {}", at + 1)),
            relative_rotation([pair[0], pair[1]]),
            law,
        );
    }
}
