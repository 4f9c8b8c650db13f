//! One periodic motion with all that is known of it: its state, its multipliers, what the outputs do.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use super::balance::{Balance, Unknowns};
use super::family::Family;
use super::multipliers::multipliers;
use crate::base::error::Error;
use crate::base::stop::Stop;
use crate::motion::floquet::NEUTRAL;
use crate::motion::floquet::orbit::{Orbit, orbit};
use crate::motion::methods::periodic;
use crate::motion::outputs::Outputs;
use crate::motion::problem::{Ask, Follower, Wanted};
use crate::motion::regime::Regime;
use crate::numeric::Complex;

/// How a motion was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Found {
    /// By its orders alone.
    Orders,
    /// By its orders, then by shooting with every switch located.
    Events,
}

/// What an output does over a period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// The mean.
    pub mean: f64,
    /// The largest value.
    pub max: f64,
    /// The least.
    pub min: f64,
    /// The root of the mean square about the mean.
    pub rms: f64,
}

impl Extent {
    /// Half of peak to peak.
    pub fn amplitude(&self) -> f64 {
        0.5 * (self.max - self.min)
    }

    /// Of equally spaced values over a period; extremes by parabolas through three.
    fn of(values: &[f64]) -> Extent {
        let n = values.len();
        let mean = values.iter().sum::<f64>() / n as f64;
        let square = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n as f64;
        let highest = |sign: f64| {
            let at = (0..n).fold(0, |best, j| {
                if sign * values[j] > sign * values[best] {
                    j
                } else {
                    best
                }
            });
            let [a, b, c] = [values[(at + n - 1) % n], values[at], values[(at + 1) % n]];
            let bend = a - 2.0 * b + c;
            match bend * sign < 0.0 {
                true => b - (a - c).powi(2) / (8.0 * bend),
                false => b,
            }
        };
        Extent {
            mean,
            max: highest(1.0),
            min: highest(-1.0),
            rms: square.sqrt(),
        }
    }
}

/// A periodic motion.
#[derive(Debug, Clone)]
pub struct Point {
    /// What everything repeats with, rad/s.
    pub omega: f64,
    /// Orders of the balance.
    pub orders: usize,
    /// What higher orders would add, of the size of the deflections.
    pub left_out: f64,
    /// How it was found.
    pub found: Found,
    /// State at the start of a period, of the machine against its free turning.
    pub start: Vec<f64>,
    /// Floquet multipliers by falling size, those of free motions left out.
    pub multipliers: Vec<Complex>,
    /// Of every output.
    pub outputs: Vec<Extent>,
    /// The sense in which the frequency changes along the curve here: positive where it rises.
    pub sense: f64,
}

impl Point {
    /// How many ways a disturbance of it grows.
    pub fn unstable(&self) -> usize {
        self.multipliers
            .iter()
            .filter(|m| m.norm() > 1.0 + NEUTRAL)
            .count()
    }
}

/// Samples of a period for the extents of outputs.
const SAMPLES: usize = 512;

/// Of the size of the motion: shooting that ends further away has found another one.
const ANOTHER: f64 = 0.02;

/// What is asked of every point.
#[derive(Clone, Copy)]
pub struct Asked<'a> {
    /// Outputs over the machine as it was given.
    pub outputs: &'a Outputs,
    /// Refine by events where the machine allows.
    pub events: bool,
}

/// A solution of the balance, refined where that is possible.
///
/// # Errors
/// Those of the linear part, of the multipliers.
pub fn point(
    balance: &mut Balance,
    x: &Unknowns,
    tangent: &[f64],
    asked: &Asked,
) -> Result<Point, Error> {
    let omega = balance.omega(x);
    let family = balance.family;
    let left_out = balance.left_out(x)?;
    let motion = balance.motion(x)?;
    let start = state(balance, &motion, omega, 0.0);
    let exact = match asked.events {
        true => refined(family, omega, &start),
        false => None,
    };
    let (found, start, multipliers) = match exact {
        Some(orbit) => (Found::Events, orbit.start, orbit.multipliers),
        None => (Found::Orders, start, judged(balance, x)?),
    };
    let outputs = match found {
        Found::Events => sampled_exactly(family, omega, 1, &start, asked.outputs)?,
        Found::Orders => sampled(balance, &motion, omega, asked.outputs),
    };
    let sense = tangent[tangent.len() - 1];
    Ok(Point {
        omega,
        orders: balance.orders,
        left_out,
        found,
        start,
        multipliers,
        outputs,
        sense,
    })
}

/// The orbit with every switch located, if it is this one.
pub fn refined(family: &Family, omega: f64, start: &[f64]) -> Option<Orbit> {
    let found = orbit(&family.at(omega), start, 1).ok()?;
    let n = family.relative.train.n();
    let size =
        |part: std::ops::Range<usize>| start[part].iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let moved = |part: std::ops::Range<usize>| {
        part.map(|i| (found.start[i] - start[i]).abs())
            .fold(0.0, f64::max)
    };
    let near = moved(0..n) <= ANOTHER * size(0..n)
        && moved(n..2 * n) <= ANOTHER * (size(n..2 * n) + omega * size(0..n));
    near.then_some(found)
}

fn judged(balance: &mut Balance, x: &Unknowns) -> Result<Vec<Complex>, Error> {
    let (omega, delta) = (balance.omega(x), balance.deflections(x));
    let (family, active) = (balance.family, &balance.lines.active);
    let alternating = balance.alternating();
    let periods: Vec<_> = (0..active.len())
        .map(|own| alternating.period(family, active, own, &delta[own], omega))
        .collect();
    multipliers(family, active, &periods, omega)
}

/// `[x, ẋ, z]` at a share of the period.
fn state(balance: &Balance, motion: &[Vec<Complex>], omega: f64, share: f64) -> Vec<f64> {
    let n = balance.lines.n();
    let inner = balance.family.relative.train.inner();
    let mut y = vec![0.0; 2 * n + inner];
    for (k, line) in motion.iter().enumerate() {
        let angle = TAU * k as f64 * share;
        let turn = Complex::new(angle.cos(), angle.sin()) * if k == 0 { 1.0 } else { 2.0 };
        let rate = Complex::new(0.0, k as f64 * omega);
        for (i, x) in line.iter().enumerate() {
            let x = x * turn;
            y[i] += x.re;
            y[n + i] += (x * rate).re;
        }
        if inner > 0 {
            for (i, z) in balance.lines.inner(k, omega, line).iter().enumerate() {
                y[2 * n + i] += (z * turn).re;
            }
        }
    }
    y
}

/// The state of the machine as it was given.
fn whole(family: &Family, y: &[f64]) -> Vec<f64> {
    let n = family.relative.train.n();
    let mut all = family.relative.whole(&y[..n]);
    all.extend(family.relative.whole(&y[n..2 * n]));
    all.extend(&y[2 * n..]);
    all
}

fn sampled(
    balance: &Balance,
    motion: &[Vec<Complex>],
    omega: f64,
    outputs: &Outputs,
) -> Vec<Extent> {
    let family = balance.family;
    let train = family.whole_at(omega);
    let rows: Vec<Vec<f64>> = (0..SAMPLES)
        .map(|j| {
            let share = j as f64 / SAMPLES as f64;
            let y = whole(family, &state(balance, motion, omega, share));
            outputs.at(&train, None, share * TAU / omega, &y)
        })
        .collect();
    extents(&rows, outputs.list.len())
}

/// Extents of outputs over so many periods, by events.
pub(super) fn sampled_exactly(
    family: &Family,
    omega: f64,
    periods: usize,
    start: &[f64],
    outputs: &Outputs,
) -> Result<Vec<Extent>, Error> {
    let (train, given) = (family.at(omega), family.whole_at(omega));
    let samples = periods * SAMPLES;
    let ask = Ask {
        from: 0.0,
        to: periods as f64 * TAU / omega,
        start: start.to_vec(),
        samples,
        effort: Wanted::Tolerance(1e-12),
        budget: u64::MAX,
        stop: Stop::default(),
        follower: Follower::default(),
    };
    let mut rows = Vec::with_capacity(samples);
    let mut sink = |t: f64, y: &[f64], _: Option<&Regime>| {
        if rows.len() < samples {
            rows.push(outputs.at(&given, None, t, &whole(family, y)));
        }
        ControlFlow::Continue(())
    };
    (periodic::METHOD.run)(&train, &ask, &mut sink)?;
    Ok(extents(&rows, outputs.list.len()))
}

fn extents(rows: &[Vec<f64>], outputs: usize) -> Vec<Extent> {
    (0..outputs)
        .map(|at| Extent::of(&rows.iter().map(|row| row[at]).collect::<Vec<f64>>()))
        .collect()
}
