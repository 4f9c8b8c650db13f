//! Transmission error from the channels of two encoders: what the readings are, brought to rows, and evaluated.

use std::f64::consts::TAU;
use std::time::Instant;

use super::attribution::{Attribution, Model, Row};
use super::blocks;
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::base::kind::{Dimension, Kind};
use crate::base::units;
use crate::recording::column::Column;
use crate::recording::settle::no_channel;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::rotation::angle::AngleCurve;
use crate::spectrum::rotation::encoder::quadrature;
use crate::spectrum::rotation::tacho::{Pulse, Pulses, number};
use crate::transmission::measured::eccentricity::{Parted, parted};
use crate::transmission::measured::evaluate::{Ask, Measured, evaluate};
use crate::transmission::measured::orders::Named;
use crate::transmission::measured::rows::{InMemory, Rows, Scale, Scales, wrap};
use crate::transmission::measured::teeth::Teeth;

/// What is asked of an encoder record.
#[derive(Debug, Clone)]
pub struct EncoderStudy {
    /// Channel of the input; two of them are the tracks of an encoder in quadrature.
    pub input: Vec<String>,
    /// Channels of the output, likewise.
    pub output: Vec<String>,
    /// Teeth between the shafts.
    pub teeth: Teeth,
    /// Lines a turn of both encoders, where the readings are not angles.
    pub lines: Option<(usize, usize)>,
    /// Counts that a counter makes of a line.
    pub counts_per_line: usize,
    /// The channels hold instants of pulses, one a line.
    pub stamps: bool,
    /// Rows are not even in time: no speed is told.
    pub angle_base: bool,
    /// Multiples of the meshes.
    pub multiples: Option<usize>,
    /// Lost counts are taken out.
    pub repair: bool,
    /// Every multiple of the shafts is fitted.
    pub every: bool,
    /// Radius that turns an angle of the output into a length on the line of action, m.
    pub radius: Option<f64>,
    /// Transverse pressure angle of a single pair, rad: tells an encoder's eccentricity from the gear's, of both flanks.
    pub pressure_angle: Option<f64>,
}

/// What an encoder record says.
pub struct EncoderRecord {
    /// What the readings were, in words.
    pub how: Vec<String>,
    /// The evaluation.
    pub measured: Measured,
    /// Eccentricity of encoders and gears apart.
    pub parted: Vec<Parted>,
    /// What makes the lines of the first flank, where there is a model.
    pub attribution: Option<Attribution>,
    /// What this record cannot tell apart, and what could.
    pub limits: Vec<String>,
    /// See [`EncoderStudy::radius`].
    pub radius: Option<f64>,
    /// Stages and their time, s.
    pub trace: Vec<(&'static str, f64)>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// Evaluates the channels of recordings: the same one for both shafts, or one for each where their rows are their own.
///
/// # Errors
/// Channels that are not there or hold no angle; missing readings; everything [`evaluate`] refuses.
pub fn encoders(
    input: &Recording,
    output: &Recording,
    study: &EncoderStudy,
    model: Option<&Model>,
) -> Result<EncoderRecord, Error> {
    let start = Instant::now();
    let mut how = Vec::new();
    let mut warnings = Vec::new();
    let first = channels(input, &study.input)?;
    let second = channels(output, &study.output)?;
    for recording in [input, output] {
        whole(recording)?;
    }
    let timed = study.stamps || study.input.len() == 2 || study.output.len() == 2;
    let mut ask = Ask {
        teeth: study.teeth.clone(),
        scales: Scales {
            input: Scale::RAD,
            output: Scale::RAD,
        },
        rate_hz: None,
        multiples: study.multiples,
        repair: study.repair,
        named: match model {
            Some(model) => model.named(&study.teeth)?,
            None => Named::default(),
        },
        every: study.every,
        // What the input does tells what of a line is the model's.
        input: model.is_some(),
    };
    let measured = if timed {
        let curve =
            |recording: &Recording, list: &[&Channel], lines, said: &mut Vec<String>| match study
                .stamps
            {
                true => from_stamps(list[0], lines, study.repair, said),
                false => from_tracks(recording, list, lines, said),
            };
        let (a, b) = lines(study)?;
        let (first, second) = (
            curve(input, &first, a, &mut how)?,
            curve(output, &second, b, &mut how)?,
        );
        let (rate_hz, [first, second]) = even(&first, &second)?;
        ask.rate_hz = Some(rate_hz);
        evaluate(&InMemory(&first, &second), &ask)?
    } else {
        let rows = Columns {
            input: &first[0].samples,
            output: &second[0].samples,
        };
        ask.scales.input = scale(&rows, first[0], false, study, &mut how)?;
        ask.scales.output = scale(&rows, second[0], true, study, &mut how)?;
        ask.rate_hz = (!study.angle_base).then_some(input.rate_hz);
        evaluate(&rows, &ask)?
    };
    let evaluated = start.elapsed().as_secs_f64();
    warnings.extend(measured.warnings.iter().cloned());
    for jump in &measured.repaired {
        warnings.push(Warning {
            code: "counts-repaired",
            message: format!("{} at row {}: taken out", jump.told(), jump.row + 1),
            hint: None,
        });
    }
    let speed = measured.speed.as_ref().map(|s| s.range().0);
    let attribution = match (model, measured.flanks.first()) {
        (Some(model), Some(flank)) => Some(model.attribute(flank, speed, measured.error)?),
        _ => None,
    };
    warnings.extend(attribution.as_ref().and_then(uneven));
    let parted = study
        .pressure_angle
        .map_or(Vec::new(), |angle| parted(&measured, &study.teeth, angle));
    let limits = limits(&measured, study, !parted.is_empty());
    Ok(EncoderRecord {
        how,
        parted,
        attribution,
        limits,
        measured,
        radius: study.radius,
        trace: vec![("evaluate", evaluated)],
        warnings,
    })
}

/// Says that the input does not turn evenly at the orders of declared errors.
fn uneven(found: &Attribution) -> Option<Warning> {
    let worst = found.rows.iter().max_by(|a, b| {
        let far = |row: &Row| (row.even / row.amplitude - 1.0).abs();
        far(a).total_cmp(&far(b))
    })?;
    let far = worst.even / worst.amplitude - 1.0;
    (far.abs() > UNEVEN).then(|| Warning {
        code: "input-uneven",
        message: format!(
            "the input does not turn evenly: of order {} it makes {:.0} % of what is measured; the model takes that off",
            worst.order,
            -100.0 * far
        ),
        hint: Some("the free driver answers the meshes; what it does is in the record, and how it passes on is the model's".into()),
    })
}

/// The share of a line that an uneven input may make unsaid.
const UNEVEN: f64 = 0.02;

/// What is not told apart.
fn limits(measured: &Measured, study: &EncoderStudy, is_parted: bool) -> Vec<String> {
    let mut all = Vec::new();
    if !is_parted {
        let missing = match (measured.flanks.len(), study.pressure_angle) {
            (2, None) => "both flanks are there: --pressure-angle parts them",
            (2, Some(_)) => "both flanks are there, but the lines are shared or faint",
            _ => "a record of both directions would, with --pressure-angle",
        };
        all.push(format!(
            "the eccentricity of an encoder and that of the gear on its shaft have one order and are not told apart; {missing}"
        ));
    }
    all.push(
        "errors of single encoder lines repeat with their shaft and are part of its orders; another seat of the encoder would tell them"
            .into(),
    );
    all
}

fn channels<'r>(recording: &'r Recording, names: &[String]) -> Result<Vec<&'r Channel>, Error> {
    let known: Vec<String> = recording.channels.iter().map(|c| c.name.clone()).collect();
    names
        .iter()
        .map(|name| {
            recording
                .channel(name)
                .ok_or_else(|| no_channel(name, &known))
        })
        .collect()
}

/// Refuses gaps: an encoder that was not read may have lost counts.
fn whole(recording: &Recording) -> Result<(), Error> {
    let found: usize = recording.stretches.iter().map(ExactSizeIterator::len).sum();
    if recording.stretches.len() <= 1 && found == recording.samples {
        return Ok(());
    }
    let end = recording.stretches.first().map_or(0, |s| s.end);
    let message = format!(
        "readings are missing after row {end} ({:.6} s): {} of {} rows hold numbers of all channels",
        end as f64 / recording.rate_hz,
        found,
        recording.samples
    );
    Err(Error::new(Code::NotANumber, message).hint(
        "bridge them by straight lines with --fill-gaps, or take a stretch without: --after, --before",
    ))
}

fn lines(study: &EncoderStudy) -> Result<(usize, usize), Error> {
    study.lines.ok_or_else(|| {
        Error::new(Code::Usage, "nothing says how many lines the encoders have")
            .hint("state the lines a turn of both: --lines 5000,5000")
    })
}

/// What the readings of a channel mean.
fn scale(
    rows: &dyn Rows,
    channel: &Channel,
    is_output: bool,
    study: &EncoderStudy,
    how: &mut Vec<String>,
) -> Result<Scale, Error> {
    let name = &channel.name;
    let role = if is_output { "output" } else { "input" };
    let unit = channel.unit.as_str();
    if let Some((factor, dimension)) = units::of_unit(unit).filter(|_| !unit.is_empty())
        && dimension != Dimension::NONE
    {
        if dimension != Kind::Angle.dimension() {
            let message = format!("{name} is in {unit}, which is no angle");
            return Err(Error::new(Code::WrongUnit, message).hint(
                "encoders are read as angles (--unit COL=deg) or as counts (--unit COL=1 and --lines)",
            ));
        }
        let wrap = wrap(rows, is_output, name, &[TAU / factor, 0.5 * TAU / factor])?;
        how.push(format!(
            "{role} {name}: angle in {unit}{}",
            begins_again(wrap)
        ));
        return Ok(Scale {
            unit: factor,
            wrap,
            step: 0.0,
        });
    }
    let (a, b) = lines(study)?;
    let lines = if is_output { b } else { a };
    let counts = (lines * study.counts_per_line) as f64;
    // Counters of 8 to 32 bits, and those set back each turn.
    let mut known: Vec<f64> = vec![counts];
    known.extend([8, 10, 12, 14, 16, 24, 32].map(|bits| f64::from(bits).exp2()));
    let wrap = wrap(rows, is_output, name, &known)?;
    how.push(format!(
        "{role} {name}: {counts} counts a turn ({lines} lines × {}){}",
        study.counts_per_line,
        begins_again(wrap)
    ));
    Ok(Scale {
        unit: TAU / counts,
        wrap,
        step: TAU / counts,
    })
}

fn begins_again(wrap: Option<f64>) -> String {
    wrap.map_or(String::new(), |w| format!(", begins again after {w}"))
}

/// Channels as rows.
struct Columns<'a> {
    input: &'a Column,
    output: &'a Column,
}

impl Rows for Columns<'_> {
    fn rows(&self) -> usize {
        self.input.len().min(self.output.len())
    }

    fn read(&self, from: usize, input: &mut [f64], output: &mut [f64]) -> Result<(), Error> {
        self.input.read(from, input)?;
        self.output.read(from, output)
    }
}

/// The angle of a shaft from instants of pulses.
fn from_stamps(
    channel: &Channel,
    lines: usize,
    repair: bool,
    how: &mut Vec<String>,
) -> Result<AngleCurve, Error> {
    let (name, unit) = (&channel.name, &channel.unit);
    let factor = match units::of_unit(unit) {
        Some((factor, dimension)) if dimension == Kind::Time.dimension() => factor,
        _ if unit.is_empty() => 1.0,
        _ => {
            let message = format!("{name} is in {unit}, which is no time");
            return Err(Error::new(Code::WrongUnit, message)
                .hint("--stamps takes instants: state the unit, such as --unit COL=µs"));
        }
    };
    let mut times = vec![0.0; channel.samples.len()];
    channel.samples.read(0, &mut times)?;
    times.iter_mut().for_each(|t| *t *= factor);
    if let Some(at) = times.windows(2).position(|w| w[0] >= w[1]) {
        let message = format!(
            "the pulses of {name} do not come one after the other at row {}",
            at + 2
        );
        return Err(Error::new(Code::BadTime, message)
            .hint("is this the column of instants, and its unit right?"));
    }
    let found = number(&times);
    let missing: usize = found.missing.iter().map(|m| m.number).sum();
    if missing + found.extra_s.len() > 0 && !repair {
        return Err(misses(name, &found, missing, lines));
    }
    how.push(format!(
        "{name}: {} pulses, {lines} a turn{}",
        times.len(),
        match missing + found.extra_s.len() {
            0 => String::new(),
            _ => format!(
                ", {missing} missing and {} extra ones put right",
                found.extra_s.len()
            ),
        }
    ));
    AngleCurve::from_pulses(&found, lines)
}

/// The error of missing lines: where, and whether always at the same place of the disc.
fn misses(name: &str, found: &Pulses, missing: usize, lines: usize) -> Error {
    let after = |time: f64| found.pulses.iter().find(|p: &&Pulse| p.time_s >= time);
    let places: Vec<usize> = found
        .missing
        .iter()
        .filter_map(|m| after(m.after_s))
        .map(|p| p.place % lines.max(1))
        .collect();
    let same = places.len() > 1 && places.iter().all(|p| *p == places[0]);
    let place = match (found.missing.first(), found.extra_s.first()) {
        (Some(m), _) => format!("the first after {:.6} s", m.after_s),
        (None, Some(t)) => format!("the first at {t:.6} s"),
        (None, None) => String::new(),
    };
    let disc = match same {
        true => format!("; always behind line {} of the disc", places[0] + 1),
        false => String::new(),
    };
    let message = format!(
        "{name} misses {missing} pulses and has {} too many, {place}{disc}",
        found.extra_s.len()
    );
    Error::new(Code::LostCounts, message)
        .hint("their places are known from their neighbours: --repair puts them right")
}

/// The angle of a shaft from two tracks.
fn from_tracks(
    recording: &Recording,
    list: &[&Channel],
    lines: usize,
    how: &mut Vec<String>,
) -> Result<AngleCurve, Error> {
    let [a, b] = list else {
        let message = "one shaft has two tracks and the other has not";
        return Err(Error::new(Code::Usage, message)
            .hint("name both tracks of both encoders: --input A1,B1 --output A2,B2"));
    };
    let samples = blocks::whole(recording, &[a, b], "the decoding of tracks")?;
    let mut found = quadrature(&samples[0], &samples[1], recording.rate_hz)?;
    if found.boundary.last() < found.boundary.first() {
        // Tracks the other way round: counted up all the same, the ratio has no sign of its own.
        found.boundary.iter_mut().for_each(|c| *c = -*c);
    }
    how.push(format!(
        "{} and {}: tracks with {lines} lines a turn, {} edges{}",
        a.name,
        b.name,
        found.time_s.len(),
        match found.doubtful {
            0 => String::new(),
            n => format!(", {n} closer than two samples"),
        }
    ));
    found.curve(lines)
}

/// Both angles at even instants, as many as the coarser encoder has points, and how many a second.
fn even(a: &AngleCurve, b: &AngleCurve) -> Result<(f64, [Vec<f64>; 2]), Error> {
    let ((a0, a1), (b0, b1)) = (a.times_s(), b.times_s());
    let (from, to) = (a0.max(b0), a1.min(b1));
    if !(to > from) {
        return Err(Error::new(
            Code::TooShort,
            "the two encoders were not read at the same time",
        )
        .hint("both columns must count time from the same instant"));
    }
    let count = a.points_within(from, to).min(b.points_within(from, to));
    if count < 2 {
        return Err(
            Error::new(Code::TooShort, "an encoder has fewer than two pulses")
                .hint("look at the columns named"),
        );
    }
    let rate = (count - 1) as f64 / (to - from);
    let at = |curve: &AngleCurve| -> Vec<f64> {
        (0..count)
            .map(|i| curve.at(from + i as f64 / rate))
            .collect()
    };
    Ok((rate, [at(a), at(b)]))
}
