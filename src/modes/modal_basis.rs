//! Undamped modes of `K = Wᵀ diag(k) W`: symmetric eigenproblem with frequencies from energies, or singular values of the factored form.
//!
//! Both solvers keep the relative accuracy of small frequencies next to large ones. The first is described at [`energy_modes`]. The second
//! takes the singular values of `√k W L⁻ᵀ`, `M = L Lᵀ`, and never forms K; massless coordinates are condensed in the factored form.

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
    /// Symmetric eigenproblem with frequencies from energies, or the factored form if the error bound is too large. The value is the
    /// largest cosine between the strains of two shapes.
    Symmetric(f64),
    /// Singular values of the factored form: row-sorted QR, then one-sided Jacobi. Shapes are as accurate as the frequencies.
    Factored,
}

/// Undamped modes over the independent coordinates.
#[derive(Debug, Clone)]
pub struct ModalBasis {
    /// Natural frequencies, rad/s, ascending; the first `n_rigid` are exactly zero.
    pub omega: Vec<f64>,
    /// Number of rigid-body modes.
    pub n_rigid: usize,
    /// Mass-normalised shapes as columns over all independent coordinates; massless coordinates follow statically.
    pub shapes: Matrix,
    /// Number of correct decimal digits of each frequency; ∞ for zero frequencies.
    pub digits: Vec<f64>,
    /// Solver that computed the modes.
    pub solution: BasisSolution,
}

/// Solver that computed a basis, with the error bound of its frequencies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BasisSolution {
    /// Symmetric eigenproblem with frequencies from energies.
    Symmetric {
        /// Largest bound of the relative error of a frequency.
        bound: f64,
        /// Number of rotated modes.
        n_rotated: usize,
    },
    /// Singular values of the factored form.
    Factored,
}

impl ModalBasis {
    /// Basis without modes over `n` coordinates.
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

/// Correct digits of the factored form. The worst relative error over chains, trees and loops with stiffness spread 1e14 and inertia
/// spread 1e12 is below 1e-14 (tests/machine/numeric_graded.rs), over assembled machines below 1e-13 (tests/machine/graded_machines.rs).
const FACTORED_DIGITS: f64 = 13.0;

/// Shape tolerance, a cosine, for modes that are only listed and enter no further computation.
pub const LISTED_SHAPE_TOLERANCE: f64 = 1e-9;

/// Smallest ratio to the largest frequency of a frequency that is not the rounding of zero.
const STRAINED: f64 = 1e-6;

/// Computes all undamped modes of a model.
///
/// # Errors
/// Errors for a mass matrix that is not positive definite, for overflow, and for an iteration that does not converge.
pub fn solve(model: &LinearModel, solver: UndampedSolver) -> Result<ModalBasis, Error> {
    let order = CoordinateOrder::new(model);
    let condensed = match model.massless.len() {
        0 => None,
        first => Some(graded::condense(&strain_rows(model, &order), first)?),
    };
    let mass_factor = mass_factor(model, &order)?;
    let rigid = rigid_modes(model);
    let eigenproblem = ScaledEigenproblem {
        model,
        order: &order,
        condensed,
        mass_factor,
        rigid,
    };
    if let UndampedSolver::Symmetric(shape_tolerance) = solver
        && let Some(basis) = eigenproblem.solve_symmetric(shape_tolerance)?
    {
        return Ok(basis);
    }
    eigenproblem.solve_factored()
}

/// `√k W`: one row per elastic branch, one column per coordinate in the sorted order.
fn strain_rows(model: &LinearModel, order: &CoordinateOrder) -> Matrix {
    let branches: Vec<&LinearBranch> = elastic_branches(model).collect();
    let mut rows = Matrix::zeros(branches.len(), model.n);
    for (i, branch) in branches.iter().enumerate() {
        let root = branch.stiffness.sqrt();
        for (j, a) in branch.direction.entries() {
            rows[(i, order.position[j])] += root * a;
        }
    }
    rows
}

/// Branches whose strain energy is `½ k (wᵀp)²`.
fn elastic_branches(model: &LinearModel) -> impl Iterator<Item = &LinearBranch> {
    let branches = model.branches.iter();
    branches.filter(|b| b.stiffness > 0.0 && b.force.is_none())
}

/// Data of the eigenproblem that both solvers use.
struct ScaledEigenproblem<'a> {
    model: &'a LinearModel,
    order: &'a CoordinateOrder,
    /// Static condensation of the massless coordinates; `None` if there are none.
    condensed: Option<graded::StaticCondensation>,
    mass_factor: MassFactor,
    rigid: Vec<Vec<f64>>,
}

impl ScaledEigenproblem<'_> {
    /// Symmetric eigenproblem; `None` if the error bound of a frequency is too large.
    fn solve_symmetric(&self, shape_tolerance: f64) -> Result<Option<ModalBasis>, Error> {
        let first = self.model.massless.len();
        let mut springs = Squares::default();
        for branch in elastic_branches(self.model) {
            self.push(&mut springs, branch.stiffness, &branch.direction);
        }
        let expansion = self.expansion();
        let rigid = self.rigid.iter().map(|p| {
            let x: Vec<f64> = (self.order.coordinates[first..].iter().map(|&i| p[i])).collect();
            self.mass_factor.transposed_times(&x)
        });
        let rigid: Vec<Vec<f64>> = rigid.collect();
        let Some(modes) = energy_modes(&springs, &expansion, &rigid, shape_tolerance)? else {
            return Ok(None);
        };
        let EnergyModes {
            omega,
            vectors,
            bounds,
            n_rotated,
        } = modes;
        let bound = bounds.iter().copied().fold(0.0, f64::max);
        let lowest = omega.first().copied().unwrap_or(f64::INFINITY);
        // Branches with negative stiffness or a force of their own may restrain motions that the other branches do not strain.
        let no_missed_zero = self.model.is_sum_of_squares()
            || lowest > STRAINED * omega.last().copied().unwrap_or(0.0);
        if !(no_missed_zero && bounds.iter().all(|b| *b <= MAX_BOUND)) {
            return Ok(None);
        }
        let shapes = expansion.product(&vectors);
        let solution = BasisSolution::Symmetric { bound, n_rotated };
        let column = |j: usize| shapes.col_as_slice(j);
        self.basis(omega, column, solution).map(Some)
    }

    /// Matrix E of `x = E y` over the sorted coordinates x and the mass-normalised coordinates y.
    fn expansion(&self) -> Expansion {
        if let (None, MassFactor::Diagonal(root)) = (&self.condensed, &self.mass_factor) {
            return Expansion::Diagonal(root.iter().map(|root| 1.0 / root).collect());
        }
        let mut masses = Squares::default();
        for mass in &self.model.masses {
            self.push(&mut masses, mass.value, &mass.direction);
        }
        let n = self.model.n - self.model.massless.len();
        let massive = self.mass_factor.solve_transposed(&Matrix::identity(n, n));
        Expansion::Dense(self.with_massless(massive), masses)
    }

    /// Adds a square over the sorted coordinates; the scale of the direction goes to the root, so that integer coefficients stay integers.
    fn push(&self, squares: &mut Squares, value: f64, direction: &Direction) {
        let terms = direction.terms.iter();
        let terms = terms.map(|&(j, a)| (self.order.position[j], a));
        squares.push(value.sqrt() * direction.scale.abs(), terms);
    }

    /// Adds the rows of the massless coordinates, which follow statically, above those of the coordinates with inertia.
    fn with_massless(&self, massive: Matrix) -> Matrix {
        let Some(condensed) = &self.condensed else {
            return massive;
        };
        let massless = symmetric::product(&condensed.recovery, &massive);
        let first = massless.nrows();
        Matrix::from_fn(first + massive.nrows(), massive.ncols(), |i, j| {
            match i.checked_sub(first) {
                Some(i) => massive[(i, j)],
                None => massless[(i, j)],
            }
        })
    }

    fn solve_factored(&self) -> Result<ModalBasis, Error> {
        let n = self.model.n - self.model.massless.len();
        let n_rigid = self.rigid.len();
        let scaled = match &self.condensed {
            Some(condensed) => self.mass_factor.right_divide(&condensed.condensed),
            None => self
                .mass_factor
                .right_divide(&strain_rows(self.model, self.order)),
        };
        let svd = graded::svd(&scaled, Some(n - n_rigid))?;
        let shapes = self.with_massless(self.mass_factor.solve_transposed(&svd.vectors));
        let column = |j: usize| shapes.col_as_slice(n_rigid + j);
        self.basis(
            svd.values[n_rigid..].to_vec(),
            column,
            BasisSolution::Factored,
        )
    }

    /// Basis of the rigid-body modes and the elastic modes, whose shapes are over the sorted coordinates.
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
            let entries = self.order.coordinates.iter().zip(shape(j));
            entries.for_each(|(&i, x)| column[i] = *x);
        }
        let omega: Vec<f64> = std::iter::repeat_n(0.0, n_rigid).chain(elastic).collect();
        if let Some(invalid) = omega.iter().position(|w| !w.is_finite()) {
            return Err(Error::new(
                Code::Overflow,
                format!("frequency {} of {n} is out of range", invalid + 1),
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

/// Order of the coordinates with the massless ones first.
struct CoordinateOrder {
    /// Coordinates in the sorted order.
    coordinates: Vec<usize>,
    /// Position of each coordinate in the sorted order.
    position: Vec<usize>,
}

impl CoordinateOrder {
    fn new(model: &LinearModel) -> CoordinateOrder {
        let mut massless = vec![false; model.n];
        model.massless.iter().for_each(|&j| massless[j] = true);
        let massive = (0..model.n).filter(|&j| !massless[j]);
        let coordinates: Vec<usize> = model.massless.iter().copied().chain(massive).collect();
        let mut position = vec![0; model.n];
        coordinates
            .iter()
            .enumerate()
            .for_each(|(at, &j)| position[j] = at);
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
        let massive = order.coordinates[first..].iter();
        return Ok(MassFactor::diagonal(massive.map(|&j| diagonal[j])));
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

/// Rigid-body modes: the motions without strain, M-orthonormalised in their order over the independent coordinates.
pub fn rigid_modes(model: &LinearModel) -> Vec<Vec<f64>> {
    let mut modes: Vec<Vec<f64>> = Vec::with_capacity(model.rigid.len());
    for motion in &model.rigid {
        let mut r = motion.clone();
        // Two Gram–Schmidt passes are enough (Giraud, Langou & Rozložník 2005, Numer. Math. 101, 87).
        for _ in 0..2 {
            for mode in &modes {
                let c = mass_product(model, mode, &r);
                r.iter_mut().zip(mode).for_each(|(x, d)| *x -= c * d);
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

/// `wᵀΦ`: projection of a direction on every mode.
pub fn project_direction(direction: &Direction, shapes: &Matrix) -> Vec<f64> {
    (0..shapes.ncols())
        .map(|j| direction.entries().map(|(i, a)| a * shapes[(i, j)]).sum())
        .collect()
}

/// `wᵀΦ`, set to exactly zero for each of the first `n_rigid` columns in which the terms cancel to rounding.
pub fn project_with_zeros(direction: &Direction, shapes: &Matrix, n_rigid: usize) -> Vec<f64> {
    const TOLERANCE: f64 = 1e-12; // relative; rigid-body motions are accurate to a few ε
    let mut projection = project_direction(direction, shapes);
    for (j, sum) in projection.iter_mut().enumerate().take(n_rigid) {
        let size: f64 = direction
            .entries()
            .map(|(i, a)| (a * shapes[(i, j)]).abs())
            .sum();
        if sum.abs() <= TOLERANCE * size {
            *sum = 0.0;
        }
    }
    projection
}
