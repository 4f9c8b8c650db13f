//! Coordinates that can be condensed because their fixed frequency `√(K_ii/M_ii)` lies far above the band.
//!
//! The result is advice; the model is not changed.

use super::interior::elastic_stiffness;
use super::method::{ReducedModel, ReductionMethod, natural_frequencies};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::modes::system_matrices::AnalysisContext;
use crate::numeric::sorting::sort_descending;

/// Coordinate that could be condensed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CondensableCoordinate {
    /// Index among the retained coordinates.
    pub coordinate: usize,
    /// Index of the degree of freedom in the machine.
    pub dof: usize,
    /// Frequency `√(K_ii/M_ii)/2π` with all other coordinates fixed, Hz; infinite without inertia.
    pub fixed_frequency_hz: f64,
}

/// Coordinates that can be condensed together.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CondensationAdvice {
    /// Condensable coordinates, by decreasing fixed frequency.
    pub coordinates: Vec<CondensableCoordinate>,
    /// Number of elastic natural frequencies compared in the band.
    pub n_compared: usize,
    /// Largest relative change of these frequencies by the condensation.
    pub max_change: f64,
}

/// Least ratio of the fixed frequency of a candidate to the highest frequency of the band.
const MIN_FREQUENCY_RATIO: f64 = 1.5;

/// Finds the coordinates that can be condensed statically while every frequency up to `f_max_hz` stays within `tolerance`.
///
/// Undamped natural frequencies are compared; [`ReducedModel::compare`] compares responses.
///
/// # Errors
/// `OutOfRange` for a frequency or tolerance that is not positive; those of a reduction.
pub fn find_condensable(
    context: &AnalysisContext,
    f_max_hz: f64,
    tolerance: f64,
) -> Result<CondensationAdvice, Error> {
    if !(f_max_hz > 0.0 && tolerance > 0.0) {
        let message =
            format!("frequencies up to {f_max_hz} Hz within {tolerance} cannot be compared");
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("give both above zero, such as 500 Hz and 0.001"));
    }
    let candidates = candidates(context, f_max_hz);
    // The change increases with the number of condensed coordinates; bisection finds the largest number within the tolerance.
    let (mut accepted, mut rejected) = (0, candidates.len() + 1);
    let mut best = (0, 0.0);
    while rejected - accepted > 1 {
        let middle = (accepted + rejected) / 2;
        match change(context, &candidates[..middle], f_max_hz)? {
            Some((compared, worst)) if worst <= tolerance => {
                accepted = middle;
                best = (compared, worst);
            }
            _ => rejected = middle,
        }
    }
    Ok(CondensationAdvice {
        coordinates: candidates[..accepted].to_vec(),
        n_compared: best.0,
        max_change: best.1,
    })
}

fn candidates(context: &AnalysisContext, f_max_hz: f64) -> Vec<CondensableCoordinate> {
    let linear = context.model;
    let k = elastic_stiffness(linear);
    let mut inertia = vec![0.0; linear.n];
    for mass in &linear.masses {
        mass.direction
            .entries()
            .for_each(|(j, a)| inertia[j] += mass.value * a * a);
    }
    let frequency = |j: usize| (k[(j, j)] / inertia[j]).sqrt() / std::f64::consts::TAU;
    let coordinates = (0..linear.n).map(|j| CondensableCoordinate {
        coordinate: j,
        dof: linear.independent_dofs[j],
        fixed_frequency_hz: frequency(j),
    });
    let mut candidates: Vec<CondensableCoordinate> = coordinates
        .filter(|c| c.fixed_frequency_hz > MIN_FREQUENCY_RATIO * f_max_hz)
        .collect();
    sort_descending(&mut candidates, |a| a.fixed_frequency_hz);
    candidates
}

/// Number of frequencies compared and their largest relative change; `None` if the retained coordinates cannot represent the machine.
fn change(
    context: &AnalysisContext,
    condensed: &[CondensableCoordinate],
    f_max_hz: f64,
) -> Result<Option<(usize, f64)>, Error> {
    let masters: Vec<usize> = (0..context.model.n)
        .filter(|j| condensed.iter().all(|c| c.coordinate != *j))
        .collect();
    let Ok(model) = ReducedModel::new(context, ReductionMethod::Guyan { masters }) else {
        return Ok(None);
    };
    if !model.matrices.massless.is_empty() {
        return Ok(None);
    }
    let reduced = natural_frequencies(context.model, &model.matrices)?;
    let rigid = context.basis.n_rigid;
    let in_band = |w: &&f64| **w <= f_max_hz * std::f64::consts::TAU;
    let exact: Vec<f64> = context.basis.omega[rigid..]
        .iter()
        .take_while(in_band)
        .copied()
        .collect();
    if reduced.len() < rigid + exact.len() {
        return Ok(None);
    }
    let worst = exact
        .iter()
        .zip(&reduced[rigid..])
        .map(|(e, f)| (f / e - 1.0).abs())
        .fold(0.0, f64::max);
    Ok(Some((exact.len(), worst)))
}
