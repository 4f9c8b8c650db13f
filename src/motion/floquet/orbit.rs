//! Periodic orbits `P(y) = y` by shooting, with saltation matrices at switches.
//!
//! P′ is the product of the fundamental solutions of the legs and, where the force jumps at a switch, of the saltation matrices
//! `I + (f⁺ − f⁻) ∇h/ḣ` (Aizerman and Gantmakher 1958; Leine and Nijmeijer 2004, eq. 7.69).

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::dynamic_model::{DynamicModel, ElementState};
use crate::motion::methods::periodic::run::{PeriodicRun, RunSegment};
use crate::numeric::sorting::sort_falling;
use crate::numeric::{Complex, Matrix, eigen, small_dense};

/// A periodic motion with its Floquet multipliers.
#[derive(Debug, Clone)]
pub struct PeriodicOrbit {
    /// State of the orbit at t = 0.
    pub start: Vec<f64>,
    /// Number of machine periods in the orbit.
    pub periods: u64,
    /// Duration of the orbit, s.
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
pub struct ReturnMap {
    /// P, in units of the states' size.
    pub end: Vec<f64>,
    /// P′, row by row, in those units.
    pub jacobian: Vec<f64>,
    /// Those units.
    pub units: Vec<f64>,
    /// Duration of the map, s.
    pub duration: f64,
    /// Switches on the way.
    pub events: u64,
}

/// Newton's method has come far enough where the state moves by less than this share of its size.
const NEWTON_TOLERANCE: f64 = 1e-13;

const MAX_ITERATIONS: usize = 40;

/// Steps are allowed while a period ends this much beyond the best so far.
const MAX_RESIDUAL_GROWTH: f64 = 2.0;

/// Finds a periodic orbit of a number of periods by Newton shooting from an estimate of its start.
///
/// # Errors
/// What the periodic method refuses; `NoConvergence` where there is none near, or a whole family of them, as of machines that turn freely.
pub fn find_orbit(
    model: &DynamicModel,
    near: &[f64],
    periods: u64,
) -> Result<PeriodicOrbit, Error> {
    let mut start = near.to_vec();
    let mut before = f64::INFINITY;
    let mut step = vec![0.0; near.len()];
    for _ in 0..MAX_ITERATIONS {
        let there = return_map(model, &start, periods)?;
        let apart = there.residual(&start);
        let size = max_norm(&apart);
        let scale = max_norm(&there.end).max(f64::MIN_POSITIVE);
        if size > MAX_RESIDUAL_GROWTH * before {
            // Newton's step has overshot a switch: half of it.
            step.iter_mut().for_each(|s| *s *= 0.5);
            start.iter_mut().zip(&step).for_each(|(y, s)| *y -= s);
            continue;
        }
        before = size;
        let mut moved = apart;
        small_dense::solve(&mut there.minus_identity(), &mut moved);
        if !moved.iter().all(|x| x.is_finite()) {
            break;
        }
        if max_norm(&moved) <= NEWTON_TOLERANCE * scale {
            return there.into_periodic_orbit(start, periods, size);
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
        .with_hint("start from a motion that has settled, or hold a machine that turns freely"))
}

/// The Poincaré map P and its Jacobian P′.
///
/// # Errors
/// What the periodic method refuses.
pub fn return_map(model: &DynamicModel, start: &[f64], periods: u64) -> Result<ReturnMap, Error> {
    let mut walk = PeriodicRun::new(model, 0.0, start)?;
    let n = start.len();
    let mut slope: Vec<f64> = (0..n * n).map(|at| f64::from(at / n == at % n)).collect();
    let duration = walk.cache.grid.elapsed(periods);
    let mut end = walk.cache.grid.instant(0.0);
    end.periods = periods;
    loop {
        let segment = walk.next_segment(end);
        walk.propagate(&mut slope, segment.to);
        if segment.limit.is_none() && segment.to >= walk.position_of(end) {
            let mut y = vec![0.0; n];
            walk.value(segment.to, &mut y);
            let units = walk.cache.scale.units.clone();
            return Ok(ReturnMap {
                end: y.iter().zip(&units).map(|(y, unit)| y / unit).collect(),
                jacobian: slope,
                units,
                duration,
                events: walk.stats.events,
            });
        }
        if segment.limit.is_some() && segment.rate != 0.0 {
            apply_saltation(&mut walk, segment, &mut slope);
        }
        walk.advance(segment)?;
    }
}

/// Multiplies by the saltation matrix of the switch that ends a leg.
fn apply_saltation(walk: &mut PeriodicRun, segment: RunSegment, slope: &mut [f64]) {
    let Some(limit) = segment.limit else { return };
    let model = walk.cache.model;
    let (n, all) = (
        model.coordinate_count(),
        model.coordinate_count() * 2 + model.internal_count(),
    );
    let mut y = vec![0.0; all];
    walk.value(segment.to, &mut y);
    let t = walk.cache.from + walk.elapsed(segment.to);
    let mut regime = walk.whole_regime();
    let (mut before, mut beyond) = (vec![0.0; all], vec![0.0; all]);
    model.derivative_in(Some(&regime), t, &y, &mut before);
    let ElementState::Contact(_, piece) = regime.states[limit.branch] else {
        return;
    };
    regime.states[limit.branch] = ElementState::Contact(limit.next, piece);
    model.derivative_in(Some(&regime), t, &y, &mut beyond);
    let units = &walk.cache.scale.units;
    let branch = &model.elements[limit.branch];
    let factor = branch.factor(t, &y[..n], piece).0;
    let [plain, more] = limit.value;
    let along = plain.deflection + factor * more.deflection;
    let rate = plain.rate + factor * more.rate;
    let mut normal = vec![0.0; all];
    for (i, w) in branch.direction.entries() {
        normal[i] = along * w * units[i];
        normal[n + i] = rate * w * units[n + i];
    }
    let mut seen = vec![0.0; all];
    for (row, &h) in slope.chunks_exact(all).zip(&normal) {
        seen.iter_mut().zip(row).for_each(|(s, x)| *s += h * x);
    }
    for (i, row) in slope.chunks_exact_mut(all).enumerate() {
        let jump = (beyond[i] - before[i]) / units[i] / segment.rate;
        row.iter_mut().zip(&seen).for_each(|(x, s)| *x += jump * s);
    }
}

impl ReturnMap {
    /// P − y, in units.
    pub fn residual(&self, start: &[f64]) -> Vec<f64> {
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
        self.jacobian.iter().enumerate().map(entry).collect()
    }

    /// The periodic orbit at a converged start, with the Floquet multipliers of P′; convergence is the caller's.
    ///
    /// # Errors
    /// `NoConvergence` where the multipliers are not found.
    pub fn into_periodic_orbit(
        self,
        start: Vec<f64>,
        periods: u64,
        residual: f64,
    ) -> Result<PeriodicOrbit, Error> {
        let n = self.end.len();
        let slope = Matrix::from_fn(n, n, |i, j| self.jacobian[i * n + j]);
        let mut multipliers = eigen::eigenvalues(&slope)?;
        sort_falling(&mut multipliers, |a| a.norm());
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
    x.iter().fold(0.0, |most, x| most.max(x.abs()))
}
