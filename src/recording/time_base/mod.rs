//! Time base by regression of the stamps, `t_i = a_s + i/rate`, an offset per segment; jitter, gaps.
//!
//! Where they jitter, the mean over the segments, which keeps their length when the samples are put on an even grid. Never the
//! median step: rounding and jitter bias it.

use std::ops::Range;

use super::raw::{LineNumbers, RawTiming, TimeStamps};
use super::resolution::Resolution;
use super::sample_column::SampleColumn;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::source_span::SourceSpan;
use crate::base::text::pluralise;

mod regression;

mod typical_step;

mod losses;

mod drift;

#[cfg(test)]
mod tests;

use regression::RegressionSums;
use typical_step::{TypicalStep, typical_step};

/// Samples read at a time.
const BLOCK: usize = 1 << 16;

/// A step longer than this many usual steps misses samples.
const MIN_GAP_STEPS: f64 = 1.5;

/// A step this many usual ones long misses samples however uneven the stamps are.
const CERTAIN_GAP_STEPS: f64 = 3.0;

/// Stamps that deviate by less than this many steps are uniform: at the highest frequency it is an error of −50 dB.
const MAX_UNIFORM_JITTER: f64 = 1e-3;

/// Time base derived from the stamps of a log.
#[derive(Debug, Clone)]
pub struct TimeBase {
    /// Samples a second, Hz.
    pub rate_hz: f64,
    /// Standard deviation of it by the residuals of the regression, relative.
    pub rate_std: f64,
    /// Segments without a gap, in rows.
    pub segments: Vec<Range<usize>>,
    /// Time of the first row of each segment, s: on the regression line, its own stamp where the stamps jitter.
    pub segment_starts: Vec<f64>,
    /// The rate of single parts of the record, the lowest and the highest, Hz: how the clock drifts.
    pub drift_hz: (f64, f64),
    /// Gaps between the segments.
    pub gaps: Vec<Gap>,
    /// Uniformity of the stamp spacing.
    pub spacing: Spacing,
}

/// Missing samples between two rows of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    /// The first row after it.
    pub row: usize,
    /// Line of the row, in a text.
    pub line: Option<usize>,
    /// Samples missing, to the nearest whole.
    pub missing: usize,
    /// From the last stamp before to the first after, s.
    pub seconds: f64,
}

/// Uniformity of the stamp spacing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spacing {
    /// To a thousandth of a step.
    Uniform,
    /// As evenly as their last digit allows to say.
    Rounded {
        /// One unit of the last digit, s: of the coarsest stamp.
        resolution_s: f64,
        /// Number of significant digits written, where the last digit is worth more in later stamps.
        digits: Option<i32>,
    },
    /// Not evenly: the samples must be resampled.
    Jittered {
        /// Root mean square deviation from the regression line, s.
        rms_s: f64,
        /// Largest deviation, s.
        max_s: f64,
        /// The shortest and the longest step inside the segments, s.
        steps_s: (f64, f64),
    },
}

/// Calls `see(row, stamp)` for every row.
fn for_each_stamp(
    seconds: &SampleColumn,
    mut see: impl FnMut(usize, f64) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut block = vec![0.0; BLOCK.min(seconds.len())];
    let mut at = 0;
    while at < seconds.len() {
        let count = BLOCK.min(seconds.len() - at);
        seconds.read(at, &mut block[..count])?;
        for (j, &t) in block[..count].iter().enumerate() {
            see(at + j, t)?;
        }
        at += count;
    }
    Ok(())
}

/// Examines the stamps of a log.
///
/// # Errors
/// Stamps that are no number, run backward, are all equal, or repeat although they are written finely enough not to.
pub fn fit(timing: &RawTiming, stamps: &TimeStamps) -> Result<TimeBase, Error> {
    let n = stamps.seconds.len();
    if n < 2 {
        let message = format!(
            "{} of numbers cannot tell a sample rate",
            pluralise(n, "row")
        );
        return Err(Error::new(Code::TooShort, message).with_hint("state it: --rate"));
    }
    let resolution = &over_record(stamps)?;
    let usual = typical_step(stamps, resolution)?;
    // Rounding lengthens a step by less than one unit of the last digit.
    const MIN_STEP_RATIO: f64 = 1.001;
    if losses::are_ambiguous(stamps, resolution, &usual)? {
        let is_gap = |step: f64, _: f64| step > CERTAIN_GAP_STEPS * usual.median_s;
        let found = split_at_gaps(timing, stamps, resolution, &usual, is_gap)?;
        losses::check_hidden_losses(timing, stamps, &usual)?;
        return Ok(found);
    }
    let is_gap = |step: f64, t: f64| {
        step > MIN_GAP_STEPS * usual.mean_s
            && step > usual.mean_s + MIN_STEP_RATIO * resolution.unit_at(t)
    };
    let found = split_at_gaps(timing, stamps, resolution, &usual, is_gap)?;
    // Where most steps are one unit, a step of two is a sample lost, or a clock a little slower than its digits.
    let unit_s = resolution.finest_s;
    if resolution.digits().is_none() && (usual.median_s / unit_s - 1.0).abs() < MIN_STEP_RATIO - 1.0
    {
        let is_gap = |step: f64, _: f64| step > MIN_GAP_STEPS * usual.median_s;
        let strict = split_at_gaps(timing, stamps, resolution, &usual, is_gap)?;
        if losses::are_lost(&found, &strict, n) {
            return Ok(strict);
        }
    }
    Ok(found)
}

/// The resolution of the stamps: of a fixed digit wherever significant digits make no difference over the record.
fn over_record(stamps: &TimeStamps) -> Result<Resolution, Error> {
    let mut end = [0.0];
    stamps.seconds.read(stamps.seconds.len() - 1, &mut end)?;
    let most = stamps
        .resolution
        .unit_at(0.0)
        .max(stamps.resolution.unit_at(end[0]));
    Ok(match most > stamps.resolution.finest_s {
        true => stamps.resolution,
        false => Resolution::constant(stamps.resolution.finest_s),
    })
}

/// The time base where `is_gap(step, stamp after it)` says so.
fn split_at_gaps(
    timing: &RawTiming,
    stamps: &TimeStamps,
    resolution: &Resolution,
    usual: &TypicalStep,
    is_gap: impl Fn(f64, f64) -> bool,
) -> Result<TimeBase, Error> {
    let n = stamps.seconds.len();
    // Only stamps coarser than the step may repeat.
    let may_repeat = |t: f64| resolution.unit_at(t) > 1.02 * usual.mean_s;
    // Fine stamps count more, down to those that are uniform as they are.
    let floor_s = resolution.finest_s.max(MAX_UNIFORM_JITTER * usual.mean_s);
    let weight = |t: f64| match resolution.digits() {
        None => 1.0,
        Some(_) => (floor_s / resolution.unit_at(t).max(floor_s)).powi(2),
    };
    // First pass: order, gaps, and the sums of every segment.
    let (mut segments, mut gaps): (Vec<Range<usize>>, Vec<Gap>) = (Vec::new(), Vec::new());
    let mut lines: Vec<RegressionSums> = Vec::new();
    let mut firsts = Vec::new();
    let (mut last, mut shortest, mut longest) = (f64::NAN, f64::INFINITY, 0.0f64);
    for_each_stamp(&stamps.seconds, |row, t| {
        if !t.is_finite() {
            return Err(bad_stamp(&timing.lines, row, "has no time stamp"));
        }
        let step = t - last;
        if step < 0.0 || (step == 0.0 && !may_repeat(t)) {
            let what = match step == 0.0 {
                true => format!("repeats the time stamp of the row before, {t} s after the first"),
                false => format!("goes back in time by {:.6} s", -step),
            };
            let error = bad_stamp(&timing.lines, row, &what);
            return Err(restarted(timing, stamps, row, step).unwrap_or(error));
        }
        if row == 0 || is_gap(step, t) {
            if let Some(before) = segments.last_mut() {
                before.end = row;
                gaps.push(Gap {
                    row,
                    line: timing.lines.line_of_row(row),
                    missing: 0,
                    seconds: step,
                });
            }
            segments.push(row..n);
            lines.push(RegressionSums::default());
            firsts.push(t);
        } else {
            (shortest, longest) = (shortest.min(step), longest.max(step));
        }
        if let (Some(line), Some(&first)) = (lines.last_mut(), firsts.last()) {
            line.add(t - first, weight(t));
        }
        last = t;
        Ok(())
    })?;
    let (xx, xy) = lines
        .iter()
        .map(|line| line.centred())
        .fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
    let dt = if xx > 0.0 && xy > 0.0 {
        xy / xx
    } else {
        usual.mean_s
    };
    if dt <= 0.0 {
        return Err(Error::new(
            Code::InvalidTimeStamps,
            format!("all {n} time stamps are equal"),
        )
        .with_hint("leave them aside and state the rate: --time none --rate HZ"));
    }
    let starts: Vec<f64> = lines
        .iter()
        .zip(&firsts)
        .map(|(line, first)| first + line.offset(dt))
        .collect();
    // Second pass: deviations from the line.
    let (mut square, mut weighted, mut most, mut at) = (0.0, 0.0, 0.0f64, 0);
    let mut is_beyond_rounding = false;
    for_each_stamp(&stamps.seconds, |row, t| {
        while row >= segments[at].end {
            at += 1;
        }
        let off = t - starts[at] - dt * (row - segments[at].start) as f64;
        let size = off.abs();
        square += off * off;
        weighted += weight(t) * off * off;
        most = most.max(size);
        is_beyond_rounding |= size > floor_s && size > resolution.unit_at(t);
        Ok(())
    })?;
    let dofs = (n as f64 - 1.0 - segments.len() as f64).max(1.0);
    let mut rate_hz = 1.0 / dt;
    let spacing = if most <= MAX_UNIFORM_JITTER * dt {
        Spacing::Uniform
    } else if !is_beyond_rounding {
        let mut end = [0.0];
        stamps.seconds.read(n - 1, &mut end)?;
        Spacing::Rounded {
            resolution_s: resolution.unit_at(0.0).max(resolution.unit_at(end[0])),
            digits: resolution.digits(),
        }
    } else {
        Spacing::Jittered {
            rms_s: (square / n as f64).sqrt(),
            max_s: most,
            steps_s: (shortest, longest),
        }
    };
    let mut starts = starts;
    let mut ends_std = 0.0f64;
    if matches!(spacing, Spacing::Jittered { .. }) {
        let (steps, length) = lines
            .iter()
            .fold((0.0, 0.0), |(n, t), l| (n + l.rows - 1.0, t + l.last_s));
        rate_hz = if length > 0.0 {
            steps / length
        } else {
            rate_hz
        };
        // Both ends of every segment are as uncertain as a stamp.
        ends_std = (2.0 * segments.len() as f64 * square / n as f64).sqrt() / length;
        starts = firsts;
    }
    // Sums of a million stamps round: a rate that close to a whole number of micro-hertz is that number.
    const ROUNDING: f64 = 1e-12;
    let whole = (rate_hz * 1e6).round() / 1e6;
    if (whole / rate_hz - 1.0).abs() < ROUNDING {
        rate_hz = whole;
    }
    /// Missing samples that no recorder leaves out: beyond, a stamp is wrong.
    const MAX_MISSING_SAMPLES: f64 = 1e12;
    if let Some(gap) = gaps
        .iter()
        .find(|g| !(g.seconds * rate_hz < MAX_MISSING_SAMPLES))
    {
        let what = format!("leaps forward in time by {:.3e} s", gap.seconds);
        return Err(bad_stamp(&timing.lines, gap.row, &what));
    }
    for gap in &mut gaps {
        gap.missing = ((gap.seconds * rate_hz).round() as usize)
            .saturating_sub(1)
            .max(1);
    }
    Ok(TimeBase {
        rate_hz,
        drift_hz: drift::drift(stamps, &segments, rate_hz)?,
        rate_std: if ends_std > 0.0 {
            ends_std
        } else if xx > 0.0 {
            (weighted / dofs / xx).sqrt() / dt
        } else {
            0.0
        },
        segments,
        segment_starts: starts,
        gaps,
        spacing,
    })
}

/// Error for stamps that go back below a header that is repeated: the file holds more than one record.
fn restarted(timing: &RawTiming, stamps: &TimeStamps, row: usize, step: f64) -> Option<Error> {
    let line_of = |row| timing.lines.line_of_row(row);
    let between = line_of(row.checked_sub(1)?)?..line_of(row)?;
    let mut repeated = timing.repeated_header.iter().copied();
    let line = repeated.find(|line| between.contains(line))?;
    let message = format!(
        "line {line} repeats the header, and below it `{}` restarts: it goes back by {:.6} s; the file holds more than one record",
        stamps.name, -step
    );
    let error = Error::new(Code::InvalidTimeStamps, message);
    Some(error.with_span(&SourceSpan::whole_line("", line)).with_hint(
        "split the log at that line, one file a record; if the rows follow each other without a break, leave the stamps aside: --time none --rate HZ",
    ))
}

fn bad_stamp(lines: &LineNumbers, row: usize, what: &str) -> Error {
    let which = match lines.line_of_row(row) {
        Some(line) => format!("line {line}"),
        None => format!("sample {}", row + 1),
    };
    let error = Error::new(Code::InvalidTimeStamps, format!("{which} {what}"));
    let error = match lines.line_of_row(row) {
        Some(line) => error.with_span(&SourceSpan::whole_line("", line)),
        None => error,
    };
    error.with_hint("sort or cut the log there, or leave its stamps aside: --time none --rate HZ")
}
