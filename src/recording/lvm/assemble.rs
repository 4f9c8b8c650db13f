//! Conversion of LVM segments into channel groups and spectra.

use super::header::LvmChannel;
use super::rows::{ColumnReader, LvmSegment};
use crate::base::error::{Diagnostic, Error};
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::numeric::Complex;
use crate::recording::frequency_responses::StoredSpectrum;
use crate::recording::raw::{
    ChannelGroup, LineNumbers, RawChannel, RawLog, RawTiming, Repair, TimeStamps,
    rate_from_interval,
};
use crate::recording::read_options::ReadOptions;
use crate::recording::resolution::Resolution;
use crate::recording::sample_column::SampleColumn;
use crate::recording::stated_rates::StatedRate;

/// Parts of LabVIEW's own names of transformed channels.
const SPECTRUM_NAMES: &[&str] = &[
    "(FFT",
    "(Power Spectrum",
    "(PSD",
    "(Power Spectral Density",
    "(Magnitude",
];

/// Segments closer than this to the end of the one before follow it without a gap, in steps.
const MAX_SEAM_STEPS: f64 = 0.5;

/// Rounding of LabVIEW's clock stamps, s.
const TIMESTAMP_RESOLUTION_S: f64 = 1e-6;

/// Channels of one segment with one abscissa.
struct SegmentChannels {
    channels: Vec<(LvmChannel, ColumnReader)>,
    /// Abscissas of the rows as written, where there are any.
    x: Option<Vec<f64>>,
    resolution: f64,
    length: usize,
}

/// Turns the segments into groups and spectra.
pub(super) fn assemble(
    segments: Vec<LvmSegment>,
    options: &ReadOptions,
    log: &mut RawLog,
) -> Result<(), Error> {
    let scale = match options.time_unit.as_deref() {
        None => 1.0,
        Some(unit) => {
            quantity::parse(&format!("1 {unit}"), QuantityKind::Time, "the unit of time")?
        }
    };
    let mut parts = Vec::new();
    for (at, mut segment) in segments.into_iter().enumerate() {
        report_comments(&mut segment, at, log);
        let lines = segment.lines.clone();
        let mut pieces = Vec::new();
        for piece in split_by_abscissa(segment, log)? {
            match piece
                .channels
                .iter()
                .any(|(channel, _)| is_spectrum(channel))
            {
                true => push_spectra(piece, log)?,
                false => pieces.push(piece),
            }
        }
        if !pieces.is_empty() {
            parts.push((pieces, lines));
        }
    }
    if let Some(offsets) = segment_offsets(&parts, scale) {
        let lines = parts
            .iter()
            .map(|(_, lines)| lines.clone())
            .collect::<Vec<_>>();
        return join_segments(
            parts.into_iter().map(|(pieces, _)| pieces).collect(),
            &offsets,
            scale,
            &lines,
            log,
        );
    }
    let many = parts.len() > 1;
    for (at, (pieces, lines)) in parts.into_iter().enumerate() {
        for mut piece in pieces {
            if many {
                for (channel, _) in &mut piece.channels {
                    channel.name = format!("{} (segment {})", channel.name, at + 1);
                }
            }
            let mut group = start_group(&piece, scale);
            group.timing.lines = lines.clone();
            if let Some(x) = &piece.x {
                let first = x.first().copied().unwrap_or(0.0);
                let seconds: Vec<f64> = x.iter().map(|x| (x - first) * scale).collect();
                group.timing.stamps = Some(time_stamps(&seconds, piece.resolution * scale));
            }
            group.channels = piece.channels.into_iter().map(channel).collect();
            log.groups.push(group);
        }
    }
    Ok(())
}

fn report_comments(segment: &mut LvmSegment, at: usize, log: &mut RawLog) {
    for (row, comment) in segment.comments.drain(..) {
        let place = format!("comment, segment {}, row {}", at + 1, row + 1);
        log.metadata.push((place, comment));
    }
    if segment.comments_left_out > 0 {
        let more = format!("and {} more", segment.comments_left_out);
        log.metadata.push(("comments".to_string(), more));
    }
}

/// Groups the channels of a segment by abscissa and length; channels without any number are passed over.
fn split_by_abscissa(segment: LvmSegment, log: &mut RawLog) -> Result<Vec<SegmentChannels>, Error> {
    let rows = segment.rows;
    let mut abscissas = Vec::new();
    for mut series in segment.abscissas {
        // A blank abscissa of a channel that has ended is no missing stamp.
        series.mark_blanks_missing()?;
        abscissas.push((read_all(&series.column)?, series.resolution));
    }
    let mut pieces: Vec<SegmentChannels> = Vec::new();
    for (at, (channel, mut samples)) in segment
        .channels
        .into_iter()
        .zip(segment.samples)
        .enumerate()
    {
        let held = rows - samples.blanks;
        if held == 0 {
            log.repairs.push(Repair {
                kind: "channel-empty",
                message: format!("channel `{}` holds no number and is left out", channel.name),
            });
            log.skipped_columns
                .push((channel.name, "holds no number in any row"));
            continue;
        }
        if channel.samples != Some(held) {
            samples.mark_blanks_missing()?;
        }
        let length = samples.column.len();
        let abscissa = abscissas.get(if abscissas.len() > 1 { at } else { 0 });
        let x = abscissa.and_then(|(x, _)| x.get(..length));
        let kin = pieces.iter_mut().find(|piece| {
            piece.length == length
                && piece.x.as_deref() == x
                && piece.channels.first().is_some_and(|(other, _)| {
                    other.delta_x == channel.delta_x && other.x0 == channel.x0
                })
        });
        match kin {
            Some(piece) => piece.channels.push((channel, samples)),
            None => pieces.push(SegmentChannels {
                channels: vec![(channel, samples)],
                x: x.map(<[f64]>::to_vec),
                resolution: abscissa.map_or(0.0, |(_, resolution)| *resolution),
                length,
            }),
        }
    }
    Ok(pieces)
}

fn read_all(column: &SampleColumn) -> Result<Vec<f64>, Error> {
    let mut values = vec![0.0; column.len()];
    column.read(0, &mut values)?;
    Ok(values)
}

/// By the dimension of its abscissa, or by the name LabVIEW gives a transformed channel.
fn is_spectrum(channel: &LvmChannel) -> bool {
    channel.x_dimension == "Frequency"
        || SPECTRUM_NAMES
            .iter()
            .any(|word| channel.name.contains(word))
}

fn push_spectra(piece: SegmentChannels, log: &mut RawLog) -> Result<(), Error> {
    for (channel, series) in &piece.channels {
        let values = read_all(&series.column)?;
        let step = channel.delta_x.unwrap_or(f64::NAN);
        let even = || {
            (0..values.len())
                .map(|k| channel.x0 + k as f64 * step)
                .collect()
        };
        if channel.x_dimension != "Frequency" {
            log.diagnostics.push(Diagnostic {
                code: "taken-as-spectrum",
                message: format!(
                    "channel `{}` is a spectrum by its name, though the header says X_Dimension {}; its abscissa is taken in Hz",
                    channel.name, channel.x_dimension
                ),
                hint: None,
            });
        }
        log.spectra.push(StoredSpectrum {
            name: channel.name.clone(),
            unit: channel.unit.clone(),
            kind: "spectrum",
            // Magnitudes are never negative, their logarithms mostly are.
            is_decibel: values.iter().any(|&v| v < 0.0) && !channel.name.contains("Phase"),
            frequency_hz: piece.x.clone().unwrap_or_else(even),
            values: values.iter().map(|&v| Complex::new(v, 0.0)).collect(),
        });
    }
    Ok(())
}

/// When each segment begins, s from the first, where the segments have the same channels and follow each other in time;
/// a segment that begins where the one before ends does so exactly.
fn segment_offsets(parts: &[(Vec<SegmentChannels>, LineNumbers)], scale: f64) -> Option<Vec<f64>> {
    let first = &parts.first()?.0;
    if parts.len() < 2 {
        return None;
    }
    let layout = |pieces: &[SegmentChannels]| -> Vec<Vec<(String, String, Option<f64>)>> {
        let key = |(c, _): &(LvmChannel, ColumnReader)| (c.name.clone(), c.unit.clone(), c.delta_x);
        pieces
            .iter()
            .map(|piece| piece.channels.iter().map(key).collect())
            .collect()
    };
    let channel = |pieces: &[SegmentChannels]| {
        pieces
            .first()
            .and_then(|piece| piece.channels.first().map(|(c, _)| c.clone()))
    };
    let known = layout(first);
    let start = start_time_s(&channel(first)?)?;
    let mut offsets = Vec::new();
    let mut end: Option<(f64, f64)> = None;
    for (pieces, _) in parts {
        if layout(pieces) != known {
            return None;
        }
        let (piece, channel) = (pieces.first()?, channel(pieces)?);
        let mut offset = start_time_s(&channel)? - start;
        let step = channel.delta_x? * scale;
        let (begin, last) = match &piece.x {
            Some(x) => (x.first()? * scale, x.last()? * scale),
            None => (
                channel.x0 * scale,
                channel.x0 * scale + (piece.length - 1) as f64 * step,
            ),
        };
        if let Some((previous, step)) = end {
            let jump = offset + begin - previous;
            if jump <= 0.0 || jump.is_nan() {
                return None;
            }
            if (jump - step).abs() < MAX_SEAM_STEPS * step {
                offset = previous + step - begin;
            }
        }
        end = Some((offset + last, step));
        offsets.push(offset);
    }
    Some(offsets)
}

/// Date and time of a channel, s from year 0.
fn start_time_s(channel: &LvmChannel) -> Option<f64> {
    let mut date = channel.date.split(['/', '-', '.']).map(str::parse::<i16>);
    let mut next = || date.next()?.ok();
    let (year, month, day) = (
        next()?,
        i8::try_from(next()?).ok()?,
        i8::try_from(next()?).ok()?,
    );
    let date = jiff::civil::Date::new(year, month, day).ok()?;
    let epoch = jiff::civil::Date::new(1904, 1, 1).ok()?; // LabVIEW's own
    let days = date.duration_since(epoch).as_secs() as f64;
    let time = channel.time.replace(',', ".");
    let mut parts = time.split(':').map(str::parse::<f64>);
    let mut next = || parts.next()?.ok();
    let (hours, minutes, seconds) = (next()?, next()?, next()?);
    Some(days + 3600.0 * hours + 60.0 * minutes + seconds)
}

/// One group of all segments for each of their pieces.
fn join_segments(
    parts: Vec<Vec<SegmentChannels>>,
    offsets: &[f64],
    scale: f64,
    lines: &[LineNumbers],
    log: &mut RawLog,
) -> Result<(), Error> {
    let n_segments = parts.len();
    let mut groups: Vec<(ChannelGroup, Vec<f64>, f64)> = Vec::new();
    let mut rows_before = Vec::new();
    for (at, pieces) in parts.into_iter().enumerate() {
        for (place, piece) in pieces.into_iter().enumerate() {
            if groups.len() == place {
                groups.push((start_group(&piece, scale), Vec::new(), 0.0));
                rows_before.push(0);
            }
            let (group, seconds, resolution) = &mut groups[place];
            for row in 0..piece.length {
                if let Some(line) = lines[at].line_of_row(row) {
                    group.timing.lines.push(rows_before[place] + row, line);
                }
            }
            rows_before[place] += piece.length;
            *resolution = resolution.max(piece.resolution * scale);
            let (x0, step) = piece
                .channels
                .first()
                .map_or((0.0, 0.0), |(c, _)| (c.x0, c.delta_x.unwrap_or(0.0)));
            match &piece.x {
                Some(x) => seconds.extend(x.iter().map(|x| offsets[at] + x * scale)),
                None => seconds.extend(
                    (0..piece.length).map(|i| offsets[at] + (x0 + i as f64 * step) * scale),
                ),
            }
            for (which, member) in piece.channels.into_iter().enumerate() {
                let new = channel(member);
                match group.channels.get_mut(which) {
                    Some(known) => {
                        known.samples.push(&read_all(&new.samples)?)?;
                        known.overloads += new.overloads;
                    }
                    None => group.channels.push(new),
                }
            }
        }
    }
    log.repairs.push(Repair {
        kind: "segments-joined",
        message: format!("{n_segments} segments joined by their date and time"),
    });
    for (mut group, mut seconds, resolution) in groups {
        let first = seconds.first().copied().unwrap_or(0.0);
        seconds.iter_mut().for_each(|t| *t -= first);
        group.timing.header_samples = None;
        group.timing.stamps = Some(time_stamps(
            &seconds,
            resolution.max(TIMESTAMP_RESOLUTION_S),
        ));
        log.groups.push(group);
    }
    Ok(())
}

/// A group with what the header says of its clock, without channels.
fn start_group(piece: &SegmentChannels, scale: f64) -> ChannelGroup {
    let channel = piece.channels.first().map(|(channel, _)| channel);
    let rate = channel
        .and_then(|c| c.delta_x)
        .map(|dx| rate_from_interval(scale * dx));
    let start = channel.map(|c| format!("{} {}", c.date, c.time).trim().to_string());
    ChannelGroup {
        timing: RawTiming {
            stamps: None,
            stated_rates: (rate
                .map(|rate| StatedRate::is_sample_rate(rate, "Delta_X"))
                .into_iter())
            .collect(),
            invalid_rate: None,
            header_samples: channel.and_then(|c| {
                // A first packet longer than the whole file contradicts it; a shorter one does not.
                let packet = c.first_packet.filter(|&packet| packet > piece.length);
                c.samples.or(packet)
            }),
            start: start.filter(|start| !start.is_empty()),
            ..RawTiming::default()
        },
        channels: Vec::new(),
    }
}

fn time_stamps(seconds: &[f64], resolution_s: f64) -> TimeStamps {
    TimeStamps {
        name: "X_Value".to_string(),
        unit: "s".to_string(),
        first: String::new(),
        first_s: 0.0,
        seconds: SampleColumn::from_slice(seconds),
        resolution: Resolution::constant(resolution_s),
    }
}

fn channel((channel, series): (LvmChannel, ColumnReader)) -> RawChannel {
    RawChannel {
        name: channel.name,
        unit: channel.unit,
        samples: series.column,
        overloads: series.overloads,
    }
}
