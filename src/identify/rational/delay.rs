//! Initial estimate of a delay from residue phases: common phase falls as `−ωτ`.

use crate::numeric::Complex;

use super::basis::WhitenedProblem;
use super::local_fit::{LocalFit, fit_locally};
use super::projection::{PoleModel, fit_at};
use super::scan::scan;

/// Modes the phases are taken from.
const MAX_MODES: usize = 8;

/// Delays tried, to either side of zero, and their distance: a fifth of the radian by which the doubled phase of the highest line turns.
const DELAY_TRIALS: i32 = 2000;
const DELAY_STEP: f64 = 0.1;

/// Delays whose sum reaches this share of the highest are alike.
const TIE_SHARE: f64 = 0.85;

/// A mode whose gain is below this share of the strongest may be the skirt of another.
const MIN_GAIN_SHARE: f64 = 0.01;

/// The delay of one or of every response, in units of the inverse of the highest line's angular frequency.
///
/// The local fits give, per response, the phase of a mode's residue. Among delays the sum of `|R| cos 2(arg R + xτ)` is largest; of
/// alike delays the shortest wins.
pub(super) fn initial_delay(problem: &WhitenedProblem, per_response: bool) -> Vec<f64> {
    let empty = fit_at(std::slice::from_ref(problem), &PoleModel::default(), 2);
    let peaks = scan(problem, &empty.fits[0].e, &[]);
    let mut strong: Vec<LocalFit> = Vec::new();
    for peak in &peaks {
        if strong.len() == MAX_MODES {
            break;
        }
        if strong
            .first()
            .is_some_and(|s| peak.gain < MIN_GAIN_SHARE * s.gain)
        {
            break;
        }
        let clear = |p: &LocalFit| p.pole.overlap(&peak.pole) < 0.05;
        if strong.iter().all(clear)
            && let Some(p) = fit_locally(problem, &empty, 2, peak, false)
            && strong.iter().all(|q| q.pole.overlap(&p.pole) < 0.2)
        {
            strong.push(p);
        }
    }
    let responses = problem.y.ncols();
    if !per_response {
        return vec![best_delay(&strong, &(0..responses).collect::<Vec<_>>())];
    }
    (0..responses).map(|i| best_delay(&strong, &[i])).collect()
}

fn best_delay(strong: &[LocalFit], responses: &[usize]) -> f64 {
    // (place, square of the residue with its phase doubled)
    let phases: Vec<(f64, Complex)> = strong
        .iter()
        .flat_map(|p| {
            let size = p.pole.w.hypot(p.pole.sigma);
            let value = p.pole.value();
            responses.iter().map(move |&i| {
                // the two columns have length one and nearly the same shape, so that their lengths drop out but for s/|p|
                let (a, b) = (p.numerators[(0, i)], p.numerators[(1, i)]);
                let residue = Complex::new(a, 0.0) + value / size * b;
                (p.pole.w, residue * residue)
            })
        })
        .collect();
    let total: f64 = phases.iter().map(|p| p.1.norm()).sum();
    if total == 0.0 {
        return 0.0;
    }
    let score = |delay: f64| -> f64 {
        phases
            .iter()
            .map(|(w, z)| (z * Complex::new(0.0, 2.0 * w * delay).exp()).re)
            .sum::<f64>()
            / total
    };
    // by rising length, both signs
    let trials: Vec<(f64, f64)> = (0..=DELAY_TRIALS)
        .flat_map(|j| [1.0, -1.0].map(|sign| sign * DELAY_STEP * f64::from(j)))
        .map(|delay| (delay, score(delay)))
        .collect();
    let highest = trials.iter().map(|t| t.1).fold(0.0, f64::max);
    let Some(&(mut delay, mut value)) = trials.iter().find(|t| t.1 >= TIE_SHARE * highest) else {
        return 0.0;
    };
    for sign in [1.0, -1.0] {
        while score(delay + sign * DELAY_STEP) > value {
            delay += sign * DELAY_STEP;
            value = score(delay);
        }
    }
    delay
}
