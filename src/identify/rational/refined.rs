//! Poles that another method found, each brought to its place in a window of its own: every response has its own pole there, beside a
//! smooth background, and the mode is the mean over the responses that see it (random effects, DerSimonian and Laird 1986). A method
//! that looks for common poles of all lines at once spends two on a resonance the responses disagree about, or a wider one; here
//! there is one, with an uncertainty that holds what noise leaves and what the responses disagree by.

use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::statistics::chi_squared_quantile;

use super::answer::spread_of;
use super::basis::{Pole, Problem, Structure};
use super::lines::{Lines, Weights};
use super::local::{cut, window};
use super::projection::{Fitted, Model, Stop, at, refine};
use super::scan::spacing;
use super::spread::{Mean, beside, disagreement, mean};
use super::variance::from_differences;
use super::{Measured, RationalOptions, Spread};
use crate::identify::mode::IdentifiedMode;

/// A pole at its place.
#[derive(Debug, Clone)]
pub struct Refined {
    /// Which of those given.
    pub place: usize,
    /// The pole and its covariance; no shape. As given, and without covariance, where its window is most of the band or no response
    /// holds on to it.
    pub mode: IdentifiedMode,
    /// What the responses disagree by, where it is known.
    pub spread: Option<Spread>,
}

/// Each pole is fitted beside the others where they stand, so all are fitted again once they have moved.
const ROUNDS: usize = 4;

/// Brings poles (rad/s, of the upper half plane, the more certain first) to their places. One that lies beside another and stands only
/// for what the responses disagree by is left out; the order is kept.
///
/// # Errors
/// As [`super::fit`] of what was measured.
pub fn refined(
    measured: &Measured,
    options: &RationalOptions,
    poles: &[Complex],
) -> Result<Vec<Refined>, Error> {
    let lines = Lines::new(measured, options)?;
    let variance = match &lines.variance {
        Some(variance) => lines.floored(variance),
        None => from_differences(&lines),
    };
    let weights = Weights::new(&variance);
    let numerators = Structure::FULL.numerators();
    let problem = [lines.shared(&weights, Structure::FULL)];
    let all: Vec<Pole> = poles.iter().map(|p| scaled(*p, lines.top)).collect();
    let places = distinct(&problem, numerators, &all);
    let mut now: Vec<Pole> = places.iter().map(|&k| all[k]).collect();
    let mut answer = Vec::new();
    for _ in 0..ROUNDS {
        let fitted = fitted(&problem, &now, numerators);
        answer = (0..now.len())
            .map(|r| {
                let mean = mean(&problem[0], &fitted, numerators, r, lines.independence)
                    .filter(Mean::is_finite);
                (places[r], mean)
            })
            .collect();
        for (pole, (_, mean)) in now.iter_mut().zip(&answer) {
            *pole = mean.as_ref().map_or(*pole, |mean| mean.pole);
        }
    }
    Ok(answer
        .into_iter()
        .map(|(place, mean)| {
            let mut mode = IdentifiedMode {
                pole: poles[place],
                pole_covariance: None,
                shape: Vec::new(),
            };
            let spread = mean.map(|mean| spread_of(&mut mode, &mean, lines.top));
            Refined {
                place,
                mode,
                spread,
            }
        })
        .collect())
}

/// A start needs a width; in units of the highest line.
const LEAST_REAL_PART: f64 = 1e-9;

fn scaled(pole: Complex, top: f64) -> Pole {
    Pole {
        w: pole.im / top,
        sigma: (pole.re.abs() / top).max(LEAST_REAL_PART),
        stable: pole.re <= 0.0,
    }
}

fn fitted(problem: &[Problem; 1], poles: &[Pole], numerators: usize) -> Fitted {
    let model = Model {
        poles: poles.to_vec(),
        delays: Vec::new(),
    };
    at(problem, &model, numerators)
}

/// Which poles are left when those are gone that stand beside an earlier one without need, or for a disagreement about it.
fn distinct(problem: &[Problem; 1], numerators: usize, all: &[Pole]) -> Vec<usize> {
    let mut kept: Vec<usize> = Vec::new();
    for (k, pole) in all.iter().enumerate() {
        let known: Vec<Pole> = kept.iter().map(|&k| all[k]).collect();
        let is_double = beside(&problem[0], &known, pole).is_some_and(|r| {
            let others = (0..all.len()).filter(|o| *o > k || kept.contains(o));
            let without: Vec<usize> = others.collect();
            let Some(r) = without.iter().position(|&o| o == kept[r]) else {
                return false;
            };
            let poles: Vec<Pole> = without.iter().map(|&o| all[o]).collect();
            let fitted = fitted(problem, &poles, numerators);
            !is_needed(&problem[0], &fitted, numerators, r, *pole)
                || disagreement(&problem[0], &fitted, numerators, r, *pole).is_some()
        });
        if !is_double {
            kept.push(k);
        }
    }
    kept
}

/// How often noise alone may keep a second pole beside another.
const FALSE_ALARM: f64 = 1e-3;

const STOP: Stop = Stop {
    steps: 15,
    fall: 0.1,
    share: 1e-5,
};

/// Whether one more pole beside pole `r` lowers the misfit of the window by more than noise would, the noise taken from what both leave.
fn is_needed(problem: &Problem, fitted: &Fitted, numerators: usize, r: usize, place: Pole) -> bool {
    let pole = fitted.model.poles[r];
    let Some((from, to)) = window(&problem.x, &pole, spacing(&problem.x)) else {
        return true;
    };
    let local = [cut(problem, fitted, numerators, &[r], from, to)];
    let best = |poles: Vec<Pole>| {
        let model = Model {
            poles,
            delays: Vec::new(),
        };
        refine(&local, at(&local, &model, numerators), numerators, STOP).chi2
    };
    let (one, two) = (best(vec![pole]), best(vec![pole, place]));
    let responses = local[0].y.ncols() as f64;
    let unknown = responses * (2 * numerators + local[0].fixed.ncols()) as f64 + 4.0;
    let freedom = (2.0 * (to - from) as f64 * responses - unknown).max(1.0);
    let brings = numerators as f64 * responses + 2.0;
    one - two > (two / freedom).max(1.0) * chi_squared_quantile(1.0 - FALSE_ALARM, brings)
}
