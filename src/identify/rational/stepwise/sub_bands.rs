//! Selection of many poles by overlapping sub-bands: the cost of a joint step grows with the square of the number of poles.
//!
//! The data of a sub-band are the residual of the fit plus the terms of the poles inside, with a linear background. Each sub-band yields
//! the poles of its core. A few steps then refine all poles jointly.

use super::super::SelectionStep;
use super::super::basis::ScaledPole;
use super::super::local_fit::cut_window;
use super::super::projection::{ModelFit, PoleModel, StopCriteria, refine};
use super::{StepwiseOptions, StepwiseSearch, parameters_per_pole};
use crate::numeric::sorting::sort_ascending;
use crate::numeric::{Matrix, parallel};

/// Maximum number of poles selected jointly, and within a sub-band.
pub(super) const MAX_JOINT_POLES: usize = 24;
pub(super) const MAX_BAND_POLES: usize = 12;

/// Number of known poles in the core of a sub-band, and in the overlap on either side.
const CORE_POLES: usize = 4;
const OVERLAP_POLES: isize = 2;

/// Maximum number of passes over the sub-bands.
pub(super) const MAX_PASSES: usize = 16;

/// Joint steps after a pass.
const STOP_AFTER_PASS: StopCriteria = StopCriteria {
    steps: 3,
    min_decrease: 1.0,
    min_relative_decrease: 1e-3,
};

/// A pass lowers χ² below this share, or to less than this multiple of the number of data; otherwise the responses depart from the model.
const MAX_CHI2_RATIO: f64 = 0.7;
pub(super) const MAX_NOISE_CHI2: f64 = 3.0;

/// Poles of two sub-bands with a larger overlap are the same pole.
const MIN_SAME_OVERLAP: f64 = 0.95;

/// Frequency limits of a sub-band, relative to the highest line.
struct SubBand {
    core: (f64, f64),
    limits: (f64, f64),
}

/// Poles selected in a sub-band.
struct SubBandPoles {
    /// Poles in the core.
    poles: Vec<ScaledPole>,
    /// Steps that added no pole.
    rejected: Vec<SelectionStep>,
}

fn contains((low, high): (f64, f64), w: f64) -> bool {
    low < w && w <= high
}

/// Sub-bands with equal numbers of poles in their cores, which cover the whole axis.
fn sub_bands(poles: &[ScaledPole]) -> Vec<SubBand> {
    let mut w: Vec<f64> = poles.iter().map(|p| p.w).collect();
    sort_ascending(&mut w, |&w| w);
    let limit = |k: isize| match usize::try_from(k) {
        Ok(k) if k >= w.len() => f64::INFINITY,
        Ok(k) if k > 0 => 0.5 * (w[k - 1] + w[k]),
        _ => f64::NEG_INFINITY,
    };
    let count = w.len().div_ceil(CORE_POLES);
    let first = |band: usize| (band * w.len() / count) as isize;
    (0..count)
        .map(|band| SubBand {
            core: (limit(first(band)), limit(first(band + 1))),
            limits: (
                limit(first(band) - OVERLAP_POLES),
                limit(first(band + 1) + OVERLAP_POLES),
            ),
        })
        .collect()
}

impl StepwiseSearch<'_> {
    /// One pass over all sub-bands, and whether another may add poles; the fit is unchanged where none is significant.
    pub(super) fn next_by_sub_band(
        &mut self,
        fit: ModelFit,
        evidence: &mut Vec<SelectionStep>,
    ) -> (ModelFit, bool) {
        let residual = self.residual_on_all_lines(&fit);
        let bands = sub_bands(&fit.model.poles);
        let selected = parallel::map(&bands, |band| self.select_in(band, &fit, &residual));
        let mut poles: Vec<ScaledPole> = Vec::new();
        for band in &selected {
            let known = poles.clone();
            let is_new = |p: &&ScaledPole| known.iter().all(|q| q.overlap(p) <= MIN_SAME_OVERLAP);
            poles.extend(band.poles.iter().filter(is_new));
        }
        let model = PoleModel {
            poles,
            delays: fit.model.delays.clone(),
        };
        let start = self.fit_model(&model, &[]);
        if self.is_crowd(&model.poles) {
            return (start, false);
        }
        let refined = refine(self.problem(), start, self.numerators, STOP_AFTER_PASS);
        self.steps += refined.steps;
        let next = self.prune(refined);
        let added = (next.model.poles.len())
            .saturating_sub(fit.model.poles.len())
            .max(1);
        if fit.chi2 - next.chi2 < self.threshold * added as f64 {
            let rejected = selected.into_iter().flat_map(|band| band.rejected);
            let decrease = |step: &SelectionStep| step.chi2_before - step.chi2_after;
            if let Some(best) = rejected.max_by(|a, b| decrease(a).total_cmp(&decrease(b))) {
                let chi2 = fit.chi2 - decrease(&best);
                evidence.push(self.step(&fit, chi2, 1, false, &best.reason));
            }
            return (self.fit_model(&fit.model, &[]), false);
        }
        evidence.push(self.step(&fit, next.chi2, added, true, ""));
        let is_converging = next.chi2 < MAX_CHI2_RATIO * fit.chi2;
        let is_near_noise = next.chi2 < MAX_NOISE_CHI2 * self.options.data_count;
        (next, is_converging || is_near_noise)
    }

    /// Poles in the core of a sub-band; those of the fit where its lines determine no further one.
    fn select_in(&self, band: &SubBand, fit: &ModelFit, residual: &Matrix) -> SubBandPoles {
        let mut rejected = Vec::new();
        let selected = self.select_between(band.limits, (fit, residual), &mut rejected);
        let mut poles = match selected {
            Some((selected, _)) => selected.model.poles,
            None => fit.model.poles.clone(),
        };
        poles.retain(|p| contains(band.core, p.w));
        rejected.retain(|step| !step.accepted);
        SubBandPoles { poles, rejected }
    }

    /// Stepwise selection on the lines between two frequencies, from the poles of a fit there and with a linear background; with the number
    /// of data. `None` where these lines determine no further pole.
    pub(super) fn select_between(
        &self,
        limits: (f64, f64),
        (fit, residual): (&ModelFit, &Matrix),
        evidence: &mut Vec<SelectionStep>,
    ) -> Option<(ModelFit, f64)> {
        let (x, poles) = (&self.measured.x, &fit.model.poles);
        let from = x.partition_point(|&x| x <= limits.0);
        let to = x.partition_point(|&x| x <= limits.1);
        let indices: Vec<usize> = (0..poles.len())
            .filter(|&r| contains(limits, poles[r].w))
            .collect();
        let values = ((to - from) * self.measured.y.ncols()) as f64;
        let determined = (values / parameters_per_pole(self.measured, self.numerators)) as usize;
        if determined <= indices.len() {
            return None;
        }
        let model = PoleModel {
            poles: indices.iter().map(|&r| poles[r]).collect(),
            delays: Vec::new(),
        };
        let part = cut_window(
            self.measured,
            fit,
            residual,
            self.numerators,
            &indices,
            from,
            to,
        );
        let data_count = self.options.data_count * (to - from) as f64 / x.len() as f64;
        let options = StepwiseOptions {
            max_poles: MAX_BAND_POLES.min(determined),
            fixed_pole_count: None,
            data_count,
            ..self.options
        };
        let mut search = StepwiseSearch::new(&part, self.numerators, options);
        search.threshold = self.threshold;
        Some((search.run(&model, evidence).fit, data_count))
    }
}
