//! A viscous damper: `T = c (θ̇₂ − θ̇₁)`.

use crate::base::error::Error;
use crate::machine::builder::{Builder, twist};
use crate::machine::parts::Law;
use crate::scene::model::{Damper, Loss};

/// Puts the damper between its ends.
pub fn add(builder: &mut Builder, element: usize, damper: &Damper) -> Result<(), Error> {
    let ends = [
        builder.theta_of(&damper.between[0])?,
        builder.theta_of(&damper.between[1])?,
    ];
    let law = Law::Linear {
        stiffness: 0.0,
        loss: Loss::Viscous(damper.coefficient),
    };
    builder.branch(element, None, twist(ends), law);
    Ok(())
}
