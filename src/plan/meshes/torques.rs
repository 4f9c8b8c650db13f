//! Torques of the meshes at the operating point, as static forces of the branches times the base radii of the pinions.
//!
//! The machine runs evenly: a motor, or else the first node of `[speed]`, takes up what the loads leave open.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::build::build;
use crate::machine::components::Machine;
use crate::machine::kinematics::Kinematics;
use crate::machine::operating_point::{MeanForces, mean_forces};
use crate::scene::model::Model;

/// Static forces of every branch of a model whose meshes have a stiffness, with the machine.
///
/// # Errors
/// Whatever is wrong with the machine; loads that several motors share.
pub fn static_forces(model: &Model) -> Result<(Machine, MeanForces), Error> {
    let machine = build(model)?;
    let kinematics = Kinematics::new(&machine)?;
    let mut motors: Vec<usize> = machine.motors.iter().map(|motor| motor.dof).collect();
    motors.sort_unstable();
    motors.dedup();
    let held = match &motors[..] {
        [] => machine
            .speeds
            .first()
            .map(|speed| speed.0)
            .into_iter()
            .collect(),
        [one] => vec![*one],
        _ => Vec::new(),
    };
    let forces = mean_forces(&machine, &kinematics, &held)?;
    if motors.len() > 1 && forces.accelerates {
        let message = "the mean loads do not balance, and the shares of several motors are not known: the mesh torques are undetermined";
        return Err(
            Error::new(Code::Conflict, message).with_hint("state loads that balance, or one motor")
        );
    }
    Ok((machine, forces))
}

/// Mean force of the branches of an element whose part begins with a word, N; zero where there are none.
pub fn mean_force(machine: &Machine, forces: &MeanForces, element: &str, part: &str) -> f64 {
    let of_mesh = |branch: usize| {
        let b = &machine.branches[branch];
        let begins = b.part.as_deref().unwrap_or("").starts_with(part);
        machine.elements[b.element].name == element && begins
    };
    let mine = forces.forces.iter().filter(|(branch, _)| of_mesh(*branch));
    let (sum, count) = mine.fold((0.0, 0usize), |(sum, n), (_, force)| (sum + force, n + 1));
    sum / count.max(1) as f64
}
