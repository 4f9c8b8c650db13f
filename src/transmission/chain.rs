//! Transmission chain from driver to output, `θ_out = i θ_driver + Σ T_b e_b`.
//!
//! Every joint is taken as rigid, `wᵀq = e`. The ratios are exact fractions; so is `T_b` but for the size of its branch. Where joints
//! close a loop, their e must fit: what they must satisfy, `Σ c_b e_b = 0`, comes out of the same elimination.

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
    /// The degree of freedom whose angle is prescribed.
    pub driver: usize,
    /// The degree of freedom whose error is wanted: an angle, or the travel of a slide.
    pub output: usize,
    /// The degree of freedom it should turn with.
    pub relative_to: Option<usize>,
}

/// A train from a driven end to an output, with the ratio between them.
#[derive(Debug, Clone)]
pub struct TransmissionChain {
    /// Ends of the chain.
    pub ends: ChainEnds,
    /// The angle orders are counted by: the output's, of a slide that of the screw that moves it.
    pub order_reference: usize,
    /// Degrees of freedom that do not err: the driver, and of a machine with several independent motions those with stated
    /// speeds.
    pub fixed: Vec<usize>,
    /// `Σ a q` whose deviation is the error: the output, less the ratio times the other end.
    pub combination: Vec<(usize, f64)>,
    /// Motion of every degree of freedom per angle of `order_reference`; absent where it does not follow from the driver's.
    turns: Vec<Option<Fraction>>,
    /// `T_b`, by branch; of those alone that carry an error.
    transmission: Vec<(usize, f64)>,
    /// Compatibility conditions on errors in loops: `Σ c e = 0`.
    pub loop_conditions: Vec<Vec<(usize, f64)>>,
}

/// The direction of a branch on the flank that carries; absent where it is open.
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
    /// Solves the joints.
    ///
    /// # Errors
    /// An end that does not turn with the driver, or whose ratio no fraction gives; an open contact on the way.
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
            let may_slide = dof != ends.driver && machine.is_slide(dof);
            if !machine.dofs[dof].axis.is_rotation() && !may_slide {
                let message = format!("{} is no angle", machine.dof_name(dof));
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
        let turning = speed_constraints(machine, ends.driver);
        let per = order_reference(machine, ends.output)?;
        let turns: Vec<Option<Fraction>> = (0..n).map(|i| turning.exact_ratio(i, per)).collect();
        let moves = |dof: usize| turns[dof].as_ref().filter(|t| !t.is_zero());
        for dof in [Some(ends.driver), ends.relative_to].into_iter().flatten() {
            if moves(dof).is_none() {
                return Err(not_coupled_error(machine, operating, ends.output, dof));
            }
        }
        let Some(output) = moves(ends.output) else {
            return Err(not_coupled_error(
                machine,
                operating,
                ends.output,
                ends.driver,
            ));
        };
        let mut combination = vec![(ends.output, 1.0)];
        if let Some((against, turns)) = ends.relative_to.and_then(|a| Some((a, moves(a)?))) {
            combination.push((against, -(output / turns).to_f64()));
        }
        let mut chain = TransmissionChain {
            ends,
            order_reference: per,
            fixed: vec![ends.driver],
            combination,
            turns,
            transmission: Vec::new(),
            loop_conditions: Vec::new(),
        };
        chain.solve_transmission(machine, operating)?;
        Ok(chain)
    }

    /// Motion of a degree of freedom per angle of `order_reference`, with its sign; absent where it does not follow.
    pub fn ratio(&self, dof: usize) -> Option<&Fraction> {
        self.turns[dof].as_ref()
    }

    /// `T_b`: motion of the output, positive in the sense it goes while the driver turns forward, per displacement of a branch.
    pub fn transmission(&self, branch: usize) -> f64 {
        (self.transmission.iter().find(|t| t.0 == branch)).map_or(0.0, |t| t.1)
    }

    /// +1 where the output goes forward with the driver, −1 where backward.
    pub fn output_sense(&self) -> f64 {
        self.reference_sense() * self.sign(self.ends.output)
    }

    /// The same of `order_reference`.
    pub fn reference_sense(&self) -> f64 {
        self.sign(self.ends.driver)
    }

    fn sign(&self, dof: usize) -> f64 {
        let backward = (self.turns[dof].as_ref()).is_some_and(Fraction::is_negative);
        if backward { -1.0 } else { 1.0 }
    }

    fn solve_transmission(
        &mut self,
        machine: &Machine,
        operating: &OperatingPoint,
    ) -> Result<(), Error> {
        let n = machine.dofs.len();
        let mut carriers: Vec<usize> = Vec::new();
        for act in machine.errors.iter().flat_map(|error| &error.acts) {
            if !carriers.contains(&act.branch)
                && carrying_direction(machine, operating, act.branch).is_some()
            {
                carriers.push(act.branch);
            }
        }
        let mut joints = ExactConstraints::with_prescribed(n, carriers.len());
        // Short rows first: what ground holds drops out before meshes are looked at.
        let mut rows: Vec<(usize, &Direction)> = (0..machine.branches.len())
            .filter_map(|b| Some((b, carrying_direction(machine, operating, b)?)))
            .collect();
        rows.sort_by_key(|(_, direction)| direction.terms.len());
        for (branch, direction) in &rows {
            let mut row = direction.terms.clone();
            if let Some(at) = carriers.iter().position(|c| c == branch) {
                row.push((n + at, -1.0));
            }
            joints.impose(&row);
        }
        joints.impose(&[(self.ends.driver, 1.0)]);
        // What still turns freely goes as its stated speed says.
        for &(dof, _) in &machine.speeds {
            if joints.combination(dof).iter().any(|t| t.0 < n) {
                joints.impose(&[(dof, 1.0)]);
                self.fixed.push(dof);
            }
        }
        let mut sum = vec![0.0; carriers.len()];
        for &(dof, a) in &self.combination {
            for (j, b) in joints.combination(dof) {
                if j < n {
                    return Err(not_coupled_error(machine, operating, dof, self.ends.driver));
                }
                sum[j - n] += a * b;
            }
        }
        let scale = |at: usize| {
            carrying_direction(machine, operating, carriers[at])
                .map_or(1.0, |direction| direction.scale)
        };
        let sense = self.output_sense();
        // Of a relative error the paths common to both ends cancel to rounding.
        let largest = sum.iter().fold(0.0f64, |m, t| m.max(t.abs()));
        self.transmission = (0..carriers.len())
            .filter(|&at| sum[at].abs() > 1e-13 * largest)
            .map(|at| (carriers[at], sense * sum[at] / scale(at)))
            .collect();
        for at in 0..carriers.len() {
            let made_of = joints.combination(n + at);
            if made_of != [(n + at, 1.0)] {
                let others = made_of
                    .iter()
                    .map(|&(j, a)| (carriers[j - n], -a / scale(j - n)));
                let row = std::iter::once((carriers[at], 1.0 / scale(at))).chain(others);
                self.loop_conditions.push(row.collect());
            }
        }
        Ok(())
    }
}

/// The angle that orders at an end are counted by.
fn order_reference(machine: &Machine, output: usize) -> Result<usize, Error> {
    if machine.dofs[output].axis.is_rotation() {
        return Ok(output);
    }
    let moved_by = machine.branches.iter().find(|branch| {
        let kind = machine.elements[branch.element].kind;
        kind == "screw" && branch.direction.terms.iter().any(|t| t.0 == output)
    });
    let terms = moved_by.map_or(&[][..], |branch| &branch.direction.terms);
    let turning = (terms.iter()).find(|t| machine.dofs[t.0].axis.is_rotation());
    turning.map(|t| t.0).ok_or_else(|| {
        let message = format!("no screw moves {}", machine.dof_name(output));
        Error::new(Code::UndeterminedSpeed, message)
            .with_hint("join it to what turns by a [[screw]]")
    })
}

/// An end that does not turn with another.
fn not_coupled_error(
    machine: &Machine,
    operating: &OperatingPoint,
    one: usize,
    other: usize,
) -> Error {
    let [one, other] = [one, other].map(|dof| machine.dof_name(dof));
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
                "{one} does not turn with {other}: {} is open under the mean loads",
                machine.branch_name(branch)
            ),
            "state loads that close it",
        ),
        None => (
            format!("{one} and {other} do not turn in a ratio of whole numbers"),
            "one of them is held or free, or several motions are open: state in [speed] the speeds of all that turn independently; 0 rpm where it does not turn",
        ),
    };
    Error::new(Code::UndeterminedSpeed, message).with_hint(hint)
}
