//! Spur, helical, bevel and hypoid pairs: `δ = s (z₁θ₁ ± z₂θ₂) + lateral terms`, `s = mₙ cos αₙ / 2`, `F = k δ` along the tooth normal.
//!
//! One direction serves them all: with cone angle δᵢ and spiral angle βᵢ at the mean point, `rᵢ = zᵢ mₙ/(2 cos βᵢ)` and
//! the moment arm of θᵢ is `rᵢ cos αₙ cos βᵢ = s zᵢ` whatever the kind (Litvin & Fuentes, Gear Geometry and Applied Theory,
//! 2nd ed. 2004, ch. 6 for the equation of meshing n·v = 0 behind it).

use super::tooth::{Side, add_pair, direction};
use crate::base::error::Error;
use crate::machine::builder::Builder;
use crate::machine::direction::Direction;
use crate::scene::model::{GearPair, Hand};

/// Puts the mesh between the two bodies.
pub fn add(builder: &mut Builder, element: usize, pair: &GearPair) -> Result<(), Error> {
    let drive = mesh(builder, pair, pair.pressure_angle)?;
    let coast = mesh(builder, pair, -pair.pressure_angle)?;
    let members = pair.between.iter().zip(pair.teeth);
    add_pair(builder, element, members, [drive, coast], &pair.contact)
}

/// The direction of the flank with the signed pressure angle `alpha`.
fn mesh(builder: &Builder, pair: &GearPair, alpha: f64) -> Result<Direction, Error> {
    // A rigid pair without a module only turns: any scale gives the same constraint.
    let module = pair.module.unwrap_or(2.0);
    let hand = if pair.hand == Hand::Right { -1.0 } else { 1.0 };
    let inside = if pair.internal { -1.0 } else { 1.0 };
    let side = |i: usize| {
        let (cone, spiral) = (pair.cone_angles[i], pair.spiral_angles[i]);
        // Gear 2 sees the pitch normal from the other side; a ring sees it as gear 1 does, and so its tangent.
        let facing = if i == 0 || pair.internal { 1.0 } else { -1.0 };
        let along = hand * alpha.cos() * spiral.sin();
        let normal = [
            facing * alpha.sin() * cone.cos() + along * cone.sin(),
            facing * alpha.cos() * spiral.cos(),
            -facing * alpha.sin() * cone.sin() + along * cone.cos(),
        ];
        let turns = f64::from(pair.teeth[i]) * if i == 0 { 1.0 } else { inside };
        let radius = f64::from(pair.teeth[i]) * module / (2.0 * spiral.cos());
        let sign = if i == 0 { 1.0 } else { -1.0 };
        Side {
            node: &pair.between[i],
            sign,
            normal,
            turns,
            radius,
            angle: pair.mesh_angles[i],
        }
    };
    direction(builder, module * alpha.cos() / 2.0, &[side(0), side(1)])
}
