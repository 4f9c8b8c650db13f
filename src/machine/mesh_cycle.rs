//! The cycle of a mesh, which its stiffness wave is counted by: `ψ = (z (θ − θ_c) + phase)/2π`.
//!
//! It goes forward as the first gear of the pair turns in its positive sense, of a planetary stage the sun or the ring against the
//! carrier; of a sun or ring that is fixed to ground, as the carrier does. See docs/signs.md.

use super::components::{Gear, Machine, StageMember};

/// Degrees of freedom that count a mesh cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshCycle {
    /// A degree of freedom whose turn carries it on.
    pub turning: usize,
    /// The degree of freedom that carries the mesh round.
    pub carrier: Option<usize>,
    /// Cycles a turn; below zero for a gear that turns backward as the cycle goes forward.
    pub teeth: i64,
}

/// The ways to count the cycle of a branch, one by each gear of the mesh, that of the gear that defines it first.
pub fn cycles(machine: &Machine, branch: usize) -> Vec<MeshCycle> {
    let in_mesh = |gear: &&Gear| gear.branches.contains(&branch);
    let gears = machine.gears.iter().filter(in_mesh);
    let standing = |member: &&StageMember| member.is_fixed && in_mesh(&&member.gear);
    let standing = machine.members.iter().filter(standing);
    let all = gears.chain(standing.map(|member| &member.gear));
    let counts = all.filter_map(|gear| Some((gear, i64::from(gear.teeth?))));
    let count = |(at, (gear, teeth)): (usize, (&Gear, i64))| {
        // Rolling without strain, `Σ c θ = 0`: the second gear turns so that the first turns forward.
        let terms = &machine.branches[branch].direction.terms;
        let own = terms.iter().find(|t| t.0 == gear.rotation_dof);
        let backward = at > 0 && own.is_some_and(|t| t.1 > 0.0);
        MeshCycle {
            turning: gear.rotation_dof,
            carrier: gear.carrier,
            teeth: if backward { -teeth } else { teeth },
        }
    };
    counts.enumerate().map(count).collect()
}
