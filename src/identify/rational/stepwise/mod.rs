//! Stepwise selection of poles: forward addition while Δχ² is significant, backward elimination (Wald).

mod addition;
mod elimination;
mod single_line;
mod sub_bands;

mod noise_windows;

use std::borrow::Cow;

use self::addition::distinct_peaks;
use self::sub_bands::{MAX_JOINT_POLES, MAX_PASSES};
use super::SelectionStep;
use super::basis::{ScaledPole, WhitenedProblem};
use super::line_compression::{CompressedProblem, Compressor};
use super::projection::{ModelFit, PoleModel, StopCriteria, fit_at, refine, residual};
use super::scan::ScanPeak;
use crate::numeric::Matrix;
use crate::numeric::statistics::{chi_squared_quantile, chi_squared_sf};

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
    /// Operations allowed.
    pub max_work: f64,
    /// Further operations allowed once if noise explains windows of lines.
    pub dense_work: f64,
}

/// Probability that noise alone adds one pole too many.
const FALSE_ALARM: f64 = 1e-4;

/// Number of independent pole places per line, about four.
const PLACES_PER_LINE: f64 = 4.0;

/// Poles added at once, and places tried one by one.
const MAX_BATCH: usize = 12;
const MAX_TRIALS: usize = 4;

/// Before a place near a pole is looked at, the poles are brought to theirs.
const STOP_BEFORE_SCAN: StopCriteria = StopCriteria {
    steps: 12,
    min_decrease: 1.0,
    min_relative_decrease: 1e-3,
};

/// Least number of poles of which more than a third lie within [`CROWD_HALF_WIDTHS`] half-widths, or lines, of another, and thus explain a
/// departure.
const MIN_CROWD: usize = 8;
const CROWD_HALF_WIDTHS: f64 = 2.0;

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
    /// Operations made, about, without those by sub-bands.
    pub work: f64,
}

impl<'a> StepwiseSearch<'a> {
    /// `measured` holds all responses.
    pub fn new(
        measured: &'a WhitenedProblem,
        numerators: usize,
        options: StepwiseOptions,
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

    /// From initial poles to the significant ones, with the lines they were fitted on.
    pub fn run(mut self, model: &PoleModel, evidence: &mut Vec<SelectionStep>) -> StepwiseResult {
        let start = self.fit_model(model, &[]);
        let fit = match self.options.add_poles {
            true => {
                let start = self.prune(start);
                self.add_poles(start, evidence)
            }
            false => self.eliminate(start, evidence),
        };
        let fit = match self.is_crowd(&fit.model.poles) {
            true => fit,
            false => self.drop_uncertain(fit),
        };
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
            compressed: (!self.lines.is_uncompressed()).then(|| self.lines.problem.into_owned()),
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

    /// Residual on the measured lines of a fit to condensed ones.
    fn residual_on_all_lines<'f>(&self, fit: &'f ModelFit) -> Cow<'f, Matrix> {
        let of_lines = &fit.fits[0];
        match self.lines.is_uncompressed() {
            true => Cow::Borrowed(&of_lines.e),
            false => {
                let all = residual(self.measured, &fit.model, self.numerators, of_lines);
                Cow::Owned(all)
            }
        }
    }

    /// The same fit on the lines its poles need now.
    fn recompress(&mut self, fit: ModelFit) -> ModelFit {
        if self.lines.is_valid_for(&fit.model.poles) {
            return fit;
        }
        self.fit_model(&fit.model, &[])
    }

    /// Adds poles until none is significant, or too many lie close to each other.
    fn add_poles(&mut self, mut fit: ModelFit, evidence: &mut Vec<SelectionStep>) -> ModelFit {
        let mut passes = 0;
        loop {
            let is_many = fit.model.poles.len() > MAX_JOINT_POLES;
            let (next, is_more) = match is_many && self.options.fixed_pole_count.is_none() {
                true => {
                    passes += 1;
                    self.next_by_sub_band(fit, evidence)
                }
                false => self.next(fit, evidence),
            };
            if !is_more || passes == MAX_PASSES || self.is_crowd(&next.model.poles) {
                return next;
            }
            fit = next;
        }
    }

    /// Whether poles are crowded; never of a requested number.
    fn is_crowd(&self, poles: &[ScaledPole]) -> bool {
        self.options.fixed_pole_count.is_none() && is_crowd(poles, self.measured.line_spacing)
    }

    /// The fit with more poles, or that at hand, settled, where none is worth it or no more are allowed; and which.
    fn next(&mut self, mut fit: ModelFit, evidence: &mut Vec<SelectionStep>) -> (ModelFit, bool) {
        loop {
            let count = fit.model.poles.len();
            let limit = self
                .options
                .fixed_pole_count
                .unwrap_or(self.options.max_poles);
            if count >= limit || self.work > self.options.max_work {
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
                    "too little to try, even at the best frequency",
                ));
            }
            return (fit, false);
        }
    }

    /// Poles in their places, on lines that serve them there.
    fn converge(&mut self, fit: ModelFit) -> ModelFit {
        let lines = &mut self.lines;
        let fit = (self.condenser).refine(fit, lines, self.numerators, STOP_BEFORE_SCAN);
        self.count_steps(fit.steps, fit.model.poles.len());
        fit
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
