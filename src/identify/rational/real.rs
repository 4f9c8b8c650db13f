//! Responses that depart from the model by more than their noise: poles are sought, judged and refined in a variance that holds what
//! each mode departs by, from no pole on. The poles of a fit by noise alone are no start: they are in each other's place.

use crate::numeric::{Complex, Matrix};

use super::basis::{Pole, Problem, Structure};
use super::condensed::Condenser;
use super::covariance::{Covariance, covariance};
use super::departure::{Departure, Modes, misfit, variance};
use super::growth::{Growth, Rules};
use super::judge::{DEPARTURE, Judge, is_same};
use super::lines::{Lines, Weights};
use super::projection::{Fitted, Model, Stop, at, left, refine};
use super::scatter::{FEWEST_GROUPS, scatter};
use super::windowed::{Band, NUMERATORS, coefficients};
use super::{Effort, Step};

/// While poles are sought, lines across no more than this share of the frequency count as one: a broad background must not hide
/// narrow modes.
const NARROW: f64 = 0.02;

/// Steps of all poles after one was added, while they are judged, and at the end.
const ADDED: Stop = Stop {
    steps: 3,
    fall: 1.0,
    share: 1e-4,
};
const JUDGED: Stop = Stop {
    steps: 6,
    fall: 0.5,
    share: 1e-5,
};
const LAST: Stop = Stop {
    steps: 12,
    fall: 0.0,
    share: 1e-8,
};

/// Most rounds of the judge, in each of which poles far apart are taken out together.
const JUDGEMENTS: usize = 40;

/// Rounds of departures and poles at the end.
const ROUNDS: usize = 3;

/// Operations of the growth, about, on condensed lines: forty poles in ten thousand lines of six responses take a part of it.
const MOST_WORK: f64 = 6e10;

/// What the search needs.
pub(super) struct Search<'a> {
    /// Lines and responses.
    pub lines: &'a Lines,
    /// Variance of the noise alone.
    pub noise: &'a [Vec<f64>],
    /// How poles are added.
    pub rules: Rules,
}

/// A fit under a variance of its own.
pub(super) struct State {
    /// The variance.
    pub variance: Vec<Vec<f64>>,
    /// As weights.
    pub weights: Weights,
    /// All lines.
    pub all: Problem,
    /// The lines that the fit was made on.
    fewer: Problem,
    /// Poles and coefficients.
    pub fitted: Fitted,
}

/// What the search came to.
pub(super) struct Departing {
    /// The fit.
    pub state: State,
    /// What each pole departs by.
    pub departures: Vec<Departure>,
    /// Covariance of the poles under the variance.
    pub covariance: Covariance,
}

impl Search<'_> {
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
        model: &Model,
        stop: Stop,
        effort: &mut Effort,
    ) -> State {
        let weights = Weights::mean(&variance);
        let all = self.lines.shared(&weights, Structure::FULL);
        let enough = Condenser::new(&all).condensed(model, &[]);
        let fewer = enough.problem.into_owned();
        let problem = std::slice::from_ref(&fewer);
        let fitted = refine(problem, at(problem, model, NUMERATORS), NUMERATORS, stop);
        effort.steps += fitted.steps;
        State {
            variance,
            weights,
            fitted,
            fewer,
            all,
        }
    }

    fn modes(&self, state: &State) -> Modes {
        Modes {
            poles: state.fitted.model.poles.clone(),
            coefficients: (0..self.lines.h.len())
                .map(|i| coefficients(&state.fitted, i, state.weights.by_response[i]))
                .collect(),
        }
    }

    /// The fit as windows see it.
    pub fn band(&self, state: &State) -> Band<'_> {
        let e = left(
            &state.all,
            &state.fitted.model,
            NUMERATORS,
            &state.fitted.fits[0],
        );
        Band {
            lines: self.lines,
            noise: self.noise,
            modes: self.modes(state),
            residual: unweighted(self.lines, &state.weights, &e),
        }
    }

    /// Departures while poles are sought.
    fn supposed(&self, state: &State) -> Vec<Departure> {
        let model = &state.fitted.model;
        let tau = match self.by_hit() {
            true => scatter(&state.fewer, &state.fitted, NUMERATORS, &self.lines.hits),
            false => vec![0.0; model.poles.len()],
        };
        let of = |(pole, tau): (&Pole, f64)| Departure {
            share: DEPARTURE,
            scatter: tau,
            width: NARROW * pole.w,
        };
        model.poles.iter().zip(tau).map(of).collect()
    }

    fn variance(&self, state: &State, departures: &[Departure]) -> Vec<Vec<f64>> {
        variance(self.lines, 0, self.noise, &self.modes(state), departures)
    }

    /// The fit once its variance has followed its poles.
    fn settled(&self, state: &State, stop: Stop, effort: &mut Effort) -> State {
        let variance = self.variance(state, &self.supposed(state));
        self.state(variance, &state.fitted.model, stop, effort)
    }

    /// Poles, judged and refined, with what they depart by.
    pub fn run(&self, start: &Model, evidence: &mut Vec<Step>, effort: &mut Effort) -> Departing {
        let first = self.state(self.noise.to_vec(), start, ADDED, effort);
        let mut state = match start.poles.is_empty() {
            true => first,
            false => self.settled(&first, JUDGED, effort),
        };
        state = self.grow(state, evidence, effort);
        if self.rules.order.is_none() {
            state = self.judge(state, effort);
        }
        self.finish(state, effort)
    }

    fn grow(&self, mut state: State, evidence: &mut Vec<Step>, effort: &mut Effort) -> State {
        let mut refused = Vec::new();
        let already = effort.work;
        loop {
            let allowed = MOST_WORK - (effort.work - already);
            let mut growth = Growth::new(&state.all, NUMERATORS, self.rules, allowed);
            growth.refused = std::mem::take(&mut refused);
            let (grown, is_more) = growth.once(&state.fitted.model, evidence);
            effort.scans += grown.scans;
            effort.steps += grown.steps;
            effort.work += grown.work;
            refused = grown.refused;
            let before = state.fitted.model.poles.len();
            let changed = is_more || grown.fitted.model.poles.len() != before;
            if changed {
                state.fewer = grown.fewer.unwrap_or_else(|| state.all.clone());
                state.fitted = grown.fitted;
                state = self.settled(&state, ADDED, effort);
            }
            if !is_more {
                return state;
            }
        }
    }

    fn judge(&self, mut state: State, effort: &mut Effort) -> State {
        let groups = self.groups();
        let judge = Judge {
            threshold: Growth::new(&state.all, NUMERATORS, self.rules, 0.0).threshold,
            groups: &groups,
            by_hit: self.by_hit() && groups.len() >= FEWEST_GROUPS,
        };
        let mut needed = Vec::new();
        let mut is_last = false;
        for _ in 0..JUDGEMENTS {
            let needless = judge.needless(&self.band(&state), &mut needed);
            if needless.is_empty() {
                if is_last {
                    break;
                }
                // Once more, all of them, where the others are now.
                is_last = true;
                needed.clear();
                continue;
            }
            let mut model = state.fitted.model.clone();
            for one in &needless {
                let moves = |p: &Pole| one.others.iter().any(|o| is_same(p, &model.poles[o.0]));
                needed.retain(|p: &Pole| !moves(p));
            }
            for &(r, pole) in needless.iter().flat_map(|n| &n.others) {
                model.poles[r] = pole;
            }
            let gone: Vec<usize> = needless.iter().map(|n| n.pole).collect();
            let mut at = 0..model.poles.len();
            model
                .poles
                .retain(|_| at.next().is_some_and(|r| !gone.contains(&r)));
            state = self.state(state.variance, &model, ADDED, effort);
            state = self.settled(&self.settled(&state, JUDGED, effort), JUDGED, effort);
        }
        state
    }

    /// Departures as they are measured, the poles under them, and their covariance.
    fn finish(&self, mut state: State, effort: &mut Effort) -> Departing {
        let groups = self.groups();
        let mut departures = Vec::new();
        for _ in 0..ROUNDS {
            departures = self.measured(&state, &groups);
            let variance = self.variance(&state, &departures);
            let model = state.fitted.model.clone();
            state = self.state(variance, &model, LAST, effort);
        }
        let certain = covariance(
            std::slice::from_ref(&state.fewer),
            &state.fitted,
            NUMERATORS,
        );
        Departing {
            state,
            departures,
            covariance: certain,
        }
    }

    /// What every mode departs by.
    pub fn measured(&self, state: &State, groups: &[Vec<usize>]) -> Vec<Departure> {
        let band = self.band(state);
        let all: Vec<usize> = (0..self.lines.h.len()).collect();
        let tau = scatter(&state.fewer, &state.fitted, NUMERATORS, groups);
        (0..band.modes.poles.len())
            .map(|r| Departure {
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
pub(super) fn unweighted(lines: &Lines, weights: &Weights, left: &Matrix) -> Vec<Vec<Complex>> {
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
