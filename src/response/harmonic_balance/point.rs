//! One periodic solution: state, Floquet multipliers, output statistics.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use super::balance::{HarmonicBalance, HarmonicUnknowns};
use super::family::SpeedFamily;
use super::multipliers::multipliers;
use crate::base::error::Error;
use crate::base::time_budget::CancelToken;
use crate::motion::floquet::MULTIPLIER_TOLERANCE;
use crate::motion::floquet::orbit::{PeriodicOrbit, find_orbit};
use crate::motion::methods::periodic;
use crate::motion::outputs::MotionOutputs;
use crate::motion::problem::{IntegrationOptions, Observer, StepSize};
use crate::motion::regime::Regime;
use crate::numeric::Complex;

/// Refinement by which a motion was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refinement {
    /// By its orders alone.
    HarmonicBalance,
    /// By its orders, then by shooting with every switch located.
    Shooting,
}

/// Statistics of an output over a period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputStats {
    /// The mean.
    pub mean: f64,
    /// The largest value.
    pub max: f64,
    /// The least.
    pub min: f64,
    /// The root of the mean square about the mean.
    pub std_dev: f64,
}

impl OutputStats {
    /// Half of peak to peak.
    pub fn amplitude(&self) -> f64 {
        0.5 * (self.max - self.min)
    }

    /// Statistics of equally spaced values over a period; extremes by parabolas through three.
    fn from_samples(values: &[f64]) -> OutputStats {
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
        OutputStats {
            mean,
            max: highest(1.0),
            min: highest(-1.0),
            std_dev: square.sqrt(),
        }
    }
}

/// A periodic motion.
#[derive(Debug, Clone)]
pub struct PeriodicSolution {
    /// Base frequency of the excitation, rad/s.
    pub omega: f64,
    /// Orders of the balance.
    pub orders: usize,
    /// Truncation error: contribution of higher orders, relative to the size of the deflections.
    pub truncation_error: f64,
    /// Refinement by which the solution was found.
    pub refinement: Refinement,
    /// State at the start of a period, of the machine against its free turning.
    pub start: Vec<f64>,
    /// Floquet multipliers by falling size, those of free motions left out.
    pub multipliers: Vec<Complex>,
    /// Statistics of every output.
    pub outputs: Vec<OutputStats>,
    /// The sense in which the frequency changes along the curve here: positive where it rises.
    pub sense: f64,
}

impl PeriodicSolution {
    /// Number of independent growing disturbances (multipliers outside the unit circle).
    pub fn unstable_count(&self) -> usize {
        self.multipliers
            .iter()
            .filter(|m| m.norm() > 1.0 + MULTIPLIER_TOLERANCE)
            .count()
    }
}

/// Samples of a period for the extents of outputs.
const SAMPLES: usize = 512;

/// Orbit tolerance relative to the size of the motion: shooting that ends further away has found another orbit.
const ORBIT_TOLERANCE: f64 = 0.02;

/// Evaluations requested at every point.
#[derive(Clone, Copy)]
pub struct PointOptions<'a> {
    /// Outputs over the machine as it was given.
    pub outputs: &'a MotionOutputs,
    /// Refine by events where the machine allows.
    pub events: bool,
}

/// A solution of the balance, refined where that is possible.
///
/// # Errors
/// Those of the linear part, of the multipliers.
pub fn periodic_solution(
    balance: &mut HarmonicBalance,
    x: &HarmonicUnknowns,
    tangent: &[f64],
    options: &PointOptions,
) -> Result<PeriodicSolution, Error> {
    let omega = balance.omega(x);
    let family = balance.family;
    let left_out = balance.truncation_error(x)?;
    let motion = balance.motion(x)?;
    let start = state(balance, &motion, omega, 0.0);
    let exact = match options.events {
        true => refine(family, omega, &start),
        false => None,
    };
    let (result, start, multipliers) = match exact {
        Some(orbit) => (Refinement::Shooting, orbit.start, orbit.multipliers),
        None => (
            Refinement::HarmonicBalance,
            start,
            floquet_multipliers(balance, x)?,
        ),
    };
    let outputs = match result {
        Refinement::Shooting => sample_with_events(family, omega, 1, &start, options.outputs)?,
        Refinement::HarmonicBalance => sample_outputs(balance, &motion, omega, options.outputs),
    };
    let sense = tangent[tangent.len() - 1];
    Ok(PeriodicSolution {
        omega,
        orders: balance.orders,
        truncation_error: left_out,
        refinement: result,
        start,
        multipliers,
        outputs,
        sense,
    })
}

/// The orbit with every switch located, if it is this one.
pub fn refine(family: &SpeedFamily, omega: f64, start: &[f64]) -> Option<PeriodicOrbit> {
    let found = find_orbit(&family.relative_at(omega), start, 1).ok()?;
    let n = family.relative.model.coordinate_count();
    let size =
        |part: std::ops::Range<usize>| start[part].iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let moved = |part: std::ops::Range<usize>| {
        part.map(|i| (found.start[i] - start[i]).abs())
            .fold(0.0, f64::max)
    };
    let near = moved(0..n) <= ORBIT_TOLERANCE * size(0..n)
        && moved(n..2 * n) <= ORBIT_TOLERANCE * (size(n..2 * n) + omega * size(0..n));
    near.then_some(found)
}

fn floquet_multipliers(
    balance: &mut HarmonicBalance,
    x: &HarmonicUnknowns,
) -> Result<Vec<Complex>, Error> {
    let (omega, delta) = (balance.omega(x), balance.deflections(x));
    let (family, active) = (balance.family, &balance.lines.active);
    let alternating = balance.alternating();
    let periods: Vec<_> = (0..active.len())
        .map(|own| alternating.period(family, active, own, &delta[own], omega))
        .collect();
    multipliers(family, active, &periods, omega)
}

/// `[x, ẋ, z]` at a share of the period.
fn state(balance: &HarmonicBalance, motion: &[Vec<Complex>], omega: f64, share: f64) -> Vec<f64> {
    let n = balance.lines.coordinate_count();
    let inner = balance.family.relative.model.internal_count();
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
            for (i, z) in balance
                .lines
                .internal_states(k, omega, line)
                .iter()
                .enumerate()
            {
                y[2 * n + i] += (z * turn).re;
            }
        }
    }
    y
}

/// The state of the machine as it was given.
fn full_state(family: &SpeedFamily, y: &[f64]) -> Vec<f64> {
    let n = family.relative.model.coordinate_count();
    let mut all = family.relative.full_coordinates(&y[..n]);
    all.extend(family.relative.full_coordinates(&y[n..2 * n]));
    all.extend(&y[2 * n..]);
    all
}

fn sample_outputs(
    balance: &HarmonicBalance,
    motion: &[Vec<Complex>],
    omega: f64,
    outputs: &MotionOutputs,
) -> Vec<OutputStats> {
    let family = balance.family;
    let model = family.model_at(omega);
    let rows: Vec<Vec<f64>> = (0..SAMPLES)
        .map(|j| {
            let share = j as f64 / SAMPLES as f64;
            let y = full_state(family, &state(balance, motion, omega, share));
            outputs.evaluate(&model, None, share * TAU / omega, &y)
        })
        .collect();
    extents(&rows, outputs.list.len())
}

/// Extents of outputs over so many periods, by events.
pub(super) fn sample_with_events(
    family: &SpeedFamily,
    omega: f64,
    periods: usize,
    start: &[f64],
    outputs: &MotionOutputs,
) -> Result<Vec<OutputStats>, Error> {
    let (model, given) = (family.relative_at(omega), family.model_at(omega));
    let samples = periods * SAMPLES;
    let options = IntegrationOptions {
        from: 0.0,
        to: periods as f64 * TAU / omega,
        initial_state: start.to_vec(),
        samples,
        step_size: StepSize::Adaptive(1e-12),
        max_work: u64::MAX,
        cancel: CancelToken::default(),
        observer: Observer::default(),
    };
    let mut rows = Vec::with_capacity(samples);
    let mut sink = |t: f64, y: &[f64], _: Option<&Regime>| {
        if rows.len() < samples {
            rows.push(outputs.evaluate(&given, None, t, &full_state(family, y)));
        }
        ControlFlow::Continue(())
    };
    (periodic::METHOD.run)(&model, &options, &mut sink)?;
    Ok(extents(&rows, outputs.list.len()))
}

fn extents(rows: &[Vec<f64>], outputs: usize) -> Vec<OutputStats> {
    (0..outputs)
        .map(|at| OutputStats::from_samples(&rows.iter().map(|row| row[at]).collect::<Vec<f64>>()))
        .collect()
}
