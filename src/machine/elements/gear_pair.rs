//! Spur, helical, bevel and hypoid pairs: `δ = s (z₁θ₁ ± z₂θ₂) + lateral terms`, `s = mₙ cos αₙ / 2`, `F = k δ` along the tooth normal.
//!
//! One direction serves them all: with cone angle δᵢ and spiral angle βᵢ at the mean point, `rᵢ = zᵢ mₙ/(2 cos βᵢ)` and
//! the moment arm of θᵢ is `rᵢ cos αₙ cos βᵢ = s zᵢ` whatever the kind (Litvin & Fuentes, Gear Geometry and Applied Theory,
//! 2nd ed. 2004, ch. 6 for the equation of meshing n·v = 0 behind it).

use super::friction;
use super::mesh::{MeshPair, MeshSide, add_pair};
use crate::base::error::Error;
use crate::machine::builder::MachineBuilder;
use crate::scene::model::{GearPair, Hand};

/// Puts the mesh between the two bodies.
pub fn add(builder: &mut MachineBuilder, element: usize, pair: &GearPair) -> Result<(), Error> {
    // A rigid pair without a module only turns: any scale gives the same constraint.
    let module = pair.module.unwrap_or(2.0);
    let sides = |alpha: f64| [side(pair, module, alpha, 0), side(pair, module, alpha, 1)];
    let made = MeshPair {
        scale: module * pair.pressure_angle.cos() / 2.0,
        drive: sides(pair.pressure_angle),
        coast: sides(-pair.pressure_angle),
        teeth: pair.teeth,
        cylindrical: (pair.module).filter(|_| pair.cone_angles == [0.0; 2]),
        sized: pair.module.is_some(),
    };
    let branch = builder.machine.branches.len();
    add_pair(builder, element, &made, &pair.contact)?;
    match &pair.friction {
        Some(friction) => {
            let drive = (made.scale, &made.drive);
            friction::add_tooth_friction(builder, element, (pair, friction), drive, branch)
        }
        None => Ok(()),
    }
}

/// A gear as the flank with the signed pressure angle `alpha` sees it.
fn side(pair: &GearPair, module: f64, alpha: f64, i: usize) -> MeshSide<'_> {
    let hand = if pair.hand == Hand::Right { -1.0 } else { 1.0 };
    let inside = if pair.internal { -1.0 } else { 1.0 };
    let (cone, spiral) = (pair.cone_angles[i], pair.spiral_angles[i]);
    // Gear 2 sees the pitch normal from the other side; a ring sees it as gear 1 does, and so its tangent.
    let facing = if i == 0 || pair.internal { 1.0 } else { -1.0 };
    let along = hand * alpha.cos() * spiral.sin();
    let normal = [
        facing * alpha.sin() * cone.cos() + along * cone.sin(),
        facing * alpha.cos() * spiral.cos(),
        -facing * alpha.sin() * cone.sin() + along * cone.cos(),
    ];
    MeshSide {
        node: &pair.between[i],
        sign: if i == 0 { 1.0 } else { -1.0 },
        normal,
        theta_coefficient: f64::from(pair.teeth[i]) * if i == 0 { 1.0 } else { inside },
        radius: f64::from(pair.teeth[i]) * module / (2.0 * spiral.cos()),
        angle: pair.mesh_angles[i],
    }
}
