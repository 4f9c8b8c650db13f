//! From the first line to the last fit: variance, growth, structure, last refinement.

use crate::numeric::Complex;

use super::basis::Structure;
use super::growth::{Growth, Rules};
use super::lines::{Lines, Weights};
use super::projection::{Fitted, Model, Stop, at, refine};
use super::structure::{choose, parameters};
use super::variance::{from_differences, from_residuals, mean_ratio};
use super::{Delay, Effort, RationalOptions, Step, delay};

/// What a search found.
pub(super) struct Found {
    /// The last fit, over [`Found::problems`].
    pub fitted: Fitted,
    /// The problems of the last fit.
    pub problems: Vec<super::basis::Problem>,
    /// Weights of the responses in them.
    pub by_response: Vec<f64>,
    /// Its terms.
    pub structure: Structure,
    /// The variance was not given, or is itself an estimate.
    pub estimated: bool,
    /// Data less parameters.
    pub dof: f64,
    /// What was tried.
    pub evidence: Vec<Step>,
    /// The most poles allowed were used up.
    pub at_limit: bool,
    /// What it took.
    pub effort: Effort,
}

/// Most estimates of the variance, and the ratio of one to the last within which they have settled.
const ROUNDS: usize = 6;
const SETTLED: (f64, f64) = (0.8, 1.1);

/// Before the variance is estimated from residuals, poles are refined until a step gains less than this share.
const BEFORE_VARIANCE: Stop = Stop {
    steps: 20,
    fall: 1e-3,
    share: 1e-3,
};

/// The last refinement.
const LAST: Stop = Stop {
    steps: 40,
    fall: 0.0,
    share: 1e-9,
};

/// Finds poles and their structure.
pub(super) fn search(lines: &Lines, options: &RationalOptions, trusted: bool) -> Found {
    let given = lines.variance.is_some();
    let estimated = !(given && trusted);
    let mut variance = match &lines.variance {
        Some(v) => floored(lines, v),
        None => from_differences(lines),
    };
    let rules = Rules {
        most: most_determined(lines, options.most_poles),
        order: options.order,
        unstable: options.allow_unstable,
        estimated,
        data: lines.data(),
    };
    let mut effort = Effort::default();
    let mut evidence = Vec::new();
    let mut weights = Weights::new(&variance);
    let mut structure = Structure::FULL;
    let mut problem = [lines.shared(&weights, structure)];
    let mut model = Model {
        poles: Vec::new(),
        delays: match options.delay {
            Delay::None => Vec::new(),
            kind => delay::start(&problem[0], kind == Delay::PerResponse),
        },
    };
    let mut fitted = at(&problem, &model, structure.numerators());
    for round in 0..=ROUNDS {
        let mut growth = Growth::new(&problem, structure.numerators(), rules);
        fitted = growth.prune(fitted);
        fitted = growth.grow(fitted, &mut evidence);
        effort.scans += growth.scans;
        effort.steps += growth.steps;
        if given || round == ROUNDS {
            break;
        }
        fitted = refine(&problem, fitted, structure.numerators(), BEFORE_VARIANCE);
        effort.steps += fitted.steps;
        effort.rounds += 1;
        let residual = residuals(lines, &weights, &fitted);
        let free = 1.0
            - parameters(structure, &fitted, lines.h.len()) * lines.independence / lines.data();
        let next = from_residuals(lines, &residual, free.max(0.1));
        let ratio = mean_ratio(&next, &variance);
        variance = next;
        weights = Weights::new(&variance);
        problem = [lines.shared(&weights, structure)];
        model = fitted.model;
        fitted = at(&problem, &model, structure.numerators());
        if (SETTLED.0..SETTLED.1).contains(&ratio) {
            break;
        }
    }
    let (chosen, better, steps) = choose(lines, &weights, &fitted, true);
    structure = chosen;
    effort.steps += steps;
    problem = [lines.shared(&weights, structure)];
    let mut growth = Growth::new(&problem, structure.numerators(), rules);
    fitted = growth.prune(better);
    fitted = growth.grow(fitted, &mut evidence);
    effort.scans += growth.scans;
    effort.steps += growth.steps;
    let at_limit = options.order.is_none() && fitted.model.poles.len() >= rules.most;
    let problems = if weights.exact {
        problem.to_vec()
    } else {
        lines.separate(&weights, &variance, structure)
    };
    let start = at(&problems, &fitted.model, structure.numerators());
    let fitted = refine(&problems, start, structure.numerators(), LAST);
    effort.steps += fitted.steps;
    let dof = lines.data() - parameters(structure, &fitted, lines.h.len());
    Found {
        fitted,
        problems,
        by_response: weights.by_response,
        structure,
        estimated,
        dof: dof.max(1.0),
        evidence,
        at_limit,
        effort,
    }
}

/// Pole pairs whose parameters stay below half of the data, and at most `most`.
fn most_determined(lines: &Lines, most: usize) -> usize {
    let (n, no) = (lines.x.len(), lines.h.len());
    // per pole pair two numbers per response and the pole itself; two residual terms per response
    let determined = (n * no).saturating_sub(2 * no) / (2 * no + 2);
    most.min(determined.max(1))
}

fn floored(lines: &Lines, variance: &[Vec<f64>]) -> Vec<Vec<f64>> {
    variance
        .iter()
        .enumerate()
        .map(|(i, v)| {
            v.iter()
                .enumerate()
                .map(|(k, v)| v.max(lines.floor(i, k)))
                .collect()
        })
        .collect()
}

/// What a fit of all responses leaves of the scaled responses.
pub(super) fn residuals(lines: &Lines, weights: &Weights, fitted: &Fitted) -> Vec<Vec<Complex>> {
    let n = lines.x.len();
    let e = &fitted.fits[0].e;
    (0..lines.h.len())
        .map(|i| {
            let column = e.col_as_slice(i);
            (0..n)
                .map(|k| {
                    let unit =
                        (weights.by_response[i] * weights.by_line[k] / 2.0 / lines.independence)
                            .sqrt();
                    Complex::new(column[k], column[n + k]) * unit
                })
                .collect()
        })
        .collect()
}
