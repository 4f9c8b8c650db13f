//! Equal discs on equal shafts: `J θ̈ᵢ = k (θᵢ₊₁ − θᵢ) − k (θᵢ − θᵢ₋₁)`.

use crate::machine::builder::{Builder, twist};
use crate::machine::parts::Law;
use crate::scene::model::{Axis, Chain};

/// Names of its discs.
pub fn discs(chain: &Chain) -> impl Iterator<Item = String> + '_ {
    (1..=chain.count).map(|i| format!("{}.{i}", chain.name.text))
}

/// Puts discs and shafts.
pub fn add(builder: &mut Builder, element: usize, chain: &Chain) {
    let thetas: Vec<Option<usize>> = discs(chain)
        .map(|name| builder.named(&name, Axis::Theta))
        .collect();
    for freedom in thetas.iter().flatten() {
        builder.mass(element, *freedom, chain.polar);
    }
    let held = |is: bool| is.then_some(None);
    let ends: Vec<Option<usize>> = held(chain.start_held)
        .into_iter()
        .chain(thetas)
        .chain(held(chain.end_held))
        .collect();
    for (at, pair) in ends.windows(2).enumerate() {
        let law = Law::Linear {
            stiffness: chain.stiffness,
            loss: chain.loss,
        };
        builder.branch(
            element,
            Some(format!("shaft {}", at + 1)),
            twist([pair[0], pair[1]]),
            law,
        );
    }
}
