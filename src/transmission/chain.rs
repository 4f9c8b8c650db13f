//! The chain between a driver and an output: `θ_out = i θ_driver + Σ T_b e_b`, by whole numbers of teeth.
//!
//! Every joint is taken as rigid, `wᵀq = e`. The ratios are exact fractions; so is `T_b` but for the size of its branch. Where joints
//! close a loop, their e must fit: what they must satisfy, `Σ c_b e_b = 0`, comes out of the same elimination.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::direction::Direction;
use crate::machine::kinematics::contradictory_loop;
use crate::machine::operating::{ContactState, Operating};
use crate::machine::parts::{Law, Machine};
use crate::modes::orders::stated_joints;
use crate::numeric::exact::Constraints;
use crate::numeric::fraction::Fraction;

/// What is looked at: an output alone, or against where a second one says it should be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ends {
    /// The freedom whose angle is prescribed.
    pub driver: usize,
    /// The freedom whose error is wanted: an angle, or the travel of a slide.
    pub output: usize,
    /// The freedom it should turn with.
    pub against: Option<usize>,
}

/// A chain.
#[derive(Debug, Clone)]
pub struct Chain {
    /// Its ends.
    pub ends: Ends,
    /// The angle orders are counted by: the output's, of a slide that of the screw that moves it.
    pub per: usize,
    /// Freedoms that do not err: the driver, and of a machine with several independent motions those with stated speeds.
    pub held: Vec<usize>,
    /// `Σ a q` whose deviation is the error: the output, less the ratio times the other end.
    pub combination: Vec<(usize, f64)>,
    /// Motion of every freedom per angle of `per`; absent where it does not follow from the driver's.
    turns: Vec<Option<Fraction>>,
    /// `T_b`, by branch; of those alone that carry an error.
    transmission: Vec<(usize, f64)>,
    /// What errors in loops must satisfy: `Σ c e = 0`.
    pub conditions: Vec<Vec<(usize, f64)>>,
}

/// The direction of a branch on the flank that carries; absent where it is open.
pub fn carried<'a>(
    machine: &'a Machine,
    operating: &Operating,
    branch: usize,
) -> Option<&'a Direction> {
    let part = &machine.branches[branch];
    if matches!(part.law, Law::Linear { stiffness, .. } if stiffness == 0.0) {
        return None;
    }
    match (operating.state(branch), &part.coast) {
        (ContactState::Open, _) => None,
        (ContactState::Coast, Some(coast)) => Some(coast),
        _ => Some(&part.direction),
    }
}

impl Chain {
    /// Solves the joints.
    ///
    /// # Errors
    /// An end that does not turn with the driver, or whose ratio no fraction gives; an open contact on the way.
    pub fn new(machine: &Machine, operating: &Operating, ends: Ends) -> Result<Chain, Error> {
        let n = machine.freedoms.len();
        for freedom in [Some(ends.driver), Some(ends.output), ends.against]
            .into_iter()
            .flatten()
        {
            let may_slide = freedom != ends.driver && machine.slides(freedom);
            if !machine.freedoms[freedom].axis.turns() && !may_slide {
                let message = format!("{} is no angle", machine.freedom_name(freedom));
                return Err(Error::new(Code::NoSuchFreedom, message)
                    .hint("transmission errors are of angles, and of slides that screws move: name a node"));
            }
        }
        if ends.output == ends.driver || ends.against == Some(ends.output) {
            let message = format!(
                "{} has no error against itself",
                machine.freedom_name(ends.output)
            );
            return Err(Error::new(Code::Conflict, message)
                .hint("name another node as the driver, or as the one it should turn with"));
        }
        let turning = stated_joints(machine, ends.driver);
        let per = counted_by(machine, ends.output)?;
        let turns: Vec<Option<Fraction>> = (0..n).map(|i| turning.fraction(i, per)).collect();
        let moves = |freedom: usize| turns[freedom].as_ref().filter(|t| !t.is_zero());
        for freedom in [Some(ends.driver), ends.against].into_iter().flatten() {
            if moves(freedom).is_none() {
                return Err(apart(machine, operating, ends.output, freedom));
            }
        }
        let Some(output) = moves(ends.output) else {
            return Err(apart(machine, operating, ends.output, ends.driver));
        };
        let mut combination = vec![(ends.output, 1.0)];
        if let Some((against, turns)) = ends.against.and_then(|a| Some((a, moves(a)?))) {
            combination.push((against, -(output / turns).value()));
        }
        let mut chain = Chain {
            ends,
            per,
            held: vec![ends.driver],
            combination,
            turns,
            transmission: Vec::new(),
            conditions: Vec::new(),
        };
        chain.transmit(machine, operating)?;
        Ok(chain)
    }

    /// Motion of a freedom per angle of `per`, with its sign; absent where it does not follow.
    pub fn turns(&self, freedom: usize) -> Option<&Fraction> {
        self.turns[freedom].as_ref()
    }

    /// `T_b`: motion of the output, positive in the sense it goes while the driver turns forward, per displacement of a branch.
    pub fn transmission(&self, branch: usize) -> f64 {
        (self.transmission.iter().find(|t| t.0 == branch)).map_or(0.0, |t| t.1)
    }

    /// +1 where the output goes forward with the driver, −1 where backward.
    pub fn sense(&self) -> f64 {
        self.forward() * self.sign(self.ends.output)
    }

    /// The same of `per`.
    pub fn forward(&self) -> f64 {
        self.sign(self.ends.driver)
    }

    fn sign(&self, freedom: usize) -> f64 {
        let backward = (self.turns[freedom].as_ref()).is_some_and(Fraction::is_negative);
        if backward { -1.0 } else { 1.0 }
    }

    fn transmit(&mut self, machine: &Machine, operating: &Operating) -> Result<(), Error> {
        let n = machine.freedoms.len();
        let mut carriers: Vec<usize> = Vec::new();
        for act in machine.errors.iter().flat_map(|error| &error.acts) {
            if !carriers.contains(&act.branch) && carried(machine, operating, act.branch).is_some()
            {
                carriers.push(act.branch);
            }
        }
        let mut joints = Constraints::with_given(n, carriers.len());
        // Short rows first: what ground holds drops out before meshes are looked at.
        let mut rows: Vec<(usize, &Direction)> = (0..machine.branches.len())
            .filter_map(|b| Some((b, carried(machine, operating, b)?)))
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
        for &(freedom, _) in &machine.speeds {
            if joints.combination(freedom).iter().any(|t| t.0 < n) {
                joints.impose(&[(freedom, 1.0)]);
                self.held.push(freedom);
            }
        }
        let mut sum = vec![0.0; carriers.len()];
        for &(freedom, a) in &self.combination {
            for (j, b) in joints.combination(freedom) {
                if j < n {
                    return Err(apart(machine, operating, freedom, self.ends.driver));
                }
                sum[j - n] += a * b;
            }
        }
        let scale = |at: usize| {
            carried(machine, operating, carriers[at]).map_or(1.0, |direction| direction.scale)
        };
        let sense = self.sense();
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
                self.conditions.push(row.collect());
            }
        }
        Ok(())
    }
}

/// The angle that orders at an end are counted by.
fn counted_by(machine: &Machine, output: usize) -> Result<usize, Error> {
    if machine.freedoms[output].axis.turns() {
        return Ok(output);
    }
    let moved_by = machine.branches.iter().find(|branch| {
        let kind = machine.elements[branch.element].kind;
        kind == "screw" && branch.direction.terms.iter().any(|t| t.0 == output)
    });
    let terms = moved_by.map_or(&[][..], |branch| &branch.direction.terms);
    let turning = (terms.iter()).find(|t| machine.freedoms[t.0].axis.turns());
    turning.map(|t| t.0).ok_or_else(|| {
        let message = format!("no screw moves {}", machine.freedom_name(output));
        Error::new(Code::NoSpeed, message).hint("join it to what turns by a [[screw]]")
    })
}

/// An end that does not turn with another.
fn apart(machine: &Machine, operating: &Operating, one: usize, other: usize) -> Error {
    let [one, other] = [one, other].map(|freedom| machine.freedom_name(freedom));
    let open = (operating.contacts.iter()).find(|contact| contact.1 == ContactState::Open);
    if open.is_none() {
        let joints: Vec<(usize, &[(usize, f64)])> = (0..machine.branches.len())
            .filter_map(|b| Some((b, carried(machine, operating, b)?.terms.as_slice())))
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
            "one of them is held or free, or several motions are open: state in [speed] the speeds of all that turn independently; 0 rpm where it stands",
        ),
    };
    Error::new(Code::NoSpeed, message).hint(hint)
}
