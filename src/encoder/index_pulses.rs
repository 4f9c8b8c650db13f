//! Index pulses: angle of the mark, and counts lost or added between two passages.
//!
//! A mark has two edges, of which one rises where the shaft turns up and the same one falls where it turns back: that one is taken.

use std::f64::consts::TAU;

use super::readings::{EncoderReadings, EncoderScales, for_each_block};
use super::survey::DirectionRun;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::numeric::Complex;

/// A passage of an index signal through the middle of its levels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PulseEdge {
    /// Row, with what has passed of it.
    pub row: f64,
    /// Upward.
    pub rising: bool,
}

/// The index signal of a shaft.
#[derive(Debug, Clone)]
pub struct IndexSignal {
    /// In their order.
    pub edges: Vec<PulseEdge>,
    /// Rows by which an edge may be off.
    pub edge_uncertainty: f64,
    /// Counts the encoder makes of a turn; nothing where it has no steps.
    pub counts: Option<f64>,
}

/// A mark that passed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PulsePassage {
    row: f64,
    /// Angle of its own shaft, rad.
    own: f64,
    /// Angle of the input, rad.
    input: f64,
    forward: bool,
    run: usize,
}

/// Counts that an encoder lost (negative) or had too many, between two rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CountShift {
    /// The mark passed there before and after.
    pub rows: (f64, f64),
    /// Number of counts.
    pub counts: f64,
    /// Their own standard deviation.
    pub deviation: f64,
}

/// Evaluation of a shaft's index pulses.
#[derive(Debug, Clone)]
pub struct IndexEvaluation {
    /// `input` or `output`.
    pub shaft: &'static str,
    /// Passages that are whole turns apart.
    pub passages: usize,
    /// Turns in which no pulse was seen.
    pub missing: usize,
    /// Pulses elsewhere.
    pub extra: usize,
    /// Counts from one to the next on average, where the encoder has counts.
    pub counts_apart: Option<f64>,
    /// Angle of the mark by the readings, in turns from zero to one.
    pub mark_angle: f64,
    /// Standard deviation of its place, turns.
    pub scatter: f64,
    /// Lost or extra counts, in their order.
    pub shifts: Vec<CountShift>,
    counted: CountAccuracy,
    pulses: Vec<PulsePassage>,
}

/// Accuracy of the counts at one passage.
#[derive(Debug, Clone, Copy)]
struct CountAccuracy {
    a_turn: f64,
    deviation: f64,
}

/// Another passage belongs to the same mark when it lies this near to a whole turn.
const SAME_MARK: f64 = 0.05;

/// Counts are lost when the level of the passages steps by so many deviations of it, and by this share of a count.
const SHIFT_THRESHOLD: f64 = 4.5;

/// See [`SHIFT_THRESHOLD`].
const MIN_COUNT_SHARE: f64 = 0.6;

/// Looks at the index signals of both shafts; `paces` are the largest turns of input and output in a row, rad.
///
/// # Errors
/// Readings that cannot be read; `NoSignal`: no mark passes twice; `RatioMismatch`: marks are no turn apart; `LostCounts`: every turn.
pub fn evaluate_indices(
    rows: &dyn EncoderReadings,
    scales: EncoderScales,
    runs: &[DirectionRun],
    signals: [Option<&IndexSignal>; 2],
    paces: [f64; 2],
) -> Result<[Option<IndexEvaluation>; 2], Error> {
    let mut found = passages(rows, scales, runs, signals)?;
    let mut all = [None, None];
    for (k, shaft) in ["input", "output"].into_iter().enumerate() {
        if let Some(signal) = signals[k] {
            all[k] = Some(evaluate_index(
                shaft,
                signal,
                std::mem::take(&mut found[k]),
                paces[k],
            )?);
        }
    }
    Ok(all)
}

/// Both angles at the edges that count.
fn passages(
    rows: &dyn EncoderReadings,
    scales: EncoderScales,
    runs: &[DirectionRun],
    signals: [Option<&IndexSignal>; 2],
) -> Result<[Vec<PulsePassage>; 2], Error> {
    let wanted = |signal: Option<&IndexSignal>| -> Vec<(f64, usize)> {
        let edges = signal.map_or(&[][..], |s| &s.edges);
        let of_run = |e: &PulseEdge| {
            let inside = |run: &DirectionRun| run.rows.contains(&(e.row.max(0.0) as usize));
            let at = runs.iter().position(inside)?;
            (runs[at].forward == e.rising).then_some((e.row, at))
        };
        edges.iter().filter_map(of_run).collect()
    };
    let wanted = signals.map(wanted);
    let mut next = [0, 0];
    let mut found = [Vec::new(), Vec::new()];
    let mut before: Option<(f64, f64)> = None;
    for_each_block(rows, scales, |first, input, output| {
        let at = |row: usize| match row.checked_sub(first) {
            Some(i) => (input[i], output[i]),
            None => before.unwrap_or((input[0], output[0])),
        };
        let end = first + input.len();
        for k in 0..2 {
            while let Some(&(row, run)) = wanted[k].get(next[k]) {
                let whole = row.floor() as usize;
                if whole + 1 >= end {
                    break;
                }
                next[k] += 1;
                if whole + 1 < first {
                    continue;
                }
                let (low, high) = (at(whole), at(whole + 1));
                let part = row - row.floor();
                let angles = (
                    low.0 + part * (high.0 - low.0),
                    low.1 + part * (high.1 - low.1),
                );
                found[k].push(PulsePassage {
                    row,
                    own: if k == 0 { angles.0 } else { angles.1 },
                    input: angles.0,
                    forward: runs[run].forward,
                    run,
                });
            }
        }
        before = input.last().copied().zip(output.last().copied());
    })?;
    Ok(found)
}

/// The index of one shaft.
fn evaluate_index(
    shaft: &'static str,
    signal: &IndexSignal,
    found: Vec<PulsePassage>,
    pace: f64,
) -> Result<IndexEvaluation, Error> {
    let a_turn = signal.counts.unwrap_or(0.0);
    let apart: Vec<f64> = (found.windows(2))
        .filter(|w| w[0].run == w[1].run)
        .map(|w| ((w[1].own - w[0].own) / TAU).abs())
        .collect();
    check_apart(shaft, &apart, a_turn)?;
    // An edge lies anywhere within its sharpness, a reading anywhere within its count.
    let off = signal.edge_uncertainty * pace / TAU * a_turn + 0.5;
    let deviation = off / 3f64.sqrt();
    let all = found.len();
    let found = whole_turn_passages(found);
    let mut missing = 0;
    let (mut whole, mut level) = (0.0, Vec::with_capacity(found.len()));
    for (k, passage) in found.iter().enumerate() {
        if k > 0 {
            let turns = (passage.own - found[k - 1].own) / TAU;
            whole += turns.round();
            if passage.run == found[k - 1].run {
                missing += (turns.abs().round() as usize).saturating_sub(1);
            }
        }
        level.push((passage.own - found[0].own) / TAU - whole);
    }
    let counts: Vec<f64> = level.iter().map(|x| x * a_turn).collect();
    check_systematic_loss(shaft, &found, &counts, a_turn, deviation)?;
    let counted = CountAccuracy { a_turn, deviation };
    let shifts = shifts(&found, &counts, counted);
    let mean = level.iter().sum::<f64>() / level.len() as f64;
    let square: f64 = level.iter().map(|x| (x - mean).powi(2)).sum();
    let near: Vec<f64> = apart
        .iter()
        .copied()
        .filter(|x| (x - 1.0).abs() < SAME_MARK)
        .collect();
    Ok(IndexEvaluation {
        shaft,
        passages: found.len(),
        missing,
        extra: all - found.len(),
        counts_apart: (a_turn > 0.0 && !near.is_empty())
            .then(|| a_turn * near.iter().sum::<f64>() / near.len() as f64),
        mark_angle: circular_mean(found.iter().map(|p| p.own / TAU)),
        scatter: (square / level.len() as f64).sqrt(),
        shifts,
        counted,
        pulses: found,
    })
}

/// Refuses marks that do not come once a turn.
fn check_apart(shaft: &str, apart: &[f64], a_turn: f64) -> Result<(), Error> {
    if apart.is_empty() {
        let message = format!("the index of the {shaft} does not pass twice in one direction");
        return Err(Error::new(Code::NoSignal, message).with_hint(
            "take a longer segment, check whether this is its channel, or leave the index out",
        ));
    }
    let mut sorted = apart.to_vec();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted[sorted.len() / 2];
    let most = sorted
        .iter()
        .filter(|x| (*x - usual).abs() < SAME_MARK)
        .count();
    if (usual - 1.0).abs() < SAME_MARK || 2 * most <= apart.len() {
        return Ok(());
    }
    let shown = match a_turn > 0.0 {
        true => format!(
            "{:.0} counts apart, and a turn has {a_turn:.0}",
            usual * a_turn
        ),
        false => format!("{usual:.4} turns apart"),
    };
    let message = format!("the index pulses of the {shaft} are {shown}");
    Err(Error::new(Code::RatioMismatch, message).with_hint(
        "check --lines and --counts-per-line; a pulse narrower than a row is missed: read more often, or widen it",
    ))
}

/// The passages that are whole turns apart: the largest company of followers counts.
fn whole_turn_passages(found: Vec<PulsePassage>) -> Vec<PulsePassage> {
    let fraction = |p: &PulsePassage| (p.own / TAU).rem_euclid(1.0);
    let far = |a: f64, b: f64| {
        let d = (a - b).rem_euclid(1.0);
        d.min(1.0 - d)
    };
    const MAX_STARTS: usize = 32;
    let company = |start: usize| {
        let mut level = fraction(&found[start]);
        let mut list = Vec::new();
        for (k, passage) in found.iter().enumerate().skip(start) {
            let here = fraction(passage);
            if far(here, level) < SAME_MARK {
                level = here;
                list.push(k);
            }
        }
        list
    };
    let best = (0..found.len().min(MAX_STARTS))
        .map(company)
        .max_by_key(Vec::len);
    let keep = best.unwrap_or_default();
    keep.into_iter().map(|k| found[k]).collect()
}

/// Refuses an encoder that loses the same every turn: no step shows where.
fn check_systematic_loss(
    shaft: &str,
    found: &[PulsePassage],
    counts: &[f64],
    a_turn: f64,
    deviation: f64,
) -> Result<(), Error> {
    let pairs = found.windows(2).zip(counts.windows(2));
    let mut each: Vec<f64> = pairs
        .filter(|(p, _)| p[0].run == p[1].run)
        .map(|(p, c)| (c[1] - c[0]) * (p[1].own - p[0].own).signum())
        .collect();
    const MIN_PASSAGES: usize = 3;
    if a_turn == 0.0 || each.len() < MIN_PASSAGES {
        return Ok(());
    }
    each.sort_by(f64::total_cmp);
    let usual = each[each.len() / 2];
    // The median of n scatters by 1.25 deviations over the root of n; either end of a turn scatters.
    let scatter = 1.25 * deviation * (2.0 / each.len() as f64).sqrt();
    if usual.abs() < MIN_COUNT_SHARE.max(SHIFT_THRESHOLD * scatter) {
        return Ok(());
    }
    let message = format!(
        "the {shaft} counts {:.1} from one index pulse to the next, turn by turn, where {a_turn:.0} are stated",
        a_turn + usual
    );
    Err(Error::new(Code::LostCounts, message)
        .with_hint("check --lines; else lines of its disc are dirty, or it is turned too fast"))
}

/// Steps of the level of the passages: the strongest split, and again on either side of it.
fn shifts(found: &[PulsePassage], counts: &[f64], counted: CountAccuracy) -> Vec<CountShift> {
    if counted.a_turn == 0.0 {
        return Vec::new();
    }
    let mean = |a: usize, b: usize| counts[a..b].iter().sum::<f64>() / (b - a) as f64;
    let spread = |a: usize, k: usize, b: usize| {
        counted.deviation * (1.0 / (k - a) as f64 + 1.0 / (b - k) as f64).sqrt()
    };
    let mut splits = Vec::new();
    let mut open = vec![(0, counts.len())];
    while let Some((a, b)) = open.pop() {
        let out = |k: usize| (mean(k, b) - mean(a, k)).abs() / spread(a, k, b);
        let best = (a + 1..b).max_by(|&j, &k| out(j).total_cmp(&out(k)));
        if let Some(k) = best
            && out(k) > SHIFT_THRESHOLD
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
    let all = edges.windows(3).map(|e| CountShift {
        rows: (found[e[1] - 1].row, found[e[1]].row),
        counts: (mean(e[1], e[2]) - mean(e[0], e[1])).round(),
        deviation: spread(e[0], e[1], e[2]),
    });
    all.filter(|s| s.counts != 0.0).collect()
}

impl IndexEvaluation {
    /// Uncertainty of the count at a row, counts; absent where no mark passed before or after it.
    pub fn count_uncertainty(&self, row: usize) -> Option<f64> {
        if self.counted.a_turn == 0.0 {
            return None;
        }
        let inside = |p: &&PulsePassage| {
            let same = |r: f64| {
                !self
                    .shifts
                    .iter()
                    .any(|s| edge_between(s.rows.1, row as f64, r))
            };
            same(p.row)
        };
        let near: Vec<&PulsePassage> = self.pulses.iter().filter(inside).collect();
        let before = near.iter().filter(|p| p.row < row as f64).count();
        let after = near.len() - before;
        (before > 0 && after > 0)
            .then(|| self.counted.deviation * (1.0 / before as f64 + 1.0 / after as f64).sqrt())
    }

    /// Angle of one encoder count, rad of its own shaft.
    pub fn count_angle(&self) -> f64 {
        TAU / self.counted.a_turn
    }

    /// Reverses the counting direction of the readings from here on.
    pub fn reverse(&mut self) {
        self.mark_angle = (1.0 - self.mark_angle).rem_euclid(1.0);
        self.shifts.iter_mut().for_each(|s| s.counts = -s.counts);
        self.pulses.iter_mut().for_each(|p| p.own = -p.own);
    }

    /// Angle of the output, turns, as `ratio` makes it of the input, at which the mark first passed in a direction: the mean over its
    /// passages.
    pub fn output_angle(&self, ratio: f64, forward: bool) -> Option<f64> {
        let passed = || self.pulses.iter().filter(|p| p.forward == forward);
        let first = passed().next()?.input * ratio / TAU;
        let mean = circular_mean(passed().map(|p| p.input * ratio / TAU));
        let off = (mean - first + 0.5).rem_euclid(1.0) - 0.5;
        Some(first + off)
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
                "pulses narrower than a row are missed; others come from noise on the line".into(),
            ),
        })
    }
}

/// Whether a threshold lies between two rows.
fn edge_between(border: f64, a: f64, b: f64) -> bool {
    (border > a) != (border > b)
}

/// The mean of places on a circle, in turns from zero to one.
fn circular_mean(turns: impl Iterator<Item = f64>) -> f64 {
    let sum: Complex = turns.map(|x| Complex::from_polar(1.0, TAU * x)).sum();
    (sum.im.atan2(sum.re) / TAU).rem_euclid(1.0)
}
