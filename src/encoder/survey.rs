//! Survey of a record: direction runs, reversals, angle increment per row, measured ratio.

use std::f64::consts::TAU;
use std::ops::Range;

use super::gear_train::GearTrain;
use super::readings::{EncoderReadings, EncoderScales, for_each_block};
use crate::base::code::Code;
use crate::base::error::Error;

/// Maximum number of survey points of a record.
const POINTS: usize = 4096;

/// Rows over which the angle increment is averaged.
const INCREMENT_ROWS: usize = 16;

/// Backward rotation that counts as a reversal, in encoder steps and in revolutions; both apply.
const REVERSAL_THRESHOLD: (f64, f64) = (8.0, 1e-3);

/// Rest band of a shaft, in encoder steps and in revolutions: a reading at the edge of a count alternates between two counts.
const MAX_REST_STEPS: (f64, f64) = (2.5, 1.25e-4);

/// Minimum duration of a rest, in rows and as a multiple of the time of rotation through the rest band at mean speed.
const MIN_REST_ROWS: (usize, f64) = (16, 4.0);

/// Segment of a record with one direction of input rotation.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectionRun {
    /// Rows of the run.
    pub rows: Range<usize>,
    /// True where the input angle increases.
    pub forward: bool,
    /// Angle of the input at both ends of the run, rad.
    pub input: (f64, f64),
}

impl DirectionRun {
    /// Rotation of the input over the run, rad.
    pub fn travel(&self) -> f64 {
        (self.input.1 - self.input.0).abs()
    }
}

/// Directions, speeds and rest periods of a record.
#[derive(Debug, Clone)]
pub struct RecordSurvey {
    /// Direction runs in the order of time.
    pub runs: Vec<DirectionRun>,
    /// Largest input rotation per row, averaged over 16 rows, rad.
    pub max_increment: f64,
    /// Row, input angle and output angle, rad, at equally spaced rows.
    pub points: Vec<(usize, f64, f64)>,
    /// Number of rows at rest at the beginning and at the end, outside of all runs.
    pub rest_rows: [usize; 2],
}

/// Measured transmission ratio of a record and its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredRatio {
    /// Output revolutions per input revolution; negative for encoders of opposite counting directions.
    pub value: f64,
    /// Relative uncertainty: the smallest drift over the record that exceeds the transmission error.
    pub relative_uncertainty: f64,
}

/// Surveys a record in one pass over the rows.
///
/// # Errors
/// Readings that cannot be read or are no numbers; `NoSignal`: the input does not rotate.
pub fn survey(rows: &dyn EncoderReadings, scales: EncoderScales) -> Result<RecordSurvey, Error> {
    let count = rows.n_rows();
    let reversal = (REVERSAL_THRESHOLD.0 * scales.input.step).max(REVERSAL_THRESHOLD.1 * TAU);
    let spacing = count.div_ceil(POINTS).max(1);
    let mut result = RecordSurvey {
        runs: Vec::new(),
        max_increment: 0.0,
        points: Vec::with_capacity(POINTS + 1),
        rest_rows: [0, 0],
    };
    let rest_band = (MAX_REST_STEPS.0 * scales.input.step).max(MAX_REST_STEPS.1 * TAU);
    // Row and angle at the end of the rest before the first run.
    let mut rest_end = (0, 0.0);
    // The run in progress.
    let mut run: Option<RunTracker> = None;
    // Angles of the preceding rows, and the largest increments over `INCREMENT_ROWS` rows.
    let mut recent = [f64::NAN; INCREMENT_ROWS];
    let mut increments = [0.0; INCREMENT_ROWS];
    let mut next = 0;
    for_each_block(rows, scales, |first, input, output| {
        while next < first + input.len() {
            let i = next - first;
            result.points.push((next, input[i], output[i]));
            next += spacing;
        }
        // Block lengths are multiples of `INCREMENT_ROWS`.
        for rows in input.chunks(INCREMENT_ROWS) {
            for ((&angle, previous), max) in rows.iter().zip(&mut recent).zip(&mut increments) {
                let increment = (angle - *previous).abs();
                *max = if increment > *max { increment } else { *max };
                *previous = angle;
            }
        }
        for (i, &angle) in input.iter().enumerate() {
            let row = first + i;
            let tracker = run.get_or_insert(RunTracker::new(row, angle));
            if tracker.forward.is_none() && (angle - tracker.start.1).abs() <= rest_band {
                rest_end = (row, angle);
            }
            if let Some(finished) = tracker.push(row, angle, reversal, rest_band) {
                result.runs.push(finished);
            }
        }
    })?;
    result.max_increment = increments.into_iter().fold(0.0, f64::max) / INCREMENT_ROWS as f64;
    if let Some(tracker) = run {
        let last_advance = tracker.last_advance;
        result.runs.extend(tracker.end(count));
        result.trim(rest_end, last_advance, rest_band);
    }
    if result.runs.is_empty() {
        let message = "the input does not turn";
        return Err(Error::new(Code::NoSignal, message).with_hint(
            "check whether this is its channel: `geardyn check LOG` shows what each holds",
        ));
    }
    Ok(result)
}

/// State of the direction run in progress: rows and angles, rad.
struct RunTracker {
    start: (usize, f64),
    far: (usize, f64),
    /// Last row and angle of an advance by more than the rest band.
    last_advance: (usize, f64),
    forward: Option<bool>,
}

impl RunTracker {
    fn new(row: usize, angle: f64) -> RunTracker {
        RunTracker {
            start: (row, angle),
            far: (row, angle),
            last_advance: (row, angle),
            forward: None,
        }
    }

    /// Adds a row; returns the run that ends at a reversal.
    fn push(&mut self, row: usize, angle: f64, reversal: f64, band: f64) -> Option<DirectionRun> {
        let Some(forward) = self.forward else {
            if (angle - self.start.1).abs() > reversal {
                self.forward = Some(angle > self.start.1);
                self.far = (row, angle);
                self.last_advance = self.far;
            }
            return None;
        };
        let advance = if forward {
            angle - self.far.1
        } else {
            self.far.1 - angle
        };
        if (angle - self.last_advance.1).abs() > band && advance > 0.0 {
            self.last_advance = (row, angle);
        }
        if advance > 0.0 {
            self.far = (row, angle);
        } else if -advance > reversal {
            let finished = self.run(forward);
            *self = RunTracker {
                start: self.far,
                far: (row, angle),
                last_advance: (row, angle),
                forward: Some(!forward),
            };
            return Some(finished);
        }
        None
    }

    fn run(&self, forward: bool) -> DirectionRun {
        DirectionRun {
            rows: self.start.0..self.far.0 + 1,
            forward,
            input: (self.start.1, self.far.1),
        }
    }

    fn end(mut self, count: usize) -> Option<DirectionRun> {
        let forward = self.forward?;
        self.far.0 = count.saturating_sub(1);
        Some(self.run(forward))
    }
}

impl RecordSurvey {
    /// Removes the rests at both ends: rows up to `rest_end`, and rows after `last_advance`.
    fn trim(&mut self, rest_end: (usize, f64), last_advance: (usize, f64), band: f64) {
        let is_rest = |run: &DirectionRun, rows: usize| {
            let moving = run.rows.len().saturating_sub(rows) as f64;
            rows >= MIN_REST_ROWS.0 && rows as f64 > MIN_REST_ROWS.1 * moving * band / run.travel()
        };
        if let Some(run) = self.runs.first_mut() {
            let rows = rest_end.0.saturating_sub(run.rows.start);
            if is_rest(run, rows) {
                (run.rows.start, run.input.0) = rest_end;
                self.rest_rows[0] = rows;
            }
        }
        if let Some(run) = self.runs.last_mut() {
            let rows = run.rows.end.saturating_sub(last_advance.0 + 1);
            if is_rest(run, rows) {
                (run.rows.end, run.input.1) = (last_advance.0 + 1, last_advance.1);
                self.rest_rows[1] = rows;
            }
        }
    }

    /// Survey points of a run.
    fn points_in(&self, run: &DirectionRun) -> impl Iterator<Item = &(usize, f64, f64)> {
        self.points.iter().filter(|p| run.rows.contains(&p.0))
    }

    /// Transmission ratio as the common slope of straight lines through all runs, by least squares.
    ///
    /// # Errors
    /// `NoSignal`: the output does not rotate.
    pub fn ratio(&self, steps: (f64, f64)) -> Result<MeasuredRatio, Error> {
        let (mut square, mut product, mut residual, mut n) = (0.0, 0.0, 0.0, 0.0);
        let mut centred: Vec<(f64, f64)> = Vec::new();
        for run in &self.runs {
            let count = self.points_in(run).count() as f64;
            let sums = self
                .points_in(run)
                .fold((0.0, 0.0), |s, p| (s.0 + p.1, s.1 + p.2));
            let mean = (sums.0 / count.max(1.0), sums.1 / count.max(1.0));
            centred.extend(self.points_in(run).map(|p| (p.1 - mean.0, p.2 - mean.1)));
        }
        for (x, y) in &centred {
            square += x * x;
            product += x * y;
        }
        let value = product / square;
        for (x, y) in &centred {
            residual += (y - value * x).powi(2);
            n += 1.0;
        }
        if !(value.abs() > 0.0 && value.is_finite()) {
            let message = "the output does not turn while the input does";
            return Err(Error::new(Code::NoSignal, message).with_hint(
                "check whether this is its channel: `geardyn check LOG` shows what each holds",
            ));
        }
        // Six times the rms residual: one period of a sine over the run has a slope of 4.4 times its rms residual.
        const DRIFT_FACTOR: f64 = 6.0;
        let travel = self
            .runs
            .iter()
            .map(DirectionRun::travel)
            .fold(0.0, f64::max);
        let drift = DRIFT_FACTOR * (residual / f64::max(n, 1.0)).sqrt()
            + 2.0 * (steps.1 + steps.0 * value.abs());
        Ok(MeasuredRatio {
            value,
            relative_uncertainty: drift / (travel * value.abs()),
        })
    }

    /// Rejects a record whose ratio differs from the tooth ratio by other tooth numbers or by slip.
    ///
    /// # Errors
    /// `RatioMismatch` with the measured ratio; `Slip` with the location.
    pub fn check_ratio(
        &self,
        teeth: &GearTrain,
        measured: MeasuredRatio,
        rate_hz: Option<f64>,
    ) -> Result<(), Error> {
        let declared = teeth.ratio().to_f64();
        let deviation = measured.value.abs() / declared - 1.0;
        if deviation.abs() <= measured.relative_uncertainty {
            return Ok(());
        }
        let pairs: Vec<String> = teeth
            .pairs()
            .iter()
            .map(|p| format!("{}:{}", p.0, p.1))
            .collect();
        let pairs = pairs.join(",");
        let comparison = format!(
            "the output turns {:.9} times for one turn of the input, and {pairs} makes {declared:.9} ({:+.2e} relative)",
            measured.value.abs(),
            deviation
        );
        if let Some((row, share)) = self.slip(declared, measured.value, deviation) {
            let position = match rate_hz {
                Some(rate) => format!("{:.4} s", row as f64 / rate),
                None => format!("row {}", row + 1),
            };
            let message = format!(
                "slip: {comparison}; {share:.0} % of the difference arises near {position}"
            );
            return Err(Error::new(Code::Slip, message)
                .with_hint("check couplings, clamps and belts; choose a segment without slip: --after, --before"));
        }
        let largest = teeth
            .pairs()
            .iter()
            .map(|p| p.0.max(p.1))
            .max()
            .unwrap_or(1);
        let nearest = nearest_tooth_ratio(
            measured.value.abs(),
            measured.relative_uncertainty,
            u64::from(largest.max(100)) * 2,
        );
        let nearest = nearest.map_or(String::new(), |(a, b)| format!(": that is {a}:{b}"));
        let ratio = measured.value.abs() / declared;
        let factor = ratio.max(1.0 / ratio);
        let is_integer =
            factor > 1.5 && (factor / factor.round() - 1.0).abs() <= measured.relative_uncertainty;
        if is_integer {
            let message = format!(
                "{comparison}, {} by a factor of exactly {factor:.0}",
                if ratio > 1.0 { "too many" } else { "too few" }
            );
            let is_reciprocal =
                (ratio * declared * declared - 1.0).abs() <= measured.relative_uncertainty;
            let hint = match is_reciprocal {
                true => {
                    "the ratio is the reciprocal of that of the teeth: interchange --input and --output, or the teeth of each pair"
                }
                false => {
                    "check --lines and --counts-per-line of both encoders (the factor is whole), then --teeth"
                }
            };
            return Err(Error::new(Code::RatioMismatch, message).with_hint(hint));
        }
        Err(Error::new(Code::RatioMismatch, format!("{comparison}{nearest}"))
            .with_hint("check --teeth (driver first), --lines and --counts-per-line of both encoders, and whether input and output are interchanged"))
    }

    /// Location of a slip: the first row of the eighth of the longest run with the largest share of the difference, and that share, %.
    fn slip(&self, declared: f64, measured: f64, deviation: f64) -> Option<(usize, f64)> {
        const SECTIONS: usize = 8;
        /// Largest share of a section by other tooth numbers, nominally 1/8; a slip is concentrated in one or two sections.
        const MAX_SECTION_SPREAD: f64 = 0.3;
        let run = self
            .runs
            .iter()
            .max_by(|a, b| a.travel().total_cmp(&b.travel()))?;
        let points: Vec<_> = self.points_in(run).collect();
        let (first, last) = (points.first()?, points.last()?);
        let ideal = declared * measured.signum();
        let drift =
            |a: &(usize, f64, f64), b: &(usize, f64, f64)| (b.2 - a.2) - ideal * (b.1 - a.1);
        let total = drift(first, last);
        let point = |k: usize| points[k * (points.len() - 1) / SECTIONS];
        let shares = (0..SECTIONS).map(|k| (point(k).0, drift(point(k), point(k + 1)) / total));
        let max = shares.max_by(|a, b| a.1.total_cmp(&b.1))?;
        // A larger relative deviation is another gear pair.
        const MAX_SLIP: f64 = 0.2;
        (max.1 > MAX_SECTION_SPREAD && deviation.abs() < MAX_SLIP).then_some((max.0, 100.0 * max.1))
    }
}

impl RecordSurvey {
    /// Runs without the take-up of the backlash and one tooth pitch after each reversal; `pitch`: of the input, rad.
    pub fn after_take_up(&self, ratio: f64, pitch: f64) -> Vec<DirectionRun> {
        /// Margin of the take-up angle over the measured backlash.
        const TAKE_UP_MARGIN: f64 = 1.5;
        let median_error = |run: &DirectionRun| {
            let mut errors: Vec<f64> = self.points_in(run).map(|p| p.2 - ratio * p.1).collect();
            let middle = errors.len() / 2;
            errors.sort_by(f64::total_cmp);
            errors.get(middle).copied()
        };
        let mut trimmed_runs = Vec::with_capacity(self.runs.len());
        let mut previous = None;
        for run in &self.runs {
            let current = median_error(run);
            let mut trimmed = run.clone();
            if let (Some(previous), Some(current)) = (previous, current) {
                let backlash = f64::abs(current - previous) / ratio.abs();
                let skip = TAKE_UP_MARGIN * backlash + pitch;
                let is_loaded = |p: &&(usize, f64, f64)| (p.1 - run.input.0).abs() > skip;
                match self.points_in(run).find(is_loaded) {
                    Some(&(row, input, _)) => (trimmed.rows.start, trimmed.input.0) = (row, input),
                    None => trimmed.rows.start = trimmed.rows.end,
                }
            }
            previous = current.or(previous);
            trimmed_runs.push(trimmed);
        }
        trimmed_runs.retain(|run| run.rows.len() > 1);
        trimmed_runs
    }
}

/// Tooth numbers up to `max_teeth` whose ratio lies within a relative tolerance, by continued fraction.
fn nearest_tooth_ratio(ratio: f64, tolerance: f64, max_teeth: u64) -> Option<(u64, u64)> {
    let (mut p, mut q) = ((1u64, ratio.floor() as u64), (0u64, 1u64));
    let mut frac = ratio - ratio.floor();
    const MIN_TOLERANCE: f64 = 1e-6;
    while (p.1 as f64 / q.1 as f64 / ratio - 1.0).abs() > tolerance.max(MIN_TOLERANCE) {
        let term = (1.0 / frac).floor();
        frac = 1.0 / frac - term;
        let step = |(a, b): (u64, u64)| Some((b, (term as u64).checked_mul(b)?.checked_add(a)?));
        (p, q) = (step(p)?, step(q)?);
        if p.1 > max_teeth || q.1 > max_teeth || !frac.is_finite() {
            return None;
        }
    }
    (p.1 > 0).then_some((p.1, q.1))
}
