//! From the first line to the last fit: variance, growth, structure, last refinement.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::statistics::median;
use crate::numeric::{Complex, Matrix};

use super::basis::{Pole, Problem, Structure};
use super::condensed::{Condensed, Condenser};
use super::covariance::{Covariance, covariance};
use super::growth::{Growth, Rules};
use super::lines::{Lines, Weights};
use super::projection::{Fitted, Model, Stop, at, left, refine};
use super::spread::{self, Scatter};
use super::structure::{choose, parameters};
use super::variance::{from_differences, from_residuals, mean_ratio};
use super::{Delay, Effort, RationalOptions, Step, delay};

/// What a search found.
pub(super) struct Found {
    /// The last fit, with one set of coefficients per problem.
    pub fitted: Fitted,
    /// All lines, for each set.
    pub problems: Vec<Problem>,
    /// What the fit leaves of them.
    pub left: Vec<Matrix>,
    /// Of the poles and delays, if the variance is right.
    pub covariance: Covariance,
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
    /// `Σ ln v + |r|²/v` over all values, by independent lines: the negative logarithm of the likelihood.
    pub surprise: f64,
    /// The share of its size by which each value was taken to be off, beside its noise.
    pub departure: f64,
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

/// Finds poles and their structure. Where poles are added beside poles without end, every value is taken to be off by a share of its
/// size as well, that which the poles could not explain, and poles are looked for again. Poles may be given to begin `from`: then none
/// is added.
///
/// # Errors
/// `NoConvergence`: that does not end either.
pub(super) fn search(
    lines: &Lines,
    options: &RationalOptions,
    trusted: bool,
    from: Option<&[Pole]>,
) -> Result<Found, Error> {
    let mut departure = options.departure.unwrap_or(0.0);
    let mut repeats = 0;
    loop {
        let departs = match searched(lines, options, trusted, from, departure) {
            Ok(found) => return Ok(found),
            Err(departs) => departs,
        };
        if options.departure.is_none() || repeats == MOST_REPEATS || departs.share > MOST_DEPARTURE
        {
            let message = format!(
                "{} pole pairs do not explain the responses to within their noise, and more do not help",
                departs.poles
            );
            let hint = "the responses disagree, leak or are nonlinear: take another method (--method plscf), a narrower band, or say how many modes there are (--order)";
            return Err(Error::new(Code::NoConvergence, message).hint(hint));
        }
        repeats += 1;
        departure = departs.share.max(MORE * departure);
    }
}

/// How often a share of the size is raised, and the largest that still says something about poles.
const MOST_REPEATS: usize = 2;
const MOST_DEPARTURE: f64 = 0.2;

/// Poles without end.
struct Departs {
    /// Pole pairs so far.
    poles: usize,
    /// What they leave of a value, as a share of it: the median where values stand out of their noise.
    share: f64,
}

fn searched(
    lines: &Lines,
    options: &RationalOptions,
    trusted: bool,
    from: Option<&[Pole]>,
    departure: f64,
) -> Result<Found, Departs> {
    let given = lines.variance.is_some();
    let estimated = !(given && trusted);
    let mut variance = match &lines.variance {
        Some(v) => lines.floored(v),
        None => from_differences(lines),
    };
    depart(lines, &mut variance, departure);
    let rules = Rules {
        most: most_determined(lines, options.most_poles),
        order: options.order,
        grows: from.is_none(),
        unstable: options.allow_unstable,
        estimated,
        data: lines.data(),
    };
    let mut effort = Effort::default();
    let mut evidence = Vec::new();
    let mut structure = Structure::FULL;
    let mut start = Model {
        poles: from.unwrap_or_default().to_vec(),
        delays: match options.delay {
            Delay::None => Vec::new(),
            kind => {
                let problem = lines.shared(&lines.weights(&variance), structure);
                delay::start(&problem, kind == Delay::PerResponse)
            }
        },
    };
    let mut scattered = Scattered::default();
    for round in 0..=ROUNDS {
        let mut held = grown(
            lines,
            rules,
            structure,
            &variance,
            &mut scattered,
            start,
            &mut evidence,
            &mut effort,
        )?;
        let mut settled = given || round == ROUNDS;
        if !settled {
            let residual = held.residuals(lines, structure.numerators(), &mut effort);
            let unknown = parameters(structure, &held.fitted, lines.h.len());
            let free = 1.0 - unknown * lines.independence / lines.data();
            let mut next = from_residuals(lines, &residual, free.max(0.1));
            depart(lines, &mut next, departure);
            let ratio = mean_ratio(&next, &variance);
            variance = next;
            settled = (SETTLED.0..SETTLED.1).contains(&ratio);
            if settled {
                held = Held::at(
                    lines,
                    &scattered.added(lines, &variance),
                    &held.fitted.model,
                );
            }
        }
        start = held.fitted.model.clone();
        if settled {
            let (chosen, better, steps) = choose(held.lines(), lines.data(), &held.fitted);
            structure = chosen;
            start = better.model;
            effort.steps += steps;
            break;
        }
    }
    let Held {
        mut all,
        mut weights,
        mut fitted,
        ..
    } = grown(
        lines,
        rules,
        structure,
        &variance,
        &mut scattered,
        start,
        &mut evidence,
        &mut effort,
    )?;
    if merge(lines, &weights, &mut scattered, &mut fitted, structure) {
        weights = lines.weights(&scattered.added(lines, &variance));
        all = [lines.shared(&weights, structure)];
    }
    let at_limit = rules.grows && options.order.is_none() && fitted.model.poles.len() >= rules.most;
    let numerators = structure.numerators();
    let separate = (!weights.exact)
        .then(|| lines.separate(&weights, &scattered.added(lines, &variance), structure));
    let problems = separate.as_deref().unwrap_or(&all);
    let (fitted, covariance) = last(problems, fitted.model, numerators, &mut effort);
    let fits = problems.iter().zip(&fitted.fits);
    let left = fits
        .map(|(problem, fit)| left(problem, &fitted.model, numerators, fit))
        .collect();
    let shared = at(&all, &fitted.model, numerators);
    let mean_of = |r: usize| {
        spread::mean(&all[0], &shared, numerators, r, lines.independence).map(|m| (r, m))
    };
    let mut spread: Vec<(usize, spread::Mean)> = (0..scattered.list.len())
        .filter(|&at_list| scattered.list[at_list].0.share == 0.0)
        .filter_map(|at_list| mean_of(scattered.nearest(at_list, &fitted)?))
        .collect();
    if departure > 0.0 && lines.h.len() > 1 {
        // A common pole is wider than those of responses that disagree, whether that was seen or not.
        let known: Vec<usize> = spread.iter().map(|s| s.0).collect();
        let others = (0..fitted.model.poles.len())
            .filter(|r| !known.contains(r) && spread::is_light(&fitted.model.poles[*r]));
        spread.extend(others.filter_map(mean_of).filter(|(_, m)| m.is_finite()));
    }
    let dof = lines.data() - parameters(structure, &fitted, lines.h.len());
    let last_variance = scattered.added(lines, &variance);
    let logarithms: f64 = last_variance.iter().flatten().map(|v| v.ln()).sum();
    let surprise = lines.independence * logarithms + 0.5 * fitted.chi2;
    Ok(Found {
        fitted,
        problems: separate.unwrap_or_else(|| all.to_vec()),
        left,
        covariance,
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
        surprise,
        departure,
        effort,
    })
}

/// Adds the square of a share of each value to its variance.
fn depart(lines: &Lines, variance: &mut [Vec<f64>], share: f64) {
    for (v, h) in variance.iter_mut().zip(&lines.h) {
        for (v, h) in v.iter_mut().zip(h) {
            *v += share * share * h.norm_sqr();
        }
    }
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
                (poles[a].w - poles[b].w).abs() < spread::ONE * poles[a].sigma.min(poles[b].sigma)
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

/// A fit with all lines, those it was made on, and their weights.
struct Held {
    all: [Problem; 1],
    /// `None` for all.
    fewer: Option<Problem>,
    weights: Weights,
    fitted: Fitted,
}

impl Held {
    /// Of every term, at a model as it stands.
    fn at(lines: &Lines, variance: &[Vec<f64>], model: &Model) -> Held {
        let weights = lines.weights(variance);
        let all = [lines.shared(&weights, Structure::FULL)];
        let enough = Condenser::new(&all[0]).condensed(model, &[]);
        let fewer = (!enough.is_whole()).then(|| enough.problem.into_owned());
        let problem = fewer.as_ref().unwrap_or(&all[0]);
        let fitted = at(&[problem], model, Structure::FULL.numerators());
        Held {
            all,
            fewer,
            weights,
            fitted,
        }
    }

    /// Those the fit was made on.
    fn lines(&self) -> &Problem {
        self.fewer.as_ref().unwrap_or(&self.all[0])
    }

    /// What is left of the scaled responses once the poles are near enough to their place for an estimate of the variance.
    fn residuals(
        &mut self,
        lines: &Lines,
        numerators: usize,
        effort: &mut Effort,
    ) -> Vec<Vec<Complex>> {
        let problem = std::slice::from_ref(self.lines());
        let fitted = refine(problem, self.fitted.clone(), numerators, BEFORE_VARIANCE);
        effort.steps += fitted.steps;
        effort.rounds += 1;
        let residual = unweighted(lines, &self.weights, &self.all[0], &fitted, numerators);
        self.fitted = fitted;
        residual
    }
}

/// What a fit leaves of the scaled responses, on all lines.
fn unweighted(
    lines: &Lines,
    weights: &Weights,
    all: &Problem,
    fitted: &Fitted,
    numerators: usize,
) -> Vec<Vec<Complex>> {
    let left = left(all, &fitted.model, numerators, &fitted.fits[0]);
    let n = lines.x.len();
    let unit = |i: usize, k: usize| {
        let variance = weights.by_response[i] * weights.by_line[k];
        (variance / 2.0 / lines.independence).sqrt()
    };
    (0..lines.h.len())
        .map(|i| {
            let column = left.col_as_slice(i);
            (0..n)
                .map(|k| Complex::new(column[k], column[n + k]) * unit(i, k))
                .collect()
        })
        .collect()
}

/// The median of residuals over values that stand out of their noise, as the deviation of a complex normal number.
fn share_left(lines: &Lines, variance: &[Vec<f64>], residual: &[Vec<Complex>]) -> f64 {
    /// Power over the variance.
    const STANDS_OUT: f64 = 100.0;
    let mut shares = Vec::new();
    for ((h, v), e) in lines.h.iter().zip(variance).zip(residual) {
        for ((h, v), e) in h.iter().zip(v).zip(e) {
            if h.norm_sqr() > STANDS_OUT * v {
                shares.push(e.norm_sqr() / h.norm_sqr());
            }
        }
    }
    median(&mut shares).map_or(f64::INFINITY, |median| {
        (median / std::f64::consts::LN_2).sqrt()
    })
}

/// Grows at one variance and structure; where responses disagree about a pole, the weights are changed and growth goes on.
#[allow(clippy::too_many_arguments)]
fn grown(
    lines: &Lines,
    rules: Rules,
    structure: Structure,
    variance: &[Vec<f64>],
    scattered: &mut Scattered,
    mut model: Model,
    evidence: &mut Vec<Step>,
    effort: &mut Effort,
) -> Result<Held, Departs> {
    let numerators = structure.numerators();
    for _ in 0..MOST_DISAGREEMENTS {
        let weights = lines.weights(&scattered.added(lines, variance));
        let all = [lines.shared(&weights, structure)];
        let growth = Growth::new(&all[0], numerators, rules, MOST_WORK - effort.work);
        let grown = growth.grown(&model, evidence);
        effort.scans += grown.scans;
        effort.steps += grown.steps;
        effort.work += grown.work;
        if effort.work > MOST_WORK {
            let problem = grown.fewer.as_ref().unwrap_or(&all[0]);
            let fit = at(&[problem], &grown.fitted.model, numerators);
            let residual = unweighted(lines, &weights, &all[0], &fit, numerators);
            return Err(Departs {
                poles: grown.fitted.model.poles.len(),
                share: share_left(lines, variance, &residual),
            });
        }
        let Some(scatter) = grown.scatter else {
            return Ok(Held {
                fewer: grown.fewer,
                fitted: grown.fitted,
                all,
                weights,
            });
        };
        scattered.add(lines, &weights, &grown.fitted, numerators, scatter);
        model = grown.fitted.model;
    }
    let weights = lines.weights(&scattered.added(lines, variance));
    let all = [lines.shared(&weights, structure)];
    Ok(Held {
        fitted: at(&all, &model, numerators),
        fewer: None,
        all,
        weights,
    })
}

/// Most changes of the lines that the last refinement is made on: the poles have hardly anywhere to go.
const LAST_ROUNDS: usize = 4;

/// The last refinement, and the covariance there.
fn last(
    problems: &[Problem],
    mut model: Model,
    numerators: usize,
    effort: &mut Effort,
) -> (Fitted, Covariance) {
    let mut condensers: Vec<Condenser> = problems.iter().map(Condenser::new).collect();
    let mut round = 0;
    loop {
        let enough: Vec<Condensed> = (condensers.iter_mut())
            .map(|c| c.condensed(&model, &[]))
            .collect();
        let start = at(&enough, &model, numerators);
        let fitted = refine(&enough, start, numerators, LAST);
        effort.steps += fitted.steps;
        round += 1;
        let served = enough.iter().all(|e| e.serves(&fitted.model.poles));
        if served || round == LAST_ROUNDS {
            let certain = covariance(&enough, &fitted, numerators);
            return (fitted, certain);
        }
        model = fitted.model;
    }
}

/// Pole pairs whose parameters stay below half of the data, and at most `most`.
pub(super) fn most_determined(lines: &Lines, most: usize) -> usize {
    let (n, no) = (lines.x.len(), lines.h.len());
    // per pole pair two numbers per response and the pole itself; two residual terms per response
    let determined = (n * no).saturating_sub(2 * no) / (2 * no + 2);
    most.min(determined.max(1))
}
