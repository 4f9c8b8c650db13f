//! The clock of a log: its rate by regression over the stamps, `t_i = a_s + i/rate` with one rate and an offset for every stretch
//! between gaps; jitter, gaps, rounding of the stamps. Where they jitter, the mean over the stretches, which keeps their length
//! when the samples are put on an even grid. Never the median step: rounding and jitter bias it.

use std::ops::Range;

use super::column::Column;
use super::raw::{Clock, Lines, Stamps};
use super::resolution::Resolution;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::place::Place;
use crate::base::words::counted;

/// Sums of regressions.
mod line;

/// The step most rows make.
mod usual;

/// Lost samples in uneven stamps.
mod losses;

/// Clocks that drift.
mod drift;

#[cfg(test)]
mod tests;

use line::Line;
use usual::{Usual, usual_step};

/// Samples read at a time.
const BLOCK: usize = 1 << 16;

/// A step longer than this many usual steps misses samples.
const GAP: f64 = 1.5;

/// A step this many usual ones long misses samples however uneven the stamps are.
const SURE: f64 = 3.0;

/// Stamps that deviate by less than this many steps are uniform: at the highest frequency it is an error of −50 dB.
const UNIFORM: f64 = 1e-3;

/// What the stamps of a log say.
#[derive(Debug, Clone)]
pub struct TimeBase {
    /// Samples a second, Hz.
    pub rate_hz: f64,
    /// Standard deviation of it by the residuals of the regression, relative.
    pub rate_std: f64,
    /// Stretches without a gap, in rows.
    pub stretches: Vec<Range<usize>>,
    /// Time of the first row of each stretch, s: on the regression line, its own stamp where the stamps jitter.
    pub starts: Vec<f64>,
    /// The rate of single parts of the record, the lowest and the highest, Hz: how the clock drifts.
    pub drift_hz: (f64, f64),
    /// Gaps between the stretches.
    pub gaps: Vec<Gap>,
    /// How evenly the stamps are spaced.
    pub spacing: Spacing,
}

/// Missing samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    /// The first row after it.
    pub row: usize,
    /// Its line, in a text.
    pub line: Option<usize>,
    /// Samples missing, to the nearest whole.
    pub missing: usize,
    /// From the last stamp before to the first after, s.
    pub seconds: f64,
}

/// How evenly stamps are spaced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spacing {
    /// To a thousandth of a step.
    Uniform,
    /// As evenly as their last digit allows to say.
    Rounded {
        /// One unit of the last digit, s: of the coarsest stamp.
        resolution_s: f64,
        /// How many significant digits were written, where the last digit is worth more in later stamps.
        digits: Option<i32>,
    },
    /// Not evenly: the samples must be resampled.
    Jittered {
        /// Root mean square deviation from the regression line, s.
        rms_s: f64,
        /// Largest deviation, s.
        most_s: f64,
        /// The shortest and the longest step inside the stretches, s.
        steps_s: (f64, f64),
    },
}

/// Calls `see(row, stamp)` for every row.
fn each(
    seconds: &Column,
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
pub fn examine(clock: &Clock, stamps: &Stamps) -> Result<TimeBase, Error> {
    let n = stamps.seconds.len();
    if n < 2 {
        let message = format!("{} of numbers cannot tell a sample rate", counted(n, "row"));
        return Err(Error::new(Code::TooShort, message).hint("state it: --rate"));
    }
    let resolution = &over_record(stamps)?;
    let usual = usual_step(stamps, resolution)?;
    // Rounding lengthens a step by less than one unit of the last digit.
    const LESS: f64 = 1.001;
    if losses::are_ambiguous(stamps, resolution, &usual)? {
        let is_gap = |step: f64, _: f64| step > SURE * usual.median_s;
        let found = split(clock, stamps, resolution, &usual, is_gap)?;
        losses::refuse_hidden_losses(clock, stamps, &usual)?;
        return Ok(found);
    }
    let is_gap = |step: f64, t: f64| {
        step > GAP * usual.mean_s && step > usual.mean_s + LESS * resolution.at(t)
    };
    let found = split(clock, stamps, resolution, &usual, is_gap)?;
    // Where most steps are one unit, a step of two is a sample lost, or a clock a little slower than its digits.
    let unit_s = resolution.finest_s;
    if resolution.digits().is_none() && (usual.median_s / unit_s - 1.0).abs() < LESS - 1.0 {
        let is_gap = |step: f64, _: f64| step > GAP * usual.median_s;
        let strict = split(clock, stamps, resolution, &usual, is_gap)?;
        if losses::are_lost(&found, &strict, n) {
            return Ok(strict);
        }
    }
    Ok(found)
}

/// The resolution of the stamps: of a fixed digit wherever significant digits make no difference over the record.
fn over_record(stamps: &Stamps) -> Result<Resolution, Error> {
    let mut end = [0.0];
    stamps.seconds.read(stamps.seconds.len() - 1, &mut end)?;
    let most = stamps.resolution.at(0.0).max(stamps.resolution.at(end[0]));
    Ok(match most > stamps.resolution.finest_s {
        true => stamps.resolution,
        false => Resolution::fixed(stamps.resolution.finest_s),
    })
}

/// The time base where `is_gap(step, stamp after it)` says so.
fn split(
    clock: &Clock,
    stamps: &Stamps,
    resolution: &Resolution,
    usual: &Usual,
    is_gap: impl Fn(f64, f64) -> bool,
) -> Result<TimeBase, Error> {
    let n = stamps.seconds.len();
    // Only stamps coarser than the step may repeat.
    let may_repeat = |t: f64| resolution.at(t) > 1.02 * usual.mean_s;
    // Fine stamps count more, down to those that are uniform as they are.
    let floor_s = resolution.finest_s.max(UNIFORM * usual.mean_s);
    let weight = |t: f64| match resolution.digits() {
        None => 1.0,
        Some(_) => (floor_s / resolution.at(t).max(floor_s)).powi(2),
    };
    // First pass: order, gaps, and the sums of every stretch.
    let (mut stretches, mut gaps): (Vec<Range<usize>>, Vec<Gap>) = (Vec::new(), Vec::new());
    let mut lines: Vec<Line> = Vec::new();
    let mut firsts = Vec::new();
    let (mut last, mut shortest, mut longest) = (f64::NAN, f64::INFINITY, 0.0f64);
    each(&stamps.seconds, |row, t| {
        if !t.is_finite() {
            return Err(bad_stamp(&clock.lines, row, "has no time stamp"));
        }
        let step = t - last;
        if step < 0.0 || (step == 0.0 && !may_repeat(t)) {
            let what = match step == 0.0 {
                true => format!("repeats the time stamp of the row before, {t} s after the first"),
                false => format!("goes back in time by {:.6} s", -step),
            };
            return Err(bad_stamp(&clock.lines, row, &what));
        }
        if row == 0 || is_gap(step, t) {
            if let Some(before) = stretches.last_mut() {
                before.end = row;
                gaps.push(Gap {
                    row,
                    line: clock.lines.of(row),
                    missing: 0,
                    seconds: step,
                });
            }
            stretches.push(row..n);
            lines.push(Line::default());
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
        .map(Line::centred)
        .fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
    let dt = if xx > 0.0 && xy > 0.0 {
        xy / xx
    } else {
        usual.mean_s
    };
    if dt <= 0.0 {
        return Err(
            Error::new(Code::BadTime, format!("all {n} time stamps are equal"))
                .hint("leave them aside and state the rate: --time none --rate HZ"),
        );
    }
    let starts: Vec<f64> = lines
        .iter()
        .zip(&firsts)
        .map(|(line, first)| first + line.offset(dt))
        .collect();
    // Second pass: deviations from the line.
    let (mut square, mut weighted, mut most, mut at) = (0.0, 0.0, 0.0f64, 0);
    let mut is_beyond_rounding = false;
    each(&stamps.seconds, |row, t| {
        while row >= stretches[at].end {
            at += 1;
        }
        let off = t - starts[at] - dt * (row - stretches[at].start) as f64;
        let size = off.abs();
        square += off * off;
        weighted += weight(t) * off * off;
        most = most.max(size);
        is_beyond_rounding |= size > floor_s && size > resolution.at(t);
        Ok(())
    })?;
    let freedoms = (n as f64 - 1.0 - stretches.len() as f64).max(1.0);
    let mut rate_hz = 1.0 / dt;
    let spacing = if most <= UNIFORM * dt {
        Spacing::Uniform
    } else if !is_beyond_rounding {
        let mut end = [0.0];
        stamps.seconds.read(n - 1, &mut end)?;
        Spacing::Rounded {
            resolution_s: resolution.at(0.0).max(resolution.at(end[0])),
            digits: resolution.digits(),
        }
    } else {
        Spacing::Jittered {
            rms_s: (square / n as f64).sqrt(),
            most_s: most,
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
        // Both ends of every stretch are as uncertain as a stamp.
        ends_std = (2.0 * stretches.len() as f64 * square / n as f64).sqrt() / length;
        starts = firsts;
    }
    // Sums of a million stamps round: a rate that close to a whole number of micro-hertz is that number.
    const ROUNDING: f64 = 1e-12;
    let whole = (rate_hz * 1e6).round() / 1e6;
    if (whole / rate_hz - 1.0).abs() < ROUNDING {
        rate_hz = whole;
    }
    /// Missing samples that no recorder leaves out: beyond, a stamp is wrong.
    const ENDLESS: f64 = 1e12;
    if let Some(gap) = gaps.iter().find(|g| !(g.seconds * rate_hz < ENDLESS)) {
        let what = format!("leaps forward in time by {:.3e} s", gap.seconds);
        return Err(bad_stamp(&clock.lines, gap.row, &what));
    }
    for gap in &mut gaps {
        gap.missing = ((gap.seconds * rate_hz).round() as usize)
            .saturating_sub(1)
            .max(1);
    }
    Ok(TimeBase {
        rate_hz,
        drift_hz: drift::drift(stamps, &stretches, rate_hz)?,
        rate_std: if ends_std > 0.0 {
            ends_std
        } else if xx > 0.0 {
            (weighted / freedoms / xx).sqrt() / dt
        } else {
            0.0
        },
        stretches,
        starts,
        gaps,
        spacing,
    })
}

fn bad_stamp(lines: &Lines, row: usize, what: &str) -> Error {
    let which = match lines.of(row) {
        Some(line) => format!("line {line}"),
        None => format!("sample {}", row + 1),
    };
    let error = Error::new(Code::BadTime, format!("{which} {what}"));
    let error = match lines.of(row) {
        Some(line) => error.at(&Place::of_line("", line)),
        None => error,
    };
    error.hint("sort or cut the log there, or leave its stamps aside: --time none --rate HZ")
}
