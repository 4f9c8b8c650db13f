//! Lost or extra encoder counts: steps of the error by whole counts.
//!
//! `D_i = mean(e_i … e_{i+w}) − mean(e_{i−w} … e_i)` over a tooth on either side, where what the mesh does averages out, stands out of its
//! own median deviation.

use std::ops::Range;

use super::readings::{EncoderReadings, EncoderScales, ReadingsRange, for_each_block};
use super::survey::{DirectionRun, RecordSurvey};
use crate::base::error::Error;
use crate::base::text::pluralise;
use crate::numeric::Matrix;
use crate::numeric::least_squares::solve;
use crate::numeric::sorting::sort_falling;

/// A place where counts are missing or too many.
#[derive(Debug, Clone, PartialEq)]
pub struct CountStep {
    /// The first row after it.
    pub row: usize,
    /// By how much the error steps, rad of the output.
    pub step: f64,
    /// Counts the encoder read too many; negative: missing.
    pub counts: f64,
    /// Encoder that made the step; both where a count of either would make the same step.
    pub encoder: &'static str,
    /// Counts of the other encoder that would make this step as well.
    pub alternative: Option<(f64, &'static str)>,
}

impl CountStep {
    /// `5 counts lost on the output or 3 too many on the input`.
    pub fn describe(&self) -> String {
        let what = |counts: f64| if counts < 0.0 { "lost" } else { "too many" };
        let or = self.alternative.map_or(String::new(), |(counts, whose)| {
            format!(" or {} {} on the {whose}", counts.abs(), what(counts))
        });
        let count = pluralise(self.counts.abs() as usize, "count");
        format!("{count} {} on the {}{or}", what(self.counts), self.encoder)
    }
}

/// Parameters of the search for steps in the error.
#[derive(Debug, Clone, Copy)]
pub struct StepSearch<'a> {
    /// Survey of the record, the output counting up with the input.
    pub survey: &'a RecordSurvey,
    /// Turns of the output for one of the input.
    pub ratio: f64,
    /// Rows that pass in one tooth of the output.
    pub rows_per_tooth: f64,
}

/// Rows on either side of a place: to see where a step is, and that it is one.
const NARROW: (usize, usize) = (4, 24);

/// See [`NARROW`].
const WIDE: usize = 4096;

/// A step this many deviations out is one, where the deviation is of noise alone.
const STEP_THRESHOLD: f64 = 8.0;

/// A step is one where it has this share of a count.
const MIN_COUNT_SHARE: f64 = 0.6;

/// Counts of both encoders make steps that differ by no more than this share: nothing tells which lost one.
const AMBIGUITY_TOLERANCE: f64 = 0.02;

/// Tolerance of the size of a step, over the smaller count.
const SIZE_TOLERANCE: f64 = 0.15;

/// Places that are followed up, the strongest.
const MAX_CANDIDATES: usize = 40;

/// Differences looked at to know the noise of all; fewer where their windows would lie on each other.
const SAMPLES: usize = 8192;

/// The places, in their order. Encoders without steps have none.
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
    let least = (MIN_COUNT_SHARE * smallest).max(STEP_THRESHOLD * deviation);
    // Over the wide windows a step is told from noise; where it is, the narrow ones say.
    let mut found: Vec<(usize, f64, f64)> = Vec::new();
    windows.for_each_step(
        rows,
        scales,
        request.ratio,
        runs,
        least,
        |row, near, far| {
            if far * near < 0.0 {
                return;
            }
            let height = near.abs() + far.abs();
            match found.last_mut() {
                Some(last) if row - last.0 <= 2 * wide => {
                    if height > last.1 {
                        *last = (row, height, far);
                    }
                }
                _ => found.push((row, height, far)),
            }
        },
    )?;
    sort_falling(&mut found, |a| a.1);
    found.truncate(MAX_CANDIDATES);
    found.sort_by_key(|f| f.0);
    let steps = fit_step_sizes(&found, runs, request);
    let all: Vec<CountStep> = found
        .iter()
        .zip(steps)
        .filter(|(_, step)| step.abs() > MIN_COUNT_SHARE * smallest)
        .map(|(&(row, ..), step)| as_counts(row, step, counts))
        .collect();
    Ok(if is_tooth_form(&all, runs) {
        Vec::new()
    } else {
        all
    })
}

/// Fits the step sizes over the whole record: with the turning of the shafts and a level for each run they are fitted to points of it.
/// Beats of two counters look like a step and go back; a lost count stays.
fn fit_step_sizes(
    found: &[(usize, f64, f64)],
    runs: &[DirectionRun],
    request: StepSearch,
) -> Vec<f64> {
    let claimed = found.iter().map(|f| f.2).collect();
    let inside = |run: &DirectionRun, row: usize| run.rows.contains(&row);
    let points: Vec<_> = request
        .survey
        .points
        .iter()
        .filter(|p| runs.iter().any(|r| inside(r, p.0)))
        .collect();
    const TURNING: usize = 8;
    let columns = runs.len() + TURNING + found.len();
    if found.is_empty() || points.len() < 2 * columns {
        return claimed;
    }
    let a = Matrix::from_fn(points.len(), columns, |i, j| {
        let &(row, input, _) = points[i];
        if let Some(run) = runs.get(j) {
            return f64::from(u8::from(inside(run, row)));
        }
        match j - runs.len() {
            k if k < TURNING => {
                let angle = [1.0, 2.0][k / 2 % 2] * input * [1.0, request.ratio][k / 4];
                if k % 2 == 0 { angle.cos() } else { angle.sin() }
            }
            k => f64::from(u8::from(row >= found[k - TURNING].0)),
        }
    });
    let error = |p: &(usize, f64, f64)| p.2 - request.ratio * p.1;
    let b = Matrix::from_fn(points.len(), 1, |i, _| error(points[i]) - error(points[0]));
    match solve(&a, &b) {
        Ok(x) => (0..found.len())
            .map(|k| x[(runs.len() + TURNING + k, 0)])
            .collect(),
        Err(_) => claimed, // steps too near each other for the points
    }
}

/// Places in cells, of the direction `forward`, as rows: the row whose angle it is, and there the row at which the error steps most.
///
/// # Errors
/// Readings that cannot be read.
pub fn locate_rows(
    found: &[(f64, f64)],
    rows: &dyn EncoderReadings,
    scales: EncoderScales,
    runs: &[DirectionRun],
    request: StepSearch,
) -> Result<Vec<CountStep>, Error> {
    /// Cells reach so many rows beyond a place.
    const SEARCH_ROWS: usize = 24;
    let near = ((request.rows_per_tooth / 8.0) as usize).clamp(NARROW.0, NARROW.1);
    let points = &request.survey.points;
    let mut all = Vec::new();
    for &(input, step) in found {
        let holds = |run: &&DirectionRun| (run.input.0 - input) * (run.input.1 - input) <= 0.0;
        let Some(run) = runs.iter().find(holds) else {
            continue;
        };
        let passed = |p: &&(usize, f64, f64)| {
            run.rows.contains(&p.0) && ((p.1 > input) == run.forward || p.1 == input)
        };
        let after = points.iter().find(passed).map_or(run.rows.end, |p| p.0);
        let before = points
            .iter()
            .rev()
            .find(|p| p.0 < after && run.rows.contains(&p.0));
        let (start, angle) = before.map_or((run.rows.start, run.input.0), |p| (p.0, p.1));
        let from = start.saturating_sub(SEARCH_ROWS + near).max(run.rows.start);
        let to = (after + SEARCH_ROWS + near).min(run.rows.end);
        let part = ReadingsRange {
            rows,
            from,
            count: to - from,
        };
        let (mut angles, mut errors) = (Vec::new(), Vec::new());
        for_each_block(&part, scales, |_, a, b| {
            angles.extend_from_slice(a);
            errors.extend(a.iter().zip(b).map(|(a, b)| b - request.ratio * a));
        })?;
        // A counter that begins again is counted from the start of the part: angles are those next to a known row.
        let Some(&known) = angles.get(start - from) else {
            continue;
        };
        let reached = |a: &f64| (a - known + angle > input) == run.forward;
        let cross = angles.iter().position(reached).unwrap_or(start - from);
        let mean = |from: usize, to: usize| {
            errors[from..to].iter().map(|e| e - errors[0]).sum::<f64>() / (to - from) as f64
        };
        let (low, high) = (
            cross.saturating_sub(SEARCH_ROWS).max(near),
            cross + SEARCH_ROWS,
        );
        let at = (low..=high.min(errors.len().saturating_sub(near)))
            .map(|i| (i, step.signum() * (mean(i, i + near) - mean(i - near, i))))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(cross, |best| best.0);
        let counts = (scales.input.step * request.ratio, scales.output.step);
        all.push(as_counts(from + at, step, counts));
    }
    Ok(all)
}

/// A step as whole counts of the encoder they fit better, `counts` being what one of either makes, rad of the output.
fn as_counts(row: usize, step: f64, counts: (f64, f64)) -> CountStep {
    // Too many counts of the input turn the error back.
    let fit = |count: f64| {
        let n = (step / count).round();
        let n = if n == 0.0 { (step / count).signum() } else { n };
        (n, (step - n * count).abs())
    };
    let (input, output) = (fit(-counts.0), fit(counts.1));
    // Fewer counts are likelier, as long as they fit as well.
    let better = |a: (f64, f64), b: (f64, f64)| {
        let slack = SIZE_TOLERANCE * counts.0.min(counts.1);
        a.1 + if a.0.abs() < b.0.abs() { -slack } else { slack } < b.1
    };
    let alike = (counts.0 - counts.1).abs() < AMBIGUITY_TOLERANCE * counts.1;
    // What misses the step by little more may be it as well: steps are known to no more than that.
    let slack = SIZE_TOLERANCE * counts.0.min(counts.1);
    let or = |other: (f64, f64), taken: (f64, f64), whose| {
        (other.1 < slack.max(taken.1 + slack)).then_some((other.0, whose))
    };
    let (counts, whose, or) = match (counts.0 > 0.0, counts.1 > 0.0) {
        (true, true) if alike => (output.0, "input or output", None),
        (true, true) if better(input, output) => (input.0, "input", or(output, input, "output")),
        (true, true) => (output.0, "output", or(input, output, "input")),
        (_, true) => (output.0, "output", None),
        _ => (input.0, "input", None),
    };
    CountStep {
        row,
        step,
        counts,
        encoder: whose,
        alternative: or,
    }
}

/// Steps that come and go tooth by tooth are the shape of the teeth: many, and their sum is nothing.
fn is_tooth_form(all: &[CountStep], runs: &[DirectionRun]) -> bool {
    const MIN_FORM_STEPS: usize = 12;
    const NET_STEP_TOLERANCE: f64 = 0.2;
    let sum: f64 = all.iter().map(|j| j.step).sum();
    let size: f64 = all.iter().map(|j| j.step.abs()).sum();
    all.len() > MIN_FORM_STEPS * runs.len().max(1) && sum.abs() < NET_STEP_TOLERANCE * size
}

/// Windows on either side of a row.
struct StepWindows {
    narrow: usize,
    wide: usize,
}

impl StepWindows {
    /// Sizes of the steps over the wide windows at places spread over the runs.
    fn sample_noise(
        &self,
        rows: &dyn EncoderReadings,
        scales: EncoderScales,
        ratio: f64,
        runs: &[DirectionRun],
    ) -> Result<Vec<f64>, Error> {
        let span = 2 * self.wide;
        let every = (rows.n_rows() / SAMPLES).max(span);
        let mut sizes = Vec::new();
        for run in runs {
            for from in (run.rows.start..run.rows.end.saturating_sub(span)).step_by(every) {
                let part = ReadingsRange {
                    rows,
                    from,
                    count: span,
                };
                let (mut early, mut late, mut origin) = (0.0, 0.0, None);
                for_each_block(&part, scales, |first, input, output| {
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

    /// `see(row, step near, step over the wide windows)` wherever both windows fit into a run and the wide ones show `least` or more.
    fn for_each_step(
        &self,
        rows: &dyn EncoderReadings,
        scales: EncoderScales,
        ratio: f64,
        runs: &[DirectionRun],
        least: f64,
        mut see: impl FnMut(usize, f64, f64),
    ) -> Result<(), Error> {
        // Running sums of the error, kept as far back as the windows reach.
        let mut sums: Vec<f64> = vec![0.0];
        let mut first = 0; // row of sums[0]
        let mut at = 0; // the next row to be judged
        let mut origin = None;
        for_each_block(rows, scales, |_, input, output| {
            let mut sum = sums.last().copied().unwrap_or(0.0);
            let origin = *origin.get_or_insert_with(|| output[0] - ratio * input[0]);
            sums.extend(input.iter().zip(output).map(|(a, b)| {
                sum += (b - ratio * a) - origin;
                sum
            }));
            let end = first + sums.len() - 1; // rows seen
            for run in runs {
                let judged = run_inside(run, self.wide, at..end.saturating_sub(self.wide) + 1);
                if judged.is_empty() {
                    continue;
                }
                let at = judged.start - first..judged.end - first;
                let before = &sums[at.start - self.wide..at.end - self.wide];
                let after = &sums[at.start + self.wide..at.end + self.wide];
                let least = least * self.wide as f64;
                for (i, ((a, b), c)) in before.iter().zip(&sums[at.clone()]).zip(after).enumerate()
                {
                    let far = a - 2.0 * b + c;
                    if far.abs() >= least {
                        let (i, w) = (at.start + i, self.narrow);
                        let near = (sums[i + w] - 2.0 * sums[i] + sums[i - w]) / w as f64;
                        see(first + i, near, far / self.wide as f64);
                    }
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
fn run_inside(run: &DirectionRun, wide: usize, wanted: Range<usize>) -> Range<usize> {
    let low = (run.rows.start + wide).max(wanted.start);
    let high = run.rows.end.saturating_sub(wide).min(wanted.end);
    low..high.max(low)
}
