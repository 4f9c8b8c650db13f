//! A shaft length: `T = k (θ₂ − θ₁) + losses`, positive when end 2 is ahead; it turns end 1 forward and holds end 2 back.
//!
//! A round bar has `k = G Iₚ / L`, `Iₚ = π (D⁴ − d⁴)/32`, and the inertia `ρ Iₚ L`, lumped at its ends or consistent
//! (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, ch. 9).

use std::f64::consts::PI;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::builder::{MachineBuilder, branch_law, relative_rotation};
use crate::machine::components::BranchLaw;
use crate::machine::direction::Direction;
use crate::scene::model::{Axis, BarMass, BranchDamping, Shaft, ShaftBody};

/// Polar second moment of area of a ring, m⁴.
pub fn polar_area(outer: f64, inner: f64) -> f64 {
    // (D² − d²)(D² + d²) keeps the digits of a thin tube, where D⁴ − d⁴ cancels.
    PI / 32.0 * (outer - inner) * (outer + inner) * (outer * outer + inner * inner)
}

/// Names of the inner nodes of a shaft cut in lengths.
pub fn inner_nodes(shaft: &Shaft) -> impl Iterator<Item = String> + '_ {
    let segments = match shaft.body {
        Some(ShaftBody::Bar { segments, .. }) => segments,
        _ => 1,
    };
    (1..segments).map(|i| format!("{}.{i}", shaft.name.text))
}

/// Adds the lengths, and their own inertia on request, between the ends.
pub fn add(builder: &mut MachineBuilder, element: usize, shaft: &Shaft) -> Result<(), Error> {
    let [first, last] = [
        builder.rotation_of_end(&shaft.between[0])?,
        builder.rotation_of_end(&shaft.between[1])?,
    ];
    let Some(ShaftBody::Bar {
        length,
        outer,
        inner,
        shear_modulus,
        density,
        segments,
        mass,
    }) = shaft.body
    else {
        let stiffness = match shaft.body {
            Some(ShaftBody::Stiffness(k)) => Some(k),
            _ => None,
        };
        builder.branch(
            element,
            None,
            relative_rotation([first, last]),
            branch_law(stiffness, shaft.loss),
        );
        return Ok(());
    };
    if segments > 1 && matches!(shaft.loss, BranchDamping::Ratio(_)) {
        let message = format!(
            "the damping ratio of `{}` would decrease with its number of segments",
            shaft.name.text
        );
        let hint = "the ratio refers to the mass of each segment; give c or loss_factor";
        return Err(Error::new(Code::Conflict, message)
            .with_span(&shaft.name.span)
            .with_hint(hint));
    }
    let (area, piece) = (polar_area(outer, inner), length / segments as f64);
    let (stiffness, inertia) = (shear_modulus * area / piece, density * area * piece);
    let mut ends = vec![first];
    ends.extend(inner_nodes(shaft).map(|name| builder.dof_by_name(&name, Axis::Theta)));
    ends.push(last);
    for (at, pair) in ends.windows(2).enumerate() {
        let part = (segments > 1).then(|| format!("length {}", at + 1));
        builder.branch(
            element,
            part,
            relative_rotation([pair[0], pair[1]]),
            BranchLaw::Linear {
                stiffness,
                loss: shaft.loss,
            },
        );
        add_inertia(builder, element, [pair[0], pair[1]], inertia, mass);
    }
    Ok(())
}

/// `[[2, 1], [1, 2]] = e₁e₁ᵀ + e₂e₂ᵀ + (e₁ + e₂)(e₁ + e₂)ᵀ`, so a consistent mass is three terms `m v vᵀ`.
fn add_inertia(
    builder: &mut MachineBuilder,
    element: usize,
    ends: [Option<usize>; 2],
    inertia: f64,
    mass: BarMass,
) {
    let each = match mass {
        BarMass::None => return,
        BarMass::Lumped => inertia / 2.0,
        BarMass::Consistent => inertia / 6.0,
    };
    let moving = || ends.into_iter().flatten();
    for dof in moving() {
        builder.mass(element, dof, each);
    }
    if mass == BarMass::Consistent {
        builder.mass_along(
            element,
            Direction::new(1.0, moving().map(|dof| (dof, 1.0))),
            each,
        );
    }
}
