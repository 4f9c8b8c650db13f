//! Lost or extra counts: places where the error steps by whole counts of an encoder and stays there.
//!
//! `D_i = mean(e_i … e_{i+w}) − mean(e_{i−w} … e_i)` stands out of its own median deviation; over a longer stretch the step remains.

use std::ops::Range;

use super::rows::{Rows, Scales, each};
use super::survey::Run;
use crate::base::error::Error;

/// A place where counts are missing or too many.
#[derive(Debug, Clone, PartialEq)]
pub struct Jump {
    /// The first row after it.
    pub row: usize,
    /// By how much the error steps, rad of the output.
    pub step: f64,
    /// Counts the encoder read too many; negative: missing.
    pub counts: f64,
    /// Of which encoder; both where a count of either would make the same step.
    pub whose: &'static str,
}

/// How the error is looked at.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    /// Turns of the output for one of the input.
    pub ratio: f64,
    /// Rows that pass in one tooth of the output.
    pub rows_per_tooth: f64,
}

/// Rows on either side of a place: to see a step, and to see that it stays.
const NARROW: (usize, usize) = (4, 24);

/// See [`NARROW`].
const WIDE: usize = 4096;

/// A step this many deviations out is one, where the deviation is of noise alone.
const STANDS_OUT: f64 = 8.0;

/// A step is one where it has this share of a count; and it stays where so much of it is left farther off.
const SHARE: f64 = 0.6;

/// How far a step may be from whole counts, in counts.
const WHOLE: f64 = 0.3;

/// Differences looked at to know the noise of all.
const SAMPLES: usize = 8192;

/// The places, in their order. Encoders without steps have none.
///
/// # Errors
/// Readings that cannot be read.
pub fn jumps(
    rows: &dyn Rows,
    scales: Scales,
    runs: &[Run],
    look: Look,
) -> Result<Vec<Jump>, Error> {
    let counts = (scales.input.step * look.ratio, scales.output.step);
    let smallest = [counts.0, counts.1]
        .into_iter()
        .filter(|c| *c > 0.0)
        .fold(f64::INFINITY, f64::min);
    if !smallest.is_finite() {
        return Ok(Vec::new());
    }
    let narrow = ((look.rows_per_tooth / 8.0) as usize).clamp(NARROW.0, NARROW.1);
    let wide = ((1.5 * look.rows_per_tooth) as usize).clamp(2 * narrow, WIDE);
    let windows = Windows { narrow, wide };
    let every = (rows.rows() / SAMPLES).max(1);
    let mut sizes = Vec::new();
    windows.slide(rows, scales, look.ratio, runs, |row, near, _| {
        if row.is_multiple_of(every) {
            sizes.push(near.abs());
        }
    })?;
    if sizes.is_empty() {
        return Ok(Vec::new());
    }
    sizes.sort_by(f64::total_cmp);
    // The median of the size of a normal variable is 0.6745 of its deviation.
    let deviation = sizes[sizes.len() / 2] / 0.6745;
    let least = (SHARE * smallest).max(STANDS_OUT * deviation);
    let mut found: Vec<(usize, f64, f64)> = Vec::new();
    windows.slide(rows, scales, look.ratio, runs, |row, near, far| {
        if near.abs() < least || far * near < 0.0 || far.abs() < SHARE * near.abs() {
            return;
        }
        match found.last_mut() {
            Some(last) if row - last.0 <= 2 * narrow => {
                if near.abs() > last.1.abs() {
                    *last = (row, near, far);
                }
            }
            _ => found.push((row, near, far)),
        }
    })?;
    let jump = |&(row, near, _): &(usize, f64, f64)| {
        let fit = |count: f64| {
            let n = (near / count).round();
            (n != 0.0 && (near / count - n).abs() < WHOLE * n.abs().sqrt()).then_some(n)
        };
        // Too many counts of the input turn the error back.
        let of_input = if counts.0 > 0.0 { fit(-counts.0) } else { None };
        let of_output = if counts.1 > 0.0 { fit(counts.1) } else { None };
        let (counts, whose) = match (of_input, of_output) {
            (Some(a), Some(b)) if (a + b).abs() < 0.5 => (b, "input or output"),
            (Some(a), Some(b)) if a.abs() < b.abs() => (a, "input"),
            (_, Some(b)) => (b, "output"),
            (Some(a), None) => (a, "input"),
            (None, None) => return None,
        };
        Some(Jump {
            row,
            step: near,
            counts,
            whose,
        })
    };
    let all: Vec<Jump> = found.iter().filter_map(jump).collect();
    Ok(if is_form(&all, runs) {
        Vec::new()
    } else {
        all
    })
}

/// Steps that come and go tooth by tooth are the shape of the teeth: many, and their sum is nothing.
fn is_form(all: &[Jump], runs: &[Run]) -> bool {
    const MANY: usize = 12;
    const NOTHING: f64 = 0.2;
    let sum: f64 = all.iter().map(|j| j.step).sum();
    let size: f64 = all.iter().map(|j| j.step.abs()).sum();
    all.len() > MANY * runs.len().max(1) && sum.abs() < NOTHING * size
}

/// Windows on either side of a row.
struct Windows {
    narrow: usize,
    wide: usize,
}

impl Windows {
    /// `see(row, step near, step over the wide windows)` wherever both fit into a run.
    fn slide(
        &self,
        rows: &dyn Rows,
        scales: Scales,
        ratio: f64,
        runs: &[Run],
        mut see: impl FnMut(usize, f64, f64),
    ) -> Result<(), Error> {
        // Running sums of the error, kept as far back as the windows reach.
        let mut sums: Vec<f64> = vec![0.0];
        let mut first = 0; // row of sums[0]
        let mut at = 0; // the next row to be judged
        let mut origin = None;
        each(rows, scales, |_, input, output| {
            let mut sum = sums.last().copied().unwrap_or(0.0);
            for (a, b) in input.iter().zip(output) {
                let e = b - ratio * a;
                sum += e - *origin.get_or_insert(e);
                sums.push(sum);
            }
            let end = first + sums.len() - 1; // rows seen
            for run in runs {
                let judged = run_inside(run, self.wide, at..end.saturating_sub(self.wide) + 1);
                for row in judged {
                    let s = |r: usize| sums[r - first];
                    let step = |w: usize| (s(row + w) - 2.0 * s(row) + s(row - w)) / w as f64;
                    see(row, step(self.narrow), step(self.wide));
                }
            }
            at = at.max((end + 1).saturating_sub(self.wide));
            let drop = at.saturating_sub(self.wide).saturating_sub(first);
            sums.drain(..drop);
            first += drop;
        })
    }
}

/// Rows of a run whose wide windows lie in it, of those wanted.
fn run_inside(run: &Run, wide: usize, wanted: Range<usize>) -> Range<usize> {
    let low = (run.rows.start + wide).max(wanted.start);
    let high = run.rows.end.saturating_sub(wide).min(wanted.end);
    low..high.max(low)
}
