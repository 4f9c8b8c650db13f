//! Partition into retained and condensed coordinates; constraint modes, fixed-interface modes.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::components::Mass;
use crate::machine::direction::Direction;
use crate::machine::linear::LinearModel;
use crate::modes::modal_basis::{self, ModalBasis, UndampedSolver};
use crate::numeric::{Matrix, graded, symmetric};

/// Kept coordinates and the others.
pub struct CoordinatePartition {
    /// Kept.
    pub retained: Vec<usize>,
    /// The rest.
    pub condensed: Vec<usize>,
}

impl CoordinatePartition {
    /// Splits the coordinates.
    ///
    /// # Errors
    /// `OutOfRange` for a coordinate that is not there, or twice.
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

    /// Ψ over all coordinates: unit motions of the kept ones, the others following statically. `K_ss` is never formed.
    ///
    /// # Errors
    /// `Disconnected` where the kept coordinates leave something free to move.
    pub fn constraint_modes(&self, model: &LinearModel) -> Result<Matrix, Error> {
        let order: Vec<usize> = self
            .condensed
            .iter()
            .chain(&self.retained)
            .copied()
            .collect();
        let mut place = vec![0; model.n];
        order.iter().enumerate().for_each(|(at, &j)| place[j] = at);
        let squares: Vec<_> = model
            .branches
            .iter()
            .filter(|b| b.stiffness > 0.0 && b.force.is_none())
            .collect();
        let mut rows = Matrix::zeros(squares.len().max(1), model.n);
        for (i, branch) in squares.iter().enumerate() {
            branch
                .direction
                .entries()
                .for_each(|(j, a)| rows[(i, place[j])] += branch.stiffness.sqrt() * a);
        }
        let follow = graded::condense(&rows, self.condensed.len())?;
        if let Some(loose) = follow.singular {
            return Err(loose_error(self.condensed[loose]));
        }
        let mut psi = Matrix::zeros(model.n, self.retained.len());
        for k in 0..self.retained.len() {
            psi[(self.retained[k], k)] = 1.0;
            self.condensed
                .iter()
                .enumerate()
                .for_each(|(i, &j)| psi[(j, k)] = follow.recovery[(i, k)]);
        }
        Ok(psi)
    }

    /// Modes with the kept coordinates at rest, over the interior ones.
    ///
    /// # Errors
    /// Those of [`basis::lu_solve`]; `Disconnected` as above.
    pub fn fixed_modes(&self, model: &LinearModel) -> Result<ModalBasis, Error> {
        let fixed = self.fixed(model);
        if fixed.n == fixed.massless.len() {
            return Ok(ModalBasis::empty(fixed.n));
        }
        let basis = modal_basis::solve(&fixed, UndampedSolver::Factored)?;
        match basis.omega.first() {
            Some(&lowest) if lowest <= 0.0 => Err(loose_error(self.condensed[0])),
            _ => Ok(basis),
        }
    }

    /// `K_ss⁻¹` over all coordinates, nil for the kept ones: the flexibility that is left inside.
    ///
    /// # Errors
    /// `Indefinite` where K_ss is singular.
    pub fn flexibility(&self, model: &LinearModel) -> Result<Matrix, Error> {
        let k = elastic_stiffness(model);
        let s = &self.condensed;
        let inner = Matrix::from_fn(s.len(), s.len(), |i, j| k[(s[i], s[j])]);
        let inverse = symmetric::lu_solve(&inner, &Matrix::identity(s.len(), s.len()))?;
        let mut all = Matrix::zeros(model.n, model.n);
        (0..s.len()).for_each(|j| (0..s.len()).for_each(|i| all[(s[i], s[j])] = inverse[(i, j)]));
        Ok(all)
    }

    /// The machine with the kept coordinates at rest.
    fn fixed(&self, model: &LinearModel) -> LinearModel {
        let mut place = vec![None; model.n];
        self.condensed
            .iter()
            .enumerate()
            .for_each(|(at, &j)| place[j] = Some(at));
        let cut = |d: &Direction| {
            let terms = d
                .terms
                .iter()
                .filter_map(|&(j, a)| place[j].map(|at| (at, a)))
                .collect();
            Direction {
                scale: d.scale,
                terms,
            }
        };
        let branches = model.branches.iter().filter(|b| b.force.is_none());
        let mut branches: Vec<_> = branches
            .map(|b| crate::machine::linear::LinearBranch {
                direction: cut(&b.direction),
                ..b.clone()
            })
            .collect();
        branches.retain(|b| !b.direction.terms.is_empty());
        let masses = model.masses.iter().map(|m| Mass {
            direction: cut(&m.direction),
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
            massless: model.massless.iter().filter_map(|&j| place[j]).collect(),
        }
    }
}

/// `Σ k w wᵀ` over the springs.
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

fn loose_error(coordinate: usize) -> Error {
    let message = format!("coordinate {coordinate} is still free to move with the kept ones fixed");
    Error::new(Code::Disconnected, message)
        .with_hint("keep at least one coordinate of every part that moves freely")
}
