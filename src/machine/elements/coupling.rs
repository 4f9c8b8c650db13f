//! A torsional coupling: `T = k (θ₂ − θ₁) + losses`, after its lost motion is taken up; beside it springs and dampers in
//! series, `T + (c/k) Ṫ = c (θ̇₂ − θ̇₁)` (Maxwell 1867), each with the node where both meet.

use crate::base::error::Error;
use crate::machine::builder::{Builder, twist};
use crate::machine::parts::Law;
use crate::scene::model::{Axis, Coupling, Loss};

/// Names of the nodes between springs and dampers in series.
pub fn inner_nodes(coupling: &Coupling) -> impl Iterator<Item = String> + '_ {
    (1..=coupling.maxwell.len()).map(|i| format!("{}.maxwell_{i}", coupling.name.text))
}

/// Puts the coupling between its ends.
pub fn add(builder: &mut Builder, element: usize, coupling: &Coupling) -> Result<(), Error> {
    let [first, second] = [
        builder.theta_of(&coupling.between[0])?,
        builder.theta_of(&coupling.between[1])?,
    ];
    if coupling.contact.stiffness.is_some() || coupling.maxwell.is_empty() {
        let along = twist([first, second]);
        builder.contact(element, None, along, None, &coupling.contact);
    }
    for (node, [stiffness, damping]) in inner_nodes(coupling).zip(&coupling.maxwell) {
        let part = |what: &str| {
            node.rsplit_once('.')
                .map(|(_, own)| format!("{own} {what}"))
        };
        let inner = builder.named(&node, Axis::Theta);
        let spring = Law::Linear {
            stiffness: *stiffness,
            loss: Loss::None,
        };
        let damper = Law::Linear {
            stiffness: 0.0,
            loss: Loss::Viscous(*damping),
        };
        builder.branch(element, part("spring"), twist([first, inner]), spring);
        builder.branch(element, part("damper"), twist([inner, second]), damper);
    }
    Ok(())
}
