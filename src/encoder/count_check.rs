//! Check of count steps against the index pulses of both shafts.

use super::count_steps::CountStep;
use super::index_pulses::{CountShift, IndexEvaluation};
use super::readings::{EncoderReadings, EncoderScales, ReadingsRange, for_each_block};
use crate::base::error::{Diagnostic, Error};

/// Check of count steps with the index pulses of both shafts.
pub struct CountCheck<'a> {
    /// Index evaluations of input and output.
    indices: [Option<&'a IndexEvaluation>; 2],
    /// Output revolutions per input revolution.
    ratio: f64,
    /// Count shifts of input and output without an assigned step.
    unmatched: [Vec<CountShift>; 2],
    /// Steps that lost or extra counts do not explain.
    pub rejected: Vec<CountStep>,
}

/// Largest difference of a step and a count shift that agree, counts.
const AGREEMENT: f64 = 0.5;

/// Smallest step, in standard deviations of the count, that an index evaluation can rule out.
const MIN_DEVIATIONS: f64 = 4.5;

impl<'a> CountCheck<'a> {
    /// Creates a check without assigned steps; `ratio` is output revolutions per input revolution.
    pub fn new(indices: [Option<&'a IndexEvaluation>; 2], ratio: f64) -> CountCheck<'a> {
        CountCheck {
            unmatched: indices.map(|i| i.map_or(Vec::new(), |i| i.shifts.clone())),
            indices,
            ratio,
            rejected: Vec::new(),
        }
    }

    /// Transmission error of one extra count of a shaft (0: input, 1: output), rad of the output.
    fn count_error(&self, shaft: usize) -> f64 {
        let count = self.indices[shaft].map_or(0.0, IndexEvaluation::count_angle);
        if shaft == 0 {
            -count * self.ratio
        } else {
            count
        }
    }

    /// Confirms steps and assigns them to an encoder if an index evaluation identifies it; the others join `rejected`.
    pub fn confirm_steps(&mut self, steps: Vec<CountStep>) -> Vec<CountStep> {
        let mut confirmed = Vec::new();
        for step in steps {
            match self.confirm_step(step.clone()) {
                Some(step) => confirmed.push(step),
                None => self.rejected.push(step),
            }
        }
        confirmed
    }

    fn confirm_step(&mut self, mut step: CountStep) -> Option<CountStep> {
        let names = ["input", "output"];
        let row = step.row as f64;
        for shaft in 0..2 {
            let count_error = self.count_error(shaft);
            let agrees = |s: &CountShift| {
                s.rows.0 <= row
                    && row <= s.rows.1 + 1.0
                    && (s.counts * count_error - step.step).abs()
                        < AGREEMENT * count_error.abs() + 0.1 * step.step.abs()
            };
            if let Some(index) = self.unmatched[shaft].iter().position(agrees) {
                let shift = self.unmatched[shaft].remove(index);
                (step.counts, step.encoder, step.alternative) = (shift.counts, names[shaft], None);
                return Some(step);
            }
        }
        // True if the index pulses rule out lost or extra counts of the shaft.
        let is_excluded = |shaft: usize| {
            let count_error = self.count_error(shaft).abs();
            let deviation = self.indices[shaft].and_then(|i| i.count_uncertainty(step.row));
            deviation.is_some_and(|d| step.step.abs() / count_error > MIN_DEVIATIONS * d)
        };
        match (is_excluded(0), is_excluded(1)) {
            (true, true) => None,
            (false, false) => Some(step),
            (input, _) => {
                let remaining = if input { "output" } else { "input" };
                match step.alternative.take() {
                    Some((counts, encoder)) if encoder == remaining => {
                        (step.counts, step.encoder) = (counts, encoder);
                    }
                    _ if step.encoder.contains(remaining) => step.encoder = remaining,
                    // Only counts of the excluded shaft would cause this step.
                    _ => return None,
                }
                Some(step)
            }
        }
    }

    /// Takes the count shifts without a step and locates each as a step at the row that fits best; `window` in rows.
    ///
    /// # Errors
    /// Readings that cannot be read.
    pub fn undetected_shifts(
        &mut self,
        rows: &dyn EncoderReadings,
        scales: EncoderScales,
        window: usize,
    ) -> Result<Vec<CountStep>, Error> {
        let mut steps = Vec::new();
        for (shaft, encoder) in ["input", "output"].into_iter().enumerate() {
            for shift in std::mem::take(&mut self.unmatched[shaft]) {
                let step = shift.counts * self.count_error(shaft);
                steps.push(CountStep {
                    row: self.best_row(rows, scales, shift, step, window)?,
                    step,
                    counts: shift.counts,
                    encoder,
                    alternative: None,
                });
            }
        }
        Ok(steps)
    }

    /// Row between two passages with the largest change of the mean error over `window` rows, in the direction of `step`.
    fn best_row(
        &self,
        rows: &dyn EncoderReadings,
        scales: EncoderScales,
        shift: CountShift,
        step: f64,
        window: usize,
    ) -> Result<usize, Error> {
        let (start, end) = (shift.rows.0 as usize, shift.rows.1.ceil() as usize);
        let first = start.saturating_sub(window);
        let range = ReadingsRange {
            rows,
            first,
            count: (end + window).min(rows.n_rows()) - first,
        };
        let mut sums = vec![0.0];
        let (mut sum, mut origin) = (0.0, None);
        for_each_block(&range, scales, |_, input, output| {
            for (a, b) in input.iter().zip(output) {
                let error = b - self.ratio * a;
                sum += error - *origin.get_or_insert(error);
                sums.push(sum);
            }
        })?;
        let jump = |i: usize| sums[i + window] - 2.0 * sums[i] + sums[i - window];
        let best = (start - first..=end - first)
            .filter(|&i| i >= window && i + window < sums.len())
            .max_by(|&i, &j| (step * jump(i)).total_cmp(&(step * jump(j))));
        Ok(best.map_or(start.midpoint(end), |i| first + i))
    }

    /// Warnings of the rejected steps.
    pub fn warnings(&self) -> Vec<Diagnostic> {
        let warning = |step: &CountStep| Diagnostic {
            code: "step-without-counts",
            message: format!(
                "the error steps by {:.2} arcsec at row {} and stays, and the index pulses say that no counts are lost: it is left in",
                step.step.to_degrees() * 3600.0,
                step.row + 1
            ),
            hint: Some("a seat, a coupling or an encoder moved slightly: check them".into()),
        };
        self.rejected.iter().map(warning).collect()
    }
}
