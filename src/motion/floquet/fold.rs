//! Fold of a family of periodic orbits, found by arc-length continuation.
//!
//! The family is followed by arc length (Keller 1977; Allgower and Georg 1990, ch. 6) until its tangent stands still in the parameter.

use super::orbit::{PeriodicOrbit, find_orbit, max_norm, return_map};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::dynamic_model::DynamicModel;
use crate::numeric::small_dense;

/// A point of a family: a state at t = 0 in units of its size, then the parameter.
type ContinuationPoint = Vec<f64>;

/// Which way to go, and how.
#[derive(Debug, Clone, Copy)]
pub struct FoldOptions {
    /// The parameter of the first orbit.
    pub from: f64,
    /// The first step of the parameter; its sign is the sense.
    pub step: f64,
    /// Steps after which no fold is expected any more.
    pub max_steps: usize,
}

/// Steps of the parameter for its derivative, relative: errors of rounding and of the second order are then alike.
const DIFFERENCE_STEP: f64 = 1e-6;

/// The parameter and the orbit of the first fold of a family that starts near a state.
///
/// # Errors
/// `NoConvergence` where the family is lost or does not turn back.
pub fn find_fold(
    family: &dyn Fn(f64) -> DynamicModel,
    near: &[f64],
    periods: u64,
    course: FoldOptions,
) -> Result<(f64, PeriodicOrbit), Error> {
    let first = find_orbit(&family(course.from), near, periods)?;
    let units = return_map(&family(course.from), &first.start, periods)?.units;
    let follow = OrbitFamily {
        family,
        periods,
        units,
    };
    let mut here: ContinuationPoint = first
        .start
        .iter()
        .zip(&follow.units)
        .map(|(y, u)| y / u)
        .collect();
    here.push(course.from);
    let mut along = vec![0.0; here.len()];
    along[here.len() - 1] = course.step.signum();
    let mut tangent = follow.tangent(&here, &along)?;
    let step = course.step.abs() / tangent[here.len() - 1].abs();
    for _ in 0..course.max_steps {
        let next = follow.correct(&here, &tangent, step)?;
        let turned = follow.tangent(&next, &tangent)?;
        if turned[here.len() - 1] * course.step < 0.0 {
            return follow.locate_fold(&here, &tangent, step);
        }
        (here, tangent) = (next, turned);
    }
    Err(Error::new(
        Code::NoConvergence,
        format!(
            "the family of orbits did not turn back in {} steps",
            course.max_steps
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
    /// `P − y` and its derivatives, `[row][state and parameter]`.
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
        let miss = |parameter: f64| {
            let there = return_map(&(self.family)(parameter), &start, self.periods)?;
            Ok::<_, Error>((self.rescaled(&there.end, &there.units), there))
        };
        let (end, there) = miss(parameter)?;
        let apart: Vec<f64> = end.iter().zip(point).map(|(end, x)| end - x).collect();
        let delta = DIFFERENCE_STEP * parameter.abs();
        let (up, down) = (miss(parameter + delta)?.0, miss(parameter - delta)?.0);
        let mut slope = Vec::with_capacity(n * (n + 1));
        for i in 0..n {
            for j in 0..n {
                let ratio = there.units[i] / self.units[i] * (self.units[j] / there.units[j]);
                slope.push(there.jacobian[i * n + j] * ratio - f64::from(i == j));
            }
            slope.push((up[i] - down[i]) / (2.0 * delta));
        }
        Ok((apart, slope))
    }

    fn rescaled(&self, x: &[f64], units: &[f64]) -> Vec<f64> {
        let each = x.iter().zip(units).zip(&self.units);
        each.map(|((x, from), to)| x * from / to).collect()
    }

    /// The unit tangent at a point, in the sense of `along`.
    fn tangent(&self, point: &ContinuationPoint, along: &[f64]) -> Result<Vec<f64>, Error> {
        let (_, mut slope) = self.residual_and_jacobian(point)?;
        slope.extend_from_slice(along);
        let mut tangent = vec![0.0; point.len()];
        tangent[point.len() - 1] = 1.0;
        small_dense::solve(&mut slope, &mut tangent);
        let size = tangent.iter().map(|x| x * x).sum::<f64>().sqrt();
        tangent.iter_mut().for_each(|x| *x /= size);
        Ok(tangent)
    }

    /// The point of the family at a distance along the tangent.
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
            let (mut miss, mut slope) = self.residual_and_jacobian(&point)?;
            slope.extend_from_slice(tangent);
            let gone: f64 = point
                .iter()
                .zip(from)
                .zip(tangent)
                .map(|((x, o), t)| (x - o) * t)
                .sum();
            miss.push(gone - step);
            small_dense::solve(&mut slope, &mut miss);
            point.iter_mut().zip(&miss).for_each(|(x, m)| *x -= m);
            if max_norm(&miss) <= 1e-12 * max_norm(&point) {
                return Ok(point);
            }
        }
        Err(
            Error::new(Code::NoConvergence, "the family of orbits was lost")
                .with_hint("take smaller steps"),
        )
    }

    /// Locates a fold, where the parameter is stationary between a point and the step ahead of it.
    fn locate_fold(
        &self,
        from: &ContinuationPoint,
        tangent: &[f64],
        step: f64,
    ) -> Result<(f64, PeriodicOrbit), Error> {
        let n = self.units.len();
        let (mut low, mut high) = (0.0, step);
        let sense = tangent[n];
        while high - low > 1e-7 * step {
            let middle = 0.5 * (low + high);
            let there = self.correct(from, tangent, middle)?;
            match self.tangent(&there, tangent)?[n] * sense > 0.0 {
                true => low = middle,
                false => high = middle,
            }
        }
        let there = self.correct(from, tangent, low)?;
        let model = (self.family)(there[n]);
        let start: Vec<f64> = there
            .iter()
            .zip(&self.units)
            .map(|(x, unit)| x * unit)
            .collect();
        let map = return_map(&model, &start, self.periods)?;
        let residual = max_norm(&map.residual(&start));
        Ok((
            there[n],
            map.into_periodic_orbit(start, self.periods, residual)?,
        ))
    }
}

const MAX_ITERATIONS: usize = 20;
