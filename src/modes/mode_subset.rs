//! Lowest modes, or modes nearest a frequency, of large machines (Lanczos, Sturm count).
//!
//! Torsional models are forests of two-ended springs, eliminated in series and parallel without subtraction. Their lowest modes come from
//! Sturm bisection and inverse iteration if there are no loops; otherwise, and near a frequency, from Lanczos iteration with the rigid-body
//! modes deflated. All other models use a sparse LDLᵀ factorisation. A Sturm count verifies that no mode is missing.

use super::modal_basis::rigid_modes;
use super::mode::Mode;
use super::undamped;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::linear::LinearModel;
use crate::numeric::forest::{Forest, ForestSpring};
use crate::numeric::forest_modes::lowest_modes;
use crate::numeric::lanczos::{LanczosProblem, RitzPairs, nearest_modes};
use crate::numeric::shift_invert::{EnergyCorrected, ShiftInvert, ShiftedForest};
use crate::numeric::sorting::ascending_order;
use crate::numeric::sparse::{LdlFactor, SparseSymmetric};

/// Number and frequency range of the requested modes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubsetRequest {
    /// Number of modes; it includes the rigid-body modes if the lowest modes are requested.
    pub count: usize,
    /// Frequency, rad/s, whose nearest modes are requested; `None` for the lowest modes.
    pub near_omega: Option<f64>,
}

/// Solver of the shifted systems.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SubsetSolver {
    /// Series and parallel elimination of a forest.
    Forest,
    /// Sparse LDLᵀ factorisation of the assembled matrices.
    Sparse,
}

/// Requested modes with the solver and its effort.
#[derive(Debug, Clone)]
pub struct ModeSubset {
    /// Modes by rising frequency.
    pub modes: Vec<Mode>,
    /// Solver used for the shifted systems.
    pub solver: SubsetSolver,
    /// Number of solved shifted systems.
    pub solves: usize,
    /// Whether a Sturm count verified that no mode among them is missing.
    pub sturm_verified: bool,
}

/// Correct digits of the frequencies of a forest: the tests against closed forms of 10 to 100 000 discs show errors below 1e-12.
const FOREST_DIGITS: f64 = 12.0;

/// Distance of the shift below zero for a model with rigid-body modes, relative to the largest `Σ k a² / m`.
const SHIFT_BELOW_ZERO: f64 = 1e-10;

/// Forest of two-ended springs on a diagonal mass; `None` if the model has another form.
pub fn as_forest(model: &LinearModel) -> Option<Forest> {
    let mass = model.mass_diagonal()?;
    let springs = model
        .branches
        .iter()
        .filter(|b| b.stiffness != 0.0)
        .map(|b| {
            let k = b.stiffness * b.direction.scale * b.direction.scale;
            if b.force.is_some() || k <= 0.0 {
                return None;
            }
            match b.direction.terms[..] {
                [(i, a)] => Some(ForestSpring {
                    i,
                    a,
                    second: None,
                    k,
                }),
                [(i, a), (j, c)] => Some(ForestSpring {
                    i,
                    a,
                    second: Some((j, c)),
                    k,
                }),
                _ => None,
            }
        })
        .collect::<Option<Vec<ForestSpring>>>()?;
    Forest::new(model.n, &springs, &mass)
}

/// Computes the requested modes.
///
/// # Errors
/// `BudgetExceeded` if the strain energy is not a sum of squares; `NoConvergence` of the iteration.
pub fn solve(
    model: &LinearModel,
    forest: Option<&Forest>,
    request: SubsetRequest,
) -> Result<ModeSubset, Error> {
    if !model.is_sum_of_squares() {
        let message = "single modes with negative or unsymmetric stiffness are not computed";
        return Err(Error::new(Code::BudgetExceeded, message)
            .with_hint("omit --lowest and --near to compute all modes"));
    }
    let rigid = rigid_modes(model);
    let elastic = match request.near_omega {
        None => request.count.saturating_sub(rigid.len()),
        Some(_) => request.count,
    };
    let (ritz, solver) = match request.near_omega {
        None => modes_near_shift(model, forest, &rigid, 0.0, elastic)?,
        Some(omega) => {
            // Far above the spectrum shift-invert does not separate the modes; the upper end has the same nearest modes.
            let omega = omega.min(frequency_bound(model));
            modes_near_frequency(model, forest, &rigid, omega, elastic).map_err(|error| {
                let hint = "the frequency is too far from the modes to separate them: name a nearer frequency";
                match error.code {
                    Code::NoConvergence => error.with_hint(hint),
                    _ => error,
                }
            })?
        }
    };
    let largest = max_stiffness_ratio(model);
    let digits = |lambda: f64| match solver {
        SubsetSolver::Forest => FOREST_DIGITS,
        SubsetSolver::Sparse => {
            (-(f64::EPSILON * largest / lambda).log10()).clamp(0.0, FOREST_DIGITS)
        }
    };
    let mut modes = Vec::new();
    if request.near_omega.is_none() {
        modes.extend(
            rigid
                .iter()
                .take(request.count)
                .map(|p| undamped::mode(model, p, 0.0, true, f64::INFINITY)),
        );
    }
    for (value, vector) in ritz.values.iter().zip(&ritz.vectors) {
        modes.push(undamped::mode(
            model,
            vector,
            value.max(0.0).sqrt(),
            false,
            digits(*value),
        ));
    }
    Ok(ModeSubset {
        modes,
        solver,
        solves: ritz.solves,
        sturm_verified: ritz.sturm_verified,
    })
}

/// Modes whose λ = ω² is nearest to σ, rad²/s².
fn modes_near_shift(
    model: &LinearModel,
    forest: Option<&Forest>,
    rigid: &[Vec<f64>],
    sigma: f64,
    count: usize,
) -> Result<(RitzPairs, SubsetSolver), Error> {
    Ok(match forest {
        Some(forest) => (
            forest_modes(model, forest, rigid, sigma, count)?,
            SubsetSolver::Forest,
        ),
        None => (ldl_modes(model, rigid, sigma, count)?, SubsetSolver::Sparse),
    })
}

/// Number of modes computed in addition to those requested: the nearest in λ is not always the nearest in ω.
const EXTRA_MODES: usize = 2;

/// Modes whose frequency is nearest to `omega`, rad/s.
///
/// Modes within D of ω have λ within D (2ω + D) of ω²: the number of modes is raised until this interval is covered.
fn modes_near_frequency(
    model: &LinearModel,
    forest: Option<&Forest>,
    rigid: &[Vec<f64>],
    omega: f64,
    count: usize,
) -> Result<(RitzPairs, SubsetSolver), Error> {
    let available = model.n.saturating_sub(rigid.len() + model.massless.len());
    let count = count.min(available);
    let mut n_modes = (count + EXTRA_MODES).min(available);
    loop {
        let (mut ritz, solver) = modes_near_shift(model, forest, rigid, omega * omega, n_modes)?;
        let distance = |value: &f64| (value.max(0.0).sqrt() - omega).abs();
        let mut order = ascending_order(ritz.values.iter().map(distance));
        let radius = ritz
            .values
            .iter()
            .map(|value| (value - omega * omega).abs())
            .fold(0.0, f64::max);
        let farthest = order
            .get(count.saturating_sub(1))
            .map_or(0.0, |&at| distance(&ritz.values[at]));
        if n_modes < available && radius < farthest * (2.0 * omega + farthest) {
            n_modes = (2 * n_modes).min(available);
            continue;
        }
        order.truncate(count);
        order.sort_unstable();
        ritz.values = order.iter().map(|&at| ritz.values[at]).collect();
        ritz.residuals = order.iter().map(|&at| ritz.residuals[at]).collect();
        ritz.vectors = order
            .iter()
            .map(|&at| std::mem::take(&mut ritz.vectors[at]))
            .collect();
        return Ok((ritz, solver));
    }
}

fn forest_modes(
    model: &LinearModel,
    forest: &Forest,
    rigid: &[Vec<f64>],
    sigma: f64,
    count: usize,
) -> Result<RitzPairs, Error> {
    let mass = model.mass_diagonal().unwrap_or_default();
    if sigma == 0.0 && forest.n_loops() == 0 {
        return lowest_modes(forest, &mass, count);
    }
    let matrix = SparseSymmetric::diagonal(&mass);
    let below = |sigma: f64| Ok(forest.count_below(&mass, sigma));
    let inverse = if sigma == 0.0 {
        ShiftedForest::unshifted(forest)
    } else {
        ShiftedForest::shifted(forest, &mass, sigma)
    };
    nearest_modes(&LanczosProblem {
        inverse: &inverse,
        mass: &matrix,
        rigid,
        count: Some(&below),
        n_modes: count,
    })
}

fn ldl_modes(
    model: &LinearModel,
    rigid: &[Vec<f64>],
    sigma: f64,
    count: usize,
) -> Result<RitzPairs, Error> {
    let (k, m) = assemble(model);
    let energy = |p: &[f64]| {
        model
            .branches
            .iter()
            .map(|b| b.stiffness * b.direction.dot(p).powi(2))
            .sum::<f64>()
    };
    // K is singular for a free machine; a shift slightly below zero is regular, and rigid-body motions are deflated in any case.
    let sigma = if sigma == 0.0 && !rigid.is_empty() {
        -SHIFT_BELOW_ZERO * max_stiffness_ratio(model)
    } else {
        sigma
    };
    let factor = LdlFactor::shifted(&k, &m, sigma)?;
    let below = |sigma: f64| LdlFactor::shifted(&k, &m, sigma).map(|factor| factor.n_negative());
    let corrected = EnergyCorrected {
        factor: &factor,
        energy: &energy,
    };
    let inverse: &dyn ShiftInvert = &corrected;
    nearest_modes(&LanczosProblem {
        inverse,
        mass: &m,
        rigid,
        count: Some(&below),
        n_modes: count,
    })
}

/// K and M as sparse matrices.
fn assemble(model: &LinearModel) -> (SparseSymmetric, SparseSymmetric) {
    let mut k = Vec::new();
    for branch in &model.branches {
        add_outer_product(&mut k, branch.stiffness, &branch.direction);
    }
    let mut m = Vec::new();
    for mass in &model.masses {
        add_outer_product(&mut m, mass.value, &mass.direction);
    }
    (
        SparseSymmetric::from_entries(model.n, &k),
        SparseSymmetric::from_entries(model.n, &m),
    )
}

fn add_outer_product(
    entries: &mut Vec<(usize, usize, f64)>,
    value: f64,
    direction: &crate::machine::direction::Direction,
) {
    let terms: Vec<(usize, f64)> = direction.entries().collect();
    for (at, &(i, a)) in terms.iter().enumerate() {
        entries.extend(terms[..=at].iter().map(|&(j, b)| (i, j, value * a * b)));
    }
}

/// Upper bound of the frequencies, rad/s, from `(wᵀp)² ≤ n Σ a² p²` for a branch of n terms.
fn frequency_bound(model: &LinearModel) -> f64 {
    let counts = model.branches.iter().map(|b| b.direction.terms.len());
    let n_terms = counts.max().unwrap_or(0) as f64;
    // The margin keeps an attained bound away from the eigenvalue.
    (n_terms * max_stiffness_ratio(model)).sqrt() * (1.0 + 1e-6)
}

/// Largest ratio `Σ k a² / m` of a coordinate, rad²/s².
fn max_stiffness_ratio(model: &LinearModel) -> f64 {
    let (mut k, mut m) = (vec![0.0; model.n], vec![0.0; model.n]);
    for branch in &model.branches {
        branch
            .direction
            .entries()
            .for_each(|(i, a)| k[i] += branch.stiffness.abs() * a * a);
    }
    for mass in &model.masses {
        mass.direction
            .entries()
            .for_each(|(i, a)| m[i] += mass.value * a * a);
    }
    k.iter()
        .zip(&m)
        .filter(|(_, m)| **m > 0.0)
        .map(|(k, m)| k / m)
        .fold(0.0, f64::max)
}
