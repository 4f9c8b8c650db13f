//! Mode tracking over speed by the MAC of energy-weighted complex states.
//!
//! A mode is the state `(√k wᵀφ, λ √m vᵀφ)`, whose squared length is its energy. Without losses the states of one speed are
//! orthogonal in this product (see `gyroscopic`), forward and backward whirl apart, so that the squares of their products
//! with those of another speed, the MAC (Allemang, Sound & Vibration 37 (2003), no. 8, 14–23), sum to 1. With losses they are nearly so.

use std::cell::Cell;

use super::mode::{Mode, modulus};
use crate::base::error::Error;
use crate::machine::linear::LinearModel;
use crate::numeric::assignment::assign;
use crate::numeric::mac::{self, hermitian_product};
use crate::numeric::sorting::{sort_falling, sort_rising};
use crate::numeric::{Complex, Matrix, parallel};

/// Oscillatory modes at one speed, by rising |λ|.
#[derive(Debug, Clone)]
pub struct ModeSet {
    /// Reference speed, rad/s.
    pub speed: f64,
    /// The modes.
    pub modes: Vec<TrackedMode>,
}

/// A mode with its state.
#[derive(Debug, Clone)]
pub struct TrackedMode {
    /// The mode. Of repeated ones the shape is the combination that continues its branch.
    pub mode: Mode,
    state: Vec<Complex>,
}

/// Which mode became which.
#[derive(Debug, Clone)]
pub struct ModeMatching {
    /// Present number of every earlier mode, or `None` where it ceased to be oscillatory.
    pub to: Vec<Option<usize>>,
    /// Uncertainty flag of every earlier mode: its match stays ambiguous even at the smallest step.
    pub uncertain: Vec<bool>,
}

impl ModeMatching {
    fn compose(self, next: &ModeMatching) -> ModeMatching {
        let doubt =
            |(&to, &doubt): (&Option<usize>, &bool)| doubt || to.is_some_and(|j| next.uncertain[j]);
        let uncertain = self.to.iter().zip(&self.uncertain).map(doubt).collect();
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

/// When a match is believed.
#[derive(Debug, Clone, Copy)]
pub struct TrackingOptions {
    /// Smallest MAC of a match that needs no smaller step.
    pub accept_mac: f64,
    /// Smallest MAC at which the smallest step still calls it the same mode.
    pub min_mac: f64,
    /// Maximum number of times a step is halved.
    pub halvings: u32,
    /// Most speeds solved inside one step.
    pub max_solves: usize,
}

impl Default for TrackingOptions {
    /// 0.9, 0.5, 24 halvings, 120 solves.
    fn default() -> Self {
        TrackingOptions {
            accept_mac: 0.9,
            min_mac: 0.5,
            halvings: 24,
            max_solves: 120,
        }
    }
}

/// Two frequencies, or two shapes, that are taken for equal: relative, √ε with a margin. A veering narrower than this is a crossing.
const REPEATED_TOLERANCE: f64 = 1e-7;

/// Follows the modes that `solve` finds at a speed, rad/s.
pub struct ModeTracker<'a, F: Fn(f64) -> Result<Vec<Mode>, Error>> {
    model: &'a LinearModel,
    solve: F,
    options: TrackingOptions,
    solves: Cell<usize>,
}

impl<'a, F: Fn(f64) -> Result<Vec<Mode>, Error>> ModeTracker<'a, F> {
    /// A tracker for the modes of one machine.
    pub fn new(model: &'a LinearModel, options: TrackingOptions, solve: F) -> Self {
        ModeTracker {
            model,
            solve,
            options,
            solves: Cell::new(0),
        }
    }

    /// Speeds solved so far.
    pub fn solves(&self) -> usize {
        self.solves.get()
    }

    /// The modes at the first speed; repeated ones are split as they will part towards `next`.
    ///
    /// # Errors
    /// Those of the solver.
    pub fn start(&self, speed: f64, next: f64) -> Result<ModeSet, Error> {
        let mut first = self.snapshot(speed)?;
        if next != speed && groups(&first).iter().any(|group| group.len() > 1) {
            let near = self.snapshot(speed + (next - speed) / 64.0)?; // so little that shapes have not changed yet
            align_repeated(&mut first, &near);
        }
        Ok(first)
    }

    /// The modes at the next speed, and which of those before each continues.
    ///
    /// # Errors
    /// Those of the solver.
    pub fn follow(&self, from: &ModeSet, speed: f64) -> Result<(ModeSet, ModeMatching), Error> {
        let to = self.snapshot(speed)?;
        self.follow_to(from, to)
    }

    /// As [`ModeTracker::follow`], the modes at the next speed being known.
    ///
    /// # Errors
    /// Those of the solver.
    pub fn follow_to(&self, from: &ModeSet, to: ModeSet) -> Result<(ModeSet, ModeMatching), Error> {
        // The solution `to` counts as one of this step.
        let spent = self.solves.get() - 1;
        self.step(from, to, 0, spent)
    }

    /// The modes at several speeds, not yet matched.
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
        spent: usize,
    ) -> Result<(ModeSet, ModeMatching), Error> {
        align_repeated(&mut to, from);
        let likeness = mac(from, &to);
        let pairs = assign(&likeness);
        let doubt = self.refinement_speed(from, &to, &likeness, &pairs);
        let is_last =
            depth >= self.options.halvings || self.solves.get() - spent >= self.options.max_solves;
        let Some(middle) = doubt.filter(|_| !is_last) else {
            return Ok((to, self.assign_modes(&likeness, pairs)));
        };
        let middle = self.snapshot(middle)?;
        let (middle, first) = self.step(from, middle, depth + 1, spent)?;
        let (to, second) = self.step(&middle, to, depth + 1, spent)?;
        Ok((to, first.compose(&second)))
    }

    /// Next speed to evaluate if a match is uncertain: halfway, or where two branches seem to cross and may veer instead.
    fn refinement_speed(
        &self,
        from: &ModeSet,
        to: &ModeSet,
        likeness: &Matrix,
        pairs: &[Option<usize>],
    ) -> Option<f64> {
        let width = to.speed - from.speed;
        for (i, pair) in pairs.iter().enumerate() {
            let Some(j) = *pair else { continue };
            let rival = (0..likeness.ncols())
                .filter(|&k| k != j)
                .map(|k| likeness[(i, k)])
                .fold(0.0, f64::max);
            if likeness[(i, j)] < self.options.accept_mac || rival > likeness[(i, j)] - 0.1 {
                return Some(from.speed + width / 2.0);
            }
        }
        let matched: Vec<(usize, usize)> = pairs
            .iter()
            .enumerate()
            .filter_map(|(i, j)| j.map(|j| (i, j)))
            .collect();
        let omega = |snapshot: &ModeSet, i: usize| snapshot.modes[i].mode.omega();
        for (at, &(i, j)) in matched.iter().enumerate() {
            for &(k, l) in &matched[at + 1..] {
                let before = omega(from, i) - omega(from, k);
                let after = omega(to, j) - omega(to, l);
                let is_apart = before.abs() > REPEATED_TOLERANCE * omega(from, i)
                    && after.abs() > REPEATED_TOLERANCE * omega(to, j);
                let is_coupled = likeness[(i, l)].max(likeness[(k, j)])
                    > REPEATED_TOLERANCE * REPEATED_TOLERANCE;
                if before * after < 0.0 && is_apart && is_coupled {
                    return Some(
                        from.speed + width * (before / (before - after)).clamp(0.01, 0.99),
                    );
                }
            }
        }
        None
    }

    fn assign_modes(&self, likeness: &Matrix, mut to: Vec<Option<usize>>) -> ModeMatching {
        let mut uncertain = vec![false; to.len()];
        for (i, pair) in to.iter_mut().enumerate() {
            let Some(j) = *pair else { continue };
            uncertain[i] = likeness[(i, j)] < self.options.accept_mac;
            if likeness[(i, j)] < self.options.min_mac {
                *pair = None;
            }
        }
        ModeMatching { to, uncertain }
    }

    fn snapshot(&self, speed: f64) -> Result<ModeSet, Error> {
        self.solves.set(self.solves.get() + 1);
        Ok(mode_set(self.model, speed, (self.solve)(speed)?))
    }
}

/// The oscillatory ones of the modes at a speed, by rising |λ|.
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
    sort_rising(&mut modes, |a| a.mode.omega());
    ModeSet { speed, modes }
}

/// `(√k wᵀφ, λ √m vᵀφ)` of length one. What is no square (negative or one-sided stiffness) has no part in it.
fn state(model: &LinearModel, mode: &Mode) -> Vec<Complex> {
    let p = model.select_independent(&mode.shape);
    let springs = model
        .branches
        .iter()
        .filter(|b| b.stiffness > 0.0 && b.force.is_none());
    let strained = springs.map(|b| b.direction.dot_complex(&p) * b.stiffness.sqrt());
    let moving = model
        .masses
        .iter()
        .map(|m| mode.eigenvalue * m.direction.dot_complex(&p) * m.value.sqrt());
    let mut state: Vec<Complex> = strained.chain(moving).collect();
    let length = hermitian_product(&state, &state).re.sqrt();
    if length > 0.0 {
        scale(&mut state, 1.0 / length);
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

/// Modal assurance criterion of every mode before with every mode after.
fn mac(from: &ModeSet, to: &ModeSet) -> Matrix {
    Matrix::from_fn(from.modes.len(), to.modes.len(), |i, j| {
        mac::mac(&from.modes[i].state, &to.modes[j].state)
    })
}

/// Runs of modes whose eigenvalues are equal.
fn groups(snapshot: &ModeSet) -> Vec<std::ops::Range<usize>> {
    let mut groups: Vec<std::ops::Range<usize>> = Vec::new();
    for (i, followed) in snapshot.modes.iter().enumerate() {
        let lambda = followed.mode.eigenvalue;
        match groups.last_mut() {
            Some(group)
                if modulus(lambda - snapshot.modes[i - 1].mode.eigenvalue)
                    <= REPEATED_TOLERANCE * modulus(lambda) =>
            {
                group.end = i + 1;
            }
            _ => groups.push(i..i + 1),
        }
    }
    groups
}

/// Shapes of repeated modes are any combination of each other: takes those most like the modes of `like`.
fn align_repeated(snapshot: &mut ModeSet, like: &ModeSet) {
    for group in groups(snapshot).into_iter().filter(|group| group.len() > 1) {
        let mut basis: Vec<TrackedMode> = Vec::new();
        for followed in &snapshot.modes[group.clone()] {
            let mut next = followed.clone();
            if orthonormalise(&mut next, &basis) {
                basis.push(next);
            }
        }
        if basis.len() < group.len() {
            continue; // defective: there are no others to choose from
        }
        let parts = |target: &TrackedMode| -> Vec<Complex> {
            basis
                .iter()
                .map(|b| hermitian_product(&b.state, &target.state))
                .collect()
        };
        let mut targets: Vec<Vec<Complex>> = like.modes.iter().map(parts).collect();
        let size = |parts: &Vec<Complex>| parts.iter().map(|c| c.norm_sqr()).sum::<f64>();
        sort_falling(&mut targets, size);
        let mut turned: Vec<TrackedMode> = Vec::new();
        let axes = (0..basis.len()).map(|i| {
            (0..basis.len())
                .map(|j| Complex::new(f64::from(u8::from(i == j)), 0.0))
                .collect()
        });
        for parts in targets.into_iter().chain(axes) {
            if turned.len() < basis.len() {
                let mut next = combination(&basis, &parts);
                if orthonormalise(&mut next, &turned) {
                    turned.push(next);
                }
            }
        }
        sort_rising(&mut turned, |a| a.mode.omega());
        for (place, followed) in group.zip(turned) {
            snapshot.modes[place] = followed;
        }
    }
}

/// `Σ part · mode`; its eigenvalue, equal but for rounding, is the mean.
fn combination(basis: &[TrackedMode], parts: &[Complex]) -> TrackedMode {
    let mut sum = basis[0].clone();
    let zero = Complex::ZERO;
    sum.state.fill(zero);
    sum.mode.shape.fill(zero);
    let (mut lambda, mut weight) = (zero, 0.0);
    for (b, &part) in basis.iter().zip(parts) {
        add(&mut sum.state, part, &b.state);
        add(&mut sum.mode.shape, part, &b.mode.shape);
        lambda += b.mode.eigenvalue * part.norm_sqr();
        weight += part.norm_sqr();
    }
    if weight > 0.0 {
        sum.mode.eigenvalue = lambda / weight;
    }
    sum
}

/// Takes out what the others have of it; false where little is left.
fn orthonormalise(followed: &mut TrackedMode, others: &[TrackedMode]) -> bool {
    let whole = hermitian_product(&followed.state, &followed.state)
        .re
        .sqrt();
    for _ in 0..2 {
        for other in others {
            let part = -hermitian_product(&other.state, &followed.state);
            add(&mut followed.state, part, &other.state);
            add(&mut followed.mode.shape, part, &other.mode.shape);
        }
    }
    let length = hermitian_product(&followed.state, &followed.state)
        .re
        .sqrt();
    let is_new = length > 1e-3 * whole && length > 1e-6; // of unit states: less is no direction of its own
    if is_new {
        scale(&mut followed.state, 1.0 / length);
        scale(&mut followed.mode.shape, 1.0 / length);
    }
    is_new
}
