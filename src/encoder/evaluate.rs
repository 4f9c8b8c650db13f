//! Evaluation of an encoder record: checks, resampling for each flank, backlash, speed.

use std::f64::consts::TAU;

use super::angle_origin::AngleOrigin;
use super::backlash::{self, AngularBacklash};
use super::count_check::CountCheck;
use super::count_steps::{CountStep, StepSearch, find_steps, locate_rows};
use super::flank::{FlankEvaluation, FlankOptions, evaluate_flank};
use super::gear_train::{GearTrain, OrderSource};
use super::index_pulses::{IndexEvaluation, IndexSignal, evaluate_indices};
use super::orders::KnownOrders;
use super::readings::{EncoderReadings, EncoderScales, for_each_block};
use super::resampling::{
    AngularResampler, CELLS_PER_ORDER, EDGE_CELLS, MIN_PER_CELL, RESAMPLING_ERROR,
};
use super::speed::{PitchTimer, SpeedTrace};
use super::survey::{DirectionRun, MeasuredRatio, survey};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::numeric::fraction::Fraction;
use crate::spectrum::rotation::angular_resampling::AngularSignal;

/// Options of the evaluation of a record.
#[derive(Debug, Clone)]
pub struct EvaluationOptions {
    /// Teeth between the shafts.
    pub teeth: GearTrain,
    /// Scales of the encoder readings.
    pub scales: EncoderScales,
    /// Row rate, Hz; `None` for rows without a uniform time base.
    pub rate_hz: Option<f64>,
    /// Number of mesh harmonics; by default as many as the row spacing allows, up to [`DEFAULT_MULTIPLES`].
    pub multiples: Option<usize>,
    /// Removes steps of lost or extra counts.
    pub repair: bool,
    /// Orders known from a model.
    pub known_orders: KnownOrders,
    /// Fits every multiple of the shafts, not only the significant ones.
    pub all_multiples: bool,
    /// Also evaluates the deviation of the input from uniform rotation; needs `rate_hz`.
    pub input: bool,
    /// Index signals of input and output, if recorded.
    pub index: [Option<IndexSignal>; 2],
}

/// Default number of mesh multiples evaluated.
pub const DEFAULT_MULTIPLES: usize = 4;

/// Maximum number of evaluations after removal of steps.
const MAX_REPAIRS: usize = 4;

/// Ratio of the highest order to the highest mesh harmonic: room for sidebands.
const SIDEBAND_MARGIN: f64 = 1.05;

/// Transmission error and encoder findings of a record.
#[derive(Debug)]
pub struct TeEvaluation {
    /// Transmission ratio by tooth numbers: output revolutions per input revolution.
    pub tooth_ratio: Fraction,
    /// Transmission ratio measured by the encoders.
    pub ratio: MeasuredRatio,
    /// One or two flanks, the one with more output revolutions first.
    pub flanks: Vec<FlankEvaluation>,
    /// Direction runs of the input.
    pub runs: Vec<DirectionRun>,
    /// Number of rows at rest at the beginning and at the end, excluded.
    pub rest_rows: [usize; 2],
    /// Angular backlash of the output between the flanks.
    pub backlash: Option<AngularBacklash>,
    /// Removed steps of lost or extra counts.
    pub removed_steps: Vec<CountStep>,
    /// Index-pulse evaluations of input and output.
    pub index: [Option<IndexEvaluation>; 2],
    /// Number of mesh harmonics evaluated.
    pub multiples: usize,
    /// Highest order evaluated, per output revolution.
    pub band: f64,
    /// Relative amplitude error of the highest order by resampling and by quantisation of the input.
    pub order_error: f64,
    /// Quantisation noise of both encoders, rms, rad of the output.
    pub quantisation: f64,
    /// Rows per tooth pitch of the output.
    pub rows_per_tooth: f64,
    /// Speed over the record.
    pub speed: Option<SpeedTrace>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Evaluates the transmission error of an encoder record.
///
/// # Errors
/// Readings that are no numbers, a shaft at rest, a ratio other than the tooth ratio, slip, lost counts (without `repair`), too few
/// rows per tooth, less than one revolution, orders above the band of the rows.
pub fn evaluate(
    rows: &dyn EncoderReadings,
    options: &EvaluationOptions,
) -> Result<TeEvaluation, Error> {
    let mut scales = options.scales;
    let overview = survey(rows, scales)?;
    let ratio = overview.ratio((scales.input.step, scales.output.step))?;
    let mut index = match options.index.iter().flatten().next() {
        None => [None, None],
        Some(_) => {
            let signals = [options.index[0].as_ref(), options.index[1].as_ref()];
            let max_increments = [
                overview.max_increment,
                overview.max_increment * ratio.value.abs(),
            ];
            evaluate_indices(rows, scales, &overview.runs, signals, max_increments)?
        }
    };
    overview.check_ratio(&options.teeth, ratio, options.rate_hz)?;
    // Both shafts count in the same direction from this line on.
    scales.output.unit *= ratio.value.signum();
    if let Some(output) = index[1].as_mut().filter(|_| ratio.value < 0.0) {
        output.reverse();
    }
    let declared = options.teeth.ratio();
    let r = declared.to_f64();
    let overview = match ratio.value < 0.0 {
        true => survey(rows, scales)?,
        false => overview,
    };
    let rev_per_row = overview.max_increment * r / TAU; // output revolutions per row
    let output_teeth = options.teeth.output_teeth() as f64;
    let rows_per_tooth = 1.0 / (rev_per_row * output_teeth);
    let (multiples, per_turn) = resolution(options, rev_per_row)?;
    let mut diagnostics = Vec::new();
    let band = per_turn as f64 / CELLS_PER_ORDER as f64;
    warn_above_band(options, band, &mut diagnostics);
    let runs = overview.after_take_up(r, TAU / output_teeth / r);
    let request = StepSearch {
        survey: &overview,
        ratio: r,
        rows_per_tooth,
    };
    let mut count_check = CountCheck::new([index[0].as_ref(), index[1].as_ref()], r);
    let mut removed = count_check.confirm_steps(find_steps(rows, scales, &runs, request)?);
    removed.extend(count_check.undetected_shifts(rows, scales, rows_per_tooth.ceil() as usize)?);
    removed.sort_by_key(|jump| jump.row);
    let marks = AngleOrigin::new(&index, &runs, r);
    let steps = (scales.input.step * r, scales.output.step);
    let count_sizes = [steps.0, steps.1].into_iter().filter(|c| *c > 0.0);
    // Quantisation of the input angle, half a step, attenuates high orders.
    let step_orders = band * steps.0 / TAU;
    let error = RESAMPLING_ERROR + (0.5 * TAU * step_orders).powi(2) / 6.0;
    let search = FlankOptions {
        teeth: &options.teeth,
        multiples,
        band,
        known_orders: &options.known_orders,
        all_multiples: options.all_multiples,
        error,
        input_mark: marks.input.unwrap_or(0.0),
        count_step: count_sizes.fold(f64::INFINITY, f64::min),
    };
    let min_cells = turns_needed(options) * per_turn as f64;
    let mut round = 0;
    let (mut flanks, speed, offset) = loop {
        if !removed.is_empty() && !options.repair {
            return Err(lost_counts_error(&removed, options.rate_hz));
        }
        let (mut signals, speed) = resample_directions(
            rows,
            scales,
            &runs,
            &removed,
            options,
            per_turn,
            marks.output_origin,
        )?;
        signals.sort_by_key(|s| std::cmp::Reverse(s.order_error.values.len()));
        check_turns(options, &signals, per_turn)?;
        let signal_of = |forward| signals.iter().find(|s| s.forward == forward);
        let offset = (signal_of(true).zip(signal_of(false)))
            .and_then(|(up, down)| backlash::mean_backlash(&up.order_error, &down.order_error));
        let flanks = signals
            .into_iter()
            .filter(|s| s.order_error.values.len() as f64 >= min_cells)
            .map(|s| evaluate_flank(s.order_error, s.input.as_ref(), s.forward, &search))
            .collect::<Result<Vec<FlankEvaluation>, Error>>()?;
        let mut new_steps = Vec::new();
        for flank in &flanks {
            let located = flank.steps.iter();
            let located: Vec<(f64, f64)> = located
                .map(|s| {
                    (
                        (flank.signal.angle(s.cell) + marks.output_origin * TAU) / r,
                        s.size,
                    )
                })
                .collect();
            let flank_runs: Vec<DirectionRun> = runs
                .iter()
                .filter(|run| run.forward == flank.forward)
                .cloned()
                .collect();
            new_steps.extend(locate_rows(&located, rows, scales, &flank_runs, request)?);
        }
        let new_steps = count_check.confirm_steps(new_steps);
        if new_steps.is_empty() {
            warn_too_short(
                &overview.runs,
                &flanks,
                turns_needed(options),
                r,
                &mut diagnostics,
            );
            break (flanks, speed, offset);
        }
        removed.extend(new_steps);
        removed.sort_by_key(|jump| jump.row);
        round += 1;
        if round > MAX_REPAIRS {
            return Err(lost_counts_error(&removed, options.rate_hz).with_hint(
                "steps stay in the record however many are taken out: check the encoders and their cables",
            ));
        }
    };
    let backlash = offset.map(|(mean, first, count)| AngularBacklash {
        mean,
        variation: backlash::backlash_variation(&flanks, first, count),
    });
    flanks
        .iter_mut()
        .for_each(|f| marks.set_mark_phases(f, &options.teeth));
    diagnostics.extend(count_check.warnings());
    diagnostics.extend(index.iter().flatten().filter_map(IndexEvaluation::warnings));
    Ok(TeEvaluation {
        index,
        tooth_ratio: declared,
        ratio,
        flanks,
        runs,
        rest_rows: overview.rest_rows,
        backlash,
        removed_steps: removed,
        multiples,
        band,
        order_error: error,
        quantisation: (steps.0.powi(2) + steps.1.powi(2)).sqrt() / 12f64.sqrt(),
        rows_per_tooth,
        speed,
        diagnostics,
    })
}

/// Warns of a direction with too little rotation for an evaluation.
fn warn_too_short(
    runs: &[DirectionRun],
    flanks: &[FlankEvaluation],
    needed: f64,
    ratio: f64,
    diagnostics: &mut Vec<Diagnostic>,
) {
    for (forward, direction) in [(true, "forward"), (false, "backward")] {
        let travels = runs.iter().filter(|run| run.forward == forward);
        let turns = travels.map(DirectionRun::travel).fold(0.0, f64::max) * ratio / TAU;
        if turns > 0.0 && !flanks.iter().any(|f| f.forward == forward) {
            diagnostics.push(Diagnostic {
                code: "direction-too-short",
                message: format!(
                    "{direction} the record turns {turns:.3} turns of the output, where {needed:.3} and what the play takes are needed: that direction is not evaluated"
                ),
                hint: Some("record a whole turn of every shaft in each direction".into()),
            });
        }
    }
}

/// Number of mesh harmonics, and cells per output revolution.
fn resolution(options: &EvaluationOptions, rev_per_row: f64) -> Result<(usize, usize), Error> {
    let max_cells = 1.0 / (MIN_PER_CELL * rev_per_row); // cells per revolution
    let cells = |order: f64| (CELLS_PER_ORDER as f64 * SIDEBAND_MARGIN * order).ceil();
    let meshes = options.teeth.meshes();
    let orders = || meshes.iter().map(|m| m.order.to_f64());
    let lowest = orders().fold(f64::INFINITY, f64::min);
    // Meshes above the band of the rows are excluded, except for the lowest.
    let in_band = |m: &&OrderSource| cells(m.order.to_f64()) <= max_cells;
    let fastest = meshes
        .iter()
        .filter(in_band)
        .max_by(|a, b| a.order.cmp(&b.order));
    let highest = fastest.map_or(lowest, |m| m.order.to_f64());
    if cells(lowest) > max_cells {
        let per_tooth = 1.0 / (rev_per_row * lowest);
        let message = format!(
            "{per_tooth:.2} rows a tooth do not show what teeth do: at least {:.1} are needed",
            MIN_PER_CELL * CELLS_PER_ORDER as f64 * SIDEBAND_MARGIN
        );
        return Err(Error::new(Code::TooShort, message)
            .with_hint("read the encoders more often, or turn more slowly"));
    }
    let possible = (1..)
        .take_while(|&k| cells(k as f64 * highest) <= max_cells)
        .take(1000);
    let possible = possible.last().unwrap_or(0);
    if let Some(requested) = options.multiples
        && requested > possible
    {
        let message = format!(
            "order {} (multiple {requested} of {}) exceeds {:.1}, the highest order of these rows",
            requested as f64 * highest,
            fastest.map_or("", |m| m.name.as_str()),
            max_cells / CELLS_PER_ORDER as f64
        );
        let hint = match possible {
            0 => "read the encoders more often, or turn more slowly".to_string(),
            n => format!("pass --harmonics {n} at most"),
        };
        return Err(Error::new(Code::OutOfRange, message).with_hint(hint));
    }
    let multiples = options
        .multiples
        .unwrap_or(DEFAULT_MULTIPLES.min(possible.max(1)));
    let highest_known = options
        .known_orders
        .declared
        .iter()
        .map(|n| n.0.to_f64())
        .fold(0.0, f64::max);
    let required = cells(multiples as f64 * highest)
        .max(cells(highest_known))
        .min(max_cells);
    // An integer number of cells per output pitch, within the limit of the rows.
    let pitch = options.teeth.output_teeth() as f64;
    let per_pitch = (required / pitch).ceil();
    let per_pitch = if per_pitch * pitch > max_cells {
        (max_cells / pitch).floor()
    } else {
        per_pitch
    };
    Ok((multiples, (per_pitch.max(1.0) * pitch) as usize))
}

/// Warns of meshes above the band.
fn warn_above_band(options: &EvaluationOptions, band: f64, diagnostics: &mut Vec<Diagnostic>) {
    let above: Vec<OrderSource> = options.teeth.meshes();
    let above: Vec<String> = above
        .into_iter()
        .filter(|m| m.order.to_f64() > band)
        .map(|m| format!("{} (order {})", m.name, m.order))
        .collect();
    if !above.is_empty() {
        diagnostics.push(Diagnostic {
            code: "mesh-above-band",
            message: format!(
                "{} above the highest order of these rows, {band:.1}: not evaluated",
                match &above[..] {
                    [name] => format!("{name} lies"),
                    names => format!("{} lie", names.join(", ")),
                }
            ),
            hint: Some("read the encoders more often, or turn more slowly".into()),
        });
    }
}

fn lost_counts_error(steps: &[CountStep], rate_hz: Option<f64>) -> Error {
    const SHOWN: usize = 4;
    let located_step = |j: &CountStep| {
        let position = match rate_hz {
            Some(rate) => format!("{:.4} s", j.row as f64 / rate),
            None => format!("row {}", j.row + 1),
        };
        format!("{} at {position}", j.describe())
    };
    let mut list: Vec<String> = steps.iter().take(SHOWN).map(located_step).collect();
    if steps.len() > SHOWN {
        list.push(format!("and {} more", steps.len() - SHOWN));
    }
    Error::new(Code::LostCounts, list.join(", ")).with_hint(
        "have the steps taken out with --repair, or take a segment without them: --after, --before",
    )
}

/// Transmission error of one direction over equal angle cells, rad of the output.
struct DirectionSignal {
    forward: bool,
    order_error: AngularSignal,
    /// Deviation of the input from uniform rotation, rad of the output.
    input: Option<AngularSignal>,
}

/// Transmission error of both directions over equal angle cells, and the speed; `zero`: origin of the output angle, revolutions.
fn resample_directions(
    rows: &dyn EncoderReadings,
    scales: EncoderScales,
    runs: &[DirectionRun],
    lost: &[CountStep],
    options: &EvaluationOptions,
    per_turn: usize,
    zero: f64,
) -> Result<(Vec<DirectionSignal>, Option<SpeedTrace>), Error> {
    let r = options.teeth.ratio().to_f64();
    let unit = r / TAU;
    let turns = |x: f64| x * unit - zero;
    let range = |forward: bool| {
        let ends = runs.iter().filter(|run| run.forward == forward);
        ends.flat_map(|run| [run.input.0, run.input.1])
            .map(turns)
            .fold(None, |m: Option<(f64, f64)>, x| {
                Some(m.map_or((x, x), |(a, b)| (a.min(x), b.max(x))))
            })
    };
    // Rows beyond the ends of the run are quantisation noise only.
    let resampler = |forward: bool, enabled: bool| {
        let ends = range(forward).filter(|_| enabled);
        ends.map(|(a, b)| AngularResampler::new(per_turn, a, b))
            .transpose()
    };
    let (mut fwd, mut bwd) = (resampler(true, true)?, resampler(false, true)?);
    let enabled = options.input && options.rate_hz.is_some();
    let (mut fwd_input, mut bwd_input) = (resampler(true, enabled)?, resampler(false, enabled)?);
    let mut timer = options
        .rate_hz
        .map(|rate| PitchTimer::new(rate, options.teeth.output_teeth()));
    let (mut positions, mut values) = (Vec::new(), Vec::new());
    for_each_block(rows, scales, |first, input, output| {
        let end = first + input.len();
        for run in runs {
            let (low, high) = (run.rows.start.max(first), run.rows.end.min(end));
            if low >= high {
                continue;
            }
            let (a, b) = (
                &input[low - first..high - first],
                &output[low - first..high - first],
            );
            positions.clear();
            positions.extend(a.iter().map(|x| turns(*x)));
            values.clear();
            values.extend(a.iter().zip(b).map(|(a, b)| b - r * a));
            remove_steps(&mut values, low, lost);
            let (cells, input_cells) = match run.forward {
                true => (&mut fwd, &mut fwd_input),
                false => (&mut bwd, &mut bwd_input),
            };
            if let Some(cells) = cells {
                cells.push(&positions, &values);
            }
            if let Some(input_cells) = input_cells {
                // Uniform rotation from the start of the run at its mean speed.
                let increment = (run.input.1 - run.input.0) / (run.rows.len() - 1) as f64;
                let uniform = |row: usize| run.input.0 + increment * (row - run.rows.start) as f64;
                values.clear();
                values.extend((low..).zip(a).map(|(row, x)| r * (x - uniform(row))));
                input_cells.push(&positions, &values);
            }
            if let Some(timer) = &mut timer {
                timer.push(low, &positions);
            }
        }
    })?;
    let mut signals = Vec::new();
    for (forward, cells, input_cells) in [(true, fwd, fwd_input), (false, bwd, bwd_input)] {
        match cells.map(AngularResampler::finish) {
            Some(Ok(error)) => signals.push(DirectionSignal {
                forward,
                order_error: error,
                input: input_cells.map(AngularResampler::finish).transpose()?,
            }),
            // A direction below the minimum length is no flank.
            Some(Err(e)) if e.code != Code::TooShort => return Err(e),
            _ => {}
        }
    }
    Ok((signals, timer.and_then(PitchTimer::finish)))
}

/// Subtracts the steps before and within these rows.
fn remove_steps(values: &mut [f64], first: usize, lost: &[CountStep]) {
    for step in lost {
        let start = step.row.saturating_sub(first).min(values.len());
        values[start..].iter_mut().for_each(|e| *e -= step.step);
    }
}

/// Output revolutions in which every shaft makes one revolution.
fn turns_needed(options: &EvaluationOptions) -> f64 {
    let shafts = options.teeth.shafts();
    shafts
        .iter()
        .map(|s| 1.0 / s.order.to_f64())
        .fold(1.0, f64::max)
}

fn check_turns(
    options: &EvaluationOptions,
    signals: &[DirectionSignal],
    per_turn: usize,
) -> Result<(), Error> {
    let needed = turns_needed(options);
    let recorded = signals
        .first()
        .map_or(0.0, |s| s.order_error.values.len() as f64 / per_turn as f64);
    if recorded >= needed {
        return Ok(());
    }
    let message = format!(
        "the record covers {recorded:.3} turns of the output in one direction; {needed:.3} are needed for one turn of every shaft"
    );
    Err(Error::new(Code::TooShort, message).with_hint(format!(
        "record one turn of the slowest shaft plus {:.3} turns of the output, in one direction without a gap",
        2.0 * EDGE_CELLS as f64 / per_turn as f64
    )))
}
