//! Preprocessing of a raw log into a `Recording`: sample rate, gaps, jitter, cropping, calibration.

use std::ops::Range;

pub use channels::unknown_channel;

use super::calibrate::Calibration;
use super::raw::{RawChannel, RawLog, Repair};
use super::read_options::{GapPolicy, RateSource, ReadOptions};
use super::sample_column::SampleColumn;
use super::signals::{Channel, LogFile, Recording};
use super::time_base::{self, TimeBase};
use crate::base::error::{Diagnostic, Error};
use crate::base::source_span::SourceSpan;

mod channels;

mod gaps;

mod jitter;

mod crop;

mod rate;

/// Block length of reads and writes, samples.
const BLOCK: usize = 1 << 16;

/// Largest distance from the grid of samples for a position on the grid, sample intervals.
const GRID_TOLERANCE: f64 = 1e-3;

/// Determines the time base of a log, splits or fills gaps, and scales the channels.
///
/// # Errors
/// The rate is missing or contradictory; time stamps are not ascending; a channel does not exist or has another time base; a unit is invalid.
pub fn preprocess(log: RawLog, options: &ReadOptions) -> Result<Recording, Error> {
    let path = log.path.clone();
    preprocess_group(log, options).map_err(|mut e| {
        // Errors of the time base have a line number but no path.
        e.span = e.span.map(|span| match span.source().path.is_empty() {
            true => SourceSpan::whole_line(&path, span.line()),
            false => span,
        });
        e.with_file(&path)
    })
}

fn preprocess_group(mut log: RawLog, options: &ReadOptions) -> Result<Recording, Error> {
    let group = channels::select_channels(&mut log, options)?;
    let calibrations = channels::calibrations(&group.channels, options)?;
    let stamps = group.timing.stamps.as_ref();
    let fitted = stamps.map(|stamps| time_base::fit(&group.timing, stamps));
    // A rate stated by the user needs no time stamps; it is compared with those that can be read.
    let is_stated = matches!(options.rate, Some(RateSource::Hertz(_)));
    let (base, compared) = match is_stated {
        true => (None, fitted.and_then(Result::ok)),
        false => (fitted.transpose()?, None),
    };
    let rate = rate::rate(&group, base.as_ref(), options)?;
    let rate_hz = rate.hertz;
    let compared = base.as_ref().or(compared.as_ref());
    (log.diagnostics).extend(rate::contradicted(&group, compared, rate_hz, options));
    let rows = group.rows();
    let stated = group.timing.header_samples.filter(|&n| n > rows);
    if let Some(stated) = stated
        && !log.diagnostics.iter().any(|w| w.code == "values-missing")
    {
        log.diagnostics.push(Diagnostic {
            code: "values-missing",
            message: format!("the header states {stated} samples, the file contains {rows}"),
            hint: Some("check whether the file was cut off".to_string()),
        });
    }
    if let (Some(_), Some(unread), None) = (&base, &group.timing.invalid_rate, options.rate) {
        log.diagnostics.push(Diagnostic {
            code: "header-rate-unread",
            message: format!("{}; the time stamps give the rate", unread.message),
            hint: None,
        });
    }
    let mut work = Preprocessing {
        rate_hz,
        segments: match &base {
            Some(base) => segments(base, rate_hz),
            None => vec![Segment {
                rows: 0..rows,
                start: 0.0,
            }],
        },
        repairs: std::mem::take(&mut log.repairs),
        diagnostics: std::mem::take(&mut log.diagnostics),
        channels: group.channels,
    };
    if let (Some(base), Some(stamps)) = (&base, &group.timing.stamps) {
        work.report_gaps(base, options);
        work.resample_jitter(base, stamps)?;
    }
    let empty = work.empty_channels()?;
    if let Some(index) = empty
        .iter()
        .position(|e| *e)
        .filter(|_| !options.keep_channels.is_empty())
    {
        let name = &work.channels[index].name;
        return Err(channels::skipped_column_error(
            name,
            "contains no number in any row",
        ));
    }
    work.split_at_missing(&empty)?;
    work.crop(options)?;
    if !options.keep_channels.is_empty() {
        // The trigger channel was read only for its level.
        work.channels.truncate(options.keep_channels.len());
    }
    if options.gaps == GapPolicy::Fill {
        work.interpolate_gaps()?;
    }
    let first_s = group.timing.stamps.as_ref().map_or(0.0, |s| s.first_s);
    work.finish(log, (group.timing.start, first_s), rate, &calibrations)
}

/// Segment of rows without a gap.
struct Segment {
    rows: Range<usize>,
    /// Start of the segment, sample intervals from the first sample of the log.
    start: f64,
}

impl Segment {
    /// Position after the last sample, sample intervals.
    fn end(&self) -> f64 {
        self.start + self.rows.len() as f64
    }

    /// Sub-segment of the given rows.
    fn slice(&self, rows: Range<usize>) -> Segment {
        let start = self.start + (rows.start - self.rows.start) as f64;
        Segment { rows, start }
    }
}

/// Segments of a time base; starts within tolerance of a sample are rounded to it.
fn segments(base: &TimeBase, rate_hz: f64) -> Vec<Segment> {
    let first = base.segment_starts.first().copied().unwrap_or(0.0);
    let position = |start_s: &f64| {
        let position = (start_s - first) * rate_hz;
        match (position - position.round()).abs() < GRID_TOLERANCE {
            true => position.round(),
            false => position,
        }
    };
    (base.segments.iter().zip(&base.segment_starts))
        .map(|(rows, start_s)| Segment {
            rows: rows.clone(),
            start: position(start_s),
        })
        .collect()
}

/// Intermediate state of the preprocessing.
struct Preprocessing {
    rate_hz: f64,
    segments: Vec<Segment>,
    channels: Vec<RawChannel>,
    repairs: Vec<Repair>,
    diagnostics: Vec<Diagnostic>,
}

impl Preprocessing {
    fn push_repair(&mut self, kind: &'static str, message: String) {
        self.repairs.push(Repair { kind, message });
    }

    /// Scales the channels and concatenates the segments.
    fn finish(
        self,
        log: RawLog,
        (start, first_s): (Option<String>, f64),
        rate: rate::Rate,
        calibrations: &[Calibration],
    ) -> Result<Recording, Error> {
        let mut channels = Vec::new();
        for (channel, calibration) in self.channels.into_iter().zip(calibrations) {
            let overloads = channel.overloads;
            let is_complete =
                matches!(&self.segments[..], [single] if single.rows == (0..channel.samples.len()));
            let samples = match is_complete && calibration.factor == 1.0 {
                true => channel.samples,
                false => {
                    let mut scaled = SampleColumn::default();
                    for segment in &self.segments {
                        copy(
                            &channel.samples,
                            segment.rows.clone(),
                            &mut scaled,
                            calibration.factor,
                        )?;
                    }
                    scaled
                }
            };
            channels.push(Channel {
                name: calibration.name.clone(),
                unit: calibration.unit.clone(),
                samples: samples.into(),
                overload_level: calibration.overload,
                overloads,
            });
        }
        let mut end = 0;
        let packed_range = |s: &Segment| {
            let start = end;
            end += s.rows.len();
            start..end
        };
        let segments: Vec<Range<usize>> = self.segments.iter().map(packed_range).collect();
        Ok(Recording {
            path: log.path.clone(),
            dialect: log.dialect,
            metadata: log.metadata,
            rate_hz: self.rate_hz,
            rate_std: rate.std,
            rate_source: rate.source,
            samples: end,
            segments,
            segment_starts: self.segments.iter().map(|s| s.start).collect(),
            start,
            files: vec![LogFile {
                path: log.path.clone(),
                samples: 0..end,
                first_s,
            }],
            channels,
            repairs: self.repairs,
            diagnostics: self.diagnostics,
        })
    }
}

/// Appends rows of one column to another, multiplied by a factor.
fn copy(
    from: &SampleColumn,
    rows: Range<usize>,
    to: &mut SampleColumn,
    factor: f64,
) -> Result<(), Error> {
    let mut block = vec![0.0; BLOCK.min(rows.len())];
    let mut row = rows.start;
    while row < rows.end {
        let count = BLOCK.min(rows.end - row);
        from.read(row, &mut block[..count])?;
        block[..count].iter_mut().for_each(|x| *x *= factor);
        to.push(&block[..count])?;
        row += count;
    }
    Ok(())
}
