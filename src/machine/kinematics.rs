//! Rigid joints eliminated in exact fractions; rigid-body motions and mean speeds.

use std::collections::{BTreeMap, HashMap};

use super::components::{Branch, BranchLaw, Machine};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::exact_constraints::{ConstraintEffect, ExactConstraints};
use crate::numeric::fraction::Fraction;
use crate::scene::model::Axis;

/// The machine's rigid joints, solved.
#[derive(Debug, Clone)]
pub struct Kinematics {
    constraints: ExactConstraints,
    /// Degrees of freedom that stay, in order.
    pub independent_dofs: Vec<usize>,
    number: HashMap<usize, usize>,
}

impl Kinematics {
    /// Solves every rigid joint.
    ///
    /// # Errors
    /// Ratios that contradict each other round a loop, naming the loop and the mismatch.
    pub fn new(machine: &Machine) -> Result<Kinematics, Error> {
        let mut constraints = ExactConstraints::new(machine.dofs.len());
        for (index, branch) in machine.branches.iter().enumerate() {
            if branch.law != BranchLaw::Rigid {
                continue;
            }
            let row = &branch.direction.terms;
            let grounded = row.len() == 1 || row.iter().any(|&(i, _)| constraints.is_zero(i));
            let before = (!grounded).then(|| constraints.clone());
            if let (ConstraintEffect::Zeroed(_), Some(before)) = (constraints.impose(row), before) {
                let rigid = |branch: &Branch| branch.law == BranchLaw::Rigid;
                let error = contradiction(machine, index, row, &before, &rigid);
                return Err(error.with_hint(
                    "mend the tooth numbers, or give one pair of the loop a stiffness k",
                ));
            }
        }
        let free = constraints.free();
        let number = free.iter().enumerate().map(|(p, &q)| (q, p)).collect();
        Ok(Kinematics {
            constraints,
            independent_dofs: free,
            number,
        })
    }

    /// A row over all degrees of freedom in the degrees of freedom that stay.
    pub fn reduce_row(&self, row: &[(usize, f64)]) -> Vec<(usize, f64)> {
        self.constraints
            .reduce_row(row)
            .into_iter()
            .map(|(q, a)| (self.number[&q], a))
            .collect()
    }

    /// A degree of freedom in the degrees of freedom that stay.
    pub fn in_independent_dofs(&self, dof: usize) -> Vec<(usize, f64)> {
        self.constraints
            .combination(dof)
            .into_iter()
            .map(|(q, a)| (self.number[&q], a))
            .collect()
    }

    /// The motions over all degrees of freedom that deform none of `branches`.
    pub fn undeformed_motions<'a>(
        &self,
        branches: impl Iterator<Item = &'a Branch>,
    ) -> RigidMotions {
        self.null_space(branches.map(|branch| branch.direction.terms.as_slice()))
    }

    /// The motions over all degrees of freedom that leave every row, `Σ coefficient · q`, at zero.
    pub fn null_space<'a>(&self, rows: impl Iterator<Item = &'a [(usize, f64)]>) -> RigidMotions {
        let mut constraints = self.constraints.clone();
        // Short rows first: what ground holds drops out before meshes are looked at.
        let mut rows: Vec<&[(usize, f64)]> = rows.collect();
        rows.sort_by_key(|row| row.len());
        for row in rows {
            constraints.impose(row);
        }
        RigidMotions {
            free: constraints.free(),
            constraints,
        }
    }
}

/// Motions that deform nothing, in exact fractions.
#[derive(Debug, Clone)]
pub struct RigidMotions {
    constraints: ExactConstraints,
    /// One degree of freedom a motion: the one that is 1 in it and 0 in the others.
    pub free: Vec<usize>,
}

impl RigidMotions {
    /// The motions, each over all `n` degrees of freedom.
    pub fn basis(&self, n: usize) -> Vec<Vec<f64>> {
        let at: HashMap<usize, usize> =
            self.free.iter().enumerate().map(|(k, &j)| (j, k)).collect();
        let mut basis = vec![vec![0.0; n]; self.free.len()];
        for i in 0..n {
            for (j, a) in self.constraints.combination(i) {
                basis[at[&j]][i] = a;
            }
        }
        basis
    }

    /// The exact ratio of two degrees of freedom, such as `-37/12`, where one motion moves both and no other does.
    pub fn ratio(&self, of: usize, to: usize) -> Option<String> {
        self.constraints.ratio_text(of, to)
    }

    /// The speeds of all degrees of freedom that follow from stated ones.
    ///
    /// # Errors
    /// See [`SpeedError`].
    pub fn speeds(&self, n: usize, stated: &[(usize, f64)]) -> Result<Vec<f64>, SpeedError> {
        let fastest = stated.iter().fold(0.0f64, |m, s| m.max(s.1.abs()));
        let mut solved: Vec<ReducedRow> = Vec::new();
        for &(dof, speed) in stated {
            let mut row = ReducedRow {
                terms: self.constraints.combination(dof).into_iter().collect(),
                value: speed,
                pivot: dof,
            };
            let size = row.size();
            solved.iter().for_each(|other| row.take_out(other));
            // Coefficients are fractions of tooth numbers: what cancels leaves rounding.
            let lead = row
                .terms
                .iter()
                .map(|(&j, &a)| (j, a))
                .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
            let Some((pivot, a)) = lead.filter(|(_, a)| a.abs() > 1e-12 * size) else {
                if row.value.abs() <= 1e-9 * fastest {
                    continue;
                }
                let implied = speed - row.value;
                return Err(SpeedError::Contradiction {
                    dof,
                    speed,
                    implied,
                });
            };
            row.terms.values_mut().for_each(|b| *b /= a);
            row.value /= a;
            row.pivot = pivot;
            solved.iter_mut().for_each(|other| other.take_out(&row));
            solved.push(row);
        }
        let known: HashMap<usize, f64> = solved
            .iter()
            .filter(|row| row.terms.len() == 1)
            .map(|row| (row.pivot, row.value))
            .collect();
        let speed_of = |i: usize| -> Option<f64> {
            self.constraints
                .combination(i)
                .iter()
                .map(|(j, a)| known.get(j).map(|x| a * x))
                .sum()
        };
        let all = (0..n).map(|i| speed_of(i).ok_or(SpeedError::Undetermined(i)));
        all.collect()
    }
}

/// A number to nine digits.
fn rounded(x: f64) -> f64 {
    let scale = 10f64.powf(8.0 - x.abs().max(1e-12).log10().floor());
    (x * scale).round() / scale
}

/// Speeds that stated ones do not give.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SpeedError {
    /// The stated speeds do not determine that of this degree of freedom.
    Undetermined(usize),
    /// A stated speed contradicts those stated before it.
    Contradiction {
        /// The degree of freedom.
        dof: usize,
        /// The stated speed, rad/s.
        speed: f64,
        /// The speed that follows from the others, rad/s.
        implied: f64,
    },
}

/// `x_pivot + Σ a x = value`, of a system brought to reduced form.
struct ReducedRow {
    pivot: usize,
    terms: BTreeMap<usize, f64>,
    value: f64,
}

impl ReducedRow {
    fn size(&self) -> f64 {
        self.terms.values().fold(0.0, |m, a| m.max(a.abs()))
    }

    /// Subtracts what the other row says of its pivot.
    fn take_out(&mut self, other: &ReducedRow) {
        let Some(share) = self.terms.remove(&other.pivot) else {
            return;
        };
        let size = self.size();
        for (&j, a) in other.terms.iter().filter(|(j, _)| **j != other.pivot) {
            *self.terms.entry(j).or_insert(0.0) -= share * a;
        }
        self.terms
            .retain(|_, a| a.abs() > 1e-12 * size.max(share.abs()));
        self.value -= share * other.value;
    }
}

/// The first joint, rigid or elastic, that closes a loop by another ratio than the joints before it: such a loop does not turn.
/// `joints`: branches with their directions.
pub fn contradictory_loop(machine: &Machine, joints: &[(usize, &[(usize, f64)])]) -> Option<Error> {
    let mut constraints = ExactConstraints::new(machine.dofs.len());
    for &(index, row) in joints {
        let grounded = row.len() == 1 || row.iter().any(|&(i, _)| constraints.is_zero(i));
        let before = (!grounded).then(|| constraints.clone());
        if let (ConstraintEffect::Zeroed(_), Some(before)) = (constraints.impose(row), before) {
            let all = |branch: &Branch| match branch.law {
                BranchLaw::Rigid => true,
                BranchLaw::Linear { stiffness, .. } => stiffness != 0.0,
            };
            let error = contradiction(machine, index, row, &before, &all);
            return Some(error.with_hint(
                "mend the tooth numbers: however its joints yield, a loop whose ratios differ does not turn",
            ));
        }
    }
    None
}

/// Names the loop that a joint closes wrongly, and both ratios.
fn contradiction(
    machine: &Machine,
    index: usize,
    row: &[(usize, f64)],
    before: &ExactConstraints,
    joins: &dyn Fn(&Branch) -> bool,
) -> Error {
    let branch = &machine.branches[index];
    let name = &machine.elements[branch.element].name;
    let message = match ratios(row, before) {
        Some((a, b, own, others)) => {
            let path = shortest_path(machine, index, a, b, joins);
            let through = if path.is_empty() {
                String::new()
            } else {
                format!(" through {}", path.join(", "))
            };
            format!(
                "ratios contradict each other: the loop{through} turns {} by {others} per turn of {}, `{name}` by {own}",
                machine.dof_name(b),
                machine.dof_name(a),
            )
        }
        None => format!("`{name}` closes a loop of joints that then cannot turn at all"),
    };
    Error::new(Code::ContradictoryRatios, message).with_span(&machine.elements[branch.element].span)
}

/// Two degrees of freedom of a joint, the ratio of the second to the first by this joint, and by those before it.
fn ratios(
    row: &[(usize, f64)],
    before: &ExactConstraints,
) -> Option<(usize, usize, Fraction, Fraction)> {
    let moves = |t: &&(usize, f64)| t.1 != 0.0 && !before.is_zero(t.0);
    let &(a, _) = row.iter().find(moves)?;
    let &(b, lead) = row.iter().rev().find(moves).filter(|t| t.0 != a)?;
    let others = before.exact_ratio(b, a)?;
    let mut sum = Fraction::zero();
    for &(other, share) in row.iter().filter(|t| t.0 != b) {
        sum = &sum + &(&Fraction::from_f64(share) * &before.exact_ratio(other, a)?);
    }
    let own = &(&Fraction::zero() - &sum) / &Fraction::from_f64(lead);
    Some((a, b, own, others))
}

/// Names of the elements on the shortest way from `a` to `b` that come before branch `last`.
fn shortest_path(
    machine: &Machine,
    last: usize,
    a: usize,
    b: usize,
    joins: &dyn Fn(&Branch) -> bool,
) -> Vec<String> {
    let mut edges: Vec<(usize, usize, usize)> = Vec::new();
    let others = machine.branches.iter().enumerate();
    for (_, branch) in others.filter(|(k, branch)| *k != last && joins(branch)) {
        let terms = &branch.direction.terms;
        for (k, i) in terms.iter().enumerate() {
            let pairs = terms[k + 1..].iter().map(|j| (i.0, j.0, branch.element));
            edges.extend(pairs);
        }
    }
    let mut came: HashMap<usize, (usize, usize)> = HashMap::new();
    let mut queue = std::collections::VecDeque::from([a]);
    while let Some(here) = queue.pop_front() {
        for &(i, j, element) in &edges {
            let next = if i == here {
                j
            } else if j == here {
                i
            } else {
                continue;
            };
            if next != a && !came.contains_key(&next) {
                came.insert(next, (here, element));
                queue.push_back(next);
            }
        }
    }
    let (mut names, mut here) = (Vec::new(), b);
    while let Some(&(from, element)) = came.get(&here) {
        names.push(format!("`{}`", machine.elements[element].name));
        here = from;
    }
    names.reverse();
    names
}

/// The error of a machine of which nothing can turn: a loop of other ratios where there is one.
pub fn no_rotation_error(machine: &Machine) -> Error {
    let joints: Vec<(usize, &[(usize, f64)])> = (machine.branches.iter().enumerate())
        .filter(|(_, b)| match b.law {
            BranchLaw::Rigid => true,
            BranchLaw::Linear { stiffness, .. } => stiffness != 0.0,
        })
        .map(|(index, b)| (index, b.direction.terms.as_slice()))
        .collect();
    contradictory_loop(machine, &joints).unwrap_or_else(|| {
        let hint = "a shaft to ground holds it; leave the speed out";
        Error::new(
            Code::UndeterminedSpeed,
            "nothing of this machine can turn freely",
        )
        .with_hint(hint)
    })
}

/// Mean speed of every degree of freedom, rad/s, from the stated ones or from `reference` times the first motion.
///
/// # Errors
/// Nothing can turn, or the stated speeds leave a part open.
pub fn mean_speeds(
    machine: &Machine,
    kinematics: &Kinematics,
    reference: Option<f64>,
) -> Result<Vec<f64>, Error> {
    let n = machine.dofs.len();
    // Springs and dampers that resist the deformation of a joint say how its ends turn together.
    let joints = || {
        let elastic = |branch: &&Branch| matches!(branch.law, BranchLaw::Linear { stiffness, .. } if stiffness != 0.0);
        machine.branches.iter().filter(elastic)
    };
    let mut motions = kinematics.undeformed_motions(joints());
    let held = |&(dof, speed): &(usize, f64)| speed != 0.0 && motions.constraints.is_zero(dof);
    if motions.free.is_empty() || machine.speeds.iter().any(held) {
        // A torsional support of what is said to turn holds it about its mean turn.
        motions = kinematics.undeformed_motions(joints().filter(|b| !supports_turning(machine, b)));
    }
    if motions.free.is_empty() {
        return Err(no_rotation_error(machine));
    }
    let mut stated = machine.speeds.clone();
    if stated.is_empty() {
        stated.push((
            first_rotating_dof(machine, &motions),
            reference.unwrap_or(0.0),
        ));
    } else if let Some(speed) = reference {
        let old = stated[0].1;
        stated[0].1 = speed;
        for other in stated.iter_mut().skip(1).filter(|_| old != 0.0) {
            other.1 *= speed / old;
        }
    }
    // Bodies about the axis of a stage stay on it.
    let across = machine.gyroscopic.iter().filter_map(|spin| spin.across);
    stated.extend(across.flatten().map(|dof| (dof, 0.0)));
    let rpm = |speed: f64| speed * 30.0 / std::f64::consts::PI;
    motions.speeds(n, &stated).map_err(|error| {
        let hint = "state in [speed] one node of every part that turns independently, each once";
        let message = match error {
            SpeedError::Undetermined(dof) => format!(
                "the speed of {} does not follow from those stated",
                machine.dof_name(dof)
            ),
            SpeedError::Contradiction {
                dof,
                speed,
                implied,
            } => format!(
                "the stated speed of {}, {} rpm, contradicts the tooth numbers and the speeds stated before it, which give {} rpm",
                machine.dof_name(dof),
                rounded(rpm(speed)),
                rounded(rpm(implied))
            ),
        };
        Error::new(Code::UndeterminedSpeed, message).with_hint(hint)
    })
}

/// A bearing that holds the rotation of one body.
pub fn supports_turning(machine: &Machine, branch: &Branch) -> bool {
    let turns = |t: &(usize, f64)| machine.dofs[t.0].axis == Axis::Theta;
    let grounded = matches!(&branch.direction.terms[..], [only] if turns(only));
    grounded && machine.elements[branch.element].kind == "bearing"
}

fn first_rotating_dof(machine: &Machine, motions: &RigidMotions) -> usize {
    (0..machine.dofs.len())
        .find(|&i| !motions.constraints.is_zero(i))
        .unwrap_or(0)
}
