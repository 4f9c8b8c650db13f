//! The evaluation of a record: checks, even cells for each flank, play between the flanks, speed.

use std::f64::consts::TAU;

use super::cells::{CELLS_PER_ORDER, Cells, ERROR, LEAST_PER_CELL, LOST};
use super::flank::{Flank, Search, flank};
use super::index::{Index, Signal, indices};
use super::jumps::{Jump, Look, jumps, placed};
use super::marks::Marks;
use super::orders::Named;
use super::play::{self, Play};
use super::rows::{Rows, Scales, each};
use super::speed::{Paces, Speed};
use super::survey::{MeasuredRatio, Run, survey};
use super::teeth::{Member, Teeth};
use super::verdict::Verdict;
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::numeric::fraction::Fraction;
use crate::spectrum::rotation::angular::AngularSignal;

/// What is asked.
#[derive(Debug, Clone)]
pub struct Ask {
    /// Teeth between the shafts.
    pub teeth: Teeth,
    /// What the readings mean.
    pub scales: Scales,
    /// Rows a second, Hz, where the rows are even in time.
    pub rate_hz: Option<f64>,
    /// Multiples of the meshes; as many as the rows allow, up to [`MULTIPLES`], where left out.
    pub multiples: Option<usize>,
    /// Steps of lost counts are taken out.
    pub repair: bool,
    /// Orders that a model names.
    pub named: Named,
    /// Every multiple of the shafts is fitted, not only those that stand out.
    pub every: bool,
    /// What the input does beside even turning is wanted as well, where rows have a clock.
    pub input: bool,
    /// Index pulses of input and output, where they were read.
    pub index: [Option<Signal>; 2],
}

/// Multiples of the meshes looked for where nobody says how many.
pub const MULTIPLES: usize = 4;

/// So often the record is looked at again after steps were taken out.
const ROUNDS: usize = 4;

/// Room above the highest mesh multiple for its sidebands, relative.
const ROOM: f64 = 1.05;

/// What a record says.
#[derive(Debug)]
pub struct Measured {
    /// Turns of the output for one of the input, by tooth numbers.
    pub declared: Fraction,
    /// As the encoders have it.
    pub ratio: MeasuredRatio,
    /// One or two flanks, the one with more turns first.
    pub flanks: Vec<Flank>,
    /// Stretches in which the input turned one way.
    pub runs: Vec<Run>,
    /// Rows at either end in which the input stood still, left out.
    pub still: [usize; 2],
    /// How far the output is free between the flanks.
    pub play: Option<Play>,
    /// Steps that were taken out.
    pub repaired: Vec<Jump>,
    /// What the index pulses of input and output say.
    pub index: [Option<Index>; 2],
    /// Multiples of the meshes looked for.
    pub multiples: usize,
    /// The highest order kept.
    pub band: f64,
    /// What the cells and the steps of the input lose of the highest order, relative.
    pub error: f64,
    /// Noise of the encoders' steps at one row, rms, rad of the output.
    pub quantisation: f64,
    /// Rows that a tooth of the output passes in.
    pub rows_per_tooth: f64,
    /// Speed over the record.
    pub speed: Option<Speed>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// Evaluates a record.
///
/// # Errors
/// Readings that are no numbers, nothing that turns, another ratio than the teeth make, slip, lost counts (unless they are to be taken
/// out), too few rows a tooth, less than one turn, orders above what the rows hold.
pub fn evaluate(rows: &dyn Rows, ask: &Ask) -> Result<Measured, Error> {
    let mut scales = ask.scales;
    let looked = survey(rows, scales)?;
    let ratio = looked.ratio((scales.input.step, scales.output.step))?;
    let mut index = match ask.index.iter().flatten().next() {
        None => [None, None],
        Some(_) => {
            let signals = [ask.index[0].as_ref(), ask.index[1].as_ref()];
            let paces = [looked.pace, looked.pace * ratio.value.abs()];
            indices(rows, scales, &looked.runs, signals, paces)?
        }
    };
    looked.check_ratio(&ask.teeth, ratio, ask.rate_hz)?;
    // From here on both count up together.
    scales.output.unit *= ratio.value.signum();
    if let Some(output) = index[1].as_mut().filter(|_| ratio.value < 0.0) {
        output.turned();
    }
    let declared = ask.teeth.ratio();
    let r = declared.value();
    let looked = match ratio.value < 0.0 {
        true => survey(rows, scales)?,
        false => looked,
    };
    let pace = looked.pace * r / TAU; // turns of the output in a row
    let last = ask.teeth.last() as f64;
    let rows_per_tooth = 1.0 / (pace * last);
    let (multiples, per_turn) = resolution(ask, pace)?;
    let mut warnings = Vec::new();
    let band = per_turn as f64 / CELLS_PER_ORDER as f64;
    left_out(ask, band, &mut warnings);
    let runs = looked.settled(r, TAU / last / r);
    let look = Look {
        survey: &looked,
        ratio: r,
        rows_per_tooth,
    };
    let mut verdict = Verdict::new([index[0].as_ref(), index[1].as_ref()], r);
    let mut found = verdict.judge(jumps(rows, scales, &runs, look)?);
    found.extend(verdict.hidden(rows, scales, rows_per_tooth.ceil() as usize)?);
    found.sort_by_key(|jump| jump.row);
    let marks = Marks::of(&index, &runs, r);
    let steps = (scales.input.step * r, scales.output.step);
    let given = [steps.0, steps.1].into_iter().filter(|c| *c > 0.0);
    // Angles of the input are known to half a step, which rounds off high orders.
    let blunt = band * steps.0 / TAU;
    let error = ERROR + (0.5 * TAU * blunt).powi(2) / 6.0;
    let search = Search {
        teeth: &ask.teeth,
        multiples,
        band,
        named: &ask.named,
        every: ask.every,
        error,
        input_mark: marks.input.unwrap_or(0.0),
        count: given.fold(f64::INFINITY, f64::min),
    };
    let least = turns_needed(ask) * per_turn as f64;
    let mut round = 0;
    let (mut flanks, speed, apart) = loop {
        if !found.is_empty() && !ask.repair {
            return Err(lost(&found, ask.rate_hz));
        }
        let (mut signals, speed) = gather(rows, scales, &runs, &found, ask, per_turn, marks.zero)?;
        signals.sort_by_key(|s| std::cmp::Reverse(s.error.values.len()));
        check_turns(ask, &signals, per_turn)?;
        let of = |forward| signals.iter().find(|s| s.forward == forward);
        let apart =
            (of(true).zip(of(false))).and_then(|(up, down)| play::mean(&up.error, &down.error));
        let flanks = signals
            .into_iter()
            .filter(|s| s.error.values.len() as f64 >= least)
            .map(|s| flank(s.error, s.input.as_ref(), s.forward, &search))
            .collect::<Result<Vec<Flank>, Error>>()?;
        let mut more = Vec::new();
        for flank in &flanks {
            let places = flank.steps.iter();
            let places: Vec<(f64, f64)> = places
                .map(|s| ((flank.signal.angle(s.cell) + marks.zero * TAU) / r, s.size))
                .collect();
            let of_way: Vec<Run> = runs
                .iter()
                .filter(|run| run.forward == flank.forward)
                .cloned()
                .collect();
            more.extend(placed(&places, rows, scales, &of_way, look)?);
        }
        let more = verdict.judge(more);
        if more.is_empty() {
            too_short(&looked.runs, &flanks, turns_needed(ask), r, &mut warnings);
            break (flanks, speed, apart);
        }
        found.extend(more);
        found.sort_by_key(|jump| jump.row);
        round += 1;
        if round > ROUNDS {
            return Err(lost(&found, ask.rate_hz).hint(
                "steps stay in the record however many are taken out: look at the encoders and their cables",
            ));
        }
    };
    let play = apart.map(|(mean, first, count)| Play {
        mean,
        course: play::course(&flanks, first, count),
    });
    flanks.iter_mut().for_each(|f| marks.refer(f, &ask.teeth));
    warnings.extend(verdict.warnings());
    warnings.extend(index.iter().flatten().filter_map(Index::warnings));
    Ok(Measured {
        index,
        declared,
        ratio,
        flanks,
        runs,
        still: looked.still,
        play,
        repaired: found,
        multiples,
        band,
        error,
        quantisation: (steps.0.powi(2) + steps.1.powi(2)).sqrt() / 12f64.sqrt(),
        rows_per_tooth,
        speed,
        warnings,
    })
}

/// Says which direction turns too little to be evaluated.
fn too_short(runs: &[Run], flanks: &[Flank], needed: f64, ratio: f64, to: &mut Vec<Warning>) {
    for (forward, way) in [(true, "forward"), (false, "backward")] {
        let reach = runs.iter().filter(|run| run.forward == forward);
        let turns = reach.map(Run::reach).fold(0.0, f64::max) * ratio / TAU;
        if turns > 0.0 && !flanks.iter().any(|f| f.forward == forward) {
            to.push(Warning {
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
fn resolution(ask: &Ask, pace: f64) -> Result<(usize, usize), Error> {
    let most = 1.0 / (LEAST_PER_CELL * pace); // cells a turn
    let cells = |order: f64| (CELLS_PER_ORDER as f64 * ROOM * order).ceil();
    let meshes = ask.teeth.meshes();
    let values = || meshes.iter().map(|m| m.order.value());
    let lowest = values().fold(f64::INFINITY, f64::min);
    // Meshes that the rows do not hold are left out, unless none is left.
    let held = |m: &&Member| cells(m.order.value()) <= most;
    let fastest = meshes
        .iter()
        .filter(held)
        .max_by(|a, b| a.order.cmp(&b.order));
    let highest = fastest.map_or(lowest, |m| m.order.value());
    if cells(lowest) > most {
        let per_tooth = 1.0 / (pace * lowest);
        let message = format!(
            "{per_tooth:.2} rows a tooth do not show what teeth do: at least {:.1} are needed",
            LEAST_PER_CELL * CELLS_PER_ORDER as f64 * ROOM
        );
        return Err(Error::new(Code::TooShort, message)
            .hint("read the encoders more often, or turn more slowly"));
    }
    let reachable = (1..)
        .take_while(|&k| cells(k as f64 * highest) <= most)
        .take(1000);
    let reachable = reachable.last().unwrap_or(0);
    if let Some(asked) = ask.multiples
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
        return Err(Error::new(Code::OutOfRange, message).hint(hint));
    }
    let multiples = ask.multiples.unwrap_or(MULTIPLES.min(reachable.max(1)));
    let named = ask
        .named
        .declared
        .iter()
        .map(|n| n.0.value())
        .fold(0.0, f64::max);
    let wanted = cells(multiples as f64 * highest)
        .max(cells(named))
        .min(most);
    // Whole cells in a pitch of the output, as far as the rows allow.
    let pitch = ask.teeth.last() as f64;
    let per_pitch = (wanted / pitch).ceil();
    let per_pitch = if per_pitch * pitch > most {
        (most / pitch).floor()
    } else {
        per_pitch
    };
    Ok((multiples, (per_pitch.max(1.0) * pitch) as usize))
}

/// Says which meshes lie above the band.
fn left_out(ask: &Ask, band: f64, warnings: &mut Vec<Warning>) {
    let above: Vec<Member> = ask.teeth.meshes();
    let above: Vec<String> = above
        .into_iter()
        .filter(|m| m.order.value() > band)
        .map(|m| format!("{} (order {})", m.name, m.order))
        .collect();
    if !above.is_empty() {
        warnings.push(Warning {
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

fn lost(found: &[Jump], rate_hz: Option<f64>) -> Error {
    const SHOWN: usize = 4;
    let one = |j: &Jump| {
        let place = match rate_hz {
            Some(rate) => format!("{:.4} s", j.row as f64 / rate),
            None => format!("row {}", j.row + 1),
        };
        format!("{} at {place}", j.told())
    };
    let mut list: Vec<String> = found.iter().take(SHOWN).map(one).collect();
    if found.len() > SHOWN {
        list.push(format!("and {} more", found.len() - SHOWN));
    }
    Error::new(Code::LostCounts, list.join(", ")).hint(
        "have the steps taken out with --repair, or take a stretch without them: --after, --before",
    )
}

/// What one direction holds over even cells, rad of the output.
struct Passed {
    forward: bool,
    error: AngularSignal,
    /// How far the input runs ahead of even turning.
    input: Option<AngularSignal>,
}

/// Both directions over even cells, and the speed; angles of the output from `zero` turns on.
fn gather(
    rows: &dyn Rows,
    scales: Scales,
    runs: &[Run],
    lost: &[Jump],
    ask: &Ask,
    per_turn: usize,
    zero: f64,
) -> Result<(Vec<Passed>, Option<Speed>), Error> {
    let r = ask.teeth.ratio().value();
    let turns = |x: f64| x * r / TAU - zero;
    let room = |forward: bool| {
        let ends = runs.iter().filter(|run| run.forward == forward);
        ends.flat_map(|run| [run.input.0, run.input.1])
            .map(turns)
            .fold(None, |m: Option<(f64, f64)>, x| {
                Some(m.map_or((x, x), |(a, b)| (a.min(x), b.max(x))))
            })
    };
    // What lies beside the run's ends is no more than rows that dither.
    let open = |forward| room(forward).map(|(a, b)| Cells::new(per_turn, a, b));
    let (mut up, mut down) = (open(true), open(false));
    let wanted = ask.input && ask.rate_hz.is_some();
    let ahead = |forward| open(forward).filter(|_| wanted);
    let (mut up_ahead, mut down_ahead) = (ahead(true), ahead(false));
    let mut paces = ask.rate_hz.map(|rate| Paces::new(rate, ask.teeth.last()));
    let mut values = Vec::new();
    each(rows, scales, |first, input, output| {
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
            values.clear();
            values.extend(a.iter().zip(b).map(|(a, b)| b - r * a));
            take_out(&mut values, low, lost);
            let (cells, ahead) = match run.forward {
                true => (&mut up, &mut up_ahead),
                false => (&mut down, &mut down_ahead),
            };
            if let Some(cells) = cells {
                cells.put(a.iter().map(|x| turns(*x)), &values);
            }
            if let Some(ahead) = ahead {
                // From the run's start on, at its mean pace.
                let pace = (run.input.1 - run.input.0) / (run.rows.len() - 1) as f64;
                let even = |row: usize| run.input.0 + pace * (row - run.rows.start) as f64;
                values.clear();
                values.extend((low..).zip(a).map(|(row, x)| r * (x - even(row))));
                ahead.put(a.iter().map(|x| turns(*x)), &values);
            }
            if let Some(paces) = &mut paces {
                paces.see(low, a.iter().map(|x| turns(*x)));
            }
        }
    })?;
    let mut signals = Vec::new();
    for (forward, cells, ahead) in [(true, up, up_ahead), (false, down, down_ahead)] {
        match cells.map(Cells::finish) {
            Some(Ok(error)) => signals.push(Passed {
                forward,
                error,
                input: ahead.map(Cells::finish).transpose()?,
            }),
            // A short way back is no flank of its own.
            Some(Err(e)) if e.code != Code::TooShort => return Err(e),
            _ => {}
        }
    }
    Ok((signals, paces.and_then(Paces::finish)))
}

/// Takes the steps out that lie before these rows or among them.
fn take_out(values: &mut [f64], first: usize, lost: &[Jump]) {
    for jump in lost {
        let from = jump.row.saturating_sub(first).min(values.len());
        values[from..].iter_mut().for_each(|e| *e -= jump.step);
    }
}

/// Turns of the output in which every shaft turns once.
fn turns_needed(ask: &Ask) -> f64 {
    let shafts = ask.teeth.shafts();
    shafts
        .iter()
        .map(|s| 1.0 / s.order.value())
        .fold(1.0, f64::max)
}

fn check_turns(ask: &Ask, signals: &[Passed], per_turn: usize) -> Result<(), Error> {
    let needed = turns_needed(ask);
    let found = signals
        .first()
        .map_or(0.0, |s| s.error.values.len() as f64 / per_turn as f64);
    if found >= needed {
        return Ok(());
    }
    let message = format!(
        "the record covers {found:.3} turns of the output in one direction, where {needed:.3} are needed for one turn of every shaft"
    );
    Err(Error::new(Code::TooShort, message).hint(format!(
        "record one turn of the slowest shaft and {:.3} turns of the output more, in one direction without a gap",
        2.0 * LOST as f64 / per_turn as f64
    )))
}
