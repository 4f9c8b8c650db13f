//! Kinematics of the train: elimination of rigid joints in exact fractions, rigid-body motions, mean speeds.

use std::collections::{BTreeMap, HashMap};

use super::components::{Branch, BranchLaw, Machine};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::exact_constraints::{ConstraintEffect, ExactConstraints};
use crate::numeric::fraction::Fraction;
use crate::scene::model::Axis;

/// Solved kinematic constraints of the rigid joints.
#[derive(Debug, Clone)]
pub struct Kinematics {
    constraints: ExactConstraints,
    /// Independent degrees of freedom, in ascending order.
    pub independent_dofs: Vec<usize>,
    number: HashMap<usize, usize>,
}

impl Kinematics {
    /// Eliminates the constraint of every rigid joint.
    ///
    /// # Errors
    /// Contradictory ratios in a closed loop, with the loop and both ratios.
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
                    "correct the tooth numbers, or give one pair of the loop a stiffness k",
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

    /// Linear form over all degrees of freedom, expressed in the independent ones.
    pub fn reduce_row(&self, row: &[(usize, f64)]) -> Vec<(usize, f64)> {
        self.constraints
            .reduce_row(row)
            .into_iter()
            .map(|(q, a)| (self.number[&q], a))
            .collect()
    }

    /// Linear combination of independent degrees of freedom equal to one degree of freedom.
    pub fn in_independent_dofs(&self, dof: usize) -> Vec<(usize, f64)> {
        self.constraints
            .combination(dof)
            .into_iter()
            .map(|(q, a)| (self.number[&q], a))
            .collect()
    }

    /// Rigid-body motions over all degrees of freedom, without deformation of `branches`.
    pub fn undeformed_motions<'a>(
        &self,
        branches: impl Iterator<Item = &'a Branch>,
    ) -> RigidMotions {
        self.null_space(branches.map(|branch| branch.direction.terms.as_slice()))
    }

    /// Null space of the linear forms `rows`, `Σ coefficient · q`, over all degrees of freedom.
    pub fn null_space<'a>(&self, rows: impl Iterator<Item = &'a [(usize, f64)]>) -> RigidMotions {
        let mut constraints = self.constraints.clone();
        // Short rows first: grounded degrees of freedom cancel before the meshes are processed.
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

/// Rigid-body motions in exact fractions, without elastic deformation.
#[derive(Debug, Clone)]
pub struct RigidMotions {
    constraints: ExactConstraints,
    /// Free degree of freedom of each motion: 1 in that motion, 0 in all others.
    pub free: Vec<usize>,
}

impl RigidMotions {
    /// Basis of the rigid-body motions, each over all `n` degrees of freedom.
    pub fn basis(&self, n: usize) -> Vec<Vec<f64>> {
        let number: HashMap<usize, usize> =
            self.free.iter().enumerate().map(|(k, &j)| (j, k)).collect();
        let mut basis = vec![vec![0.0; n]; self.free.len()];
        for i in 0..n {
            for (j, a) in self.constraints.combination(i) {
                basis[number[&j]][i] = a;
            }
        }
        basis
    }

    /// Exact ratio of two degrees of freedom, such as `-37/12`, if exactly one motion moves both.
    pub fn ratio(&self, dof: usize, reference: usize) -> Option<String> {
        self.constraints.ratio_text(dof, reference)
    }

    /// Speeds of all degrees of freedom, rad/s, from the stated ones.
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
            solved.iter().for_each(|other| row.eliminate(other));
            // Coefficients are fractions of tooth numbers; cancellation produces rounding errors only.
            let largest = row
                .terms
                .iter()
                .map(|(&j, &a)| (j, a))
                .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
            let Some((pivot, a)) = largest.filter(|(_, a)| a.abs() > 1e-12 * size) else {
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
            solved.iter_mut().for_each(|other| other.eliminate(&row));
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
        let speeds = (0..n).map(|i| speed_of(i).ok_or(SpeedError::Undetermined(i)));
        speeds.collect()
    }
}

/// Value rounded to nine significant digits.
fn rounded(x: f64) -> f64 {
    let scale = 10f64.powf(8.0 - x.abs().max(1e-12).log10().floor());
    (x * scale).round() / scale
}

/// Error of mean speeds: undetermined or contradictory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SpeedError {
    /// Degree of freedom without a speed determined by the stated ones.
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

/// Equation `x_pivot + Σ a x = value` in reduced row echelon form.
struct ReducedRow {
    pivot: usize,
    terms: BTreeMap<usize, f64>,
    value: f64,
}

impl ReducedRow {
    fn size(&self) -> f64 {
        self.terms.values().fold(0.0, |m, a| m.max(a.abs()))
    }

    /// Eliminates the pivot of another row by subtraction of that row.
    fn eliminate(&mut self, other: &ReducedRow) {
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

/// First joint, rigid or elastic, that closes a loop with a ratio contradicting the joints before: such a loop cannot rotate.
/// `joints`: branch indices with their directions.
pub fn contradictory_loop(machine: &Machine, joints: &[(usize, &[(usize, f64)])]) -> Option<Error> {
    let mut constraints = ExactConstraints::new(machine.dofs.len());
    for &(index, row) in joints {
        let grounded = row.len() == 1 || row.iter().any(|&(i, _)| constraints.is_zero(i));
        let before = (!grounded).then(|| constraints.clone());
        if let (ConstraintEffect::Zeroed(_), Some(before)) = (constraints.impose(row), before) {
            let connects = |branch: &Branch| match branch.law {
                BranchLaw::Rigid => true,
                BranchLaw::Linear { stiffness, .. } => stiffness != 0.0,
            };
            let error = contradiction(machine, index, row, &before, &connects);
            return Some(error.with_hint(
                "correct the tooth numbers: elastic joints do not unlock a loop whose ratios differ",
            ));
        }
    }
    None
}

/// Error of a joint that closes a loop with contradictory ratios; names the loop and both ratios.
fn contradiction(
    machine: &Machine,
    index: usize,
    row: &[(usize, f64)],
    before: &ExactConstraints,
    connects: &dyn Fn(&Branch) -> bool,
) -> Error {
    let branch = &machine.branches[index];
    let name = &machine.elements[branch.element].name;
    let message = match ratios(row, before) {
        Some((a, b, joint_ratio, loop_ratio)) => {
            let path = shortest_path(machine, index, a, b, connects);
            let through = if path.is_empty() {
                String::new()
            } else {
                format!(" through {}", path.join(", "))
            };
            format!(
                "contradictory ratios: the loop{through} turns {} by {loop_ratio} per turn of {}, `{name}` by {joint_ratio}",
                machine.dof_name(b),
                machine.dof_name(a),
            )
        }
        None => format!("`{name}` closes a loop of joints, which locks it"),
    };
    Error::new(Code::ContradictoryRatios, message).with_span(&machine.elements[branch.element].span)
}

/// Two degrees of freedom of a joint, with the ratio of the second to the first by this joint and by the joints before.
fn ratios(
    row: &[(usize, f64)],
    before: &ExactConstraints,
) -> Option<(usize, usize, Fraction, Fraction)> {
    let moves = |t: &&(usize, f64)| t.1 != 0.0 && !before.is_zero(t.0);
    let &(a, _) = row.iter().find(moves)?;
    let &(b, coefficient) = row.iter().rev().find(moves).filter(|t| t.0 != a)?;
    let loop_ratio = before.exact_ratio(b, a)?;
    let mut sum = Fraction::zero();
    for &(other, share) in row.iter().filter(|t| t.0 != b) {
        sum = &sum + &(&Fraction::from_f64(share) * &before.exact_ratio(other, a)?);
    }
    let joint_ratio = &(&Fraction::zero() - &sum) / &Fraction::from_f64(coefficient);
    Some((a, b, joint_ratio, loop_ratio))
}

/// Names of the elements on the shortest path from `a` to `b` without branch `excluded`.
fn shortest_path(
    machine: &Machine,
    excluded: usize,
    a: usize,
    b: usize,
    connects: &dyn Fn(&Branch) -> bool,
) -> Vec<String> {
    let mut edges: Vec<(usize, usize, usize)> = Vec::new();
    let branches = machine.branches.iter().enumerate();
    for (_, branch) in branches.filter(|(k, branch)| *k != excluded && connects(branch)) {
        let terms = &branch.direction.terms;
        for (k, i) in terms.iter().enumerate() {
            let pairs = terms[k + 1..].iter().map(|j| (i.0, j.0, branch.element));
            edges.extend(pairs);
        }
    }
    let mut predecessor: HashMap<usize, (usize, usize)> = HashMap::new();
    let mut queue = std::collections::VecDeque::from([a]);
    while let Some(dof) = queue.pop_front() {
        for &(i, j, element) in &edges {
            let next = if i == dof {
                j
            } else if j == dof {
                i
            } else {
                continue;
            };
            if next != a && !predecessor.contains_key(&next) {
                predecessor.insert(next, (dof, element));
                queue.push_back(next);
            }
        }
    }
    let (mut names, mut dof) = (Vec::new(), b);
    while let Some(&(previous, element)) = predecessor.get(&dof) {
        names.push(format!("`{}`", machine.elements[element].name));
        dof = previous;
    }
    names.reverse();
    names
}

/// Error of a machine without free rotation; names a loop with contradictory ratios, if any.
pub fn no_rotation_error(machine: &Machine) -> Error {
    let joints: Vec<(usize, &[(usize, f64)])> = (machine.branches.iter().enumerate())
        .filter(|(_, b)| match b.law {
            BranchLaw::Rigid => true,
            BranchLaw::Linear { stiffness, .. } => stiffness != 0.0,
        })
        .map(|(index, b)| (index, b.direction.terms.as_slice()))
        .collect();
    contradictory_loop(machine, &joints).unwrap_or_else(|| {
        let hint = "it is held by a shaft to ground; speeds and transmission errors need a machine that turns";
        Error::new(
            Code::UndeterminedSpeed,
            "no part of this machine can turn freely",
        )
        .with_hint(hint)
    })
}

/// Mean speed of every degree of freedom, rad/s, from the stated speeds or from `reference` on the first rotating one.
///
/// # Errors
/// No free rotation; contradictory or missing stated speeds.
pub fn mean_speeds(
    machine: &Machine,
    kinematics: &Kinematics,
    reference: Option<f64>,
) -> Result<Vec<f64>, Error> {
    let n = machine.dofs.len();
    // Elastic joints transmit the mean speed: their mean deflection is constant.
    let joints = || {
        let elastic = |branch: &&Branch| matches!(branch.law, BranchLaw::Linear { stiffness, .. } if stiffness != 0.0);
        machine.branches.iter().filter(elastic)
    };
    let mut motions = kinematics.undeformed_motions(joints());
    let blocked = |&(dof, speed): &(usize, f64)| speed != 0.0 && motions.constraints.is_zero(dof);
    if motions.free.is_empty() || machine.speeds.iter().any(blocked) {
        // A torsional support of a rotating node acts about its mean rotation.
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
        let first = stated[0].1;
        stated[0].1 = speed;
        for other in stated.iter_mut().skip(1).filter(|_| first != 0.0) {
            other.1 *= speed / first;
        }
    }
    // Mean lateral speeds of bodies on a stage axis are zero.
    let across = machine.gyroscopic.iter().filter_map(|spin| spin.across);
    stated.extend(across.flatten().map(|dof| (dof, 0.0)));
    let rpm = |speed: f64| speed * 30.0 / std::f64::consts::PI;
    motions.speeds(n, &stated).map_err(|error| {
        let hint = "state in [speed] one node of every part that turns independently";
        let message = match error {
            SpeedError::Undetermined(dof) => format!(
                "the speed of {} is not determined by those stated",
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

/// True for a bearing that supports the rotation of one body.
pub fn supports_turning(machine: &Machine, branch: &Branch) -> bool {
    let is_rotation = |t: &(usize, f64)| machine.dofs[t.0].axis == Axis::Theta;
    let grounded = matches!(&branch.direction.terms[..], [term] if is_rotation(term));
    grounded && machine.elements[branch.element].kind == "bearing"
}

fn first_rotating_dof(machine: &Machine, motions: &RigidMotions) -> usize {
    (0..machine.dofs.len())
        .find(|&i| !motions.constraints.is_zero(i))
        .unwrap_or(0)
}
