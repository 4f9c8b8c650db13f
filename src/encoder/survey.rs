//! Survey of a record: direction runs, reversals, angle increment per row, measured ratio.

use std::f64::consts::TAU;
use std::ops::Range;

use super::gear_train::GearTrain;
use super::readings::{EncoderReadings, EncoderScales, for_each_block};
use crate::base::code::Code;
use crate::base::error::Error;

/// Points of a record kept for its survey.
const POINTS: usize = 4096;

/// Rows over which the pace is taken.
const INCREMENT_ROWS: usize = 16;

/// A shaft has turned back when it went so many steps of its encoder the other way, and so much of a turn.
const REVERSAL_THRESHOLD: (f64, f64) = (8.0, 1e-3);

/// Rest limit of a shaft, in steps of its encoder, and in turns: a reading at an edge goes a count back and forth.
const MAX_REST_STEPS: (f64, f64) = (2.5, 1.25e-4);

/// Minimum length of a rest in rows, and as a multiple of the time it takes to turn as far at the mean speed.
const MIN_REST_ROWS: (usize, f64) = (16, 4.0);

/// A segment in which the input turns one way.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectionRun {
    /// Rows of the run.
    pub rows: Range<usize>,
    /// It turns up.
    pub forward: bool,
    /// Angle of the input at its ends, rad.
    pub input: (f64, f64),
}

impl DirectionRun {
    /// Travel of the input, rad.
    pub fn travel(&self) -> f64 {
        (self.input.1 - self.input.0).abs()
    }
}

/// Directions, speeds and rest periods of a record.
#[derive(Debug, Clone)]
pub struct RecordSurvey {
    /// Runs in one direction, in their order.
    pub runs: Vec<DirectionRun>,
    /// The largest turn of the input in one row, averaged over a few, rad.
    pub max_increment: f64,
    /// Rows, input and output angle, at even distances.
    pub points: Vec<(usize, f64, f64)>,
    /// Rows at either end in which the input is at rest; they belong to no run.
    pub still: [usize; 2],
}

/// The ratio of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredRatio {
    /// Turns of the output for one of the input; negative where the encoders count against each other.
    pub value: f64,
    /// Relative uncertainty: the smallest drift over the record that is distinguishable from the error itself.
    pub relative_uncertainty: f64,
}

/// Looks at every row once.
///
/// # Errors
/// Readings that cannot be read or are no numbers; `NoSignal` where nothing turns.
pub fn survey(rows: &dyn EncoderReadings, scales: EncoderScales) -> Result<RecordSurvey, Error> {
    let count = rows.n_rows();
    let back = (REVERSAL_THRESHOLD.0 * scales.input.step).max(REVERSAL_THRESHOLD.1 * TAU);
    let every = count.div_ceil(POINTS).max(1);
    let mut found = RecordSurvey {
        runs: Vec::new(),
        max_increment: 0.0,
        points: Vec::with_capacity(POINTS + 1),
        still: [0, 0],
    };
    let still = (MAX_REST_STEPS.0 * scales.input.step).max(MAX_REST_STEPS.1 * TAU);
    // Where the first run leaves its first angle, and where the last one comes to its last.
    let mut left = (0, 0.0);
    // The farthest the run has come, and where it began.
    let mut run: Option<RunTracker> = None;
    // Angles of the rows before, and the farthest from there to the same place of the next.
    let mut recent = [f64::NAN; INCREMENT_ROWS];
    let mut farthest = [0.0; INCREMENT_ROWS];
    let mut next = 0;
    for_each_block(rows, scales, |first, input, output| {
        while next < first + input.len() {
            let at = next - first;
            found.points.push((next, input[at], output[at]));
            next += every;
        }
        // Blocks are whole multiples of these rows.
        for rows in input.chunks(INCREMENT_ROWS) {
            for ((&angle, before), most) in rows.iter().zip(&mut recent).zip(&mut farthest) {
                let way = (angle - *before).abs();
                *most = if way > *most { way } else { *most };
                *before = angle;
            }
        }
        for (i, &angle) in input.iter().enumerate() {
            let row = first + i;
            let turning = run.get_or_insert(RunTracker::revolutions_at(row, angle));
            if turning.forward.is_none() && (angle - turning.start.1).abs() <= still {
                left = (row, angle);
            }
            if let Some(done) = turning.see(row, angle, back, still) {
                found.runs.push(done);
            }
        }
    })?;
    found.max_increment = farthest.into_iter().fold(0.0, f64::max) / INCREMENT_ROWS as f64;
    if let Some(turning) = run {
        let came = turning.came;
        found.runs.extend(turning.end(count));
        found.trim(left, came, still);
    }
    if found.runs.is_empty() {
        let message = "the input does not turn";
        return Err(Error::new(Code::NoSignal, message).with_hint(
            "check whether this is its channel: `geardyn check LOG` shows what each holds",
        ));
    }
    Ok(found)
}

/// A run being followed.
struct RunTracker {
    start: (usize, f64),
    far: (usize, f64),
    /// Last row that was farther than those before by more than a shaft at rest moves.
    came: (usize, f64),
    forward: Option<bool>,
}

impl RunTracker {
    fn revolutions_at(row: usize, angle: f64) -> RunTracker {
        RunTracker {
            start: (row, angle),
            far: (row, angle),
            came: (row, angle),
            forward: None,
        }
    }

    /// One more row; the run that it ends, if it does.
    fn see(&mut self, row: usize, angle: f64, back: f64, still: f64) -> Option<DirectionRun> {
        let Some(forward) = self.forward else {
            if (angle - self.start.1).abs() > back {
                self.forward = Some(angle > self.start.1);
                self.far = (row, angle);
                self.came = self.far;
            }
            return None;
        };
        let beyond = if forward {
            angle - self.far.1
        } else {
            self.far.1 - angle
        };
        if (angle - self.came.1).abs() > still && beyond > 0.0 {
            self.came = (row, angle);
        }
        if beyond > 0.0 {
            self.far = (row, angle);
        } else if -beyond > back {
            let done = self.run(forward);
            *self = RunTracker {
                start: self.far,
                far: (row, angle),
                came: (row, angle),
                forward: Some(!forward),
            };
            return Some(done);
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
    /// Removes rows at both ends in which the input is at rest: up to where it `left` its first angle, from where it `came` to its last.
    fn trim(&mut self, left: (usize, f64), came: (usize, f64), still: f64) {
        let rests = |run: &DirectionRun, rows: usize| {
            let moving = run.rows.len().saturating_sub(rows) as f64;
            rows >= MIN_REST_ROWS.0 && rows as f64 > MIN_REST_ROWS.1 * moving * still / run.travel()
        };
        if let Some(run) = self.runs.first_mut() {
            let rows = left.0.saturating_sub(run.rows.start);
            if rests(run, rows) {
                (run.rows.start, run.input.0) = left;
                self.still[0] = rows;
            }
        }
        if let Some(run) = self.runs.last_mut() {
            let rows = run.rows.end.saturating_sub(came.0 + 1);
            if rests(run, rows) {
                (run.rows.end, run.input.1) = (came.0 + 1, came.1);
                self.still[1] = rows;
            }
        }
    }

    /// Points inside a run.
    fn points_in(&self, run: &DirectionRun) -> impl Iterator<Item = &(usize, f64, f64)> {
        self.points.iter().filter(|p| run.rows.contains(&p.0))
    }

    /// Turns of the output for one of the input, by a straight line through each run, the longer ones counting more.
    ///
    /// # Errors
    /// `NoSignal`: the output does not turn.
    pub fn ratio(&self, steps: (f64, f64)) -> Result<MeasuredRatio, Error> {
        let (mut square, mut product, mut rest, mut n) = (0.0, 0.0, 0.0, 0.0);
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
            rest += (y - value * x).powi(2);
            n += 1.0;
        }
        if !(value.abs() > 0.0 && value.is_finite()) {
            let message = "the output does not turn while the input does";
            return Err(Error::new(Code::NoSignal, message).with_hint(
                "check whether this is its channel: `geardyn check LOG` shows what each holds",
            ));
        }
        // Six times what is left next to a straight line: a wave of one period leaves a slope of 4.4 times that.
        const WAVE: f64 = 6.0;
        let reach = self
            .runs
            .iter()
            .map(DirectionRun::travel)
            .fold(0.0, f64::max);
        let drift =
            WAVE * (rest / f64::max(n, 1.0)).sqrt() + 2.0 * (steps.1 + steps.0 * value.abs());
        Ok(MeasuredRatio {
            value,
            relative_uncertainty: drift / (reach * value.abs()),
        })
    }

    /// Refuses a record whose ratio is not that of the teeth: other teeth, or slip.
    ///
    /// # Errors
    /// `RatioMismatch`, saying the measured ratio; `Slip`, saying where.
    pub fn check_ratio(
        &self,
        teeth: &GearTrain,
        found: MeasuredRatio,
        rate_hz: Option<f64>,
    ) -> Result<(), Error> {
        let declared = teeth.ratio().to_f64();
        let off = found.value.abs() / declared - 1.0;
        if off.abs() <= found.relative_uncertainty {
            return Ok(());
        }
        let pairs: Vec<String> = teeth
            .pairs()
            .iter()
            .map(|p| format!("{}:{}", p.0, p.1))
            .collect();
        let pairs = pairs.join(",");
        let said = format!(
            "the output turns {:.9} times for one turn of the input, and {pairs} makes {declared:.9} ({:+.2e} relative)",
            found.value.abs(),
            off
        );
        if let Some((row, share)) = self.slip(declared, found.value, off) {
            let place = match rate_hz {
                Some(rate) => format!("{:.4} s", row as f64 / rate),
                None => format!("row {}", row + 1),
            };
            let message = format!(
                "something slips: {said}; {share:.0} % of the difference arises near {place}"
            );
            return Err(Error::new(Code::Slip, message)
                .with_hint("check couplings, clamps and belts; take a segment in which nothing slips: --after, --before"));
        }
        let largest = teeth
            .pairs()
            .iter()
            .map(|p| p.0.max(p.1))
            .max()
            .unwrap_or(1);
        let near = nearest_tooth_ratio(
            found.value.abs(),
            found.relative_uncertainty,
            u64::from(largest.max(100)) * 2,
        );
        let near = near.map_or(String::new(), |(a, b)| format!(": that is {a}:{b}"));
        let times = found.value.abs() / declared;
        let whole = times.max(1.0 / times);
        let is_whole =
            whole > 1.5 && (whole / whole.round() - 1.0).abs() <= found.relative_uncertainty;
        if is_whole {
            let message = format!(
                "{said}, {} by exactly {whole:.0}",
                if times > 1.0 { "too many" } else { "too few" }
            );
            return Err(Error::new(Code::RatioMismatch, message).with_hint(
                "a whole factor comes from the encoders: check --lines and --counts-per-line of both, then --teeth",
            ));
        }
        Err(Error::new(Code::RatioMismatch, format!("{said}{near}"))
            .with_hint("check --teeth (driver first), --lines and --counts-per-line of both encoders, and whether input and output are interchanged"))
    }

    /// Location of the difference, if it does not arise evenly: the row, and the share of it in that eighth of its run, per cent.
    fn slip(&self, declared: f64, measured: f64, off: f64) -> Option<(usize, f64)> {
        const SECTIONS: usize = 8;
        /// Other teeth make an eighth of the difference in each section; a slip makes most of it in one or two.
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
        let whole = drift(first, last);
        let at = |k: usize| points[k * (points.len() - 1) / SECTIONS];
        let shares = (0..SECTIONS).map(|k| (at(k).0, drift(at(k), at(k + 1)) / whole));
        let most = shares.max_by(|a, b| a.1.total_cmp(&b.1))?;
        // No pair of wheels is mistaken for one that differs by less than this.
        const TEETH: f64 = 0.2;
        (most.1 > MAX_SECTION_SPREAD && off.abs() < TEETH).then_some((most.0, 100.0 * most.1))
    }
}

impl RecordSurvey {
    /// The runs without what follows a reversal until the play is taken up and a tooth has passed; `pitch` of the input, rad.
    pub fn after_take_up(&self, ratio: f64, pitch: f64) -> Vec<DirectionRun> {
        /// Margin of the take-up angle over the backlash that shows.
        const TAKE_UP_MARGIN: f64 = 1.5;
        let level = |run: &DirectionRun| {
            let mut all: Vec<f64> = self.points_in(run).map(|p| p.2 - ratio * p.1).collect();
            let middle = all.len() / 2;
            all.sort_by(f64::total_cmp);
            all.get(middle).copied()
        };
        let mut settled = Vec::with_capacity(self.runs.len());
        let mut before = None;
        for run in &self.runs {
            let here = level(run);
            let mut kept = run.clone();
            if let (Some(before), Some(here)) = (before, here) {
                let play = f64::abs(here - before) / ratio.abs();
                let skip = TAKE_UP_MARGIN * play + pitch;
                let passed = |p: &&(usize, f64, f64)| (p.1 - run.input.0).abs() > skip;
                match self.points_in(run).find(passed) {
                    Some(&(row, input, _)) => (kept.rows.start, kept.input.0) = (row, input),
                    None => kept.rows.start = kept.rows.end,
                }
            }
            before = here.or(before);
            settled.push(kept);
        }
        settled.retain(|run| run.rows.len() > 1);
        settled
    }
}

/// The fraction of smallest numbers within `relative_uncertainty` of a ratio, by its continued fraction.
fn nearest_tooth_ratio(ratio: f64, known_to: f64, most: u64) -> Option<(u64, u64)> {
    let (mut top, mut bottom) = ((1u64, ratio.floor() as u64), (0u64, 1u64));
    let mut rest = ratio - ratio.floor();
    const MIN_COUNT: f64 = 1e-6;
    while (top.1 as f64 / bottom.1 as f64 / ratio - 1.0).abs() > known_to.max(MIN_COUNT) {
        let whole = (1.0 / rest).floor();
        rest = 1.0 / rest - whole;
        let step = |(a, b): (u64, u64)| Some((b, (whole as u64).checked_mul(b)?.checked_add(a)?));
        (top, bottom) = (step(top)?, step(bottom)?);
        if top.1 > most || bottom.1 > most || !rest.is_finite() {
            return None;
        }
    }
    (top.1 > 0).then_some((top.1, bottom.1))
}
