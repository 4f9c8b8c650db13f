//! Coordinates under prescribed motions, `p = T_r r + T_h h`.
//!
//! A prescribed degree of freedom is a constraint row `q_i = h`; a rigid joint with an imposed displacement, `wᵀq = e`, is released and
//! becomes such a row. The columns of T_r satisfy all rows with zero right-hand side; column h of T_h satisfies row h with one and the
//! others with zero.

use super::dynamic_stiffness::{SparseVector, sum_duplicates};
use super::ports::{Ports, ResponseInput, ResponseOutput};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::components::{Branch, BranchLaw, Machine};
use crate::machine::direction::Direction;
use crate::machine::kinematics::Kinematics;
use crate::machine::linear::{LinearBranch, LinearModel};
use crate::machine::operating_point::OperatingPoint;
use crate::modes::modal_basis::{ModalBasis, column};
use crate::numeric::Matrix;
use crate::scene::model::BranchDamping;

/// Degree of freedom or rigid joint (by its branch) with a prescribed motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PrescribedDof {
    Dof(usize),
    Joint(usize),
}

/// Coordinates of a machine with prescribed motions.
pub(super) struct ConstrainedCoordinates {
    /// Machine with the prescribed joints released.
    pub machine: Machine,
    /// Linear model of that machine; its coordinates are p.
    pub model: LinearModel,
    /// Linear model with all prescribed motions fixed at zero.
    pub fixed: LinearModel,
    /// Prescribed motions, one per component of h.
    pub prescribed: Vec<PrescribedDof>,
    /// Rigid-body motions with all prescribed motions fixed, over p.
    pub rigid: Vec<Vec<f64>>,
    rows: ConstraintRows,
}

/// Machine, its operating point and linear model.
pub(super) struct CoordinateInput<'a> {
    pub machine: &'a Machine,
    pub operating: &'a OperatingPoint,
    pub model: &'a LinearModel,
}

impl ConstrainedCoordinates {
    pub fn new(input: &CoordinateInput, ports: &Ports) -> Result<ConstrainedCoordinates, Error> {
        let prescribed = fixed_rows(input.machine, ports);
        let (mut machine, mut fixed_machine) = (input.machine.clone(), input.machine.clone());
        for motion in &prescribed {
            match *motion {
                // A temporary stiffness keeps the parts connected; the branch is removed below.
                PrescribedDof::Joint(branch) => {
                    machine.branches[branch].law = BranchLaw::Linear {
                        stiffness: 1.0,
                        loss: BranchDamping::None,
                    }
                }
                PrescribedDof::Dof(dof) => fixed_machine.branches.push(Branch {
                    element: fixed_machine.nodes[fixed_machine.dofs[dof].node].element,
                    part: None,
                    direction: Direction::unit(dof),
                    coast: None,
                    force: None,
                    law: BranchLaw::Rigid,
                    backlash: 0.0,
                    contact_damping: None,
                    stiffness_variation: None,
                    mesh_springs: None,
                    characteristic: None,
                }),
            }
        }
        let has_joints = prescribed
            .iter()
            .any(|motion| matches!(motion, PrescribedDof::Joint(_)));
        let has_dofs = prescribed
            .iter()
            .any(|motion| matches!(motion, PrescribedDof::Dof(_)));
        let relinearise = |machine: &Machine| -> Result<LinearModel, Error> {
            let mut linear_model =
                LinearModel::new(machine, &Kinematics::new(machine)?, input.operating)?;
            // Damping ratios refer to the masses of the unconstrained machine.
            for branch in &mut linear_model.branches {
                let original = input.model.branch(branch.index);
                branch.damping = original.map_or(branch.damping, |b| b.damping);
            }
            Ok(linear_model)
        };
        let linear_model = if has_joints {
            relinearise(&machine)?
        } else {
            input.model.clone()
        };
        let fixed_model = if has_dofs {
            relinearise(&fixed_machine)?
        } else {
            input.model.clone()
        };
        let released = |b: &LinearBranch| prescribed.contains(&PrescribedDof::Joint(b.index));
        let mut linear_model = linear_model;
        linear_model.branches.retain(|b| !released(b));
        let rows = ConstraintRows::new(&machine, &linear_model, &prescribed)?;
        let rigid = fixed_model
            .rigid
            .iter()
            .map(|r| linear_model.select_independent(&fixed_model.expand(r)))
            .collect();
        Ok(ConstrainedCoordinates {
            machine,
            model: linear_model,
            fixed: fixed_model,
            prescribed,
            rigid,
            rows,
        })
    }

    /// Columns of `[T_r, T_h]`: rigid-body motions, single free coordinates of p, prescribed motions.
    pub fn sparse_basis(&self) -> Vec<SparseVector> {
        let mut used = self.rows.pivots.clone();
        let mut rigid: Vec<Vec<f64>> = self.rigid.clone();
        for k in 0..rigid.len() {
            let free = (0..self.model.n).filter(|j| !used.contains(j));
            let Some(pivot) = free.max_by(|&a, &b| rigid[k][a].abs().total_cmp(&rigid[k][b].abs()))
            else {
                continue;
            };
            used.push(pivot);
            let (processed, remaining) = rigid.split_at_mut(k + 1);
            for other in remaining {
                let factor = other[pivot] / processed[k][pivot];
                other
                    .iter_mut()
                    .zip(&processed[k])
                    .for_each(|(x, y)| *x -= factor * y);
            }
        }
        let mut free = vec![true; self.model.n];
        used.iter().for_each(|&j| free[j] = false);
        let single = (0..self.model.n)
            .filter(|&j| free[j])
            .map(|j| self.rows.free_motion(j));
        let imposed = (0..self.prescribed.len()).map(|h| self.rows.imposed(h));
        let rigid = self.rigid.iter().map(|r| sparse(r.iter().copied()));
        rigid.chain(single).chain(imposed).collect()
    }

    /// `[T_r, T_h]` over the modes and massless coordinates of the model with fixed prescribed motions.
    pub fn modal_basis(&self, basis: &ModalBasis) -> Matrix {
        let transfer = |p: &[f64]| self.model.select_independent(&self.fixed.expand(p));
        let modes = (0..basis.omega.len()).map(|k| transfer(&column(&basis.shapes, k)));
        let massless = self.fixed.massless.iter().map(|&j| {
            let mut unit = vec![0.0; self.fixed.n];
            unit[j] = 1.0;
            transfer(&unit)
        });
        let imposed = (0..self.prescribed.len()).map(|h| {
            let mut column = vec![0.0; self.model.n];
            (self.rows.imposed(h).iter()).for_each(|&(j, a)| column[j] = a);
            column
        });
        let columns: Vec<Vec<f64>> = modes.chain(massless).chain(imposed).collect();
        Matrix::from_fn(self.model.n, columns.len(), |i, j| columns[j][i])
    }

    /// Modes of the unconstrained machine over p, for modal damping.
    pub fn shapes(&self, basis: &ModalBasis, model: &LinearModel) -> ModalBasis {
        let modes: Vec<Vec<f64>> = (0..basis.omega.len())
            .map(|k| {
                self.model
                    .select_independent(&model.expand(&column(&basis.shapes, k)))
            })
            .collect();
        ModalBasis {
            shapes: Matrix::from_fn(self.model.n, modes.len(), |i, j| modes[j][i]),
            ..basis.clone()
        }
    }
}

/// Nonzero entries of a column.
fn sparse(column: impl IntoIterator<Item = f64>) -> SparseVector {
    let terms = column.into_iter().enumerate();
    terms.filter(|term| term.1 != 0.0).collect()
}

/// Prescribed degrees of freedom, and rigid joints with an imposed displacement or an output force, without duplicates.
fn fixed_rows(machine: &Machine, ports: &Ports) -> Vec<PrescribedDof> {
    let rigid = |branch: usize| machine.branches[branch].law == BranchLaw::Rigid;
    let mut motions: Vec<PrescribedDof> = ports
        .fixed
        .iter()
        .map(|&dof| PrescribedDof::Dof(dof))
        .collect();
    for input in &ports.inputs {
        match input.kind {
            ResponseInput::Motion(dof) => motions.push(PrescribedDof::Dof(dof)),
            ResponseInput::Displacement(branch) if rigid(branch) => {
                motions.push(PrescribedDof::Joint(branch))
            }
            _ => {}
        }
    }
    for output in &ports.outputs {
        match output.kind {
            ResponseOutput::Force(branch) if rigid(branch) => {
                motions.push(PrescribedDof::Joint(branch))
            }
            _ => {}
        }
    }
    let mut unique: Vec<PrescribedDof> = Vec::new();
    motions.into_iter().for_each(|motion| {
        if !unique.contains(&motion) {
            unique.push(motion);
        }
    });
    unique
}

/// Constraint rows, each solved for its pivot coordinate: `p_pivot = Σ imposed h − Σ others p`.
struct ConstraintRows {
    pivots: Vec<usize>,
    others: Vec<Vec<f64>>,
    imposed: Vec<Vec<f64>>,
}

/// Rank tolerance relative to the largest entry of a row, above the rounding of tooth ratios.
const DEPENDENT: f64 = 1e-11;

impl ConstraintRows {
    fn new(
        machine: &Machine,
        model: &LinearModel,
        prescribed: &[PrescribedDof],
    ) -> Result<ConstraintRows, Error> {
        let mut rows = ConstraintRows {
            pivots: Vec::new(),
            others: Vec::new(),
            imposed: Vec::new(),
        };
        for (number, motion) in prescribed.iter().enumerate() {
            let mut row = vec![0.0; model.n];
            let direction = match *motion {
                PrescribedDof::Dof(dof) => Direction::unit(dof),
                PrescribedDof::Joint(branch) => machine.branches[branch].direction.clone(),
            };
            for (dof, a) in direction.entries() {
                for &(j, b) in &model.transform[dof] {
                    row[j] += a * b;
                }
            }
            let size = row.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let mut right = vec![0.0; prescribed.len()];
            right[number] = 1.0;
            for (k, &pivot) in rows.pivots.iter().enumerate() {
                let factor = row[pivot];
                row.iter_mut()
                    .zip(&rows.others[k])
                    .for_each(|(x, y)| *x -= factor * y);
                right
                    .iter_mut()
                    .zip(&rows.imposed[k])
                    .for_each(|(x, y)| *x -= factor * y);
            }
            let pivot = (0..model.n).max_by(|&a, &b| row[a].abs().total_cmp(&row[b].abs()));
            let Some(pivot) = pivot.filter(|&j| row[j].abs() > DEPENDENT * size) else {
                return Err(overdetermined_error(machine, *motion));
            };
            let scale = row[pivot];
            row.iter_mut()
                .chain(right.iter_mut())
                .for_each(|x| *x /= scale);
            for k in 0..rows.pivots.len() {
                let factor = rows.others[k][pivot];
                rows.others[k]
                    .iter_mut()
                    .zip(&row)
                    .for_each(|(x, y)| *x -= factor * y);
                rows.imposed[k]
                    .iter_mut()
                    .zip(&right)
                    .for_each(|(x, y)| *x -= factor * y);
            }
            rows.pivots.push(pivot);
            rows.others.push(row);
            rows.imposed.push(right);
        }
        Ok(rows)
    }

    /// Column of T_r: unit motion of coordinate j with the dependent motions of the pivots.
    fn free_motion(&self, j: usize) -> SparseVector {
        let dependent = self.pivots.iter().zip(&self.others);
        sum_duplicates(
            std::iter::once((j, 1.0)).chain(dependent.map(|(&pivot, row)| (pivot, -row[j]))),
        )
    }

    /// Column of T_h: unit motion of prescribed motion h.
    fn imposed(&self, h: usize) -> SparseVector {
        let dependent = self.pivots.iter().zip(&self.imposed);
        sum_duplicates(dependent.map(|(&pivot, right)| (pivot, right[h])))
    }
}

fn overdetermined_error(machine: &Machine, motion: PrescribedDof) -> Error {
    match motion {
        PrescribedDof::Dof(dof) => {
            let message = format!(
                "{} cannot be prescribed: it is already constrained by rigid joints or another prescribed motion",
                machine.dof_name(dof)
            );
            Error::new(Code::Conflict, message).with_hint("prescribe one motion of each rigid part")
        }
        PrescribedDof::Joint(branch) => {
            let message = format!(
                "`{}` closes a rigid loop: neither a displacement in it nor its force is determined",
                machine.branch_name(branch)
            );
            Error::new(Code::Conflict, message)
                .with_hint("give one joint of the loop a stiffness k")
        }
    }
}
