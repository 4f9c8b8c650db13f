//! Shift-and-invert Lanczos method on `(K − σM)⁻¹ M` with eigenvalues `θ = 1/(λ − σ)`: the modes nearest the shift σ.
//!
//! Every vector is M-orthogonalised against the rigid motions, the converged modes and the basis of its run. One run cannot resolve
//! repeated eigenvalues, so converged modes are deflated and further runs search for missing modes, until a Sturm count verifies
//! completeness or, without a count, a run yields no new mode.

use super::shift_invert::ShiftInvert;
use super::sorting::{falling_order, sort_ascending};
use super::sparse::SparseSymmetric;
use super::symmetric::symmetric_eigen;
use super::vector_ops::{axpy, dot, gemv, linear_combinations, normalised};
use super::{Matrix, parallel};
use crate::base::code::Code;
use crate::base::error::Error;

/// Residual of a converged Ritz pair relative to |θ|; the error of its value is the square of it over the gap.
const RESIDUAL_TOLERANCE: f64 = 1e-10;

/// Smallest accepted θ relative to the largest of a run, whose rounding limits its accuracy; a later run resolves it.
const MIN_THETA_RATIO: f64 = 1e-5;

/// Inverse relative growth of a run between convergence checks: the projected eigenproblem costs the cube of its length.
const CHECK_EVERY: usize = 8;

/// Number of rows per block of a blocked update: a block fits in the cache.
const BLOCK: usize = 1024;

/// Smallest total number of entries for several threads.
const MIN_PARALLEL_LENGTH: usize = 1 << 18;

/// Relative spacing below which two eigenvalues are counted together.
const SAME_VALUE: f64 = 1e-9;

/// Ratio of norms below which orthogonalisation is repeated (Daniel, Gragg, Kaufman and Stewart 1976, 1/√2).
const REORTHOGONALISE_BELOW: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Sturm count: number of eigenvalues of (K, M) below a value, including rigid motions.
pub type SturmCount<'a> = &'a dyn Fn(f64) -> Result<usize, Error>;

/// Eigenvalue problem for the Lanczos iteration.
pub struct LanczosProblem<'a> {
    /// The factorised `K − σM`.
    pub inverse: &'a dyn ShiftInvert,
    /// Mass matrix M.
    pub mass: &'a SparseSymmetric,
    /// Motions without strain energy, deflated exactly.
    pub rigid: &'a [Vec<f64>],
    /// Sturm count that verifies completeness.
    pub count: Option<SturmCount<'a>>,
    /// Number of requested modes.
    pub n_modes: usize,
}

/// Converged Ritz pairs in ascending order of λ.
#[derive(Debug, Clone)]
pub struct RitzPairs {
    /// Eigenvalues λ = ω², rad²/s².
    pub values: Vec<f64>,
    /// Shapes with `φᵀMφ = 1`, of either sign.
    pub vectors: Vec<Vec<f64>>,
    /// Residuals `‖(K − σM)⁻¹Mφ − θφ‖_M / |θ|` before the last solve, which reduces them further.
    pub residuals: Vec<f64>,
    /// Number of solved systems.
    pub solves: usize,
    /// Number of runs; each finds at most one mode of a repeated frequency.
    pub runs: usize,
    /// Whether a Sturm count verified completeness.
    pub sturm_verified: bool,
}

struct ConvergedPair {
    value: f64,
    vector: Vec<f64>,
    residual: f64,
}

/// Elastic modes nearest σ, at most the requested number.
pub fn nearest_modes(search: &LanczosProblem) -> Result<RitzPairs, Error> {
    let n_modes = search
        .n_modes
        .min(search.mass.len().saturating_sub(search.rigid.len()));
    let mut state = LanczosState {
        search,
        n_modes,
        deflated: Vec::new(),
        modes: Vec::new(),
        solves: 0,
    };
    for r in search.rigid {
        let mut r = r.clone();
        let norm = state.orthogonalise(&mut r, &[]);
        state.deflated.push(normalised(r, norm));
    }
    let max_runs = 20 + 3 * n_modes;
    let (mut start, mut stalled) = (None, false);
    for run in 0..max_runs {
        let counted = state.is_complete()?;
        if counted == Some(true) || (counted.is_none() && stalled && state.modes.len() >= n_modes) {
            return Ok(state.finish(run, counted == Some(true)));
        }
        let first = start
            .take()
            .unwrap_or_else(|| state.random_vector(run as u64));
        let result = state.run(first)?;
        if result.exhausted && result.modes.is_empty() {
            return Ok(state.finish(run + 1, counted == Some(true)));
        }
        stalled = result.nothing_new;
        start = result.restart;
        for (theta, vector) in result.modes {
            state.accept_pair(theta, vector);
        }
    }
    let n_converged = state.modes.len();
    Err(Error::new(
        Code::NoConvergence,
        format!(
            "Lanczos ended after {max_runs} runs and {} solves with {n_converged} of {n_modes} modes converged",
            state.solves
        ),
    ))
}

/// Result of one run.
#[derive(Default)]
struct RunResult {
    modes: Vec<(f64, Vec<f64>)>,
    restart: Option<Vec<f64>>,
    nothing_new: bool,
    /// No start vector outside the deflated space.
    exhausted: bool,
}

struct LanczosState<'a> {
    search: &'a LanczosProblem<'a>,
    /// Requested modes, at most the number of elastic modes.
    n_modes: usize,
    /// M-orthonormal rigid motions, then converged modes.
    deflated: Vec<Vec<f64>>,
    modes: Vec<ConvergedPair>,
    solves: usize,
}

impl LanczosState<'_> {
    fn mass_times(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        self.search.mass.mul_vec(x, &mut y);
        y
    }

    /// M-orthogonalises x against the deflated vectors and `basis`; returns its remaining norm.
    fn orthogonalise(&self, x: &mut [f64], basis: &[Vec<f64>]) -> f64 {
        let mut mx = self.mass_times(x);
        let mut norm = dot(x, &mx).max(0.0).sqrt();
        for _ in 0..4 {
            let all: Vec<&[f64]> = (self.deflated.iter().chain(basis))
                .map(Vec::as_slice)
                .collect();
            let share = |v: &&[f64]| -dot(v, &mx);
            let is_long = all.len() * x.len() >= MIN_PARALLEL_LENGTH;
            let factors: Vec<f64> = match is_long {
                true => parallel::map(&all, share),
                false => all.iter().map(share).collect(),
            };
            let mut blocks: Vec<_> = x.chunks_mut(BLOCK).enumerate().collect();
            let update = |(index, block): &mut (usize, &mut [f64])| {
                gemv(block, &factors, |j| &all[j][*index * BLOCK..]);
            };
            match is_long {
                true => parallel::for_each(&mut blocks, update),
                false => blocks.iter_mut().for_each(update),
            }
            self.search.mass.mul_vec(x, &mut mx);
            let remaining = dot(x, &mx).max(0.0).sqrt();
            if remaining > REORTHOGONALISE_BELOW * norm || remaining == 0.0 {
                return remaining;
            }
            norm = remaining;
        }
        norm
    }

    /// Pseudo-random start vector, reproducible, smoothed by one solve.
    fn random_vector(&mut self, seed: u64) -> Vec<f64> {
        let mut state = (seed + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let number = |_| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let mut x: Vec<f64> = (0..self.search.mass.len()).map(number).collect();
        let norm = self.orthogonalise(&mut x, &[]);
        self.solves += 1;
        let mut x = self.mass_times(&normalised(x, norm));
        self.search.inverse.solve(&mut x);
        x
    }

    fn run(&mut self, mut start: Vec<f64>) -> Result<RunResult, Error> {
        let before = {
            let m = self.mass_times(&start);
            dot(&start, &m).max(0.0).sqrt()
        };
        let norm = self.orthogonalise(&mut start, &[]);
        if !norm.is_finite() {
            return Err(Error::new(
                Code::Overflow,
                "the Lanczos vectors exceed the range of double precision",
            ));
        }
        if norm <= 1e3 * f64::EPSILON * before || norm == 0.0 {
            return Ok(RunResult {
                exhausted: true,
                ..RunResult::default()
            });
        }
        let max_length = (2 * self.n_modes + 60).min(start.len());
        let (mut alpha, mut beta): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        let mut basis = vec![normalised(start, norm)];
        // A basis smaller than the number of missing modes cannot contain all of them.
        let mut next_check = (self.n_modes.saturating_sub(self.modes.len()) + 5).max(10);
        loop {
            let j = basis.len() - 1;
            let mv = self.mass_times(&basis[j]);
            let mut w = mv.clone();
            self.search.inverse.solve(&mut w);
            self.solves += 1;
            alpha.push(dot(&w, &mv));
            axpy(&mut w, -alpha[j], &basis[j]);
            if j > 0 {
                axpy(&mut w, -beta[j - 1], &basis[j - 1]);
            }
            beta.push(self.orthogonalise(&mut w, &basis));
            let size = alpha
                .iter()
                .chain(&beta)
                .fold(0.0_f64, |m, v| m.max(v.abs()));
            if !size.is_finite() {
                return Err(Error::new(
                    Code::Overflow,
                    "the shift is an eigenvalue to rounding; move it",
                ));
            }
            let invariant = beta[j] <= 1e2 * f64::EPSILON * size;
            let last = invariant || basis.len() == max_length;
            if last || basis.len() >= next_check {
                let result = self.collect_converged(&alpha, &beta, &basis, invariant, last)?;
                if let Some(result) = result {
                    return Ok(result);
                }
                next_check = basis.len() + (basis.len() / CHECK_EVERY).max(5);
            }
            basis.push(normalised(w, beta[j]));
        }
    }

    /// Converged Ritz pairs of a run, if sufficient or at the end of the run.
    fn collect_converged(
        &self,
        alpha: &[f64],
        beta: &[f64],
        basis: &[Vec<f64>],
        invariant: bool,
        last: bool,
    ) -> Result<Option<RunResult>, Error> {
        let m = alpha.len();
        let projected = Matrix::from_fn(m, m, |i, j| match i.abs_diff(j) {
            0 => alpha[i],
            1 => beta[i.min(j)],
            _ => 0.0,
        });
        let eigen = symmetric_eigen(&projected)?;
        let theta = |i: usize| eigen.values[i];
        let order = falling_order((0..m).map(|j| theta(j).abs()));
        let largest = theta(order[0]).abs();
        let ready = |i: usize| {
            invariant
                || (beta[m - 1] * eigen.vectors[(m - 1, i)]).abs()
                    <= RESIDUAL_TOLERANCE * theta(i).abs()
        };
        let n_ready = order
            .iter()
            .take_while(|&&i| ready(i) && theta(i).abs() > MIN_THETA_RATIO * largest)
            .count();
        let n_missing = self.n_modes.saturating_sub(self.modes.len());
        let cutoff = self.cutoff();
        let nothing_new = n_ready > 0 && largest < cutoff;
        let passed = |i: usize| theta(i).abs() < cutoff;
        // The missing θ are below the accuracy of this run: the next run deflates the converged modes.
        let exhausted = order
            .get(n_ready)
            .is_some_and(|&i| n_ready > 0 && theta(i).abs() <= MIN_THETA_RATIO * largest);
        if !(last
            || nothing_new
            || exhausted
            || (n_missing > 0 && n_ready >= n_missing)
            || order[..n_ready].iter().any(|&i| passed(i)))
        {
            return Ok(None);
        }
        let n_restart = n_missing.max(1).min(m - n_ready);
        let restarts = last && !invariant && n_ready < n_missing.max(1);
        let factors = |row: usize| -> Vec<f64> {
            let mut factors: Vec<f64> = order[..n_ready]
                .iter()
                .map(|&i| eigen.vectors[(row, i)])
                .collect();
            factors.extend(restarts.then(|| {
                order[n_ready..n_ready + n_restart]
                    .iter()
                    .map(|&i| eigen.vectors[(row, i)])
                    .sum::<f64>()
            }));
            factors
        };
        let factors: Vec<Vec<f64>> = (0..m).map(factors).collect();
        let mut vectors = linear_combinations(basis, &factors);
        let restart = if restarts { vectors.pop() } else { None };
        let modes = order[..n_ready]
            .iter()
            .map(|&i| theta(i))
            .zip(vectors)
            .collect();
        Ok(Some(RunResult {
            modes,
            restart,
            nothing_new,
            exhausted: false,
        }))
    }

    /// Smallest |θ| of the requested modes.
    fn cutoff(&self) -> f64 {
        self.distances()
            .get(self.n_modes.wrapping_sub(1))
            .map_or(0.0, |d| (1.0 - SAME_VALUE) / d)
    }

    fn distances(&self) -> Vec<f64> {
        let mut distances: Vec<f64> = self
            .modes
            .iter()
            .map(|m| (m.value - self.search.inverse.shift()).abs())
            .collect();
        distances.sort_by(f64::total_cmp);
        distances
    }

    /// Refines a Ritz pair by one solve and the Rayleigh quotient `yᵀKy / yᵀMy`, and deflates the mode.
    fn accept_pair(&mut self, theta: f64, vector: Vec<f64>) {
        let f = self.mass_times(&vector);
        let mut y = f.clone();
        let energy = self.search.inverse.solve_with_energy(&mut y);
        if energy.is_none() {
            self.search.inverse.solve(&mut y);
        }
        self.solves += 1;
        let work = dot(&f, &y);
        let deflated_energy = self.energy_of_modes(&y);
        let mut residual_vector = y.clone();
        axpy(&mut residual_vector, -theta, &vector);
        let residual = self.orthogonalise(&mut residual_vector, &[]) / theta.abs();
        let norm = self.orthogonalise(&mut y, &[]);
        let value = match energy {
            Some(energy) => (energy - deflated_energy) / (norm * norm),
            None => self.search.inverse.shift() + work / (norm * norm),
        };
        let vector = normalised(y, norm);
        self.deflated.push(vector.clone());
        self.modes.push(ConvergedPair {
            value,
            vector,
            residual,
        });
    }

    /// Share of `yᵀKy` of converged modes, due to rounding.
    fn energy_of_modes(&self, y: &[f64]) -> f64 {
        let my = self.mass_times(y);
        let energy = |mode: &ConvergedPair| mode.value * dot(&mode.vector, &my).powi(2);
        self.modes.iter().map(energy).sum()
    }

    /// Whether all requested modes have converged by the Sturm count; none without a count.
    fn is_complete(&self) -> Result<Option<bool>, Error> {
        let Some(count) = self.search.count else {
            return Ok(None);
        };
        if self.n_modes == 0 {
            return Ok(Some(true));
        }
        let distances = self.distances();
        let Some(&last) = distances.get(self.n_modes - 1) else {
            return Ok(Some(false));
        };
        let shift = self.search.inverse.shift();
        let radius = last + SAME_VALUE * (last + shift.abs());
        let within = distances.iter().filter(|d| **d <= radius).count();
        let below = shift - radius;
        let known = within
            + if below > 0.0 {
                count(below)?
            } else {
                self.search.rigid.len()
            };
        Ok(Some(count(shift + radius)? <= known))
    }

    fn finish(self, runs: usize, counted: bool) -> RitzPairs {
        let shift = self.search.inverse.shift();
        let mut modes = self.modes;
        sort_ascending(&mut modes, |a| (a.value - shift).abs());
        modes.truncate(self.n_modes);
        sort_ascending(&mut modes, |a| a.value);
        let values = modes.iter().map(|m| m.value).collect();
        let residuals = modes.iter().map(|m| m.residual).collect();
        let vectors = modes.into_iter().map(|m| m.vector).collect();
        RitzPairs {
            values,
            vectors,
            residuals,
            solves: self.solves,
            runs,
            sturm_verified: counted,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::forest::{Forest, ForestSpring};
    use crate::numeric::shift_invert::ShiftedForest;

    /// Uniform chain of 800 discs, one end held, ω_j = 2 sin((2j − 1) π / (4n + 2)): systems solved grow with the number of modes.
    #[test]
    fn exact_solutions_grow_with_the_modes() {
        let n = 800;
        let spring = |i: usize| match i.checked_sub(1) {
            None => (0, 1.0, None),
            Some(before) => (before, -1.0, Some((i, 1.0))),
        };
        let springs: Vec<ForestSpring> = (0..n)
            .map(spring)
            .map(|(i, a, second)| ForestSpring {
                i,
                a,
                second,
                k: 1.0,
            })
            .collect();
        let mass = vec![1.0; n];
        let forest = Forest::new(n, &springs, &mass).unwrap();
        let matrix = SparseSymmetric::diagonal(&mass);
        let below = |sigma: f64| Ok(forest.count_below(&mass, sigma));
        for count in [10, 40, 160] {
            let found = nearest_modes(&LanczosProblem {
                inverse: &ShiftedForest::unshifted(&forest),
                mass: &matrix,
                rigid: &[],
                count: Some(&below),
                n_modes: count,
            })
            .unwrap();
            assert!(found.sturm_verified && found.values.len() == count);
            for (j, value) in found.values.iter().enumerate() {
                let angle = (2 * j + 1) as f64 * std::f64::consts::PI / (4 * n + 2) as f64;
                assert!(
                    (value.sqrt() / (2.0 * angle.sin()) - 1.0).abs() < 1e-13,
                    "{j} of {count}"
                );
            }
            assert!(
                found.solves <= 7 * count / 2 + 25,
                "{count}: {}",
                found.solves
            );
        }
    }
}
