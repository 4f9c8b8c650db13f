//! Encoder readings: counters, angles, quadrature tracks, pulse times and index pulses as angles.

use std::f64::consts::TAU;

use super::encoder_study::{EncoderRecordings, EncoderStudy};
use super::sample_blocks;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity;
use crate::base::quantity_kind::{Dimension, QuantityKind};
use crate::encoder::index_pulses::{IndexSignal, PulseEdge};
use crate::encoder::readings::{EncoderReadings, EncoderScale, detect_wrap};
use crate::recording::preprocess::unknown_channel;
use crate::recording::sample_column::SampleColumn;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::rotation::angle_curve::AngleCurve;
use crate::spectrum::rotation::encoder::quadrature;
use crate::spectrum::rotation::level_crossings::{self, StateLevels, level_crossings};
use crate::spectrum::rotation::tacho::{TachoPulse, TachoPulses, number_pulses};

/// The channels of these names.
///
/// # Errors
/// `NoChannel`.
pub fn find_channels<'r>(
    recording: &'r Recording,
    names: &[String],
) -> Result<Vec<&'r Channel>, Error> {
    let known: Vec<String> = recording.channels.iter().map(|c| c.name.clone()).collect();
    names
        .iter()
        .map(|name| {
            recording
                .channel(name)
                .ok_or_else(|| unknown_channel(name, &known))
        })
        .collect()
}

/// Refuses gaps: an encoder that was not read may have lost counts.
///
/// # Errors
/// Rows are missing.
pub fn check_no_gaps(recording: &Recording) -> Result<(), Error> {
    let found: usize = recording.segments.iter().map(ExactSizeIterator::len).sum();
    if recording.segments.len() <= 1 && found == recording.samples {
        return Ok(());
    }
    let end = recording.segments.first().map_or(0, |s| s.end);
    let message = format!(
        "readings are missing after row {end} ({:.6} s): {found} rows in {} segments have numbers of all channels",
        end as f64 / recording.rate_hz,
        recording.segments.len()
    );
    Err(Error::new(Code::NotANumber, message).with_hint(
        "bridge them by straight lines with --fill-gaps, or take a segment without: --after, --before",
    ))
}

/// Lines a turn of both encoders.
///
/// # Errors
/// `Usage`: they were not stated.
pub fn lines_per_rev(study: &EncoderStudy) -> Result<(usize, usize), Error> {
    study.lines.ok_or_else(|| {
        Error::new(Code::Usage, "the number of encoder lines is not stated")
            .with_hint("state the lines a turn of both: --lines 5000,5000")
    })
}

/// Scale of a channel's readings.
///
/// # Errors
/// Readings that are neither angles nor counts, or jump.
pub fn reading_scale(
    rows: &dyn EncoderReadings,
    channel: &Channel,
    is_output: bool,
    study: &EncoderStudy,
    how: &mut Vec<String>,
) -> Result<EncoderScale, Error> {
    let name = &channel.name;
    let role = if is_output { "output" } else { "input" };
    let unit = channel.unit.as_str();
    if let Some((factor, dimension)) = quantity::parse_unit(unit).filter(|_| !unit.is_empty())
        && dimension != Dimension::DIMENSIONLESS
    {
        if dimension != QuantityKind::Angle.dimension() {
            let message = format!("{name} is in {unit}, which is no angle");
            return Err(Error::new(Code::WrongUnit, message).with_hint(
                "encoders are read as angles (--unit COL=deg) or as counts (--unit COL=1 and --lines)",
            ));
        }
        let wrap = detect_wrap(rows, is_output, name, &[TAU / factor, 0.5 * TAU / factor])?;
        how.push(format!("{role} {name}: angle in {unit}{}", wrap_text(wrap)));
        return Ok(EncoderScale {
            unit: factor,
            wrap,
            step: 0.0,
        });
    }
    let (a, b) = lines_per_rev(study)?;
    let lines = if is_output { b } else { a };
    let counts = (lines * study.counts_per_line) as f64;
    // Counters of 8 to 32 bits, and those set back each turn.
    let mut known: Vec<f64> = vec![counts];
    known.extend([8, 10, 12, 14, 16, 24, 32].map(|bits| f64::from(bits).exp2()));
    let wrap = detect_wrap(rows, is_output, name, &known)?;
    how.push(format!(
        "{role} {name}: {counts} counts a turn ({lines} lines × {}){}",
        study.counts_per_line,
        wrap_text(wrap)
    ));
    Ok(EncoderScale {
        unit: TAU / counts,
        wrap,
        step: TAU / counts,
    })
}

fn wrap_text(wrap: Option<f64>) -> String {
    wrap.map_or(String::new(), |w| format!(", begins again after {w}"))
}

/// Channels as rows.
pub struct EncoderColumns<'a> {
    /// Readings of the input encoder.
    pub input: &'a SampleColumn,
    /// Readings of the output encoder.
    pub output: &'a SampleColumn,
}

impl EncoderReadings for EncoderColumns<'_> {
    fn n_rows(&self) -> usize {
        self.input.len().min(self.output.len())
    }

    fn read(&self, from: usize, input: &mut [f64], output: &mut [f64]) -> Result<(), Error> {
        self.input.read(from, input)?;
        self.output.read(from, output)
    }
}

/// Instants of pulses, s, one after the other.
fn pulse_times(channel: &Channel) -> Result<Vec<f64>, Error> {
    let (name, unit) = (&channel.name, &channel.unit);
    let factor = match quantity::parse_unit(unit) {
        Some((factor, dimension)) if dimension == QuantityKind::Time.dimension() => factor,
        _ if unit.is_empty() => 1.0,
        _ => {
            let message = format!("{name} is in {unit}, which is no time");
            return Err(Error::new(Code::WrongUnit, message)
                .with_hint("--stamps takes instants: state the unit, such as --unit COL=µs"));
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
        return Err(Error::new(Code::InvalidTimeStamps, message)
            .with_hint("is this the column of instants, and its unit right?"));
    }
    Ok(times)
}

/// The angle of a shaft from instants of pulses.
///
/// # Errors
/// Instants that do not follow each other; pulses missing, unless they are to be put right.
pub fn angle_from_pulse_times(
    channel: &Channel,
    lines: usize,
    repair: bool,
    how: &mut Vec<String>,
) -> Result<AngleCurve, Error> {
    let name = &channel.name;
    let times = pulse_times(channel)?;
    let found = number_pulses(&times);
    let missing: usize = found.missing.iter().map(|m| m.number).sum();
    if missing + found.extra_s.len() > 0 && !repair {
        return Err(missing_lines_error(name, &found, missing, lines));
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
fn missing_lines_error(name: &str, found: &TachoPulses, missing: usize, lines: usize) -> Error {
    let after = |time: f64| found.pulses.iter().find(|p: &&TachoPulse| p.time_s >= time);
    let places: Vec<usize> = found
        .missing
        .iter()
        .filter_map(|m| after(m.after_s))
        .map(|p| p.index % lines.max(1))
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
        .with_hint("their places are known from their neighbours: --repair puts them right")
}

/// The angle of a shaft from two tracks.
///
/// # Errors
/// One track only; those of the decoding.
pub fn angle_from_tracks(
    recording: &Recording,
    list: &[&Channel],
    lines: usize,
    how: &mut Vec<String>,
) -> Result<AngleCurve, Error> {
    let [a, b] = list else {
        let message = "one shaft has two tracks and the other has not";
        return Err(Error::new(Code::Usage, message)
            .with_hint("name both tracks of both encoders: --input A1,B1 --output A2,B2"));
    };
    let samples = sample_blocks::load_channels(recording, &[a, b], "the decoding of tracks")?;
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
        match found.ambiguous_edges {
            0 => String::new(),
            n => format!(", {n} closer than two samples"),
        }
    ));
    found.angle_curve(lines)
}

/// Angles at even instants.
pub struct UniformAngles {
    /// When they are read.
    pub timing: RowTiming,
    /// Angles of input and output, rad.
    pub angles: [Vec<f64>; 2],
}

/// Both angles at even instants, as many as the coarser encoder has points.
///
/// # Errors
/// No common time, fewer than two pulses.
pub fn resample_uniform(a: &AngleCurve, b: &AngleCurve) -> Result<UniformAngles, Error> {
    let ((a0, a1), (b0, b1)) = (a.time_range_s(), b.time_range_s());
    let (from, to) = (a0.max(b0), a1.min(b1));
    if !(to > from) {
        return Err(Error::new(
            Code::TooShort,
            "the two encoders were not read at the same time",
        )
        .with_hint("both columns must count time from the same instant"));
    }
    let count = a.points_within(from, to).min(b.points_within(from, to));
    if count < 2 {
        return Err(
            Error::new(Code::TooShort, "an encoder has fewer than two pulses")
                .with_hint("check the columns named"),
        );
    }
    let rate = (count - 1) as f64 / (to - from);
    let at = |curve: &AngleCurve| -> Vec<f64> {
        (0..count)
            .map(|i| curve.angle_at(from + i as f64 / rate))
            .collect()
    };
    Ok(UniformAngles {
        timing: RowTiming {
            from_s: from,
            rate_hz: rate,
        },
        angles: [at(a), at(b)],
    })
}

/// When rows were read.
#[derive(Clone, Copy)]
pub struct RowTiming {
    /// The first, s.
    pub from_s: f64,
    /// Rows a second, Hz.
    pub rate_hz: f64,
}

/// The index pulses that are named, their edges in rows.
///
/// # Errors
/// Channels that are not there, hold no pulses or no instants.
pub fn index_signals(
    read: EncoderRecordings,
    study: &EncoderStudy,
    timing: RowTiming,
    how: &mut Vec<String>,
) -> Result<[Option<IndexSignal>; 2], Error> {
    let mut all = [None, None];
    for (k, role) in ["input", "output"].into_iter().enumerate() {
        let (Some(name), Some(recording)) = (&study.index[k], read.index[k]) else {
            continue;
        };
        let channel = find_channels(recording, std::slice::from_ref(name))?[0];
        let tracks = [&study.input, &study.output][k].len() == 2;
        let counts = study.lines.map(|l| {
            let lines = [l.0, l.1][k] as f64;
            match () {
                () if study.pulse_times => lines,
                () if tracks => 4.0 * lines,
                () => lines * study.counts_per_line as f64,
            }
        });
        let row = |time_s: f64| (time_s - timing.from_s) * timing.rate_hz;
        let signal = if study.pulse_times {
            let mark = |t: f64| PulseEdge {
                row: row(t),
                rising: true,
            };
            IndexSignal {
                edges: pulse_times(channel)?.into_iter().map(mark).collect(),
                edge_uncertainty: 0.0,
                counts,
            }
        } else {
            index_edges(recording, channel, row, timing, counts)?
        };
        how.push(format!(
            "{role} index {}: {} edges",
            channel.name,
            signal.edges.len()
        ));
        all[k] = Some(signal);
    }
    Ok(all)
}

/// The edges of a level that is one way most of the time.
fn index_edges(
    recording: &Recording,
    channel: &Channel,
    row: impl Fn(f64) -> f64,
    timing: RowTiming,
    counts: Option<f64>,
) -> Result<IndexSignal, Error> {
    let samples = sample_blocks::load_channels(recording, &[channel], "the edges of index pulses")?;
    let samples = &samples[0];
    let levels = StateLevels::from_samples(samples).map_err(|e| {
        let message = format!("{} holds no index pulses: {}", channel.name, e.message);
        Error::new(e.code, message)
            .with_hint("check whether this is its channel: `geardyn check LOG`")
    })?;
    let middle = 0.5 * (levels.low + levels.high);
    let above = samples.iter().filter(|x| **x > middle).count();
    // What is high most of the time is a pulse downward.
    let upward = 2 * above <= samples.len();
    let found = level_crossings(samples, recording.rate_hz, levels)?;
    let edge = |e: level_crossings::LevelCrossing| PulseEdge {
        row: row(e.time_s),
        rising: e.rising == upward,
    };
    Ok(IndexSignal {
        edges: found.into_iter().map(edge).collect(),
        // Steeper than the sampling, an edge lies anywhere between two samples.
        edge_uncertainty: 0.5 * (timing.rate_hz / recording.rate_hz).max(0.0),
        counts,
    })
}
