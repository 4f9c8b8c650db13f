//! Stepwise selection of poles: forward addition while Δχ² is significant, backward elimination (Wald).

use crate::numeric::Matrix;
use crate::numeric::statistics::{chi_squared_quantile, chi_squared_sf};

use super::SelectionStep;
use super::basis::{ScaledPole, WhitenedProblem};
use super::covariance::covariance;
use super::line_compression::{CompressedProblem, Compressor};
use super::local_fit::{LocalFit, fit_locally};
use super::projection::{ModelFit, PoleModel, StopCriteria, fit_at, refine, residual};
use super::scan::{ScanPeak, scan};
use crate::numeric::sorting::sort_falling;

/// Options of the stepwise selection.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepwiseOptions {
    /// Most pole pairs.
    pub max_poles: usize,
    /// So many pole pairs whatever they gain.
    pub fixed_pole_count: Option<usize>,
    /// Poles may be added; else they are only refined and taken out.
    pub add_poles: bool,
    /// Poles of the right half plane are allowed.
    pub unstable: bool,
    /// The variance is an estimate along the frequency axis, which a single bad line may escape.
    pub estimated: bool,
    /// Independent real numbers of data.
    pub data_count: f64,
    /// The variance holds departures from the model: a pole must gain on more lines than one.
    pub departs: bool,
}

/// Probability that noise alone adds one pole too many.
const FALSE_ALARM: f64 = 1e-4;

/// Number of independent pole places per line, about four.
const PLACES_PER_LINE: f64 = 4.0;

/// Poles added at once, and places tried one by one.
const MAX_BATCH: usize = 12;
const MAX_TRIALS: usize = 4;

/// Steps of all poles together after one was added. No precision is bought before all are in.
const STEPS_AFTER_ADDED: usize = 6;

/// Before a place near a pole is looked at, the poles are brought to theirs.
const STOP_BEFORE_SCAN: StopCriteria = StopCriteria {
    steps: 12,
    min_decrease: 1.0,
    min_relative_decrease: 1e-3,
};

/// A pole whose place is uncertain by more than this share of its half-width may be no pole of its own.
const MAX_RELATIVE_STD: f64 = 0.2;

/// The others are brought to their best places without it.
const STOP_AFTER_REMOVAL: StopCriteria = StopCriteria {
    steps: 30,
    min_decrease: 1.0,
    min_relative_decrease: 0.0,
};

/// Least number of poles of which more than a third lie within [`CROWD_HALF_WIDTHS`] half-widths, or lines, of another, and thus explain a
/// departure.
const MIN_CROWD: usize = 8;
const CROWD_HALF_WIDTHS: f64 = 2.0;

/// Poles added at once to a variance that holds departures are farther from each other than so many of their half-widths.
const CLEAR_OF_DEPARTURES: f64 = 20.0;

/// Poles added at once share less than this with any other, and are farther from it than so many lines.
const MIN_SEPARATION: (f64, f64) = (0.1, 6.0);

/// A local fit sees most of what a pole gains; below this share of the threshold it is not worth a fit of all lines.
const NEAR_THRESHOLD: f64 = 0.7;

/// A peak of the scan is followed from this share of the threshold on: the scan cuts Lorentzians off.
const WORTH_TRYING: f64 = 0.3;

/// Searches at one weighting and one structure.
pub(super) struct StepwiseSearch<'a> {
    /// All lines.
    measured: &'a WhitenedProblem,
    condenser: Compressor<'a>,
    /// As many as the poles at hand need.
    lines: CompressedProblem<'a>,
    numerators: usize,
    options: StepwiseOptions,
    /// Fall of χ² a pole must bring.
    pub threshold: f64,
    /// Places that were tried in vain.
    pub rejected: Vec<ScaledPole>,
    settled: bool,
    /// Steps of all poles together.
    pub steps: usize,
    /// Scans made.
    pub scans: usize,
    /// Operations made, about.
    pub work: f64,
    /// Operations allowed.
    pub allowed: f64,
}

impl<'a> StepwiseSearch<'a> {
    /// `measured` holds all responses.
    pub fn new(
        measured: &'a WhitenedProblem,
        numerators: usize,
        options: StepwiseOptions,
        allowed: f64,
    ) -> StepwiseSearch<'a> {
        let places = PLACES_PER_LINE * measured.lines() as f64;
        let threshold = chi_squared_quantile(
            1.0 - FALSE_ALARM / places,
            parameters_per_pole(measured, numerators),
        );
        StepwiseSearch {
            measured,
            condenser: Compressor::new(measured),
            lines: CompressedProblem::uncompressed(measured),
            numerators,
            options,
            threshold,
            rejected: Vec::new(),
            settled: false,
            steps: 0,
            scans: 0,
            work: 0.0,
            allowed,
        }
    }

    fn count_steps(&mut self, steps: usize, poles: usize) {
        self.steps += steps;
        self.work += steps as f64 * self.step_work(poles);
    }

    /// Operations of one step of all poles together.
    fn step_work(&self, poles: usize) -> f64 {
        let problem = match self.options.departs {
            true => &self.lines.problem,
            false => self.measured,
        };
        step_work(problem, poles, self.numerators)
    }

    /// From poles at hand to those that are worth it, with the lines they were fitted on.
    pub fn run(mut self, model: &PoleModel, evidence: &mut Vec<SelectionStep>) -> StepwiseResult {
        let start = self.fit_model(model, &[]);
        let fit = match self.options.add_poles {
            true => {
                let start = self.prune(start);
                self.add_poles(start, evidence)
            }
            false => self.eliminate(start, evidence),
        };
        let fit = self.drop_uncertain(fit);
        self.into_grown(fit)
    }

    /// One more pole, or several far apart, and whether there may be more; poles that came from elsewhere are only thinned out.
    pub fn add_round(
        mut self,
        model: &PoleModel,
        evidence: &mut Vec<SelectionStep>,
    ) -> (StepwiseResult, bool) {
        let start = self.fit_model(model, &[]);
        if !self.options.add_poles {
            let thinned = self.eliminate(start, evidence);
            return (self.into_grown(thinned), false);
        }
        let start = self.prune(start);
        let (fit, is_more) = self.next(start, evidence);
        (self.into_grown(fit), is_more)
    }

    fn into_grown(mut self, fit: ModelFit) -> StepwiseResult {
        let fit = self.recompress(fit);
        StepwiseResult {
            fit,
            compressed: (!self.lines.is_whole()).then(|| self.lines.problem.into_owned()),
            rejected: self.rejected,
            steps: self.steps,
            scans: self.scans,
            work: self.work,
        }
    }

    fn problem(&self) -> &[WhitenedProblem] {
        std::slice::from_ref(&*self.lines.problem)
    }

    /// A fit on the lines that poles and candidates need.
    fn fit_model(&mut self, model: &PoleModel, candidates: &[ScanPeak]) -> ModelFit {
        self.lines = self.condenser.compress(model, candidates);
        fit_at(self.problem(), model, self.numerators)
    }

    /// The same fit on the lines its poles need now.
    fn recompress(&mut self, fit: ModelFit) -> ModelFit {
        if self.lines.is_valid_for(&fit.model.poles) {
            return fit;
        }
        self.fit_model(&fit.model, &[])
    }

    /// Adds poles until none is worth it, or too many lie close to each other.
    fn add_poles(&mut self, mut fit: ModelFit, evidence: &mut Vec<SelectionStep>) -> ModelFit {
        loop {
            let (next, is_more) = self.next(fit, evidence);
            let is_crowd = self.options.fixed_pole_count.is_none()
                && is_crowd(&next.model.poles, self.measured.line_spacing);
            if !is_more || is_crowd {
                return next;
            }
            fit = next;
        }
    }

    /// The fit with more poles, or that at hand, settled, where none is worth it or no more are allowed; and which.
    fn next(&mut self, mut fit: ModelFit, evidence: &mut Vec<SelectionStep>) -> (ModelFit, bool) {
        loop {
            let count = fit.model.poles.len();
            let limit = self
                .options
                .fixed_pole_count
                .unwrap_or(self.options.max_poles);
            if count >= limit || self.work > self.allowed {
                return (fit, false);
            }
            // The scan of all places costs about a step.
            self.work += self.step_work(count);
            fit = self.recompress(fit);
            let peaks = self.worth_trying(&fit);
            let best = peaks.first().map_or(0.0, |p| p.gain);
            let candidates = distinct_peaks(
                &peaks,
                self.measured.line_spacing,
                MAX_BATCH.max(MAX_TRIALS),
            );
            if !candidates.is_empty() {
                fit = self.fit_model(&fit.model, &candidates);
            }
            if let Some(next) = self.try_batch(&fit, &peaks, limit - count, evidence) {
                self.settled = false;
                return (next, true);
            }
            // what poles not yet at their place leave next to them is not taken for others
            if !self.settled && !peaks.is_empty() {
                let before = fit.chi2;
                fit = refine(self.problem(), fit, self.numerators, STOP_BEFORE_SCAN);
                self.count_steps(fit.steps, count);
                self.settled = true;
                if before - fit.chi2 > self.threshold {
                    continue;
                }
            }
            if let Some(next) = self.try_single(&fit, &peaks, evidence) {
                self.settled = false;
                return (next, true);
            }
            if peaks.is_empty() {
                evidence.push(self.step(
                    &fit,
                    fit.chi2 - best,
                    1,
                    false,
                    "at the best place in the band, too little to try",
                ));
            }
            return (fit, false);
        }
    }

    /// Backward elimination: removes the poles that are not significant, the weakest first, down to the requested number, with the others
    /// refitted.
    fn eliminate(&mut self, start: ModelFit, evidence: &mut Vec<SelectionStep>) -> ModelFit {
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

    /// Poles in their places, on lines that serve them there.
    fn converge(&mut self, fit: ModelFit) -> ModelFit {
        let lines = &mut self.lines;
        let fit = (self.condenser).refine(fit, lines, self.numerators, STOP_BEFORE_SCAN);
        self.count_steps(fit.steps, fit.model.poles.len());
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

    fn worth_trying(&mut self, fit: &ModelFit) -> Vec<ScanPeak> {
        self.scans += 1;
        let least = if self.options.fixed_pole_count.is_some() {
            0.0
        } else {
            WORTH_TRYING * self.threshold
        };
        let mut peaks = if self.lines.is_whole() {
            scan(self.measured, &fit.fits[0].e, &fit.model.poles)
        } else {
            let left = residual(self.measured, &fit.model, self.numerators, &fit.fits[0]);
            scan(self.measured, &left, &fit.model.poles)
        };
        peaks.retain(|p| p.gain > least && !self.rejected.iter().any(|q| is_same_pole(q, &p.pole)));
        peaks
    }

    /// Poles far from each other, added together.
    fn try_batch(
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
    fn try_single(
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
        sort_falling(&mut tries, |a| a.0);
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

    /// Takes poles out whose numerators are not significant, the weakest first (Wald 1943), if a new fit confirms it.
    fn prune(&mut self, mut fit: ModelFit) -> ModelFit {
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
    fn drop_uncertain(&mut self, mut fit: ModelFit) -> ModelFit {
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

    /// More than half of the fall on one line, the others not significant, and the values of that line not in or out of phase as
    /// those of a mode with real constants are. For a random vector of m complex numbers with the second moments λ₁ ≥ λ₂ of its
    /// points, `4 λ₁λ₂/(λ₁+λ₂)²` is below u with probability `u^((m−1)/2)` (Mauchly 1940).
    fn is_outlier(&self, before: &Matrix, after: &Matrix) -> bool {
        const OUTLIER_PROBABILITY: f64 = 1e-3;
        let n = before.nrows() / 2;
        let falls = falls(before, after);
        let total: f64 = falls.iter().sum();
        let Some((line, largest)) = falls
            .iter()
            .copied()
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(&b.1))
        else {
            return false;
        };
        let dofs = parameters_per_pole(self.measured, self.numerators);
        if largest < 0.5 * total
            || total - largest > chi_squared_quantile(1.0 - OUTLIER_PROBABILITY, dofs)
        {
            return false;
        }
        let m = before.ncols();
        let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
        for i in 0..m {
            let (x, y) = (before[(line, i)], before[(n + line, i)]);
            xx += x * x;
            yy += y * y;
            xy += x * y;
        }
        let round = 4.0 * (xx * yy - xy * xy).max(0.0) / (xx + yy).powi(2);
        round.powf((m as f64 - 1.0) / 2.0) > OUTLIER_PROBABILITY
    }

    /// Without its best line the fall would not be half of what a pole must bring.
    fn is_on_a_line(&self, before: &Matrix, after: &Matrix) -> bool {
        let falls = falls(before, after);
        let largest = falls.iter().copied().fold(0.0, f64::max);
        falls.iter().sum::<f64>() - largest < 0.5 * self.threshold
    }

    fn step(
        &self,
        before: &ModelFit,
        chi2: f64,
        added: usize,
        accepted: bool,
        why: &str,
    ) -> SelectionStep {
        let fall = (before.chi2 - chi2).max(0.0) / added as f64;
        let places = PLACES_PER_LINE * self.measured.lines() as f64;
        let alone = chi_squared_sf(fall, parameters_per_pole(self.measured, self.numerators));
        SelectionStep {
            poles_before: before.model.poles.len(),
            poles_after: before.model.poles.len() + added,
            chi2_before: before.chi2,
            chi2_after: chi2,
            probability: (alone * places).min(1.0),
            accepted,
            reason: why.to_string(),
        }
    }
}

/// Decrease of the squared residual from one fit to another, by line.
fn falls(before: &Matrix, after: &Matrix) -> Vec<f64> {
    let n = before.nrows() / 2;
    let power = |e: &Matrix, k: usize| -> f64 {
        (0..e.ncols())
            .map(|i| e[(k, i)].powi(2) + e[(n + k, i)].powi(2))
            .sum()
    };
    (0..n).map(|k| power(before, k) - power(after, k)).collect()
}

/// More than a third of many poles lie next to another.
pub(super) fn is_crowd(poles: &[ScaledPole], step: f64) -> bool {
    let is_near = |a: &ScaledPole, b: &ScaledPole| {
        (a.w - b.w).abs() < CROWD_HALF_WIDTHS * a.sigma.max(step) && !std::ptr::eq(a, b)
    };
    let crowded = poles.iter().filter(|a| poles.iter().any(|b| is_near(a, b)));
    poles.len() >= MIN_CROWD && 3 * crowded.count() > poles.len()
}

/// Result of the stepwise selection.
pub(super) struct StepwiseResult {
    /// The fit, on `compressed` lines.
    pub fit: ModelFit,
    /// As many lines as its poles need; `None` for all.
    pub compressed: Option<WhitenedProblem>,
    /// Places that were tried in vain.
    pub rejected: Vec<ScaledPole>,
    /// Steps of all poles together.
    pub steps: usize,
    /// Scans made.
    pub scans: usize,
    /// Operations made, about.
    pub work: f64,
}

/// Why a pole is refused.
pub(super) const REASON_NOISE: &str = "no more than noise gives somewhere in the band";

/// Operations of one step of all poles together: a QR factorisation of the basis and its derivatives projected on it.
pub(super) fn step_work(problem: &WhitenedProblem, poles: usize, numerators: usize) -> f64 {
    let (lines, responses) = (problem.lines() as f64, problem.y.ncols() as f64);
    let columns = (numerators * poles + 2) as f64;
    20.0 * lines * columns * columns + 8.0 * lines * columns * responses
}

/// Real numbers one more pole brings.
fn parameters_per_pole(problem: &WhitenedProblem, numerators: usize) -> f64 {
    (numerators * problem.y.ncols() + 2) as f64
}

/// The same place, for what has been tried before.
fn is_same_pole(a: &ScaledPole, b: &ScaledPole) -> bool {
    a.overlap(b) > 0.6
}

/// The largest peaks whose gain is not that of a larger one seen through another width.
fn distinct_peaks(peaks: &[ScanPeak], step: f64, most: usize) -> Vec<ScanPeak> {
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

/// Rise of χ² if a pole's columns were taken out and the others remained fixed, for every pole.
pub(super) fn significance(fitted: &ModelFit, numerators: usize) -> Vec<f64> {
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
