//! Steps of the error and what index pulses say of them: whose counts they are, which are none, and which the error hides.

use super::index::{Index, Shift};
use super::jumps::Jump;
use super::rows::{Part, Rows, Scales, each};
use crate::base::error::{Error, Warning};

/// What index pulses know, while steps are judged by it.
pub struct Verdict<'a> {
    /// Of input and output.
    indices: [Option<&'a Index>; 2],
    /// Turns of the output for one of the input.
    ratio: f64,
    /// Shifts that no step has been given yet.
    open: [Vec<Shift>; 2],
    /// Steps that are no counts.
    pub refuted: Vec<Jump>,
}

/// A step is that of a shift where both agree to this share of a count.
const AGREE: f64 = 0.5;

/// An index knows counts well enough to rule on a step of so many of its deviations.
const KNOWS: f64 = 4.5;

impl<'a> Verdict<'a> {
    /// Nothing judged so far.
    pub fn new(indices: [Option<&'a Index>; 2], ratio: f64) -> Verdict<'a> {
        Verdict {
            open: indices.map(|i| i.map_or(Vec::new(), |i| i.shifts.clone())),
            indices,
            ratio,
            refuted: Vec::new(),
        }
    }

    /// What a count too many does to the error, rad of the output.
    fn unit(&self, shaft: usize) -> f64 {
        let count = self.indices[shaft].map_or(0.0, Index::count);
        if shaft == 0 {
            -count * self.ratio
        } else {
            count
        }
    }

    /// Steps that stay, with their encoder where an index tells it.
    pub fn judge(&mut self, jumps: Vec<Jump>) -> Vec<Jump> {
        let mut kept = Vec::new();
        for jump in jumps {
            match self.one(jump.clone()) {
                Some(jump) => kept.push(jump),
                None => self.refuted.push(jump),
            }
        }
        kept
    }

    fn one(&mut self, mut jump: Jump) -> Option<Jump> {
        let names = ["input", "output"];
        let row = jump.row as f64;
        for shaft in 0..2 {
            let unit = self.unit(shaft);
            let agrees = |s: &Shift| {
                s.rows.0 <= row
                    && row <= s.rows.1 + 1.0
                    && (s.counts * unit - jump.step).abs()
                        < AGREE * unit.abs() + 0.1 * jump.step.abs()
            };
            if let Some(at) = self.open[shaft].iter().position(agrees) {
                let shift = self.open[shaft].remove(at);
                (jump.counts, jump.whose, jump.or) = (shift.counts, names[shaft], None);
                return Some(jump);
            }
        }
        // The counts of a shaft are in order there: it was not this one.
        let cleared = |shaft: usize| {
            let unit = self.unit(shaft).abs();
            let known = self.indices[shaft].and_then(|i| i.known_at(jump.row));
            known.is_some_and(|d| jump.step.abs() / unit > KNOWS * d)
        };
        match (cleared(0), cleared(1)) {
            (true, true) => None,
            (false, false) => Some(jump),
            (input, _) => {
                let left = if input { "output" } else { "input" };
                match jump.or.take() {
                    Some((counts, whose)) if whose == left => {
                        (jump.counts, jump.whose) = (counts, whose);
                    }
                    _ if jump.whose.contains(left) => jump.whose = left,
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
    pub fn hidden(
        &mut self,
        rows: &dyn Rows,
        scales: Scales,
        window: usize,
    ) -> Result<Vec<Jump>, Error> {
        let mut all = Vec::new();
        for (shaft, whose) in ["input", "output"].into_iter().enumerate() {
            for shift in std::mem::take(&mut self.open[shaft]) {
                let step = shift.counts * self.unit(shaft);
                all.push(Jump {
                    row: self.best_row(rows, scales, shift, step, window)?,
                    step,
                    counts: shift.counts,
                    whose,
                    or: None,
                });
            }
        }
        Ok(all)
    }

    /// The row between two passages at which the error steps most in a direction, over `window` rows on either side.
    fn best_row(
        &self,
        rows: &dyn Rows,
        scales: Scales,
        shift: Shift,
        step: f64,
        window: usize,
    ) -> Result<usize, Error> {
        let (low, high) = (shift.rows.0 as usize, shift.rows.1.ceil() as usize);
        let from = low.saturating_sub(window);
        let part = Part {
            rows,
            from,
            count: (high + window).min(rows.rows()) - from,
        };
        let mut sums = vec![0.0];
        let (mut sum, mut origin) = (0.0, None);
        each(&part, scales, |_, input, output| {
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
    pub fn warnings(&self) -> Vec<Warning> {
        let one = |jump: &Jump| Warning {
            code: "step-without-counts",
            message: format!(
                "the error steps by {:.2} arcsec at row {} and stays, and the index pulses say that no counts are lost: it is left in",
                jump.step.to_degrees() * 3600.0,
                jump.row + 1
            ),
            hint: Some("something slipped a little, a seat or an encoder moved: look there".into()),
        };
        self.refuted.iter().map(one).collect()
    }
}
