//! Coordinates that can be condensed: fixed frequency `√(K_ii/M_ii)` far above the band.
//!
//! Advice only: nothing is left out by it.

use super::interior::elastic_stiffness;
use super::method::{ReducedModel, ReductionMethod, natural_frequencies};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::modes::system_matrices::AnalysisContext;
use crate::numeric::sorting::sort_falling;

/// A coordinate that could be left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CondensableCoordinate {
    /// Coordinate number among those retained.
    pub coordinate: usize,
    /// Degree of freedom in the machine.
    pub dof: usize,
    /// `√(K_ii/M_ii)/2π`, Hz: with all others held; infinite without inertia.
    pub fixed_frequency_hz: f64,
}

/// Coordinates that can be condensed together.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CondensationAdvice {
    /// The coordinates, the lightest for their stiffness first.
    pub leave_out: Vec<CondensableCoordinate>,
    /// Elastic frequencies in the band that were compared.
    pub compared: usize,
    /// The largest relative change of any of these without the coordinates.
    pub worst_change: f64,
}

/// Nearer to the band than this a coordinate is not tried.
const MIN_FREQUENCY_RATIO: f64 = 1.5;

/// Finds the coordinates that can be condensed statically while every frequency up to `f_max_hz` stays within `tolerance`.
///
/// Undamped frequencies are compared; the response is [`ReducedModel::compare`]'s to judge.
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
            .with_hint("both are above zero, such as 500 Hz and 0.001"));
    }
    let candidates = candidates(context, f_max_hz);
    // The most that passes: more left out means larger changes, so that halving finds it; each answer is a real comparison.
    let (mut good, mut bad) = (0, candidates.len() + 1);
    let mut best = (0, 0.0);
    while bad - good > 1 {
        let middle = (good + bad) / 2;
        match change(context, &candidates[..middle], f_max_hz)? {
            Some((compared, worst)) if worst <= tolerance => {
                good = middle;
                best = (compared, worst);
            }
            _ => bad = middle,
        }
    }
    Ok(CondensationAdvice {
        leave_out: candidates[..good].to_vec(),
        compared: best.0,
        worst_change: best.1,
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
    let own = |j: usize| (k[(j, j)] / inertia[j]).sqrt() / std::f64::consts::TAU;
    let all = (0..linear.n).map(|j| CondensableCoordinate {
        coordinate: j,
        dof: linear.independent_dofs[j],
        fixed_frequency_hz: own(j),
    });
    let mut far: Vec<CondensableCoordinate> = all
        .filter(|c| c.fixed_frequency_hz > MIN_FREQUENCY_RATIO * f_max_hz)
        .collect();
    sort_falling(&mut far, |a| a.fixed_frequency_hz);
    far
}

/// Number of frequencies compared and the largest change among them; `None` where the rest cannot represent the machine.
fn change(
    context: &AnalysisContext,
    left_out: &[CondensableCoordinate],
    f_max_hz: f64,
) -> Result<Option<(usize, f64)>, Error> {
    let masters: Vec<usize> = (0..context.model.n)
        .filter(|j| left_out.iter().all(|c| c.coordinate != *j))
        .collect();
    let Ok(model) = ReducedModel::new(context, ReductionMethod::Guyan { masters }) else {
        return Ok(None);
    };
    if !model.matrices.massless.is_empty() {
        return Ok(None);
    }
    let found = natural_frequencies(context.model, &model.matrices)?;
    let rigid = context.basis.n_rigid;
    let in_band = |w: &&f64| **w <= f_max_hz * std::f64::consts::TAU;
    let exact: Vec<f64> = context.basis.omega[rigid..]
        .iter()
        .take_while(in_band)
        .copied()
        .collect();
    if found.len() < rigid + exact.len() {
        return Ok(None);
    }
    let worst = exact
        .iter()
        .zip(&found[rigid..])
        .map(|(e, f)| (f / e - 1.0).abs())
        .fold(0.0, f64::max);
    Ok(Some((exact.len(), worst)))
}
