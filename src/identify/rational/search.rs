//! From the first line to the last fit: variance, growth, structure, last refinement.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;

use super::basis::{Pole, Problem, Structure};
use super::growth::{Growth, Rules};
use super::lines::{Lines, Weights};
use super::projection::{Fitted, Model, Stop, at, refine};
use super::spread::{self, Scatter};
use super::structure::{choose, parameters};
use super::variance::{from_differences, from_residuals, mean_ratio};
use super::{Delay, Effort, RationalOptions, Step, delay};

/// What a search found.
pub(super) struct Found {
    /// The last fit, over [`Found::problems`].
    pub fitted: Fitted,
    /// The problems of the last fit.
    pub problems: Vec<Problem>,
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
    /// Poles the responses disagree about, with their means.
    pub spread: Vec<(usize, spread::Mean)>,
    /// Resonances whose skirts are not those of a pole: place, and misfit as a share of the mode's own value.
    pub skirts: Vec<(f64, f64)>,
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

/// Operations of growth, about, after which the responses are taken to be no sum of poles to within their noise: several times
/// what ten modes in ten thousand lines of six responses take.
const MOST_WORK: f64 = 2e10;

/// The last refinement.
const LAST: Stop = Stop {
    steps: 40,
    fall: 0.0,
    share: 1e-9,
};

/// Finds poles and their structure.
///
/// # Errors
/// `NoConvergence`: poles are added beside poles without end.
pub(super) fn search(
    lines: &Lines,
    options: &RationalOptions,
    trusted: bool,
) -> Result<Found, Error> {
    let given = lines.variance.is_some();
    let estimated = !(given && trusted);
    let mut variance = match &lines.variance {
        Some(v) => lines.floored(v),
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
    let mut scattered = Scattered::default();
    for round in 0..=ROUNDS {
        (problem, weights, fitted) = grown(
            lines,
            rules,
            structure,
            &variance,
            &mut scattered,
            fitted,
            &mut evidence,
            &mut effort,
        )?;
        if given || round == ROUNDS {
            break;
        }
        fitted = refine(&problem, fitted, structure.numerators(), BEFORE_VARIANCE);
        effort.steps += fitted.steps;
        effort.rounds += 1;
        let residual = residuals(lines, &weights, &fitted);
        let free =
            1.0 - parameters(structure, &fitted, lines.h.len()) * lines.independence / lines.data();
        let next = from_residuals(lines, &residual, free.max(0.1));
        let ratio = mean_ratio(&next, &variance);
        variance = next;
        weights = Weights::new(&scattered.added(lines, &variance));
        problem = [lines.shared(&weights, structure)];
        model = fitted.model;
        fitted = at(&problem, &model, structure.numerators());
        if (SETTLED.0..SETTLED.1).contains(&ratio) {
            break;
        }
    }
    let (chosen, better, steps) = choose(lines, &weights, &fitted);
    structure = chosen;
    effort.steps += steps;
    (problem, weights, fitted) = grown(
        lines,
        rules,
        structure,
        &variance,
        &mut scattered,
        better,
        &mut evidence,
        &mut effort,
    )?;
    if merge(lines, &weights, &mut scattered, &mut fitted, structure) {
        weights = Weights::new(&scattered.added(lines, &variance));
        problem = [lines.shared(&weights, structure)];
    }
    let at_limit = options.order.is_none() && fitted.model.poles.len() >= rules.most;
    let problems = if weights.exact {
        problem.to_vec()
    } else {
        lines.separate(&weights, &scattered.added(lines, &variance), structure)
    };
    let start = at(&problems, &fitted.model, structure.numerators());
    let fitted = refine(&problems, start, structure.numerators(), LAST);
    effort.steps += fitted.steps;
    let spread = (0..scattered.list.len())
        .filter(|&at_list| scattered.list[at_list].0.share == 0.0)
        .filter_map(|at_list| {
            let r = scattered.nearest(at_list, &fitted)?;
            let shared = at(&problem, &fitted.model, structure.numerators());
            Some((
                r,
                spread::mean(
                    &problem[0],
                    &shared,
                    structure.numerators(),
                    r,
                    lines.independence,
                )?,
            ))
        })
        .collect();
    let dof = lines.data() - parameters(structure, &fitted, lines.h.len());
    Ok(Found {
        fitted,
        problems,
        by_response: weights.by_response,
        structure,
        estimated,
        dof: dof.max(1.0),
        evidence,
        skirts: scattered
            .list
            .iter()
            .filter(|s| s.0.share > 0.0)
            .map(|s| (s.1.value().norm(), s.0.share))
            .collect(),
        spread,
        at_limit,
        effort,
    })
}

/// Disagreements found so far, with the pole and its residues as they were.
#[derive(Default)]
struct Scattered {
    list: Vec<(Scatter, Pole, Vec<f64>)>,
}

/// A pole that is found to scatter again scatters more than was thought.
const MORE: f64 = 2.0;

/// Most disagreements of one fit, counting repeats.
const MOST_DISAGREEMENTS: usize = 60;

impl Scattered {
    fn add(
        &mut self,
        lines: &Lines,
        weights: &Weights,
        fitted: &Fitted,
        numerators: usize,
        new: Scatter,
    ) {
        let pole = fitted.model.poles[new.pole];
        let residues = residue_sizes(lines, weights, fitted, numerators, new.pole);
        let old = self
            .list
            .iter_mut()
            .find(|(_, p, _)| p.overlap(&pole) > 0.5);
        match old {
            Some((scatter, p, r)) => {
                scatter.tau.0 = (MORE * scatter.tau.0).max(new.tau.0);
                scatter.tau.1 = (MORE * scatter.tau.1).max(new.tau.1);
                scatter.share = (MORE * scatter.share).max(new.share);
                (*p, *r) = (pole, residues);
            }
            None => self.list.push((new, pole, residues)),
        }
    }

    /// The variance with what the disagreements add.
    fn added(&self, lines: &Lines, variance: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut all = variance.to_vec();
        for (scatter, pole, residues) in &self.list {
            for (i, v) in all.iter_mut().enumerate() {
                for (k, v) in v.iter_mut().enumerate() {
                    let x = lines.x[k];
                    let size = residues[i] * x.powi(i32::from(lines.derivative));
                    *v += size * size * spread::variance(scatter, pole, x);
                }
            }
        }
        all
    }

    /// The pole of a fit that an entry is about.
    fn nearest(&self, entry: usize, fitted: &Fitted) -> Option<usize> {
        let pole = &self.list[entry].1;
        let poles = &fitted.model.poles;
        (0..poles.len())
            .filter(|&r| poles[r].overlap(pole) > 0.5)
            .max_by(|&a, &b| poles[a].overlap(pole).total_cmp(&poles[b].overlap(pole)))
    }
}

/// Where responses disagree about some poles, two poles nearer than this share of a half-width are one they disagree about.
const ONE: f64 = 0.5;

/// Merges such poles; says whether there were any.
fn merge(
    lines: &Lines,
    weights: &Weights,
    scattered: &mut Scattered,
    fitted: &mut Fitted,
    structure: Structure,
) -> bool {
    let numerators = structure.numerators();
    let mut merged = false;
    if scattered.list.iter().all(|s| s.0.share > 0.0) {
        return false;
    }
    loop {
        let poles = &fitted.model.poles;
        let pair = (0..poles.len())
            .flat_map(|a| (0..a).map(move |b| (a, b)))
            .find(|&(a, b)| {
                (poles[a].w - poles[b].w).abs() < ONE * poles[a].sigma.min(poles[b].sigma)
            });
        let Some((gone, kept)) = pair else {
            return merged;
        };
        let apart = (poles[gone].w - poles[kept].w).abs();
        let wider = (poles[gone].sigma - poles[kept].sigma).abs();
        let mut model = fitted.model.clone();
        model.poles[kept].w = 0.5 * (poles[gone].w + poles[kept].w);
        model.poles.remove(gone);
        *fitted = at(&[lines.shared(weights, structure)], &model, numerators);
        let new = Scatter {
            pole: kept,
            tau: (apart, wider),
            share: 0.0,
        };
        scattered.add(lines, weights, fitted, numerators, new);
        merged = true;
    }
}

/// Sizes of the residues of a pole in the scaled responses.
fn residue_sizes(
    lines: &Lines,
    weights: &Weights,
    fitted: &Fitted,
    numerators: usize,
    r: usize,
) -> Vec<f64> {
    let fit = &fitted.fits[0];
    let p = fitted.model.poles[r].value();
    (0..lines.h.len())
        .map(|i| {
            let c = |b: usize| {
                let at = r * numerators + b;
                fit.c[(at, i)] / fit.length[at]
            };
            let mut top = Complex::new(c(0) * p.norm(), 0.0);
            if numerators == 2 {
                top += p * c(1);
            }
            top.norm() / (2.0 * p.im) * weights.by_response[i].sqrt()
        })
        .collect()
}

/// Grows at one variance and structure; where responses disagree about a pole, the weights are changed and growth goes on.
#[allow(clippy::too_many_arguments)]
fn grown(
    lines: &Lines,
    rules: Rules,
    structure: Structure,
    variance: &[Vec<f64>],
    scattered: &mut Scattered,
    start: Fitted,
    evidence: &mut Vec<Step>,
    effort: &mut Effort,
) -> Result<([Problem; 1], Weights, Fitted), Error> {
    let numerators = structure.numerators();
    let mut model = start.model;
    for _ in 0..MOST_DISAGREEMENTS {
        let weights = Weights::new(&scattered.added(lines, variance));
        let problem = [lines.shared(&weights, structure)];
        let mut growth = Growth::new(&problem, numerators, rules, MOST_WORK - effort.work);
        let fitted = growth.prune(at(&problem, &model, numerators));
        let mut fitted = growth.grow(fitted, evidence);
        // A disagreement names its pole by place: poles go only where there is none.
        if growth.scatter.is_none() {
            fitted = growth.drop_uncertain(fitted);
        }
        effort.scans += growth.scans;
        effort.steps += growth.steps;
        effort.work += growth.work;
        if effort.work > MOST_WORK {
            let message = format!(
                "{} pole pairs do not explain the responses to within their noise, and more do not help",
                fitted.model.poles.len()
            );
            let hint = "the responses disagree, leak or are nonlinear: take another method (--method plscf), a narrower band, or say how many modes there are (--order)";
            return Err(Error::new(Code::NoConvergence, message).hint(hint));
        }
        let Some(scatter) = growth.scatter else {
            return Ok((problem, weights, fitted));
        };
        scattered.add(lines, &weights, &fitted, numerators, scatter);
        model = fitted.model;
    }
    let weights = Weights::new(&scattered.added(lines, variance));
    let problem = [lines.shared(&weights, structure)];
    let fitted = at(&problem, &model, numerators);
    Ok((problem, weights, fitted))
}

/// Pole pairs whose parameters stay below half of the data, and at most `most`.
pub(super) fn most_determined(lines: &Lines, most: usize) -> usize {
    let (n, no) = (lines.x.len(), lines.h.len());
    // per pole pair two numbers per response and the pole itself; two residual terms per response
    let determined = (n * no).saturating_sub(2 * no) / (2 * no + 2);
    most.min(determined.max(1))
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
