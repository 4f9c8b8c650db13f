//! Conversion of encoder readings to angles: counters, angles, quadrature tracks, pulse times and index pulses.

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

/// Channels by name.
///
/// # Errors
/// `NoChannel`.
pub fn find_channels<'r>(
    recording: &'r Recording,
    names: &[String],
) -> Result<Vec<&'r Channel>, Error> {
    let channel_names: Vec<String> = recording.channels.iter().map(|c| c.name.clone()).collect();
    names
        .iter()
        .map(|name| {
            recording
                .channel(name)
                .ok_or_else(|| unknown_channel(name, &channel_names))
        })
        .collect()
}

/// Refuses gaps in the readings, in which counts may be lost.
///
/// # Errors
/// Rows are missing.
pub fn check_no_gaps(recording: &Recording) -> Result<(), Error> {
    let rows: usize = recording.segments.iter().map(ExactSizeIterator::len).sum();
    if recording.segments.len() <= 1 && rows == recording.samples {
        return Ok(());
    }
    let end = recording.segments.first().map_or(0, |s| s.end);
    let message = format!(
        "missing samples after row {end} ({:.6} s): {rows} rows in {} segments have numbers of all channels",
        end as f64 / recording.rate_hz,
        recording.segments.len()
    );
    Err(Error::new(Code::NotANumber, message).with_hint(
        "interpolate them with --fill-gaps, or select a segment without gaps: --after, --before",
    ))
}

/// Lines per revolution of the input and the output encoder.
///
/// # Errors
/// `Usage` if they are not stated.
pub fn lines_per_rev(study: &EncoderStudy) -> Result<(usize, usize), Error> {
    study.lines.ok_or_else(|| {
        Error::new(Code::Usage, "the number of encoder lines is not stated")
            .with_hint("state the lines per turn of both: --lines 5000,5000")
    })
}

/// Scale of the readings of a channel; its description is appended to `descriptions`.
///
/// # Errors
/// Readings that are neither angles nor counts, or that jump.
pub fn reading_scale(
    rows: &dyn EncoderReadings,
    channel: &Channel,
    is_output: bool,
    study: &EncoderStudy,
    descriptions: &mut Vec<String>,
) -> Result<EncoderScale, Error> {
    let name = &channel.name;
    let role = if is_output { "output" } else { "input" };
    let unit = channel.unit.as_str();
    if let Some((factor, dimension)) = quantity::parse_unit(unit).filter(|_| !unit.is_empty())
        && dimension != Dimension::DIMENSIONLESS
    {
        if dimension != QuantityKind::Angle.dimension() {
            let message = format!("{name} is in {unit}, which is not an angle");
            return Err(Error::new(Code::WrongUnit, message).with_hint(
                "encoders are read as angles (--unit COL=deg) or as counts (--unit COL=1 and --lines)",
            ));
        }
        let wrap = detect_wrap(rows, is_output, name, &[TAU / factor, 0.5 * TAU / factor])?;
        descriptions.push(format!("{role} {name}: angle in {unit}{}", wrap_text(wrap)));
        return Ok(EncoderScale {
            unit: factor,
            wrap,
            step: 0.0,
        });
    }
    let (of_input, of_output) = lines_per_rev(study)?;
    let lines = if is_output { of_output } else { of_input };
    let counts = (lines * study.counts_per_line) as f64;
    // Counters of 8 to 32 bits, and counters reset at each revolution.
    let mut moduli: Vec<f64> = vec![counts];
    moduli.extend([8, 10, 12, 14, 16, 24, 32].map(|bits| f64::from(bits).exp2()));
    let wrap = detect_wrap(rows, is_output, name, &moduli)?;
    descriptions.push(format!(
        "{role} {name}: {counts} counts per turn ({lines} lines × {}){}",
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
    wrap.map_or(String::new(), |w| format!(", wraps at {w}"))
}

/// Columns of the input and the output encoder, read row by row.
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

    fn read(&self, first_row: usize, input: &mut [f64], output: &mut [f64]) -> Result<(), Error> {
        self.input.read(first_row, input)?;
        self.output.read(first_row, output)
    }
}

/// Times of pulses, s, strictly increasing.
fn pulse_times(channel: &Channel) -> Result<Vec<f64>, Error> {
    let (name, unit) = (&channel.name, &channel.unit);
    let factor = match quantity::parse_unit(unit) {
        Some((factor, dimension)) if dimension == QuantityKind::Time.dimension() => factor,
        _ if unit.is_empty() => 1.0,
        _ => {
            let message = format!("{name} is in {unit}, which is not a time");
            return Err(Error::new(Code::WrongUnit, message)
                .with_hint("--stamps takes pulse times: state the unit, such as --unit COL=µs"));
        }
    };
    let mut times = vec![0.0; channel.samples.len()];
    channel.samples.read(0, &mut times)?;
    times.iter_mut().for_each(|t| *t *= factor);
    if let Some(row) = times.windows(2).position(|w| w[0] >= w[1]) {
        let message = format!(
            "the pulse times of {name} do not increase at row {}",
            row + 2
        );
        return Err(Error::new(Code::InvalidTimeStamps, message)
            .with_hint("check that this is the column of pulse times, and its unit"));
    }
    Ok(times)
}

/// Angle of a shaft from pulse times; `lines` pulses per revolution.
///
/// # Errors
/// Times that do not increase; missing or extra pulses without `repair`.
pub fn angle_from_pulse_times(
    channel: &Channel,
    lines: usize,
    repair: bool,
    descriptions: &mut Vec<String>,
) -> Result<AngleCurve, Error> {
    let name = &channel.name;
    let times = pulse_times(channel)?;
    let pulses = number_pulses(&times);
    let missing: usize = pulses.missing.iter().map(|m| m.number).sum();
    if missing + pulses.extra_pulses_s.len() > 0 && !repair {
        return Err(missing_lines_error(name, &pulses, missing, lines));
    }
    descriptions.push(format!(
        "{name}: {} pulses, {lines} per turn{}",
        times.len(),
        match missing + pulses.extra_pulses_s.len() {
            0 => String::new(),
            _ => format!(
                ", {missing} missing and {} extra ones corrected",
                pulses.extra_pulses_s.len()
            ),
        }
    ));
    AngleCurve::from_pulses(&pulses, lines)
}

/// Error of missing lines, with the first time and the position on the disc if it is always the same.
fn missing_lines_error(name: &str, tacho: &TachoPulses, missing: usize, lines: usize) -> Error {
    let next = |time: f64| tacho.pulses.iter().find(|p: &&TachoPulse| p.time_s >= time);
    let positions: Vec<usize> = tacho
        .missing
        .iter()
        .filter_map(|m| next(m.after_s))
        .map(|p| p.index % lines.max(1))
        .collect();
    let is_same = positions.len() > 1 && positions.iter().all(|p| *p == positions[0]);
    let place = match (tacho.missing.first(), tacho.extra_pulses_s.first()) {
        (Some(m), _) => format!("the first after {:.6} s", m.after_s),
        (None, Some(t)) => format!("the first at {t:.6} s"),
        (None, None) => String::new(),
    };
    let disc = match is_same {
        true => format!("; always behind line {} of the disc", positions[0] + 1),
        false => String::new(),
    };
    let message = format!(
        "{name} has {missing} missing and {} extra pulses, {place}{disc}",
        tacho.extra_pulses_s.len()
    );
    Error::new(Code::LostCounts, message)
        .with_hint("pass --repair to correct them from their neighbours")
}

/// Angle of a shaft from two quadrature tracks of `lines` lines per revolution.
///
/// # Errors
/// A single track; those of the decoding.
pub fn angle_from_tracks(
    recording: &Recording,
    tracks: &[&Channel],
    lines: usize,
    descriptions: &mut Vec<String>,
) -> Result<AngleCurve, Error> {
    let [a, b] = tracks else {
        let message = "one shaft has two tracks, the other only one";
        return Err(Error::new(Code::Usage, message)
            .with_hint("name both tracks of both encoders: --input A1,B1 --output A2,B2"));
    };
    let samples = sample_blocks::load_channels(recording, &[a, b], "the decoding of tracks")?;
    let mut edges = quadrature(&samples[0], &samples[1], recording.rate_hz)?;
    if edges.boundary.last() < edges.boundary.first() {
        // Exchanged tracks count down; the sign of the ratio is not evaluated, so count up.
        edges.boundary.iter_mut().for_each(|c| *c = -*c);
    }
    descriptions.push(format!(
        "{} and {}: tracks with {lines} lines per turn, {} edges{}",
        a.name,
        b.name,
        edges.time_s.len(),
        match edges.ambiguous_edges {
            0 => String::new(),
            n => format!(", {n} closer than two samples"),
        }
    ));
    edges.angle_curve(lines)
}

/// Angles sampled at a constant rate.
pub struct UniformAngles {
    /// Times of the rows.
    pub timing: RowTiming,
    /// Angles of input and output, rad.
    pub angles: [Vec<f64>; 2],
}

/// Samples both angles at a constant rate, with as many rows as the coarser encoder has points.
///
/// # Errors
/// No common time range; fewer than two pulses.
pub fn resample_uniform(a: &AngleCurve, b: &AngleCurve) -> Result<UniformAngles, Error> {
    let ((a0, a1), (b0, b1)) = (a.time_range_s(), b.time_range_s());
    let (from, to) = (a0.max(b0), a1.min(b1));
    if !(to > from) {
        return Err(Error::new(
            Code::TooShort,
            "the two encoders were not read at the same time",
        )
        .with_hint("both columns must have the same time origin"));
    }
    let count = a.points_within(from, to).min(b.points_within(from, to));
    if count < 2 {
        return Err(
            Error::new(Code::TooShort, "an encoder has fewer than two pulses")
                .with_hint("check the columns named"),
        );
    }
    let rate = (count - 1) as f64 / (to - from);
    let sample = |curve: &AngleCurve| -> Vec<f64> {
        (0..count)
            .map(|i| curve.angle_at(from + i as f64 / rate))
            .collect()
    };
    Ok(UniformAngles {
        timing: RowTiming {
            from_s: from,
            rate_hz: rate,
        },
        angles: [sample(a), sample(b)],
    })
}

/// Times of the rows of a recording.
#[derive(Clone, Copy)]
pub struct RowTiming {
    /// Time of the first row, s.
    pub from_s: f64,
    /// Row rate, Hz.
    pub rate_hz: f64,
}

/// Index pulses of the channels that the study names; edges in rows.
///
/// # Errors
/// Unknown channels, channels without pulses or times.
pub fn index_signals(
    recordings: EncoderRecordings,
    study: &EncoderStudy,
    timing: RowTiming,
    descriptions: &mut Vec<String>,
) -> Result<[Option<IndexSignal>; 2], Error> {
    let mut signals = [None, None];
    for (k, role) in ["input", "output"].into_iter().enumerate() {
        let (Some(name), Some(recording)) = (&study.index[k], recordings.index[k]) else {
            continue;
        };
        let channel = find_channels(recording, std::slice::from_ref(name))?[0];
        let is_quadrature = [&study.input, &study.output][k].len() == 2;
        let counts = study.lines.map(|l| {
            let lines = [l.0, l.1][k] as f64;
            match () {
                () if study.pulse_times => lines,
                () if is_quadrature => 4.0 * lines,
                () => lines * study.counts_per_line as f64,
            }
        });
        let row = |time_s: f64| (time_s - timing.from_s) * timing.rate_hz;
        let signal = if study.pulse_times {
            let edge = |t: f64| PulseEdge {
                row: row(t),
                rising: true,
            };
            IndexSignal {
                edges: pulse_times(channel)?.into_iter().map(edge).collect(),
                edge_uncertainty: 0.0,
                counts,
            }
        } else {
            index_edges(recording, channel, row, timing, counts)?
        };
        descriptions.push(format!(
            "{role} index {}: {} edges",
            channel.name,
            signal.edges.len()
        ));
        signals[k] = Some(signal);
    }
    Ok(signals)
}

/// Edges of an index signal, whose level between pulses prevails.
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
        let message = format!("{} has no index pulses: {}", channel.name, e.message);
        Error::new(e.code, message)
            .with_hint("check whether this is its channel: `geardyn check LOG`")
    })?;
    let threshold = 0.5 * (levels.low + levels.high);
    let above = samples.iter().filter(|x| **x > threshold).count();
    // A level that is high for most of the time has pulses downward.
    let upward = 2 * above <= samples.len();
    let crossings = level_crossings(samples, recording.rate_hz, levels)?;
    let edge = |e: level_crossings::LevelCrossing| PulseEdge {
        row: row(e.time_s),
        rising: e.rising == upward,
    };
    Ok(IndexSignal {
        edges: crossings.into_iter().map(edge).collect(),
        // An edge shorter than the sample interval lies anywhere between two samples.
        edge_uncertainty: 0.5 * (timing.rate_hz / recording.rate_hz).max(0.0),
        counts,
    })
}
