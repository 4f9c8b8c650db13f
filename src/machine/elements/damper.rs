//! A viscous damper: `T = c (θ̇₂ − θ̇₁)`.

use crate::base::error::Error;
use crate::machine::builder::{MachineBuilder, relative_rotation};
use crate::machine::components::BranchLaw;
use crate::scene::model::{BranchDamping, Damper};

/// Puts the damper between its ends.
pub fn add(builder: &mut MachineBuilder, element: usize, damper: &Damper) -> Result<(), Error> {
    let ends = [
        builder.rotation_of_end(&damper.between[0])?,
        builder.rotation_of_end(&damper.between[1])?,
    ];
    let law = BranchLaw::Linear {
        stiffness: 0.0,
        loss: BranchDamping::Viscous(damper.coefficient),
    };
    builder.branch(element, None, relative_rotation(ends), law);
    Ok(())
}
