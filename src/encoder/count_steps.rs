//! Lost or extra encoder counts: steps of the transmission error by whole counts.
//!
//! `D_i = mean(e_i … e_{i+w}) − mean(e_{i−w} … e_i)` over one tooth on either side, which averages out the mesh harmonics, exceeds a
//! multiple of its median absolute deviation.

use std::ops::Range;

use super::readings::{EncoderReadings, EncoderScales, ReadingsRange, for_each_block};
use super::survey::{DirectionRun, RecordSurvey};
use crate::base::error::Error;
use crate::base::text::pluralise;
use crate::numeric::Matrix;
use crate::numeric::least_squares::solve;
use crate::numeric::sorting::sort_descending;

/// Step of the transmission error by lost or extra counts.
#[derive(Debug, Clone, PartialEq)]
pub struct CountStep {
    /// First row after the step.
    pub row: usize,
    /// Height of the step, rad of the output.
    pub step: f64,
    /// Extra counts of the encoder; negative: lost.
    pub counts: f64,
    /// Encoder that made the step; both where a count of either would make the same step.
    pub encoder: &'static str,
    /// Counts of the other encoder that would make this step as well.
    pub alternative: Option<(f64, &'static str)>,
}

impl CountStep {
    /// Text of the step, such as `5 counts lost on the output or 3 too many on the input`.
    pub fn describe(&self) -> String {
        let kind = |counts: f64| if counts < 0.0 { "lost" } else { "too many" };
        let also = self.alternative.map_or(String::new(), |(n, encoder)| {
            format!(" or {} {} on the {encoder}", n.abs(), kind(n))
        });
        let count = pluralise(self.counts.abs() as usize, "count");
        let kind = kind(self.counts);
        format!("{count} {kind} on the {}{also}", self.encoder)
    }
}

/// Parameters of the search for steps in the error.
#[derive(Debug, Clone, Copy)]
pub struct StepSearch<'a> {
    /// Survey of the record, with both shafts counting in the same direction.
    pub survey: &'a RecordSurvey,
    /// Transmission ratio: output revolutions per input revolution.
    pub ratio: f64,
    /// Rows per tooth pitch of the output.
    pub rows_per_tooth: f64,
}

/// Least and largest narrow window, rows: it locates a step.
const NARROW: (usize, usize) = (4, 24);

/// Largest wide window, rows: it detects a step above the noise.
const WIDE: usize = 4096;

/// Detection threshold of a step, in standard deviations of the noise.
const STEP_THRESHOLD: f64 = 8.0;

/// Least height of a step, in counts.
const MIN_COUNT_SHARE: f64 = 0.6;

/// Relative difference of the count angles up to which the encoder of a step is ambiguous.
const AMBIGUITY_TOLERANCE: f64 = 0.02;

/// Tolerance of the height of a step, in the smaller count.
const SIZE_TOLERANCE: f64 = 0.15;

/// Maximum number of candidate steps, the strongest.
const MAX_CANDIDATES: usize = 40;

/// Maximum number of differences that estimate the noise; fewer in short records, so that their windows do not overlap.
const SAMPLES: usize = 8192;

/// Steps of the error in the order of time; none for encoders without counts.
///
/// # Errors
/// Readings that cannot be read.
pub fn find_steps(
    rows: &dyn EncoderReadings,
    scales: EncoderScales,
    runs: &[DirectionRun],
    request: StepSearch,
) -> Result<Vec<CountStep>, Error> {
    let counts = (scales.input.step * request.ratio, scales.output.step);
    let smallest = [counts.0, counts.1]
        .into_iter()
        .filter(|c| *c > 0.0)
        .fold(f64::INFINITY, f64::min);
    if !smallest.is_finite() {
        return Ok(Vec::new());
    }
    let narrow = ((request.rows_per_tooth / 8.0) as usize).clamp(NARROW.0, NARROW.1);
    let wide = (request.rows_per_tooth.round() as usize).clamp(2 * narrow, WIDE);
    let windows = StepWindows { narrow, wide };
    let mut sizes = windows.sample_noise(rows, scales, request.ratio, runs)?;
    if sizes.is_empty() {
        return Ok(Vec::new());
    }
    sizes.sort_by(f64::total_cmp);
    // The median of the size of a normal variable is 0.6745 of its deviation.
    let deviation = sizes[sizes.len() / 2] / 0.6745;
    let min_step = (MIN_COUNT_SHARE * smallest).max(STEP_THRESHOLD * deviation);
    // The wide windows detect a step above the noise; the narrow ones locate it.
    let mut candidates: Vec<(usize, f64, f64)> = Vec::new();
    windows.for_each_step(
        rows,
        scales,
        request.ratio,
        runs,
        min_step,
        |row, near, far| {
            if far * near < 0.0 {
                return;
            }
            let height = near.abs() + far.abs();
            match candidates.last_mut() {
                Some(previous) if row - previous.0 <= 2 * wide => {
                    if height > previous.1 {
                        *previous = (row, height, far);
                    }
                }
                _ => candidates.push((row, height, far)),
            }
        },
    )?;
    sort_descending(&mut candidates, |a| a.1);
    candidates.truncate(MAX_CANDIDATES);
    candidates.sort_by_key(|f| f.0);
    let steps = fit_step_sizes(&candidates, runs, request);
    let detected: Vec<CountStep> = candidates
        .iter()
        .zip(steps)
        .filter(|(_, step)| step.abs() > MIN_COUNT_SHARE * smallest)
        .map(|(&(row, ..), step)| as_counts(row, step, counts))
        .collect();
    Ok(if is_tooth_form(&detected, runs) {
        Vec::new()
    } else {
        detected
    })
}

/// Least-squares fit of the step heights to the survey points, with the first two harmonics of both shafts and a level for each run.
/// A beat of two counters resembles a step and reverses; a lost count is permanent.
fn fit_step_sizes(
    candidates: &[(usize, f64, f64)],
    runs: &[DirectionRun],
    request: StepSearch,
) -> Vec<f64> {
    let detected = candidates.iter().map(|f| f.2).collect();
    let contains = |run: &DirectionRun, row: usize| run.rows.contains(&row);
    let points: Vec<_> = request
        .survey
        .points
        .iter()
        .filter(|p| runs.iter().any(|r| contains(r, p.0)))
        .collect();
    const HARMONIC_COLUMNS: usize = 8;
    let columns = runs.len() + HARMONIC_COLUMNS + candidates.len();
    if candidates.is_empty() || points.len() < 2 * columns {
        return detected;
    }
    let a = Matrix::from_fn(points.len(), columns, |i, j| {
        let &(row, input, _) = points[i];
        if let Some(run) = runs.get(j) {
            return f64::from(u8::from(contains(run, row)));
        }
        match j - runs.len() {
            k if k < HARMONIC_COLUMNS => {
                let angle = [1.0, 2.0][k / 2 % 2] * input * [1.0, request.ratio][k / 4];
                if k % 2 == 0 { angle.cos() } else { angle.sin() }
            }
            k => f64::from(u8::from(row >= candidates[k - HARMONIC_COLUMNS].0)),
        }
    });
    let error = |p: &(usize, f64, f64)| p.2 - request.ratio * p.1;
    let b = Matrix::from_fn(points.len(), 1, |i, _| error(points[i]) - error(points[0]));
    match solve(&a, &b) {
        Ok(x) => (0..candidates.len())
            .map(|k| x[(runs.len() + HARMONIC_COLUMNS + k, 0)])
            .collect(),
        Err(_) => detected, // steps too near each other for the points
    }
}

/// Steps located in rows: for each input angle and height the row of the largest step near that angle.
///
/// # Errors
/// Readings that cannot be read.
pub fn locate_rows(
    steps: &[(f64, f64)],
    rows: &dyn EncoderReadings,
    scales: EncoderScales,
    runs: &[DirectionRun],
    request: StepSearch,
) -> Result<Vec<CountStep>, Error> {
    /// Rows searched before and after the row of the angle.
    const SEARCH_ROWS: usize = 24;
    let w = ((request.rows_per_tooth / 8.0) as usize).clamp(NARROW.0, NARROW.1);
    let points = &request.survey.points;
    let mut located = Vec::new();
    for &(input, step) in steps {
        let contains = |run: &&DirectionRun| (run.input.0 - input) * (run.input.1 - input) <= 0.0;
        let Some(run) = runs.iter().find(contains) else {
            continue;
        };
        let is_after = |p: &&(usize, f64, f64)| {
            run.rows.contains(&p.0) && ((p.1 > input) == run.forward || p.1 == input)
        };
        let after = points.iter().find(is_after).map_or(run.rows.end, |p| p.0);
        let before = points
            .iter()
            .rev()
            .find(|p| p.0 < after && run.rows.contains(&p.0));
        let (start, angle) = before.map_or((run.rows.start, run.input.0), |p| (p.0, p.1));
        let first = start.saturating_sub(SEARCH_ROWS + w).max(run.rows.start);
        let last = (after + SEARCH_ROWS + w).min(run.rows.end);
        let segment = ReadingsRange {
            rows,
            first,
            count: last - first,
        };
        let (mut angles, mut errors) = (Vec::new(), Vec::new());
        for_each_block(&segment, scales, |_, a, b| {
            angles.extend_from_slice(a);
            errors.extend(a.iter().zip(b).map(|(a, b)| b - request.ratio * a));
        })?;
        // Unwrapped angles of the segment begin at its first row: they are referred to a surveyed row.
        let Some(&start_angle) = angles.get(start - first) else {
            continue;
        };
        let is_beyond = |a: &f64| (a - start_angle + angle > input) == run.forward;
        let crossing = angles.iter().position(is_beyond).unwrap_or(start - first);
        let mean = |a: usize, b: usize| {
            errors[a..b].iter().map(|e| e - errors[0]).sum::<f64>() / (b - a) as f64
        };
        let (low, high) = (
            crossing.saturating_sub(SEARCH_ROWS).max(w),
            crossing + SEARCH_ROWS,
        );
        let offset = (low..=high.min(errors.len().saturating_sub(w)))
            .map(|i| (i, step.signum() * (mean(i, i + w) - mean(i - w, i))))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(crossing, |best| best.0);
        let counts = (scales.input.step * request.ratio, scales.output.step);
        located.push(as_counts(first + offset, step, counts));
    }
    Ok(located)
}

/// Step as whole counts of the encoder that fits it better; `counts`: angle of one count of input and output, rad of the output.
fn as_counts(row: usize, step: f64, counts: (f64, f64)) -> CountStep {
    // Extra counts of the input reduce the error.
    let fit = |count: f64| {
        let n = (step / count).round();
        let n = if n == 0.0 { (step / count).signum() } else { n };
        (n, (step - n * count).abs())
    };
    let (input, output) = (fit(-counts.0), fit(counts.1));
    // Of two equal fits the one with fewer counts is more probable.
    let better = |a: (f64, f64), b: (f64, f64)| {
        let slack = SIZE_TOLERANCE * counts.0.min(counts.1);
        a.1 + if a.0.abs() < b.0.abs() { -slack } else { slack } < b.1
    };
    let ambiguous = (counts.0 - counts.1).abs() < AMBIGUITY_TOLERANCE * counts.1;
    // A fit within the tolerance of the height is an alternative.
    let slack = SIZE_TOLERANCE * counts.0.min(counts.1);
    let rival = |other: (f64, f64), chosen: (f64, f64), encoder| {
        (other.1 < slack.max(chosen.1 + slack)).then_some((other.0, encoder))
    };
    let (counts, encoder, rival) = match (counts.0 > 0.0, counts.1 > 0.0) {
        (true, true) if ambiguous => (output.0, "input or output", None),
        (true, true) if better(input, output) => (input.0, "input", rival(output, input, "output")),
        (true, true) => (output.0, "output", rival(input, output, "input")),
        (_, true) => (output.0, "output", None),
        _ => (input.0, "input", None),
    };
    CountStep {
        row,
        step,
        counts,
        encoder,
        alternative: rival,
    }
}

/// Whether the steps repeat tooth by tooth, as the form of the teeth: numerous, with a sum near zero.
fn is_tooth_form(steps: &[CountStep], runs: &[DirectionRun]) -> bool {
    const MIN_FORM_STEPS: usize = 12;
    const NET_STEP_TOLERANCE: f64 = 0.2;
    let sum: f64 = steps.iter().map(|j| j.step).sum();
    let size: f64 = steps.iter().map(|j| j.step.abs()).sum();
    steps.len() > MIN_FORM_STEPS * runs.len().max(1) && sum.abs() < NET_STEP_TOLERANCE * size
}

/// Lengths of the averaging windows on either side of a row, rows.
struct StepWindows {
    narrow: usize,
    wide: usize,
}

impl StepWindows {
    /// Absolute differences over the wide windows, at rows distributed over the runs.
    fn sample_noise(
        &self,
        rows: &dyn EncoderReadings,
        scales: EncoderScales,
        ratio: f64,
        runs: &[DirectionRun],
    ) -> Result<Vec<f64>, Error> {
        let span = 2 * self.wide;
        let spacing = (rows.n_rows() / SAMPLES).max(span);
        let mut sizes = Vec::new();
        for run in runs {
            for from in (run.rows.start..run.rows.end.saturating_sub(span)).step_by(spacing) {
                let segment = ReadingsRange {
                    rows,
                    first: from,
                    count: span,
                };
                let (mut early, mut late, mut origin) = (0.0, 0.0, None);
                for_each_block(&segment, scales, |first, input, output| {
                    for (i, (a, b)) in input.iter().zip(output).enumerate() {
                        let e = b - ratio * a;
                        let e = e - *origin.get_or_insert(e);
                        match first + i < self.wide {
                            true => early += e,
                            false => late += e,
                        }
                    }
                })?;
                sizes.push(((late - early) / self.wide as f64).abs());
            }
        }
        Ok(sizes)
    }

    /// Calls `visit(row, narrow step, wide step)` for all rows whose windows lie in a run and whose wide step is `min_step` or more.
    fn for_each_step(
        &self,
        rows: &dyn EncoderReadings,
        scales: EncoderScales,
        ratio: f64,
        runs: &[DirectionRun],
        min_step: f64,
        mut visit: impl FnMut(usize, f64, f64),
    ) -> Result<(), Error> {
        // Running sums of the error over the length of the windows.
        let mut sums: Vec<f64> = vec![0.0];
        let mut first = 0; // row of sums[0]
        let mut next = 0; // next row to examine
        let mut origin = None;
        for_each_block(rows, scales, |_, input, output| {
            let mut sum = sums.last().copied().unwrap_or(0.0);
            let origin = *origin.get_or_insert_with(|| output[0] - ratio * input[0]);
            sums.extend(input.iter().zip(output).map(|(a, b)| {
                sum += (b - ratio * a) - origin;
                sum
            }));
            let end = first + sums.len() - 1; // rows read
            for run in runs {
                let examined = inner_rows(run, self.wide, next..end.saturating_sub(self.wide) + 1);
                if examined.is_empty() {
                    continue;
                }
                let k = examined.start - first..examined.end - first;
                let before = &sums[k.start - self.wide..k.end - self.wide];
                let after = &sums[k.start + self.wide..k.end + self.wide];
                let min_step = min_step * self.wide as f64;
                for (i, ((a, b), c)) in before.iter().zip(&sums[k.clone()]).zip(after).enumerate() {
                    let far = a - 2.0 * b + c;
                    if far.abs() >= min_step {
                        let (i, w) = (k.start + i, self.narrow);
                        let near = (sums[i + w] - 2.0 * sums[i] + sums[i - w]) / w as f64;
                        visit(first + i, near, far / self.wide as f64);
                    }
                }
            }
            next = next.max((end + 1).saturating_sub(self.wide));
            let expired = next.saturating_sub(self.wide).saturating_sub(first);
            sums.drain(..expired);
            first += expired;
        })
    }
}

/// Rows of the range `candidates` whose wide windows lie within the run.
fn inner_rows(run: &DirectionRun, wide: usize, candidates: Range<usize>) -> Range<usize> {
    let low = (run.rows.start + wide).max(candidates.start);
    let high = run.rows.end.saturating_sub(wide).min(candidates.end);
    low..high.max(low)
}
