//! Mode tracking over speed by the MAC of energy-weighted complex states.
//!
//! A mode is represented by the state `(√k wᵀφ, λ √m vᵀφ)`, whose squared norm is its energy. Without losses the states at one speed,
//! forward and backward whirl included, are orthogonal (see `gyroscopic`), so their squared products with the states at another speed, the
//! MAC (Allemang, Sound & Vibration 37 (2003), no. 8, 14–23), sum to 1. With losses this holds approximately.

use std::cell::Cell;

use super::mode::{Mode, modulus};
use crate::base::error::Error;
use crate::machine::linear::LinearModel;
use crate::numeric::assignment::assign;
use crate::numeric::mac::{self, hermitian_product};
use crate::numeric::sorting::{sort_ascending, sort_descending};
use crate::numeric::{Complex, Matrix, parallel};

/// Oscillatory modes at one speed, by rising |λ|.
#[derive(Debug, Clone)]
pub struct ModeSet {
    /// Reference speed, rad/s.
    pub speed: f64,
    /// Oscillatory modes, by rising |λ|.
    pub modes: Vec<TrackedMode>,
}

/// Mode with its energy-weighted state.
#[derive(Debug, Clone)]
pub struct TrackedMode {
    /// Mode; for a repeated eigenvalue, the shape is the combination that continues the tracked branch.
    pub mode: Mode,
    state: Vec<Complex>,
}

/// Matching of the modes at an earlier speed with those at the present speed.
#[derive(Debug, Clone)]
pub struct ModeMatching {
    /// Present index of every earlier mode; `None` without a match, as for a mode that is no longer oscillatory.
    pub to: Vec<Option<usize>>,
    /// Whether the match of every earlier mode stays ambiguous at the smallest step.
    pub uncertain: Vec<bool>,
}

impl ModeMatching {
    fn compose(self, next: &ModeMatching) -> ModeMatching {
        let either =
            |(&to, &first): (&Option<usize>, &bool)| first || to.is_some_and(|j| next.uncertain[j]);
        let uncertain = self.to.iter().zip(&self.uncertain).map(either).collect();
        ModeMatching {
            to: self
                .to
                .iter()
                .map(|to| to.and_then(|j| next.to[j]))
                .collect(),
            uncertain,
        }
    }
}

/// Acceptance limits and step control of the mode tracking.
#[derive(Debug, Clone, Copy)]
pub struct TrackingOptions {
    /// Smallest MAC, 0 to 1, of a match that needs no smaller step.
    pub accept_mac: f64,
    /// Smallest MAC, 0 to 1, of a match at the smallest step.
    pub min_mac: f64,
    /// Maximum number of halvings of a step.
    pub halvings: u32,
    /// Maximum number of speeds solved inside one step.
    pub max_solves: usize,
}

impl Default for TrackingOptions {
    /// MAC limits 0.9 and 0.5, 24 halvings, 120 solves.
    fn default() -> Self {
        TrackingOptions {
            accept_mac: 0.9,
            min_mac: 0.5,
            halvings: 24,
            max_solves: 120,
        }
    }
}

/// Relative difference below which eigenvalues or shapes count as equal, √ε with a margin; a veering narrower than this is a crossing.
const REPEATED_TOLERANCE: f64 = 1e-7;

/// Tracks the modes that `solve` computes at a speed, rad/s.
pub struct ModeTracker<'a, F: Fn(f64) -> Result<Vec<Mode>, Error>> {
    model: &'a LinearModel,
    solve: F,
    options: TrackingOptions,
    solves: Cell<usize>,
}

impl<'a, F: Fn(f64) -> Result<Vec<Mode>, Error>> ModeTracker<'a, F> {
    /// Tracker for the modes of one model.
    pub fn new(model: &'a LinearModel, options: TrackingOptions, solve: F) -> Self {
        ModeTracker {
            model,
            solve,
            options,
            solves: Cell::new(0),
        }
    }

    /// Number of speeds solved so far.
    pub fn solves(&self) -> usize {
        self.solves.get()
    }

    /// Modes at the first speed, rad/s; repeated modes are aligned with those at a slightly different speed towards `next`.
    ///
    /// # Errors
    /// Those of the solver.
    pub fn start(&self, speed: f64, next: f64) -> Result<ModeSet, Error> {
        let mut first = self.solve_at(speed)?;
        if next != speed && groups(&first).iter().any(|group| group.len() > 1) {
            let neighbour = self.solve_at(speed + (next - speed) / 64.0)?; // the shapes are nearly unchanged
            align_repeated(&mut first, &neighbour);
        }
        Ok(first)
    }

    /// Modes at the next speed, rad/s, and their matching with the modes `from`.
    ///
    /// # Errors
    /// Those of the solver.
    pub fn follow(&self, from: &ModeSet, speed: f64) -> Result<(ModeSet, ModeMatching), Error> {
        let to = self.solve_at(speed)?;
        self.follow_to(from, to)
    }

    /// Matching with known modes at the next speed; otherwise as [`ModeTracker::follow`].
    ///
    /// # Errors
    /// Those of the solver.
    pub fn follow_to(&self, from: &ModeSet, to: ModeSet) -> Result<(ModeSet, ModeMatching), Error> {
        // The solution `to` counts as a solve of this step.
        let solves_before = self.solves.get() - 1;
        self.step(from, to, 0, solves_before)
    }

    /// Modes at several speeds, rad/s, not yet matched.
    ///
    /// # Errors
    /// Those of the solver.
    pub fn mode_sets(&self, speeds: &[f64]) -> Result<Vec<ModeSet>, Error>
    where
        F: Sync,
    {
        self.solves.set(self.solves.get() + speeds.len());
        let (model, solve) = (self.model, &self.solve);
        parallel::try_map(speeds, |&speed| Ok(mode_set(model, speed, solve(speed)?)))
    }

    fn step(
        &self,
        from: &ModeSet,
        mut to: ModeSet,
        depth: u32,
        solves_before: usize,
    ) -> Result<(ModeSet, ModeMatching), Error> {
        align_repeated(&mut to, from);
        let mac = mac_matrix(from, &to);
        let pairs = assign(&mac);
        let speed = self.refinement_speed(from, &to, &mac, &pairs);
        let is_last = depth >= self.options.halvings
            || self.solves.get() - solves_before >= self.options.max_solves;
        let Some(middle) = speed.filter(|_| !is_last) else {
            return Ok((to, self.assign_modes(&mac, pairs)));
        };
        let middle = self.solve_at(middle)?;
        let (middle, first) = self.step(from, middle, depth + 1, solves_before)?;
        let (to, second) = self.step(&middle, to, depth + 1, solves_before)?;
        Ok((to, first.compose(&second)))
    }

    /// Next speed to evaluate if a match is uncertain: halfway, or at the apparent crossing of two branches that may veer instead.
    fn refinement_speed(
        &self,
        from: &ModeSet,
        to: &ModeSet,
        mac: &Matrix,
        pairs: &[Option<usize>],
    ) -> Option<f64> {
        let width = to.speed - from.speed;
        for (i, pair) in pairs.iter().enumerate() {
            let Some(j) = *pair else { continue };
            let second = (0..mac.ncols())
                .filter(|&k| k != j)
                .map(|k| mac[(i, k)])
                .fold(0.0, f64::max);
            if mac[(i, j)] < self.options.accept_mac || second > mac[(i, j)] - 0.1 {
                return Some(from.speed + width / 2.0);
            }
        }
        let matched: Vec<(usize, usize)> = pairs
            .iter()
            .enumerate()
            .filter_map(|(i, j)| j.map(|j| (i, j)))
            .collect();
        let omega = |set: &ModeSet, i: usize| set.modes[i].mode.omega();
        for (at, &(i, j)) in matched.iter().enumerate() {
            for &(k, l) in &matched[at + 1..] {
                let before = omega(from, i) - omega(from, k);
                let after = omega(to, j) - omega(to, l);
                let is_distinct = before.abs() > REPEATED_TOLERANCE * omega(from, i)
                    && after.abs() > REPEATED_TOLERANCE * omega(to, j);
                let is_coupled =
                    mac[(i, l)].max(mac[(k, j)]) > REPEATED_TOLERANCE * REPEATED_TOLERANCE;
                if before * after < 0.0 && is_distinct && is_coupled {
                    return Some(
                        from.speed + width * (before / (before - after)).clamp(0.01, 0.99),
                    );
                }
            }
        }
        None
    }

    fn assign_modes(&self, mac: &Matrix, mut to: Vec<Option<usize>>) -> ModeMatching {
        let mut uncertain = vec![false; to.len()];
        for (i, pair) in to.iter_mut().enumerate() {
            let Some(j) = *pair else { continue };
            uncertain[i] = mac[(i, j)] < self.options.accept_mac;
            if mac[(i, j)] < self.options.min_mac {
                *pair = None;
            }
        }
        ModeMatching { to, uncertain }
    }

    fn solve_at(&self, speed: f64) -> Result<ModeSet, Error> {
        self.solves.set(self.solves.get() + 1);
        Ok(mode_set(self.model, speed, (self.solve)(speed)?))
    }
}

/// Oscillatory modes of those at a speed, by rising |λ|, with their states.
fn mode_set(model: &LinearModel, speed: f64, modes: Vec<Mode>) -> ModeSet {
    let oscillatory = modes
        .into_iter()
        .filter(|mode| !mode.rigid && mode.is_oscillatory());
    let mut modes: Vec<TrackedMode> = oscillatory
        .map(|mode| TrackedMode {
            state: state(model, &mode),
            mode,
        })
        .collect();
    sort_ascending(&mut modes, |a| a.mode.omega());
    ModeSet { speed, modes }
}

/// State `(√k wᵀφ, λ √m vᵀφ)` of norm one; branches with negative or one-sided stiffness do not contribute.
fn state(model: &LinearModel, mode: &Mode) -> Vec<Complex> {
    let p = model.select_independent(&mode.shape);
    let springs = model
        .branches
        .iter()
        .filter(|b| b.stiffness > 0.0 && b.force.is_none());
    let strains = springs.map(|b| b.direction.dot_complex(&p) * b.stiffness.sqrt());
    let velocities = model
        .masses
        .iter()
        .map(|m| mode.eigenvalue * m.direction.dot_complex(&p) * m.value.sqrt());
    let mut state: Vec<Complex> = strains.chain(velocities).collect();
    let norm = hermitian_product(&state, &state).re.sqrt();
    if norm > 0.0 {
        scale(&mut state, 1.0 / norm);
    }
    state
}

fn scale(a: &mut [Complex], factor: f64) {
    a.iter_mut().for_each(|x| *x *= factor);
}

/// `a += factor · b`.
fn add(a: &mut [Complex], factor: Complex, b: &[Complex]) {
    a.iter_mut().zip(b).for_each(|(x, y)| *x += factor * y);
}

/// Modal assurance criterion of every earlier mode (row) with every later mode (column).
fn mac_matrix(from: &ModeSet, to: &ModeSet) -> Matrix {
    Matrix::from_fn(from.modes.len(), to.modes.len(), |i, j| {
        mac::mac(&from.modes[i].state, &to.modes[j].state)
    })
}

/// Index ranges of modes with equal eigenvalues.
fn groups(set: &ModeSet) -> Vec<std::ops::Range<usize>> {
    let mut groups: Vec<std::ops::Range<usize>> = Vec::new();
    for (i, mode) in set.modes.iter().enumerate() {
        let lambda = mode.mode.eigenvalue;
        match groups.last_mut() {
            Some(group)
                if modulus(lambda - set.modes[i - 1].mode.eigenvalue)
                    <= REPEATED_TOLERANCE * modulus(lambda) =>
            {
                group.end = i + 1;
            }
            _ => groups.push(i..i + 1),
        }
    }
    groups
}

/// Replaces the shapes of repeated modes, which are arbitrary combinations, by those closest to the modes of `reference`.
fn align_repeated(set: &mut ModeSet, reference: &ModeSet) {
    for group in groups(set).into_iter().filter(|group| group.len() > 1) {
        let mut basis: Vec<TrackedMode> = Vec::new();
        for mode in &set.modes[group.clone()] {
            let mut next = mode.clone();
            if orthonormalise(&mut next, &basis) {
                basis.push(next);
            }
        }
        if basis.len() < group.len() {
            continue; // defective: the eigenvectors do not span the group
        }
        let components = |target: &TrackedMode| -> Vec<Complex> {
            basis
                .iter()
                .map(|b| hermitian_product(&b.state, &target.state))
                .collect()
        };
        let mut targets: Vec<Vec<Complex>> = reference.modes.iter().map(components).collect();
        let energy =
            |components: &Vec<Complex>| components.iter().map(|c| c.norm_sqr()).sum::<f64>();
        sort_descending(&mut targets, energy);
        let mut aligned: Vec<TrackedMode> = Vec::new();
        let axes = (0..basis.len()).map(|i| {
            (0..basis.len())
                .map(|j| Complex::new(f64::from(u8::from(i == j)), 0.0))
                .collect()
        });
        for components in targets.into_iter().chain(axes) {
            if aligned.len() < basis.len() {
                let mut next = combination(&basis, &components);
                if orthonormalise(&mut next, &aligned) {
                    aligned.push(next);
                }
            }
        }
        sort_ascending(&mut aligned, |a| a.mode.omega());
        for (index, mode) in group.zip(aligned) {
            set.modes[index] = mode;
        }
    }
}

/// Combination `Σ component · mode`; its eigenvalue is the weighted mean, as the eigenvalues differ by rounding only.
fn combination(basis: &[TrackedMode], components: &[Complex]) -> TrackedMode {
    let mut sum = basis[0].clone();
    let zero = Complex::ZERO;
    sum.state.fill(zero);
    sum.mode.shape.fill(zero);
    let (mut lambda, mut weight) = (zero, 0.0);
    for (b, &c) in basis.iter().zip(components) {
        add(&mut sum.state, c, &b.state);
        add(&mut sum.mode.shape, c, &b.mode.shape);
        lambda += b.mode.eigenvalue * c.norm_sqr();
        weight += c.norm_sqr();
    }
    if weight > 0.0 {
        sum.mode.eigenvalue = lambda / weight;
    }
    sum
}

/// Orthonormalises a mode against others by two Gram–Schmidt passes; `false` if the remainder is rounding.
fn orthonormalise(mode: &mut TrackedMode, others: &[TrackedMode]) -> bool {
    let norm_before = hermitian_product(&mode.state, &mode.state).re.sqrt();
    for _ in 0..2 {
        for other in others {
            let component = -hermitian_product(&other.state, &mode.state);
            add(&mut mode.state, component, &other.state);
            add(&mut mode.mode.shape, component, &other.mode.shape);
        }
    }
    let norm = hermitian_product(&mode.state, &mode.state).re.sqrt();
    let is_new = norm > 1e-3 * norm_before && norm > 1e-6; // relative to unit states
    if is_new {
        scale(&mut mode.state, 1.0 / norm);
        scale(&mut mode.mode.shape, 1.0 / norm);
    }
    is_new
}
