//! Backward elimination: poles that are not significant, or have no place of their own, are taken out.

use super::super::SelectionStep;
use super::super::basis::ScaledPole;
use super::super::covariance::covariance;
use super::super::projection::{ModelFit, StopCriteria, fit_at, refine};
use super::{REASON_NOISE, STOP_BEFORE_SCAN, StepwiseSearch, is_same_pole};
use crate::numeric::Matrix;

/// A pole whose place is uncertain by more than this share of its half-width may be no pole of its own.
const MAX_RELATIVE_STD: f64 = 0.2;

/// The others are brought to their best places without it.
const STOP_AFTER_REMOVAL: StopCriteria = StopCriteria {
    steps: 30,
    min_decrease: 1.0,
    min_relative_decrease: 0.0,
};

impl StepwiseSearch<'_> {
    /// Backward elimination: removes the poles that are not significant, the weakest first, down to the requested number, with the others
    /// refitted.
    pub(super) fn eliminate(
        &mut self,
        start: ModelFit,
        evidence: &mut Vec<SelectionStep>,
    ) -> ModelFit {
        let mut fit = self.converge(start);
        let most = self.options.fixed_pole_count.unwrap_or(0);
        while fit.model.poles.len() > most {
            let significance = significance(&fit, self.numerators);
            let by_weight = significance.into_iter().enumerate();
            let Some((weakest, _)) = by_weight.min_by(|a, b| a.1.total_cmp(&b.1)) else {
                break;
            };
            let without = self.fit_without(&fit, weakest);
            if self.options.fixed_pole_count.is_none() {
                let is_needed = without.chi2 - fit.chi2 >= self.threshold;
                let why = if is_needed { "" } else { REASON_NOISE };
                evidence.push(self.step(&without, fit.chi2, 1, is_needed, why));
                if is_needed {
                    break;
                }
            }
            fit = self.converge(without);
        }
        fit
    }

    /// The fit without a pole, the others moved again.
    fn fit_without(&mut self, fit: &ModelFit, r: usize) -> ModelFit {
        let mut model = fit.model.clone();
        model.poles.remove(r);
        let start = fit_at(self.problem(), &model, self.numerators);
        let without = refine(self.problem(), start, self.numerators, STOP_BEFORE_SCAN);
        self.count_steps(without.steps, without.model.poles.len());
        without
    }

    /// Takes poles out whose numerators are not significant, the weakest first (Wald 1943), if a new fit confirms it.
    pub(super) fn prune(&mut self, mut fit: ModelFit) -> ModelFit {
        if self.options.fixed_pole_count.is_some() {
            return fit;
        }
        let mut kept: Vec<ScaledPole> = Vec::new();
        loop {
            let weak = significance(&fit, self.numerators)
                .into_iter()
                .enumerate()
                .filter(|&(r, s)| {
                    s < self.threshold && !kept.iter().any(|q| is_same_pole(q, &fit.model.poles[r]))
                })
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((r, _)) = weak else {
                return fit;
            };
            let gone = fit.model.poles[r];
            let without = self.fit_without(&fit, r);
            if without.chi2 - fit.chi2 < self.threshold {
                fit = without;
            } else {
                kept.push(gone);
            }
        }
    }

    /// Takes out poles that hardly have a place of their own, the least certain first, if the others, moved again, explain as
    /// much. Next to a heavily damped pole a second one may share what is its, at a place that does not matter; held still,
    /// both look significant.
    pub(super) fn drop_uncertain(&mut self, mut fit: ModelFit) -> ModelFit {
        if self.options.fixed_pole_count.is_some() {
            return fit;
        }
        let mut kept: Vec<ScaledPole> = Vec::new();
        loop {
            let unit = (fit.chi2 / self.options.data_count).max(1.0);
            let certain = covariance(self.problem(), &fit, self.numerators);
            let share = |r: usize| -> f64 {
                let sigma = fit.model.poles[r].sigma;
                certain.poles[r].map_or(f64::INFINITY, |[re, im, _]| {
                    (unit * re.max(im)).sqrt() / sigma
                })
            };
            let worst = (0..fit.model.poles.len())
                .map(|r| (r, share(r)))
                .filter(|&(r, s)| {
                    s > MAX_RELATIVE_STD
                        && !kept.iter().any(|q| is_same_pole(q, &fit.model.poles[r]))
                })
                .max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((r, _)) = worst else {
                return fit;
            };
            let mut model = fit.model.clone();
            let gone = model.poles.remove(r);
            let start = fit_at(self.problem(), &model, self.numerators);
            let without = refine(self.problem(), start, self.numerators, STOP_AFTER_REMOVAL);
            self.count_steps(without.steps, without.model.poles.len());
            if without.chi2 - fit.chi2 < self.threshold * unit {
                fit = without;
            } else {
                kept.push(gone);
            }
        }
    }
}

/// Rise of χ² if a pole's columns were taken out and the others remained fixed, for every pole.
fn significance(fitted: &ModelFit, numerators: usize) -> Vec<f64> {
    let np = fitted.model.poles.len();
    let mut all = vec![0.0; np];
    for fit in &fitted.fits {
        let n = fit.qr.r.ncols();
        let inverse = fit
            .qr
            .solve(&Matrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j))));
        let product =
            |a: usize, b: usize| -> f64 { (0..n).map(|k| inverse[(a, k)] * inverse[(b, k)]).sum() };
        for (r, sum) in all.iter_mut().enumerate() {
            let a = r * numerators;
            let saa = product(a, a);
            for i in 0..fit.c.ncols() {
                let ca = fit.c[(a, i)];
                if numerators == 1 {
                    *sum += if saa > 0.0 { ca * ca / saa } else { 0.0 };
                    continue;
                }
                let (sbb, sab) = (product(a + 1, a + 1), product(a, a + 1));
                let cb = fit.c[(a + 1, i)];
                let det = saa * sbb - sab * sab;
                if det > 0.0 {
                    *sum += (ca * ca * sbb - 2.0 * ca * cb * sab + cb * cb * saa) / det;
                }
            }
        }
    }
    all
}
