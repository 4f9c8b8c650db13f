//! Partition into retained (m) and condensed (s) coordinates: constraint modes `Ψ = −K_ss⁻¹ K_sm` and fixed-interface modes.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::components::Mass;
use crate::machine::direction::Direction;
use crate::machine::linear::LinearModel;
use crate::modes::modal_basis::{self, ModalBasis, UndampedSolver};
use crate::numeric::{Matrix, graded, symmetric};

/// Partition of the independent coordinates into retained and condensed ones.
pub struct CoordinatePartition {
    /// Indices of the retained coordinates, in the order of the request.
    pub retained: Vec<usize>,
    /// Indices of the condensed coordinates, ascending.
    pub condensed: Vec<usize>,
}

impl CoordinatePartition {
    /// Splits the coordinates of a model into `masters` and the others.
    ///
    /// # Errors
    /// `OutOfRange` for a coordinate that does not exist or is listed twice.
    pub fn new(model: &LinearModel, masters: &[usize]) -> Result<CoordinatePartition, Error> {
        let mut is_master = vec![false; model.n];
        for &j in masters {
            if j >= model.n || is_master[j] {
                let message = format!(
                    "coordinate {j} of {} is named twice or does not exist",
                    model.n
                );
                return Err(Error::new(Code::OutOfRange, message)
                    .with_hint("name each kept coordinate once"));
            }
            is_master[j] = true;
        }
        let slaves = (0..model.n).filter(|&j| !is_master[j]).collect();
        Ok(CoordinatePartition {
            retained: masters.to_vec(),
            condensed: slaves,
        })
    }

    /// Constraint modes Ψ over all coordinates: static response to unit displacements of the retained ones; `K_ss` is never formed.
    ///
    /// # Errors
    /// `Disconnected` if a condensed coordinate can move freely with the retained ones fixed.
    pub fn constraint_modes(&self, model: &LinearModel) -> Result<Matrix, Error> {
        let order: Vec<usize> = self
            .condensed
            .iter()
            .chain(&self.retained)
            .copied()
            .collect();
        let mut index = vec![0; model.n];
        order.iter().enumerate().for_each(|(at, &j)| index[j] = at);
        let springs: Vec<_> = model
            .branches
            .iter()
            .filter(|b| b.stiffness > 0.0 && b.force.is_none())
            .collect();
        let mut rows = Matrix::zeros(springs.len().max(1), model.n);
        for (i, branch) in springs.iter().enumerate() {
            branch
                .direction
                .entries()
                .for_each(|(j, a)| rows[(i, index[j])] += branch.stiffness.sqrt() * a);
        }
        let condensation = graded::condense(&rows, self.condensed.len())?;
        if let Some(unrestrained) = condensation.singular {
            return Err(unrestrained_error(self.condensed[unrestrained]));
        }
        let mut psi = Matrix::zeros(model.n, self.retained.len());
        for k in 0..self.retained.len() {
            psi[(self.retained[k], k)] = 1.0;
            self.condensed
                .iter()
                .enumerate()
                .for_each(|(i, &j)| psi[(j, k)] = condensation.recovery[(i, k)]);
        }
        Ok(psi)
    }

    /// Fixed-interface modes over the condensed coordinates.
    ///
    /// # Errors
    /// Those of [`modal_basis::solve`]; `Disconnected` as for the constraint modes.
    pub fn fixed_modes(&self, model: &LinearModel) -> Result<ModalBasis, Error> {
        let fixed = self.fixed_model(model);
        if fixed.n == fixed.massless.len() {
            return Ok(ModalBasis::empty(fixed.n));
        }
        let basis = modal_basis::solve(&fixed, UndampedSolver::Factored)?;
        match basis.omega.first() {
            Some(&lowest) if lowest <= 0.0 => Err(unrestrained_error(self.condensed[0])),
            _ => Ok(basis),
        }
    }

    /// Flexibility `K_ss⁻¹` with fixed retained coordinates, over all coordinates; zero in the rows and columns of the retained ones.
    ///
    /// # Errors
    /// `Indefinite` if K_ss is singular.
    pub fn flexibility(&self, model: &LinearModel) -> Result<Matrix, Error> {
        let k = elastic_stiffness(model);
        let s = &self.condensed;
        let k_ss = Matrix::from_fn(s.len(), s.len(), |i, j| k[(s[i], s[j])]);
        let inverse = symmetric::lu_solve(&k_ss, &Matrix::identity(s.len(), s.len()))?;
        let mut g = Matrix::zeros(model.n, model.n);
        (0..s.len()).for_each(|j| (0..s.len()).for_each(|i| g[(s[i], s[j])] = inverse[(i, j)]));
        Ok(g)
    }

    /// Model with the retained coordinates fixed.
    fn fixed_model(&self, model: &LinearModel) -> LinearModel {
        let mut index = vec![None; model.n];
        self.condensed
            .iter()
            .enumerate()
            .for_each(|(at, &j)| index[j] = Some(at));
        let restrict = |d: &Direction| {
            let terms = d
                .terms
                .iter()
                .filter_map(|&(j, a)| index[j].map(|at| (at, a)))
                .collect();
            Direction {
                scale: d.scale,
                terms,
            }
        };
        let branches = model.branches.iter().filter(|b| b.force.is_none());
        let mut branches: Vec<_> = branches
            .map(|b| crate::machine::linear::LinearBranch {
                direction: restrict(&b.direction),
                ..b.clone()
            })
            .collect();
        branches.retain(|b| !b.direction.terms.is_empty());
        let masses = model.masses.iter().map(|m| Mass {
            direction: restrict(&m.direction),
            ..m.clone()
        });
        LinearModel {
            n: self.condensed.len(),
            independent_dofs: self
                .condensed
                .iter()
                .map(|&j| model.independent_dofs[j])
                .collect(),
            transform: Vec::new(),
            masses: masses.filter(|m| !m.direction.terms.is_empty()).collect(),
            branches,
            rigid: Vec::new(),
            n_undamped_rigid: 0,
            massless: model.massless.iter().filter_map(|&j| index[j]).collect(),
        }
    }
}

/// Stiffness `Σ k w wᵀ` of the springs over the independent coordinates.
pub fn elastic_stiffness(model: &LinearModel) -> Matrix {
    let mut k = Matrix::zeros(model.n, model.n);
    for branch in model
        .branches
        .iter()
        .filter(|b| b.stiffness > 0.0 && b.force.is_none())
    {
        for (i, a) in branch.direction.entries() {
            branch
                .direction
                .entries()
                .for_each(|(j, b)| k[(i, j)] += branch.stiffness * a * b);
        }
    }
    k
}

fn unrestrained_error(coordinate: usize) -> Error {
    let message = format!("coordinate {coordinate} is still free to move with the kept ones fixed");
    Error::new(Code::Disconnected, message)
        .with_hint("keep at least one coordinate of every part that moves freely")
}
