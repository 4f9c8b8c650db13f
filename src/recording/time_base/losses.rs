//! Lost samples in uneven or coarse stamps: distinguished from late stamps, or refused.

use std::collections::VecDeque;
use std::ops::Range;

use super::typical_step::TypicalStep;
use super::{CERTAIN_GAP_STEPS, Gap, TimeBase, for_each_stamp};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::recording::raw::{RawTiming, TimeStamps};
use crate::recording::resolution::Resolution;

/// Steps this close to [`GAP`], in usual steps, are as well a lost sample as a late stamp.
const AMBIGUOUS_STEPS: Range<f64> = 1.4..1.6;

/// Rows to either side of a step by which samples lost in it show: stamps that deviate by 0.3 steps, as those do that are uneven by
/// half a step, leave their shift uncertain by `0.3 √(8/64)` = 0.1 steps.
const LEVEL_ROWS: usize = 64;

/// The stamps of all rows after a lost sample lie a whole step later; by this much they do or do not.
const MIN_LEVEL_SHIFT: f64 = 0.5;

/// Whether steps about the length that makes a gap are common, in stamps fine enough to tell.
pub(super) fn are_ambiguous(
    stamps: &TimeStamps,
    resolution: &Resolution,
    usual: &TypicalStep,
) -> Result<bool, Error> {
    /// Coarsest stamp resolution examined, as a part of a step.
    const FINE_RESOLUTION: f64 = 0.25;
    /// One or two may be pauses; so may one step in a thousand.
    const TOLERATED_PAUSES: (usize, usize) = (3, 1000);
    let finest = FINE_RESOLUTION * usual.median_s;
    if !(usual.median_s > 0.0 && resolution.finest_s < finest) {
        return Ok(false);
    }
    let [least, most] = [AMBIGUOUS_STEPS.start, AMBIGUOUS_STEPS.end].map(|n| n * usual.median_s);
    let (mut last, mut neither) = (f64::NAN, 0);
    for_each_stamp(&stamps.seconds, |_, t| {
        let is_neither = (least..most).contains(&(t - last));
        neither += usize::from(is_neither && resolution.unit_at(t) < finest);
        last = t;
        Ok(())
    })?;
    Ok(neither >= TOLERATED_PAUSES.0 && neither * TOLERATED_PAUSES.1 >= stamps.seconds.len())
}

/// Refuses stamps that lie later, by half a step and more, from a row on than those before let expect, where no sure gap is near:
/// with `t = a + b row` before the row and `t = a + c + b row` after it, c by least squares.
pub(super) fn check_hidden_losses(
    timing: &RawTiming,
    stamps: &TimeStamps,
    usual: &TypicalStep,
) -> Result<(), Error> {
    let mut near = VecDeque::new();
    // The row of the largest shift in a run of them, the shift, and whether a sure gap is in the run.
    let mut run: Option<(usize, f64, bool)> = None;
    let (mut hidden, mut last_shifted) = (None, 0);
    for_each_stamp(&stamps.seconds, |row, t| {
        near.push_back(t);
        if near.len() > 2 * LEVEL_ROWS {
            near.pop_front();
        }
        if near.len() < 2 * LEVEL_ROWS {
            return Ok(());
        }
        let at = row + 1 - LEVEL_ROWS;
        let shift = level(near.make_contiguous()) / usual.median_s;
        let step = (near[LEVEL_ROWS] - near[LEVEL_ROWS - 1]) / usual.median_s;
        if shift.abs() >= MIN_LEVEL_SHIFT {
            let (first, most, sure) = run.unwrap_or((at, 0.0, false));
            let largest = if shift.abs() > most { at } else { first };
            run = Some((
                largest,
                most.max(shift.abs()),
                sure || step >= CERTAIN_GAP_STEPS,
            ));
            last_shifted = at;
        } else if let Some((row, _, sure)) = run.filter(|_| at > last_shifted + LEVEL_ROWS) {
            hidden = hidden.or((!sure).then_some(row));
            run = None;
        }
        Ok(())
    })?;
    let open = run.filter(|r| !r.2).map(|r| r.0);
    let Some(row) = hidden.or(open) else {
        return Ok(());
    };
    let place = match timing.lines.line_of_row(row) {
        Some(line) => format!("about line {line}"),
        None => format!("about sample {}", row + 1),
    };
    let message = format!(
        "the time stamps are too uneven to distinguish lost samples from late stamps: {place} they move by half a step and more"
    );
    Err(Error::new(Code::InvalidTimeStamps, message)
        .with_hint("log with even steps, or leave the stamps aside: --time none --rate HZ"))
}

/// By how much the second half of stamps lies later than the first, beyond the steps between them.
fn level(stamps: &[f64]) -> f64 {
    let (before, after) = stamps.split_at(stamps.len() / 2);
    let n = before.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let sums = |half: &[f64]| {
        let mean = half.iter().map(|t| t - stamps[0]).sum::<f64>() / n;
        let moment = half.iter().enumerate();
        let moment: f64 = moment
            .map(|(k, t)| (k as f64 - middle) * (t - stamps[0] - mean))
            .sum();
        (mean, moment)
    };
    let ((first, one), (second, two)) = (sums(before), sums(after));
    let step = (one + two) / (n * (n * n - 1.0) / 6.0);
    second - first - n * step
}

/// Whether the steps of two units, gaps in `strict` and not in `found`, are samples lost: few, and not as even as those of a clock a
/// little slower than its digits.
pub(super) fn are_lost(found: &TimeBase, strict: &TimeBase, rows: usize) -> bool {
    /// More than one in so many rows is how such a clock runs.
    const MIN_ROWS_PER_LOSS: usize = 200;
    /// Any one or two may be even.
    const MIN_LOSSES: usize = 3;
    /// Largest deviation of the distances of even steps from their mean.
    const MAX_SPACING_DEVIATION: f64 = 0.25;
    let is_new = |gap: &&Gap| !found.gaps.iter().any(|g| g.row == gap.row);
    let places: Vec<f64> = (strict.gaps.iter().filter(is_new))
        .map(|gap| gap.row as f64)
        .collect();
    let (Some(first), Some(last)) = (places.first(), places.last()) else {
        return false;
    };
    let period = (last - first) / (places.len() - 1).max(1) as f64;
    let most = (1.0 + MAX_SPACING_DEVIATION) * period;
    let even = |pair: &[f64]| ((pair[1] - pair[0]) / period - 1.0).abs() < MAX_SPACING_DEVIATION;
    let by_clock = places.len() >= MIN_LOSSES
        && places.windows(2).all(even)
        && *first < most
        && rows as f64 - last < most;
    places.len() * MIN_ROWS_PER_LOSS <= rows && !by_clock
}
