//! Index pulses: angle of the index mark, and counts lost or added between two passages.
//!
//! A mark has two edges. The evaluated edge rises in forward rotation and falls in backward rotation, so that its angle is the same.

use std::f64::consts::TAU;

use super::readings::{EncoderReadings, EncoderScales, for_each_block};
use super::survey::DirectionRun;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::numeric::Complex;

/// Crossing of the mid level by an index signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PulseEdge {
    /// Row index with the fraction of the row interval.
    pub row: f64,
    /// True for an upward crossing.
    pub rising: bool,
}

/// Edges of a shaft's index signal and their uncertainty.
#[derive(Debug, Clone)]
pub struct IndexSignal {
    /// Edges in the order of time.
    pub edges: Vec<PulseEdge>,
    /// Uncertainty of the position of an edge, rows.
    pub edge_uncertainty: f64,
    /// Encoder counts per revolution; `None` for readings without counts.
    pub counts: Option<f64>,
}

/// Passage of the index mark, with the angles of both shafts.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PulsePassage {
    row: f64,
    /// Angle of the shaft with the mark, rad.
    angle: f64,
    /// Angle of the input, rad.
    input: f64,
    forward: bool,
    run: usize,
}

/// Encoder counts lost (negative) or added between two rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CountShift {
    /// Rows of the last passage before the shift and of the first one after it.
    pub rows: (f64, f64),
    /// Counts added; negative: lost.
    pub counts: f64,
    /// Standard deviation of the number of counts.
    pub deviation: f64,
}

/// Evaluation of a shaft's index pulses.
#[derive(Debug, Clone)]
pub struct IndexEvaluation {
    /// `input` or `output`.
    pub shaft: &'static str,
    /// Number of passages spaced by whole revolutions.
    pub passages: usize,
    /// Number of revolutions without a pulse.
    pub missing: usize,
    /// Number of pulses at other angles.
    pub extra: usize,
    /// Mean number of counts between successive passages; `None` for readings without counts.
    pub counts_between_passages: Option<f64>,
    /// Measured angle of the mark, revolutions from 0 to 1.
    pub mark_angle: f64,
    /// Standard deviation of the angle of the mark, revolutions.
    pub scatter: f64,
    /// Lost or extra counts in the order of time.
    pub shifts: Vec<CountShift>,
    accuracy: CountAccuracy,
    pulses: Vec<PulsePassage>,
}

/// Counts per revolution and their standard deviation at one passage.
#[derive(Debug, Clone, Copy)]
struct CountAccuracy {
    counts_per_rev: f64,
    deviation: f64,
}

/// Angular tolerance of passages of one mark about whole revolutions, revolutions.
const SAME_MARK: f64 = 0.05;

/// Detection threshold of lost counts: step of the mean level of the passages, in its standard deviations.
const SHIFT_THRESHOLD: f64 = 4.5;

/// Least detectable step of the mean level, in counts.
const MIN_COUNT_SHARE: f64 = 0.6;

/// Evaluates the index signals of both shafts; `max_increments` are the largest rotations of input and output per row, rad.
///
/// # Errors
/// Readings that cannot be read; `NoSignal`: no mark passes twice; `RatioMismatch`: marks not spaced by one revolution; `LostCounts`: in every revolution.
pub fn evaluate_indices(
    rows: &dyn EncoderReadings,
    scales: EncoderScales,
    runs: &[DirectionRun],
    signals: [Option<&IndexSignal>; 2],
    max_increments: [f64; 2],
) -> Result<[Option<IndexEvaluation>; 2], Error> {
    let mut passages = index_passages(rows, scales, runs, signals)?;
    let mut evaluations = [None, None];
    for (k, shaft) in ["input", "output"].into_iter().enumerate() {
        if let Some(signal) = signals[k] {
            evaluations[k] = Some(evaluate_index(
                shaft,
                signal,
                std::mem::take(&mut passages[k]),
                max_increments[k],
            )?);
        }
    }
    Ok(evaluations)
}

/// Passages of both marks with both angles, at the edges that belong to the direction of rotation.
fn index_passages(
    rows: &dyn EncoderReadings,
    scales: EncoderScales,
    runs: &[DirectionRun],
    signals: [Option<&IndexSignal>; 2],
) -> Result<[Vec<PulsePassage>; 2], Error> {
    let edges_and_runs_of = |signal: Option<&IndexSignal>| -> Vec<(f64, usize)> {
        let edges = signal.map_or(&[][..], |s| &s.edges);
        let in_run = |e: &PulseEdge| {
            let contains = |run: &DirectionRun| run.rows.contains(&(e.row.max(0.0) as usize));
            let run = runs.iter().position(contains)?;
            (runs[run].forward == e.rising).then_some((e.row, run))
        };
        edges.iter().filter_map(in_run).collect()
    };
    let edges_and_runs = signals.map(edges_and_runs_of);
    let mut cursor = [0, 0];
    let mut passages = [Vec::new(), Vec::new()];
    let mut previous: Option<(f64, f64)> = None;
    for_each_block(rows, scales, |first, input, output| {
        let angles_at = |row: usize| match row.checked_sub(first) {
            Some(i) => (input[i], output[i]),
            None => previous.unwrap_or((input[0], output[0])),
        };
        let end = first + input.len();
        for k in 0..2 {
            while let Some(&(row, run)) = edges_and_runs[k].get(cursor[k]) {
                let floor = row.floor() as usize;
                if floor + 1 >= end {
                    break;
                }
                cursor[k] += 1;
                if floor + 1 < first {
                    continue;
                }
                let (low, high) = (angles_at(floor), angles_at(floor + 1));
                let fraction = row - row.floor();
                let angles = (
                    low.0 + fraction * (high.0 - low.0),
                    low.1 + fraction * (high.1 - low.1),
                );
                passages[k].push(PulsePassage {
                    row,
                    angle: if k == 0 { angles.0 } else { angles.1 },
                    input: angles.0,
                    forward: runs[run].forward,
                    run,
                });
            }
        }
        previous = input.last().copied().zip(output.last().copied());
    })?;
    Ok(passages)
}

/// Evaluates the passages of one shaft's mark.
fn evaluate_index(
    shaft: &'static str,
    signal: &IndexSignal,
    passages: Vec<PulsePassage>,
    max_increment: f64,
) -> Result<IndexEvaluation, Error> {
    let per_rev = signal.counts.unwrap_or(0.0);
    let spacings: Vec<f64> = (passages.windows(2))
        .filter(|w| w[0].run == w[1].run)
        .map(|w| ((w[1].angle - w[0].angle) / TAU).abs())
        .collect();
    check_spacing(shaft, &spacings, per_rev)?;
    // The edge is uniformly distributed over its uncertainty, the reading over its count.
    let half_range = signal.edge_uncertainty * max_increment / TAU * per_rev + 0.5;
    let deviation = half_range / 3f64.sqrt();
    let n_edges = passages.len();
    let passages = whole_turn_passages(passages);
    let mut missing = 0;
    let (mut total_turns, mut residuals) = (0.0, Vec::with_capacity(passages.len()));
    for (k, passage) in passages.iter().enumerate() {
        if k > 0 {
            let turns = (passage.angle - passages[k - 1].angle) / TAU;
            total_turns += turns.round();
            if passage.run == passages[k - 1].run {
                missing += (turns.abs().round() as usize).saturating_sub(1);
            }
        }
        residuals.push((passage.angle - passages[0].angle) / TAU - total_turns);
    }
    let counts: Vec<f64> = residuals.iter().map(|x| x * per_rev).collect();
    check_systematic_loss(shaft, &passages, &counts, per_rev, deviation)?;
    let accuracy = CountAccuracy {
        counts_per_rev: per_rev,
        deviation,
    };
    let shifts = shifts(&passages, &counts, accuracy);
    let mean = residuals.iter().sum::<f64>() / residuals.len() as f64;
    let squares: f64 = residuals.iter().map(|x| (x - mean).powi(2)).sum();
    let single_turns: Vec<f64> = spacings
        .iter()
        .copied()
        .filter(|x| (x - 1.0).abs() < SAME_MARK)
        .collect();
    Ok(IndexEvaluation {
        shaft,
        passages: passages.len(),
        missing,
        extra: n_edges - passages.len(),
        counts_between_passages: (per_rev > 0.0 && !single_turns.is_empty())
            .then(|| per_rev * single_turns.iter().sum::<f64>() / single_turns.len() as f64),
        mark_angle: circular_mean(passages.iter().map(|p| p.angle / TAU)),
        scatter: (squares / residuals.len() as f64).sqrt(),
        shifts,
        accuracy,
        pulses: passages,
    })
}

/// Rejects marks that do not pass once per revolution.
fn check_spacing(shaft: &str, spacings: &[f64], counts_per_rev: f64) -> Result<(), Error> {
    if spacings.is_empty() {
        let message = format!("fewer than two index pulses of the {shaft} in one direction");
        return Err(Error::new(Code::NoSignal, message).with_hint(
            "take a longer segment, check whether this is its channel, or omit the index",
        ));
    }
    let mut sorted = spacings.to_vec();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[sorted.len() / 2];
    let near_median = sorted
        .iter()
        .filter(|x| (*x - median).abs() < SAME_MARK)
        .count();
    if (median - 1.0).abs() < SAME_MARK || 2 * near_median <= spacings.len() {
        return Ok(());
    }
    let spacing = match counts_per_rev > 0.0 {
        true => format!(
            "{:.0} counts apart, but a turn has {counts_per_rev:.0}",
            median * counts_per_rev
        ),
        false => format!("{median:.4} turns apart"),
    };
    let message = format!("the index pulses of the {shaft} are {spacing}");
    Err(Error::new(Code::RatioMismatch, message).with_hint(
        "check --lines and --counts-per-line; a pulse narrower than a row is missed: read more often, or widen it",
    ))
}

/// The largest group of passages spaced by whole revolutions.
fn whole_turn_passages(passages: Vec<PulsePassage>) -> Vec<PulsePassage> {
    let fraction = |p: &PulsePassage| (p.angle / TAU).rem_euclid(1.0);
    let distance = |a: f64, b: f64| {
        let d = (a - b).rem_euclid(1.0);
        d.min(1.0 - d)
    };
    const MAX_STARTS: usize = 32;
    let group_from = |start: usize| {
        let mut reference = fraction(&passages[start]);
        let mut group = Vec::new();
        for (k, passage) in passages.iter().enumerate().skip(start) {
            let angle = fraction(passage);
            if distance(angle, reference) < SAME_MARK {
                reference = angle;
                group.push(k);
            }
        }
        group
    };
    let largest = (0..passages.len().min(MAX_STARTS))
        .map(group_from)
        .max_by_key(Vec::len);
    let largest = largest.unwrap_or_default();
    largest.into_iter().map(|k| passages[k]).collect()
}

/// Rejects an encoder that loses equally many counts in every revolution: no step locates such a loss.
fn check_systematic_loss(
    shaft: &str,
    passages: &[PulsePassage],
    counts: &[f64],
    counts_per_rev: f64,
    deviation: f64,
) -> Result<(), Error> {
    let pairs = passages.windows(2).zip(counts.windows(2));
    let mut losses: Vec<f64> = pairs
        .filter(|(p, _)| p[0].run == p[1].run)
        .map(|(p, c)| (c[1] - c[0]) * (p[1].angle - p[0].angle).signum())
        .collect();
    const MIN_PASSAGES: usize = 3;
    if counts_per_rev == 0.0 || losses.len() < MIN_PASSAGES {
        return Ok(());
    }
    losses.sort_by(f64::total_cmp);
    let median = losses[losses.len() / 2];
    // A median of n has the standard deviation 1.25 σ/√n; both ends of a revolution contribute.
    let scatter = 1.25 * deviation * (2.0 / losses.len() as f64).sqrt();
    if median.abs() < MIN_COUNT_SHARE.max(SHIFT_THRESHOLD * scatter) {
        return Ok(());
    }
    let message = format!(
        "the {shaft} counts {:.1} from one index pulse to the next, turn by turn, where {counts_per_rev:.0} are stated",
        counts_per_rev + median
    );
    Err(Error::new(Code::LostCounts, message)
        .with_hint("check --lines; else clean its disc, or turn it more slowly"))
}

/// Steps of the mean level of the passages, by binary segmentation: split at the strongest step, then split both segments.
fn shifts(passages: &[PulsePassage], counts: &[f64], accuracy: CountAccuracy) -> Vec<CountShift> {
    if accuracy.counts_per_rev == 0.0 {
        return Vec::new();
    }
    let mean = |a: usize, b: usize| counts[a..b].iter().sum::<f64>() / (b - a) as f64;
    let step_std = |a: usize, k: usize, b: usize| {
        accuracy.deviation * (1.0 / (k - a) as f64 + 1.0 / (b - k) as f64).sqrt()
    };
    let mut splits = Vec::new();
    let mut open = vec![(0, counts.len())];
    while let Some((a, b)) = open.pop() {
        let significance = |k: usize| (mean(k, b) - mean(a, k)).abs() / step_std(a, k, b);
        let best = (a + 1..b).max_by(|&j, &k| significance(j).total_cmp(&significance(k)));
        if let Some(k) = best
            && significance(k) > SHIFT_THRESHOLD
            && (mean(k, b) - mean(a, k)).abs() > MIN_COUNT_SHARE
        {
            splits.push(k);
            open.extend([(a, k), (k, b)]);
        }
    }
    splits.sort_unstable();
    let edges: Vec<usize> = std::iter::once(0)
        .chain(splits.iter().copied())
        .chain([counts.len()])
        .collect();
    let steps = edges.windows(3).map(|e| CountShift {
        rows: (passages[e[1] - 1].row, passages[e[1]].row),
        counts: (mean(e[1], e[2]) - mean(e[0], e[1])).round(),
        deviation: step_std(e[0], e[1], e[2]),
    });
    steps.filter(|s| s.counts != 0.0).collect()
}

impl IndexEvaluation {
    /// Standard deviation of the count at a row, counts; `None` unless the mark passed before and after it.
    pub fn count_uncertainty(&self, row: usize) -> Option<f64> {
        if self.accuracy.counts_per_rev == 0.0 {
            return None;
        }
        let is_unshifted = |p: &&PulsePassage| {
            !(self.shifts.iter()).any(|s| is_between(s.rows.1, row as f64, p.row))
        };
        let passages: Vec<&PulsePassage> = self.pulses.iter().filter(is_unshifted).collect();
        let before = passages.iter().filter(|p| p.row < row as f64).count();
        let after = passages.len() - before;
        (before > 0 && after > 0)
            .then(|| self.accuracy.deviation * (1.0 / before as f64 + 1.0 / after as f64).sqrt())
    }

    /// Angle of one encoder count, rad of the shaft with the mark.
    pub fn count_angle(&self) -> f64 {
        TAU / self.accuracy.counts_per_rev
    }

    /// Reverses the counting direction of the shaft.
    pub fn reverse(&mut self) {
        self.mark_angle = (1.0 - self.mark_angle).rem_euclid(1.0);
        self.shifts.iter_mut().for_each(|s| s.counts = -s.counts);
        self.pulses.iter_mut().for_each(|p| p.angle = -p.angle);
    }

    /// Output angle of the mark in one direction, revolutions: input angle times `ratio`, averaged over the passages and counted
    /// from the first.
    pub fn output_angle(&self, ratio: f64, forward: bool) -> Option<f64> {
        let passages = || self.pulses.iter().filter(|p| p.forward == forward);
        let first = passages().next()?.input * ratio / TAU;
        let mean = circular_mean(passages().map(|p| p.input * ratio / TAU));
        let offset = (mean - first + 0.5).rem_euclid(1.0) - 0.5;
        Some(first + offset)
    }

    /// Warnings about the index pulses.
    pub fn warnings(&self) -> Option<Diagnostic> {
        if self.missing + self.extra == 0 {
            return None;
        }
        Some(Diagnostic {
            code: "index-pulses",
            message: format!(
                "of the index of the {} {} pulses are seen, {} are missing, and {} are elsewhere and ignored",
                self.shaft, self.passages, self.missing, self.extra
            ),
            hint: Some(
                "check for pulses narrower than a row (missed) and noise on the line (extra pulses)".into(),
            ),
        })
    }
}

/// Whether a row lies between two others.
fn is_between(row: f64, a: f64, b: f64) -> bool {
    (row > a) != (row > b)
}

/// Circular mean of angles, revolutions from 0 to 1.
fn circular_mean(turns: impl Iterator<Item = f64>) -> f64 {
    let sum: Complex = turns.map(|x| Complex::from_polar(1.0, TAU * x)).sum();
    (sum.im.atan2(sum.re) / TAU).rem_euclid(1.0)
}
