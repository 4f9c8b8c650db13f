//! Mesh cycle, the phase of the stiffness variation: `ψ = (z (θ − θ_c) + phase)/2π`.
//!
//! It increases with the rotation of the first gear of the pair, in a planetary stage with that of the sun or ring relative to the carrier;
//! for a sun or ring fixed to ground, with that of the carrier. See docs/signs.md.

use super::components::{Gear, Machine, StageMember};

/// Degrees of freedom that determine a mesh cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshCycle {
    /// Rotational degree of freedom θ of the gear.
    pub rotation: usize,
    /// Rotational degree of freedom θ_c of the carrier.
    pub carrier: Option<usize>,
    /// Cycles per revolution; negative for a gear that rotates backward while the cycle increases.
    pub teeth: i64,
}

/// Mesh cycle of a branch in terms of each gear of the mesh; that of the gear that defines the cycle first.
pub fn cycles(machine: &Machine, branch: usize) -> Vec<MeshCycle> {
    let in_mesh = |gear: &&Gear| gear.branches.contains(&branch);
    let gears = machine.gears.iter().filter(in_mesh);
    let is_grounded = |member: &&StageMember| member.is_fixed && in_mesh(&&member.gear);
    let grounded = machine.members.iter().filter(is_grounded);
    let gears = gears.chain(grounded.map(|member| &member.gear));
    let gear_teeth = gears.filter_map(|gear| Some((gear, i64::from(gear.teeth?))));
    let cycle = |(at, (gear, teeth)): (usize, (&Gear, i64))| {
        // Rolling without deformation, `Σ c θ = 0`, gives the sense of the second gear for a forward rotation of the first.
        let terms = &machine.branches[branch].direction.terms;
        let term = terms.iter().find(|t| t.0 == gear.rotation_dof);
        let is_reversed = at > 0 && term.is_some_and(|t| t.1 > 0.0);
        MeshCycle {
            rotation: gear.rotation_dof,
            carrier: gear.carrier,
            teeth: if is_reversed { -teeth } else { teeth },
        }
    };
    gear_teeth.enumerate().map(cycle).collect()
}
