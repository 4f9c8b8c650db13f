//! Preprocessing of a raw log: sample rate, gaps, jitter, calibration; returns a `Recording`.

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

/// Samples handled at a time.
const BLOCK: usize = 1 << 16;

/// Places closer to a whole step than this are on it.
const GRID_TOLERANCE: f64 = 1e-3;

/// Settles the time base of a log and scales its channels.
///
/// # Errors
/// No rate or contradicting ones, stamps out of order, channels that do not exist or do not share a clock, units without sense.
pub fn preprocess(log: RawLog, options: &ReadOptions) -> Result<Recording, Error> {
    let path = log.path.clone();
    preprocess_group(log, options).map_err(|mut e| {
        // The clock knows the lines of its rows and not whose they are.
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
    let examined = stamps.map(|stamps| time_base::fit(&group.timing, stamps));
    // A stated rate needs no stamps: it is compared with those that can be read.
    let is_stated = matches!(options.rate, Some(RateSource::Hertz(_)));
    let (base, compared) = match is_stated {
        true => (None, examined.and_then(Result::ok)),
        false => (examined.transpose()?, None),
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
            message: format!("the header states {stated} samples, the file holds {rows}"),
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
    let mut settled = Preprocessing {
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
        settled.report_gaps(base, options);
        settled.resample_jitter(base, stamps)?;
    }
    let empty = settled.empty_channels()?;
    if let Some(at) = empty
        .iter()
        .position(|e| *e)
        .filter(|_| !options.keep_channels.is_empty())
    {
        let name = &settled.channels[at].name;
        return Err(channels::skipped_column_error(
            name,
            "holds no number in any row",
        ));
    }
    settled.split_at_missing(&empty)?;
    settled.crop(options)?;
    if !options.keep_channels.is_empty() {
        // The trigger was read for its level alone.
        settled.channels.truncate(options.keep_channels.len());
    }
    if options.gaps == GapPolicy::Fill {
        settled.interpolate_gaps()?;
    }
    let first_s = group.timing.stamps.as_ref().map_or(0.0, |s| s.first_s);
    settled.finish(log, (group.timing.start, first_s), rate, &calibrations)
}

/// Rows without a gap.
struct Segment {
    rows: Range<usize>,
    /// Start of the segment, in steps from the first sample of the log.
    start: f64,
}

impl Segment {
    /// The place after its last sample.
    fn end(&self) -> f64 {
        self.start + self.rows.len() as f64
    }

    /// A part of it.
    fn slice(&self, rows: Range<usize>) -> Segment {
        let start = self.start + (rows.start - self.rows.start) as f64;
        Segment { rows, start }
    }
}

/// The segments of a time base, on whole steps where their stamps are.
fn segments(base: &TimeBase, rate_hz: f64) -> Vec<Segment> {
    let first = base.segment_starts.first().copied().unwrap_or(0.0);
    let place = |start_s: &f64| {
        let place = (start_s - first) * rate_hz;
        match (place - place.round()).abs() < GRID_TOLERANCE {
            true => place.round(),
            false => place,
        }
    };
    let both = base.segments.iter().zip(&base.segment_starts);
    both.map(|(rows, start_s)| Segment {
        rows: rows.clone(),
        start: place(start_s),
    })
    .collect()
}

/// The channels on their way.
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

    /// Scales, and puts the segments end to end.
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
            let whole =
                matches!(&self.segments[..], [one] if one.rows == (0..channel.samples.len()));
            let samples = match whole && calibration.factor == 1.0 {
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
        let mut at = 0;
        let packed = |s: &Segment| {
            let start = at;
            at += s.rows.len();
            start..at
        };
        let stretches: Vec<Range<usize>> = self.segments.iter().map(packed).collect();
        Ok(Recording {
            path: log.path.clone(),
            dialect: log.dialect,
            metadata: log.metadata,
            rate_hz: self.rate_hz,
            rate_std: rate.std,
            rate_source: rate.source,
            samples: at,
            segments: stretches,
            segment_starts: self.segments.iter().map(|s| s.start).collect(),
            start,
            files: vec![LogFile {
                path: log.path.clone(),
                samples: 0..at,
                first_s,
            }],
            channels,
            repairs: self.repairs,
            diagnostics: self.diagnostics,
        })
    }
}

/// Appends a segment of one column to another, times a factor.
fn copy(
    from: &SampleColumn,
    rows: Range<usize>,
    to: &mut SampleColumn,
    factor: f64,
) -> Result<(), Error> {
    let mut block = vec![0.0; BLOCK.min(rows.len())];
    let mut at = rows.start;
    while at < rows.end {
        let count = BLOCK.min(rows.end - at);
        from.read(at, &mut block[..count])?;
        block[..count].iter_mut().for_each(|x| *x *= factor);
        to.push(&block[..count])?;
        at += count;
    }
    Ok(())
}
