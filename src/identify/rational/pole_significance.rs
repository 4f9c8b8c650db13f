//! Is each pole needed next to its neighbours? Two poles in one resonance explain each other's departure from the model; so a pole is
//! judged in the variance of the fit without it, in a window about it.

use super::basis::ScaledPole;
use super::model_error::ModeDeviation;
use super::projection::StopCriteria;
use super::scatter::{MIN_GROUPS, scatter};
use super::windowed::{BandFit, NUMERATORS, PoleWindow, WindowFit, half_window};

/// Share of its own value by which a mode is taken to be off its model while poles are sought and judged: a pole then has to explain
/// some 5 to 9 % of the response about it. With 0.01 all modes of a measured beam stayed double.
pub(super) const MODEL_ERROR_SHARE: f64 = 0.02;

/// Distance of a neighbour, in half-widths or two lines, and ratio of widths, within which only a gross misfit proves two poles.
const MERGED_DISTANCE: (f64, f64) = (0.5, 3.0);
const MERGED_MODEL_ERROR_SHARE: f64 = 0.15;

/// A pole is judged if another lies within so many half-widths or two lines; hits may take its place within so many.
const NEIGHBOUR_HALF_WIDTHS: f64 = 4.0;
const NEIGHBOUR_HALF_WIDTHS_BY_HIT: f64 = 3.0;

/// A broad neighbour counts as no wider than so many times the pole.
const MAX_WIDTH_RATIO: f64 = 5.0;

/// Half-widths that the pole of a hit may be off the common one.
const MAX_HIT_SHIFT: f64 = 3.0;

const CONVERGENCE: StopCriteria = StopCriteria {
    steps: 10,
    min_decrease: 0.3,
    min_relative_decrease: 1e-4,
};

/// A pole that is not needed.
pub(super) struct RedundantPole {
    /// Which.
    pub pole: usize,
    /// Decrease of χ² due to the pole.
    gain: f64,
    /// Poles of its window fitted without it.
    pub others: Vec<(usize, ScaledPole)>,
}

/// Criteria of pole significance.
pub(super) struct PoleSignificance<'a> {
    /// Fall of χ² a pole must bring.
    pub threshold: f64,
    /// Responses by hit, or each alone; empty where there are too few.
    pub groups: &'a [Vec<usize>],
    /// Groups are hits.
    pub by_hit: bool,
}

/// Distance of two poles, in half-widths of the first or two lines; for a broad second one a few half-widths of the first.
fn distance(q: &ScaledPole, r: &ScaledPole, step: f64) -> f64 {
    let unit = q
        .sigma
        .max(r.sigma.min(MAX_WIDTH_RATIO * q.sigma))
        .max(2.0 * step);
    (q.w - r.w).abs() / unit
}

/// A pole that moved little.
pub(super) fn is_same(a: &ScaledPole, b: &ScaledPole) -> bool {
    const SAME_POLE_DISTANCE: f64 = 0.98;
    a.overlap(b) > SAME_POLE_DISTANCE
}

impl PoleSignificance<'_> {
    /// Poles that are not needed, the least first, no two of one window; `needed` are those known to be, by place.
    pub fn needless(&self, band: &BandFit, needed: &mut Vec<ScaledPole>) -> Vec<RedundantPole> {
        let poles = &band.modes.poles;
        let mut all = Vec::new();
        for q in 0..poles.len() {
            // Background is reported as no mode in any case, and its window would be the whole band.
            let is_background = !band.lines.may_be_mode(&poles[q]);
            if is_background || needed.iter().any(|p| is_same(p, &poles[q])) {
                continue;
            }
            match self.redundant(band, q) {
                Some(needless) => all.push(needless),
                None => needed.push(poles[q]),
            }
        }
        all.sort_by(|a: &RedundantPole, b| a.gain.total_cmp(&b.gain));
        let mut chosen: Vec<RedundantPole> = Vec::new();
        for one in all {
            let touches = |other: &RedundantPole| {
                let mut of = other.others.iter().map(|o| o.0).chain([other.pole]);
                of.any(|r| r == one.pole || one.others.iter().any(|o| o.0 == r))
            };
            if !chosen.iter().any(touches) {
                chosen.push(one);
            }
        }
        chosen
    }

    /// `None` where the pole is needed, or alone.
    fn redundant(&self, band: &BandFit, q: usize) -> Option<RedundantPole> {
        let (poles, lines) = (&band.modes.poles, band.lines);
        let (pole, step) = (poles[q], lines.step);
        let others = (0..poles.len()).filter(|&r| r != q);
        let nearest = others.min_by(|&a, &b| {
            let of = |r: usize| distance(&pole, &poles[r], step);
            of(a).total_cmp(&of(b))
        })?;
        let near = distance(&pole, &poles[nearest], step);
        if near > NEIGHBOUR_HALF_WIDTHS {
            return None;
        }
        let half = half_window(step, pole.sigma, poles[nearest].sigma);
        let share = |r: usize| {
            let other = &poles[r];
            let apart = (other.w - pole.w).abs();
            let ratio = other.sigma / pole.sigma;
            let is_one = apart < MERGED_DISTANCE.0 * other.sigma.max(pole.sigma).max(2.0 * step)
                && (1.0 / MERGED_DISTANCE.1..=MERGED_DISTANCE.1).contains(&ratio);
            if is_one {
                MERGED_MODEL_ERROR_SHARE
            } else {
                MODEL_ERROR_SHARE
            }
        };
        let departure = |r: usize| ModeDeviation {
            share: share(r),
            scatter: 0.0,
            width: pole.sigma,
        };
        let window = PoleWindow::new(band, pole.w, half, &departure);
        let others: Vec<usize> = window.near.iter().copied().filter(|&r| r != q).collect();
        let all: Vec<usize> = (0..lines.h.len()).collect();
        // The variance of the fit without it.
        let mut modes = band.modes.select(&others);
        let mut departures: Vec<ModeDeviation> = others.iter().map(|&r| departure(r)).collect();
        let mut weights = window.weights(&all, &window.variance(&modes, &departures));
        let mut without = window.fit(&all, &weights, &modes.poles, CONVERGENCE);
        for _ in 0..2 {
            modes = without.modes(lines.h.len());
            let tau = self.scatter(&without);
            for (d, tau) in departures.iter_mut().zip(tau) {
                d.scatter = tau;
            }
            weights = window.weights(&all, &window.variance(&modes, &departures));
            without = window.fit(&all, &weights, &modes.poles, CONVERGENCE);
        }
        let with: Vec<ScaledPole> = window.near.iter().map(|&r| poles[r]).collect();
        let with = window.fit(&all, &weights, &with, CONVERGENCE);
        let mut gain = without.fit.chi2 - with.fit.chi2;
        if self.by_hit && near < NEIGHBOUR_HALF_WIDTHS_BY_HIT && gain >= self.threshold {
            let start = &without.fit.model.poles;
            let own: Vec<WindowFit> = (self.groups.iter())
                .map(|hit| window.fit(hit, &weights, start, CONVERGENCE))
                .collect();
            let chi2: f64 = own.iter().map(|f| f.fit.chi2).sum();
            let stays = |f: &WindowFit| {
                let mut pairs = f.fit.model.poles.iter().zip(start);
                pairs.all(|(a, b)| (a.w - b.w).abs() < MAX_HIT_SHIFT * b.sigma)
            };
            if chi2 < with.fit.chi2 + self.threshold && own.iter().all(stays) {
                gain = 0.5 * self.threshold;
            }
        }
        let moved = without.fit.model.poles;
        (gain < self.threshold).then(|| RedundantPole {
            pole: q,
            gain,
            others: others.into_iter().zip(moved).collect(),
        })
    }

    fn scatter(&self, fit: &WindowFit) -> Vec<f64> {
        if self.groups.len() < MIN_GROUPS {
            return vec![0.0; fit.fit.model.poles.len()];
        }
        scatter(&fit.problem, &fit.fit, NUMERATORS, self.groups)
    }
}
