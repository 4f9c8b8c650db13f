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

/// Substrings of the names that LabVIEW gives to spectra.
const SPECTRUM_NAMES: &[&str] = &[
    "(FFT",
    "(Power Spectrum",
    "(PSD",
    "(Power Spectral Density",
    "(Magnitude",
];

/// Largest deviation of the start of a segment from the end of the previous one for segments without a gap, sample intervals.
const MAX_SEAM_STEPS: f64 = 0.5;

/// Resolution of the LabVIEW time stamps, s.
const TIMESTAMP_RESOLUTION_S: f64 = 1e-6;

/// Channels of one segment with a common abscissa.
struct SegmentChannels {
    channels: Vec<(LvmChannel, ColumnReader)>,
    /// Abscissa of each row as written; `None` without a column of it.
    x: Option<Vec<f64>>,
    resolution: f64,
    length: usize,
}

/// Converts the segments into channel groups and spectra of the log.
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
    for (index, mut segment) in segments.into_iter().enumerate() {
        report_comments(&mut segment, index, log);
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
    let is_numbered = parts.len() > 1;
    for (index, (pieces, lines)) in parts.into_iter().enumerate() {
        for mut piece in pieces {
            if is_numbered {
                for (channel, _) in &mut piece.channels {
                    channel.name = format!("{} (segment {})", channel.name, index + 1);
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

fn report_comments(segment: &mut LvmSegment, index: usize, log: &mut RawLog) {
    for (row, comment) in segment.comments.drain(..) {
        let key = format!("comment, segment {}, row {}", index + 1, row + 1);
        log.metadata.push((key, comment));
    }
    if segment.comments_left_out > 0 {
        let count_text = format!("and {} more", segment.comments_left_out);
        log.metadata.push(("comments".to_string(), count_text));
    }
}

/// Groups the channels of a segment by abscissa and length; channels without any number are skipped.
fn split_by_abscissa(segment: LvmSegment, log: &mut RawLog) -> Result<Vec<SegmentChannels>, Error> {
    let rows = segment.rows;
    let mut abscissas = Vec::new();
    for mut series in segment.abscissas {
        // The abscissa after the end of a channel is blank, not missing.
        series.mark_blanks_missing()?;
        abscissas.push((read_all(&series.column)?, series.resolution));
    }
    let mut pieces: Vec<SegmentChannels> = Vec::new();
    for (index, (channel, mut samples)) in segment
        .channels
        .into_iter()
        .zip(segment.samples)
        .enumerate()
    {
        let n_values = rows - samples.blanks;
        if n_values == 0 {
            log.repairs.push(Repair {
                kind: "channel-empty",
                message: format!("channel `{}` holds no number and is left out", channel.name),
            });
            log.skipped_columns
                .push((channel.name, "contains no number in any row"));
            continue;
        }
        if channel.samples != Some(n_values) {
            samples.mark_blanks_missing()?;
        }
        let length = samples.column.len();
        let abscissa = abscissas.get(if abscissas.len() > 1 { index } else { 0 });
        let x = abscissa.and_then(|(x, _)| x.get(..length));
        let matching = pieces.iter_mut().find(|piece| {
            piece.length == length
                && piece.x.as_deref() == x
                && piece.channels.first().is_some_and(|(other, _)| {
                    other.delta_x == channel.delta_x && other.x0 == channel.x0
                })
        });
        match matching {
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

/// True if the abscissa is a frequency, or if LabVIEW named the channel as a spectrum.
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
        let uniform = || {
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
            // Magnitudes are not negative; negative values are decibels.
            is_decibel: values.iter().any(|&v| v < 0.0) && !channel.name.contains("Phase"),
            frequency_hz: piece.x.clone().unwrap_or_else(uniform),
            values: values.iter().map(|&v| Complex::new(v, 0.0)).collect(),
        });
    }
    Ok(())
}

/// Start of each segment, s from the first, if the segments have the same channels and succeed each other in time; a start
/// within tolerance of the end of the previous segment is set to that end.
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
    let first_layout = layout(first);
    let start = start_time_s(&channel(first)?)?;
    let mut offsets = Vec::new();
    let mut end: Option<(f64, f64)> = None;
    for (pieces, _) in parts {
        if layout(pieces) != first_layout {
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

/// Date and time of a channel, s from the LabVIEW epoch.
fn start_time_s(channel: &LvmChannel) -> Option<f64> {
    let mut date = channel.date.split(['/', '-', '.']).map(str::parse::<i16>);
    let mut next = || date.next()?.ok();
    let (year, month, day) = (
        next()?,
        i8::try_from(next()?).ok()?,
        i8::try_from(next()?).ok()?,
    );
    let date = jiff::civil::Date::new(year, month, day).ok()?;
    let epoch = jiff::civil::Date::new(1904, 1, 1).ok()?; // epoch of LabVIEW
    let days = date.duration_since(epoch).as_secs() as f64;
    let time = channel.time.replace(',', ".");
    let mut parts = time.split(':').map(str::parse::<f64>);
    let mut next = || parts.next()?.ok();
    let (hours, minutes, seconds) = (next()?, next()?, next()?);
    Some(days + 3600.0 * hours + 60.0 * minutes + seconds)
}

/// Joins the pieces of all segments that correspond to each other into one group each.
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
    for (segment, pieces) in parts.into_iter().enumerate() {
        for (position, piece) in pieces.into_iter().enumerate() {
            if groups.len() == position {
                groups.push((start_group(&piece, scale), Vec::new(), 0.0));
                rows_before.push(0);
            }
            let (group, seconds, resolution) = &mut groups[position];
            for row in 0..piece.length {
                if let Some(line) = lines[segment].line_of_row(row) {
                    group.timing.lines.push(rows_before[position] + row, line);
                }
            }
            rows_before[position] += piece.length;
            *resolution = resolution.max(piece.resolution * scale);
            let (x0, step) = piece
                .channels
                .first()
                .map_or((0.0, 0.0), |(c, _)| (c.x0, c.delta_x.unwrap_or(0.0)));
            match &piece.x {
                Some(x) => seconds.extend(x.iter().map(|x| offsets[segment] + x * scale)),
                None => seconds.extend(
                    (0..piece.length).map(|i| offsets[segment] + (x0 + i as f64 * step) * scale),
                ),
            }
            for (index, column) in piece.channels.into_iter().enumerate() {
                let added = channel(column);
                match group.channels.get_mut(index) {
                    Some(joined) => {
                        joined.samples.push(&read_all(&added.samples)?)?;
                        joined.overloads += added.overloads;
                    }
                    None => group.channels.push(added),
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

/// Group without channels, with the sample interval and start time of the header.
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
                // A first packet longer than the file shows that rows are missing; a shorter one does not.
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
