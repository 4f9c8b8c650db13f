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
    /// Rows a second, Hz, where the rows are even in time.
    pub rate_hz: Option<f64>,
    /// Multiples of the meshes; as many as the rows allow, up to [`DEFAULT_MULTIPLES`] by default.
    pub multiples: Option<usize>,
    /// Steps of lost counts are taken out.
    pub repair: bool,
    /// Orders that a model names.
    pub known_orders: KnownOrders,
    /// Fits every multiple of the shafts, not only the significant ones.
    pub all_multiples: bool,
    /// Evaluates the input's deviation from uniform rotation as well, where rows have a clock.
    pub input: bool,
    /// Index pulses of input and output, where they were read.
    pub index: [Option<IndexSignal>; 2],
}

/// Default number of mesh multiples evaluated.
pub const DEFAULT_MULTIPLES: usize = 4;

/// So often the record is looked at again after steps were taken out.
const MAX_REPAIRS: usize = 4;

/// Room above the highest mesh multiple for its sidebands, relative.
const SIDEBAND_MARGIN: f64 = 1.05;

/// Transmission error and encoder findings of a record.
#[derive(Debug)]
pub struct TeEvaluation {
    /// Turns of the output for one of the input, by tooth numbers.
    pub tooth_ratio: Fraction,
    /// As the encoders have it.
    pub ratio: MeasuredRatio,
    /// One or two flanks, the one with more turns first.
    pub flanks: Vec<FlankEvaluation>,
    /// Runs in which the input turned one way.
    pub runs: Vec<DirectionRun>,
    /// Rows at either end in which the input stood still, left out.
    pub still: [usize; 2],
    /// Free angle of the output between the flanks.
    pub backlash: Option<AngularBacklash>,
    /// Steps that were taken out.
    pub removed_steps: Vec<CountStep>,
    /// Index-pulse evaluations of input and output.
    pub index: [Option<IndexEvaluation>; 2],
    /// Multiples of the meshes looked for.
    pub multiples: usize,
    /// The highest order kept.
    pub band: f64,
    /// Relative error of the highest order from the cells and the steps of the input.
    pub order_error: f64,
    /// Noise of the encoders' steps at one row, rms, rad of the output.
    pub quantisation: f64,
    /// Rows that a tooth of the output passes in.
    pub rows_per_tooth: f64,
    /// Speed over the record.
    pub speed: Option<SpeedTrace>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Evaluates a record.
///
/// # Errors
/// Readings that are no numbers, nothing that turns, another ratio than the teeth make, slip, lost counts (unless they are to be taken
/// out), too few rows a tooth, less than one turn, orders above what the rows hold.
pub fn evaluate(
    rows: &dyn EncoderReadings,
    options: &EvaluationOptions,
) -> Result<TeEvaluation, Error> {
    let mut scales = options.scales;
    let looked = survey(rows, scales)?;
    let ratio = looked.ratio((scales.input.step, scales.output.step))?;
    let mut index = match options.index.iter().flatten().next() {
        None => [None, None],
        Some(_) => {
            let signals = [options.index[0].as_ref(), options.index[1].as_ref()];
            let paces = [
                looked.max_increment,
                looked.max_increment * ratio.value.abs(),
            ];
            evaluate_indices(rows, scales, &looked.runs, signals, paces)?
        }
    };
    looked.check_ratio(&options.teeth, ratio, options.rate_hz)?;
    // From here on both count up together.
    scales.output.unit *= ratio.value.signum();
    if let Some(output) = index[1].as_mut().filter(|_| ratio.value < 0.0) {
        output.reverse();
    }
    let declared = options.teeth.ratio();
    let r = declared.to_f64();
    let looked = match ratio.value < 0.0 {
        true => survey(rows, scales)?,
        false => looked,
    };
    let pace = looked.max_increment * r / TAU; // turns of the output in a row
    let last = options.teeth.output_teeth() as f64;
    let rows_per_tooth = 1.0 / (pace * last);
    let (multiples, per_turn) = resolution(options, pace)?;
    let mut diagnostics = Vec::new();
    let band = per_turn as f64 / CELLS_PER_ORDER as f64;
    warn_above_band(options, band, &mut diagnostics);
    let runs = looked.after_take_up(r, TAU / last / r);
    let request = StepSearch {
        survey: &looked,
        ratio: r,
        rows_per_tooth,
    };
    let mut decision = CountCheck::new([index[0].as_ref(), index[1].as_ref()], r);
    let mut found = decision.confirm_steps(find_steps(rows, scales, &runs, request)?);
    found.extend(decision.undetected_shifts(rows, scales, rows_per_tooth.ceil() as usize)?);
    found.sort_by_key(|jump| jump.row);
    let marks = AngleOrigin::new(&index, &runs, r);
    let steps = (scales.input.step * r, scales.output.step);
    let given = [steps.0, steps.1].into_iter().filter(|c| *c > 0.0);
    // Angles of the input are known to half a step, which rounds off high orders.
    let blunt = band * steps.0 / TAU;
    let error = RESAMPLING_ERROR + (0.5 * TAU * blunt).powi(2) / 6.0;
    let search = FlankOptions {
        teeth: &options.teeth,
        multiples,
        band,
        known_orders: &options.known_orders,
        all_multiples: options.all_multiples,
        error,
        input_mark: marks.input.unwrap_or(0.0),
        count_step: given.fold(f64::INFINITY, f64::min),
    };
    let least = turns_needed(options) * per_turn as f64;
    let mut round = 0;
    let (mut flanks, speed, apart) = loop {
        if !found.is_empty() && !options.repair {
            return Err(lost_counts_error(&found, options.rate_hz));
        }
        let (mut signals, speed) = resample_directions(
            rows,
            scales,
            &runs,
            &found,
            options,
            per_turn,
            marks.output_origin,
        )?;
        signals.sort_by_key(|s| std::cmp::Reverse(s.order_error.values.len()));
        check_turns(options, &signals, per_turn)?;
        let of = |forward| signals.iter().find(|s| s.forward == forward);
        let apart = (of(true).zip(of(false)))
            .and_then(|(up, down)| backlash::mean_backlash(&up.order_error, &down.order_error));
        let flanks = signals
            .into_iter()
            .filter(|s| s.order_error.values.len() as f64 >= least)
            .map(|s| evaluate_flank(s.order_error, s.input.as_ref(), s.forward, &search))
            .collect::<Result<Vec<FlankEvaluation>, Error>>()?;
        let mut more = Vec::new();
        for flank in &flanks {
            let places = flank.steps.iter();
            let places: Vec<(f64, f64)> = places
                .map(|s| {
                    (
                        (flank.signal.angle(s.cell) + marks.output_origin * TAU) / r,
                        s.size,
                    )
                })
                .collect();
            let of_way: Vec<DirectionRun> = runs
                .iter()
                .filter(|run| run.forward == flank.forward)
                .cloned()
                .collect();
            more.extend(locate_rows(&places, rows, scales, &of_way, request)?);
        }
        let more = decision.confirm_steps(more);
        if more.is_empty() {
            warn_too_short(
                &looked.runs,
                &flanks,
                turns_needed(options),
                r,
                &mut diagnostics,
            );
            break (flanks, speed, apart);
        }
        found.extend(more);
        found.sort_by_key(|jump| jump.row);
        round += 1;
        if round > MAX_REPAIRS {
            return Err(lost_counts_error(&found, options.rate_hz).with_hint(
                "steps stay in the record however many are taken out: check the encoders and their cables",
            ));
        }
    };
    let play = apart.map(|(mean, first, count)| AngularBacklash {
        mean,
        variation: backlash::backlash_variation(&flanks, first, count),
    });
    flanks
        .iter_mut()
        .for_each(|f| marks.set_mark_phases(f, &options.teeth));
    diagnostics.extend(decision.warnings());
    diagnostics.extend(index.iter().flatten().filter_map(IndexEvaluation::warnings));
    Ok(TeEvaluation {
        index,
        tooth_ratio: declared,
        ratio,
        flanks,
        runs,
        still: looked.still,
        backlash: play,
        removed_steps: found,
        multiples,
        band,
        order_error: error,
        quantisation: (steps.0.powi(2) + steps.1.powi(2)).sqrt() / 12f64.sqrt(),
        rows_per_tooth,
        speed,
        diagnostics,
    })
}

/// Says which direction turns too little to be evaluated.
fn warn_too_short(
    runs: &[DirectionRun],
    flanks: &[FlankEvaluation],
    needed: f64,
    ratio: f64,
    to: &mut Vec<Diagnostic>,
) {
    for (forward, way) in [(true, "forward"), (false, "backward")] {
        let reach = runs.iter().filter(|run| run.forward == forward);
        let turns = reach.map(DirectionRun::travel).fold(0.0, f64::max) * ratio / TAU;
        if turns > 0.0 && !flanks.iter().any(|f| f.forward == forward) {
            to.push(Diagnostic {
                code: "direction-too-short",
                message: format!(
                    "{way} the record turns {turns:.3} turns of the output, where {needed:.3} and what the play takes are needed: that direction is not evaluated"
                ),
                hint: Some("record a whole turn of every shaft in each direction".into()),
            });
        }
    }
}

/// Multiples of the meshes, and cells a turn.
fn resolution(options: &EvaluationOptions, pace: f64) -> Result<(usize, usize), Error> {
    let most = 1.0 / (MIN_PER_CELL * pace); // cells a turn
    let cells = |order: f64| (CELLS_PER_ORDER as f64 * SIDEBAND_MARGIN * order).ceil();
    let meshes = options.teeth.meshes();
    let values = || meshes.iter().map(|m| m.order.to_f64());
    let lowest = values().fold(f64::INFINITY, f64::min);
    // Meshes that the rows do not hold are left out, unless none is left.
    let held = |m: &&OrderSource| cells(m.order.to_f64()) <= most;
    let fastest = meshes
        .iter()
        .filter(held)
        .max_by(|a, b| a.order.cmp(&b.order));
    let highest = fastest.map_or(lowest, |m| m.order.to_f64());
    if cells(lowest) > most {
        let per_tooth = 1.0 / (pace * lowest);
        let message = format!(
            "{per_tooth:.2} rows a tooth do not show what teeth do: at least {:.1} are needed",
            MIN_PER_CELL * CELLS_PER_ORDER as f64 * SIDEBAND_MARGIN
        );
        return Err(Error::new(Code::TooShort, message)
            .with_hint("read the encoders more often, or turn more slowly"));
    }
    let reachable = (1..)
        .take_while(|&k| cells(k as f64 * highest) <= most)
        .take(1000);
    let reachable = reachable.last().unwrap_or(0);
    if let Some(asked) = options.multiples
        && asked > reachable
    {
        let message = format!(
            "order {} (multiple {asked} of {}) is above {:.1}, the highest that these rows hold",
            asked as f64 * highest,
            fastest.map_or("", |m| m.name.as_str()),
            most / CELLS_PER_ORDER as f64
        );
        let hint = match reachable {
            0 => "read the encoders more often, or turn more slowly".to_string(),
            n => format!("--harmonics {n} at most"),
        };
        return Err(Error::new(Code::OutOfRange, message).with_hint(hint));
    }
    let multiples = options
        .multiples
        .unwrap_or(DEFAULT_MULTIPLES.min(reachable.max(1)));
    let named = options
        .known_orders
        .declared
        .iter()
        .map(|n| n.0.to_f64())
        .fold(0.0, f64::max);
    let wanted = cells(multiples as f64 * highest)
        .max(cells(named))
        .min(most);
    // Whole cells in a pitch of the output, as far as the rows allow.
    let pitch = options.teeth.output_teeth() as f64;
    let per_pitch = (wanted / pitch).ceil();
    let per_pitch = if per_pitch * pitch > most {
        (most / pitch).floor()
    } else {
        per_pitch
    };
    Ok((multiples, (per_pitch.max(1.0) * pitch) as usize))
}

/// Says which meshes lie above the band.
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
                "{} above the highest order these rows hold, {band:.1}, and not looked for",
                match &above[..] {
                    [one] => format!("{one} lies"),
                    many => format!("{} lie", many.join(", ")),
                }
            ),
            hint: Some("read the encoders more often, or turn more slowly".into()),
        });
    }
}

fn lost_counts_error(found: &[CountStep], rate_hz: Option<f64>) -> Error {
    const SHOWN: usize = 4;
    let one = |j: &CountStep| {
        let place = match rate_hz {
            Some(rate) => format!("{:.4} s", j.row as f64 / rate),
            None => format!("row {}", j.row + 1),
        };
        format!("{} at {place}", j.describe())
    };
    let mut list: Vec<String> = found.iter().take(SHOWN).map(one).collect();
    if found.len() > SHOWN {
        list.push(format!("and {} more", found.len() - SHOWN));
    }
    Error::new(Code::LostCounts, list.join(", ")).with_hint(
        "have the steps taken out with --repair, or take a segment without them: --after, --before",
    )
}

/// Signals of one direction over even cells, rad of the output.
struct DirectionSignal {
    forward: bool,
    order_error: AngularSignal,
    /// Lead of the input over uniform rotation.
    input: Option<AngularSignal>,
}

/// Both directions over even cells, and the speed; angles of the output from `output_origin` turns on.
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
    let room = |forward: bool| {
        let ends = runs.iter().filter(|run| run.forward == forward);
        ends.flat_map(|run| [run.input.0, run.input.1])
            .map(turns)
            .fold(None, |m: Option<(f64, f64)>, x| {
                Some(m.map_or((x, x), |(a, b)| (a.min(x), b.max(x))))
            })
    };
    // What lies next to the run's ends is no more than rows that dither.
    let open = |forward: bool, wanted: bool| {
        let room = room(forward).filter(|_| wanted);
        room.map(|(a, b)| AngularResampler::new(per_turn, a, b))
            .transpose()
    };
    let (mut up, mut down) = (open(true, true)?, open(false, true)?);
    let wanted = options.input && options.rate_hz.is_some();
    let (mut up_ahead, mut down_ahead) = (open(true, wanted)?, open(false, wanted)?);
    let mut paces = options
        .rate_hz
        .map(|rate| PitchTimer::new(rate, options.teeth.output_teeth()));
    let (mut places, mut values) = (Vec::new(), Vec::new());
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
            places.clear();
            places.extend(a.iter().map(|x| turns(*x)));
            values.clear();
            values.extend(a.iter().zip(b).map(|(a, b)| b - r * a));
            remove_steps(&mut values, low, lost);
            let (cells, ahead) = match run.forward {
                true => (&mut up, &mut up_ahead),
                false => (&mut down, &mut down_ahead),
            };
            if let Some(cells) = cells {
                cells.push(&places, &values);
            }
            if let Some(ahead) = ahead {
                // From the run's start on, at its mean pace.
                let pace = (run.input.1 - run.input.0) / (run.rows.len() - 1) as f64;
                let even = |row: usize| run.input.0 + pace * (row - run.rows.start) as f64;
                values.clear();
                values.extend((low..).zip(a).map(|(row, x)| r * (x - even(row))));
                ahead.push(&places, &values);
            }
            if let Some(paces) = &mut paces {
                paces.push(low, &places);
            }
        }
    })?;
    let mut signals = Vec::new();
    for (forward, cells, ahead) in [(true, up, up_ahead), (false, down, down_ahead)] {
        match cells.map(AngularResampler::finish) {
            Some(Ok(error)) => signals.push(DirectionSignal {
                forward,
                order_error: error,
                input: ahead.map(AngularResampler::finish).transpose()?,
            }),
            // A short way back is no flank of its own.
            Some(Err(e)) if e.code != Code::TooShort => return Err(e),
            _ => {}
        }
    }
    Ok((signals, paces.and_then(PitchTimer::finish)))
}

/// Takes the steps out that lie before these rows or among them.
fn remove_steps(values: &mut [f64], first: usize, lost: &[CountStep]) {
    for jump in lost {
        let from = jump.row.saturating_sub(first).min(values.len());
        values[from..].iter_mut().for_each(|e| *e -= jump.step);
    }
}

/// Turns of the output in which every shaft turns once.
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
    let found = signals
        .first()
        .map_or(0.0, |s| s.order_error.values.len() as f64 / per_turn as f64);
    if found >= needed {
        return Ok(());
    }
    let message = format!(
        "the record covers {found:.3} turns of the output in one direction, where {needed:.3} are needed for one turn of every shaft"
    );
    Err(Error::new(Code::TooShort, message).with_hint(format!(
        "record one turn of the slowest shaft and {:.3} turns of the output more, in one direction without a gap",
        2.0 * EDGE_CELLS as f64 / per_turn as f64
    )))
}
