//! Named inputs and outputs of a frequency response.
//!
//! Inputs: `motor.theta` a torque or force along a degree of freedom; `first_pair.displacement` (or `.te`) the imposed
//! displacement of a branch, positive where it lets the branch rest at a positive deflection; `ground.x` a motion of the base;
//! `motor.theta.motion` a prescribed angle. Outputs: `work.theta`, `.speed`, `.acceleration`, sums such as
//! `work.theta - 1/27*motor.theta`, `first_pair.force`, `first_pair.deflection`.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::text::quoted_list;
use crate::machine::components::{BranchLaw, Machine};
use crate::modes::state_space::signals;
use crate::scene::model::Axis;

/// Excitation applied at an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResponseInput {
    /// A torque (N·m) or force (N) along a degree of freedom.
    Torque(usize),
    /// A displacement imposed in a branch, its transmission error: rad or m.
    Displacement(usize),
    /// The base moves along an axis: rad or m.
    Base(Axis),
    /// A degree of freedom moves as prescribed: rad or m.
    Motion(usize),
}

/// Quantity measured at an output.
#[derive(Debug, Clone, PartialEq)]
pub enum ResponseOutput {
    /// `Σ a q`, differentiated so many times: 0, 1 or 2.
    Sum(Vec<(usize, f64)>, u8),
    /// The force or torque in a branch, N or N·m.
    Force(usize),
    /// `Σ a F` of elastic branches: the force or torque of a bearing along one axis, N or N·m.
    Forces(Vec<(usize, f64)>),
    /// The deformation of a branch, `wᵀq − e`.
    Deflection(usize),
}

/// Something at a place of the machine, as it was named.
#[derive(Debug, Clone, PartialEq)]
pub struct Port<What> {
    /// Name of the port.
    pub name: String,
    /// Unit of the port.
    pub unit: &'static str,
    /// Kind of the port.
    pub kind: What,
}

/// All inputs and outputs, and the degrees of freedom that are held still.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Ports {
    /// Excitations.
    pub inputs: Vec<Port<ResponseInput>>,
    /// Measured quantities.
    pub outputs: Vec<Port<ResponseOutput>>,
    /// Degrees of freedom that do not move, such as a driver whose angle is prescribed.
    pub fixed: Vec<usize>,
}

impl Ports {
    /// Resolves names.
    ///
    /// # Errors
    /// Names that do not exist, with the nearest; sums of unlike quantities; rigid branches where a deformation is asked.
    pub fn parse(
        machine: &Machine,
        inputs: &[String],
        outputs: &[String],
        held: &[String],
    ) -> Result<Ports, Error> {
        let hold = |name: &String| signals::parse_input(machine, name);
        Ok(Ports {
            inputs: inputs
                .iter()
                .map(|name| input(machine, name))
                .collect::<Result<_, _>>()?,
            outputs: outputs
                .iter()
                .map(|name| output(machine, name))
                .collect::<Result<_, _>>()?,
            fixed: held.iter().map(hold).collect::<Result<_, _>>()?,
        })
    }
}

/// Parses an input's name.
///
/// # Errors
/// Those of [`Ports::parse`].
pub fn input(machine: &Machine, name: &str) -> Result<Port<ResponseInput>, Error> {
    let port = |what: ResponseInput, unit: &'static str| Port {
        name: name.to_string(),
        unit,
        kind: what,
    };
    if let Some(dof) = machine.dof(name) {
        let unit = force_unit(machine.dofs[dof].axis.is_rotation());
        return Ok(port(ResponseInput::Torque(dof), unit));
    }
    match name.rsplit_once('.') {
        Some((stem, "displacement" | "te")) => {
            let branch = signals::find_branch(machine, stem, name)?;
            Ok(port(
                ResponseInput::Displacement(branch),
                displacement_unit(is_rotational(machine, branch)),
            ))
        }
        Some((stem, "motion")) => {
            let dof = signals::parse_input(machine, stem)?;
            Ok(port(
                ResponseInput::Motion(dof),
                displacement_unit(machine.dofs[dof].axis.is_rotation()),
            ))
        }
        Some(("ground", word)) => {
            let axes = [Axis::Theta, Axis::X, Axis::Y, Axis::Z];
            let Some(axis) = axes.into_iter().find(|axis| axis.name() == word) else {
                let message = format!("the ground does not move along `{word}`");
                let names = axes.iter().map(|axis| axis.name());
                return Err(Error::new(Code::UnknownDof, message)
                    .with_hint(format!("it has {}", quoted_list(names))));
            };
            Ok(port(
                ResponseInput::Base(axis),
                displacement_unit(axis.is_rotation()),
            ))
        }
        _ => Err(match signals::parse_input(machine, name) {
            Err(error) => error,
            Ok(_) => Error::new(Code::UnknownNode, format!("there is no input `{name}`")),
        }),
    }
}

/// Parses an output's name.
///
/// # Errors
/// Those of [`Ports::parse`].
pub fn output(machine: &Machine, name: &str) -> Result<Port<ResponseOutput>, Error> {
    let port = |what: ResponseOutput, unit: &'static str| Port {
        name: name.to_string(),
        unit,
        kind: what,
    };
    if let Some((stem, word @ ("force" | "torque" | "deflection"))) = name.rsplit_once('.') {
        let support = machine.support(stem).map(|at| &machine.supports[at]);
        if let (Some(support), "force" | "torque") = (support, word) {
            let unit = force_unit(support.axis.is_rotation());
            return Ok(port(ResponseOutput::Forces(support.forces.clone()), unit));
        }
        let branch = signals::find_branch(machine, stem, name)?;
        let turns = is_rotational(machine, branch);
        if word != "deflection" {
            return Ok(port(ResponseOutput::Force(branch), force_unit(turns)));
        }
        if machine.branches[branch].law == BranchLaw::Rigid {
            let message = format!("`{stem}` is rigid and does not deform");
            return Err(
                Error::new(Code::Conflict, message).with_hint(format!("it has `{stem}.force`"))
            );
        }
        return Ok(port(
            ResponseOutput::Deflection(branch),
            displacement_unit(turns),
        ));
    }
    let terms = terms(name);
    let (mut sum, mut kind) = (Vec::new(), None);
    for (factor, term) in terms {
        let signals::OutputSignal::Dof(dof, times) = signals::parse_output(machine, term)? else {
            let message = format!("`{term}` of `{name}` is not the motion of a degree of freedom");
            return Err(Error::new(Code::Conflict, message)
                .with_hint("sums take degrees of freedom only: `work.theta - 1/27*motor.theta`"));
        };
        let own = (machine.dofs[dof].axis.is_rotation(), times);
        if kind.is_some_and(|kind: (bool, u8)| kind.1 != own.1) {
            let message = format!("`{name}` adds different quantities");
            return Err(Error::new(Code::Conflict, message)
                .with_hint("use displacements, speeds or accelerations for all of its terms"));
        }
        kind.get_or_insert(own);
        sum.push((dof, factor));
    }
    let (turns, times) = kind.unwrap_or((true, 0));
    Ok(port(
        ResponseOutput::Sum(sum, times),
        rate_unit(turns, times),
    ))
}

/// Parses `a*x + b*y - z` into factors and names; signs are surrounded by blanks, since names may hold dashes.
fn terms(text: &str) -> Vec<(f64, &str)> {
    let mut all = Vec::new();
    let mut sign = 1.0;
    for word in text.split_whitespace() {
        match word {
            "+" => sign = 1.0,
            "-" | "−" => sign = -1.0,
            _ => {
                let scaled = word
                    .split_once('*')
                    .and_then(|(factor, name)| Some((number(factor)?, name)));
                let (factor, name) = scaled.unwrap_or((1.0, word));
                all.push((sign * factor, name));
                sign = 1.0;
            }
        }
    }
    all
}

/// `0.5`, `1/27`, `-3`.
fn number(text: &str) -> Option<f64> {
    let (top, bottom) = text.split_once('/').unwrap_or((text, "1"));
    let value = top.parse::<f64>().ok()? / bottom.parse::<f64>().ok()?;
    value.is_finite().then_some(value)
}

/// The deformation of a branch is an angle: of a shaft, coupling or damper, or a support against turning.
pub fn is_rotational(machine: &Machine, branch: usize) -> bool {
    let branch = &machine.branches[branch];
    let alone = |&(dof, _): &(usize, f64)| machine.dofs[dof].axis.is_rotation();
    match machine.elements[branch.element].kind {
        "gear_pair" | "worm_pair" | "planetary" | "belt" | "screw" => false,
        _ => branch.direction.terms.iter().all(alone),
    }
}

fn force_unit(turns: bool) -> &'static str {
    if turns { "N·m" } else { "N" }
}

fn displacement_unit(turns: bool) -> &'static str {
    if turns { "rad" } else { "m" }
}

fn rate_unit(turns: bool, times: u8) -> &'static str {
    match (turns, times) {
        (true, 0) => "rad",
        (true, 1) => "rad/s",
        (true, _) => "rad/s²",
        (false, 0) => "m",
        (false, 1) => "m/s",
        (false, _) => "m/s²",
    }
}
