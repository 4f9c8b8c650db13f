//! Undamped modes from the factored stiffness `K = Wᵀ diag(k) W`; K is never formed.
//!
//! With `K = Wᵀ diag(k) W` the frequencies are the singular values of `√k W L⁻ᵀ`, `M = L Lᵀ`; K is never formed, so small
//! frequencies keep their digits next to large ones. Coordinates without inertia are condensed in the same factored form.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::direction::Direction;
use crate::machine::linear::{LinearBranch, LinearModel};
use crate::numeric::{Matrix, graded, symmetric};

/// Solver of the undamped eigenvalue problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UndampedSolver {
    /// Singular values of the factored form: row-sorted QR, then one-sided Jacobi.
    Factored,
    /// Singular values by bidiagonal reduction: small ones to ε of the largest.
    Bidiagonal,
}

/// Undamped modes over the coordinates that stay.
#[derive(Debug, Clone)]
pub struct ModalBasis {
    /// rad/s, ascending; the first `n_rigid` are exactly zero.
    pub omega: Vec<f64>,
    /// Rigid-body modes.
    pub n_rigid: usize,
    /// Columns: mass-normalised shapes over all coordinates that stay, the massless ones following statically.
    pub shapes: Matrix,
    /// Decimal digits each frequency can be trusted to.
    pub digits: Vec<f64>,
    /// Solver that found the modes.
    pub solver: UndampedSolver,
}

impl ModalBasis {
    /// No modes, over `n` coordinates.
    pub fn empty(n: usize) -> ModalBasis {
        ModalBasis {
            omega: Vec::new(),
            n_rigid: 0,
            shapes: Matrix::zeros(n, 0),
            digits: Vec::new(),
            solver: UndampedSolver::Factored,
        }
    }
}

/// Digits of the factored form: the worst relative error over chains, trees and loops with stiffness spread 1e14 and inertia
/// spread 1e12 in tests/machine/numeric_graded.rs is below 1e-14, of assembled machines in tests/machine/graded_machines.rs below 1e-13.
const FACTORED_DIGITS: f64 = 13.0;

/// Solves for every mode.
///
/// # Errors
/// A mass matrix that is not positive definite; numbers out of range; no convergence.
pub fn solve(model: &LinearModel, solver: UndampedSolver) -> Result<ModalBasis, Error> {
    let squares: Vec<&LinearBranch> = model
        .branches
        .iter()
        .filter(|b| b.stiffness > 0.0 && b.force.is_none())
        .collect();
    let order = CoordinateOrder::new(model);
    let mut rows = Matrix::zeros(squares.len(), model.n);
    for (i, branch) in squares.iter().enumerate() {
        let root = branch.stiffness.sqrt();
        for (j, a) in branch.direction.entries() {
            rows[(i, order.position[j])] += root * a;
        }
    }
    let first = model.massless.len();
    let condensed = graded::condense(&rows, first)?;
    let root = CholeskyMass::new(model, &order)?;
    let scaled = root.right_divide(&condensed.condensed);
    let rigid = rigid_modes(model);
    let n = model.n - first;
    let n_rigid = rigid.len();
    let (omega, vectors) = match solver {
        UndampedSolver::Factored => {
            let found = graded::svd(&scaled, Some(n - n_rigid))?;
            (found.values, found.vectors)
        }
        UndampedSolver::Bidiagonal => {
            let (mut values, vectors) = symmetric::right_svd(&scaled)?;
            let found = values.len();
            values.resize(n, 0.0);
            values.reverse();
            let from = |j: usize| n - 1 - j;
            (
                values,
                Matrix::from_fn(n, n, |i, j| {
                    if from(j) < found {
                        vectors[(i, from(j))]
                    } else {
                        0.0
                    }
                }),
            )
        }
    };
    let heavy = root.left_divide_transposed(&vectors);
    let light = if first > 0 {
        Some(&condensed.recovery * &heavy)
    } else {
        None
    };
    let mut shapes = Matrix::zeros(model.n, n);
    for j in 0..n {
        if j < n_rigid {
            (0..model.n).for_each(|i| shapes[(i, j)] = rigid[j][i]);
            continue;
        }
        for (place, &i) in order.coordinates.iter().enumerate() {
            shapes[(i, j)] = match &light {
                Some(light) if place < first => light[(place, j)],
                _ => heavy[(place - first, j)],
            };
        }
    }
    let mut omega = omega;
    omega.iter_mut().take(n_rigid).for_each(|w| *w = 0.0);
    if let Some(bad) = omega.iter().position(|w| !w.is_finite()) {
        return Err(Error::new(
            Code::Overflow,
            format!("frequency {} of {n} is out of range", bad + 1),
        ));
    }
    let largest = omega.last().copied().unwrap_or(0.0);
    let digits = omega.iter().map(|&w| digits(solver, w, largest)).collect();
    Ok(ModalBasis {
        omega,
        n_rigid,
        shapes,
        digits,
        solver,
    })
}

fn digits(solver: UndampedSolver, omega: f64, largest: f64) -> f64 {
    match solver {
        _ if omega == 0.0 => f64::INFINITY,
        UndampedSolver::Factored => FACTORED_DIGITS,
        UndampedSolver::Bidiagonal => {
            (-(4.0 * f64::EPSILON * largest / omega).log10()).clamp(0.0, 16.0)
        }
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
enum CholeskyMass {
    Diagonal(Vec<f64>),
    Lower(Matrix),
}

impl CholeskyMass {
    fn new(model: &LinearModel, order: &CoordinateOrder) -> Result<CholeskyMass, Error> {
        let first = model.massless.len();
        if let Some(diagonal) = model.mass_diagonal() {
            return Ok(CholeskyMass::Diagonal(
                order.coordinates[first..]
                    .iter()
                    .map(|&j| diagonal[j].sqrt())
                    .collect(),
            ));
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
        symmetric::cholesky(&m).map(CholeskyMass::Lower)
    }

    /// `A L⁻ᵀ`.
    fn right_divide(&self, a: &Matrix) -> Matrix {
        match self {
            CholeskyMass::Diagonal(root) => {
                Matrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] / root[j])
            }
            CholeskyMass::Lower(l) => symmetric::solve_lower(l, &a.transpose().to_owned())
                .transpose()
                .to_owned(),
        }
    }

    /// `L⁻ᵀ V`.
    fn left_divide_transposed(&self, v: &Matrix) -> Matrix {
        match self {
            CholeskyMass::Diagonal(root) => {
                Matrix::from_fn(v.nrows(), v.ncols(), |i, j| v[(i, j)] / root[i])
            }
            CholeskyMass::Lower(l) => symmetric::solve_lower_transposed(l, v),
        }
    }
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

/// `aᵀ M b` over the coordinates that stay.
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

/// `wᵀ Φ`: a direction seen by every mode. Exactly zero for the motions that strain nothing if `strained` is set.
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
