//! Time base of a log by regression of its time stamps, `t_i = a_s + i/rate`, one offset per segment; jitter, gaps.
//!
//! Jittered stamps give the mean rate over the segments, which preserves their length in resampling. The median step is not used:
//! rounding and jitter bias it.

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

/// Samples per block read.
const BLOCK: usize = 1 << 16;

/// Minimum length of a gap, in mean steps.
const MIN_GAP_STEPS: f64 = 1.5;

/// Minimum length of a gap among uneven stamps, in median steps.
const CERTAIN_GAP_STEPS: f64 = 3.0;

/// Maximum jitter of uniform stamps, in steps: an error of −50 dB at the highest frequency.
const MAX_UNIFORM_JITTER: f64 = 1e-3;

/// Time base of a log.
#[derive(Debug, Clone)]
pub struct TimeBase {
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Relative standard deviation of the sample rate, from the residuals of the regression.
    pub rate_std: f64,
    /// Gap-free segments, row ranges.
    pub segments: Vec<Range<usize>>,
    /// Start time of each segment, s: from the regression line, or the first stamp if the stamps jitter.
    pub segment_starts: Vec<f64>,
    /// Clock drift: lowest and highest local sample rate, Hz.
    pub drift_hz: (f64, f64),
    /// Gaps between the segments.
    pub gaps: Vec<Gap>,
    /// Uniformity of the stamp spacing.
    pub spacing: Spacing,
}

/// Missing samples between two rows of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    /// First row after the gap.
    pub row: usize,
    /// Line of the row in a text file.
    pub line: Option<usize>,
    /// Number of missing samples, rounded.
    pub missing: usize,
    /// Time from the last stamp before the gap to the first after it, s.
    pub seconds: f64,
}

/// Uniformity of the stamp spacing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spacing {
    /// Jitter below a thousandth of a step.
    Uniform,
    /// Uniform to the rounding of the stamps.
    Rounded {
        /// Unit of the last digit of the coarsest stamp, s.
        resolution_s: f64,
        /// Number of significant digits, for stamps in floating-point notation.
        digits: Option<i32>,
    },
    /// Uneven: the samples must be resampled.
    Jittered {
        /// Root-mean-square deviation from the regression line, s.
        rms_s: f64,
        /// Largest deviation from the regression line, s.
        max_s: f64,
        /// Shortest and longest step within the segments, s.
        steps_s: (f64, f64),
    },
}

/// Calls `visit(row, stamp)` for every row.
fn for_each_stamp(
    seconds: &SampleColumn,
    mut visit: impl FnMut(usize, f64) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut block = vec![0.0; BLOCK.min(seconds.len())];
    let mut row = 0;
    while row < seconds.len() {
        let n_rows = BLOCK.min(seconds.len() - row);
        seconds.read(row, &mut block[..n_rows])?;
        for (j, &t) in block[..n_rows].iter().enumerate() {
            visit(row + j, t)?;
        }
        row += n_rows;
    }
    Ok(())
}

/// Fits the time base to the time stamps of a log.
///
/// # Errors
/// Stamps that are not a number, decrease, are all equal, or repeat despite a fine resolution.
pub fn fit(timing: &RawTiming, stamps: &TimeStamps) -> Result<TimeBase, Error> {
    let n = stamps.seconds.len();
    if n < 2 {
        let message = format!(
            "{} of numbers cannot tell a sample rate",
            pluralise(n, "row")
        );
        return Err(Error::new(Code::TooShort, message).with_hint("state it: --rate"));
    }
    let resolution = &record_resolution(stamps)?;
    let usual = typical_step(stamps, resolution)?;
    // Rounding lengthens a step by less than one unit of the last digit.
    const MIN_STEP_RATIO: f64 = 1.001;
    if losses::are_ambiguous(stamps, resolution, &usual)? {
        let is_gap = |step: f64, _: f64| step > CERTAIN_GAP_STEPS * usual.median_s;
        let time_base = split_at_gaps(timing, stamps, resolution, &usual, is_gap)?;
        losses::check_hidden_losses(timing, stamps, &usual)?;
        return Ok(time_base);
    }
    let is_gap = |step: f64, t: f64| {
        step > MIN_GAP_STEPS * usual.mean_s
            && step > usual.mean_s + MIN_STEP_RATIO * resolution.unit_at(t)
    };
    let time_base = split_at_gaps(timing, stamps, resolution, &usual, is_gap)?;
    // If most steps are one unit, a step of two is a lost sample, or a clock slightly slower than the resolution.
    let unit_s = resolution.finest_s;
    if resolution.digits().is_none() && (usual.median_s / unit_s - 1.0).abs() < MIN_STEP_RATIO - 1.0
    {
        let is_gap = |step: f64, _: f64| step > MIN_GAP_STEPS * usual.median_s;
        let strict = split_at_gaps(timing, stamps, resolution, &usual, is_gap)?;
        if losses::are_lost_samples(&time_base, &strict, n) {
            return Ok(strict);
        }
    }
    Ok(time_base)
}

/// Resolution of the stamps: constant unless significant digits change it over the record.
fn record_resolution(stamps: &TimeStamps) -> Result<Resolution, Error> {
    let mut last = [0.0];
    stamps.seconds.read(stamps.seconds.len() - 1, &mut last)?;
    let coarsest = stamps
        .resolution
        .unit_at(0.0)
        .max(stamps.resolution.unit_at(last[0]));
    Ok(match coarsest > stamps.resolution.finest_s {
        true => stamps.resolution,
        false => Resolution::constant(stamps.resolution.finest_s),
    })
}

/// Time base with gaps by the criterion `is_gap(step, stamp after it)`.
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
    // Fine stamps have larger weights, up to the limit of uniform stamps.
    let floor_s = resolution.finest_s.max(MAX_UNIFORM_JITTER * usual.mean_s);
    let weight = |t: f64| match resolution.digits() {
        None => 1.0,
        Some(_) => (floor_s / resolution.unit_at(t).max(floor_s)).powi(2),
    };
    // First pass: order, gaps, and regression sums per segment.
    let (mut segments, mut gaps): (Vec<Range<usize>>, Vec<Gap>) = (Vec::new(), Vec::new());
    let mut lines: Vec<RegressionSums> = Vec::new();
    let mut first_stamps = Vec::new();
    let (mut previous, mut shortest, mut longest) = (f64::NAN, f64::INFINITY, 0.0f64);
    for_each_stamp(&stamps.seconds, |row, t| {
        if !t.is_finite() {
            return Err(bad_stamp(&timing.lines, row, "has no time stamp"));
        }
        let step = t - previous;
        if step < 0.0 || (step == 0.0 && !may_repeat(t)) {
            let fault = match step == 0.0 {
                true => format!("repeats the time stamp of the row before, {t} s after the first"),
                false => format!("goes back in time by {:.6} s", -step),
            };
            let error = bad_stamp(&timing.lines, row, &fault);
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
            first_stamps.push(t);
        } else {
            (shortest, longest) = (shortest.min(step), longest.max(step));
        }
        if let (Some(line), Some(&first)) = (lines.last_mut(), first_stamps.last()) {
            line.add(t - first, weight(t));
        }
        previous = t;
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
        .zip(&first_stamps)
        .map(|(line, first)| first + line.offset(dt))
        .collect();
    // Second pass: deviations from the line.
    let (mut sum_squares, mut weighted, mut max_deviation, mut segment) = (0.0, 0.0, 0.0f64, 0);
    let mut is_beyond_rounding = false;
    for_each_stamp(&stamps.seconds, |row, t| {
        while row >= segments[segment].end {
            segment += 1;
        }
        let deviation = t - starts[segment] - dt * (row - segments[segment].start) as f64;
        let size = deviation.abs();
        sum_squares += deviation * deviation;
        weighted += weight(t) * deviation * deviation;
        max_deviation = max_deviation.max(size);
        is_beyond_rounding |= size > floor_s && size > resolution.unit_at(t);
        Ok(())
    })?;
    let dofs = (n as f64 - 1.0 - segments.len() as f64).max(1.0);
    let mut rate_hz = 1.0 / dt;
    let spacing = if max_deviation <= MAX_UNIFORM_JITTER * dt {
        Spacing::Uniform
    } else if !is_beyond_rounding {
        let mut last = [0.0];
        stamps.seconds.read(n - 1, &mut last)?;
        Spacing::Rounded {
            resolution_s: resolution.unit_at(0.0).max(resolution.unit_at(last[0])),
            digits: resolution.digits(),
        }
    } else {
        Spacing::Jittered {
            rms_s: (sum_squares / n as f64).sqrt(),
            max_s: max_deviation,
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
        ends_std = (2.0 * segments.len() as f64 * sum_squares / n as f64).sqrt() / length;
        starts = first_stamps;
    }
    // Sums of a million stamps round: a rate this close to an integer number of micro-hertz is set to it.
    const ROUNDING: f64 = 1e-12;
    let rounded = (rate_hz * 1e6).round() / 1e6;
    if (rounded / rate_hz - 1.0).abs() < ROUNDING {
        rate_hz = rounded;
    }
    /// Maximum number of missing samples of a gap; above it a stamp is wrong.
    const MAX_MISSING_SAMPLES: f64 = 1e12;
    if let Some(gap) = gaps
        .iter()
        .find(|g| !(g.seconds * rate_hz < MAX_MISSING_SAMPLES))
    {
        let fault = format!("leaps forward in time by {:.3e} s", gap.seconds);
        return Err(bad_stamp(&timing.lines, gap.row, &fault));
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

/// Error for stamps that restart below a repeated header: the file contains several records.
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

fn bad_stamp(lines: &LineNumbers, row: usize, fault: &str) -> Error {
    let position = match lines.line_of_row(row) {
        Some(line) => format!("line {line}"),
        None => format!("sample {}", row + 1),
    };
    let error = Error::new(Code::InvalidTimeStamps, format!("{position} {fault}"));
    let error = match lines.line_of_row(row) {
        Some(line) => error.with_span(&SourceSpan::whole_line("", line)),
        None => error,
    };
    error.with_hint("sort or cut the log there, or leave its stamps aside: --time none --rate HZ")
}
