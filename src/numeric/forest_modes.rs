//! Lowest modes of a spring forest without loops: Sturm bisection, then Rayleigh-quotient iteration in the bracket of each mode.
//!
//! The number of negative pivots is the number of eigenvalues below a shift, so that each mode has a separate bracket and none is
//! missing; inverse iteration `x ← (K − σM)⁻¹ M x` with `σ = xᵀKx / xᵀMx` converges in it cubically (Peters and Wilkinson 1979,
//! SIAM Review 21, pp. 339–360). No mode needs the vectors of other modes: the time grows as nodes times modes, except for the
//! product of the shapes at the end.

use super::forest::Forest;
use super::forest_lanes::{ForestLanes, Iterate, LANES};
use super::lanczos::RitzPairs;
use super::sorting::sort_ascending;
use super::symmetric::{cholesky, solve_lower};
use super::thin_qr::transposed_product;
use super::vector_ops::{axpy, dot};
use super::{Matrix, parallel};
use crate::base::code::Code;
use crate::base::error::Error;

/// Relative spacing of unseparated eigenvalues: rounding of the counts of a chain of 100 000 nodes.
const SAME_VALUE: f64 = 1e-13;

/// Relative distance of the common shift below unseparated modes: one step amplifies all of them equally.
const BELOW_REPEATED: f64 = 1e-12;

/// Relative bracket width at which bisection ends; the iteration then converges in three or four steps.
const START_WIDTH: f64 = 0.2;

/// Estimated error of a converged shape.
const SHAPE_ERROR: f64 = 1e-13;

/// Residual relative to λ below which a stagnating iteration has converged.
const ROUNDING: f64 = 1e-11;

/// Maximum number of iterations, of bisection and of inverse iteration.
const MAX_ROUNDS: usize = 100;

/// Ratio of neighbouring trial shifts above zero.
const FIRST_RATIO: f64 = 1e-2;

/// Largest λ relative to the lowest for a final solution with K: rounding along the lowest shape grows by this ratio.
const STATIC_RANGE: f64 = 1e8;

/// Contamination by other shapes above which a shape is orthogonalised twice.
const LARGE_SHARE: f64 = 1e-3;

/// Mode with its bracket, iterate and convergence state.
struct BracketedMode {
    low: f64,
    high: f64,
    /// Bracket width at rounding; modes of a repeated eigenvalue share a bracket.
    is_narrow: bool,
    iterate: Iterate,
    value: f64,
    /// Estimated error of the shape.
    error: f64,
    residual: f64,
    converged: bool,
}

/// Lowest elastic modes of a forest without loops, at most `n_modes`.
///
/// # Errors
/// `NoConvergence`; `NotPositiveDefinite` if shapes are linearly dependent.
pub fn lowest_modes(forest: &Forest, mass: &[f64], n_modes: usize) -> Result<RitzPairs, Error> {
    let lanes = ForestLanes::new(forest, mass);
    let masses = lanes.masses();
    let n_rigid = forest.rigid_motions().len();
    let mut modes: Vec<BracketedMode> = isolate(&lanes, n_rigid, n_rigid + n_modes)
        .into_iter()
        .enumerate()
        .map(|(seed, bracket)| BracketedMode::new(bracket, random_vector(&masses, seed as u64)))
        .collect();
    let mut solves = 0;
    for round in 0.. {
        let gaps: Vec<f64> = (0..modes.len()).map(|j| gap(&modes, j)).collect();
        let is_active = |mode: &&mut BracketedMode| !mode.converged;
        let mut active: Vec<&mut Iterate> = (modes.iter_mut().filter(is_active))
            .map(|mode| &mut mode.iterate)
            .collect();
        if active.is_empty() {
            break;
        }
        if round == MAX_ROUNDS {
            let message = format!(
                "inverse iteration ended after {round} rounds with {} modes of {n_modes} not converged",
                active.len()
            );
            return Err(Error::new(Code::NoConvergence, message));
        }
        solves += active.len();
        solve_all(&lanes, &mut active);
        for (j, mode) in modes.iter_mut().enumerate().filter(|(_, m)| !m.converged) {
            mode.update(n_rigid + j, gaps[j]);
        }
    }
    separate_repeated(&mut modes, &masses)?;
    solves += solve_statically(&lanes, forest, &masses, &mut modes)?;
    let verified = |mode: &BracketedMode| {
        let rounding = ROUNDING * mode.value;
        mode.low - rounding <= mode.value && mode.value <= mode.high + rounding
    };
    let sturm_verified = modes.iter().all(verified);
    sort_ascending(&mut modes, |mode| mode.value);
    let dof_shape = |mode: &BracketedMode| {
        let mut shape = vec![0.0; masses.len()];
        (forest.order.iter().zip(&mode.iterate.x)).for_each(|(&i, x)| shape[i] = *x);
        shape
    };
    Ok(RitzPairs {
        values: modes.iter().map(|mode| mode.value).collect(),
        vectors: modes.iter().map(dof_shape).collect(),
        residuals: modes.iter().map(|mode| mode.residual).collect(),
        solves,
        runs: 1,
        sturm_verified,
    })
}

impl BracketedMode {
    fn new((low, high): (f64, f64), x: Vec<f64>) -> BracketedMode {
        let is_narrow = high - low <= SAME_VALUE * high;
        let value = middle(low, high);
        let shift = match is_narrow {
            true => low * (1.0 - BELOW_REPEATED),
            false => value,
        };
        BracketedMode {
            low,
            high,
            is_narrow,
            iterate: Iterate {
                shift,
                x,
                norm: 1.0,
                ..Iterate::default()
            },
            value,
            error: 1.0,
            residual: 1.0,
            converged: false,
        }
    }

    /// Narrows the bracket by the Sturm count; the next shift is the Rayleigh quotient if inside the bracket.
    fn update(&mut self, index: usize, gap: f64) {
        let iterate = &mut self.iterate;
        match iterate.n_below <= index {
            true => self.low = self.low.max(iterate.shift),
            false => self.high = self.high.min(iterate.shift),
        }
        // ‖(K − σM)⁻¹M x‖ of a unit vector is the reciprocal of its distance from an eigenvector of σ.
        let distance = 1.0 / iterate.norm;
        let before = std::mem::replace(&mut self.residual, distance / iterate.shift);
        self.error *= (distance / gap).min(1.0);
        let stagnates = self.residual <= ROUNDING && self.residual > 0.5 * before;
        self.converged = self.error <= SHAPE_ERROR || stagnates;
        self.value = iterate.quotient;
        if self.is_narrow {
            return;
        }
        iterate.shift = match self.low < self.value && self.value < self.high {
            true => self.value,
            false => middle(self.low, self.high),
        };
    }
}

/// Midpoint of two eigenvalues in frequency.
fn middle(low: f64, high: f64) -> f64 {
    (0.5 * (low.sqrt() + high.sqrt())).powi(2)
}

fn solve_all(lanes: &ForestLanes, iterates: &mut [&mut Iterate]) {
    let mut blocks: Vec<&mut [&mut Iterate]> = iterates.chunks_mut(LANES).collect();
    parallel::for_each(&mut blocks, |block| lanes.solve(block));
}

/// Brackets of the eigenvalues `first..last` in ascending order; the first `first` eigenvalues are zero.
fn isolate(lanes: &ForestLanes, first: usize, last: usize) -> Vec<(f64, f64)> {
    let top = lanes.upper_bound();
    if top == 0.0 {
        return Vec::new();
    }
    let mut known = vec![(0.0, first), (top, lanes.count_below(&[top])[0])];
    let last = last.min(known[1].1);
    for _ in 0..MAX_ROUNDS {
        let mut trials = Vec::new();
        for pair in known.windows(2) {
            let [(low, below), (high, above)] = [pair[0], pair[1]];
            if above.min(last) > below.max(first) {
                push_trials(&mut trials, low, high, above - below);
            }
        }
        if trials.is_empty() {
            break;
        }
        let blocks: Vec<&[f64]> = trials.chunks(LANES).collect();
        let counts = parallel::map(&blocks, |block| lanes.count_below(block));
        let counts: Vec<usize> = counts.into_iter().flatten().collect();
        known.extend(trials.into_iter().zip(counts));
        known.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    let bracket = |mode: usize| {
        let above = known.iter().position(|&(_, count)| count > mode);
        above.map(|index| (known[index - 1].0, known[index].0))
    };
    (first..last).filter_map(bracket).collect()
}

/// Trial shifts between two shifts whose counts differ by `inside`: evenly in log λ for a wide interval, else in frequency.
fn push_trials(trials: &mut Vec<f64>, low: f64, high: f64, inside: usize) {
    let width = high - low;
    if low == 0.0 {
        trials.extend((1..=LANES as i32).map(|i| high * FIRST_RATIO.powi(i)));
    } else if high > 4.0 * low {
        let fraction = |i: usize| i as f64 / (LANES + 1) as f64;
        trials.extend((1..=LANES).map(|i| low * (high / low).powf(fraction(i))));
    } else if (inside > 1 && width > SAME_VALUE * high) || width > START_WIDTH * high {
        let n = inside.min(LANES);
        let (low, high) = (low.sqrt(), high.sqrt());
        let fraction = |i: usize| i as f64 / (n + 1) as f64;
        trials.extend((1..=n).map(|i| (low + fraction(i) * (high - low)).powi(2)));
    }
}

/// Distance of a shift from the brackets of other eigenvalues.
fn gap(modes: &[BracketedMode], j: usize) -> f64 {
    let shift = modes[j].iterate.shift;
    let is_separate = |d: &f64| *d > SAME_VALUE * shift;
    let below = (modes[..j].iter().rev().map(|m| shift - m.high)).find(is_separate);
    let above = (modes[j + 1..].iter().map(|m| m.low - shift)).find(is_separate);
    below.unwrap_or(shift).min(above.unwrap_or(shift))
}

/// Pseudo-random start vector, reproducible, with similar components in all modes.
fn random_vector(masses: &[f64], seed: u64) -> Vec<f64> {
    let mut state = (seed + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let size = (3.0 / masses.len() as f64).sqrt();
    let mut number = |mass: &f64| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        match *mass > 0.0 {
            true => size * ((state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0) / mass.sqrt(),
            false => 0.0,
        }
    };
    masses.iter().map(&mut number).collect()
}

/// Orthonormalises the shapes of each repeated eigenvalue.
fn separate_repeated(modes: &mut [BracketedMode], masses: &[f64]) -> Result<(), Error> {
    let same = |m: &BracketedMode, next: &BracketedMode| m.is_narrow && m.high == next.high;
    (modes.chunk_by_mut(same))
        .filter(|group| group.len() > 1)
        .try_for_each(|group| orthonormalise(group, masses).map(drop))
}

/// Final solution with K, free of cancellation: eigenvalues and orthogonality of shapes to rounding.
///
/// Contamination by lower modes grew by the ratio of eigenvalues; its energy is subtracted. Returns the number of solutions.
fn solve_statically(
    lanes: &ForestLanes,
    forest: &Forest,
    masses: &[f64],
    modes: &mut [BracketedMode],
) -> Result<usize, Error> {
    let lowest = modes.iter().map(|m| m.value).fold(f64::INFINITY, f64::min);
    let is_low = |mode: &BracketedMode| mode.value <= STATIC_RANGE * lowest;
    let mut iterates: Vec<&mut Iterate> = (modes.iter_mut().filter(|m| is_low(m)))
        .map(|mode| &mut mode.iterate)
        .collect();
    iterates.iter_mut().for_each(|i| i.shift = 0.0);
    solve_all(lanes, &mut iterates);
    for tree in forest.trees.iter().filter(|tree| !tree.grounded) {
        let span = tree.start..tree.end;
        let rigid = &forest.rigid_shape[span.clone()];
        let momentum: Vec<f64> = (rigid.iter().zip(&masses[span.clone()]))
            .map(|(r, m)| r * m)
            .collect();
        let inertia = dot(&momentum, rigid);
        for iterate in iterates.iter_mut().filter(|_| inertia > 0.0) {
            let x = &mut iterate.x[span.clone()];
            let component = dot(&momentum, x) / inertia;
            axpy(x, -component, rigid);
        }
    }
    let solves = iterates.len();
    let energies: Vec<f64> = (modes.iter().map(|m| &m.iterate))
        .map(|i| i.quotient * i.norm * i.norm)
        .collect();
    let l = orthonormalise(modes, masses)?;
    for j in 0..modes.len() {
        let lower = modes[..j].iter().enumerate();
        let lower_energy: f64 = lower.map(|(i, mode)| l[(j, i)].powi(2) * mode.value).sum();
        modes[j].value = (energies[j] - lower_energy) / l[(j, j)].powi(2);
    }
    Ok(solves)
}

/// M-orthonormalisation of the shapes, each against the lower ones. Returns L of `XᵀMX = L Lᵀ`.
///
/// # Errors
/// Linearly dependent shapes.
fn orthonormalise(modes: &mut [BracketedMode], masses: &[f64]) -> Result<Matrix, Error> {
    let l = orthonormalise_once(modes, masses)?;
    let is_large = |j: usize| (0..j).any(|i| l[(j, i)].abs() > LARGE_SHARE * l[(j, j)]);
    if (0..modes.len()).any(is_large) {
        orthonormalise_once(modes, masses)?;
    }
    Ok(l)
}

/// Single pass of M-orthonormalisation: `Qᵀ = L⁻¹ Xᵀ` (Cholesky).
fn orthonormalise_once(modes: &mut [BracketedMode], masses: &[f64]) -> Result<Matrix, Error> {
    let roots: Vec<f64> = masses.iter().map(|mass| mass.sqrt()).collect();
    let x = |i: usize, j: usize| modes[j].iterate.x[i];
    let weighted = Matrix::from_fn(masses.len(), modes.len(), |i, j| roots[i] * x(i, j));
    let l = cholesky(&transposed_product(&weighted, &weighted))?;
    let q = solve_lower(
        &l,
        &Matrix::from_fn(modes.len(), masses.len(), |j, i| x(i, j)),
    );
    for (i, column) in q.col_iter().enumerate() {
        let shapes = modes.iter_mut().map(|mode| &mut mode.iterate.x[i]);
        shapes.zip(column.iter()).for_each(|(x, q)| *x = *q);
    }
    modes.iter_mut().for_each(|mode| mode.iterate.norm = 1.0);
    Ok(l)
}
