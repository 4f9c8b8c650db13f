//! Mesh normal as a direction vector over both bodies: `δ = n·(u₁ − u₂)`.
//!
//! At the pitch point stand the tangent t, the pitch-cone generator g (from the apex outwards) and the normal p of the
//! pitch plane (from gear 1 into gear 2), t = g × p. The normal of the drive flank is
//! `n = cos α (cos β t − h sin β g) + sin α p`, h = 1 for a right-hand gear 1; the coast flank has −α. The mesh closes by
//! `δ = n·(u₁ − u₂)`, u the velocity-like displacement of each body at the pitch point, `u = d + ω × ρ`.
//! See docs/signs.md for the frames.

use crate::base::error::Error;
use crate::machine::builder::MachineBuilder;
use crate::machine::components::{Gear, MeshGeometry};
use crate::machine::direction::Direction;
use crate::scene::model::{Axis, ContactParameters, Name};

/// Tooth normal in the frame of one body, and the place of the mesh there.
pub struct MeshSide<'a> {
    /// The body.
    pub node: &'a Name,
    /// +1 for the first body, −1 for the second: δ = n·(u₁ − u₂).
    pub sign: f64,
    /// Components of n in the body's cylindrical frame: radial, tangential, axial.
    pub normal: [f64; 3],
    /// Integer coefficient of θ in place of its moment arm: teeth, with sign.
    pub theta_coefficient: f64,
    /// Radius of the pitch point, m.
    pub radius: f64,
    /// Angle of the mesh from the body's x to its y, rad.
    pub angle: f64,
}

/// The direction of a mesh. `scale` times `theta_coefficient` is the moment arm of each θ, m.
fn direction(
    builder: &MachineBuilder,
    scale: f64,
    sides: &[MeshSide; 2],
) -> Result<Direction, Error> {
    let mut terms = Vec::new();
    for side in sides {
        terms.push((builder.theta(side.node)?, side.theta_coefficient));
        for (axis, coefficient) in lateral_terms(side) {
            if let Some(dof) = builder.dof(side.node, axis)? {
                terms.push((dof, side.sign * coefficient / scale));
            }
        }
    }
    Ok(Direction::new(scale, terms))
}

/// Components of one contact between two toothed members.
pub struct MeshPair<'a> {
    /// Moment arm of a θ per tooth, m.
    pub scale: f64,
    /// Both members as the drive flank sees them.
    pub drive: [MeshSide<'a>; 2],
    /// As the coast flank does.
    pub coast: [MeshSide<'a>; 2],
    /// Their teeth.
    pub teeth: [u32; 2],
    /// Normal module, m, of a pair of parallel axes.
    pub cylindrical: Option<f64>,
    /// The module is given.
    pub sized: bool,
}

/// Puts one contact between two toothed members.
pub fn add_pair(
    builder: &mut MachineBuilder,
    element: usize,
    pair: &MeshPair,
    contact: &ContactParameters,
) -> Result<(), Error> {
    let drive = direction(builder, pair.scale, &pair.drive)?;
    let coast = direction(builder, pair.scale, &pair.coast)?;
    let branch = builder.machine.branches.len();
    let coast = (coast != drive).then_some(coast);
    builder.contact(element, None, drive, coast, contact);
    for (at, &teeth) in pair.teeth.iter().enumerate() {
        let (side, other) = (&pair.drive[at], &pair.coast[at]);
        let turning = builder.theta(side.node)?;
        let seat = MeshGeometry {
            angle: side.angle,
            across: [side, other].map(|side| {
                let [(_, x), (_, y), ..] = lateral_terms(side);
                [side.sign * x, side.sign * y]
            }),
            along: side.sign * side.normal[2],
            lever: (pair.scale * side.theta_coefficient / side.radius).abs(),
            cylindrical: pair.cylindrical.map(|module| [module, side.radius]),
            has_module: pair.sized,
        };
        let gear = Gear {
            element,
            rotation_dof: turning,
            teeth: Some(teeth),
            carrier: None,
            branches: vec![branch],
            mesh_geometries: vec![seat],
        };
        builder.machine.gears.push(gear);
    }
    Ok(())
}

/// `n·d + (ρ × n)·ω` for all axes but θ, with ρ = (r cos ψ, r sin ψ, 0).
fn lateral_terms(side: &MeshSide) -> [(Axis, f64); 5] {
    let [radial, tangential, axial] = side.normal;
    let (sin, cos) = side.angle.sin_cos();
    [
        (Axis::X, radial * cos - tangential * sin),
        (Axis::Y, radial * sin + tangential * cos),
        (Axis::Z, axial),
        (Axis::TiltX, side.radius * sin * axial),
        (Axis::TiltY, -side.radius * cos * axial),
    ]
}
