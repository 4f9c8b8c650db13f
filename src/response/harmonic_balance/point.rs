//! Periodic solution at one point of the curve: state, Floquet multipliers, output statistics.

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

/// Method by which a periodic solution was determined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refinement {
    /// Harmonic balance alone.
    HarmonicBalance,
    /// Harmonic balance, then shooting with located switching events.
    Shooting,
}

/// Statistics of an output over a period, in the unit of the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputStats {
    /// Mean.
    pub mean: f64,
    /// Maximum.
    pub max: f64,
    /// Minimum.
    pub min: f64,
    /// Standard deviation.
    pub std_dev: f64,
}

impl OutputStats {
    /// Half of the peak-to-peak value.
    pub fn amplitude(&self) -> f64 {
        0.5 * (self.max - self.min)
    }

    /// Statistics of equidistant samples over a period; extremes by parabolas through three samples.
    fn from_samples(values: &[f64]) -> OutputStats {
        let n = values.len();
        let mean = values.iter().sum::<f64>() / n as f64;
        let square = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n as f64;
        let extreme = |sign: f64| {
            let at = (0..n).fold(0, |best, j| {
                if sign * values[j] > sign * values[best] {
                    j
                } else {
                    best
                }
            });
            let [a, b, c] = [values[(at + n - 1) % n], values[at], values[(at + 1) % n]];
            let curvature = a - 2.0 * b + c;
            match curvature * sign < 0.0 {
                true => b - (a - c).powi(2) / (8.0 * curvature),
                false => b,
            }
        };
        OutputStats {
            mean,
            max: extreme(1.0),
            min: extreme(-1.0),
            std_dev: square.sqrt(),
        }
    }
}

/// A periodic solution.
#[derive(Debug, Clone)]
pub struct PeriodicSolution {
    /// Base frequency of the excitation, rad/s.
    pub omega: f64,
    /// Highest harmonic of the balance.
    pub orders: usize,
    /// Truncation error: contribution of higher orders, relative to the size of the deflections.
    pub truncation_error: f64,
    /// Method by which the solution was determined.
    pub refinement: Refinement,
    /// State `[x, ẋ, z]` at the start of a period, relative to the free rotation of the machine.
    pub start: Vec<f64>,
    /// Floquet multipliers by falling modulus, without those of free motions.
    pub multipliers: Vec<Complex>,
    /// Statistics of every output.
    pub outputs: Vec<OutputStats>,
    /// Frequency component of the curve tangent: positive if the frequency rises along the curve.
    pub frequency_tangent: f64,
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

/// Number of samples per period for the output statistics.
const SAMPLES: usize = 512;

/// Orbit tolerance relative to the size of the motion: an orbit farther away is another solution.
const ORBIT_TOLERANCE: f64 = 0.02;

/// Requested evaluations at every point.
#[derive(Clone, Copy)]
pub struct PointOptions<'a> {
    /// Outputs of the full machine, before its reduction to relative coordinates.
    pub outputs: &'a MotionOutputs,
    /// Refine by shooting with events if the machine allows it.
    pub events: bool,
}

/// Periodic solution of the harmonic balance, refined by shooting if requested and possible.
///
/// # Errors
/// Errors of the linear part and of the multipliers.
pub fn periodic_solution(
    balance: &mut HarmonicBalance,
    x: &HarmonicUnknowns,
    tangent: &[f64],
    options: &PointOptions,
) -> Result<PeriodicSolution, Error> {
    let omega = balance.omega(x);
    let family = balance.family;
    let truncation_error = balance.truncation_error(x)?;
    let motion = balance.motion(x)?;
    let start = state(balance, &motion, omega, 0.0);
    let orbit = match options.events {
        true => refine(family, omega, &start),
        false => None,
    };
    let (refinement, start, multipliers) = match orbit {
        Some(orbit) => (Refinement::Shooting, orbit.start, orbit.multipliers),
        None => (
            Refinement::HarmonicBalance,
            start,
            floquet_multipliers(balance, x)?,
        ),
    };
    let outputs = match refinement {
        Refinement::Shooting => sample_with_events(family, omega, 1, &start, options.outputs)?,
        Refinement::HarmonicBalance => sample_outputs(balance, &motion, omega, options.outputs),
    };
    let sense = tangent[tangent.len() - 1];
    Ok(PeriodicSolution {
        omega,
        orders: balance.orders,
        truncation_error,
        refinement,
        start,
        multipliers,
        outputs,
        frequency_tangent: sense,
    })
}

/// Orbit by shooting with located switching events; `None` if it fails or ends at another orbit.
pub fn refine(family: &SpeedFamily, omega: f64, start: &[f64]) -> Option<PeriodicOrbit> {
    let orbit = find_orbit(&family.relative_at(omega), start, 1).ok()?;
    let n = family.relative.model.coordinate_count();
    let size =
        |part: std::ops::Range<usize>| start[part].iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let change = |part: std::ops::Range<usize>| {
        part.map(|i| (orbit.start[i] - start[i]).abs())
            .fold(0.0, f64::max)
    };
    let is_same = change(0..n) <= ORBIT_TOLERANCE * size(0..n)
        && change(n..2 * n) <= ORBIT_TOLERANCE * (size(n..2 * n) + omega * size(0..n));
    is_same.then_some(orbit)
}

fn floquet_multipliers(
    balance: &mut HarmonicBalance,
    x: &HarmonicUnknowns,
) -> Result<Vec<Complex>, Error> {
    let (omega, delta) = (balance.omega(x), balance.deflections(x));
    let (family, active) = (balance.family, &balance.lines.active);
    let alternating = balance.alternating();
    let periods: Vec<_> = (0..active.len())
        .map(|element| alternating.period(family, active, element, &delta[element], omega))
        .collect();
    multipliers(family, active, &periods, omega)
}

/// State `[x, ẋ, z]` at a share of the period.
fn state(balance: &HarmonicBalance, motion: &[Vec<Complex>], omega: f64, share: f64) -> Vec<f64> {
    let n = balance.lines.coordinate_count();
    let inner = balance.family.relative.model.internal_count();
    let mut y = vec![0.0; 2 * n + inner];
    for (k, line) in motion.iter().enumerate() {
        let angle = TAU * k as f64 * share;
        let phasor = Complex::new(angle.cos(), angle.sin()) * if k == 0 { 1.0 } else { 2.0 };
        let rate = Complex::new(0.0, k as f64 * omega);
        for (i, x) in line.iter().enumerate() {
            let x = x * phasor;
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
                y[2 * n + i] += (z * phasor).re;
            }
        }
    }
    y
}

/// State of the full machine.
fn full_state(family: &SpeedFamily, y: &[f64]) -> Vec<f64> {
    let n = family.relative.model.coordinate_count();
    let mut full = family.relative.full_coordinates(&y[..n]);
    full.extend(family.relative.full_coordinates(&y[n..2 * n]));
    full.extend(&y[2 * n..]);
    full
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
    statistics(&rows, outputs.list.len())
}

/// Output statistics over `periods` periods, integrated with located events.
pub(super) fn sample_with_events(
    family: &SpeedFamily,
    omega: f64,
    periods: usize,
    start: &[f64],
    outputs: &MotionOutputs,
) -> Result<Vec<OutputStats>, Error> {
    let (model, full_model) = (family.relative_at(omega), family.model_at(omega));
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
            rows.push(outputs.evaluate(&full_model, None, t, &full_state(family, y)));
        }
        ControlFlow::Continue(())
    };
    (periodic::METHOD.run)(&model, &options, &mut sink)?;
    Ok(statistics(&rows, outputs.list.len()))
}

fn statistics(rows: &[Vec<f64>], outputs: usize) -> Vec<OutputStats> {
    (0..outputs)
        .map(|at| OutputStats::from_samples(&rows.iter().map(|row| row[at]).collect::<Vec<f64>>()))
        .collect()
}
