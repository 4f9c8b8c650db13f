//! A torsional coupling: `T = k (θ₂ − θ₁) + losses`, after its lost motion is taken up; next to it springs and dampers in
//! series, `T + (c/k) Ṫ = c (θ̇₂ − θ̇₁)` (Maxwell 1867), each with the node where both meet.

use crate::base::error::Error;
use crate::machine::builder::{MachineBuilder, relative_rotation};
use crate::machine::components::BranchLaw;
use crate::scene::model::{Axis, BranchDamping, Coupling};

/// Names of the nodes between springs and dampers in series.
pub fn inner_nodes(coupling: &Coupling) -> impl Iterator<Item = String> + '_ {
    (1..=coupling.maxwell.len()).map(|i| format!("{}.maxwell_{i}", coupling.name.text))
}

/// Puts the coupling between its ends.
pub fn add(builder: &mut MachineBuilder, element: usize, coupling: &Coupling) -> Result<(), Error> {
    let [first, second] = [
        builder.rotation_of_end(&coupling.between[0])?,
        builder.rotation_of_end(&coupling.between[1])?,
    ];
    if coupling.contact.stiffness.is_some() || coupling.maxwell.is_empty() {
        let along = relative_rotation([first, second]);
        builder.contact(element, None, along, None, &coupling.contact);
    }
    for (node, [stiffness, damping]) in inner_nodes(coupling).zip(&coupling.maxwell) {
        let part = |what: &str| {
            node.rsplit_once('.')
                .map(|(_, own)| format!("{own} {what}"))
        };
        let inner = builder.dof_by_name(&node, Axis::Theta);
        let spring = BranchLaw::Linear {
            stiffness: *stiffness,
            loss: BranchDamping::None,
        };
        let damper = BranchLaw::Linear {
            stiffness: 0.0,
            loss: BranchDamping::Viscous(*damping),
        };
        builder.branch(
            element,
            part("spring"),
            relative_rotation([first, inner]),
            spring,
        );
        builder.branch(
            element,
            part("damper"),
            relative_rotation([inner, second]),
            damper,
        );
    }
    Ok(())
}
