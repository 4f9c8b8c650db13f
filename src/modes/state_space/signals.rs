//! Names of input and output signals: `motor.theta.speed`, `first_pair.force`.
//!
//! The name of a degree of freedom denotes the torque (N·m) or force (N) along it as an input, the displacement (rad or m) as an output.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::text::{quoted_list, suggestion};
use crate::machine::components::{BranchLaw, Machine};

/// Quantity measured by an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutputSignal {
    /// Degree of freedom and number of time derivatives, 0 to 2; rad or m, per second or per second squared.
    Dof(usize, u8),
    /// Force or torque in a branch by index, `k δ + c δ̇`; N or N·m.
    Force(usize),
    /// Force or torque of a bearing along one axis, cross terms included, by index of the support; N or N·m.
    Support(usize),
}

/// Index of the degree of freedom on which an input acts.
///
/// # Errors
/// `UnknownNode`, `UnknownDof` with the nearest names; `Conflict` if the name denotes an output quantity.
pub fn parse_input(machine: &Machine, name: &str) -> Result<usize, Error> {
    if let Some(dof) = machine.dof(name) {
        return Ok(dof);
    }
    if parse_output(machine, name).is_ok() {
        let message = format!(
            "`{name}` is an output only: an input is a torque or force at a degree of freedom"
        );
        return Err(Error::new(Code::Conflict, message)
            .with_hint("name the degree of freedom alone, such as `motor.theta`"));
    }
    Err(name_error(machine, name))
}

/// Parses the name of an output; `rate` and `velocity` mean `speed`, `torque` means `force`.
///
/// # Errors
/// `UnknownNode`, `UnknownDof` with the nearest names; `Conflict` for the force in a rigid joint.
pub fn parse_output(machine: &Machine, name: &str) -> Result<OutputSignal, Error> {
    if let Some(dof) = machine.dof(name) {
        return Ok(OutputSignal::Dof(dof, 0));
    }
    let Some((stem, word)) = name.rsplit_once('.') else {
        return Err(name_error(machine, name));
    };
    match word {
        "speed" | "rate" | "velocity" | "acceleration" => {
            let n_derivatives = if word == "acceleration" { 2 } else { 1 };
            let dof = machine.dof(stem).ok_or_else(|| name_error(machine, stem))?;
            Ok(OutputSignal::Dof(dof, n_derivatives))
        }
        "force" | "torque" => force(machine, stem, name),
        _ if machine.elements.iter().any(|e| e.name == stem)
            && !machine
                .nodes
                .iter()
                .any(|n| n.name.starts_with(&format!("{stem}.")))
            && machine.dof(stem).is_none() =>
        {
            let message = format!("`{stem}` has no `{word}`");
            Err(Error::new(Code::UnknownNode, message).with_hint(format!(
                "it has `{stem}.force`, and in motion `{stem}.deflection`"
            )))
        }
        _ => Err(name_error(machine, name)),
    }
}

fn force(machine: &Machine, stem: &str, name: &str) -> Result<OutputSignal, Error> {
    if let Some(at) = machine.support(stem) {
        return Ok(OutputSignal::Support(at));
    }
    let branch = find_branch(machine, stem, name)?;
    if machine.branches[branch].law == BranchLaw::Rigid {
        let message = format!("`{stem}` is rigid: its force is not determined by its deformation");
        return Err(Error::new(Code::Conflict, message)
            .with_hint("give it a stiffness k, or measure a neighbouring shaft"));
    }
    Ok(OutputSignal::Force(branch))
}

/// Index of the branch called `stem` of the signal `name`.
///
/// # Errors
/// `UnknownNode` with the nearest name, or if an element of that name has several branches.
pub fn find_branch(machine: &Machine, stem: &str, name: &str) -> Result<usize, Error> {
    let names: Vec<String> = (0..machine.branches.len())
        .map(|b| machine.branch_name(b))
        .collect();
    let is_in_element = |b: &usize| machine.elements[machine.branches[*b].element].name == stem;
    let candidates: Vec<usize> = (0..names.len()).filter(is_in_element).collect();
    let index = names
        .iter()
        .position(|n| n == stem)
        .or(if candidates.len() == 1 {
            Some(candidates[0])
        } else {
            None
        });
    let Some(branch) = index else {
        if let Some(first) = candidates.first() {
            let message = format!(
                "`{stem}` has {} branches, and `{name}` does not state which",
                candidates.len()
            );
            let hint = format!("state for example `{}.force`", names[*first]);
            return Err(Error::new(Code::UnknownNode, message).with_hint(hint));
        }
        let error = Error::new(Code::UnknownNode, format!("no branch is called `{stem}`"));
        let nearest = suggestion(stem, names.iter().map(String::as_str));
        return Err(match nearest {
            Some(nearest) => error.with_hint(format!("did you mean `{nearest}.force`?")),
            None => error.with_hint("name a shaft, gear pair, coupling, belt, bearing or damper"),
        });
    };
    Ok(branch)
}

/// Error for a name that is not a degree of freedom: its node is unknown, or the node lacks the axis.
fn name_error(machine: &Machine, name: &str) -> Error {
    let is_node = |node: &str| machine.nodes.iter().any(|n| n.name == node);
    let dofs: Vec<String> = (0..machine.dofs.len())
        .map(|f| machine.dof_name(f))
        .collect();
    if let Some((node, axis)) = name.rsplit_once('.').filter(|(node, _)| is_node(node)) {
        let dofs: Vec<&str> = dofs
            .iter()
            .map(String::as_str)
            .filter(|f| f.rsplit_once('.').is_some_and(|x| x.0 == node))
            .collect();
        let message = format!("`{node}` has no degree of freedom `{axis}`");
        let hint = match suggestion(axis, ["speed", "acceleration"].into_iter()) {
            Some(word) => format!("did you mean `{}.{word}`?", dofs.first().unwrap_or(&node)),
            None => format!("it has {}", quoted_list(dofs.into_iter())),
        };
        return Error::new(Code::UnknownDof, message).with_hint(hint);
    }
    let stem = name.rsplit_once('.').map_or(name, |x| x.0);
    let error = Error::new(Code::UnknownNode, format!("there is no node `{name}`"));
    let nodes = || machine.nodes.iter().map(|n| n.name.as_str());
    match suggestion(name, nodes().chain(dofs.iter().map(String::as_str)))
        .or_else(|| suggestion(stem, nodes()))
    {
        Some(nearest) => error.with_hint(format!("did you mean `{nearest}`?")),
        None => error.with_hint(format!("its nodes are {}", quoted_list(nodes()))),
    }
}
