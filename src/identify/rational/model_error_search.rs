//! Responses that depart from the model by more than their noise: poles are sought, judged and refined in a variance that holds what
//! each mode departs by, from no pole on. The poles of a fit by noise alone are no start: they are in each other's place.

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

/// While poles are sought, lines across no more than this share of the frequency count as one: a broad background must not hide
/// narrow modes.
const MAX_POLE_WIDTH_LINES: f64 = 0.02;

/// Steps of all poles after one was added, while they are judged, and at the end.
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

/// Most rounds of the judge, in each of which poles far apart are taken out together.
const MAX_REMOVAL_ROUNDS: usize = 40;

/// Rounds of departures and poles at the end.
const MAX_ITERATIONS: usize = 3;

/// Operations of the growth, and of the whole search, about, on condensed lines: some seconds of a processor. Beyond the second, poles are
/// judged and refined with few steps.
const MAX_WORK: (f64, f64) = (5e10, 7e10);

/// The steps of those.
const STEPS_BEYOND_WORK: StopCriteria = StopCriteria {
    steps: 2,
    min_decrease: 1.0,
    min_relative_decrease: 1e-4,
};

/// Input data of the search.
pub(super) struct ModelErrorSearch<'a> {
    /// Lines and responses.
    pub lines: &'a ScaledResponses,
    /// Variance of the noise alone.
    pub noise: &'a [Vec<f64>],
    /// Options of the pole selection.
    pub options: StepwiseOptions,
}

/// A fit under a variance of its own.
pub(super) struct WeightedFit {
    /// The variance.
    pub variance: Vec<Vec<f64>>,
    /// As weights.
    pub weights: SeparableWeights,
    /// All lines.
    pub all: WhitenedProblem,
    /// The lines that the fit was made on.
    fewer: WhitenedProblem,
    /// Poles and coefficients.
    pub fit: ModelFit,
}

/// Result of the search.
pub(super) struct ModelErrorFit {
    /// The fit.
    pub state: WeightedFit,
    /// Departure of each pole from the model.
    pub departures: Vec<ModeDeviation>,
    /// Covariance of the poles under the variance.
    pub covariance: PoleCovariance,
    /// The growth ended at the work allowed.
    pub is_out_of_work: bool,
}

impl ModelErrorSearch<'_> {
    /// Responses that may differ about a pole: by hit, else each alone.
    pub fn groups(&self) -> Vec<Vec<usize>> {
        match self.lines.hits.is_empty() {
            true => (0..self.lines.h.len()).map(|i| vec![i]).collect(),
            false => self.lines.hits.clone(),
        }
    }

    fn by_hit(&self) -> bool {
        !self.lines.hits.is_empty()
    }

    /// A model brought to its place under a variance.
    fn state(
        &self,
        variance: Vec<Vec<f64>>,
        model: &PoleModel,
        cancel: StopCriteria,
        effort: &mut FitEffort,
    ) -> WeightedFit {
        let weights = SeparableWeights::mean(&variance);
        let all = self.lines.shared_problem(&weights, ModelTerms::FULL);
        let enough = Compressor::new(&all).compress(model, &[]);
        let fewer = enough.problem.into_owned();
        let problem = std::slice::from_ref(&fewer);
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
        effort.work += fit.steps as f64 * step_work(&fewer, model.poles.len(), NUMERATORS);
        WeightedFit {
            variance,
            weights,
            fit,
            fewer,
            all,
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

    /// The fit as windows see it.
    pub fn band(&self, state: &WeightedFit) -> BandFit<'_> {
        let e = residual(&state.all, &state.fit.model, NUMERATORS, &state.fit.fits[0]);
        BandFit {
            lines: self.lines,
            noise: self.noise,
            modes: self.modes(state),
            residual: unweighted_residuals(self.lines, &state.weights, &e),
        }
    }

    /// Departures while poles are sought.
    fn assumed_model_error(&self, state: &WeightedFit) -> Vec<ModeDeviation> {
        let model = &state.fit.model;
        let tau = match self.by_hit() {
            true => scatter(&state.fewer, &state.fit, NUMERATORS, &self.lines.hits),
            false => vec![0.0; model.poles.len()],
        };
        let of = |(pole, tau): (&ScaledPole, f64)| ModeDeviation {
            share: MODEL_ERROR_SHARE,
            scatter: tau,
            width: MAX_POLE_WIDTH_LINES * pole.w,
        };
        model.poles.iter().zip(tau).map(of).collect()
    }

    fn variance(&self, state: &WeightedFit, departures: &[ModeDeviation]) -> Vec<Vec<f64>> {
        variance(self.lines, 0, self.noise, &self.modes(state), departures)
    }

    /// The fit once its variance has followed its poles.
    fn iterate_variance(
        &self,
        state: &WeightedFit,
        cancel: StopCriteria,
        effort: &mut FitEffort,
    ) -> WeightedFit {
        let variance = self.variance(state, &self.assumed_model_error(state));
        self.state(variance, &state.fit.model, cancel, effort)
    }

    /// Poles, judged and refined, with what they depart by.
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
        let before = effort.work;
        state = self.grow(state, evidence, effort);
        let is_out_of_work = effort.work - before > MAX_WORK.0;
        if self.options.fixed_pole_count.is_some() {
            return self.finish(state, effort);
        }
        state = self.judge(state, effort);
        let mut found = ModelErrorFit {
            is_out_of_work,
            ..self.finish(state, effort)
        };
        // Under the departures that hits show poles move, some of them into the place of another.
        while self.by_hit() && effort.work < MAX_WORK.1 {
            let count = found.state.fit.model.poles.len();
            let judged = self.judge(found.state, effort);
            if judged.fit.model.poles.len() == count {
                return ModelErrorFit {
                    state: judged,
                    ..found
                };
            }
            found = ModelErrorFit {
                is_out_of_work,
                ..self.finish(judged, effort)
            };
        }
        found
    }

    /// The fit with the given poles, none added or judged.
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
        let mut refused = Vec::new();
        let already = effort.work;
        loop {
            let allowed = MAX_WORK.0 - (effort.work - already);
            let mut growth = StepwiseSearch::new(&state.all, NUMERATORS, self.options, allowed);
            growth.rejected = std::mem::take(&mut refused);
            let (grown, is_more) = growth.add_round(&state.fit.model, evidence);
            effort.scans += grown.scans;
            effort.steps += grown.steps;
            effort.work += grown.work;
            refused = grown.rejected;
            let before = state.fit.model.poles.len();
            let changed = is_more || grown.fit.model.poles.len() != before;
            if changed {
                state.fewer = grown.compressed.unwrap_or_else(|| state.all.clone());
                state.fit = grown.fit;
                state = self.iterate_variance(&state, STEPS_AFTER_ADDED, effort);
            }
            if !is_more {
                return state;
            }
        }
    }

    fn judge(&self, mut state: WeightedFit, effort: &mut FitEffort) -> WeightedFit {
        let groups = self.groups();
        let judge = PoleSignificance {
            threshold: StepwiseSearch::new(&state.all, NUMERATORS, self.options, 0.0).threshold,
            groups: &groups,
            by_hit: self.by_hit() && groups.len() >= MIN_GROUPS,
        };
        let mut needed = Vec::new();
        let (mut is_last, mut is_unchanged) = (false, true);
        for _ in 0..MAX_REMOVAL_ROUNDS {
            let needless = judge.needless(&self.band(&state), &mut needed);
            if needless.is_empty() {
                if is_last || is_unchanged {
                    break;
                }
                // Once more, all of them, where the others are now.
                is_last = true;
                needed.clear();
                continue;
            }
            is_unchanged = false;
            let mut model = state.fit.model.clone();
            for one in &needless {
                let moves =
                    |p: &ScaledPole| one.others.iter().any(|o| is_same(p, &model.poles[o.0]));
                needed.retain(|p: &ScaledPole| !moves(p));
            }
            for &(r, pole) in needless.iter().flat_map(|n| &n.others) {
                model.poles[r] = pole;
            }
            let gone: Vec<usize> = needless.iter().map(|n| n.pole).collect();
            let mut at = 0..model.poles.len();
            model
                .poles
                .retain(|_| at.next().is_some_and(|r| !gone.contains(&r)));
            state = self.state(state.variance, &model, STEPS_AFTER_ADDED, effort);
            state = self.iterate_variance(
                &self.iterate_variance(&state, STEPS_AFTER_REMOVED, effort),
                STEPS_AFTER_REMOVED,
                effort,
            );
        }
        state
    }

    /// Departures as they are measured, the poles under them, and their covariance.
    fn finish(&self, mut state: WeightedFit, effort: &mut FitEffort) -> ModelErrorFit {
        let groups = self.groups();
        let mut departures = Vec::new();
        for _ in 0..MAX_ITERATIONS {
            departures = self.estimate_model_error(&state, &groups);
            let variance = self.variance(&state, &departures);
            let model = state.fit.model.clone();
            state = self.state(variance, &model, FINAL_STEPS, effort);
        }
        let certain = covariance(std::slice::from_ref(&state.fewer), &state.fit, NUMERATORS);
        ModelErrorFit {
            state,
            departures,
            covariance: certain,
            is_out_of_work: false,
        }
    }

    /// Departure of every mode from the model.
    pub fn estimate_model_error(
        &self,
        state: &WeightedFit,
        groups: &[Vec<usize>],
    ) -> Vec<ModeDeviation> {
        let band = self.band(state);
        let all: Vec<usize> = (0..self.lines.h.len()).collect();
        let tau = scatter(&state.fewer, &state.fit, NUMERATORS, groups);
        (0..band.modes.poles.len())
            .map(|r| ModeDeviation {
                share: misfit(
                    self.lines,
                    0,
                    &all,
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

/// Whitened residuals as those of the scaled responses.
pub(super) fn unweighted_residuals(
    lines: &ScaledResponses,
    weights: &SeparableWeights,
    left: &Matrix,
) -> Vec<Vec<Complex>> {
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
