//! Periodic orbits `P(y) = y` by shooting, with saltation matrices at switches.
//!
//! P′ is the product of the fundamental solutions of the segments and, where the force jumps at a switch, of the saltation matrices
//! `I + (f⁺ − f⁻) ∇h/ḣ` (Aizerman and Gantmakher 1958; Leine and Nijmeijer 2004, eq. 7.69).

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::dynamic_model::{DynamicModel, ElementState};
use crate::motion::methods::periodic::run::{PeriodicRun, RunSegment};
use crate::numeric::sorting::sort_descending;
use crate::numeric::{Complex, Matrix, eigen, small_dense};

/// Periodic orbit with its Floquet multipliers.
#[derive(Debug, Clone)]
pub struct PeriodicOrbit {
    /// State of the orbit at t = 0.
    pub start: Vec<f64>,
    /// Number of machine periods in the orbit.
    pub periods: u64,
    /// Duration of the orbit, s.
    pub duration: f64,
    /// Floquet multipliers: eigenvalues of P′, by decreasing modulus.
    pub multipliers: Vec<Complex>,
    /// Number of switches in the orbit.
    pub events: u64,
    /// Maximum norm of `P(y) − y`, in the scale units of the states.
    pub residual: f64,
}

/// Poincaré map P and its Jacobian P′ at a state.
#[derive(Debug, Clone)]
pub struct ReturnMap {
    /// Image P of the state, in its scale units.
    pub end: Vec<f64>,
    /// Jacobian P′ by rows, in the scale units.
    pub jacobian: Vec<f64>,
    /// Scale unit of each state.
    pub units: Vec<f64>,
    /// Duration of the map, s.
    pub duration: f64,
    /// Number of switches in the map.
    pub events: u64,
}

/// Convergence tolerance of Newton's method: norm of the step relative to the norm of the state.
const NEWTON_TOLERANCE: f64 = 1e-13;

const MAX_ITERATIONS: usize = 40;

/// Maximum ratio of the residuals after and before a Newton step; beyond it the step is halved.
const MAX_RESIDUAL_GROWTH: f64 = 2.0;

/// Finds a periodic orbit of a number of periods by Newton shooting from an initial estimate.
///
/// # Errors
/// Models outside the periodic method; `NoConvergence` without an isolated orbit near the estimate, as for machines that rotate freely.
pub fn find_orbit(
    model: &DynamicModel,
    estimate: &[f64],
    periods: u64,
) -> Result<PeriodicOrbit, Error> {
    let mut start = estimate.to_vec();
    let mut previous = f64::INFINITY;
    let mut step = vec![0.0; estimate.len()];
    for _ in 0..MAX_ITERATIONS {
        let map = return_map(model, &start, periods)?;
        let difference = map.residual(&start);
        let residual = max_norm(&difference);
        let scale = max_norm(&map.end).max(f64::MIN_POSITIVE);
        if residual > MAX_RESIDUAL_GROWTH * previous {
            // The Newton step overshoots a switch: halve it.
            step.iter_mut().for_each(|s| *s *= 0.5);
            start.iter_mut().zip(&step).for_each(|(y, s)| *y -= s);
            continue;
        }
        previous = residual;
        let mut correction = difference;
        small_dense::solve(&mut map.minus_identity(), &mut correction);
        if !correction.iter().all(|x| x.is_finite()) {
            break;
        }
        if max_norm(&correction) <= NEWTON_TOLERANCE * scale {
            return map.into_periodic_orbit(start, periods, residual);
        }
        for (i, s) in step.iter_mut().enumerate() {
            *s = -correction[i] * map.units[i];
            start[i] += *s;
        }
    }
    let message = format!(
        "no orbit of {periods} periods was found near the given state; relative closure error {previous:.1e} at the end"
    );
    Err(Error::new(Code::NoConvergence, message)
        .with_hint("start from a settled motion, or fix a machine that turns freely"))
}

/// Integrates the Poincaré map P and its Jacobian P′.
///
/// # Errors
/// Models outside the periodic method.
pub fn return_map(model: &DynamicModel, start: &[f64], periods: u64) -> Result<ReturnMap, Error> {
    let mut run = PeriodicRun::new(model, 0.0, start)?;
    let n = start.len();
    let mut jacobian: Vec<f64> = (0..n * n).map(|at| f64::from(at / n == at % n)).collect();
    let duration = run.cache.grid.elapsed(periods);
    let mut end = run.cache.grid.instant(0.0);
    end.periods = periods;
    loop {
        let segment = run.next_segment(end);
        run.propagate(&mut jacobian, segment.to);
        if segment.limit.is_none() && segment.to >= run.position_of(end) {
            let mut y = vec![0.0; n];
            run.value(segment.to, &mut y);
            let units = run.cache.scale.units.clone();
            return Ok(ReturnMap {
                end: y.iter().zip(&units).map(|(y, unit)| y / unit).collect(),
                jacobian,
                units,
                duration,
                events: run.stats.events,
            });
        }
        if segment.limit.is_some() && segment.rate != 0.0 {
            apply_saltation(&mut run, segment, &mut jacobian);
        }
        run.advance(segment)?;
    }
}

/// Multiplies the Jacobian by the saltation matrix of the switch that ends a segment.
fn apply_saltation(run: &mut PeriodicRun, segment: RunSegment, jacobian: &mut [f64]) {
    let Some(limit) = segment.limit else { return };
    let model = run.cache.model;
    let (n, n_states) = (
        model.coordinate_count(),
        model.coordinate_count() * 2 + model.internal_count(),
    );
    let mut y = vec![0.0; n_states];
    run.value(segment.to, &mut y);
    let t = run.cache.from + run.elapsed(segment.to);
    let mut regime = run.full_regime();
    let (mut before, mut after) = (vec![0.0; n_states], vec![0.0; n_states]);
    model.derivative_in(Some(&regime), t, &y, &mut before);
    let ElementState::Contact(_, piece) = regime.states[limit.branch] else {
        return;
    };
    regime.states[limit.branch] = ElementState::Contact(limit.next, piece);
    model.derivative_in(Some(&regime), t, &y, &mut after);
    let units = &run.cache.scale.units;
    let branch = &model.elements[limit.branch];
    let factor = branch.factor(t, &y[..n], piece).0;
    let [constant, varying] = limit.value;
    let deflection = constant.deflection + factor * varying.deflection;
    let rate = constant.rate + factor * varying.rate;
    let mut gradient = vec![0.0; n_states];
    for (i, w) in branch.direction.entries() {
        gradient[i] = deflection * w * units[i];
        gradient[n + i] = rate * w * units[n + i];
    }
    let mut dh = vec![0.0; n_states];
    for (row, &h) in jacobian.chunks_exact(n_states).zip(&gradient) {
        dh.iter_mut().zip(row).for_each(|(s, x)| *s += h * x);
    }
    for (i, row) in jacobian.chunks_exact_mut(n_states).enumerate() {
        let jump = (after[i] - before[i]) / units[i] / segment.rate;
        row.iter_mut().zip(&dh).for_each(|(x, s)| *x += jump * s);
    }
}

impl ReturnMap {
    /// Residual `P(y) − y` in the scale units.
    pub fn residual(&self, start: &[f64]) -> Vec<f64> {
        let start = start.iter().zip(&self.units).map(|(y, unit)| y / unit);
        self.end
            .iter()
            .zip(start)
            .map(|(end, start)| end - start)
            .collect()
    }

    /// Matrix `P′ − I` of Newton's method, by rows.
    pub fn minus_identity(&self) -> Vec<f64> {
        let n = self.end.len();
        let entry = |(at, x): (usize, &f64)| x - f64::from(at / n == at % n);
        self.jacobian.iter().enumerate().map(entry).collect()
    }

    /// The periodic orbit at a converged start, with the Floquet multipliers of P′. The caller checks convergence.
    ///
    /// # Errors
    /// `NoConvergence` of the eigenvalues.
    pub fn into_periodic_orbit(
        self,
        start: Vec<f64>,
        periods: u64,
        residual: f64,
    ) -> Result<PeriodicOrbit, Error> {
        let n = self.end.len();
        let jacobian = Matrix::from_fn(n, n, |i, j| self.jacobian[i * n + j]);
        let mut multipliers = eigen::eigenvalues(&jacobian)?;
        sort_descending(&mut multipliers, |a| a.norm());
        Ok(PeriodicOrbit {
            start,
            periods,
            duration: self.duration,
            multipliers,
            events: self.events,
            residual,
        })
    }
}

/// Largest absolute component.
pub fn max_norm(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |largest, x| largest.max(x.abs()))
}
