//! Undamped modes of `K = Wᵀ diag(k) W`: symmetric eigenproblem with frequencies from energies, or singular values of the factored form.
//!
//! Both keep the digits of small frequencies next to large ones: the first as [`energy_modes`] says, the second because the frequencies
//! are the singular values of `√k W L⁻ᵀ`, `M = L Lᵀ`, and K is never formed. Coordinates without inertia are condensed in that factored form.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::direction::Direction;
use crate::machine::linear::{LinearBranch, LinearModel};
use crate::numeric::energy_modes::{EnergyModes, Expansion, MAX_BOUND, Squares, energy_modes};
use crate::numeric::mass_factor::MassFactor;
use crate::numeric::{Matrix, graded, symmetric};

/// Solver of the undamped eigenvalue problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum UndampedSolver {
    /// Symmetric eigenproblem, frequencies from energies; the factored form where their bound is too large. Shapes have of each other what
    /// gives their strains a cosine of this at most.
    Symmetric(f64),
    /// Singular values of the factored form: row-sorted QR, then one-sided Jacobi. Shapes are as right as the frequencies.
    Factored,
}

/// Undamped modes over the independent coordinates.
#[derive(Debug, Clone)]
pub struct ModalBasis {
    /// rad/s, ascending; the first `n_rigid` are exactly zero.
    pub omega: Vec<f64>,
    /// Rigid-body modes.
    pub n_rigid: usize,
    /// Columns: mass-normalised shapes over all independent coordinates, the massless ones following statically.
    pub shapes: Matrix,
    /// Decimal digits each frequency can be trusted to.
    pub digits: Vec<f64>,
    /// Solver that found the modes.
    pub solution: BasisSolution,
}

/// Solver that found a basis, with what it says of its frequencies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BasisSolution {
    /// Energies of the modes of a symmetric eigenproblem.
    Symmetric {
        /// Bound of the relative error of any frequency.
        bound: f64,
        /// Number of modes that were rotated.
        n_rotated: usize,
    },
    /// Singular values of the factored form.
    Factored,
}

impl ModalBasis {
    /// No modes, over `n` coordinates.
    pub fn empty(n: usize) -> ModalBasis {
        ModalBasis {
            omega: Vec::new(),
            n_rigid: 0,
            shapes: Matrix::zeros(n, 0),
            digits: Vec::new(),
            solution: BasisSolution::Factored,
        }
    }
}

/// Digits of the factored form: the worst relative error over chains, trees and loops with stiffness spread 1e14 and inertia
/// spread 1e12 in tests/machine/numeric_graded.rs is below 1e-14, of assembled machines in tests/machine/graded_machines.rs below 1e-13.
const FACTORED_DIGITS: f64 = 13.0;

/// Tolerance of shapes that are listed and read, and feed no further solution.
pub const LISTED_SHAPE_TOLERANCE: f64 = 1e-9;

/// A frequency above this share of the largest is no rounding of a zero.
const STRAINED: f64 = 1e-6;

/// Solves for every mode.
///
/// # Errors
/// A mass matrix that is not positive definite; numbers out of range; no convergence.
pub fn solve(model: &LinearModel, solver: UndampedSolver) -> Result<ModalBasis, Error> {
    let order = CoordinateOrder::new(model);
    let condensed = match model.massless.len() {
        0 => None,
        first => Some(graded::condense(&strain_rows(model, &order), first)?),
    };
    let mass_factor = mass_factor(model, &order)?;
    let rigid = rigid_modes(model);
    let frame = ScaledEigenproblem {
        model,
        order: &order,
        condensed,
        mass_factor,
        rigid,
    };
    if let UndampedSolver::Symmetric(shape_tolerance) = solver
        && let Some(basis) = frame.by_energies(shape_tolerance)?
    {
        return Ok(basis);
    }
    frame.by_factored_form()
}

/// `√k W`, a row for each square, a column for each coordinate in their sorted order.
fn strain_rows(model: &LinearModel, order: &CoordinateOrder) -> Matrix {
    let squares: Vec<&LinearBranch> = squares(model).collect();
    let mut rows = Matrix::zeros(squares.len(), model.n);
    for (i, branch) in squares.iter().enumerate() {
        let root = branch.stiffness.sqrt();
        for (j, a) in branch.direction.entries() {
            rows[(i, order.position[j])] += root * a;
        }
    }
    rows
}

/// Branches whose strain energy is `½ k (wᵀp)²`.
fn squares(model: &LinearModel) -> impl Iterator<Item = &LinearBranch> {
    let all = model.branches.iter();
    all.filter(|b| b.stiffness > 0.0 && b.force.is_none())
}

/// A machine ready for either solver.
struct ScaledEigenproblem<'a> {
    model: &'a LinearModel,
    order: &'a CoordinateOrder,
    /// Without the coordinates that have no inertia, where there are any.
    condensed: Option<graded::StaticCondensation>,
    mass_factor: MassFactor,
    rigid: Vec<Vec<f64>>,
}

impl ScaledEigenproblem<'_> {
    /// `None` where the bound of an error is too large.
    fn by_energies(&self, shape_tolerance: f64) -> Result<Option<ModalBasis>, Error> {
        let first = self.model.massless.len();
        let mut springs = Squares::default();
        for branch in squares(self.model) {
            self.push(&mut springs, branch.stiffness, &branch.direction);
        }
        let expansion = self.expansion();
        let rigid = self.rigid.iter().map(|p| {
            let heavy: Vec<f64> = (self.order.coordinates[first..].iter().map(|&i| p[i])).collect();
            self.mass_factor.transposed_times(&heavy)
        });
        let rigid: Vec<Vec<f64>> = rigid.collect();
        let Some(found) = energy_modes(&springs, &expansion, &rigid, shape_tolerance)? else {
            return Ok(None);
        };
        let EnergyModes {
            omega,
            vectors,
            bounds,
            n_rotated,
        } = found;
        let bound = bounds.iter().copied().fold(0.0, f64::max);
        let lowest = omega.first().copied().unwrap_or(f64::INFINITY);
        // Branches that are no squares may hold what the squares alone leave free.
        let all_strained = self.model.is_sum_of_squares()
            || lowest > STRAINED * omega.last().copied().unwrap_or(0.0);
        if !(all_strained && bounds.iter().all(|b| *b <= MAX_BOUND)) {
            return Ok(None);
        }
        let shapes = expansion.product(&vectors);
        let solution = BasisSolution::Symmetric { bound, n_rotated };
        let column = |j: usize| shapes.col_as_slice(j);
        self.basis(omega, column, solution).map(Some)
    }

    /// E of `x = E y` over the sorted coordinates.
    fn expansion(&self) -> Expansion {
        if let (None, MassFactor::Diagonal(root)) = (&self.condensed, &self.mass_factor) {
            return Expansion::Diagonal(root.iter().map(|root| 1.0 / root).collect());
        }
        let mut masses = Squares::default();
        for mass in &self.model.masses {
            self.push(&mut masses, mass.value, &mass.direction);
        }
        let n = self.model.n - self.model.massless.len();
        let heavy = self.mass_factor.solve_transposed(&Matrix::identity(n, n));
        Expansion::Dense(self.with_light(heavy), masses)
    }

    /// A square over the sorted coordinates; the scale of a direction goes to the root, so that whole coefficients stay whole.
    fn push(&self, squares: &mut Squares, value: f64, direction: &Direction) {
        let terms = direction.terms.iter();
        let terms = terms.map(|&(j, a)| (self.order.position[j], a));
        squares.push(value.sqrt() * direction.scale.abs(), terms);
    }

    /// Puts what follows statically on top of the coordinates with inertia.
    fn with_light(&self, heavy: Matrix) -> Matrix {
        let Some(condensed) = &self.condensed else {
            return heavy;
        };
        let light = symmetric::product(&condensed.recovery, &heavy);
        let first = light.nrows();
        Matrix::from_fn(first + heavy.nrows(), heavy.ncols(), |i, j| {
            match i.checked_sub(first) {
                Some(i) => heavy[(i, j)],
                None => light[(i, j)],
            }
        })
    }

    fn by_factored_form(&self) -> Result<ModalBasis, Error> {
        let n = self.model.n - self.model.massless.len();
        let n_rigid = self.rigid.len();
        let scaled = match &self.condensed {
            Some(condensed) => self.mass_factor.right_divide(&condensed.condensed),
            None => self
                .mass_factor
                .right_divide(&strain_rows(self.model, self.order)),
        };
        let found = graded::svd(&scaled, Some(n - n_rigid))?;
        let shapes = self.with_light(self.mass_factor.solve_transposed(&found.vectors));
        let column = |j: usize| shapes.col_as_slice(n_rigid + j);
        self.basis(
            found.values[n_rigid..].to_vec(),
            column,
            BasisSolution::Factored,
        )
    }

    /// Rigid-body modes and the elastic ones, whose shapes are given over the sorted coordinates.
    fn basis<'x>(
        &self,
        elastic: Vec<f64>,
        shape: impl Fn(usize) -> &'x [f64],
        solution: BasisSolution,
    ) -> Result<ModalBasis, Error> {
        let (n_rigid, n) = (self.rigid.len(), self.rigid.len() + elastic.len());
        let mut shapes = Matrix::zeros(self.model.n, n);
        for (j, rigid) in self.rigid.iter().enumerate() {
            shapes.col_as_slice_mut(j).copy_from_slice(rigid);
        }
        for j in 0..elastic.len() {
            let column = shapes.col_as_slice_mut(n_rigid + j);
            let both = self.order.coordinates.iter().zip(shape(j));
            both.for_each(|(&i, x)| column[i] = *x);
        }
        let omega: Vec<f64> = std::iter::repeat_n(0.0, n_rigid).chain(elastic).collect();
        if let Some(bad) = omega.iter().position(|w| !w.is_finite()) {
            return Err(Error::new(
                Code::Overflow,
                format!("frequency {} of {n} is out of range", bad + 1),
            ));
        }
        let digits = |w: &f64| match *w == 0.0 {
            true => f64::INFINITY,
            false => FACTORED_DIGITS,
        };
        Ok(ModalBasis {
            digits: omega.iter().map(digits).collect(),
            omega,
            n_rigid,
            shapes,
            solution,
        })
    }
}

/// Coordinates sorted: those without inertia first.
struct CoordinateOrder {
    /// Coordinates in the sorted order.
    coordinates: Vec<usize>,
    /// Place of each coordinate in it.
    position: Vec<usize>,
}

impl CoordinateOrder {
    fn new(model: &LinearModel) -> CoordinateOrder {
        let mut light = vec![false; model.n];
        model.massless.iter().for_each(|&j| light[j] = true);
        let heavy = (0..model.n).filter(|&j| !light[j]);
        let coordinates: Vec<usize> = model.massless.iter().copied().chain(heavy).collect();
        let mut position = vec![0; model.n];
        coordinates
            .iter()
            .enumerate()
            .for_each(|(place, &j)| position[j] = place);
        CoordinateOrder {
            coordinates,
            position,
        }
    }
}

/// `M = L Lᵀ` over the coordinates with inertia.
fn mass_factor(model: &LinearModel, order: &CoordinateOrder) -> Result<MassFactor, Error> {
    let first = model.massless.len();
    if let Some(diagonal) = model.mass_diagonal() {
        let heavy = order.coordinates[first..].iter();
        return Ok(MassFactor::diagonal(heavy.map(|&j| diagonal[j])));
    }
    let n = model.n - first;
    let mut m = Matrix::zeros(n, n);
    for mass in &model.masses {
        for (i, a) in mass.direction.entries() {
            for (j, b) in mass.direction.entries() {
                m[(order.position[i] - first, order.position[j] - first)] += mass.value * a * b;
            }
        }
    }
    MassFactor::full(&m)
}

/// The motions that strain nothing, M-orthonormal, in their order.
pub fn rigid_modes(model: &LinearModel) -> Vec<Vec<f64>> {
    let mut modes: Vec<Vec<f64>> = Vec::with_capacity(model.rigid.len());
    for motion in &model.rigid {
        let mut r = motion.clone();
        // Twice is enough (Giraud, Langou & Rozložník 2005, Numer. Math. 101, 87).
        for _ in 0..2 {
            for done in &modes {
                let share = mass_product(model, done, &r);
                r.iter_mut().zip(done).for_each(|(x, d)| *x -= share * d);
            }
        }
        let norm = mass_product(model, &r, &r).sqrt();
        if norm > 0.0 {
            r.iter_mut().for_each(|x| *x /= norm);
            modes.push(r);
        }
    }
    modes
}

/// `aᵀ M b` over the independent coordinates.
pub fn mass_product(model: &LinearModel, a: &[f64], b: &[f64]) -> f64 {
    model
        .masses
        .iter()
        .map(|mass| mass.value * mass.direction.dot(a) * mass.direction.dot(b))
        .sum()
}

/// Column j of a matrix as a vector.
pub fn column(matrix: &Matrix, j: usize) -> Vec<f64> {
    (0..matrix.nrows()).map(|i| matrix[(i, j)]).collect()
}

/// `wᵀΦ`, a direction projected on every mode.
pub fn project_direction(direction: &Direction, shapes: &Matrix) -> Vec<f64> {
    (0..shapes.ncols())
        .map(|j| direction.entries().map(|(i, a)| a * shapes[(i, j)]).sum())
        .collect()
}

/// The same, exactly zero for each of the first `n_rigid` columns in which the terms cancel to rounding.
pub fn seen_by_rigid(direction: &Direction, shapes: &Matrix, n_rigid: usize) -> Vec<f64> {
    const CANCELS: f64 = 1e-12; // relative; rigid motions are known to some ε
    let mut all = project_direction(direction, shapes);
    for (j, sum) in all.iter_mut().enumerate().take(n_rigid) {
        let size: f64 = direction
            .entries()
            .map(|(i, a)| (a * shapes[(i, j)]).abs())
            .sum();
        if sum.abs() <= CANCELS * size {
            *sum = 0.0;
        }
    }
    all
}
