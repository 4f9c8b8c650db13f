//! Following modes from one speed to the next by the likeness of their complex states.
//!
//! A mode is the state `(√k wᵀφ, λ √m vᵀφ)`, whose squared length is its energy. Without losses the states of one speed are
//! orthogonal in this product (see `gyroscopic`), forward and backward whirl apart, so that the squares of their products
//! with those of another speed, the MAC (Allemang, Sound & Vibration 37 (2003), no. 8, 14–23), sum to 1. With losses they are nearly so.

use std::cell::Cell;

use super::mode::{Mode, modulus};
use crate::base::error::Error;
use crate::machine::linear::Linear;
use crate::numeric::assignment::assign;
use crate::numeric::collinearity::{self, product};
use crate::numeric::{Complex, Matrix};

/// The modes that swing at one speed, by rising |λ|.
#[derive(Debug, Clone)]
pub struct Snapshot {
    /// Of the reference, rad/s.
    pub speed: f64,
    /// The modes.
    pub modes: Vec<Followed>,
}

/// A mode with its state.
#[derive(Debug, Clone)]
pub struct Followed {
    /// The mode. Of repeated ones the shape is the combination that continues its branch.
    pub mode: Mode,
    state: Vec<Complex>,
}

/// Which mode became which.
#[derive(Debug, Clone)]
pub struct Link {
    /// For every mode before: its number now, or nothing where it ceased to swing.
    pub to: Vec<Option<usize>>,
    /// For every mode before: whether the smallest step still left a doubt.
    pub uncertain: Vec<bool>,
}

impl Link {
    fn then(self, next: &Link) -> Link {
        let doubt =
            |(&to, &doubt): (&Option<usize>, &bool)| doubt || to.is_some_and(|j| next.uncertain[j]);
        let uncertain = self.to.iter().zip(&self.uncertain).map(doubt).collect();
        Link {
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
    pub sure: f64,
    /// Smallest MAC at which the smallest step still calls it the same mode.
    pub same: f64,
    /// How often a step may be halved.
    pub halvings: u32,
    /// Most speeds solved inside one step.
    pub most_solves: usize,
}

impl Default for TrackingOptions {
    /// 0.9, 0.5, 24 halvings, 120 solves.
    fn default() -> Self {
        TrackingOptions {
            sure: 0.9,
            same: 0.5,
            halvings: 24,
            most_solves: 120,
        }
    }
}

/// Two frequencies, or two shapes, that are taken for equal: relative, √ε with a margin. A veering narrower than this is a crossing.
const EQUAL: f64 = 1e-7;

/// Follows the modes that `solve` finds at a speed, rad/s.
pub struct Tracker<'a, F: Fn(f64) -> Result<Vec<Mode>, Error>> {
    linear: &'a Linear,
    solve: F,
    options: TrackingOptions,
    solves: Cell<usize>,
}

impl<'a, F: Fn(f64) -> Result<Vec<Mode>, Error>> Tracker<'a, F> {
    /// A tracker for the modes of one machine.
    pub fn new(linear: &'a Linear, options: TrackingOptions, solve: F) -> Self {
        Tracker {
            linear,
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
    pub fn start(&self, speed: f64, next: f64) -> Result<Snapshot, Error> {
        let mut first = self.snapshot(speed)?;
        if next != speed && groups(&first).iter().any(|group| group.len() > 1) {
            let near = self.snapshot(speed + (next - speed) / 64.0)?; // so little that shapes have not changed yet
            turn_repeated(&mut first, &near);
        }
        Ok(first)
    }

    /// The modes at the next speed, and which of those before each continues.
    ///
    /// # Errors
    /// Those of the solver.
    pub fn follow(&self, from: &Snapshot, speed: f64) -> Result<(Snapshot, Link), Error> {
        let spent = self.solves.get();
        let to = self.snapshot(speed)?;
        self.step(from, to, 0, spent)
    }

    fn step(
        &self,
        from: &Snapshot,
        mut to: Snapshot,
        depth: u32,
        spent: usize,
    ) -> Result<(Snapshot, Link), Error> {
        turn_repeated(&mut to, from);
        let likeness = mac(from, &to);
        let pairs = assign(&likeness);
        let doubt = self.doubt(from, &to, &likeness, &pairs);
        let is_last =
            depth >= self.options.halvings || self.solves.get() - spent >= self.options.most_solves;
        let Some(middle) = doubt.filter(|_| !is_last) else {
            return Ok((to, self.settle(&likeness, pairs)));
        };
        let middle = self.snapshot(middle)?;
        let (middle, first) = self.step(from, middle, depth + 1, spent)?;
        let (to, second) = self.step(&middle, to, depth + 1, spent)?;
        Ok((to, first.then(&second)))
    }

    /// Where to look next, if a match is in doubt: halfway, or where two branches seem to cross and may veer instead.
    fn doubt(
        &self,
        from: &Snapshot,
        to: &Snapshot,
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
            if likeness[(i, j)] < self.options.sure || rival > likeness[(i, j)] - 0.1 {
                return Some(from.speed + width / 2.0);
            }
        }
        let matched: Vec<(usize, usize)> = pairs
            .iter()
            .enumerate()
            .filter_map(|(i, j)| j.map(|j| (i, j)))
            .collect();
        let omega = |snapshot: &Snapshot, i: usize| snapshot.modes[i].mode.omega();
        for (at, &(i, j)) in matched.iter().enumerate() {
            for &(k, l) in &matched[at + 1..] {
                let before = omega(from, i) - omega(from, k);
                let after = omega(to, j) - omega(to, l);
                let is_apart =
                    before.abs() > EQUAL * omega(from, i) && after.abs() > EQUAL * omega(to, j);
                let is_coupled = likeness[(i, l)].max(likeness[(k, j)]) > EQUAL * EQUAL;
                if before * after < 0.0 && is_apart && is_coupled {
                    return Some(
                        from.speed + width * (before / (before - after)).clamp(0.01, 0.99),
                    );
                }
            }
        }
        None
    }

    fn settle(&self, likeness: &Matrix, mut to: Vec<Option<usize>>) -> Link {
        let mut uncertain = vec![false; to.len()];
        for (i, pair) in to.iter_mut().enumerate() {
            let Some(j) = *pair else { continue };
            uncertain[i] = likeness[(i, j)] < self.options.sure;
            if likeness[(i, j)] < self.options.same {
                *pair = None;
            }
        }
        Link { to, uncertain }
    }

    fn snapshot(&self, speed: f64) -> Result<Snapshot, Error> {
        self.solves.set(self.solves.get() + 1);
        let swinging = (self.solve)(speed)?
            .into_iter()
            .filter(|mode| !mode.rigid && mode.oscillates());
        let mut modes: Vec<Followed> = swinging
            .map(|mode| Followed {
                state: state(self.linear, &mode),
                mode,
            })
            .collect();
        modes.sort_by(|a, b| a.mode.omega().total_cmp(&b.mode.omega()));
        Ok(Snapshot { speed, modes })
    }
}

/// `(√k wᵀφ, λ √m vᵀφ)` of length one. What is no square (negative or one-sided stiffness) has no part in it.
fn state(linear: &Linear, mode: &Mode) -> Vec<Complex> {
    let p = linear.stay(&mode.shape);
    let springs = linear
        .branches
        .iter()
        .filter(|b| b.stiffness > 0.0 && b.force.is_none());
    let strained = springs.map(|b| b.direction.dot_complex(&p) * b.stiffness.sqrt());
    let moving = linear
        .masses
        .iter()
        .map(|m| mode.eigenvalue * m.direction.dot_complex(&p) * m.value.sqrt());
    let mut state: Vec<Complex> = strained.chain(moving).collect();
    let length = product(&state, &state).re.sqrt();
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
fn mac(from: &Snapshot, to: &Snapshot) -> Matrix {
    Matrix::from_fn(from.modes.len(), to.modes.len(), |i, j| {
        collinearity::mac(&from.modes[i].state, &to.modes[j].state)
    })
}

/// Runs of modes whose eigenvalues are equal.
fn groups(snapshot: &Snapshot) -> Vec<std::ops::Range<usize>> {
    let mut groups: Vec<std::ops::Range<usize>> = Vec::new();
    for (i, followed) in snapshot.modes.iter().enumerate() {
        let lambda = followed.mode.eigenvalue;
        match groups.last_mut() {
            Some(group)
                if modulus(lambda - snapshot.modes[i - 1].mode.eigenvalue)
                    <= EQUAL * modulus(lambda) =>
            {
                group.end = i + 1;
            }
            _ => groups.push(i..i + 1),
        }
    }
    groups
}

/// Shapes of repeated modes are any combination of each other: takes those most like the modes of `like`.
fn turn_repeated(snapshot: &mut Snapshot, like: &Snapshot) {
    for group in groups(snapshot).into_iter().filter(|group| group.len() > 1) {
        let mut basis: Vec<Followed> = Vec::new();
        for followed in &snapshot.modes[group.clone()] {
            let mut next = followed.clone();
            if orthonormalise(&mut next, &basis) {
                basis.push(next);
            }
        }
        if basis.len() < group.len() {
            continue; // defective: there are no others to choose from
        }
        let parts = |target: &Followed| -> Vec<Complex> {
            basis
                .iter()
                .map(|b| product(&b.state, &target.state))
                .collect()
        };
        let mut targets: Vec<Vec<Complex>> = like.modes.iter().map(parts).collect();
        let size = |parts: &Vec<Complex>| parts.iter().map(|c| c.norm_sqr()).sum::<f64>();
        targets.sort_by(|a, b| size(b).total_cmp(&size(a)));
        let mut turned: Vec<Followed> = Vec::new();
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
        turned.sort_by(|a, b| a.mode.omega().total_cmp(&b.mode.omega()));
        for (place, followed) in group.zip(turned) {
            snapshot.modes[place] = followed;
        }
    }
}

/// `Σ part · mode`; its eigenvalue, equal but for rounding, is the mean.
fn combination(basis: &[Followed], parts: &[Complex]) -> Followed {
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
fn orthonormalise(followed: &mut Followed, others: &[Followed]) -> bool {
    let whole = product(&followed.state, &followed.state).re.sqrt();
    for _ in 0..2 {
        for other in others {
            let part = -product(&other.state, &followed.state);
            add(&mut followed.state, part, &other.state);
            add(&mut followed.mode.shape, part, &other.mode.shape);
        }
    }
    let length = product(&followed.state, &followed.state).re.sqrt();
    let is_new = length > 1e-3 * whole && length > 1e-6; // of unit states: less is no direction of its own
    if is_new {
        scale(&mut followed.state, 1.0 / length);
        scale(&mut followed.mode.shape, 1.0 / length);
    }
    is_new
}
