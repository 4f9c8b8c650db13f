//! From the first line to the last fit: variance, growth, structure, last refinement; where noise alone does not explain the responses,
//! in a variance that holds what they depart from the model by.

use crate::numeric::{Complex, Matrix};

use super::basis::{Pole, Problem, Structure};
use super::condensed::{Condensed, Condenser};
use super::covariance::{Covariance, covariance};
use super::departure::{Departure, Modes};
use super::groups::{GroupMean, means};
use super::growth::{Growth, Rules, is_crowd};
use super::judge::Judge;
use super::lines::{Lines, Weights};
use super::projection::{Fitted, Model, Stop, at, left, refine};
use super::real::{Departing, Search, unweighted};
use super::scatter::FEWEST_GROUPS;
use super::structure::{choose, parameters};
use super::variance::{from_differences, from_residuals, mean_ratio};
use super::windowed::{Band, NUMERATORS, coefficients};
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
    /// Weighted misfit of the lines that were searched.
    pub chi2: f64,
    /// Data less parameters.
    pub dof: f64,
    /// What was tried.
    pub evidence: Vec<Step>,
    /// What each pole departs from the model by, where noise alone does not explain the responses.
    pub departures: Option<Vec<Departure>>,
    /// What hits, or responses, say of each pole by themselves.
    pub means: Vec<Option<GroupMean>>,
    /// Groups of these means are hits.
    pub by_hit: bool,
    /// The most poles allowed were used up.
    pub at_limit: bool,
    /// `Σ ln v + |r|²/v` over all values, by independent lines: the negative logarithm of the likelihood.
    pub surprise: f64,
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

/// Operations of growth, about, after which noise alone is taken not to explain the responses: several times what ten modes in ten
/// thousand lines of six responses take.
const MOST_WORK: f64 = 2e10;

/// Most poles of a fit by noise alone, and one more for so many lines. Structures have fewer; what departs from the model asks for more
/// without end.
const MOST_BY_NOISE: (usize, usize) = (8, 20);

/// Noise explains the responses where the misfit over the degrees of freedom is below this: of a known variance; of one estimated from
/// few averages, of which three alone double it; of one from differences of neighbouring lines.
const EXPLAINED: (f64, f64, f64) = (1.5, 3.0, 2.0);

/// And where no more than this share of the poles is needless in a variance that holds departures.
const NEEDLESS: f64 = 0.25;

/// The last refinement.
const LAST: Stop = Stop {
    steps: 40,
    fall: 0.0,
    share: 1e-9,
};

/// Finds poles and their structure. Poles may be given to begin `from`: then none is added.
pub(super) fn search(
    lines: &Lines,
    options: &RationalOptions,
    trusted: bool,
    from: Option<&[Pole]>,
) -> Found {
    let given = lines.variance.is_some();
    let noise = match &lines.variance {
        Some(v) => lines.floored(v),
        None => from_differences(lines),
    };
    let by_noise = MOST_BY_NOISE.0 + lines.x.len() / MOST_BY_NOISE.1;
    let rules = Rules {
        most: most_determined(lines, options.most_poles.min(by_noise)),
        order: options.order,
        grows: from.is_none(),
        unstable: options.allow_unstable,
        estimated: !(given && trusted),
        data: lines.data(),
        departs: false,
    };
    let start = Model {
        poles: from.unwrap_or_default().to_vec(),
        delays: match options.delay {
            Delay::None => Vec::new(),
            kind => {
                let problem = lines.shared(&lines.weights(&noise), Structure::FULL);
                delay::start(&problem, kind == Delay::PerResponse)
            }
        },
    };
    let mut effort = Effort::default();
    let mut evidence = Vec::new();
    if let Some(mut found) = by_noise_alone(
        lines,
        rules,
        noise.clone(),
        start.clone(),
        &mut evidence,
        &mut effort,
    ) {
        (found.evidence, found.effort) = (evidence, effort);
        return found;
    }
    evidence.clear();
    let search = Search {
        lines,
        noise: &noise,
        rules: Rules {
            most: most_determined(lines, options.most_poles),
            departs: true,
            ..rules
        },
    };
    let departing = search.run(&start, &mut evidence, &mut effort);
    let mut found = departed(&search, departing);
    (found.evidence, found.effort) = (evidence, effort);
    found
}

/// The fit by noise alone; `None` where that does not explain the responses.
fn by_noise_alone(
    lines: &Lines,
    rules: Rules,
    noise: Vec<Vec<f64>>,
    mut start: Model,
    evidence: &mut Vec<Step>,
    effort: &mut Effort,
) -> Option<Found> {
    let given = lines.variance.is_some();
    let mut variance = noise.clone();
    let mut structure = Structure::FULL;
    for round in 0..=ROUNDS {
        let mut held = grown(lines, rules, structure, &variance, start, evidence, effort)?;
        let mut settled = given || round == ROUNDS;
        if !settled {
            let residual = held.residuals(lines, structure.numerators(), effort);
            let unknown = parameters(structure, &held.fitted, lines.h.len());
            let free = 1.0 - unknown * lines.independence / lines.data();
            let next = from_residuals(lines, &residual, free.max(0.1));
            let ratio = mean_ratio(&next, &variance);
            variance = next;
            settled = (SETTLED.0..SETTLED.1).contains(&ratio);
            if settled {
                held = Held::at(lines, &variance, &held.fitted.model);
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
        all,
        weights,
        fitted,
        ..
    } = grown(lines, rules, structure, &variance, start, evidence, effort)?;
    let numerators = structure.numerators();
    let separate = (!weights.exact).then(|| lines.separate(&weights, &variance, structure));
    let problems = separate.as_deref().unwrap_or(&all);
    let (fitted, covariance) = last(problems, fitted.model, numerators, effort);
    let left: Vec<Matrix> = problems
        .iter()
        .zip(&fitted.fits)
        .map(|(problem, fit)| left(problem, &fitted.model, numerators, fit))
        .collect();
    let dof = (lines.data() - parameters(structure, &fitted, lines.h.len())).max(1.0);
    if !is_explained(lines, rules, &noise, &variance, &fitted, dof) {
        return None;
    }
    let logarithms: f64 = variance.iter().flatten().map(|v| v.ln()).sum();
    let surprise = lines.independence * logarithms + 0.5 * fitted.chi2;
    let mut found = Found {
        chi2: fitted.chi2,
        fitted,
        problems: separate.unwrap_or_else(|| all.to_vec()),
        left,
        covariance,
        by_response: weights.by_response,
        structure,
        estimated: rules.estimated,
        dof,
        evidence: Vec::new(),
        departures: None,
        means: Vec::new(),
        by_hit: false,
        at_limit: false,
        surprise,
        effort: Effort::default(),
    };
    if !lines.hits.is_empty() {
        // Of what noise explains hits still say how far they place the poles apart.
        let full = Held::at(lines, &variance, &found.fitted.model);
        let band = full.band(lines, &variance);
        let departures = vec![Departure::NONE; found.fitted.model.poles.len()];
        found.means = means(&band, &lines.hits, true, &departures, &|p| {
            may_be_mode(lines, p)
        });
        found.by_hit = true;
    }
    Some(found)
}

/// Whether a fit by noise alone is one: the misfit is that of noise, and its poles are needed whatever the responses depart by.
fn is_explained(
    lines: &Lines,
    rules: Rules,
    noise: &[Vec<f64>],
    variance: &[Vec<f64>],
    fitted: &Fitted,
    dof: f64,
) -> bool {
    let full = Held::at(lines, variance, &fitted.model);
    let band = full.band(lines, noise);
    let limit = match (lines.variance.is_some(), rules.estimated) {
        (true, false) => EXPLAINED.0,
        (true, true) => EXPLAINED.1,
        (false, _) => EXPLAINED.2,
    };
    // Differences of lines that go together under a window are less than their noise.
    let has_noise =
        lines.variance.is_none() && (lines.independence == 1.0 || !lines.hits.is_empty());
    let chi2 = match has_noise {
        true => misfit(lines, &band),
        false => fitted.chi2,
    };
    if chi2 > limit * dof {
        return false;
    }
    if rules.order.is_some() {
        return true;
    }
    if fitted.model.poles.len() >= rules.most {
        return false;
    }
    let groups = lines.hits.clone();
    let judge = Judge {
        threshold: Growth::new(&full.all[0], NUMERATORS, rules, 0.0).threshold,
        by_hit: groups.len() >= FEWEST_GROUPS,
        groups: &groups,
    };
    let inside = band.modes.poles.iter().filter(|p| may_be_mode(lines, p));
    let needless = judge.needless(&band, &mut Vec::new()).len() as f64;
    needless <= NEEDLESS * inside.count() as f64
}

/// What a fit leaves over the noise.
fn misfit(lines: &Lines, band: &Band) -> f64 {
    let sum = |(e, v): (&Vec<Complex>, &Vec<f64>)| -> f64 {
        e.iter().zip(v).map(|(e, v)| e.norm_sqr() / v).sum()
    };
    let all: f64 = band.residual.iter().zip(band.noise).map(sum).sum();
    2.0 * lines.independence * all
}

/// A pole of the band that may be a mode.
fn may_be_mode(lines: &Lines, pole: &Pole) -> bool {
    /// Damping ratio from which on a pole is background.
    const BACKGROUND: f64 = 0.3;
    (lines.x[0]..=1.0).contains(&pole.w) && pole.sigma < BACKGROUND * pole.w
}

/// A fit in a variance that holds departures.
fn departed(search: &Search, departing: Departing) -> Found {
    let lines = search.lines;
    let Departing {
        state,
        departures,
        covariance,
    } = departing;
    let groups = search.groups();
    let band = search.band(&state);
    let means = means(&band, &groups, !lines.hits.is_empty(), &departures, &|p| {
        may_be_mode(lines, p)
    });
    let left = left(
        &state.all,
        &state.fitted.model,
        NUMERATORS,
        &state.fitted.fits[0],
    );
    let dof = lines.data() - parameters(Structure::FULL, &state.fitted, lines.h.len());
    let logarithms: f64 = state.variance.iter().flatten().map(|v| v.ln()).sum();
    Found {
        surprise: lines.independence * logarithms + 0.5 * state.fitted.chi2,
        chi2: state.fitted.chi2,
        at_limit: search.rules.order.is_none()
            && state.fitted.model.poles.len() >= search.rules.most,
        fitted: state.fitted,
        problems: vec![state.all],
        left: vec![left],
        covariance,
        by_response: state.weights.by_response,
        structure: Structure::FULL,
        estimated: true,
        dof: dof.max(1.0),
        evidence: Vec::new(),
        departures: Some(departures),
        means,
        by_hit: !lines.hits.is_empty(),
        effort: Effort::default(),
    }
}

impl Found {
    /// The same poles with residues of other responses over the same lines, such as the average of the hits that were searched.
    pub fn of(self, lines: &Lines) -> Found {
        let variance = match &lines.variance {
            Some(v) => lines.floored(v),
            None => vec![vec![1.0; lines.x.len()]; lines.h.len()],
        };
        let weights = lines.weights(&variance);
        let problems = lines.separate(&weights, &variance, self.structure);
        let numerators = self.structure.numerators();
        let fitted = at(&problems, &self.fitted.model, numerators);
        let fits = problems.iter().zip(&fitted.fits);
        let left = fits
            .map(|(problem, fit)| left(problem, &fitted.model, numerators, fit))
            .collect();
        Found {
            fitted,
            problems,
            left,
            by_response: weights.by_response,
            ..self
        }
    }
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
        let left = left(&self.all[0], &fitted.model, numerators, &fitted.fits[0]);
        self.fitted = fitted;
        unweighted(lines, &self.weights, &left)
    }

    /// The fit, of every term, as windows see it.
    fn band<'a>(&self, lines: &'a Lines, noise: &'a [Vec<f64>]) -> Band<'a> {
        let model = &self.fitted.model;
        let left = left(&self.all[0], model, NUMERATORS, &self.fitted.fits[0]);
        Band {
            lines,
            noise,
            modes: Modes {
                poles: model.poles.clone(),
                coefficients: (0..lines.h.len())
                    .map(|i| coefficients(&self.fitted, i, self.weights.by_response[i]))
                    .collect(),
            },
            residual: unweighted(lines, &self.weights, &left),
        }
    }
}

/// Grows at one variance and structure; `None` where more poles than noise alone can ask for do not suffice.
fn grown(
    lines: &Lines,
    rules: Rules,
    structure: Structure,
    variance: &[Vec<f64>],
    model: Model,
    evidence: &mut Vec<Step>,
    effort: &mut Effort,
) -> Option<Held> {
    let numerators = structure.numerators();
    let weights = lines.weights(variance);
    let all = [lines.shared(&weights, structure)];
    let growth = Growth::new(&all[0], numerators, rules, MOST_WORK - effort.work);
    let grown = growth.grown(&model, evidence);
    effort.scans += grown.scans;
    effort.steps += grown.steps;
    effort.work += grown.work;
    let poles = &grown.fitted.model.poles;
    let is_out =
        rules.order.is_none() && (poles.len() >= rules.most || is_crowd(poles, lines.step));
    (effort.work <= MOST_WORK && !is_out).then_some(Held {
        fewer: grown.fewer,
        fitted: grown.fitted,
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
