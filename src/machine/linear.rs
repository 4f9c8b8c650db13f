//! Linear model at the operating point: `M p̈ + C ṗ + Σ u_b k_b w_bᵀ p = 0`.

use super::components::{BranchLaw, Machine, Mass};
use super::direction::Direction;
use super::kinematics::Kinematics;
use super::operating_point::{ActiveFlank, OperatingPoint};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::{Matrix, graded};
use crate::scene::model::BranchDamping;

/// Linear model of a machine in the independent coordinates p; `q = T p` are all degrees of freedom.
#[derive(Debug, Clone)]
pub struct LinearModel {
    /// Number of independent coordinates.
    pub n: usize,
    /// Degree of freedom of each coordinate.
    pub independent_dofs: Vec<usize>,
    /// Rows of T: each degree of freedom of the machine as (coordinate, coefficient) terms.
    pub transform: Vec<Vec<(usize, f64)>>,
    /// Masses of `M = Σ m v vᵀ`.
    pub masses: Vec<Mass>,
    /// Active linear branches in order of their index in the machine.
    pub branches: Vec<LinearBranch>,
    /// Rigid-body modes in the independent coordinates: motions without strain in any branch.
    pub rigid: Vec<Vec<f64>>,
    /// Number of leading rigid-body modes without damping.
    pub n_undamped_rigid: usize,
    /// Indices of the coordinates without inertia.
    pub massless: Vec<usize>,
}

/// Linear branch at the operating point.
#[derive(Debug, Clone)]
pub struct LinearBranch {
    /// Index of the branch in the machine.
    pub index: usize,
    /// Direction w of the deformation `wᵀp`.
    pub direction: Direction,
    /// Direction u of the force; `None`: equal to w.
    pub force: Option<Direction>,
    /// Stiffness k, N/m or N·m/rad.
    pub stiffness: f64,
    /// Viscous damping c, N·s/m or N·m·s/rad.
    pub damping: f64,
    /// Loss factor η of `k (1 + iη)`.
    pub loss_factor: f64,
}

impl LinearBranch {
    /// Direction of the force.
    pub fn force_direction(&self) -> &Direction {
        self.force.as_ref().unwrap_or(&self.direction)
    }
}

impl LinearModel {
    /// Eliminates rigid constraints and linearises contacts at the operating point.
    ///
    /// # Errors
    /// `Disconnected` for a node without connection and for a massless degree of freedom without stiffness.
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
        let inverse_mass = InverseMass::new(n, &masses);
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
                    2.0 * zeta * (stiffness / inverse_mass.inverse_mass_along(&direction)).sqrt()
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
        let independent_dofs = kinematics.independent_dofs.clone();
        let model = LinearModel {
            n,
            independent_dofs,
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

    /// Branch with the given index in the machine; `None` if it is open or between rigidly connected parts.
    pub fn branch(&self, index: usize) -> Option<&LinearBranch> {
        let at = self.branches.binary_search_by_key(&index, |b| b.index);
        at.ok().map(|at| &self.branches[at])
    }

    /// Expands independent coordinates to all degrees of freedom.
    pub fn expand(&self, p: &[f64]) -> Vec<f64> {
        self.transform
            .iter()
            .map(|row| row.iter().map(|&(j, a)| a * p[j]).sum())
            .collect()
    }

    /// Selects the independent coordinates from all degrees of freedom.
    pub fn select_independent<T: Copy>(&self, q: &[T]) -> Vec<T> {
        self.independent_dofs.iter().map(|&i| q[i]).collect()
    }

    /// Diagonal of M; `None` if M is not diagonal.
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

    /// True if all branches have energy `½ k (wᵀp)²` with k ≥ 0, so that natural frequencies are singular values.
    pub fn is_sum_of_squares(&self) -> bool {
        self.branches
            .iter()
            .all(|b| b.stiffness >= 0.0 && (b.force.is_none() || b.stiffness == 0.0))
    }

    /// True if the machine has any damping.
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
        let mut linked = vec![false; machine.nodes.len()];
        for &(dof, _) in machine
            .friction_elements
            .iter()
            .flat_map(|b| &b.direction.terms)
        {
            linked[machine.dofs[dof].node] = true;
        }
        for branch in &machine.branches {
            for &(dof, _) in branch
                .direction
                .terms
                .iter()
                .chain(branch.force.iter().flat_map(|u| &u.terms))
            {
                linked[machine.dofs[dof].node] = true;
            }
        }
        if let (Some(index), true) = (linked.iter().position(|&j| !j), machine.nodes.len() > 1) {
            let node = &machine.nodes[index];
            let message = format!("`{}` is not connected", node.name);
            let hint = "name it in the `between` of a shaft, a gear pair or another element, or leave it out";
            let place = &machine.elements[node.element].span;
            return Err(Error::new(Code::Disconnected, message)
                .with_span(place)
                .with_hint(hint));
        }
        if let Some(dof) = self.unconstrained_dof(machine, kinematics) {
            let name = machine.dof_name(dof);
            let message = format!(
                "{name} has no inertia and no branch with stiffness to a body with inertia"
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
    /// First degree of freedom that can move without inertia and spring deformation: it has no equation of motion.
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

/// Rigid-body modes in the independent coordinates, the undamped ones first.
struct RigidMotionBasis {
    motions: Vec<Vec<f64>>,
    undamped: usize,
}

fn rigid_motions(
    machine: &Machine,
    kinematics: &Kinematics,
    branches: &[LinearBranch],
) -> RigidMotionBasis {
    let motions_without = |is_constraint: &dyn Fn(&LinearBranch) -> bool| -> Vec<Vec<f64>> {
        // Rows of the unreduced machine have integer tooth numbers; reduced rows may have fractions.
        let rows = branches
            .iter()
            .filter(|b| is_constraint(b))
            .map(|b| &machine.branches[b.index]);
        let motions = kinematics
            .undeformed_motions(rows)
            .basis(machine.dofs.len());
        motions
            .iter()
            .map(|q| kinematics.independent_dofs.iter().map(|&i| q[i]).collect())
            .collect()
    };
    let is_elastic = |b: &LinearBranch| b.stiffness != 0.0;
    let mut elastic = motions_without(&is_elastic);
    if machine.is_lateral() {
        let rows: Vec<&Direction> = branches
            .iter()
            .filter(|b| is_elastic(b))
            .map(|b| &b.direction)
            .collect();
        let geometric = null_motions(kinematics.independent_dofs.len(), &rows);
        // Exact rational motions come first, so that cancelling terms remain exactly zero.
        let n_geometric = geometric.len();
        for motion in geometric {
            if elastic.len() >= n_geometric {
                break;
            }
            elastic.push(motion);
            if dependent(&elastic) {
                elastic.pop();
            }
        }
    }
    let is_damped = |b: &LinearBranch| b.damping != 0.0 || b.loss_factor != 0.0;
    let mut motions = match branches.iter().any(|b| is_damped(b) && !is_elastic(b)) {
        true => motions_without(&|b| is_elastic(b) || is_damped(b)),
        false => elastic.clone(),
    };
    let has_mass_damping = machine.damping.mass != 0.0;
    if has_mass_damping {
        motions.clear();
    }
    let undamped = motions.len();
    if undamped == elastic.len() {
        return RigidMotionBasis { motions, undamped };
    }
    // Remaining motions of the elastic null space that are independent of those already listed.
    for motion in elastic {
        motions.push(motion);
        if dependent(&motions) {
            motions.pop();
        }
    }
    RigidMotionBasis { motions, undamped }
}

/// True if the last motion is a linear combination of the others.
fn dependent(motions: &[Vec<f64>]) -> bool {
    let unit = |v: &[f64]| -> Vec<f64> {
        let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.iter().map(|x| x / norm).collect()
    };
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut residual = 1.0;
    for motion in motions {
        let mut v = unit(motion);
        for _ in 0..2 {
            for b in &basis {
                let share: f64 = b.iter().zip(&v).map(|(x, y)| x * y).sum();
                v.iter_mut().zip(b).for_each(|(x, y)| *x -= share * y);
            }
        }
        residual = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        basis.push(unit(&v));
    }
    residual < 1e-9 // of a unit vector; the motions are exact fractions, so a dependent residual is at rounding
}

/// Null space of the branch directions by SVD, for lateral models whose coefficients are sines and cosines and not fractions. Rows and
/// columns are scaled to unit norm; stiffness has no influence.
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
    let Ok(svd) = graded::svd(&a, None) else {
        return Vec::new();
    };
    let largest = svd.values.last().copied().unwrap_or(0.0);
    (0..n)
        .filter(|&k| svd.values[k] <= 1e-10 * largest) // the geometry is exact to 1e-16
        .map(|k| (0..n).map(|j| svd.vectors[(j, k)] / size[j]).collect())
        .collect()
}

fn massless_coordinates(n: usize, masses: &[Mass]) -> Vec<usize> {
    let mut has_mass = vec![false; n];
    for mass in masses.iter().filter(|mass| mass.value != 0.0) {
        mass.direction
            .terms
            .iter()
            .for_each(|&(j, _)| has_mass[j] = true);
    }
    (0..n).filter(|&j| !has_mass[j]).collect()
}

/// Inverse effective mass `wᵀ M⁻¹ w` of branches with the diagonal of M.
///
/// Off-diagonal terms occur only for consistent shaft masses and differential stages, where a damping ratio per branch is approximate
/// anyway; the diagonal is then the mass at each end.
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

    /// Inverse effective mass along a direction; infinite if an end is massless, and the branch is then undamped.
    fn inverse_mass_along(&self, direction: &Direction) -> f64 {
        direction
            .entries()
            .map(|(j, a)| a * a * self.inverse[j])
            .sum()
    }
}
