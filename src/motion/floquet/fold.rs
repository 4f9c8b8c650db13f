//! Fold of a family of periodic orbits by arc-length continuation (Keller 1977; Allgower and Georg 1990, ch. 6).
//! The parameter component of the tangent vanishes at the fold.

use super::orbit::{PeriodicOrbit, find_orbit, max_norm, return_map};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::dynamic_model::DynamicModel;
use crate::numeric::small_dense;

/// Point of the family: the scaled state at t = 0, then the parameter.
type ContinuationPoint = Vec<f64>;

/// Options of the continuation to a fold.
#[derive(Debug, Clone, Copy)]
pub struct FoldOptions {
    /// Parameter of the first orbit.
    pub from: f64,
    /// First step of the parameter; its sign is the direction.
    pub step: f64,
    /// Maximum number of continuation steps.
    pub max_steps: usize,
}

/// Relative parameter step of the central difference; rounding and truncation errors are of the same order.
const DIFFERENCE_STEP: f64 = 1e-6;

/// Parameter and orbit of the first fold of the family that starts at the orbit near the state `estimate`.
///
/// # Errors
/// `NoConvergence` if the corrector fails or no fold occurs within the steps.
pub fn find_fold(
    family: &dyn Fn(f64) -> DynamicModel,
    estimate: &[f64],
    periods: u64,
    options: FoldOptions,
) -> Result<(f64, PeriodicOrbit), Error> {
    let first = find_orbit(&family(options.from), estimate, periods)?;
    let units = return_map(&family(options.from), &first.start, periods)?.units;
    let orbits = OrbitFamily {
        family,
        periods,
        units,
    };
    let mut point: ContinuationPoint = first
        .start
        .iter()
        .zip(&orbits.units)
        .map(|(y, u)| y / u)
        .collect();
    point.push(options.from);
    let mut reference = vec![0.0; point.len()];
    reference[point.len() - 1] = options.step.signum();
    let mut tangent = orbits.tangent(&point, &reference)?;
    let step = options.step.abs() / tangent[point.len() - 1].abs();
    for _ in 0..options.max_steps {
        let next = orbits.correct(&point, &tangent, step)?;
        let next_tangent = orbits.tangent(&next, &tangent)?;
        if next_tangent[point.len() - 1] * options.step < 0.0 {
            return orbits.locate_fold(&point, &tangent, step);
        }
        (point, tangent) = (next, next_tangent);
    }
    Err(Error::new(
        Code::NoConvergence,
        format!(
            "no fold of the family of orbits was found in {} steps",
            options.max_steps
        ),
    )
    .with_hint("take more steps, or larger ones"))
}

struct OrbitFamily<'a> {
    family: &'a dyn Fn(f64) -> DynamicModel,
    periods: u64,
    units: Vec<f64>,
}

impl OrbitFamily<'_> {
    /// Residual `P(y) − y` of the return map and its derivatives, `[row][state and parameter]`.
    fn residual_and_jacobian(
        &self,
        point: &ContinuationPoint,
    ) -> Result<(Vec<f64>, Vec<f64>), Error> {
        let n = self.units.len();
        let parameter = point[n];
        let start: Vec<f64> = point
            .iter()
            .zip(&self.units)
            .map(|(x, unit)| x * unit)
            .collect();
        let end_at = |parameter: f64| {
            let map = return_map(&(self.family)(parameter), &start, self.periods)?;
            Ok::<_, Error>((self.rescaled(&map.end, &map.units), map))
        };
        let (end, map) = end_at(parameter)?;
        let residual: Vec<f64> = end.iter().zip(point).map(|(end, x)| end - x).collect();
        let delta = DIFFERENCE_STEP * parameter.abs();
        let (up, down) = (end_at(parameter + delta)?.0, end_at(parameter - delta)?.0);
        let mut jacobian = Vec::with_capacity(n * (n + 1));
        for i in 0..n {
            for j in 0..n {
                let ratio = map.units[i] / self.units[i] * (self.units[j] / map.units[j]);
                jacobian.push(map.jacobian[i * n + j] * ratio - f64::from(i == j));
            }
            jacobian.push((up[i] - down[i]) / (2.0 * delta));
        }
        Ok((residual, jacobian))
    }

    fn rescaled(&self, x: &[f64], units: &[f64]) -> Vec<f64> {
        let scaled = x.iter().zip(units).zip(&self.units);
        scaled.map(|((x, from), to)| x * from / to).collect()
    }

    /// Unit tangent at a point, oriented along `reference`.
    fn tangent(&self, point: &ContinuationPoint, reference: &[f64]) -> Result<Vec<f64>, Error> {
        let (_, mut jacobian) = self.residual_and_jacobian(point)?;
        jacobian.extend_from_slice(reference);
        let mut tangent = vec![0.0; point.len()];
        tangent[point.len() - 1] = 1.0;
        small_dense::solve(&mut jacobian, &mut tangent);
        let norm = tangent.iter().map(|x| x * x).sum::<f64>().sqrt();
        tangent.iter_mut().for_each(|x| *x /= norm);
        Ok(tangent)
    }

    /// Corrector: point of the family at the arc-length step from a point along its tangent.
    fn correct(
        &self,
        from: &ContinuationPoint,
        tangent: &[f64],
        step: f64,
    ) -> Result<ContinuationPoint, Error> {
        let mut point: ContinuationPoint = from
            .iter()
            .zip(tangent)
            .map(|(x, t)| x + step * t)
            .collect();
        for _ in 0..MAX_ITERATIONS {
            let (mut residual, mut jacobian) = self.residual_and_jacobian(&point)?;
            jacobian.extend_from_slice(tangent);
            let advance: f64 = point
                .iter()
                .zip(from)
                .zip(tangent)
                .map(|((x, o), t)| (x - o) * t)
                .sum();
            residual.push(advance - step);
            small_dense::solve(&mut jacobian, &mut residual);
            point.iter_mut().zip(&residual).for_each(|(x, m)| *x -= m);
            if max_norm(&residual) <= 1e-12 * max_norm(&point) {
                return Ok(point);
            }
        }
        Err(Error::new(
            Code::NoConvergence,
            "the continuation of the family of orbits failed",
        )
        .with_hint("take smaller steps"))
    }

    /// Locates by bisection the fold between a point and the next one.
    fn locate_fold(
        &self,
        from: &ContinuationPoint,
        tangent: &[f64],
        step: f64,
    ) -> Result<(f64, PeriodicOrbit), Error> {
        let n = self.units.len();
        let (mut low, mut high) = (0.0, step);
        let direction = tangent[n];
        while high - low > 1e-7 * step {
            let middle = 0.5 * (low + high);
            let point = self.correct(from, tangent, middle)?;
            match self.tangent(&point, tangent)?[n] * direction > 0.0 {
                true => low = middle,
                false => high = middle,
            }
        }
        let point = self.correct(from, tangent, low)?;
        let model = (self.family)(point[n]);
        let start: Vec<f64> = point
            .iter()
            .zip(&self.units)
            .map(|(x, unit)| x * unit)
            .collect();
        let map = return_map(&model, &start, self.periods)?;
        let residual = max_norm(&map.residual(&start));
        Ok((
            point[n],
            map.into_periodic_orbit(start, self.periods, residual)?,
        ))
    }
}

const MAX_ITERATIONS: usize = 20;
