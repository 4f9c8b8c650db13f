//! Lowest modes of a spring forest without loops: Sturm bisection, then Rayleigh-quotient iteration inside the bracket of each mode.
//!
//! A count of negative pivots says how many eigenvalues lie below a shift, so that each mode has a bracket of its own and none is
//! missing; inverse iteration `x ← (K − σM)⁻¹ M x` with `σ = xᵀKx / xᵀMx` converges in it cubically (Peters and Wilkinson 1979,
//! SIAM Review 21, pp. 339–360). No mode needs the vectors of the others: the time goes with nodes times modes, up to the product of
//! the shapes at the end.

use super::forest::Forest;
use super::forest_lanes::{ForestLanes, Iterate, LANES};
use super::lanczos::RitzPairs;
use super::parallel;
use super::sorting::sort_rising;
use super::vector_ops::{axpy, dot, gemv};
use crate::base::code::Code;
use crate::base::error::Error;

/// Eigenvalues nearer than this (relative) are not separated: rounding of the counts of 100 000 nodes in a row.
const SAME_VALUE: f64 = 1e-13;

/// Modes that are not separated share a shift this far below them (relative), where one step enlarges them all alike.
const BELOW_REPEATED: f64 = 1e-12;

/// A bracket of one mode is divided until it is narrower than this (relative); the iteration does the rest in three or four steps.
const START_WIDTH: f64 = 0.2;

/// Estimated error of a shape at which its iteration ends.
const SHAPE_ERROR: f64 = 1e-13;

/// Residual relative to λ from which on the iteration also ends where it no longer shrinks.
const ROUNDING: f64 = 1e-11;

/// Most rounds of trial shifts, and of inverse iteration.
const MAX_ROUNDS: usize = 100;

/// Ratio of neighbouring trial shifts above zero.
const FIRST_RATIO: f64 = 1e-2;

/// Modes above this times the lowest λ get no last solution with K: rounding along the lowest shape would grow by their ratio.
const STATIC_RANGE: f64 = 1e8;

/// A shape that contains more of the others than this is orthogonalised twice.
const LARGE_PART: f64 = 1e-3;

/// Rows over which all shapes are multiplied: they stay in the cache.
const PIECE: usize = 512;

/// One mode: its bracket, its vector, and how far it is.
struct BracketedMode {
    low: f64,
    high: f64,
    /// No wider than rounding; modes of a repeated value have the same one.
    is_narrow: bool,
    iterate: Iterate,
    value: f64,
    /// Estimated error of the shape.
    error: f64,
    residual: f64,
    converged: bool,
}

/// The lowest elastic modes of a forest without loops, or all where there are fewer.
///
/// # Errors
/// `NoConvergence`.
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
        let open = |mode: &&mut BracketedMode| !mode.converged;
        let mut active: Vec<&mut Iterate> = (modes.iter_mut().filter(open))
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
    separate_repeated(&mut modes, &masses);
    solves += solve_statically(&lanes, forest, &masses, &mut modes);
    let counted = |mode: &BracketedMode| {
        let hair = ROUNDING * mode.value;
        mode.low - hair <= mode.value && mode.value <= mode.high + hair
    };
    let sturm_verified = modes.iter().all(counted);
    sort_rising(&mut modes, |mode| mode.value);
    let in_order_of_dofs = |mode: &BracketedMode| {
        let mut shape = vec![0.0; masses.len()];
        (forest.order.iter().zip(&mode.iterate.x)).for_each(|(&i, x)| shape[i] = *x);
        shape
    };
    Ok(RitzPairs {
        values: modes.iter().map(|mode| mode.value).collect(),
        vectors: modes.iter().map(in_order_of_dofs).collect(),
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

    /// The count narrows the bracket; the next shift is the quotient where it lies inside.
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

/// Halfway in frequency.
fn middle(low: f64, high: f64) -> f64 {
    (0.5 * (low.sqrt() + high.sqrt())).powi(2)
}

fn solve_all(lanes: &ForestLanes, iterates: &mut [&mut Iterate]) {
    let mut blocks: Vec<&mut [&mut Iterate]> = iterates.chunks_mut(LANES).collect();
    parallel::for_each(&mut blocks, |block| lanes.solve(block));
}

/// Brackets of the eigenvalues `first..last` by rising value, fewer where there are fewer; `first` of them are zero.
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
        above.map(|at| (known[at - 1].0, known[at].0))
    };
    (first..last).filter_map(bracket).collect()
}

/// Trial shifts between two whose counts differ by `inside`: evenly by decades where these are far apart, else in frequency.
fn push_trials(trials: &mut Vec<f64>, low: f64, high: f64, inside: usize) {
    let width = high - low;
    if low == 0.0 {
        trials.extend((1..=LANES as i32).map(|i| high * FIRST_RATIO.powi(i)));
    } else if high > 4.0 * low {
        let part = |i: usize| i as f64 / (LANES + 1) as f64;
        trials.extend((1..=LANES).map(|i| low * (high / low).powf(part(i))));
    } else if (inside > 1 && width > SAME_VALUE * high) || width > START_WIDTH * high {
        let n = inside.min(LANES);
        let (low, high) = (low.sqrt(), high.sqrt());
        let part = |i: usize| i as f64 / (n + 1) as f64;
        trials.extend((1..=n).map(|i| (low + part(i) * (high - low)).powi(2)));
    }
}

/// Distance of a shift from the brackets of other values.
fn gap(modes: &[BracketedMode], j: usize) -> f64 {
    let shift = modes[j].iterate.shift;
    let apart = |d: &f64| *d > SAME_VALUE * shift;
    let below = (modes[..j].iter().rev().map(|m| shift - m.high)).find(apart);
    let above = (modes[j + 1..].iter().map(|m| m.low - shift)).find(apart);
    below.unwrap_or(shift).min(above.unwrap_or(shift))
}

/// Numbers in (−1, 1) without pattern, the same every time, about as large in every mode.
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

/// Orthonormalises the shapes of each repeated value.
fn separate_repeated(modes: &mut [BracketedMode], masses: &[f64]) {
    let same = |m: &BracketedMode, next: &BracketedMode| m.is_narrow && m.high == next.high;
    (modes.chunk_by_mut(same))
        .filter(|group| group.len() > 1)
        .for_each(|group| drop(orthonormalise(group, masses)));
}

/// A last solution with K itself, in which nothing is subtracted: values to rounding. Shapes become orthogonal to rounding.
///
/// What a solution contains of lower modes grew by the ratio of the values; its energy is taken off. Returns the number of solutions.
fn solve_statically(
    lanes: &ForestLanes,
    forest: &Forest,
    masses: &[f64],
    modes: &mut [BracketedMode],
) -> usize {
    let lowest = modes.iter().map(|m| m.value).fold(f64::INFINITY, f64::min);
    let near = |mode: &BracketedMode| mode.value <= STATIC_RANGE * lowest;
    let mut iterates: Vec<&mut Iterate> = (modes.iter_mut().filter(|m| near(m)))
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
            let part = dot(&momentum, x) / inertia;
            axpy(x, -part, rigid);
        }
    }
    let solves = iterates.len();
    let energies: Vec<f64> = (modes.iter().map(|m| &m.iterate))
        .map(|i| i.quotient * i.norm * i.norm)
        .collect();
    let parts = orthonormalise(modes, masses);
    for j in 0..modes.len() {
        let lower = parts[j][..j].iter().zip(&modes[..j]);
        let of_lower: f64 = lower.map(|(part, mode)| part * part * mode.value).sum();
        modes[j].value = (energies[j] - of_lower) / parts[j][j].powi(2);
    }
    solves
}

/// Makes the shapes M-orthonormal, each by those before it. Returns R of `X = Q Rᵀ`, row by row.
fn orthonormalise(modes: &mut [BracketedMode], masses: &[f64]) -> Vec<Vec<f64>> {
    let r = orthonormalise_once(modes, masses);
    let is_large =
        |(j, row): (usize, &Vec<f64>)| row[..j].iter().any(|p| p.abs() > LARGE_PART * row[j]);
    if r.iter().enumerate().any(is_large) {
        orthonormalise_once(modes, masses);
    }
    r
}

/// The same without a second pass: `XᵀMX = R Rᵀ`, `Q = X R⁻ᵀ` (Cholesky).
fn orthonormalise_once(modes: &mut [BracketedMode], masses: &[f64]) -> Vec<Vec<f64>> {
    let n = modes.len();
    let mut r = vec![vec![0.0; n]; n];
    for (at, masses) in masses.chunks(PIECE).enumerate() {
        let span = at * PIECE..at * PIECE + masses.len();
        for j in 0..n {
            let x = &modes[j].iterate.x[span.clone()];
            let weighted: Vec<f64> = x.iter().zip(masses).map(|(x, m)| x * m).collect();
            for i in 0..=j {
                r[j][i] += dot(&weighted, &modes[i].iterate.x[span.clone()]);
            }
        }
    }
    for j in 0..n {
        for i in 0..=j {
            let rest = r[j][i] - dot(&r[j][..i], &r[i][..i]);
            r[j][i] = match i == j {
                true => rest.max(f64::EPSILON * f64::EPSILON * r[j][j]).sqrt(),
                false => rest / r[i][i],
            };
        }
    }
    for start in (0..masses.len()).step_by(PIECE) {
        let span = start..masses.len().min(start + PIECE);
        for j in 0..n {
            let (lower, rest) = modes.split_at_mut(j);
            let x = &mut rest[0].iterate.x[span.clone()];
            let parts: Vec<f64> = r[j][..j].iter().map(|part| -part).collect();
            gemv(x, &parts, |i| &lower[i].iterate.x[span.clone()]);
            x.iter_mut().for_each(|x| *x /= r[j][j]);
        }
    }
    modes.iter_mut().for_each(|mode| mode.iterate.norm = 1.0);
    r
}
