//! A start for a delay: modes with real constants have residues of the phases 0 or π; what the strongest modes' phases have in
//! common beyond that falls with frequency as `−ωτ`.

use crate::numeric::Complex;

use super::basis::Problem;
use super::local::{Placed, place};
use super::projection::{Model, at};
use super::scan::{scan, spacing};

/// Modes the phases are taken from.
const MODES: usize = 8;

/// Delays tried, to either side of zero.
const TRIALS: i32 = 2000;

/// The delay of one or of every response, in units of the inverse of the highest line's angular frequency.
///
/// The local fits give, per response, the phase of a mode's residue. Among delays the sum of `|R| cos 2(arg R + xτ)` is largest; the
/// range is half a turn between neighbouring lines at most, and of alike delays the shortest wins.
pub(super) fn start(problem: &Problem, per_response: bool) -> Vec<f64> {
    let empty = at(std::slice::from_ref(problem), &Model::default(), 2);
    let peaks = scan(problem, &empty.fits[0], &[]);
    let mut strong: Vec<Placed> = Vec::new();
    for peak in &peaks {
        if strong.len() == MODES {
            break;
        }
        let clear = |p: &Placed| p.pole.overlap(&peak.pole) < 0.05;
        if strong.iter().all(clear)
            && let Some(p) = place(problem, &empty, 2, peak, false)
            && strong.iter().all(|q| q.pole.overlap(&p.pole) < 0.2)
        {
            strong.push(p);
        }
    }
    let responses = problem.y.ncols();
    if !per_response {
        return vec![best(problem, &strong, &(0..responses).collect::<Vec<_>>())];
    }
    (0..responses)
        .map(|i| best(problem, &strong, &[i]))
        .collect()
}

fn best(problem: &Problem, strong: &[Placed], responses: &[usize]) -> f64 {
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
    let longest = 0.25 * std::f64::consts::PI / spacing(&problem.x);
    let score = |delay: f64| -> f64 {
        phases
            .iter()
            .map(|(w, z)| (z * Complex::new(0.0, 2.0 * w * delay).exp()).re)
            .sum::<f64>()
            / total
    };
    let mut best = (0.0, score(0.0));
    // fine enough for the highest line, within a bound on the work
    let fine = (longest / 0.2).ceil().min(f64::from(TRIALS)) as i32;
    for j in 1..=fine {
        for sign in [1.0, -1.0] {
            let delay = sign * longest * f64::from(j) / f64::from(fine);
            let value = score(delay);
            // a longer delay must be clearly better
            if value > best.1 + 0.02 {
                best = (delay, value);
            }
        }
    }
    best.0
}
