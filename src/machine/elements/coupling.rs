//! A torsional coupling: `T = k (θ₂ − θ₁) + losses`, after its lost motion is taken up.

use crate::base::error::Error;
use crate::machine::builder::{Builder, twist};
use crate::scene::model::Coupling;

/// Puts the coupling between its ends.
pub fn add(builder: &mut Builder, element: usize, coupling: &Coupling) -> Result<(), Error> {
    let ends = [
        builder.theta_of(&coupling.between[0])?,
        builder.theta_of(&coupling.between[1])?,
    ];
    builder.contact(element, None, twist(ends), None, &coupling.contact);
    Ok(())
}
