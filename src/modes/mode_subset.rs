//! Lowest modes, or modes nearest a frequency, of large machines (Lanczos, Sturm count).
//!
//! Torsional trains are forests of two-ended springs, eliminated in series and parallel without subtraction. Without loops their
//! lowest modes come from Sturm bisection and inverse iteration, one by one; with loops, or near a frequency, from Lanczos with the
//! rigid-body modes taken out. Everything else goes through a sparse LDLᵀ. A Sturm count says that no mode is missing.

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
use crate::numeric::sorting::rising_order;
use crate::numeric::sparse::{LdlFactor, SparseSymmetric};

/// Which modes are wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubsetRequest {
    /// Number of modes, rigid-body modes among them where they are the lowest.
    pub count: usize,
    /// rad/s; `None`: the lowest.
    pub near: Option<f64>,
}

/// Solver of the shifted systems.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SubsetSolver {
    /// Elimination of a forest in series and parallel.
    Forest,
    /// Sparse LDLᵀ of the assembled matrices.
    Sparse,
}

/// The modes found.
#[derive(Debug, Clone)]
pub struct ModeSubset {
    /// By rising frequency.
    pub modes: Vec<Mode>,
    /// Solver used for the shifted systems.
    pub solver: SubsetSolver,
    /// Systems solved.
    pub solves: usize,
    /// A Sturm count says that no mode among them is missing.
    pub sturm_verified: bool,
}

/// Relative accuracy of a forest's frequencies: worst of the closed forms of 10 to 100 000 discs in tests is below 1e-12.
const FOREST_DIGITS: f64 = 12.0;

/// A shift this far below the lowest mode wanted of a held or free assembled machine, relative to its stiffest spring.
const BELOW_ZERO: f64 = 1e-10;

/// Whether a machine is a forest of two-ended springs on a diagonal mass.
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

/// Finds the modes wanted.
///
/// # Errors
/// A machine whose strain energy is not a sum of squares; no convergence.
pub fn solve(
    model: &LinearModel,
    forest: Option<&Forest>,
    request: SubsetRequest,
) -> Result<ModeSubset, Error> {
    if !model.is_sum_of_squares() {
        let message = "single modes of a machine with negative or unsymmetric stiffness are not looked for one by one";
        return Err(Error::new(Code::BudgetExceeded, message)
            .with_hint("omit --lowest and --near: all modes are solved together"));
    }
    let rigid = rigid_modes(model);
    let elastic = match request.near {
        None => request.count.saturating_sub(rigid.len()),
        Some(_) => request.count,
    };
    let (ritz, solver) = match request.near {
        None => modes_near_shift(model, forest, &rigid, 0.0, elastic)?,
        Some(omega) => {
            // From above the spectrum all modes look alike; from its upper end the highest are as near.
            let omega = omega.min(frequency_bound(model));
            modes_near_frequency(model, forest, &rigid, omega, elastic).map_err(|error| {
                let far = "from too far away many modes are indistinguishable: name a frequency nearer to those needed";
                match error.code {
                    Code::NoConvergence => error.with_hint(far),
                    _ => error,
                }
            })?
        }
    };
    let largest = stiffest(model);
    let digits = |lambda: f64| match solver {
        SubsetSolver::Forest => FOREST_DIGITS,
        SubsetSolver::Sparse => {
            (-(f64::EPSILON * largest / lambda).log10()).clamp(0.0, FOREST_DIGITS)
        }
    };
    let mut modes = Vec::new();
    if request.near.is_none() {
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

/// Modes whose λ is nearest σ.
fn modes_near_shift(
    model: &LinearModel,
    forest: Option<&Forest>,
    rigid: &[Vec<f64>],
    sigma: f64,
    count: usize,
) -> Result<(RitzPairs, SubsetSolver), Error> {
    Ok(match forest {
        Some(forest) => (
            on_forest(model, forest, rigid, sigma, count)?,
            SubsetSolver::Forest,
        ),
        None => (on_sparse(model, rigid, sigma, count)?, SubsetSolver::Sparse),
    })
}

/// Number of modes computed beyond those requested: the nearest in λ is not always the nearest in ω.
const EXTRA_MODES: usize = 2;

/// Modes whose ω is nearest.
///
/// Those within D of ω have λ within D (2ω + D) of ω²: more are looked for until that far all are known.
fn modes_near_frequency(
    model: &LinearModel,
    forest: Option<&Forest>,
    rigid: &[Vec<f64>],
    omega: f64,
    count: usize,
) -> Result<(RitzPairs, SubsetSolver), Error> {
    let most = model.n.saturating_sub(rigid.len() + model.massless.len());
    let count = count.min(most);
    let mut ask = (count + EXTRA_MODES).min(most);
    loop {
        let (mut ritz, solver) = modes_near_shift(model, forest, rigid, omega * omega, ask)?;
        let apart = |value: &f64| (value.max(0.0).sqrt() - omega).abs();
        let mut order = rising_order(ritz.values.iter().map(apart));
        let reach = ritz
            .values
            .iter()
            .map(|value| (value - omega * omega).abs())
            .fold(0.0, f64::max);
        let farthest = order
            .get(count.saturating_sub(1))
            .map_or(0.0, |&at| apart(&ritz.values[at]));
        if ask < most && reach < farthest * (2.0 * omega + farthest) {
            ask = (2 * ask).min(most);
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

fn on_forest(
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

fn on_sparse(
    model: &LinearModel,
    rigid: &[Vec<f64>],
    sigma: f64,
    count: usize,
) -> Result<RitzPairs, Error> {
    let (k, m) = assembled(model);
    let energy = |p: &[f64]| {
        model
            .branches
            .iter()
            .map(|b| b.stiffness * b.direction.dot(p).powi(2))
            .sum::<f64>()
    };
    // A free machine has no K⁻¹; a shift a hair below zero has, and rigid motions are taken out anyway.
    let sigma = if sigma == 0.0 && !rigid.is_empty() {
        -BELOW_ZERO * stiffest(model)
    } else {
        sigma
    };
    let factor = LdlFactor::shifted(&k, &m, sigma)?;
    let below = |sigma: f64| LdlFactor::shifted(&k, &m, sigma).map(|factor| factor.n_negative());
    let measured = EnergyCorrected {
        factor: &factor,
        energy: &energy,
    };
    let inverse: &dyn ShiftInvert = &measured;
    nearest_modes(&LanczosProblem {
        inverse,
        mass: &m,
        rigid,
        count: Some(&below),
        n_modes: count,
    })
}

/// K and M as sparse matrices.
fn assembled(model: &LinearModel) -> (SparseSymmetric, SparseSymmetric) {
    let mut k = Vec::new();
    for branch in &model.branches {
        outer(&mut k, branch.stiffness, &branch.direction);
    }
    let mut m = Vec::new();
    for mass in &model.masses {
        outer(&mut m, mass.value, &mass.direction);
    }
    (
        SparseSymmetric::from_entries(model.n, &k),
        SparseSymmetric::from_entries(model.n, &m),
    )
}

fn outer(
    entries: &mut Vec<(usize, usize, f64)>,
    value: f64,
    direction: &crate::machine::direction::Direction,
) {
    let terms: Vec<(usize, f64)> = direction.entries().collect();
    for (at, &(i, a)) in terms.iter().enumerate() {
        entries.extend(terms[..=at].iter().map(|&(j, b)| (i, j, value * a * b)));
    }
}

/// Above every frequency, rad/s: `(wᵀp)² ≤ m Σ a² p²` for a branch of m terms.
fn frequency_bound(model: &LinearModel) -> f64 {
    let terms = model.branches.iter().map(|b| b.direction.terms.len());
    let most = terms.max().unwrap_or(0) as f64;
    // A hair more, so that a bound that is met is no eigenvalue.
    (most * stiffest(model)).sqrt() * (1.0 + 1e-6)
}

/// The largest `Σ k a² / m` of a coordinate.
fn stiffest(model: &LinearModel) -> f64 {
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
