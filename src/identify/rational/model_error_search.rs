//! Pole search for responses with a model error above the noise: poles are added, tested and refined with a variance that includes the
//! model error of each mode, from a model without poles. The poles of a fit with the noise variance are no suitable initial estimate.

use crate::numeric::{Complex, Matrix};

use super::basis::{ModelTerms, ScaledPole, WhitenedProblem};
use super::covariance::{PoleCovariance, covariance};
use super::line_compression::Compressor;
use super::model_error::{ModeDeviation, PoleResidues, misfit, variance};
use super::pole_significance::{MODEL_ERROR_SHARE, PoleSignificance, is_same};
use super::projection::{ModelFit, PoleModel, StopCriteria, fit_at, refine, residual};
use super::scaled_responses::{ScaledResponses, SeparableWeights};
use super::scatter::{MIN_GROUPS, scatter};
use super::stepwise::{StepwiseOptions, StepwiseSearch, step_work};
use super::windowed::{BandFit, NUMERATORS, coefficients};
use super::{FitEffort, SelectionStep};

/// Maximum half-width, relative to the frequency, over which lines count as one observation during the search, so that a broad background
/// does not mask narrow modes.
const MAX_POLE_WIDTH_LINES: f64 = 0.02;

/// Stop criteria of the refinement after poles are added, after poles are removed, and at the end.
const STEPS_AFTER_ADDED: StopCriteria = StopCriteria {
    steps: 3,
    min_decrease: 1.0,
    min_relative_decrease: 1e-4,
};
const STEPS_AFTER_REMOVED: StopCriteria = StopCriteria {
    steps: 6,
    min_decrease: 0.5,
    min_relative_decrease: 1e-5,
};
const FINAL_STEPS: StopCriteria = StopCriteria {
    steps: 12,
    min_decrease: 0.0,
    min_relative_decrease: 1e-8,
};

/// Maximum number of removal rounds; each round removes redundant poles of separate windows.
const MAX_REMOVAL_ROUNDS: usize = 40;

/// Final iterations of model error and poles.
const MAX_ITERATIONS: usize = 3;

/// Approximate limits of the operations on compressed lines, for adding poles and for the whole search: some seconds of processor time.
/// Beyond the second limit, poles are tested and refined with few steps.
const MAX_WORK: (f64, f64) = (5e10, 7e10);

/// Stop criteria beyond the work limit.
const STEPS_BEYOND_WORK: StopCriteria = StopCriteria {
    steps: 2,
    min_decrease: 1.0,
    min_relative_decrease: 1e-4,
};

/// Input data of the search.
pub(super) struct ModelErrorSearch<'a> {
    /// Lines and responses.
    pub lines: &'a ScaledResponses,
    /// Noise variance by response and line.
    pub noise: &'a [Vec<f64>],
    /// Options of the pole selection.
    pub options: StepwiseOptions,
}

/// Fit with its variance and weights.
pub(super) struct WeightedFit {
    /// Variance by response and line.
    pub variance: Vec<Vec<f64>>,
    /// Separable approximation of the variance.
    pub weights: SeparableWeights,
    /// Problem on all lines, without compression.
    pub raw: WhitenedProblem,
    /// Compressed problem of the fit.
    reduced: WhitenedProblem,
    /// Poles and coefficients.
    pub fit: ModelFit,
}

/// Fit of the search with the model error and covariance of its poles.
pub(super) struct ModelErrorFit {
    /// Weighted fit.
    pub state: WeightedFit,
    /// Departure of each pole from the model.
    pub departures: Vec<ModeDeviation>,
    /// Covariance of the poles under the variance.
    pub covariance: PoleCovariance,
    /// True if the work limit ended the addition of poles.
    pub is_out_of_work: bool,
}

impl ModelErrorSearch<'_> {
    /// Groups of responses whose poles may differ: one per hit, otherwise one per response.
    pub fn groups(&self) -> Vec<Vec<usize>> {
        match self.lines.hits.is_empty() {
            true => (0..self.lines.h.len()).map(|i| vec![i]).collect(),
            false => self.lines.hits.clone(),
        }
    }

    fn by_hit(&self) -> bool {
        !self.lines.hits.is_empty()
    }

    /// Refines a model with a given variance.
    fn state(
        &self,
        variance: Vec<Vec<f64>>,
        model: &PoleModel,
        cancel: StopCriteria,
        effort: &mut FitEffort,
    ) -> WeightedFit {
        let weights = SeparableWeights::mean(&variance);
        let raw = self.lines.shared_problem(&weights, ModelTerms::FULL);
        let compressed = Compressor::new(&raw).compress(model, &[]);
        let reduced = compressed.problem.into_owned();
        let problem = std::slice::from_ref(&reduced);
        let cancel = match effort.work > MAX_WORK.1 {
            true => STEPS_BEYOND_WORK,
            false => cancel,
        };
        let fit = refine(
            problem,
            fit_at(problem, model, NUMERATORS),
            NUMERATORS,
            cancel,
        );
        effort.steps += fit.steps;
        effort.work += fit.steps as f64 * step_work(&reduced, model.poles.len(), NUMERATORS);
        WeightedFit {
            variance,
            weights,
            fit,
            reduced,
            raw,
        }
    }

    fn modes(&self, state: &WeightedFit) -> PoleResidues {
        PoleResidues {
            poles: state.fit.model.poles.clone(),
            coefficients: (0..self.lines.h.len())
                .map(|i| coefficients(&state.fit, i, state.weights.by_response[i]))
                .collect(),
        }
    }

    /// Fit of the whole band, the input of [`PoleWindow`](super::windowed::PoleWindow).
    pub fn band(&self, state: &WeightedFit) -> BandFit<'_> {
        let e = residual(&state.raw, &state.fit.model, NUMERATORS, &state.fit.fits[0]);
        BandFit {
            lines: self.lines,
            noise: self.noise,
            modes: self.modes(state),
            residual: unweighted_residuals(self.lines, &state.weights, &e),
        }
    }

    /// Assumed model error of the poles during the search.
    fn assumed_model_error(&self, state: &WeightedFit) -> Vec<ModeDeviation> {
        let model = &state.fit.model;
        let tau = match self.by_hit() {
            true => scatter(&state.reduced, &state.fit, NUMERATORS, &self.lines.hits),
            false => vec![0.0; model.poles.len()],
        };
        let deviation = |(pole, tau): (&ScaledPole, f64)| ModeDeviation {
            share: MODEL_ERROR_SHARE,
            scatter: tau,
            width: MAX_POLE_WIDTH_LINES * pole.w,
        };
        model.poles.iter().zip(tau).map(deviation).collect()
    }

    fn variance(&self, state: &WeightedFit, departures: &[ModeDeviation]) -> Vec<Vec<f64>> {
        variance(self.lines, 0, self.noise, &self.modes(state), departures)
    }

    /// Updates the variance for the present poles and refines the fit.
    fn iterate_variance(
        &self,
        state: &WeightedFit,
        cancel: StopCriteria,
        effort: &mut FitEffort,
    ) -> WeightedFit {
        let variance = self.variance(state, &self.assumed_model_error(state));
        self.state(variance, &state.fit.model, cancel, effort)
    }

    /// Runs the search: adds, tests and refines poles and estimates their model error.
    pub fn run(
        &self,
        start: &PoleModel,
        evidence: &mut Vec<SelectionStep>,
        effort: &mut FitEffort,
    ) -> ModelErrorFit {
        let first = self.state(self.noise.to_vec(), start, STEPS_AFTER_ADDED, effort);
        let mut state = match start.poles.is_empty() {
            true => first,
            false => self.iterate_variance(&first, STEPS_AFTER_REMOVED, effort),
        };
        let initial_work = effort.work;
        state = self.grow(state, evidence, effort);
        let is_out_of_work = effort.work - initial_work > MAX_WORK.0;
        if self.options.fixed_pole_count.is_some() {
            return self.finish(state, effort);
        }
        state = self.remove_redundant(state, effort);
        let mut result = ModelErrorFit {
            is_out_of_work,
            ..self.finish(state, effort)
        };
        // The scatter between hits shifts poles, which may make others redundant.
        while self.by_hit() && effort.work < MAX_WORK.1 {
            let count = result.state.fit.model.poles.len();
            let tested = self.remove_redundant(result.state, effort);
            if tested.fit.model.poles.len() == count {
                return ModelErrorFit {
                    state: tested,
                    ..result
                };
            }
            result = ModelErrorFit {
                is_out_of_work,
                ..self.finish(tested, effort)
            };
        }
        result
    }

    /// Fits given poles without adding or removing any.
    pub fn refit(&self, poles: &[ScaledPole], effort: &mut FitEffort) -> ModelErrorFit {
        let model = PoleModel {
            poles: poles.to_vec(),
            delays: Vec::new(),
        };
        let first = self.state(self.noise.to_vec(), &model, STEPS_AFTER_ADDED, effort);
        self.finish(
            self.iterate_variance(&first, STEPS_AFTER_REMOVED, effort),
            effort,
        )
    }

    fn grow(
        &self,
        mut state: WeightedFit,
        evidence: &mut Vec<SelectionStep>,
        effort: &mut FitEffort,
    ) -> WeightedFit {
        let mut rejected = Vec::new();
        let initial_work = effort.work;
        loop {
            let options = StepwiseOptions {
                max_work: MAX_WORK.0 - (effort.work - initial_work),
                ..self.options
            };
            let mut search = StepwiseSearch::new(&state.raw, NUMERATORS, options);
            search.rejected = std::mem::take(&mut rejected);
            let (round, is_more) = search.add_round(&state.fit.model, evidence);
            effort.scans += round.scans;
            effort.steps += round.steps;
            effort.work += round.work;
            rejected = round.rejected;
            let count = state.fit.model.poles.len();
            let changed = is_more || round.fit.model.poles.len() != count;
            if changed {
                state.reduced = round.compressed.unwrap_or_else(|| state.raw.clone());
                state.fit = round.fit;
                state = self.iterate_variance(&state, STEPS_AFTER_ADDED, effort);
            }
            if !is_more {
                return state;
            }
        }
    }

    fn remove_redundant(&self, mut state: WeightedFit, effort: &mut FitEffort) -> WeightedFit {
        let groups = self.groups();
        let criteria = PoleSignificance {
            threshold: StepwiseSearch::new(&state.raw, NUMERATORS, self.options).threshold,
            groups: &groups,
            by_hit: self.by_hit() && groups.len() >= MIN_GROUPS,
        };
        let mut needed = Vec::new();
        let (mut is_last, mut is_unchanged) = (false, true);
        for _ in 0..MAX_REMOVAL_ROUNDS {
            let redundant = criteria.redundant(&self.band(&state), &mut needed);
            if redundant.is_empty() {
                if is_last || is_unchanged {
                    break;
                }
                // Tests all poles once more with the refined model.
                is_last = true;
                needed.clear();
                continue;
            }
            is_unchanged = false;
            let mut model = state.fit.model.clone();
            for pole in &redundant {
                let is_neighbour =
                    |p: &ScaledPole| pole.others.iter().any(|o| is_same(p, &model.poles[o.0]));
                needed.retain(|p: &ScaledPole| !is_neighbour(p));
            }
            for &(r, pole) in redundant.iter().flat_map(|n| &n.others) {
                model.poles[r] = pole;
            }
            let removed: Vec<usize> = redundant.iter().map(|n| n.pole).collect();
            let mut indices = 0..model.poles.len();
            model
                .poles
                .retain(|_| indices.next().is_some_and(|r| !removed.contains(&r)));
            state = self.state(state.variance, &model, STEPS_AFTER_ADDED, effort);
            state = self.iterate_variance(
                &self.iterate_variance(&state, STEPS_AFTER_REMOVED, effort),
                STEPS_AFTER_REMOVED,
                effort,
            );
        }
        state
    }

    /// Estimates the model error, refines the poles with it, and computes their covariance.
    fn finish(&self, mut state: WeightedFit, effort: &mut FitEffort) -> ModelErrorFit {
        let groups = self.groups();
        let mut departures = Vec::new();
        for _ in 0..MAX_ITERATIONS {
            departures = self.estimate_model_error(&state, &groups);
            let variance = self.variance(&state, &departures);
            let model = state.fit.model.clone();
            state = self.state(variance, &model, FINAL_STEPS, effort);
        }
        let covariance = covariance(std::slice::from_ref(&state.reduced), &state.fit, NUMERATORS);
        ModelErrorFit {
            state,
            departures,
            covariance,
            is_out_of_work: false,
        }
    }

    /// Estimates the model error of each mode.
    pub fn estimate_model_error(
        &self,
        state: &WeightedFit,
        groups: &[Vec<usize>],
    ) -> Vec<ModeDeviation> {
        let band = self.band(state);
        let responses: Vec<usize> = (0..self.lines.h.len()).collect();
        let tau = scatter(&state.reduced, &state.fit, NUMERATORS, groups);
        (0..band.modes.poles.len())
            .map(|r| ModeDeviation {
                share: misfit(
                    self.lines,
                    0,
                    &responses,
                    &band.residual,
                    self.noise,
                    &band.modes,
                    r,
                ),
                scatter: tau[r],
                width: band.modes.poles[r].sigma,
            })
            .collect()
    }
}

/// Converts whitened residuals to residuals of the scaled responses.
pub(super) fn unweighted_residuals(
    lines: &ScaledResponses,
    weights: &SeparableWeights,
    whitened: &Matrix,
) -> Vec<Vec<Complex>> {
    let n = lines.x.len();
    let scale = |i: usize, k: usize| {
        let variance = weights.by_response[i] * weights.by_line[k];
        (variance / 2.0 / lines.independence).sqrt()
    };
    (0..lines.h.len())
        .map(|i| {
            let column = whitened.col_as_slice(i);
            (0..n)
                .map(|k| Complex::new(column[k], column[n + k]) * scale(i, k))
                .collect()
        })
        .collect()
}
