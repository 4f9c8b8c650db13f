//! The clock of a log: its rate by regression over the stamps, `t_i = a_s + i/rate` with one rate and an offset for every stretch
//! between gaps; jitter, gaps, rounding of the stamps. Where they jitter, the mean over the stretches, which keeps their length
//! when the samples are put on an even grid. Never the median step: rounding and jitter bias it.

use std::collections::VecDeque;
use std::ops::Range;

use super::column::Column;
use super::raw::{Clock, Lines, Stamps};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::place::Place;
use crate::base::words::counted;
use crate::numeric::statistics::median;

/// Samples read at a time.
const BLOCK: usize = 1 << 16;

/// A step longer than this many usual steps misses samples.
const GAP: f64 = 1.5;

/// Steps this close to [`GAP`], in usual steps, are as well a lost sample as a late stamp.
const NEITHER: Range<f64> = 1.4..1.6;

/// Rows to either side of a step by which samples lost in it show: stamps that deviate by 0.3 steps, as those do that are uneven by
/// half a step, leave their shift uncertain by `0.3 √(8/64)` = 0.1 steps.
const LEVEL_ROWS: usize = 64;

/// The stamps of all rows after a lost sample lie a whole step later; by this much they do or do not.
const LEVEL: f64 = 0.5;

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
        /// One unit of the last digit, s.
        resolution_s: f64,
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

/// Sums of a regression that never lose digits to the size of the times: about the first row of each stretch.
#[derive(Default)]
struct Sums {
    n: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    /// The latest `y`.
    last: f64,
}

impl Sums {
    fn add(&mut self, x: f64, y: f64) {
        self.n += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.last = y;
    }

    /// Σ(x − x̄)² and Σ(x − x̄)(y − ȳ).
    fn centred(&self) -> (f64, f64) {
        (
            self.xx - self.x * self.x / self.n,
            self.xy - self.x * self.y / self.n,
        )
    }
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
    let usual = usual_step(stamps)?;
    // Rounding lengthens a step by less than one unit of the last digit.
    const LESS: f64 = 1.001;
    let limit = (GAP * usual.mean_s).max(usual.mean_s + LESS * stamps.resolution_s);
    if are_ambiguous(stamps, &usual)? {
        let found = split(clock, stamps, &usual, SURE * usual.median_s)?;
        refuse_hidden_losses(clock, stamps, &usual)?;
        return Ok(found);
    }
    let found = split(clock, stamps, &usual, limit)?;
    // Where most steps are one unit, a step of two is a sample lost, or a clock a little slower than its digits.
    if (usual.median_s / stamps.resolution_s - 1.0).abs() < LESS - 1.0 {
        let strict = split(clock, stamps, &usual, GAP * usual.median_s)?;
        if are_lost(&found, &strict, n) {
            return Ok(strict);
        }
    }
    Ok(found)
}

/// Whether steps about the length that makes a gap are common, in stamps fine enough to tell.
fn are_ambiguous(stamps: &Stamps, usual: &Usual) -> Result<bool, Error> {
    /// Of stamps no coarser than this part of a step.
    const FINE: f64 = 0.25;
    /// One or two may be pauses; so may one step in a thousand.
    const FEW: (usize, usize) = (3, 1000);
    if !(usual.median_s > 0.0 && stamps.resolution_s < FINE * usual.median_s) {
        return Ok(false);
    }
    let (mut last, mut neither) = (f64::NAN, 0);
    each(&stamps.seconds, |_, t| {
        neither += usize::from(NEITHER.contains(&((t - last) / usual.median_s)));
        last = t;
        Ok(())
    })?;
    Ok(neither >= FEW.0 && neither * FEW.1 >= stamps.seconds.len())
}

/// Refuses stamps that lie later, by half a step and more, from a row on than those before let expect, where no sure gap is near:
/// with `t = a + b row` before the row and `t = a + c + b row` after it, c by least squares.
fn refuse_hidden_losses(clock: &Clock, stamps: &Stamps, usual: &Usual) -> Result<(), Error> {
    let mut near = VecDeque::new();
    // The row of the largest shift in a run of them, the shift, and whether a sure gap is in the run.
    let mut run: Option<(usize, f64, bool)> = None;
    let (mut hidden, mut last_shifted) = (None, 0);
    each(&stamps.seconds, |row, t| {
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
        if shift.abs() >= LEVEL {
            let (first, most, sure) = run.unwrap_or((at, 0.0, false));
            let largest = if shift.abs() > most { at } else { first };
            run = Some((largest, most.max(shift.abs()), sure || step >= SURE));
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
    let place = match clock.lines.of(row) {
        Some(line) => format!("about line {line}"),
        None => format!("about sample {}", row + 1),
    };
    let message = format!(
        "the time stamps are too uneven to tell lost samples from late stamps: {place} they move by half a step and more"
    );
    Err(Error::new(Code::BadTime, message)
        .hint("log with even steps, or leave the stamps aside: --time none --rate HZ"))
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
fn are_lost(found: &TimeBase, strict: &TimeBase, rows: usize) -> bool {
    /// More than one in so many rows is how such a clock runs.
    const RARE: usize = 200;
    /// Any one or two may be even.
    const TELLING: usize = 3;
    /// How far the distances of even steps differ from their mean.
    const EVEN: f64 = 0.25;
    let is_new = |gap: &&Gap| !found.gaps.iter().any(|g| g.row == gap.row);
    let places: Vec<f64> = (strict.gaps.iter().filter(is_new))
        .map(|gap| gap.row as f64)
        .collect();
    let (Some(first), Some(last)) = (places.first(), places.last()) else {
        return false;
    };
    let period = (last - first) / (places.len() - 1).max(1) as f64;
    let most = (1.0 + EVEN) * period;
    let even = |pair: &[f64]| ((pair[1] - pair[0]) / period - 1.0).abs() < EVEN;
    let by_clock = places.len() >= TELLING
        && places.windows(2).all(even)
        && *first < most
        && rows as f64 - last < most;
    places.len() * RARE <= rows && !by_clock
}

/// The time base where steps longer than `limit_s` are gaps.
fn split(clock: &Clock, stamps: &Stamps, usual: &Usual, limit_s: f64) -> Result<TimeBase, Error> {
    let n = stamps.seconds.len();
    // Only stamps coarser than the step may repeat.
    let rounded = stamps.resolution_s > 1.02 * usual.mean_s;
    // First pass: order, gaps, and the sums of every stretch.
    let (mut stretches, mut gaps): (Vec<Range<usize>>, Vec<Gap>) = (Vec::new(), Vec::new());
    let mut all: Vec<Sums> = Vec::new();
    let mut firsts = Vec::new();
    let (mut last, mut shortest, mut longest) = (f64::NAN, f64::INFINITY, 0.0f64);
    each(&stamps.seconds, |row, t| {
        if !t.is_finite() {
            return Err(bad_stamp(&clock.lines, row, "has no time stamp"));
        }
        let step = t - last;
        if step < 0.0 || (step == 0.0 && !rounded) {
            let what = match step == 0.0 {
                true => format!("repeats the time stamp of the row before, {t} s after the first"),
                false => format!("goes back in time by {:.6} s", -step),
            };
            return Err(bad_stamp(&clock.lines, row, &what));
        }
        if row == 0 || step > limit_s {
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
            all.push(Sums::default());
            firsts.push(t);
        } else {
            (shortest, longest) = (shortest.min(step), longest.max(step));
        }
        if let (Some(sums), Some(&first), Some(stretch)) =
            (all.last_mut(), firsts.last(), stretches.last())
        {
            sums.add((row - stretch.start) as f64, t - first);
        }
        last = t;
        Ok(())
    })?;
    let (xx, xy) = all
        .iter()
        .map(Sums::centred)
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
    let starts: Vec<f64> = all
        .iter()
        .zip(&firsts)
        .map(|(s, first)| first + (s.y - dt * s.x) / s.n)
        .collect();
    // Second pass: deviations from the line.
    let (mut square, mut most, mut at) = (0.0, 0.0f64, 0);
    each(&stamps.seconds, |row, t| {
        while row >= stretches[at].end {
            at += 1;
        }
        let off = t - starts[at] - dt * (row - stretches[at].start) as f64;
        square += off * off;
        most = most.max(off.abs());
        Ok(())
    })?;
    let freedoms = (n as f64 - 1.0 - stretches.len() as f64).max(1.0);
    let mut rate_hz = 1.0 / dt;
    let spacing = if most <= UNIFORM * dt {
        Spacing::Uniform
    } else if most <= stamps.resolution_s {
        Spacing::Rounded {
            resolution_s: stamps.resolution_s,
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
        let (steps, length) = all
            .iter()
            .fold((0.0, 0.0), |(n, t), s| (n + s.n - 1.0, t + s.last));
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
        drift_hz: drift(stamps, &stretches, rate_hz)?,
        rate_std: if ends_std > 0.0 {
            ends_std
        } else if xx > 0.0 {
            (square / freedoms / xx).sqrt() / dt
        } else {
            0.0
        },
        stretches,
        starts,
        gaps,
        spacing,
    })
}

/// Standard deviation of what stamps are off from one to the next without regularity, s: by the median of second differences, to
/// which a clock that drifts adds nothing.
fn jitter(stamps: &Stamps, rows: &Range<usize>) -> Result<f64, Error> {
    let mut some = vec![0.0; rows.len().min(BLOCK)];
    stamps.seconds.read(rows.start, &mut some)?;
    let mut bends: Vec<f64> = some
        .windows(3)
        .map(|w| (w[0] - 2.0 * w[1] + w[2]).abs())
        .collect();
    // Σ(1,2,1)² = 6; a normal variable is above 0.6745 of its deviation half of the time.
    Ok(median(&mut bends).map_or(0.0, |median| median / 6f64.sqrt() / 0.674_489_75))
}

/// The lowest and the highest rate over the tenths of the longest stretch, Hz; the rate itself where they differ by no more than
/// what single stamps are off makes of one.
fn drift(stamps: &Stamps, stretches: &[Range<usize>], rate_hz: f64) -> Result<(f64, f64), Error> {
    const PARTS: usize = 10;
    let longest = stretches.iter().max_by_key(|s| s.len()).cloned();
    let Some(rows) = longest.filter(|s| s.len() > 2 * PARTS) else {
        return Ok((rate_hz, rate_hz));
    };
    let length = (rows.len() - 1) / PARTS;
    let (mut low, mut high) = (f64::INFINITY, 0.0f64);
    for part in 0..PARTS {
        let first = rows.start + part * length;
        let mut ends = [0.0, 0.0];
        stamps.seconds.read(first, &mut ends[..1])?;
        stamps.seconds.read(first + length, &mut ends[1..])?;
        let rate = length as f64 / (ends[1] - ends[0]);
        if rate.is_finite() {
            (low, high) = (low.min(rate), high.max(rate));
        }
    }
    // Of ten numbers some lie five deviations apart hardly ever.
    const BEYOND_CHANCE: f64 = 5.0;
    let by_chance = std::f64::consts::SQRT_2 * jitter(stamps, &rows)? * rate_hz / length as f64;
    if high / low - 1.0 < BEYOND_CHANCE * by_chance {
        return Ok((rate_hz, rate_hz));
    }
    Ok((low.min(rate_hz), high.max(rate_hz)))
}

/// The step most rows make, only to tell gaps from steps, never to tell the rate.
struct Usual {
    median_s: f64,
    /// The mean of the steps that rounding may have made of one, where stamps are coarse; else the median.
    mean_s: f64,
}

fn usual_step(stamps: &Stamps) -> Result<Usual, Error> {
    let n = stamps.seconds.len();
    let mut ends = [0.0, 0.0];
    stamps.seconds.read(0, &mut ends[..1])?;
    stamps.seconds.read(n - 1, &mut ends[1..])?;
    let over_all = (ends[1] - ends[0]) / (n - 1) as f64;
    let mut some = vec![0.0; n.min(BLOCK)];
    stamps.seconds.read(0, &mut some)?;
    let mut steps: Vec<f64> = some
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|s| s.is_finite())
        .collect();
    let Some(median_s) = median(&mut steps) else {
        return Ok(Usual {
            median_s: over_all,
            mean_s: over_all,
        });
    };
    // Coarse stamps of even steps make them one unit longer or shorter: their median tells nothing.
    const COARSE: f64 = 2.0;
    let longest = median_s + 1.001 * stamps.resolution_s;
    let (count, sum) = (steps.iter().filter(|s| **s <= longest))
        .fold((0.0, 0.0), |(n, sum), s| (n + 1.0, sum + s));
    let mean_s = match sum / count {
        _ if median_s > COARSE * stamps.resolution_s => median_s,
        mean if mean > 0.0 => mean,
        _ => over_all,
    };
    Ok(Usual { median_s, mean_s })
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

#[cfg(test)]
mod tests {
    use super::*;

    fn stamps(times: &[f64], resolution_s: f64) -> Stamps {
        Stamps {
            name: "t".into(),
            unit: "s".into(),
            first: String::new(),
            seconds: Column::from_slice(times),
            resolution_s,
        }
    }

    #[test]
    fn exact_rate_with_gaps() {
        let mut t: Vec<f64> = (0..1000).map(|i| f64::from(i) * 1e-3).collect();
        t[600..].iter_mut().for_each(|t| *t += 0.0503);
        let found = examine(&Clock::default(), &stamps(&t, 1e-9)).unwrap();
        assert!((found.rate_hz / 1000.0 - 1.0).abs() < 1e-12);
        assert_eq!(found.stretches, vec![0..600, 600..1000]);
        assert_eq!((found.gaps[0].missing, found.gaps[0].row), (50, 600));
        assert_eq!(found.spacing, Spacing::Uniform);
    }

    #[test]
    fn exact_rate_of_rounded_stamps() {
        // 300 Hz in whole milliseconds: the median step would say 333.3 Hz; at 3 kHz stamps even repeat.
        for rate in [300.0, 3000.0] {
            let t: Vec<f64> = (0..3000)
                .map(|i| (f64::from(i) / rate * 1e3).round() * 1e-3)
                .collect();
            let found = examine(&Clock::default(), &stamps(&t, 1e-3)).unwrap();
            assert!(
                (found.rate_hz / rate - 1.0).abs() < 1e-4,
                "{}",
                found.rate_hz
            );
            assert!(matches!(found.spacing, Spacing::Rounded { .. }));
            assert_eq!(found.stretches.len(), 1);
        }
    }

    /// 1000 Hz in whole milliseconds: a step of 2 ms is a lost sample; at 999 Hz it comes once in a thousand rows and is rounding.
    #[test]
    fn exact_lost_samples_of_whole_steps() {
        for lost in [&[700][..], &[700, 2100, 2200, 2250]] {
            let kept = (0..4000).filter(|i| !lost.contains(i));
            let t: Vec<f64> = kept.map(|i| f64::from(i) * 1e-3).collect();
            let found = examine(&Clock::default(), &stamps(&t, 1e-3)).unwrap();
            assert!((found.rate_hz / 1000.0 - 1.0).abs() < 1e-12);
            let missing: Vec<usize> = found.gaps.iter().map(|g| g.missing).collect();
            assert_eq!(missing, vec![1; lost.len()]);
            assert_eq!(found.spacing, Spacing::Uniform);
        }
        let t: Vec<f64> = (0..6000)
            .map(|i| (f64::from(i) / 0.999).floor() * 1e-3)
            .collect();
        let found = examine(&Clock::default(), &stamps(&t, 1e-3)).unwrap();
        assert_eq!(found.gaps, []);
        assert!((found.rate_hz / 999.0 - 1.0).abs() < 1e-4);
    }

    #[test]
    fn refuses_stamps_that_are_all_equal() {
        let error = examine(&Clock::default(), &stamps(&[0.0; 50], 1.0)).unwrap_err();
        assert_eq!(error.code, Code::BadTime);
    }

    #[test]
    fn refuses_stamps_that_repeat_or_run_back() {
        for wrong in [0.002, 0.0019] {
            let mut t: Vec<f64> = (0..10).map(|i| f64::from(i) * 1e-3).collect();
            t[3] = wrong;
            let mut clock = Clock::default();
            clock.lines.note(0, 5);
            let error = examine(&clock, &stamps(&t, 1e-6)).unwrap_err();
            assert_eq!(error.code, Code::BadTime);
            assert!(error.message.starts_with("line 8"), "{}", error.message);
        }
    }

    /// Stamps uneven by up to half a step with nothing lost have no gap; with a sample lost they are refused, or the gap is sure.
    #[test]
    fn law_uneven_stamps_lose_nothing() {
        for (seed, jitter) in [(1, 0.2), (2, 0.3), (3, 0.4), (4, 0.49), (5, 0.45)] {
            let mut random = fastrand::Rng::with_seed(seed);
            let mut t: Vec<f64> = (0..4000)
                .map(|i| (f64::from(i) + jitter * (2.0 * random.f64() - 1.0)) * 1e-3)
                .collect();
            let found = examine(&Clock::default(), &stamps(&t, 1e-8)).unwrap();
            assert_eq!(found.gaps, [], "{jitter}");
            assert!(
                (found.rate_hz / 1000.0 - 1.0).abs() < 3e-4,
                "{}",
                found.rate_hz
            );
            if jitter < 0.3 {
                continue;
            }
            t[2000..].iter_mut().for_each(|t| *t += 1e-3);
            let lost = examine(&Clock::default(), &stamps(&t, 1e-8)).unwrap_err();
            assert_eq!(lost.code, Code::BadTime);
            t[2000..].iter_mut().for_each(|t| *t += 6e-3);
            let found = examine(&Clock::default(), &stamps(&t, 1e-8)).unwrap();
            let rows: Vec<usize> = found.gaps.iter().map(|g| g.row).collect();
            assert_eq!(rows, [2000]);
        }
    }

    #[test]
    fn law_jitter_is_measured() {
        let mut random = fastrand::Rng::with_seed(3);
        let t: Vec<f64> = (0..20_000)
            .map(|i| f64::from(i) * 3e-3 + 3e-4 * (random.f64() - 0.5))
            .collect();
        let found = examine(&Clock::default(), &stamps(&t, 1e-6)).unwrap();
        assert!((found.rate_hz * 3e-3 - 1.0).abs() < 5.0 * found.rate_std);
        let Spacing::Jittered { rms_s, .. } = found.spacing else {
            panic!("{:?}", found.spacing)
        };
        assert!((rms_s / (3e-4 / 12f64.sqrt()) - 1.0).abs() < 0.02);
        // Stamps that are off at random are no clock that drifts; one that slows down by a fiftieth drifts, jitter or not.
        let short = examine(&Clock::default(), &stamps(&t[..1000], 1e-6)).unwrap();
        assert_eq!(short.drift_hz, (short.rate_hz, short.rate_hz));
        let slower: Vec<f64> = t[..1000].iter().map(|t| t + 0.003 * t * t).collect();
        let (low, high) = examine(&Clock::default(), &stamps(&slower, 1e-6))
            .unwrap()
            .drift_hz;
        assert!((high / low - 1.0 - 0.0164).abs() < 0.002, "{low} {high}");
    }
}
