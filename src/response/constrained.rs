//! Coordinates under prescribed motions, `p = T_r r + T_h h`.
//!
//! A held degree of freedom is a row `q_i = h`; a rigid joint with a displacement imposed in it, `wᵀq = e`, is released and
//! becomes such a row. What r is over, the rows leave at zero; column h of T_h moves its own row by one and the others not at
//! all.

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

/// A degree of freedom whose motion is prescribed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PrescribedDof {
    Dof(usize),
    Joint(usize),
}

/// A machine with some motions prescribed.
pub(super) struct ConstrainedCoordinates {
    /// The machine with the joints released that a displacement is imposed in.
    pub machine: Machine,
    /// The same, linear; its coordinates are p.
    pub model: LinearModel,
    /// The machine with everything held still.
    pub fixed: LinearModel,
    /// Prescribed degrees of freedom.
    pub prescribed: Vec<PrescribedDof>,
    /// Motions that strain nothing with everything held still, over p.
    pub rigid: Vec<Vec<f64>>,
    rows: ConstraintRows,
}

/// Machine, operating point and linear model from which the coordinates are built.
pub(super) struct CoordinateInput<'a> {
    pub machine: &'a Machine,
    pub operating: &'a OperatingPoint,
    pub model: &'a LinearModel,
}

impl ConstrainedCoordinates {
    pub fn new(from: &CoordinateInput, ports: &Ports) -> Result<ConstrainedCoordinates, Error> {
        let model = fixed_rows(from.machine, ports);
        let (mut machine, mut tied) = (from.machine.clone(), from.machine.clone());
        for what in &model {
            match *what {
                // A stiffness so that nothing hangs loose meanwhile; it is taken out below.
                PrescribedDof::Joint(branch) => {
                    machine.branches[branch].law = BranchLaw::Linear {
                        stiffness: 1.0,
                        loss: BranchDamping::None,
                    }
                }
                PrescribedDof::Dof(dof) => tied.branches.push(Branch {
                    element: tied.nodes[tied.dofs[dof].node].element,
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
        let joints = model
            .iter()
            .any(|what| matches!(what, PrescribedDof::Joint(_)));
        let dofs = model
            .iter()
            .any(|what| matches!(what, PrescribedDof::Dof(_)));
        let again = |machine: &Machine| -> Result<LinearModel, Error> {
            let mut linear_model =
                LinearModel::new(machine, &Kinematics::new(machine)?, from.operating)?;
            // A damping ratio refers to the masses of the machine as it is.
            for branch in &mut linear_model.branches {
                let own = from.model.branch(branch.index);
                branch.damping = own.map_or(branch.damping, |b| b.damping);
            }
            Ok(linear_model)
        };
        let linear_model = if joints {
            again(&machine)?
        } else {
            from.model.clone()
        };
        let still = if dofs {
            again(&tied)?
        } else {
            from.model.clone()
        };
        let released = |b: &LinearBranch| model.contains(&PrescribedDof::Joint(b.index));
        let mut linear_model = linear_model;
        linear_model.branches.retain(|b| !released(b));
        let rows = ConstraintRows::new(&machine, &linear_model, &model)?;
        let rigid = still
            .rigid
            .iter()
            .map(|r| linear_model.select_independent(&still.expand(r)))
            .collect();
        Ok(ConstrainedCoordinates {
            machine,
            model: linear_model,
            fixed: still,
            prescribed: model,
            rigid,
            rows,
        })
    }

    /// Columns of `[T_r, T_h]` over rigid motions and single coordinates of p.
    pub fn sparse_basis(&self) -> Vec<SparseVector> {
        let mut taken = self.rows.pivots.clone();
        let mut rigid: Vec<Vec<f64>> = self.rigid.clone();
        for at in 0..rigid.len() {
            let free = (0..self.model.n).filter(|j| !taken.contains(j));
            let Some(pivot) =
                free.max_by(|&a, &b| rigid[at][a].abs().total_cmp(&rigid[at][b].abs()))
            else {
                continue;
            };
            taken.push(pivot);
            let (done, rest) = rigid.split_at_mut(at + 1);
            for other in rest {
                let factor = other[pivot] / done[at][pivot];
                other
                    .iter_mut()
                    .zip(&done[at])
                    .for_each(|(x, y)| *x -= factor * y);
            }
        }
        let mut free = vec![true; self.model.n];
        taken.iter().for_each(|&j| free[j] = false);
        let alone = (0..self.model.n)
            .filter(|&j| free[j])
            .map(|j| self.rows.free_motion(j));
        let imposed = (0..self.prescribed.len()).map(|h| self.rows.imposed(h));
        let rigid = self.rigid.iter().map(|r| sparse(r.iter().copied()));
        rigid.chain(alone).chain(imposed).collect()
    }

    /// `[T_r, T_h]` over modes of the machine with everything held still, and its coordinates without inertia.
    pub fn modal_basis(&self, basis: &ModalBasis) -> Matrix {
        let over = |p: &[f64]| self.model.select_independent(&self.fixed.expand(p));
        let modes = (0..basis.omega.len()).map(|k| over(&column(&basis.shapes, k)));
        let light = self.fixed.massless.iter().map(|&j| {
            let mut unit = vec![0.0; self.fixed.n];
            unit[j] = 1.0;
            over(&unit)
        });
        let imposed = (0..self.prescribed.len()).map(|h| {
            let mut column = vec![0.0; self.model.n];
            (self.rows.imposed(h).iter()).for_each(|&(j, a)| column[j] = a);
            column
        });
        let columns: Vec<Vec<f64>> = modes.chain(light).chain(imposed).collect();
        Matrix::from_fn(self.model.n, columns.len(), |i, j| columns[j][i])
    }

    /// Modes of the machine itself over p, for modal damping.
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
    let all = column.into_iter().enumerate();
    all.filter(|term| term.1 != 0.0).collect()
}

/// Held degrees of freedom and joints that an input moves or whose force is measured, each once.
fn fixed_rows(machine: &Machine, ports: &Ports) -> Vec<PrescribedDof> {
    let rigid = |branch: usize| machine.branches[branch].law == BranchLaw::Rigid;
    let mut all: Vec<PrescribedDof> = ports
        .fixed
        .iter()
        .map(|&dof| PrescribedDof::Dof(dof))
        .collect();
    for input in &ports.inputs {
        match input.kind {
            ResponseInput::Motion(dof) => all.push(PrescribedDof::Dof(dof)),
            ResponseInput::Displacement(branch) if rigid(branch) => {
                all.push(PrescribedDof::Joint(branch))
            }
            _ => {}
        }
    }
    for output in &ports.outputs {
        match output.kind {
            ResponseOutput::Force(branch) if rigid(branch) => {
                all.push(PrescribedDof::Joint(branch))
            }
            _ => {}
        }
    }
    let mut once: Vec<PrescribedDof> = Vec::new();
    all.into_iter().for_each(|what| {
        if !once.contains(&what) {
            once.push(what);
        }
    });
    once
}

/// The rows solved for one coordinate each: `p_pivot = Σ imposed h − Σ others p`.
struct ConstraintRows {
    pivots: Vec<usize>,
    others: Vec<Vec<f64>>,
    imposed: Vec<Vec<f64>>,
}

/// Rank tolerance relative to the size of a row: a dependent row leaves the rounding of whole numbers of teeth.
const DEPENDENT: f64 = 1e-11;

impl ConstraintRows {
    fn new(
        machine: &Machine,
        model: &LinearModel,
        held: &[PrescribedDof],
    ) -> Result<ConstraintRows, Error> {
        let mut rows = ConstraintRows {
            pivots: Vec::new(),
            others: Vec::new(),
            imposed: Vec::new(),
        };
        for (number, what) in held.iter().enumerate() {
            let mut row = vec![0.0; model.n];
            let direction = match *what {
                PrescribedDof::Dof(dof) => Direction::unit(dof),
                PrescribedDof::Joint(branch) => machine.branches[branch].direction.clone(),
            };
            for (dof, a) in direction.entries() {
                for &(j, b) in &model.transform[dof] {
                    row[j] += a * b;
                }
            }
            let size = row.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let mut share = vec![0.0; held.len()];
            share[number] = 1.0;
            for (at, &pivot) in rows.pivots.iter().enumerate() {
                let factor = row[pivot];
                row.iter_mut()
                    .zip(&rows.others[at])
                    .for_each(|(x, y)| *x -= factor * y);
                share
                    .iter_mut()
                    .zip(&rows.imposed[at])
                    .for_each(|(x, y)| *x -= factor * y);
            }
            let largest = (0..model.n).max_by(|&a, &b| row[a].abs().total_cmp(&row[b].abs()));
            let Some(pivot) = largest.filter(|&j| row[j].abs() > DEPENDENT * size) else {
                return Err(overdetermined_error(machine, *what));
            };
            let lead = row[pivot];
            row.iter_mut()
                .chain(share.iter_mut())
                .for_each(|x| *x /= lead);
            for at in 0..rows.pivots.len() {
                let factor = rows.others[at][pivot];
                rows.others[at]
                    .iter_mut()
                    .zip(&row)
                    .for_each(|(x, y)| *x -= factor * y);
                rows.imposed[at]
                    .iter_mut()
                    .zip(&share)
                    .for_each(|(x, y)| *x -= factor * y);
            }
            rows.pivots.push(pivot);
            rows.others.push(row);
            rows.imposed.push(share);
        }
        Ok(rows)
    }

    /// Coordinate j moves alone, and what the rows make follow it.
    fn free_motion(&self, j: usize) -> SparseVector {
        let follow = self.pivots.iter().zip(&self.others);
        sum_duplicates(
            std::iter::once((j, 1.0)).chain(follow.map(|(&pivot, row)| (pivot, -row[j]))),
        )
    }

    /// Row h moves by one.
    fn imposed(&self, h: usize) -> SparseVector {
        let follow = self.pivots.iter().zip(&self.imposed);
        sum_duplicates(follow.map(|(&pivot, share)| (pivot, share[h])))
    }
}

fn overdetermined_error(machine: &Machine, what: PrescribedDof) -> Error {
    match what {
        PrescribedDof::Dof(dof) => {
            let message = format!(
                "{} cannot be prescribed: rigid joints or another prescribed motion hold it already",
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
