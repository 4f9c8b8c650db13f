//! Poles one after another, or several far apart at once, for as long as the fall of χ² is more than noise would give at the best
//! of all places.

use crate::numeric::Matrix;
use crate::numeric::statistics::{chi_squared_above, chi_squared_quantile};

use super::Step;
use super::basis::{Pole, Problem};
use super::condensed::{Condensed, Condenser};
use super::covariance::covariance;
use super::local::{Placed, place};
use super::projection::{Fitted, Model, Stop, at, left, refine};
use super::scan::{Peak, scan};

/// What growth is told.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rules {
    /// Most pole pairs.
    pub most: usize,
    /// So many pole pairs whatever they gain.
    pub order: Option<usize>,
    /// Poles may be added; else they are only refined and taken out.
    pub grows: bool,
    /// Poles of the right half plane are allowed.
    pub unstable: bool,
    /// The variance is an estimate along the frequency axis, which a single bad line may escape.
    pub estimated: bool,
    /// Independent real numbers of data.
    pub data: f64,
    /// The variance holds departures from the model: a pole must gain on more lines than one.
    pub departs: bool,
}

/// How often noise alone may raise one pole too many.
const FALSE_ALARM: f64 = 1e-4;

/// Of a pole's independent places there are about four per line.
const PLACES_PER_LINE: f64 = 4.0;

/// Poles added at once, and places tried one by one.
const BATCH: usize = 12;
const TRIALS: usize = 4;

/// Steps of all poles together after one was added. No precision is bought before all are in.
const STEPS: usize = 6;

/// Before a place near a pole is looked at, the poles are brought to theirs.
const SETTLE: Stop = Stop {
    steps: 12,
    fall: 1.0,
    share: 1e-3,
};

/// Most changes of the lines on which poles that came from elsewhere are brought to their places.
const MOST_LINES: usize = 4;

/// A pole whose place is uncertain by more than this share of its half-width may be no pole of its own.
const UNCERTAIN: f64 = 0.2;

/// The others are brought to their best places without it.
const WITHOUT: Stop = Stop {
    steps: 30,
    fall: 1.0,
    share: 0.0,
};

/// Where of so many poles more than a third lie within [`CROWDED`] half-widths, or lines, of another, they explain a departure.
const CROWD: usize = 8;
const CROWDED: f64 = 2.0;

/// Poles added at once to a variance that holds departures are farther from each other than so many of their half-widths.
const CLEAR_OF_DEPARTURES: f64 = 20.0;

/// Poles added at once share less than this with any other, and are farther from it than so many lines.
const CLEAR: (f64, f64) = (0.1, 6.0);

/// A local fit sees most of what a pole gains; below this share of the threshold it is not worth a fit of all lines.
const NEAR_THRESHOLD: f64 = 0.7;

/// A peak of the scan is followed from this share of the threshold on: the scan cuts Lorentzians off.
const WORTH_TRYING: f64 = 0.3;

/// Searches at one weighting and one structure.
pub(super) struct Growth<'a> {
    /// All lines.
    measured: &'a Problem,
    condenser: Condenser<'a>,
    /// As many as the poles at hand need.
    lines: Condensed<'a>,
    numerators: usize,
    rules: Rules,
    /// Fall of χ² a pole must bring.
    pub threshold: f64,
    /// Places that were tried in vain.
    pub refused: Vec<Pole>,
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

impl<'a> Growth<'a> {
    /// `measured` holds all responses.
    pub fn new(measured: &'a Problem, numerators: usize, rules: Rules, allowed: f64) -> Growth<'a> {
        let places = PLACES_PER_LINE * measured.lines() as f64;
        let threshold =
            chi_squared_quantile(1.0 - FALSE_ALARM / places, freedoms(measured, numerators));
        Growth {
            measured,
            condenser: Condenser::new(measured),
            lines: Condensed::whole(measured),
            numerators,
            rules,
            threshold,
            refused: Vec::new(),
            settled: false,
            steps: 0,
            scans: 0,
            work: 0.0,
            allowed,
        }
    }

    fn took(&mut self, steps: usize, poles: usize) {
        self.steps += steps;
        self.work += steps as f64 * self.step_work(poles);
    }

    /// Operations of one step of all poles together: a QR factorisation of the basis and its derivatives projected on it.
    fn step_work(&self, poles: usize) -> f64 {
        let lines = match self.rules.departs {
            true => self.lines.problem.lines(),
            false => self.measured.lines(),
        } as f64;
        let responses = self.measured.y.ncols() as f64;
        let columns = (self.numerators * poles + 2) as f64;
        20.0 * lines * columns * columns + 8.0 * lines * columns * responses
    }

    /// From poles at hand to those that are worth it, with the lines they were fitted on.
    pub fn grown(mut self, model: &Model, evidence: &mut Vec<Step>) -> Grown {
        let start = self.fitted(model, &[]);
        let fitted = match self.rules.grows {
            true => {
                let start = self.prune(start);
                self.grow(start, evidence)
            }
            false => self.thinned(start, evidence),
        };
        let fitted = self.drop_uncertain(fitted);
        self.into_grown(fitted)
    }

    /// One more pole, or several far apart, and whether there may be more; poles that came from elsewhere are only thinned out.
    pub fn once(mut self, model: &Model, evidence: &mut Vec<Step>) -> (Grown, bool) {
        let start = self.fitted(model, &[]);
        if !self.rules.grows {
            let thinned = self.thinned(start, evidence);
            return (self.into_grown(thinned), false);
        }
        let start = self.prune(start);
        let (fitted, is_more) = self.next(start, evidence);
        (self.into_grown(fitted), is_more)
    }

    fn into_grown(mut self, fitted: Fitted) -> Grown {
        let fitted = self.served(fitted);
        Grown {
            fitted,
            fewer: (!self.lines.is_whole()).then(|| self.lines.problem.into_owned()),
            refused: self.refused,
            steps: self.steps,
            scans: self.scans,
            work: self.work,
        }
    }

    fn problem(&self) -> &[Problem] {
        std::slice::from_ref(&*self.lines.problem)
    }

    /// A fit on the lines that poles and candidates need.
    fn fitted(&mut self, model: &Model, candidates: &[Peak]) -> Fitted {
        self.lines = self.condenser.condensed(model, candidates);
        at(self.problem(), model, self.numerators)
    }

    /// The same fit on the lines its poles need now.
    fn served(&mut self, fitted: Fitted) -> Fitted {
        if self.lines.serves(&fitted.model.poles) {
            return fitted;
        }
        self.fitted(&fitted.model, &[])
    }

    /// Adds poles until none is worth it, or too many lie close to each other.
    fn grow(&mut self, mut fitted: Fitted, evidence: &mut Vec<Step>) -> Fitted {
        loop {
            let (next, is_more) = self.next(fitted, evidence);
            let is_crowd =
                self.rules.order.is_none() && is_crowd(&next.model.poles, self.measured.step);
            if !is_more || is_crowd {
                return next;
            }
            fitted = next;
        }
    }

    /// The fit with more poles, or that at hand, settled, where none is worth it or no more are allowed; and which.
    fn next(&mut self, mut fitted: Fitted, evidence: &mut Vec<Step>) -> (Fitted, bool) {
        loop {
            let count = fitted.model.poles.len();
            let limit = self.rules.order.unwrap_or(self.rules.most);
            if count >= limit || self.work > self.allowed {
                return (fitted, false);
            }
            // The scan of all places costs about a step.
            self.work += self.step_work(count);
            fitted = self.served(fitted);
            let peaks = self.worth_trying(&fitted);
            let best = peaks.first().map_or(0.0, |p| p.gain);
            let candidates = apart(&peaks, self.measured.step, BATCH.max(TRIALS));
            if !candidates.is_empty() {
                fitted = self.fitted(&fitted.model, &candidates);
            }
            if let Some(next) = self.several(&fitted, &peaks, limit - count, evidence) {
                self.settled = false;
                return (next, true);
            }
            // what poles not yet at their place leave beside them is not taken for others
            if !self.settled && !peaks.is_empty() {
                let before = fitted.chi2;
                fitted = refine(self.problem(), fitted, self.numerators, SETTLE);
                self.took(fitted.steps, count);
                self.settled = true;
                if before - fitted.chi2 > self.threshold {
                    continue;
                }
            }
            if let Some(next) = self.single(&fitted, &peaks, evidence) {
                self.settled = false;
                return (next, true);
            }
            if peaks.is_empty() {
                evidence.push(self.step(
                    &fitted,
                    fitted.chi2 - best,
                    1,
                    false,
                    "at the best place in the band, too little to try",
                ));
            }
            return (fitted, false);
        }
    }

    /// The poles at hand in their places, without those that are not significant, the weakest first; as many as are asked for.
    fn thinned(&mut self, start: Fitted, evidence: &mut Vec<Step>) -> Fitted {
        let mut fitted = self.settled(start);
        let most = self.rules.order.unwrap_or(0);
        while fitted.model.poles.len() > most {
            let significance = significance(&fitted, self.numerators);
            let by_weight = significance.into_iter().enumerate();
            let Some((weakest, _)) = by_weight.min_by(|a, b| a.1.total_cmp(&b.1)) else {
                break;
            };
            let without = self.without(&fitted, weakest);
            if self.rules.order.is_none() {
                let is_needed = without.chi2 - fitted.chi2 >= self.threshold;
                let why = if is_needed { "" } else { NOISE };
                evidence.push(self.step(&without, fitted.chi2, 1, is_needed, why));
                if is_needed {
                    break;
                }
            }
            fitted = self.settled(without);
        }
        fitted
    }

    /// Poles in their places, on lines that serve them there.
    fn settled(&mut self, mut fitted: Fitted) -> Fitted {
        for _ in 0..MOST_LINES {
            fitted = refine(self.problem(), fitted, self.numerators, SETTLE);
            self.took(fitted.steps, fitted.model.poles.len());
            if self.lines.serves(&fitted.model.poles) {
                break;
            }
            fitted = self.fitted(&fitted.model, &[]);
        }
        fitted
    }

    /// The fit without a pole, the others moved again.
    fn without(&mut self, fitted: &Fitted, r: usize) -> Fitted {
        let mut model = fitted.model.clone();
        model.poles.remove(r);
        let start = at(self.problem(), &model, self.numerators);
        let without = refine(self.problem(), start, self.numerators, SETTLE);
        self.took(without.steps, without.model.poles.len());
        without
    }

    fn worth_trying(&mut self, fitted: &Fitted) -> Vec<Peak> {
        self.scans += 1;
        let least = if self.rules.order.is_some() {
            0.0
        } else {
            WORTH_TRYING * self.threshold
        };
        let mut peaks = if self.lines.is_whole() {
            scan(self.measured, &fitted.fits[0].e, &fitted.model.poles)
        } else {
            let left = left(
                self.measured,
                &fitted.model,
                self.numerators,
                &fitted.fits[0],
            );
            scan(self.measured, &left, &fitted.model.poles)
        };
        peaks.retain(|p| p.gain > least && !self.refused.iter().any(|q| same(q, &p.pole)));
        peaks
    }

    /// Poles far from each other, added together.
    fn several(
        &mut self,
        fitted: &Fitted,
        peaks: &[Peak],
        most: usize,
        evidence: &mut Vec<Step>,
    ) -> Option<Fitted> {
        let least = self.threshold;
        let step = self.measured.step;
        let placed: Vec<Placed> = apart(peaks, step, BATCH.min(most))
            .iter()
            .filter(|p| p.gain > least)
            .filter_map(|p| self.place(fitted, p))
            .filter(|p| p.gain > least)
            .collect();
        let mut distinct: Vec<Placed> = Vec::new();
        for p in placed {
            let old = fitted.model.poles.iter();
            let mut others = old.chain(distinct.iter().map(|q| &q.pole));
            let is_clear = |q: &Pole| {
                let far = match self.rules.departs {
                    true => CLEAR_OF_DEPARTURES * (q.sigma + p.pole.sigma),
                    false => 0.0,
                };
                q.overlap(&p.pole) < CLEAR.0 && (q.w - p.pole.w).abs() > far.max(CLEAR.1 * step)
            };
            if others.all(is_clear) {
                distinct.push(p);
            }
        }
        if distinct.len() < 2 {
            return None;
        }
        let mut model = fitted.model.clone();
        model.poles.extend(distinct.iter().map(|p| p.pole));
        let next = self.polish(&model);
        let next = self.prune(next);
        let added = next
            .model
            .poles
            .len()
            .saturating_sub(fitted.model.poles.len());
        if added == 0 || fitted.chi2 - next.chi2 < self.threshold * added as f64 {
            return None;
        }
        evidence.push(self.step(fitted, next.chi2, added, true, ""));
        Some(next)
    }

    /// The best of a few places, tried in turn.
    fn single(
        &mut self,
        fitted: &Fitted,
        peaks: &[Peak],
        evidence: &mut Vec<Step>,
    ) -> Option<Fitted> {
        let step = self.measured.step;
        let mut tries: Vec<(f64, Model)> = Vec::new();
        for peak in apart(peaks, step, TRIALS) {
            let placed = self.place(fitted, &peak);
            let mut model = fitted.model.clone();
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
        tries.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (gain, model) in tries {
            let start = model.poles.last().copied()?;
            if gain < NEAR_THRESHOLD * self.threshold && self.rules.order.is_none() {
                evidence.push(self.step(fitted, fitted.chi2 - gain, 1, false, NOISE));
                self.refused.push(start);
                continue;
            }
            let next = self.polish(&model);
            let fall = fitted.chi2 - next.chi2;
            let forced = self.rules.order.is_some() && fall > 0.0;
            if fall < self.threshold && !forced {
                evidence.push(self.step(fitted, next.chi2, 1, false, NOISE));
                self.refused.push(start);
                continue;
            }
            let (before, after) = (&fitted.fits[0].e, &next.fits[0].e);
            let is_line = match self.rules.departs {
                true => self.is_on_a_line(before, after),
                false => self.rules.estimated && self.is_outlier(before, after),
            };
            if is_line && !forced {
                evidence.push(self.step(
                    fitted,
                    next.chi2,
                    1,
                    false,
                    "nearly all of it on one line, taken as a bad line",
                ));
                self.refused.push(start);
                continue;
            }
            let before = fitted.model.poles.len();
            let next = self.prune(next);
            if next.model.poles.len() <= before && fitted.chi2 - next.chi2 < self.threshold {
                self.refused.push(start);
                continue;
            }
            evidence.push(self.step(fitted, next.chi2, 1, true, ""));
            return Some(next);
        }
        None
    }

    fn place(&self, fitted: &Fitted, peak: &Peak) -> Option<Placed> {
        place(
            &self.problem()[0],
            fitted,
            self.numerators,
            peak,
            self.rules.unstable,
        )
    }

    /// All poles together, roughly.
    fn polish(&mut self, model: &Model) -> Fitted {
        let start = at(self.problem(), model, self.numerators);
        let fall = 0.02 * self.threshold * (start.chi2 / self.rules.data).max(1.0);
        let stop = Stop {
            steps: if self.rules.departs { STEPS / 2 } else { STEPS },
            fall: fall.max(1.0),
            share: 0.0,
        };
        let fitted = refine(self.problem(), start, self.numerators, stop);
        self.took(fitted.steps, fitted.model.poles.len());
        fitted
    }

    /// Takes poles out whose numerators are not significant, the weakest first (Wald 1943), if a new fit confirms it.
    fn prune(&mut self, mut fitted: Fitted) -> Fitted {
        if self.rules.order.is_some() {
            return fitted;
        }
        let mut kept: Vec<Pole> = Vec::new();
        loop {
            let weak = significance(&fitted, self.numerators)
                .into_iter()
                .enumerate()
                .filter(|&(r, s)| {
                    s < self.threshold && !kept.iter().any(|q| same(q, &fitted.model.poles[r]))
                })
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((r, _)) = weak else {
                return fitted;
            };
            let gone = fitted.model.poles[r];
            let without = self.without(&fitted, r);
            if without.chi2 - fitted.chi2 < self.threshold {
                fitted = without;
            } else {
                kept.push(gone);
            }
        }
    }

    /// Takes out poles that hardly have a place of their own, the least certain first, if the others, moved again, explain as much. Beside
    /// a heavily damped pole a second one may share what is its, at a place that does not matter; held still, both look significant.
    fn drop_uncertain(&mut self, mut fitted: Fitted) -> Fitted {
        if self.rules.order.is_some() {
            return fitted;
        }
        let mut kept: Vec<Pole> = Vec::new();
        loop {
            let unit = (fitted.chi2 / self.rules.data).max(1.0);
            let certain = covariance(self.problem(), &fitted, self.numerators);
            let share = |r: usize| -> f64 {
                let sigma = fitted.model.poles[r].sigma;
                certain.poles[r].map_or(f64::INFINITY, |[re, im, _]| {
                    (unit * re.max(im)).sqrt() / sigma
                })
            };
            let worst = (0..fitted.model.poles.len())
                .map(|r| (r, share(r)))
                .filter(|&(r, s)| {
                    s > UNCERTAIN && !kept.iter().any(|q| same(q, &fitted.model.poles[r]))
                })
                .max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((r, _)) = worst else {
                return fitted;
            };
            let mut model = fitted.model.clone();
            let gone = model.poles.remove(r);
            let start = at(self.problem(), &model, self.numerators);
            let without = refine(self.problem(), start, self.numerators, WITHOUT);
            self.took(without.steps, without.model.poles.len());
            if without.chi2 - fitted.chi2 < self.threshold * unit {
                fitted = without;
            } else {
                kept.push(gone);
            }
        }
    }

    /// More than half of the fall on one line, the others not significant, and the values of that line not in or out of phase as
    /// those of a mode with real constants are. For a random vector of m complex numbers with the second moments λ₁ ≥ λ₂ of its
    /// points, `4 λ₁λ₂/(λ₁+λ₂)²` is below u with probability `u^((m−1)/2)` (Mauchly 1940).
    fn is_outlier(&self, before: &Matrix, after: &Matrix) -> bool {
        const OF_LAW: f64 = 1e-3;
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
        let freedoms = freedoms(self.measured, self.numerators);
        if largest < 0.5 * total || total - largest > chi_squared_quantile(1.0 - OF_LAW, freedoms) {
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
        round.powf((m as f64 - 1.0) / 2.0) > OF_LAW
    }

    /// Without its best line the fall would not be half of what a pole must bring.
    fn is_on_a_line(&self, before: &Matrix, after: &Matrix) -> bool {
        let falls = falls(before, after);
        let largest = falls.iter().copied().fold(0.0, f64::max);
        falls.iter().sum::<f64>() - largest < 0.5 * self.threshold
    }

    fn step(&self, before: &Fitted, chi2: f64, added: usize, accepted: bool, why: &str) -> Step {
        let fall = (before.chi2 - chi2).max(0.0) / added as f64;
        let places = PLACES_PER_LINE * self.measured.lines() as f64;
        let alone = chi_squared_above(fall, freedoms(self.measured, self.numerators));
        Step {
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

/// What a fit gains over another on each line.
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
pub(super) fn is_crowd(poles: &[Pole], step: f64) -> bool {
    let is_near =
        |a: &Pole, b: &Pole| (a.w - b.w).abs() < CROWDED * a.sigma.max(step) && !std::ptr::eq(a, b);
    let crowded = poles.iter().filter(|a| poles.iter().any(|b| is_near(a, b)));
    poles.len() >= CROWD && 3 * crowded.count() > poles.len()
}

/// What a growth came to.
pub(super) struct Grown {
    /// The fit, on `fewer` lines.
    pub fitted: Fitted,
    /// As many lines as its poles need; `None` for all.
    pub fewer: Option<Problem>,
    /// Places that were tried in vain.
    pub refused: Vec<Pole>,
    /// Steps of all poles together.
    pub steps: usize,
    /// Scans made.
    pub scans: usize,
    /// Operations made, about.
    pub work: f64,
}

/// Why a pole is refused.
pub(super) const NOISE: &str = "no more than noise gives somewhere in the band";

/// Real numbers one more pole brings.
fn freedoms(problem: &Problem, numerators: usize) -> f64 {
    (numerators * problem.y.ncols() + 2) as f64
}

/// The same place, for what has been tried before.
fn same(a: &Pole, b: &Pole) -> bool {
    a.overlap(b) > 0.6
}

/// The largest peaks whose gain is not that of a larger one seen through another width.
fn apart(peaks: &[Peak], step: f64, most: usize) -> Vec<Peak> {
    let mut chosen: Vec<Peak> = Vec::new();
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

/// Rise of χ² if a pole's columns were taken out and the others stood still, for every pole.
pub(super) fn significance(fitted: &Fitted, numerators: usize) -> Vec<f64> {
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
