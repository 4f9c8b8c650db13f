//! Driver of the rational fit: variance estimate, stepwise selection, term selection, last refinement.

use crate::numeric::{Complex, Matrix};

use super::basis::{ModelTerms, ScaledPole, WhitenedProblem};
use super::covariance::{PoleCovariance, covariance};
use super::groups::{GroupMean, means};
use super::line_compression::{CompressedProblem, Compressor, MAX_RECOMPRESSIONS};
use super::model_error::{self, ModeDeviation, PoleResidues};
use super::model_error_search::{ModelErrorFit, ModelErrorSearch, unweighted_residuals};
use super::pole_significance::PoleSignificance;
use super::projection::{ModelFit, PoleModel, StopCriteria, fit_at, refine, residual};
use super::scaled_responses::{ScaledResponses, SeparableWeights};
use super::scatter::MIN_GROUPS;
use super::stepwise::{StepwiseOptions, StepwiseSearch, is_crowd};
use super::term_selection::{parameter_count, select_terms};
use super::variance::{from_differences, from_residuals, mean_ratio};
use super::windowed::{BandFit, NUMERATORS, coefficients};
use super::{DelayModel, FitEffort, RationalOptions, SelectionStep, delay};

/// Result of a search.
pub(super) struct SearchResult {
    /// The last fit, with one set of coefficients per problem.
    pub fit: ModelFit,
    /// All lines, for each set.
    pub problems: Vec<WhitenedProblem>,
    /// Residuals of the fit on all lines.
    pub residuals: Vec<Matrix>,
    /// Covariance of the poles and delays, if the variance is right.
    pub covariance: PoleCovariance,
    /// Weights of the responses in them.
    pub by_response: Vec<f64>,
    /// Terms of the fit.
    pub structure: ModelTerms,
    /// The variance was not given, or is itself an estimate.
    pub estimated: bool,
    /// Weighted misfit of the lines that were searched.
    pub chi2: f64,
    /// Data less parameters.
    pub dof: f64,
    /// Selection steps tried.
    pub evidence: Vec<SelectionStep>,
    /// Departure of each pole from the model, where noise alone does not explain the responses.
    pub departures: Option<Vec<ModeDeviation>>,
    /// Mean of each pole over the separate estimates of hits, or responses.
    pub means: Vec<Option<GroupMean>>,
    /// Residual of the average of the hits at each pole, as [`ModeDeviation::share`]: what all hits depart by alike, which no number of them
    /// averages out. Empty without hits, or where noise explains the responses.
    pub common_departures: Vec<f64>,
    /// Whether the residues of each pole repeat from hit to hit; empty without hits.
    pub repeats: Vec<bool>,
    /// Groups of these means are hits.
    pub by_hit: bool,
    /// The most poles allowed, or the work, were used up.
    pub at_limit: bool,
    /// `Σ ln v + |r|²/v` over all values, by independent lines: the negative logarithm of the likelihood.
    pub negative_log_likelihood: f64,
    /// Computational effort.
    pub effort: FitEffort,
}

/// Most estimates of the variance, and the ratio of one to the last within which they have settled.
const MAX_ITERATIONS: usize = 6;
const VARIANCE_RATIO_RANGE: (f64, f64) = (0.8, 1.1);

/// Before the variance is estimated from residuals, poles are refined until a step gains less than this share.
const STEPS_BEFORE_VARIANCE: StopCriteria = StopCriteria {
    steps: 20,
    min_decrease: 1e-3,
    min_relative_decrease: 1e-3,
};

/// Approximate operations of the joint selection for each pair of responses, after which noise alone is taken not to explain the responses:
/// several times what ten modes in ten thousand lines of six responses take; and further operations where it explains windows of them.
const MAX_WORK: f64 = 2e10;
const MAX_DENSE_WORK: f64 = 2e11;

/// Pairs of responses, at least one.
fn response_pairs(lines: &ScaledResponses) -> f64 {
    (0.5 * lines.h.len() as f64).max(1.0)
}

/// Most poles of a fit by noise alone, and one more for so many lines. Structures have fewer; what departs from the model asks for more
/// without end.
const MAX_BY_NOISE: (usize, usize) = (8, 20);

/// Noise explains the responses where the misfit over the degrees of freedom is below this: of a known variance; of one estimated from
/// few averages, of which three alone double it; of one from differences of neighbouring lines.
const MAX_NOISE_MISFIT: (f64, f64, f64) = (1.5, 3.0, 2.0);

/// And where no more than this share of the poles is needless in a variance that holds departures; none of those of the average of hits,
/// which has fewer responses for a pole too many to show in.
const MAX_REDUNDANT_SHARE: f64 = 0.25;

/// The last refinement.
const STOP_FINAL: StopCriteria = StopCriteria {
    steps: 40,
    min_decrease: 0.0,
    min_relative_decrease: 1e-9,
};

/// Finds poles and their structure. Poles may be given to begin `from`: then none is added. Of responses hit by hit, poles that noise
/// alone explains are sought in their `average`.
pub(super) fn search(
    lines: &ScaledResponses,
    average: Option<&ScaledResponses>,
    options: &RationalOptions,
    trusted: bool,
    from: Option<&[ScaledPole]>,
) -> SearchResult {
    let noise = noise_variance(lines);
    let rules = stepwise_options(lines, options, trusted, from.is_none());
    let start = PoleModel {
        poles: from.unwrap_or_default().to_vec(),
        delays: match options.delay {
            DelayModel::None => Vec::new(),
            kind => {
                let problem = lines.shared_problem(&lines.weights(&noise), ModelTerms::FULL);
                delay::initial_delay(&problem, kind == DelayModel::PerResponse)
            }
        },
    };
    let mut effort = FitEffort::default();
    let mut evidence = Vec::new();
    if let Some(mut result) = fit_noise_only(
        (lines, average.unwrap_or(lines)),
        rules,
        &noise,
        start.clone(),
        &mut evidence,
        &mut effort,
    ) {
        (result.evidence, result.effort) = (evidence, effort);
        return result;
    }
    evidence.clear();
    effort.work = (effort.work / response_pairs(average.unwrap_or(lines))).min(MAX_WORK);
    let search = model_error_search(lines, &noise, rules, options);
    let departing = search.run(&start, &mut evidence, &mut effort);
    let mut result = fit_with_model_error(&search, departing);
    (result.evidence, result.effort) = (evidence, effort);
    result
}

/// Refines poles that responses depart from, none added or judged.
pub(super) fn refit_with_model_error(
    lines: &ScaledResponses,
    options: &RationalOptions,
    trusted: bool,
    poles: &[ScaledPole],
    effort: &mut FitEffort,
) -> SearchResult {
    let noise = noise_variance(lines);
    let rules = stepwise_options(lines, options, trusted, false);
    let search = model_error_search(lines, &noise, rules, options);
    let departing = search.refit(poles, effort);
    fit_with_model_error(&search, departing)
}

/// The variance that is given, or that of differences of neighbouring lines.
fn noise_variance(lines: &ScaledResponses) -> Vec<Vec<f64>> {
    match &lines.variance {
        Some(v) => lines.with_variance_floor(v),
        None => from_differences(lines),
    }
}

/// Rules of a fit by noise alone.
fn stepwise_options(
    lines: &ScaledResponses,
    options: &RationalOptions,
    trusted: bool,
    add_poles: bool,
) -> StepwiseOptions {
    let by_noise = MAX_BY_NOISE.0 + lines.x.len() / MAX_BY_NOISE.1;
    StepwiseOptions {
        max_poles: max_determined_poles(lines, by_noise),
        fixed_pole_count: options.order,
        add_poles,
        unstable: options.allow_unstable,
        estimated: !(lines.variance.is_some() && trusted),
        data_count: lines.data_count(),
        departs: false,
        max_work: f64::INFINITY,
        dense_work: 0.0,
    }
}

fn model_error_search<'a>(
    lines: &'a ScaledResponses,
    noise: &'a [Vec<f64>],
    rules: StepwiseOptions,
    options: &RationalOptions,
) -> ModelErrorSearch<'a> {
    ModelErrorSearch {
        lines,
        noise,
        options: StepwiseOptions {
            max_poles: max_determined_poles(lines, options.max_poles),
            departs: true,
            ..rules
        },
    }
}

/// The fit by noise alone; `None` where that does not explain the responses. `average` is what poles are sought in.
fn fit_noise_only(
    (lines, average): (&ScaledResponses, &ScaledResponses),
    options: StepwiseOptions,
    noise: &[Vec<f64>],
    start: PoleModel,
    evidence: &mut Vec<SelectionStep>,
    effort: &mut FitEffort,
) -> Option<SearchResult> {
    let sought = StepwiseOptions {
        data_count: average.data_count(),
        ..options
    };
    let first = match lines.hits.is_empty() {
        true => noise.to_vec(),
        false => from_differences(average),
    };
    let (found, structure, variance) =
        search_by_noise(average, sought, first, start, evidence, effort)?;
    // Noise of the force inside its window turns the phases of neighbouring lines alike: by less than the choice of terms detects, and more
    // than the interval of a frequency whose phase is fixed.
    let structure = ModelTerms {
        complex: structure.complex || !lines.hits.is_empty(),
        ..structure
    };
    let model = found.fit.model;
    let (weights, variance) = match lines.hits.is_empty() {
        true => (found.weights, variance),
        false => {
            // Every hit has a variance of its own about the poles of the average.
            let own = FullFit::fit_full(lines, noise, &model);
            let free = remaining_share(lines, ModelTerms::FULL, &own.fit);
            let variance = from_residuals(lines, &own.band(lines, noise).residual, free);
            (lines.weights(&variance), variance)
        }
    };
    let all = [lines.shared_problem(&weights, structure)];
    let numerators = structure.numerators();
    let separate =
        (!weights.exact).then(|| lines.separate_problems(&weights, &variance, structure));
    let problems = separate.as_deref().unwrap_or(&all);
    let (fitted, covariance) = final_refinement(problems, model, numerators, effort);
    let left: Vec<Matrix> = problems
        .iter()
        .zip(&fitted.fits)
        .map(|(problem, fit)| residual(problem, &fitted.model, numerators, fit))
        .collect();
    let dof = (lines.data_count() - parameter_count(structure, &fitted, lines.h.len())).max(1.0);
    let full = FullFit::fit_full(lines, &variance, &fitted.model);
    if !is_explained(lines, options, &full, noise, fitted.chi2, dof) {
        return None;
    }
    let logarithms: f64 = variance.iter().flatten().map(|v| v.ln()).sum();
    let surprise = lines.independence * logarithms + 0.5 * fitted.chi2;
    let mut result = SearchResult {
        chi2: fitted.chi2,
        fit: fitted,
        problems: separate.unwrap_or_else(|| all.to_vec()),
        residuals: left,
        covariance,
        by_response: weights.by_response,
        structure,
        estimated: options.estimated,
        dof,
        evidence: Vec::new(),
        departures: None,
        means: Vec::new(),
        common_departures: Vec::new(),
        repeats: Vec::new(),
        by_hit: false,
        at_limit: false,
        negative_log_likelihood: surprise,
        effort: FitEffort::default(),
    };
    if !lines.hits.is_empty() {
        // Of what noise explains hits still say how far they place the poles apart.
        let band = full.band(lines, &variance);
        let departures = vec![ModeDeviation::NONE; result.fit.model.poles.len()];
        result.means = means(&band, &lines.hits, true, &departures, &|p| {
            lines.may_be_mode(p)
        });
        result.by_hit = true;
    }
    Some(result)
}

/// Share of the data that the parameters of a fit leave.
fn remaining_share(lines: &ScaledResponses, structure: ModelTerms, fit: &ModelFit) -> f64 {
    let unknown = parameter_count(structure, fit, lines.h.len());
    (1.0 - unknown * lines.independence / lines.data_count()).max(0.1)
}

/// Poles and terms that noise alone asks for, with the variance of the noise; `None` where it asks for more without end.
fn search_by_noise(
    lines: &ScaledResponses,
    options: StepwiseOptions,
    mut variance: Vec<Vec<f64>>,
    mut start: PoleModel,
    evidence: &mut Vec<SelectionStep>,
    effort: &mut FitEffort,
) -> Option<(FullFit, ModelTerms, Vec<Vec<f64>>)> {
    let given = lines.variance.is_some();
    let mut options = StepwiseOptions {
        max_work: MAX_WORK * response_pairs(lines),
        dense_work: MAX_DENSE_WORK * response_pairs(lines),
        ..options
    };
    let mut structure = ModelTerms::FULL;
    for round in 0..=MAX_ITERATIONS {
        let mut model = select_poles(
            lines,
            &mut options,
            structure,
            &variance,
            start,
            evidence,
            effort,
        )?;
        let mut settled = given || round == MAX_ITERATIONS;
        if !settled {
            let residual = model.residuals(lines, structure.numerators(), effort);
            let free = remaining_share(lines, structure, &model.fit);
            let next = from_residuals(lines, &residual, free);
            let ratio = mean_ratio(&next, &variance);
            variance = next;
            settled = (VARIANCE_RATIO_RANGE.0..VARIANCE_RATIO_RANGE.1).contains(&ratio);
            if settled {
                model = FullFit::fit_full(lines, &variance, &model.fit.model);
            }
        }
        start = model.fit.model.clone();
        if settled {
            let (chosen, better, steps) =
                select_terms(model.lines(), lines.data_count(), &model.fit);
            structure = chosen;
            start = better.model;
            effort.steps += steps;
            break;
        }
    }
    let model = select_poles(
        lines,
        &mut options,
        structure,
        &variance,
        start,
        evidence,
        effort,
    )?;
    Some((model, structure, variance))
}

/// Whether a fit by noise alone is one: the misfit is that of noise, and its poles are needed whatever the responses depart by.
fn is_explained(
    lines: &ScaledResponses,
    options: StepwiseOptions,
    full: &FullFit,
    noise: &[Vec<f64>],
    chi2: f64,
    dof: f64,
) -> bool {
    let band = full.band(lines, noise);
    let limit = match (lines.variance.is_some(), options.estimated) {
        (true, false) => MAX_NOISE_MISFIT.0,
        (true, true) => MAX_NOISE_MISFIT.1,
        (false, _) => MAX_NOISE_MISFIT.2,
    };
    // Differences of lines that go together under a window are less than their noise.
    let has_noise =
        lines.variance.is_none() && (lines.independence == 1.0 || !lines.hits.is_empty());
    let chi2 = match has_noise {
        true => misfit(lines, &band),
        false => chi2,
    };
    if chi2 > limit * dof {
        return false;
    }
    if options.fixed_pole_count.is_some() {
        return true;
    }
    if full.fit.model.poles.len() >= options.max_poles {
        return false;
    }
    let groups = lines.hits.clone();
    let judge = PoleSignificance {
        threshold: StepwiseSearch::new(&full.all[0], NUMERATORS, options).threshold,
        by_hit: groups.len() >= MIN_GROUPS,
        groups: &groups,
    };
    let inside = band.modes.poles.iter().filter(|p| lines.may_be_mode(p));
    let needless = judge.redundant(&band, &mut Vec::new()).len() as f64;
    let most = match groups.is_empty() {
        true => MAX_REDUNDANT_SHARE,
        false => 0.0,
    };
    needless <= most * inside.count() as f64
}

/// Residual power of a fit over the noise.
fn misfit(lines: &ScaledResponses, band: &BandFit) -> f64 {
    let sum = |(e, v): (&Vec<Complex>, &Vec<f64>)| -> f64 {
        e.iter().zip(v).map(|(e, v)| e.norm_sqr() / v).sum()
    };
    let all: f64 = band.residual.iter().zip(band.noise).map(sum).sum();
    2.0 * lines.independence * all
}

/// A fit in a variance that holds departures.
fn fit_with_model_error(search: &ModelErrorSearch, departing: ModelErrorFit) -> SearchResult {
    let lines = search.lines;
    let ModelErrorFit {
        state,
        departures,
        covariance,
        is_out_of_work,
    } = departing;
    let groups = search.groups();
    let band = search.band(&state);
    let means = means(&band, &groups, !lines.hits.is_empty(), &departures, &|p| {
        lines.may_be_mode(p)
    });
    let left = residual(&state.raw, &state.fit.model, NUMERATORS, &state.fit.fits[0]);
    let dof = lines.data_count() - parameter_count(ModelTerms::FULL, &state.fit, lines.h.len());
    let logarithms: f64 = state.variance.iter().flatten().map(|v| v.ln()).sum();
    SearchResult {
        negative_log_likelihood: lines.independence * logarithms + 0.5 * state.fit.chi2,
        chi2: state.fit.chi2,
        at_limit: search.options.fixed_pole_count.is_none()
            && (is_out_of_work || state.fit.model.poles.len() >= search.options.max_poles),
        fit: state.fit,
        problems: vec![state.raw],
        residuals: vec![left],
        covariance,
        by_response: state.weights.by_response,
        structure: ModelTerms::FULL,
        estimated: true,
        dof: dof.max(1.0),
        evidence: Vec::new(),
        departures: Some(departures),
        means,
        common_departures: Vec::new(),
        repeats: Vec::new(),
        by_hit: !lines.hits.is_empty(),
        effort: FitEffort::default(),
    }
}

impl SearchResult {
    /// The same poles with residues of other responses over the same lines, such as the average of the hits that were searched.
    pub fn fit_responses(self, lines: &ScaledResponses) -> SearchResult {
        let variance = match &lines.variance {
            Some(v) => lines.with_variance_floor(v),
            None => vec![vec![1.0; lines.x.len()]; lines.h.len()],
        };
        let weights = lines.weights(&variance);
        let problems = lines.separate_problems(&weights, &variance, self.structure);
        let numerators = self.structure.numerators();
        let fitted = fit_at(&problems, &self.fit.model, numerators);
        let fits = problems.iter().zip(&fitted.fits);
        let left = fits
            .map(|(problem, fit)| residual(problem, &fitted.model, numerators, fit))
            .collect();
        let common_departures = match self.departures.is_some() {
            true => common_departures(lines, &variance, &weights, &fitted.model),
            false => Vec::new(),
        };
        SearchResult {
            common_departures,
            fit: fitted,
            problems,
            residuals: left,
            by_response: weights.by_response,
            ..self
        }
    }
}

/// Residual of responses at each pole beyond their noise, as a share of the pole's own value.
fn common_departures(
    lines: &ScaledResponses,
    noise: &[Vec<f64>],
    weights: &SeparableWeights,
    model: &PoleModel,
) -> Vec<f64> {
    let problem = [lines.shared_problem(weights, ModelTerms::FULL)];
    let fit = fit_at(&problem, model, NUMERATORS);
    let left = residual(&problem[0], model, NUMERATORS, &fit.fits[0]);
    let left = unweighted_residuals(lines, weights, &left);
    let modes = PoleResidues {
        poles: model.poles.clone(),
        coefficients: (0..lines.h.len())
            .map(|i| coefficients(&fit, i, weights.by_response[i]))
            .collect(),
    };
    let all: Vec<usize> = (0..lines.h.len()).collect();
    (0..modes.poles.len())
        .map(|r| model_error::misfit(lines, 0, &all, &left, noise, &modes, r))
        .collect()
}

/// A fit with all lines, those it was made on, and their weights.
struct FullFit {
    all: [WhitenedProblem; 1],
    /// `None` for all.
    fewer: Option<WhitenedProblem>,
    weights: SeparableWeights,
    fit: ModelFit,
}

impl FullFit {
    /// Fits every term at a fixed pole model.
    fn fit_full(lines: &ScaledResponses, variance: &[Vec<f64>], model: &PoleModel) -> FullFit {
        let weights = lines.weights(variance);
        let all = [lines.shared_problem(&weights, ModelTerms::FULL)];
        let enough = Compressor::new(&all[0]).compress(model, &[]);
        let fewer = (!enough.is_uncompressed()).then(|| enough.problem.into_owned());
        let problem = fewer.as_ref().unwrap_or(&all[0]);
        let fit = fit_at(&[problem], model, ModelTerms::FULL.numerators());
        FullFit {
            all,
            fewer,
            weights,
            fit,
        }
    }

    /// Those the fit was made on.
    fn lines(&self) -> &WhitenedProblem {
        self.fewer.as_ref().unwrap_or(&self.all[0])
    }

    /// Residuals of the scaled responses once the poles are near enough to their place for an estimate of the variance.
    fn residuals(
        &mut self,
        lines: &ScaledResponses,
        numerators: usize,
        effort: &mut FitEffort,
    ) -> Vec<Vec<Complex>> {
        let problem = std::slice::from_ref(self.lines());
        let fit = refine(problem, self.fit.clone(), numerators, STEPS_BEFORE_VARIANCE);
        effort.steps += fit.steps;
        effort.rounds += 1;
        let left = residual(&self.all[0], &fit.model, numerators, &fit.fits[0]);
        self.fit = fit;
        unweighted_residuals(lines, &self.weights, &left)
    }

    /// The fit, of every term, as windows see it.
    fn band<'a>(&self, lines: &'a ScaledResponses, noise: &'a [Vec<f64>]) -> BandFit<'a> {
        let model = &self.fit.model;
        let left = residual(&self.all[0], model, NUMERATORS, &self.fit.fits[0]);
        BandFit {
            lines,
            noise,
            modes: PoleResidues {
                poles: model.poles.clone(),
                coefficients: (0..lines.h.len())
                    .map(|i| coefficients(&self.fit, i, self.weights.by_response[i]))
                    .collect(),
            },
            residual: unweighted_residuals(lines, &self.weights, &left),
        }
    }
}

/// Grows at one variance and structure; `None` where more poles than noise alone can ask for do not suffice.
fn select_poles(
    lines: &ScaledResponses,
    options: &mut StepwiseOptions,
    structure: ModelTerms,
    variance: &[Vec<f64>],
    model: PoleModel,
    evidence: &mut Vec<SelectionStep>,
    effort: &mut FitEffort,
) -> Option<FullFit> {
    let numerators = structure.numerators();
    let weights = lines.weights(variance);
    let all = [lines.shared_problem(&weights, structure)];
    let mut grow = |model: &PoleModel, options: &mut StepwiseOptions| {
        let growth = StepwiseSearch::new(&all[0], numerators, *options);
        let grown = growth.run(model, evidence);
        effort.scans += grown.scans;
        effort.steps += grown.steps;
        effort.work += grown.work;
        options.max_work -= grown.work;
        grown
    };
    let mut grown = grow(&model, options);
    if options.max_work < 0.0 && options.dense_work > 0.0 {
        let dense = StepwiseOptions {
            max_work: options.dense_work,
            dense_work: 0.0,
            ..*options
        };
        let found = &grown.fit.model;
        if StepwiseSearch::new(&all[0], numerators, dense).noise_explains_windows(found) {
            *options = dense;
            grown = grow(found, options);
        }
    }
    let poles = &grown.fit.model.poles;
    let is_out = options.fixed_pole_count.is_none()
        && (poles.len() >= options.max_poles || is_crowd(poles, lines.step));
    (options.max_work >= 0.0 && !is_out).then_some(FullFit {
        fewer: grown.compressed,
        fit: grown.fit,
        all,
        weights,
    })
}

/// The last refinement, and the covariance there.
fn final_refinement(
    problems: &[WhitenedProblem],
    mut model: PoleModel,
    numerators: usize,
    effort: &mut FitEffort,
) -> (ModelFit, PoleCovariance) {
    let mut condensers: Vec<Compressor> = problems.iter().map(Compressor::new).collect();
    let mut round = 0;
    loop {
        let enough: Vec<CompressedProblem> = (condensers.iter_mut())
            .map(|c| c.compress(&model, &[]))
            .collect();
        let start = fit_at(&enough, &model, numerators);
        let fit = refine(&enough, start, numerators, STOP_FINAL);
        effort.steps += fit.steps;
        round += 1;
        let served = enough.iter().all(|e| e.is_valid_for(&fit.model.poles));
        if served || round == MAX_RECOMPRESSIONS {
            let certain = covariance(&enough, &fit, numerators);
            return (fit, certain);
        }
        model = fit.model;
    }
}

/// Pole pairs whose parameters stay below half of the data, and at most `max_poles`.
pub(super) fn max_determined_poles(lines: &ScaledResponses, most: usize) -> usize {
    let (n, no) = (lines.x.len(), lines.h.len());
    // per pole pair two numbers per response and the pole itself; two residual terms per response
    let determined = (n * no).saturating_sub(2 * no) / (2 * no + 2);
    most.min(determined.max(1))
}
