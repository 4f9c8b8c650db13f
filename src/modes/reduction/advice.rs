//! What could be left out: coordinates whose own frequency `√(K_ii/M_ii)` is far above the band, tried by really condensing them.
//!
//! Advice only: nothing is left out by it.

use super::interior::squares_stiffness;
use super::method::{Method, Reduced, frequencies};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::modes::equations::Case;

/// A coordinate that could be left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftOut {
    /// Its number among those that stay.
    pub coordinate: usize,
    /// Its freedom in the machine.
    pub freedom: usize,
    /// `√(K_ii/M_ii)/2π`, Hz: with all others held; infinite without inertia.
    pub own_hz: f64,
}

/// What could be left out together.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Advice {
    /// The coordinates, the lightest for their stiffness first.
    pub leave_out: Vec<LeftOut>,
    /// Elastic frequencies in the band that were compared.
    pub compared: usize,
    /// The largest relative change of any of these without the coordinates.
    pub worst_change: f64,
}

/// Nearer to the band than this a coordinate is not tried.
const FAR: f64 = 1.5;

/// Finds the coordinates that can be condensed statically while every frequency up to `f_max_hz` stays within `tolerance`.
///
/// Undamped frequencies are compared; the response is [`Reduced::compare`]'s to judge.
///
/// # Errors
/// `OutOfRange` for a frequency or tolerance that is not positive; those of a reduction.
pub fn advise(case: &Case, f_max_hz: f64, tolerance: f64) -> Result<Advice, Error> {
    if !(f_max_hz > 0.0 && tolerance > 0.0) {
        let message =
            format!("frequencies up to {f_max_hz} Hz within {tolerance} cannot be compared");
        return Err(Error::new(Code::OutOfRange, message)
            .hint("both are above zero, such as 500 Hz and 0.001"));
    }
    let candidates = candidates(case, f_max_hz);
    // The most that passes: more left out means larger changes, so that halving finds it; each answer is a real comparison.
    let (mut good, mut bad) = (0, candidates.len() + 1);
    let mut best = (0, 0.0);
    while bad - good > 1 {
        let middle = (good + bad) / 2;
        match change(case, &candidates[..middle], f_max_hz)? {
            Some((compared, worst)) if worst <= tolerance => {
                good = middle;
                best = (compared, worst);
            }
            _ => bad = middle,
        }
    }
    Ok(Advice {
        leave_out: candidates[..good].to_vec(),
        compared: best.0,
        worst_change: best.1,
    })
}

fn candidates(case: &Case, f_max_hz: f64) -> Vec<LeftOut> {
    let linear = case.linear;
    let k = squares_stiffness(linear);
    let mut inertia = vec![0.0; linear.n];
    for mass in &linear.masses {
        mass.direction
            .scaled()
            .for_each(|(j, a)| inertia[j] += mass.value * a * a);
    }
    let own = |j: usize| (k[(j, j)] / inertia[j]).sqrt() / std::f64::consts::TAU;
    let all = (0..linear.n).map(|j| LeftOut {
        coordinate: j,
        freedom: linear.free[j],
        own_hz: own(j),
    });
    let mut far: Vec<LeftOut> = all.filter(|c| c.own_hz > FAR * f_max_hz).collect();
    far.sort_by(|a, b| b.own_hz.total_cmp(&a.own_hz));
    far
}

/// How many frequencies were compared and how far the worst moved; `None` where the rest cannot stand for the machine.
fn change(case: &Case, left_out: &[LeftOut], f_max_hz: f64) -> Result<Option<(usize, f64)>, Error> {
    let masters: Vec<usize> = (0..case.linear.n)
        .filter(|j| left_out.iter().all(|c| c.coordinate != *j))
        .collect();
    let Ok(reduced) = Reduced::new(case, Method::Guyan { masters }) else {
        return Ok(None);
    };
    if !reduced.equations.massless.is_empty() {
        return Ok(None);
    }
    let found = frequencies(case.linear, &reduced.equations)?;
    let rigid = case.basis.n_rigid;
    let in_band = |w: &&f64| **w <= f_max_hz * std::f64::consts::TAU;
    let exact: Vec<f64> = case.basis.omega[rigid..]
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
