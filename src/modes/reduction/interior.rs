//! Interior coordinates between kept ones: how they follow statically, and how they swing while the kept ones stand.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::direction::Direction;
use crate::machine::linear::Linear;
use crate::machine::parts::Mass;
use crate::modes::basis::{self, Basis, Solver};
use crate::numeric::{Matrix, definite, graded};

/// Kept coordinates and the others.
pub struct Interior {
    /// Kept.
    pub masters: Vec<usize>,
    /// The rest.
    pub slaves: Vec<usize>,
}

impl Interior {
    /// Splits the coordinates.
    ///
    /// # Errors
    /// `OutOfRange` for a coordinate that is not there, or twice.
    pub fn new(linear: &Linear, masters: &[usize]) -> Result<Interior, Error> {
        let mut is_master = vec![false; linear.n];
        for &j in masters {
            if j >= linear.n || is_master[j] {
                let message = format!(
                    "coordinate {j} of {} is named twice or does not exist",
                    linear.n
                );
                return Err(
                    Error::new(Code::OutOfRange, message).hint("name each kept coordinate once")
                );
            }
            is_master[j] = true;
        }
        let slaves = (0..linear.n).filter(|&j| !is_master[j]).collect();
        Ok(Interior {
            masters: masters.to_vec(),
            slaves,
        })
    }

    /// Ψ over all coordinates: unit motions of the kept ones, the others following statically. `K_ss` is never formed.
    ///
    /// # Errors
    /// `Disconnected` where the kept coordinates leave something free to move.
    pub fn constraint_modes(&self, linear: &Linear) -> Result<Matrix, Error> {
        let order: Vec<usize> = self.slaves.iter().chain(&self.masters).copied().collect();
        let mut place = vec![0; linear.n];
        order.iter().enumerate().for_each(|(at, &j)| place[j] = at);
        let squares: Vec<_> = linear
            .branches
            .iter()
            .filter(|b| b.stiffness > 0.0 && b.force.is_none())
            .collect();
        let mut rows = Matrix::zeros(squares.len().max(1), linear.n);
        for (i, branch) in squares.iter().enumerate() {
            branch
                .direction
                .scaled()
                .for_each(|(j, a)| rows[(i, place[j])] += branch.stiffness.sqrt() * a);
        }
        let follow = graded::eliminate(&rows, self.slaves.len())?;
        if let Some(loose) = follow.singular {
            return Err(loose_error(self.slaves[loose]));
        }
        let mut psi = Matrix::zeros(linear.n, self.masters.len());
        for k in 0..self.masters.len() {
            psi[(self.masters[k], k)] = 1.0;
            self.slaves
                .iter()
                .enumerate()
                .for_each(|(i, &j)| psi[(j, k)] = follow.recovery[(i, k)]);
        }
        Ok(psi)
    }

    /// Modes with the kept coordinates at rest, over the interior ones.
    ///
    /// # Errors
    /// Those of [`basis::solve`]; `Disconnected` as above.
    pub fn fixed_modes(&self, linear: &Linear) -> Result<Basis, Error> {
        let fixed = self.fixed(linear);
        if fixed.n == fixed.massless.len() {
            return Ok(Basis::none(fixed.n));
        }
        let basis = basis::solve(&fixed, Solver::Factored)?;
        match basis.omega.first() {
            Some(&lowest) if lowest <= 0.0 => Err(loose_error(self.slaves[0])),
            _ => Ok(basis),
        }
    }

    /// `K_ss⁻¹` over all coordinates, nil for the kept ones: the flexibility that is left inside.
    ///
    /// # Errors
    /// `Indefinite` where K_ss is singular.
    pub fn flexibility(&self, linear: &Linear) -> Result<Matrix, Error> {
        let k = squares_stiffness(linear);
        let s = &self.slaves;
        let inner = Matrix::from_fn(s.len(), s.len(), |i, j| k[(s[i], s[j])]);
        let inverse = definite::solve(&inner, &Matrix::identity(s.len(), s.len()))?;
        let mut all = Matrix::zeros(linear.n, linear.n);
        (0..s.len()).for_each(|j| (0..s.len()).for_each(|i| all[(s[i], s[j])] = inverse[(i, j)]));
        Ok(all)
    }

    /// The machine with the kept coordinates at rest.
    fn fixed(&self, linear: &Linear) -> Linear {
        let mut place = vec![None; linear.n];
        self.slaves
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
        let branches = linear.branches.iter().filter(|b| b.force.is_none());
        let mut branches: Vec<_> = branches
            .map(|b| crate::machine::linear::LinearBranch {
                direction: cut(&b.direction),
                ..b.clone()
            })
            .collect();
        branches.retain(|b| !b.direction.terms.is_empty());
        let masses = linear.masses.iter().map(|m| Mass {
            direction: cut(&m.direction),
            ..m.clone()
        });
        Linear {
            n: self.slaves.len(),
            free: self.slaves.iter().map(|&j| linear.free[j]).collect(),
            transform: Vec::new(),
            masses: masses.filter(|m| !m.direction.terms.is_empty()).collect(),
            branches,
            rigid: Vec::new(),
            n_undamped_rigid: 0,
            massless: linear.massless.iter().filter_map(|&j| place[j]).collect(),
        }
    }
}

/// `Σ k w wᵀ` over the springs.
pub fn squares_stiffness(linear: &Linear) -> Matrix {
    let mut k = Matrix::zeros(linear.n, linear.n);
    for branch in linear
        .branches
        .iter()
        .filter(|b| b.stiffness > 0.0 && b.force.is_none())
    {
        for (i, a) in branch.direction.scaled() {
            branch
                .direction
                .scaled()
                .for_each(|(j, b)| k[(i, j)] += branch.stiffness * a * b);
        }
    }
    k
}

fn loose_error(coordinate: usize) -> Error {
    let message = format!("coordinate {coordinate} is still free to move when the kept ones stand");
    Error::new(Code::Disconnected, message)
        .hint("keep at least one coordinate of every part that moves freely")
}
