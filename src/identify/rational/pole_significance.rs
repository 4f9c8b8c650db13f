//! Significance test of poles with close neighbours. Two poles in one resonance explain the model error of each other, so each pole is
//! tested with the variance of the fit without it, in a window around it.

use super::basis::ScaledPole;
use super::model_error::ModeDeviation;
use super::projection::StopCriteria;
use super::scatter::{MIN_GROUPS, scatter};
use super::windowed::{BandFit, NUMERATORS, PoleWindow, WindowFit, half_window};

/// Assumed relative model error of a mode during the search: a pole then has to explain 5 to 9 % of the response around it. With 0.01 all
/// modes of a measured beam remained double.
pub(super) const MODEL_ERROR_SHARE: f64 = 0.02;

/// Distance of a neighbour (in half-widths or two lines) and ratio of widths, within which two poles need a larger model error.
const MERGED_DISTANCE: (f64, f64) = (0.5, 3.0);
const MERGED_MODEL_ERROR_SHARE: f64 = 0.15;

/// Maximum distance of a neighbour, in half-widths or two lines, for the test of a pole, and for the test by separate fits of hits.
const NEIGHBOUR_HALF_WIDTHS: f64 = 4.0;
const NEIGHBOUR_HALF_WIDTHS_BY_HIT: f64 = 3.0;

/// Maximum ratio of the widths of a neighbour and a pole in their distance.
const MAX_WIDTH_RATIO: f64 = 5.0;

/// Maximum shift of the pole of a hit from the common pole, in half-widths.
const MAX_HIT_SHIFT: f64 = 3.0;

const CONVERGENCE: StopCriteria = StopCriteria {
    steps: 10,
    min_decrease: 0.3,
    min_relative_decrease: 1e-4,
};

/// Redundant pole with the fit without it.
pub(super) struct RedundantPole {
    /// Index of the pole.
    pub pole: usize,
    /// Decrease of χ² due to the pole.
    gain: f64,
    /// Other poles of its window, refined without it: index and pole.
    pub others: Vec<(usize, ScaledPole)>,
}

/// Criteria of pole significance.
pub(super) struct PoleSignificance<'a> {
    /// Minimum decrease of χ² due to a significant pole.
    pub threshold: f64,
    /// Groups of responses: one per hit, otherwise one per response.
    pub groups: &'a [Vec<usize>],
    /// True if the groups are hits and there are at least [`MIN_GROUPS`].
    pub by_hit: bool,
}

/// Distance of two poles in units of the larger half-width (limited to [`MAX_WIDTH_RATIO`] times the first) or of two lines.
fn distance(q: &ScaledPole, r: &ScaledPole, step: f64) -> f64 {
    let unit = q
        .sigma
        .max(r.sigma.min(MAX_WIDTH_RATIO * q.sigma))
        .max(2.0 * step);
    (q.w - r.w).abs() / unit
}

/// True if two poles overlap almost completely.
pub(super) fn is_same(a: &ScaledPole, b: &ScaledPole) -> bool {
    const SAME_POLE_DISTANCE: f64 = 0.98;
    a.overlap(b) > SAME_POLE_DISTANCE
}

impl PoleSignificance<'_> {
    /// Redundant poles of separate windows, the least significant first; `needed` holds poles already tested as significant.
    pub fn redundant(&self, band: &BandFit, needed: &mut Vec<ScaledPole>) -> Vec<RedundantPole> {
        let poles = &band.modes.poles;
        let mut redundant = Vec::new();
        for q in 0..poles.len() {
            // A background pole is never reported as a mode, and its window would be the whole band.
            let is_background = !band.lines.may_be_mode(&poles[q]);
            if is_background || needed.iter().any(|p| is_same(p, &poles[q])) {
                continue;
            }
            match self.test(band, q) {
                Some(pole) => redundant.push(pole),
                None => needed.push(poles[q]),
            }
        }
        redundant.sort_by(|a: &RedundantPole, b| a.gain.total_cmp(&b.gain));
        let mut separate: Vec<RedundantPole> = Vec::new();
        for candidate in redundant {
            let shares_window = |other: &RedundantPole| {
                let mut poles = other.others.iter().map(|o| o.0).chain([other.pole]);
                poles.any(|r| r == candidate.pole || candidate.others.iter().any(|o| o.0 == r))
            };
            if !separate.iter().any(shares_window) {
                separate.push(candidate);
            }
        }
        separate
    }

    /// Tests a pole; `None` if it is significant or has no close neighbour.
    fn test(&self, band: &BandFit, q: usize) -> Option<RedundantPole> {
        let (poles, lines) = (&band.modes.poles, band.lines);
        let (pole, step) = (poles[q], lines.step);
        let others = (0..poles.len()).filter(|&r| r != q);
        let nearest = others.min_by(|&a, &b| {
            let unit_distance = |r: usize| distance(&pole, &poles[r], step);
            unit_distance(a).total_cmp(&unit_distance(b))
        })?;
        let gap = distance(&pole, &poles[nearest], step);
        if gap > NEIGHBOUR_HALF_WIDTHS {
            return None;
        }
        let half = half_window(step, pole.sigma, poles[nearest].sigma);
        let share = |r: usize| {
            let other = &poles[r];
            let offset = (other.w - pole.w).abs();
            let ratio = other.sigma / pole.sigma;
            let merged = offset < MERGED_DISTANCE.0 * other.sigma.max(pole.sigma).max(2.0 * step)
                && (1.0 / MERGED_DISTANCE.1..=MERGED_DISTANCE.1).contains(&ratio);
            if merged {
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
        let others: Vec<usize> = window.indices.iter().copied().filter(|&r| r != q).collect();
        let responses: Vec<usize> = (0..lines.h.len()).collect();
        // The variance comes from the fit without the pole.
        let mut modes = band.modes.select(&others);
        let mut departures: Vec<ModeDeviation> = others.iter().map(|&r| departure(r)).collect();
        let mut weights = window.weights(&responses, &window.variance(&modes, &departures));
        let mut without = window.fit(&responses, &weights, &modes.poles, CONVERGENCE);
        for _ in 0..2 {
            modes = without.modes(lines.h.len());
            let tau = self.scatter(&without);
            for (d, tau) in departures.iter_mut().zip(tau) {
                d.scatter = tau;
            }
            weights = window.weights(&responses, &window.variance(&modes, &departures));
            without = window.fit(&responses, &weights, &modes.poles, CONVERGENCE);
        }
        let with: Vec<ScaledPole> = window.indices.iter().map(|&r| poles[r]).collect();
        let with = window.fit(&responses, &weights, &with, CONVERGENCE);
        let mut gain = without.fit.chi2 - with.fit.chi2;
        if self.by_hit && gap < NEIGHBOUR_HALF_WIDTHS_BY_HIT && gain >= self.threshold {
            let start = &without.fit.model.poles;
            let hit_fits: Vec<WindowFit> = (self.groups.iter())
                .map(|hit| window.fit(hit, &weights, start, CONVERGENCE))
                .collect();
            let chi2: f64 = hit_fits.iter().map(|f| f.fit.chi2).sum();
            let is_close = |f: &WindowFit| {
                let mut pairs = f.fit.model.poles.iter().zip(start);
                pairs.all(|(a, b)| (a.w - b.w).abs() < MAX_HIT_SHIFT * b.sigma)
            };
            if chi2 < with.fit.chi2 + self.threshold && hit_fits.iter().all(is_close) {
                gain = 0.5 * self.threshold;
            }
        }
        let refined = without.fit.model.poles;
        (gain < self.threshold).then(|| RedundantPole {
            pole: q,
            gain,
            others: others.into_iter().zip(refined).collect(),
        })
    }

    fn scatter(&self, fit: &WindowFit) -> Vec<f64> {
        if self.groups.len() < MIN_GROUPS {
            return vec![0.0; fit.fit.model.poles.len()];
        }
        scatter(&fit.problem, &fit.fit, NUMERATORS, self.groups)
    }
}
