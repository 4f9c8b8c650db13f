//! Forward addition: poles at the places where they gain most, several at once where they are far apart.

use super::super::SelectionStep;
use super::super::basis::ScaledPole;
use super::super::local_fit::{LocalFit, fit_locally};
use super::super::projection::{ModelFit, PoleModel, StopCriteria, fit_at, refine};
use super::super::scan::{ScanPeak, scan};
use super::{MAX_BATCH, MAX_TRIALS, REASON_NOISE, StepwiseSearch, is_same_pole};
use crate::numeric::sorting::sort_descending;

/// Steps of all poles together after one was added. No precision is bought before all are in.
const STEPS_AFTER_ADDED: usize = 6;

/// Poles added at once to a variance that holds departures are farther from each other than so many of their half-widths.
const CLEAR_OF_DEPARTURES: f64 = 20.0;

/// Poles added at once share less than this with any other, and are farther from it than so many lines.
const MIN_SEPARATION: (f64, f64) = (0.1, 6.0);

/// A local fit sees most of what a pole gains; below this share of the threshold it is not worth a fit of all lines.
const NEAR_THRESHOLD: f64 = 0.7;

/// A peak of the scan is followed from this share of the threshold on: the scan cuts Lorentzians off.
const WORTH_TRYING: f64 = 0.3;

impl StepwiseSearch<'_> {
    pub(super) fn worth_trying(&mut self, fit: &ModelFit) -> Vec<ScanPeak> {
        self.scans += 1;
        let least = if self.options.fixed_pole_count.is_some() {
            0.0
        } else {
            WORTH_TRYING * self.threshold
        };
        let mut peaks = scan(
            self.measured,
            &self.residual_on_all_lines(fit),
            &fit.model.poles,
        );
        peaks.retain(|p| p.gain > least && !self.rejected.iter().any(|q| is_same_pole(q, &p.pole)));
        peaks
    }

    /// Poles far from each other, added together.
    pub(super) fn try_batch(
        &mut self,
        fit: &ModelFit,
        peaks: &[ScanPeak],
        most: usize,
        evidence: &mut Vec<SelectionStep>,
    ) -> Option<ModelFit> {
        let least = self.threshold;
        let step = self.measured.line_spacing;
        let placed: Vec<LocalFit> = distinct_peaks(peaks, step, MAX_BATCH.min(most))
            .iter()
            .filter(|p| p.gain > least)
            .filter_map(|p| self.fit_locally(fit, p))
            .filter(|p| p.gain > least)
            .collect();
        let mut distinct: Vec<LocalFit> = Vec::new();
        for p in placed {
            let old = fit.model.poles.iter();
            let mut others = old.chain(distinct.iter().map(|q| &q.pole));
            let is_clear = |q: &ScaledPole| {
                let far = match self.options.departs {
                    true => CLEAR_OF_DEPARTURES * (q.sigma + p.pole.sigma),
                    false => 0.0,
                };
                q.overlap(&p.pole) < MIN_SEPARATION.0
                    && (q.w - p.pole.w).abs() > far.max(MIN_SEPARATION.1 * step)
            };
            if others.all(is_clear) {
                distinct.push(p);
            }
        }
        if distinct.len() < 2 {
            return None;
        }
        let mut model = fit.model.clone();
        model.poles.extend(distinct.iter().map(|p| p.pole));
        let next = self.refine_all(&model);
        let next = self.prune(next);
        let added = next.model.poles.len().saturating_sub(fit.model.poles.len());
        if added == 0 || fit.chi2 - next.chi2 < self.threshold * added as f64 {
            return None;
        }
        evidence.push(self.step(fit, next.chi2, added, true, ""));
        Some(next)
    }

    /// The best of a few places, tried in turn.
    pub(super) fn try_single(
        &mut self,
        fit: &ModelFit,
        peaks: &[ScanPeak],
        evidence: &mut Vec<SelectionStep>,
    ) -> Option<ModelFit> {
        let step = self.measured.line_spacing;
        let mut tries: Vec<(f64, PoleModel)> = Vec::new();
        for peak in distinct_peaks(peaks, step, MAX_TRIALS) {
            let placed = self.fit_locally(fit, &peak);
            let mut model = fit.model.clone();
            match &placed {
                Some(p) => {
                    for &(r, pole) in &p.neighbours {
                        model.poles[r] = pole;
                    }
                    model.poles.push(p.pole);
                }
                None => model.poles.push(peak.pole),
            }
            tries.push((placed.map_or(peak.gain, |p| p.gain), model));
        }
        sort_descending(&mut tries, |a| a.0);
        for (gain, model) in tries {
            let start = model.poles.last().copied()?;
            if gain < NEAR_THRESHOLD * self.threshold && self.options.fixed_pole_count.is_none() {
                evidence.push(self.step(fit, fit.chi2 - gain, 1, false, REASON_NOISE));
                self.rejected.push(start);
                continue;
            }
            let next = self.refine_all(&model);
            let fall = fit.chi2 - next.chi2;
            let forced = self.options.fixed_pole_count.is_some() && fall > 0.0;
            if fall < self.threshold && !forced {
                evidence.push(self.step(fit, next.chi2, 1, false, REASON_NOISE));
                self.rejected.push(start);
                continue;
            }
            let (before, after) = (&fit.fits[0].e, &next.fits[0].e);
            let is_line = match self.options.departs {
                true => self.is_on_a_line(before, after),
                false => self.options.estimated && self.is_outlier(before, after),
            };
            if is_line && !forced {
                evidence.push(self.step(
                    fit,
                    next.chi2,
                    1,
                    false,
                    "nearly all of it on one line, taken as a bad line",
                ));
                self.rejected.push(start);
                continue;
            }
            let before = fit.model.poles.len();
            let next = self.prune(next);
            if next.model.poles.len() <= before && fit.chi2 - next.chi2 < self.threshold {
                self.rejected.push(start);
                continue;
            }
            evidence.push(self.step(fit, next.chi2, 1, true, ""));
            return Some(next);
        }
        None
    }

    fn fit_locally(&self, fit: &ModelFit, peak: &ScanPeak) -> Option<LocalFit> {
        fit_locally(
            &self.problem()[0],
            fit,
            self.numerators,
            peak,
            self.options.unstable,
        )
    }

    /// All poles together, roughly.
    fn refine_all(&mut self, model: &PoleModel) -> ModelFit {
        let start = fit_at(self.problem(), model, self.numerators);
        let fall = 0.02 * self.threshold * (start.chi2 / self.options.data_count).max(1.0);
        let cancel = StopCriteria {
            steps: if self.options.departs {
                STEPS_AFTER_ADDED / 2
            } else {
                STEPS_AFTER_ADDED
            },
            min_decrease: fall.max(1.0),
            min_relative_decrease: 0.0,
        };
        let fit = refine(self.problem(), start, self.numerators, cancel);
        self.count_steps(fit.steps, fit.model.poles.len());
        fit
    }
}

/// The largest peaks whose gain is not that of a larger one seen through another width.
pub(super) fn distinct_peaks(peaks: &[ScanPeak], step: f64, most: usize) -> Vec<ScanPeak> {
    let mut chosen: Vec<ScanPeak> = Vec::new();
    for peak in peaks {
        if chosen.len() >= most {
            break;
        }
        let clear = chosen.iter().all(|c| {
            let distance = (c.pole.w - peak.pole.w).abs();
            distance > 2.0 * (c.pole.sigma + peak.pole.sigma) + 2.0 * step
                && peak.gain > 4.0 * c.gain * c.pole.overlap(&peak.pole)
        });
        if clear {
            chosen.push(*peak);
        }
    }
    chosen
}
