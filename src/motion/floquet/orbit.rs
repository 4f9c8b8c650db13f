//! Periodic orbits of machines with play: `P(y) = y`, P the state a number of periods later, by Newton's method.
//!
//! P′ is the product of the fundamental solutions of the legs and, where the force jumps at a switch, of the saltation matrices
//! `I + (f⁺ − f⁻) ∇h/ḣ` (Aizerman and Gantmakher 1958; Leine and Nijmeijer 2004, eq. 7.69).

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::methods::periodic::walk::{Leg, Walk};
use crate::motion::train::{BranchStand, Train};
use crate::numeric::{Complex, Matrix, general, in_place};

/// An orbit.
#[derive(Debug, Clone)]
pub struct Orbit {
    /// Its state at t = 0.
    pub start: Vec<f64>,
    /// How many periods of the machine it takes.
    pub periods: u64,
    /// How long, s.
    pub duration: f64,
    /// Eigenvalues of P′, by falling size.
    pub multipliers: Vec<Complex>,
    /// Switches on the way.
    pub events: u64,
    /// `|P(y) − y|` in units of the states' size, the largest.
    pub residual: f64,
}

/// P and P′ at a state.
#[derive(Debug, Clone)]
pub struct Return {
    /// P, in units of the states' size.
    pub end: Vec<f64>,
    /// P′, row by row, in those units.
    pub slope: Vec<f64>,
    /// Those units.
    pub units: Vec<f64>,
    /// How long it takes, s.
    pub duration: f64,
    /// Switches on the way.
    pub events: u64,
}

/// Newton's method has come far enough where the state moves by less than this share of its size.
const SETTLED: f64 = 1e-13;

const MOST_ITERATIONS: usize = 40;

/// Steps are allowed while a period ends this much beyond the best so far.
const WORSE: f64 = 2.0;

/// The orbit of a number of periods near a state.
///
/// # Errors
/// What the periodic method refuses; `NoConvergence` where there is none near, or a whole family of them, as of machines that turn freely.
pub fn orbit(train: &Train, near: &[f64], periods: u64) -> Result<Orbit, Error> {
    let mut start = near.to_vec();
    let mut before = f64::INFINITY;
    let mut step = vec![0.0; near.len()];
    for _ in 0..MOST_ITERATIONS {
        let there = after(train, &start, periods)?;
        let apart = there.apart(&start);
        let size = largest(&apart);
        let scale = largest(&there.end).max(f64::MIN_POSITIVE);
        if size > WORSE * before {
            // Newton's step has overshot a switch: half of it.
            step.iter_mut().for_each(|s| *s *= 0.5);
            start.iter_mut().zip(&step).for_each(|(y, s)| *y -= s);
            continue;
        }
        before = size;
        let mut moved = apart;
        in_place::solve(&mut there.minus_identity(), &mut moved);
        if !moved.iter().all(|x| x.is_finite()) {
            break;
        }
        if largest(&moved) <= SETTLED * scale {
            return there.settled(start, periods, size);
        }
        for (i, s) in step.iter_mut().enumerate() {
            *s = -moved[i] * there.units[i];
            start[i] += *s;
        }
    }
    let message = format!(
        "no orbit of {periods} periods was found near the given state; the last one missed itself by {before:.1e} of its size"
    );
    Err(Error::new(Code::NoConvergence, message)
        .hint("start from a motion that has settled, or hold a machine that turns freely"))
}

/// P and P′.
///
/// # Errors
/// What the periodic method refuses.
pub fn after(train: &Train, start: &[f64], periods: u64) -> Result<Return, Error> {
    let mut walk = Walk::new(train, 0.0, start)?;
    let n = start.len();
    let mut slope: Vec<f64> = (0..n * n).map(|at| f64::from(at / n == at % n)).collect();
    let duration = walk.tables.grid.elapsed(periods);
    let mut end = walk.tables.grid.instant(0.0);
    end.periods = periods;
    loop {
        let leg = walk.leg(end);
        walk.carry(&mut slope, leg.to);
        if leg.limit.is_none() && leg.to >= walk.place_of(end) {
            let mut y = vec![0.0; n];
            walk.value(leg.to, &mut y);
            let units = walk.tables.scale.units.clone();
            return Ok(Return {
                end: y.iter().zip(&units).map(|(y, unit)| y / unit).collect(),
                slope,
                units,
                duration,
                events: walk.effort.events,
            });
        }
        if leg.limit.is_some() && leg.rate != 0.0 {
            saltate(&mut walk, leg, &mut slope);
        }
        walk.pass(leg)?;
    }
}

/// Multiplies by the saltation matrix of the switch that ends a leg.
fn saltate(walk: &mut Walk, leg: Leg, slope: &mut [f64]) {
    let Some(limit) = leg.limit else { return };
    let train = walk.tables.train;
    let (n, all) = (train.n(), train.n() * 2 + train.inner());
    let mut y = vec![0.0; all];
    walk.value(leg.to, &mut y);
    let t = walk.tables.from + walk.elapsed(leg.to);
    let mut regime = walk.whole_regime();
    let (mut before, mut beyond) = (vec![0.0; all], vec![0.0; all]);
    train.slope_in(Some(&regime), t, &y, &mut before);
    let BranchStand::Contact(_, piece) = regime.stands[limit.branch] else {
        return;
    };
    regime.stands[limit.branch] = BranchStand::Contact(limit.next, piece);
    train.slope_in(Some(&regime), t, &y, &mut beyond);
    let units = &walk.tables.scale.units;
    let branch = &train.branches[limit.branch];
    let factor = branch.factor(t, &y[..n], piece).0;
    let [plain, more] = limit.value;
    let along = plain.deflection + factor * more.deflection;
    let rate = plain.rate + factor * more.rate;
    let mut normal = vec![0.0; all];
    for (i, w) in branch.direction.scaled() {
        normal[i] = along * w * units[i];
        normal[n + i] = rate * w * units[n + i];
    }
    let mut seen = vec![0.0; all];
    for (row, &h) in slope.chunks_exact(all).zip(&normal) {
        seen.iter_mut().zip(row).for_each(|(s, x)| *s += h * x);
    }
    for (i, row) in slope.chunks_exact_mut(all).enumerate() {
        let jump = (beyond[i] - before[i]) / units[i] / leg.rate;
        row.iter_mut().zip(&seen).for_each(|(x, s)| *x += jump * s);
    }
}

impl Return {
    /// P − y, in units.
    pub fn apart(&self, start: &[f64]) -> Vec<f64> {
        let start = start.iter().zip(&self.units).map(|(y, unit)| y / unit);
        self.end
            .iter()
            .zip(start)
            .map(|(end, start)| end - start)
            .collect()
    }

    /// P′ − I.
    pub fn minus_identity(&self) -> Vec<f64> {
        let n = self.end.len();
        let entry = |(at, x): (usize, &f64)| x - f64::from(at / n == at % n);
        self.slope.iter().enumerate().map(entry).collect()
    }

    /// The orbit it is, if it comes back.
    ///
    /// # Errors
    /// `NoConvergence` where the multipliers are not found.
    pub fn settled(self, start: Vec<f64>, periods: u64, residual: f64) -> Result<Orbit, Error> {
        let n = self.end.len();
        let slope = Matrix::from_fn(n, n, |i, j| self.slope[i * n + j]);
        let mut multipliers = general::eigenvalues(&slope)?;
        multipliers.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
        Ok(Orbit {
            start,
            periods,
            duration: self.duration,
            multipliers,
            events: self.events,
            residual,
        })
    }
}

/// The largest size.
pub fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most, x| most.max(x.abs()))
}
