//! Names of input and output signals: `motor.theta.speed`, `first_pair.force`.
//!
//! An input is a degree of freedom's name: the torque (N·m) or force (N) that acts along it. As an output the same name is the
//! displacement (rad or m). `rate` and `velocity` mean `speed`, `torque` means `force`.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::text::{quoted_list, suggestion};
use crate::machine::components::{BranchLaw, Machine};

/// Quantity measured by an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutputSignal {
    /// A degree of freedom, differentiated so many times: 0, 1 or 2. rad or m, per second or per second squared.
    Dof(usize, u8),
    /// The force or torque in a branch, `k δ + c δ̇`; N or N·m.
    Force(usize),
    /// The force or torque of a bearing along one axis, springs, dashpots and cross terms together, by its number; N or N·m.
    Support(usize),
}

/// The degree of freedom an input acts on.
///
/// # Errors
/// `UnknownNode`, `UnknownDof` with the nearest names; `Conflict` where the name is of something measured.
pub fn parse_input(machine: &Machine, name: &str) -> Result<usize, Error> {
    if let Some(dof) = machine.dof(name) {
        return Ok(dof);
    }
    if parse_output(machine, name).is_ok() {
        let message = format!(
            "`{name}` can be measured but not driven: an input is a torque or force at a degree of freedom"
        );
        return Err(Error::new(Code::Conflict, message)
            .with_hint("name the degree of freedom alone, such as `motor.theta`"));
    }
    Err(unknown(machine, name))
}

/// Parses an output's name.
///
/// # Errors
/// `UnknownNode`, `UnknownDof` with the nearest names; `Conflict` for the force in a rigid joint.
pub fn parse_output(machine: &Machine, name: &str) -> Result<OutputSignal, Error> {
    if let Some(dof) = machine.dof(name) {
        return Ok(OutputSignal::Dof(dof, 0));
    }
    let Some((stem, word)) = name.rsplit_once('.') else {
        return Err(unknown(machine, name));
    };
    match word {
        "speed" | "rate" | "velocity" | "acceleration" => {
            let times = if word == "acceleration" { 2 } else { 1 };
            let dof = machine.dof(stem).ok_or_else(|| unknown(machine, stem))?;
            Ok(OutputSignal::Dof(dof, times))
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
        _ => Err(unknown(machine, name)),
    }
}

fn force(machine: &Machine, stem: &str, name: &str) -> Result<OutputSignal, Error> {
    if let Some(at) = machine.support(stem) {
        return Ok(OutputSignal::Support(at));
    }
    let branch = find_branch(machine, stem, name)?;
    if machine.branches[branch].law == BranchLaw::Rigid {
        let message =
            format!("`{stem}` is rigid: the force in it does not follow from its deformation");
        return Err(Error::new(Code::Conflict, message)
            .with_hint("give it a stiffness k, or measure a neighbouring shaft"));
    }
    Ok(OutputSignal::Force(branch))
}

/// The branch called `stem`, which the signal `name` is of.
///
/// # Errors
/// `UnknownNode` with the nearest name, or where an element of that name has several branches.
pub fn find_branch(machine: &Machine, stem: &str, name: &str) -> Result<usize, Error> {
    let names: Vec<String> = (0..machine.branches.len())
        .map(|b| machine.branch_name(b))
        .collect();
    let of_element = |b: &usize| machine.elements[machine.branches[*b].element].name == stem;
    let several: Vec<usize> = (0..names.len()).filter(of_element).collect();
    let found = names
        .iter()
        .position(|n| n == stem)
        .or(if several.len() == 1 {
            Some(several[0])
        } else {
            None
        });
    let Some(branch) = found else {
        if let Some(first) = several.first() {
            let message = format!(
                "`{stem}` has {} branches, and `{name}` does not state which",
                several.len()
            );
            let hint = format!("state for example `{}.force`", names[*first]);
            return Err(Error::new(Code::UnknownNode, message).with_hint(hint));
        }
        let error = Error::new(Code::UnknownNode, format!("no branch is called `{stem}`"));
        let near = suggestion(stem, names.iter().map(String::as_str));
        return Err(match near {
            Some(near) => error.with_hint(format!("did you mean `{near}.force`?")),
            None => error.with_hint("a branch goes by the name of its shaft, gear pair, coupling, belt, bearing or damper"),
        });
    };
    Ok(branch)
}

/// A name that is no degree of freedom: its node is unknown, or has no such axis.
fn unknown(machine: &Machine, name: &str) -> Error {
    let has = |node: &str| machine.nodes.iter().any(|n| n.name == node);
    let dofs: Vec<String> = (0..machine.dofs.len())
        .map(|f| machine.dof_name(f))
        .collect();
    if let Some((node, axis)) = name.rsplit_once('.').filter(|(node, _)| has(node)) {
        let own: Vec<&str> = dofs
            .iter()
            .map(String::as_str)
            .filter(|f| f.rsplit_once('.').is_some_and(|x| x.0 == node))
            .collect();
        let message = format!("`{node}` has no degree of freedom `{axis}`");
        let hint = match suggestion(axis, ["speed", "acceleration"].into_iter()) {
            Some(word) => format!("did you mean `{}.{word}`?", own.first().unwrap_or(&node)),
            None => format!("it has {}", quoted_list(own.into_iter())),
        };
        return Error::new(Code::UnknownDof, message).with_hint(hint);
    }
    let stem = name.rsplit_once('.').map_or(name, |x| x.0);
    let error = Error::new(Code::UnknownNode, format!("there is no node `{name}`"));
    let nodes = || machine.nodes.iter().map(|n| n.name.as_str());
    match suggestion(name, nodes().chain(dofs.iter().map(String::as_str)))
        .or_else(|| suggestion(stem, nodes()))
    {
        Some(near) => error.with_hint(format!("did you mean `{near}`?")),
        None => error.with_hint(format!("its nodes are {}", quoted_list(nodes()))),
    }
}
