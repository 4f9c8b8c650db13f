//! Load-dependent friction: bearings `T = T₀ + μ r F`, teeth `μ F` along the path of contact.
//!
//! A pair of teeth in contact at s from the pitch point slides at `L₁ω₁ + L₂ω₂`, `L₁ = r_b1 tan α + s`, `L₂ = r_b2 tan α − s` (positive
//! rotations opposite): `s (θ̇₁ − θ̇₂)` plus the sliding at the pitch point. The sense of the force follows `s (θ̇₁ − θ̇₂)`.

use super::mesh::MeshSide;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::cylindrical::path_of_contact::{PathGeometry, PathOfContact};
use crate::machine::builder::{MachineBuilder, relative_rotation};
use crate::machine::components::{
    BranchLaw, FrictionCapacity, FrictionElement, LoadDependentCapacity, ToothFrictionPath,
};
use crate::machine::direction::Direction;
use crate::scene::laws::ToothFriction;
use crate::scene::model::{Axis, Bearing, BearingFriction, BranchEnd, GearPair};

/// Adds the friction element of a bearing to the machine.
///
/// # Errors
/// `Conflict` for a loading pair that is missing or rigid; `MissingKey` for a friction coefficient without a load.
pub fn add_bearing_friction(
    builder: &mut MachineBuilder,
    element: usize,
    part: &Bearing,
    friction: &BearingFriction,
) -> Result<(), Error> {
    let ends = [
        builder.rotation_of_end(&part.between[0])?,
        builder.rotation_of_end(&part.between[1])?,
    ];
    let components = match (&friction.loaded_by, friction.coefficient > 0.0) {
        (_, false) => Vec::new(),
        (Some((pair, share)), true) => {
            let machine = &builder.machine;
            let loads = |b: &crate::machine::components::Branch| {
                machine.elements[b.element].name == pair.text && b.law != BranchLaw::Rigid
            };
            let pair_kinds = ["gear_pair", "worm_pair", "belt"];
            let index = machine.branches.iter().position(loads).filter(|&i| {
                pair_kinds.contains(&machine.elements[machine.branches[i].element].kind)
            });
            let index = index.ok_or_else(|| {
                let message = format!(
                    "`{}` carries the force of `{}`, which is not an elastic pair or belt",
                    part.name.text, pair.text
                );
                Error::new(Code::Conflict, message)
                    .with_span(&pair.span)
                    .with_hint("name a [[gear_pair]], [[worm_pair]] or [[belt]] that has `k`")
            })?;
            vec![vec![(index, *share)]]
        }
        (None, true) => radial_forces(builder, element, part)?,
    };
    builder.machine.friction_elements.push(FrictionElement {
        element,
        direction: relative_rotation(ends),
        friction: friction.law,
        capacity: FrictionCapacity::Pressed(LoadDependentCapacity {
            constant: friction.constant,
            coefficient: friction.coefficient,
            force_components: components,
            path: None,
        }),
    });
    Ok(())
}

/// Forces of the branches of a bearing along x and y: branch index and factor, by component.
fn radial_forces(
    builder: &MachineBuilder,
    element: usize,
    part: &Bearing,
) -> Result<Vec<Vec<(usize, f64)>>, Error> {
    let mut components = Vec::new();
    let node = part.between.iter().find_map(|end| match end {
        BranchEnd::Node(node) => Some(node),
        BranchEnd::Ground => None,
    });
    for axis in [Axis::X, Axis::Y] {
        let dof = match node {
            Some(node) => builder.dof(node, axis)?,
            None => None,
        };
        let branches = builder.machine.branches.iter().enumerate();
        let bearing_branches = branches.filter(|(_, b)| b.element == element);
        let projection = |b: &crate::machine::components::Branch| -> f64 {
            let direction = b.force.as_ref().unwrap_or(&b.direction);
            let terms = direction.entries().filter(|t| Some(t.0) == dof);
            terms.map(|t| t.1).sum()
        };
        let forces = bearing_branches.map(|(at, b)| (at, projection(b)));
        let forces: Vec<(usize, f64)> = forces.filter(|f| f.1 != 0.0).collect();
        if !forces.is_empty() {
            components.push(forces);
        }
    }
    match components.is_empty() {
        false => Ok(components),
        true => {
            let message = format!(
                "`{}` has load-dependent friction and no load",
                part.name.text
            );
            Err(Error::new(Code::MissingKey, message)
                .with_span(&part.name.span)
                .with_hint("give `radial_load`, or the pair it `carries`, or `k_radial`"))
        }
    }
}

/// Adds the tooth friction of a gear pair; `drive` holds both gears as seen from the drive flanks, `branch` is the index of the mesh branch.
///
/// # Errors
/// `OutOfRange` for a contact ratio below 1.
pub fn add_tooth_friction(
    builder: &mut MachineBuilder,
    element: usize,
    (pair, friction): (&GearPair, &ToothFriction),
    (scale, drive): (f64, &[MeshSide; 2]),
    branch: usize,
) -> Result<(), Error> {
    let thetas = [builder.theta(drive[0].node)?, builder.theta(drive[1].node)?];
    let angle = (pair.pressure_angle.tan() / pair.spiral_angles[0].cos()).atan();
    let radii = [drive[0].radius, drive[1].radius];
    let addendum = 2.0 * scale / pair.pressure_angle.cos();
    let default_tips = [
        radii[0] + addendum,
        radii[1] + if pair.internal { -addendum } else { addendum },
    ];
    let geometry = PathGeometry {
        base: radii.map(|r| r * angle.cos()),
        tip: friction.tips.unwrap_or(default_tips),
        angle,
        teeth: pair.teeth[0],
        internal: pair.internal,
    };
    let path = PathOfContact::new(&geometry).ok_or_else(|| {
        let message = format!(
            "the contact ratio of `{}` is below 1: teeth separate before the next ones touch",
            pair.name.text
        );
        Error::new(Code::OutOfRange, message)
            .with_span(&pair.name.span)
            .with_hint("give `tip_diameters`, or omit `friction`")
    })?;
    let pitch_point_sliding = [1.0, -1.0].map(|flank| {
        let mut terms = Vec::new();
        for (side, &theta) in drive.iter().zip(&thetas) {
            let [radial, tangential, _] = side.normal;
            let length = radial.hypot(tangential);
            terms.push((theta, angle.tan() * scale * side.theta_coefficient / length));
            let (sin, cos) = side.angle.sin_cos();
            let t = [-tangential, radial].map(|x| flank * side.sign * x / length);
            // The radial component of the normal is reversed on the coast flank.
            let t = if flank < 0.0 { [t[0], -t[1]] } else { t };
            for (axis, x) in [
                (Axis::X, t[0] * cos - t[1] * sin),
                (Axis::Y, t[0] * sin + t[1] * cos),
            ] {
                terms.extend(builder.dof(side.node, axis).ok().flatten().map(|f| (f, x)));
            }
        }
        Direction::new(1.0, terms)
    });
    builder.machine.friction_elements.push(FrictionElement {
        element,
        direction: Direction::new(1.0, [(thetas[0], 1.0), (thetas[1], -1.0)]),
        friction: friction.law,
        capacity: FrictionCapacity::Pressed(LoadDependentCapacity {
            constant: 0.0,
            coefficient: friction.coefficient,
            force_components: vec![vec![(branch, 1.0)]],
            path: Some(ToothFrictionPath {
                pitch_point_sliding,
                pieces: match friction.path {
                    Some(_) => path.segments(),
                    None => vec![path.mean_segment()],
                },
                cycle: friction.path.map(|start| (thetas[0], pair.teeth[0], start)),
            }),
        }),
    });
    Ok(())
}
