//! Poles that another method found, each brought to its place in a window of its own: every response has its own pole there, beside a
//! smooth background, and the mode is the mean over the responses that see it (random effects, DerSimonian and Laird 1986). A method
//! that looks for common poles of all lines at once spends two on a resonance the responses disagree about, or a wider one; here
//! there is one, with an uncertainty that holds what noise leaves and what the responses disagree by.

use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::statistics::chi_squared_quantile;

use super::answer::{residue, shape, spread_of, visibility};
use super::basis::{Pole, Problem, Structure};
use super::lines::{Lines, Weights};
use super::local::{cut, window};
use super::projection::{Fitted, Model, Stop, at, refine};
use super::reported::{Candidate, objection};
use super::spread::{FEWEST_RESPONSES, Mean, ONE, beside, disagreement, mean};
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
    /// Why it is no mode, judged as the poles of a rational fit are where the misfit exceeds the noise.
    pub objection: Option<&'static str>,
}

/// Residues are free complex numbers.
const NUMERATORS: usize = 2;

/// Each pole is fitted beside the others where they stand, so all are fitted again once they have moved.
const ROUNDS: usize = 4;

/// Brings poles (rad/s, of the upper half plane, the more certain first) to their places. One that lies beside another and stands only
/// for what the responses disagree by is left out, and so is one that comes within half a half-width of another; the order is kept.
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
    let weights = lines.weights(&variance);
    let problem = [lines.shared(&weights, Structure::FULL)];
    let all: Vec<Pole> = poles.iter().map(|p| Pole::new(*p, lines.top)).collect();
    let first = apart(&problem[0], &all);
    let (mut places, mut now): (Vec<usize>, Vec<Pole>) = first.iter().map(|&k| (k, all[k])).unzip();
    let mut means = settle(&problem, &mut now, lines.independence);
    for k in (0..all.len()).filter(|k| !first.contains(k)) {
        if is_double(&problem, &now, &all[k]) {
            continue;
        }
        places.push(k);
        now.push(all[k]);
        means = settle(&problem, &mut now, lines.independence);
    }
    while let Some(twin) = twin(&means, lines.h.len()) {
        places.remove(twin);
        now.remove(twin);
        means = settle(&problem, &mut now, lines.independence);
    }
    let residues = residues(&lines, &weights, &fitted(&problem, &now));
    let mut answer: Vec<Refined> = (places.into_iter().zip(means).enumerate())
        .map(|(r, (place, mean))| {
            let own: Vec<Complex> = residues.iter().map(|row| row[r]).collect();
            let mut mode = IdentifiedMode {
                pole: poles[place],
                pole_covariance: None,
                shape: shape(&own, &lines),
            };
            let spread = mean.map(|mean| spread_of(&mut mode, &mean, lines.top));
            let objection = match &spread {
                None => window(&lines.x, &all[place], lines.step).map(|_| NOT_HELD),
                Some(_) => objection(&Candidate {
                    mode: &mode,
                    band_hz: lines.ends_hz(),
                    visibility: visibility(&lines, &now[r].value(), &residues, r),
                    model_error: true,
                }),
            };
            mode.shape.clear();
            Refined {
                place,
                mode,
                spread,
                objection,
            }
        })
        .collect();
    answer.sort_by_key(|a| a.place);
    Ok(answer)
}

/// Of a pole that every response leaves when it may move there alone.
const NOT_HELD: &str = "no response holds a pole there";

/// Residues of the scaled responses, by response and pole.
fn residues(lines: &Lines, weights: &Weights, fitted: &Fitted) -> Vec<Vec<Complex>> {
    let fit = &fitted.fits[0];
    (0..lines.h.len())
        .map(|i| {
            let unit = weights.by_response[i].sqrt();
            let c: Vec<f64> = (0..fit.c.nrows())
                .map(|j| fit.c[(j, i)] / fit.length[j] * unit)
                .collect();
            let poles = fitted.model.poles.iter().enumerate();
            poles.map(|(r, p)| residue(&c, p, r, NUMERATORS)).collect()
        })
        .collect()
}

/// Poles that settled closer than this, in standard deviations of their difference, are one that was given twice.
const TWINS: f64 = 3.0;

/// A pole that came to the place of an earlier one: as near as both are certain, or, of responses that can disagree, nearer than what
/// they disagree by lets two be told apart.
fn twin(means: &[Option<Mean>], responses: usize) -> Option<usize> {
    let meet = |a: &Mean, b: &Mean| {
        let near = |x: f64, y: f64, v: f64, u: f64| (x - y).powi(2) <= TWINS * TWINS * (v + u);
        let (p, q) = (&a.pole, &b.pole);
        let reach = ONE * p.sigma.min(q.sigma);
        let is_one = (p.w - q.w).abs() < reach && (p.sigma - q.sigma).abs() < reach;
        (responses >= FEWEST_RESPONSES && is_one)
            || near(p.w, q.w, a.variance.0, b.variance.0)
                && near(p.sigma, q.sigma, a.variance.1, b.variance.1)
    };
    (1..means.len()).rev().find(|&k| {
        let earlier = means[..k].iter().flatten();
        means[k]
            .as_ref()
            .is_some_and(|own| earlier.into_iter().any(|other| meet(own, other)))
    })
}

fn fitted(problem: &[Problem; 1], poles: &[Pole]) -> Fitted {
    let model = Model {
        poles: poles.to_vec(),
        delays: Vec::new(),
    };
    at(problem, &model, NUMERATORS)
}

/// Which poles lie beside no earlier one.
fn apart(problem: &Problem, all: &[Pole]) -> Vec<usize> {
    let mut chosen: Vec<usize> = Vec::new();
    for (k, pole) in all.iter().enumerate() {
        let known: Vec<Pole> = chosen.iter().map(|&k| all[k]).collect();
        if beside(problem, &known, pole).is_none() {
            chosen.push(k);
        }
    }
    chosen
}

/// Brings the poles to the means over the responses that see them, which are returned.
fn settle(problem: &[Problem; 1], now: &mut [Pole], independence: f64) -> Vec<Option<Mean>> {
    let mut means = Vec::new();
    for _ in 0..ROUNDS {
        let fitted = fitted(problem, now);
        let mean = |r: usize| mean(&problem[0], &fitted, NUMERATORS, r, independence);
        means = (0..now.len())
            .map(|r| mean(r).filter(Mean::is_finite))
            .collect();
        for (pole, mean) in now.iter_mut().zip(&means) {
            *pole = mean.as_ref().map_or(*pole, |mean| mean.pole);
        }
    }
    means
}

/// Whether a pole stands beside one of those at their places without need, or for what the responses disagree about.
fn is_double(problem: &[Problem; 1], now: &[Pole], pole: &Pole) -> bool {
    let Some(r) = beside(&problem[0], now, pole) else {
        return false;
    };
    let fitted = fitted(problem, now);
    !is_needed(&problem[0], &fitted, r, *pole)
        || disagreement(&problem[0], &fitted, NUMERATORS, r, *pole, margin(problem)).is_some()
}

/// By so much two common poles must fit better than one of each response: both emulate a small disagreement equally well, with as many
/// numbers, and the choice between them would be left to noise.
fn margin(problem: &[Problem; 1]) -> f64 {
    let responses = problem[0].y.ncols() as f64;
    chi_squared_quantile(1.0 - FALSE_ALARM, 2.0 * responses)
}

/// How often noise alone may keep a second pole beside another.
const FALSE_ALARM: f64 = 1e-3;

const STOP: Stop = Stop {
    steps: 15,
    fall: 0.1,
    share: 1e-5,
};

/// Whether one more pole beside pole `r` lowers the misfit of the window by more than noise would, the noise taken from what both leave.
fn is_needed(problem: &Problem, fitted: &Fitted, r: usize, place: Pole) -> bool {
    let numerators = NUMERATORS;
    let pole = fitted.model.poles[r];
    let Some((from, to)) = window(&problem.x, &pole, problem.step) else {
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
