//! Check of count steps against the index pulses of both shafts.

use super::count_steps::CountStep;
use super::index_pulses::{CountShift, IndexEvaluation};
use super::readings::{EncoderReadings, EncoderScales, ReadingsRange, for_each_block};
use crate::base::error::{Diagnostic, Error};

/// Index-pulse evidence by which steps are judged.
pub struct CountCheck<'a> {
    /// Index evaluations of input and output.
    indices: [Option<&'a IndexEvaluation>; 2],
    /// Turns of the output for one of the input.
    ratio: f64,
    /// Shifts that no step has been given yet.
    unmatched: [Vec<CountShift>; 2],
    /// Steps that are no counts.
    pub rejected: Vec<CountStep>,
}

/// A step is that of a shift where both agree to this share of a count.
const AGREEMENT: f64 = 0.5;

/// An index knows counts well enough to rule on a step of so many of its deviations.
const MIN_DEVIATIONS: f64 = 4.5;

impl<'a> CountCheck<'a> {
    /// Nothing judged so far.
    pub fn new(indices: [Option<&'a IndexEvaluation>; 2], ratio: f64) -> CountCheck<'a> {
        CountCheck {
            unmatched: indices.map(|i| i.map_or(Vec::new(), |i| i.shifts.clone())),
            indices,
            ratio,
            rejected: Vec::new(),
        }
    }

    /// Error caused by one extra count, rad of the output.
    fn unit(&self, shaft: usize) -> f64 {
        let count = self.indices[shaft].map_or(0.0, IndexEvaluation::count_angle);
        if shaft == 0 {
            -count * self.ratio
        } else {
            count
        }
    }

    /// Steps that stay, with their encoder where an index tells it.
    pub fn confirm_steps(&mut self, jumps: Vec<CountStep>) -> Vec<CountStep> {
        let mut kept = Vec::new();
        for jump in jumps {
            match self.confirm_step(jump.clone()) {
                Some(jump) => kept.push(jump),
                None => self.rejected.push(jump),
            }
        }
        kept
    }

    fn confirm_step(&mut self, mut jump: CountStep) -> Option<CountStep> {
        let names = ["input", "output"];
        let row = jump.row as f64;
        for shaft in 0..2 {
            let unit = self.unit(shaft);
            let agrees = |s: &CountShift| {
                s.rows.0 <= row
                    && row <= s.rows.1 + 1.0
                    && (s.counts * unit - jump.step).abs()
                        < AGREEMENT * unit.abs() + 0.1 * jump.step.abs()
            };
            if let Some(at) = self.unmatched[shaft].iter().position(agrees) {
                let shift = self.unmatched[shaft].remove(at);
                (jump.counts, jump.encoder, jump.alternative) = (shift.counts, names[shaft], None);
                return Some(jump);
            }
        }
        // The counts of a shaft are in order there: it was not this one.
        let cleared = |shaft: usize| {
            let unit = self.unit(shaft).abs();
            let known = self.indices[shaft].and_then(|i| i.count_uncertainty(jump.row));
            known.is_some_and(|d| jump.step.abs() / unit > MIN_DEVIATIONS * d)
        };
        match (cleared(0), cleared(1)) {
            (true, true) => None,
            (false, false) => Some(jump),
            (input, _) => {
                let left = if input { "output" } else { "input" };
                match jump.alternative.take() {
                    Some((counts, whose)) if whose == left => {
                        (jump.counts, jump.encoder) = (counts, whose);
                    }
                    _ if jump.encoder.contains(left) => jump.encoder = left,
                    // Only counts of the cleared shaft make this step.
                    _ => return None,
                }
                Some(jump)
            }
        }
    }

    /// Shifts that no step of the error showed, as steps at the rows that fit best.
    ///
    /// # Errors
    /// Readings that cannot be read.
    pub fn undetected_shifts(
        &mut self,
        rows: &dyn EncoderReadings,
        scales: EncoderScales,
        window: usize,
    ) -> Result<Vec<CountStep>, Error> {
        let mut all = Vec::new();
        for (shaft, whose) in ["input", "output"].into_iter().enumerate() {
            for shift in std::mem::take(&mut self.unmatched[shaft]) {
                let step = shift.counts * self.unit(shaft);
                all.push(CountStep {
                    row: self.best_row(rows, scales, shift, step, window)?,
                    step,
                    counts: shift.counts,
                    encoder: whose,
                    alternative: None,
                });
            }
        }
        Ok(all)
    }

    /// The row between two passages at which the error steps most in a direction, over `window` rows on either side.
    fn best_row(
        &self,
        rows: &dyn EncoderReadings,
        scales: EncoderScales,
        shift: CountShift,
        step: f64,
        window: usize,
    ) -> Result<usize, Error> {
        let (low, high) = (shift.rows.0 as usize, shift.rows.1.ceil() as usize);
        let from = low.saturating_sub(window);
        let part = ReadingsRange {
            rows,
            from,
            count: (high + window).min(rows.n_rows()) - from,
        };
        let mut sums = vec![0.0];
        let (mut sum, mut origin) = (0.0, None);
        for_each_block(&part, scales, |_, input, output| {
            for (a, b) in input.iter().zip(output) {
                let e = b - self.ratio * a;
                sum += e - *origin.get_or_insert(e);
                sums.push(sum);
            }
        })?;
        let at = |i: usize| sums[i + window] - 2.0 * sums[i] + sums[i - window];
        let best = (low - from..=high - from)
            .filter(|&i| i >= window && i + window < sums.len())
            .max_by(|&i, &j| (step * at(i)).total_cmp(&(step * at(j))));
        Ok(best.map_or(low.midpoint(high), |i| from + i))
    }

    /// Says which steps are no counts.
    pub fn warnings(&self) -> Vec<Diagnostic> {
        let one = |jump: &CountStep| Diagnostic {
            code: "step-without-counts",
            message: format!(
                "the error steps by {:.2} arcsec at row {} and stays, and the index pulses say that no counts are lost: it is left in",
                jump.step.to_degrees() * 3600.0,
                jump.row + 1
            ),
            hint: Some("a seat, a coupling or an encoder moved slightly: check them".into()),
        };
        self.rejected.iter().map(one).collect()
    }
}
