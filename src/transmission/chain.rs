//! Transmission chain from driver to output, `θ_out = i θ_driver + Σ T_b e_b`.
//!
//! Every joint is rigid, `wᵀq = e`. The ratios are exact fractions, and so is `T_b` except for the scale of its branch. In a closed
//! loop the e must be compatible: the conditions `Σ c_b e_b = 0` follow from the same elimination.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::components::{BranchLaw, Machine};
use crate::machine::direction::Direction;
use crate::machine::kinematics::contradictory_loop;
use crate::machine::operating_point::{ActiveFlank, OperatingPoint};
use crate::modes::excitation_orders::speed_constraints;
use crate::numeric::exact_constraints::ExactConstraints;
use crate::numeric::fraction::Fraction;

/// Ends of a transmission chain: an output alone, or relative to its ideal position from a second degree of freedom.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChainEnds {
    /// Degree of freedom whose angle is prescribed.
    pub driver: usize,
    /// Degree of freedom whose error is computed: an angle, or the travel of a slide.
    pub output: usize,
    /// Degree of freedom with which the output should turn.
    pub relative_to: Option<usize>,
}

/// Transmission chain from a driver to an output, with the ratio between them.
#[derive(Debug, Clone)]
pub struct TransmissionChain {
    /// Ends of the chain.
    pub ends: ChainEnds,
    /// Degree of freedom whose revolutions count the orders: the output, of a slide the screw that moves it.
    pub order_reference: usize,
    /// Degrees of freedom without error: the driver, and those with stated speeds if the machine has several independent
    /// motions.
    pub fixed: Vec<usize>,
    /// Sum `Σ a q` whose deviation is the error: the output less the ratio times the other end.
    pub combination: Vec<(usize, f64)>,
    /// Motion of every degree of freedom per angle of `order_reference`; absent if the driver does not determine it.
    ratios: Vec<Option<Fraction>>,
    /// Transmission factor `T_b` by branch, only of branches with an error.
    transmission: Vec<(usize, f64)>,
    /// Compatibility conditions on errors in loops: `Σ c e = 0`.
    pub loop_conditions: Vec<Vec<(usize, f64)>>,
}

/// Direction of a branch on its loaded flank; absent if the contact is open or the stiffness is zero.
pub fn carrying_direction<'a>(
    machine: &'a Machine,
    operating: &OperatingPoint,
    branch: usize,
) -> Option<&'a Direction> {
    let part = &machine.branches[branch];
    if matches!(part.law, BranchLaw::Linear { stiffness, .. } if stiffness == 0.0) {
        return None;
    }
    match (operating.state(branch), &part.coast) {
        (ActiveFlank::Open, _) => None,
        (ActiveFlank::Coast, Some(coast)) => Some(coast),
        _ => Some(&part.direction),
    }
}

impl TransmissionChain {
    /// Solves the rigid joints.
    ///
    /// # Errors
    /// An end that does not turn with the driver, or has no rational ratio to it; an open contact in the chain.
    pub fn new(
        machine: &Machine,
        operating: &OperatingPoint,
        ends: ChainEnds,
    ) -> Result<TransmissionChain, Error> {
        let n = machine.dofs.len();
        for dof in [Some(ends.driver), Some(ends.output), ends.relative_to]
            .into_iter()
            .flatten()
        {
            let is_slide = dof != ends.driver && machine.is_slide(dof);
            if !machine.dofs[dof].axis.is_rotation() && !is_slide {
                let message = format!("{} is not an angle", machine.dof_name(dof));
                return Err(Error::new(Code::UnknownDof, message)
                    .with_hint("transmission errors are of angles, and of slides that screws move: name a node"));
            }
        }
        if ends.output == ends.driver || ends.relative_to == Some(ends.output) {
            let message = format!(
                "{} has no error against itself",
                machine.dof_name(ends.output)
            );
            return Err(Error::new(Code::Conflict, message)
                .with_hint("name another node as the driver, or as the one it should turn with"));
        }
        let joints = speed_constraints(machine, ends.driver);
        let base = order_reference(machine, ends.output)?;
        let ratios: Vec<Option<Fraction>> = (0..n).map(|i| joints.exact_ratio(i, base)).collect();
        let motion = |dof: usize| ratios[dof].as_ref().filter(|t| !t.is_zero());
        for dof in [Some(ends.driver), ends.relative_to].into_iter().flatten() {
            if motion(dof).is_none() {
                return Err(not_coupled_error(machine, operating, ends.output, dof));
            }
        }
        let Some(output) = motion(ends.output) else {
            return Err(not_coupled_error(
                machine,
                operating,
                ends.output,
                ends.driver,
            ));
        };
        let mut combination = vec![(ends.output, 1.0)];
        if let Some((other, ratio)) = ends.relative_to.and_then(|a| Some((a, motion(a)?))) {
            combination.push((other, -(output / ratio).to_f64()));
        }
        let mut chain = TransmissionChain {
            ends,
            order_reference: base,
            fixed: vec![ends.driver],
            combination,
            ratios,
            transmission: Vec::new(),
            loop_conditions: Vec::new(),
        };
        chain.solve_transmission(machine, operating)?;
        Ok(chain)
    }

    /// Motion of a degree of freedom per angle of `order_reference`, with its sign; absent if the driver does not determine it.
    pub fn ratio(&self, dof: usize) -> Option<&Fraction> {
        self.ratios[dof].as_ref()
    }

    /// Transmission factor `T_b`: motion of the output per displacement of a branch, positive in the sense of forward driver rotation.
    pub fn transmission(&self, branch: usize) -> f64 {
        (self.transmission.iter().find(|t| t.0 == branch)).map_or(0.0, |t| t.1)
    }

    /// +1 if the output moves forward when the driver does, −1 if backward.
    pub fn output_sense(&self) -> f64 {
        self.reference_sense() * self.sign(self.ends.output)
    }

    /// +1 if `order_reference` turns forward when the driver does, −1 if backward.
    pub fn reference_sense(&self) -> f64 {
        self.sign(self.ends.driver)
    }

    fn sign(&self, dof: usize) -> f64 {
        let backward = (self.ratios[dof].as_ref()).is_some_and(Fraction::is_negative);
        if backward { -1.0 } else { 1.0 }
    }

    fn solve_transmission(
        &mut self,
        machine: &Machine,
        operating: &OperatingPoint,
    ) -> Result<(), Error> {
        let n = machine.dofs.len();
        let mut sources: Vec<usize> = Vec::new();
        for act in machine.errors.iter().flat_map(|error| &error.acts) {
            if !sources.contains(&act.branch)
                && carrying_direction(machine, operating, act.branch).is_some()
            {
                sources.push(act.branch);
            }
        }
        let mut joints = ExactConstraints::with_prescribed(n, sources.len());
        // Short rows first: grounded degrees of freedom are eliminated before the meshes.
        let mut rows: Vec<(usize, &Direction)> = (0..machine.branches.len())
            .filter_map(|b| Some((b, carrying_direction(machine, operating, b)?)))
            .collect();
        rows.sort_by_key(|(_, direction)| direction.terms.len());
        for (branch, direction) in &rows {
            let mut row = direction.terms.clone();
            if let Some(k) = sources.iter().position(|c| c == branch) {
                row.push((n + k, -1.0));
            }
            joints.impose(&row);
        }
        joints.impose(&[(self.ends.driver, 1.0)]);
        // A degree of freedom that is still free follows its stated speed.
        for &(dof, _) in &machine.speeds {
            if joints.combination(dof).iter().any(|t| t.0 < n) {
                joints.impose(&[(dof, 1.0)]);
                self.fixed.push(dof);
            }
        }
        let mut sum = vec![0.0; sources.len()];
        for &(dof, a) in &self.combination {
            for (j, b) in joints.combination(dof) {
                if j < n {
                    return Err(not_coupled_error(machine, operating, dof, self.ends.driver));
                }
                sum[j - n] += a * b;
            }
        }
        let scale = |k: usize| {
            carrying_direction(machine, operating, sources[k])
                .map_or(1.0, |direction| direction.scale)
        };
        let sense = self.output_sense();
        // In a relative error the paths common to both ends cancel to rounding.
        let largest = sum.iter().fold(0.0f64, |m, t| m.max(t.abs()));
        self.transmission = (0..sources.len())
            .filter(|&k| sum[k].abs() > 1e-13 * largest)
            .map(|k| (sources[k], sense * sum[k] / scale(k)))
            .collect();
        for k in 0..sources.len() {
            let combination = joints.combination(n + k);
            if combination != [(n + k, 1.0)] {
                let others = combination
                    .iter()
                    .map(|&(j, a)| (sources[j - n], -a / scale(j - n)));
                let row = std::iter::once((sources[k], 1.0 / scale(k))).chain(others);
                self.loop_conditions.push(row.collect());
            }
        }
        Ok(())
    }
}

/// Degree of freedom whose revolutions count the orders of an output.
fn order_reference(machine: &Machine, output: usize) -> Result<usize, Error> {
    if machine.dofs[output].axis.is_rotation() {
        return Ok(output);
    }
    let screw = machine.branches.iter().find(|branch| {
        let kind = machine.elements[branch.element].kind;
        kind == "screw" && branch.direction.terms.iter().any(|t| t.0 == output)
    });
    let terms = screw.map_or(&[][..], |branch| &branch.direction.terms);
    let rotation = (terms.iter()).find(|t| machine.dofs[t.0].axis.is_rotation());
    rotation.map(|t| t.0).ok_or_else(|| {
        let message = format!("no screw moves {}", machine.dof_name(output));
        Error::new(Code::UndeterminedSpeed, message)
            .with_hint("join it to what turns by a [[screw]]")
    })
}

/// Error for an end that does not turn with another.
fn not_coupled_error(
    machine: &Machine,
    operating: &OperatingPoint,
    first: usize,
    second: usize,
) -> Error {
    let [first, second] = [first, second].map(|dof| machine.dof_name(dof));
    let open = (operating.contacts.iter()).find(|contact| contact.1 == ActiveFlank::Open);
    if open.is_none() {
        let joints: Vec<(usize, &[(usize, f64)])> = (0..machine.branches.len())
            .filter_map(|b| {
                Some((
                    b,
                    carrying_direction(machine, operating, b)?.terms.as_slice(),
                ))
            })
            .collect();
        if let Some(error) = contradictory_loop(machine, &joints) {
            return error;
        }
    }
    let (message, hint) = match open {
        Some(&(branch, ..)) => (
            format!(
                "{first} does not turn with {second}: {} is open under the mean loads",
                machine.branch_name(branch)
            ),
            "state loads that close it",
        ),
        None => (
            format!("{first} and {second} do not turn in a ratio of whole numbers"),
            "one of them is held or free, or several motions are open: state in [speed] the speeds of all that turn independently; 0 rpm where it does not turn",
        ),
    };
    Error::new(Code::UndeterminedSpeed, message).with_hint(hint)
}
