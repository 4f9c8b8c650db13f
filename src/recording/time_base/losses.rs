//! Detection of lost samples in uneven or coarse stamps: distinguishes them from late stamps or rejects the stamps.

use std::collections::VecDeque;
use std::ops::Range;

use super::typical_step::TypicalStep;
use super::{CERTAIN_GAP_STEPS, Gap, TimeBase, for_each_stamp};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::recording::raw::{RawTiming, TimeStamps};
use crate::recording::resolution::Resolution;

/// Range of steps, in typical steps, that may be a lost sample or a late stamp.
const AMBIGUOUS_STEPS: Range<f64> = 1.4..1.6;

/// Rows to either side of a step that determine its shift: stamps uneven by half a step have a standard deviation of 0.3 steps,
/// and their shift has `0.3 √(8/64)` = 0.1 steps.
const SHIFT_ROWS: usize = 64;

/// Threshold of the shift of all later stamps, in steps; a lost sample shifts them by one step.
const MIN_SHIFT: f64 = 0.5;

/// Whether ambiguous steps are common in stamps of sufficient resolution.
pub(super) fn are_ambiguous(
    stamps: &TimeStamps,
    resolution: &Resolution,
    usual: &TypicalStep,
) -> Result<bool, Error> {
    /// Coarsest stamp resolution examined, in typical steps.
    const FINE_RESOLUTION: f64 = 0.25;
    /// Fewer steps than this, or than one in a thousand, may be pauses.
    const TOLERATED_PAUSES: (usize, usize) = (3, 1000);
    let finest = FINE_RESOLUTION * usual.median_s;
    if !(usual.median_s > 0.0 && resolution.finest_s < finest) {
        return Ok(false);
    }
    let [least, most] = [AMBIGUOUS_STEPS.start, AMBIGUOUS_STEPS.end].map(|n| n * usual.median_s);
    let (mut last, mut ambiguous) = (f64::NAN, 0);
    for_each_stamp(&stamps.seconds, |_, t| {
        let is_ambiguous = (least..most).contains(&(t - last));
        ambiguous += usize::from(is_ambiguous && resolution.unit_at(t) < finest);
        last = t;
        Ok(())
    })?;
    Ok(ambiguous >= TOLERATED_PAUSES.0 && ambiguous * TOLERATED_PAUSES.1 >= stamps.seconds.len())
}

/// Rejects stamps with a shift of half a step or more at a row without a certain gap: `t = a + b row` before the row and
/// `t = a + c + b row` after it, with the shift c by least squares.
pub(super) fn check_hidden_losses(
    timing: &RawTiming,
    stamps: &TimeStamps,
    usual: &TypicalStep,
) -> Result<(), Error> {
    let mut window = VecDeque::new();
    // Run of shifted rows: row of the largest shift, that shift, and whether the run contains a certain gap.
    let mut run: Option<(usize, f64, bool)> = None;
    let (mut hidden, mut last_shifted) = (None, 0);
    for_each_stamp(&stamps.seconds, |row, t| {
        window.push_back(t);
        if window.len() > 2 * SHIFT_ROWS {
            window.pop_front();
        }
        if window.len() < 2 * SHIFT_ROWS {
            return Ok(());
        }
        let at = row + 1 - SHIFT_ROWS;
        let shift = half_shift(window.make_contiguous()) / usual.median_s;
        let step = (window[SHIFT_ROWS] - window[SHIFT_ROWS - 1]) / usual.median_s;
        if shift.abs() >= MIN_SHIFT {
            let (first, max_shift, certain) = run.unwrap_or((at, 0.0, false));
            let largest = if shift.abs() > max_shift { at } else { first };
            run = Some((
                largest,
                max_shift.max(shift.abs()),
                certain || step >= CERTAIN_GAP_STEPS,
            ));
            last_shifted = at;
        } else if let Some((row, _, certain)) = run.filter(|_| at > last_shifted + SHIFT_ROWS) {
            hidden = hidden.or((!certain).then_some(row));
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

/// Shift between two halves of stamps, s, fitted by least squares with a common slope.
fn half_shift(stamps: &[f64]) -> f64 {
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
    let ((first, moment_1), (second, moment_2)) = (sums(before), sums(after));
    let step = (moment_1 + moment_2) / (n * (n * n - 1.0) / 6.0);
    second - first - n * step
}

/// Whether the additional gaps of `strict`, steps of two resolution units, are lost samples: they are few and not periodic as those
/// of a clock slightly slower than its resolution unit.
pub(super) fn are_lost_samples(lenient: &TimeBase, strict: &TimeBase, rows: usize) -> bool {
    /// Minimum number of rows per lost sample; such a clock has more frequent steps.
    const MIN_ROWS_PER_LOSS: usize = 200;
    /// Minimum number of steps for a test of periodicity.
    const MIN_LOSSES: usize = 3;
    /// Maximum relative deviation of periodic distances from their mean.
    const MAX_SPACING_DEVIATION: f64 = 0.25;
    let is_new = |gap: &&Gap| !lenient.gaps.iter().any(|g| g.row == gap.row);
    let gap_rows: Vec<f64> = (strict.gaps.iter().filter(is_new))
        .map(|gap| gap.row as f64)
        .collect();
    let (Some(first), Some(last)) = (gap_rows.first(), gap_rows.last()) else {
        return false;
    };
    let period = (last - first) / (gap_rows.len() - 1).max(1) as f64;
    let most = (1.0 + MAX_SPACING_DEVIATION) * period;
    let is_even = |pair: &[f64]| ((pair[1] - pair[0]) / period - 1.0).abs() < MAX_SPACING_DEVIATION;
    let is_periodic = gap_rows.len() >= MIN_LOSSES
        && gap_rows.windows(2).all(is_even)
        && *first < most
        && rows as f64 - last < most;
    gap_rows.len() * MIN_ROWS_PER_LOSS <= rows && !is_periodic
}
