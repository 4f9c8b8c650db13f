//! Linear model at the operating point: `M p̈ + C ṗ + Σ u_b k_b w_bᵀ p = 0`.

use super::components::{BranchLaw, Machine, Mass};
use super::direction::Direction;
use super::kinematics::Kinematics;
use super::operating_point::{ActiveFlank, OperatingPoint};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::{Matrix, graded};
use crate::scene::model::BranchDamping;

/// A linear machine. Coordinates p are the degrees of freedom that stay; `q = T p` gives all of them.
#[derive(Debug, Clone)]
pub struct LinearModel {
    /// Number of remaining coordinates.
    pub n: usize,
    /// The degree of freedom each coordinate is.
    pub independent_dofs: Vec<usize>,
    /// Rows of T: each degree of freedom of the machine in the independent coordinates.
    pub transform: Vec<Vec<(usize, f64)>>,
    /// `M = Σ m v vᵀ`.
    pub masses: Vec<Mass>,
    /// Branches with stiffness or damping, in the order of their numbers.
    pub branches: Vec<LinearBranch>,
    /// Motions that strain no branch, over the independent coordinates: the rigid-body modes.
    pub rigid: Vec<Vec<f64>>,
    /// Number of leading rigid motions that strain no damper either.
    pub n_undamped_rigid: usize,
    /// Coordinates without inertia.
    pub massless: Vec<usize>,
}

/// A branch at its operating point.
#[derive(Debug, Clone)]
pub struct LinearBranch {
    /// Index in the machine.
    pub index: usize,
    /// w.
    pub direction: Direction,
    /// u, where it differs from w.
    pub force: Option<Direction>,
    /// k.
    pub stiffness: f64,
    /// c.
    pub damping: f64,
    /// η of `k (1 + iη)`.
    pub loss_factor: f64,
}

impl LinearBranch {
    /// The direction its force acts in.
    pub fn force_direction(&self) -> &Direction {
        self.force.as_ref().unwrap_or(&self.direction)
    }
}

impl LinearModel {
    /// Eliminates rigid joints, and takes every contact as the operating point left it.
    ///
    /// # Errors
    /// A part joined to nothing; a massless degree of freedom that nothing holds.
    pub fn new(
        machine: &Machine,
        kinematics: &Kinematics,
        operating: &OperatingPoint,
    ) -> Result<LinearModel, Error> {
        let reduce = |d: &Direction| Direction {
            scale: d.scale,
            terms: kinematics.reduce_row(&d.terms),
        };
        let masses: Vec<Mass> = machine
            .masses
            .iter()
            .map(|mass| Mass {
                direction: reduce(&mass.direction),
                ..mass.clone()
            })
            .filter(|mass| !mass.direction.terms.is_empty())
            .collect();
        let n = kinematics.independent_dofs.len();
        let massless = massless_coordinates(n, &masses);
        let mobility = InverseMass::new(n, &masses);
        let mut branches = Vec::new();
        for (index, branch) in machine.branches.iter().enumerate() {
            let BranchLaw::Linear { stiffness, loss } = branch.law else {
                continue;
            };
            let stiffness = operating.tangent(index).unwrap_or(stiffness);
            let state = operating.state(index);
            if state == ActiveFlank::Open {
                continue;
            }
            let flank = match (&branch.coast, state) {
                (Some(coast), ActiveFlank::Coast) => coast,
                _ => &branch.direction,
            };
            let direction = reduce(flank);
            let force = branch.force.as_ref().map(&reduce);
            if direction.terms.is_empty() {
                continue;
            }
            let damping = match loss {
                BranchDamping::Viscous(c) => c,
                BranchDamping::Ratio(zeta) => {
                    2.0 * zeta * (stiffness / mobility.inverse_mass_along(&direction)).sqrt()
                }
                BranchDamping::None | BranchDamping::Factor(_) => 0.0,
            };
            let loss_factor = if let BranchDamping::Factor(eta) = loss {
                eta
            } else {
                0.0
            };
            branches.push(LinearBranch {
                index,
                direction,
                force,
                stiffness,
                damping,
                loss_factor,
            });
        }
        let transform: Vec<Vec<(usize, f64)>> = (0..machine.dofs.len())
            .map(|dof| kinematics.in_independent_dofs(dof))
            .collect();
        let RigidMotionBasis {
            motions: rigid,
            undamped: n_undamped_rigid,
        } = rigid_motions(machine, kinematics, &branches);
        let free = kinematics.independent_dofs.clone();
        let model = LinearModel {
            n,
            independent_dofs: free,
            transform,
            masses,
            branches,
            rigid,
            n_undamped_rigid,
            massless,
        };
        model.check(machine, kinematics)?;
        Ok(model)
    }

    /// The branch of this number in the machine; nothing where it is open or between what moves as one.
    pub fn branch(&self, index: usize) -> Option<&LinearBranch> {
        let at = self.branches.binary_search_by_key(&index, |b| b.index);
        at.ok().map(|at| &self.branches[at])
    }

    /// All degrees of freedom from the independent coordinates.
    pub fn expand(&self, p: &[f64]) -> Vec<f64> {
        self.transform
            .iter()
            .map(|row| row.iter().map(|&(j, a)| a * p[j]).sum())
            .collect()
    }

    /// The independent coordinates, from all degrees of freedom.
    pub fn select_independent<T: Copy>(&self, q: &[T]) -> Vec<T> {
        self.independent_dofs.iter().map(|&i| q[i]).collect()
    }

    /// The diagonal of M, where M is diagonal.
    pub fn mass_diagonal(&self) -> Option<Vec<f64>> {
        let mut diagonal = vec![0.0; self.n];
        for mass in &self.masses {
            let [(j, a)] = mass.direction.terms[..] else {
                return None;
            };
            diagonal[j] += mass.value * (mass.direction.scale * a).powi(2);
        }
        Some(diagonal)
    }

    /// Every branch is a square `½ k (wᵀp)²` with k ≥ 0, so that frequencies are singular values.
    pub fn is_sum_of_squares(&self) -> bool {
        self.branches
            .iter()
            .all(|b| b.stiffness >= 0.0 && (b.force.is_none() || b.stiffness == 0.0))
    }

    /// Something loses energy.
    pub fn is_damped(&self, machine: &Machine) -> bool {
        let global = &machine.damping;
        self.branches
            .iter()
            .any(|b| b.damping != 0.0 || b.loss_factor != 0.0)
            || global.mass != 0.0
            || global.stiffness != 0.0
            || global.is_modal()
    }

    fn check(&self, machine: &Machine, kinematics: &Kinematics) -> Result<(), Error> {
        let mut joined = vec![false; machine.nodes.len()];
        for &(dof, _) in machine
            .friction_elements
            .iter()
            .flat_map(|b| &b.direction.terms)
        {
            joined[machine.dofs[dof].node] = true;
        }
        for branch in &machine.branches {
            for &(dof, _) in branch
                .direction
                .terms
                .iter()
                .chain(branch.force.iter().flat_map(|u| &u.terms))
            {
                joined[machine.dofs[dof].node] = true;
            }
        }
        if let (Some(alone), true) = (joined.iter().position(|&is| !is), machine.nodes.len() > 1) {
            let node = &machine.nodes[alone];
            let message = format!("`{}` is joined to nothing", node.name);
            let hint = "name it in the `between` of a shaft, a gear pair or another element, or leave it out";
            let place = &machine.elements[node.element].span;
            return Err(Error::new(Code::Disconnected, message)
                .with_span(place)
                .with_hint(hint));
        }
        if let Some(dof) = self.unconstrained_dof(machine, kinematics) {
            let name = machine.dof_name(dof);
            let message = format!(
                "{name} has no inertia, and no branch with stiffness ties it to anything that has"
            );
            let element = machine.nodes[machine.dofs[dof].node].element;
            let hint = "give the node an inertia, or join it by a branch with k";
            return Err(Error::new(Code::Disconnected, message)
                .with_span(&machine.elements[element].span)
                .with_hint(hint));
        }
        Ok(())
    }
}

impl LinearModel {
    /// A degree of freedom that moves with all inertia at rest and no spring deformed: it has no equation of motion.
    fn unconstrained_dof(&self, machine: &Machine, kinematics: &Kinematics) -> Option<usize> {
        if self.massless.is_empty() {
            return None;
        }
        let springs = self.branches.iter().filter(|b| b.stiffness != 0.0);
        let springs = springs.map(|b| machine.branches[b.index].direction.terms.as_slice());
        let masses = machine
            .masses
            .iter()
            .map(|mass| mass.direction.terms.as_slice());
        kinematics
            .null_space(springs.chain(masses))
            .free
            .first()
            .copied()
    }
}

/// Motions over the independent coordinates, those that no damper resists first.
struct RigidMotionBasis {
    motions: Vec<Vec<f64>>,
    undamped: usize,
}

fn rigid_motions(
    machine: &Machine,
    kinematics: &Kinematics,
    branches: &[LinearBranch],
) -> RigidMotionBasis {
    let free_of = |resists: &dyn Fn(&LinearBranch) -> bool| -> Vec<Vec<f64>> {
        // The machine's own rows: whole numbers of teeth, where reduced ones may be thirds.
        let rows = branches
            .iter()
            .filter(|b| resists(b))
            .map(|b| &machine.branches[b.index]);
        let motions = kinematics
            .undeformed_motions(rows)
            .basis(machine.dofs.len());
        motions
            .iter()
            .map(|q| kinematics.independent_dofs.iter().map(|&i| q[i]).collect())
            .collect()
    };
    let strained = |b: &LinearBranch| b.stiffness != 0.0;
    let mut elastic = free_of(&strained);
    if machine.is_lateral() {
        let rows: Vec<&Direction> = branches
            .iter()
            .filter(|b| strained(b))
            .map(|b| &b.direction)
            .collect();
        let geometric = null_motions(kinematics.independent_dofs.len(), &rows);
        // Exact turns first: what their terms cancel to stays zero.
        let all = geometric.len();
        for motion in geometric {
            if elastic.len() >= all {
                break;
            }
            elastic.push(motion);
            if dependent(&elastic) {
                elastic.pop();
            }
        }
    }
    let damped = |b: &LinearBranch| b.damping != 0.0 || b.loss_factor != 0.0;
    let mut motions = match branches.iter().any(|b| damped(b) && !strained(b)) {
        true => free_of(&|b| strained(b) || damped(b)),
        false => elastic.clone(),
    };
    let braked_by_all = machine.damping.mass != 0.0;
    if braked_by_all {
        motions.clear();
    }
    let undamped = motions.len();
    if undamped == elastic.len() {
        return RigidMotionBasis { motions, undamped };
    }
    // The rest of the elastic null space: motions that add a direction to those already listed.
    for motion in elastic {
        motions.push(motion);
        if dependent(&motions) {
            motions.pop();
        }
    }
    RigidMotionBasis { motions, undamped }
}

/// Whether the last of the motions is a combination of the others.
fn dependent(motions: &[Vec<f64>]) -> bool {
    let unit = |v: &[f64]| -> Vec<f64> {
        let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.iter().map(|x| x / norm).collect()
    };
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut rest = 1.0;
    for motion in motions {
        let mut v = unit(motion);
        for _ in 0..2 {
            for b in &basis {
                let share: f64 = b.iter().zip(&v).map(|(x, y)| x * y).sum();
                v.iter_mut().zip(b).for_each(|(x, y)| *x -= share * y);
            }
        }
        rest = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        basis.push(unit(&v));
    }
    rest < 1e-9 // of a unit vector; the motions are exact fractions, so what depends is at rounding
}

/// Motions that the directions leave free, from their geometry alone: for bodies that move sideways, whose coefficients are
/// sines and cosines and so no fractions. Rows and columns are brought to unit size; stiffness plays no part.
fn null_motions(n: usize, rows: &[&Direction]) -> Vec<Vec<f64>> {
    let mut a = Matrix::zeros(rows.len().max(1), n);
    for (i, row) in rows.iter().enumerate() {
        let norm = row.terms.iter().map(|t| t.1 * t.1).sum::<f64>().sqrt();
        row.terms.iter().for_each(|&(j, c)| a[(i, j)] = c / norm);
    }
    let size: Vec<f64> = (0..n)
        .map(|j| {
            (0..a.nrows())
                .map(|i| a[(i, j)] * a[(i, j)])
                .sum::<f64>()
                .sqrt()
        })
        .map(|s| if s > 0.0 { s } else { 1.0 })
        .collect();
    (0..n).for_each(|j| (0..a.nrows()).for_each(|i| a[(i, j)] /= size[j]));
    let Ok(found) = graded::svd(&a, None) else {
        return Vec::new();
    };
    let largest = found.values.last().copied().unwrap_or(0.0);
    (0..n)
        .filter(|&k| found.values[k] <= 1e-10 * largest) // geometry is known to 1e-16; a motion this free is free
        .map(|k| (0..n).map(|j| found.vectors[(j, k)] / size[j]).collect())
        .collect()
}

fn massless_coordinates(n: usize, masses: &[Mass]) -> Vec<usize> {
    let mut has = vec![false; n];
    for mass in masses.iter().filter(|mass| mass.value != 0.0) {
        mass.direction
            .terms
            .iter()
            .for_each(|&(j, _)| has[j] = true);
    }
    (0..n).filter(|&j| !has[j]).collect()
}

/// `wᵀ M⁻¹ w`, the inverse of a branch's effective mass, with M taken by its diagonal.
///
/// Off-diagonal terms come only from consistent shafts and differential stages, where a damping ratio per branch is a rule
/// of thumb anyway; the diagonal is then the mass each end carries.
struct InverseMass {
    inverse: Vec<f64>,
}

impl InverseMass {
    fn new(n: usize, masses: &[Mass]) -> InverseMass {
        let mut diagonal = vec![0.0; n];
        for mass in masses {
            for (j, a) in mass.direction.entries() {
                diagonal[j] += mass.value * a * a;
            }
        }
        InverseMass {
            inverse: diagonal.iter().map(|m| 1.0 / m).collect(),
        }
    }

    /// Infinite where an end is massless: the branch then has no damping of its own.
    fn inverse_mass_along(&self, direction: &Direction) -> f64 {
        direction
            .entries()
            .map(|(j, a)| a * a * self.inverse[j])
            .sum()
    }
}
