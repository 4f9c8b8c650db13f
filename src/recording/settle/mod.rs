//! A log as written becomes channels on a uniform time base: rate decided, gaps split or filled, jitter resampled, sensors scaled.

use std::ops::Range;

pub use channels::no_channel;

use super::calibrate::Calibration;
use super::column::Column;
use super::raw::{Raw, RawChannel, Repair};
use super::settings::{Gaps, RateSource, Settings};
use super::signals::{Channel, LogFile, Recording};
use super::time_base::{self, TimeBase};
use crate::base::error::{Error, Warning};
use crate::base::place::Place;

mod channels;
mod gaps;
mod jitter;
mod kept;
mod rate;

/// Samples handled at a time.
const BLOCK: usize = 1 << 16;

/// Places closer to a whole step than this are on it.
const WHOLE: f64 = 1e-3;

/// Settles the time base of a log and scales its channels.
///
/// # Errors
/// No rate or contradicting ones, stamps out of order, channels that do not exist or do not share a clock, units without sense.
pub fn settle(raw: Raw, settings: &Settings) -> Result<Recording, Error> {
    let path = raw.path.clone();
    settled(raw, settings).map_err(|mut e| {
        // The clock knows the lines of its rows and not whose they are.
        e.place = e.place.map(|place| match place.source().path.is_empty() {
            true => Place::of_line(&path, place.line()),
            false => place,
        });
        e.in_file(&path)
    })
}

fn settled(mut raw: Raw, settings: &Settings) -> Result<Recording, Error> {
    let group = channels::choose(&mut raw, settings)?;
    let calibrations = channels::calibrations(&group.channels, settings)?;
    let stamps = group.clock.stamps.as_ref();
    let examined = stamps.map(|stamps| time_base::examine(&group.clock, stamps));
    // A stated rate needs no stamps: it is compared with those that can be read.
    let is_stated = matches!(settings.rate, Some(RateSource::Hertz(_)));
    let (base, compared) = match is_stated {
        true => (None, examined.and_then(Result::ok)),
        false => (examined.transpose()?, None),
    };
    let rate = rate::rate(&group, base.as_ref(), settings)?;
    let rate_hz = rate.hertz;
    let compared = base.as_ref().or(compared.as_ref());
    (raw.warnings).extend(rate::contradicted(&group, compared, rate_hz, settings));
    let rows = group.rows();
    let stated = group.clock.header_samples.filter(|&n| n > rows);
    if let Some(stated) = stated
        && !raw.warnings.iter().any(|w| w.code == "values-missing")
    {
        raw.warnings.push(Warning {
            code: "values-missing",
            message: format!("the header states {stated} samples, the file holds {rows}"),
            hint: Some("look whether the file was cut off".to_string()),
        });
    }
    if let (Some(_), Some(unread), None) = (&base, &group.clock.unread_rate, settings.rate) {
        raw.warnings.push(Warning {
            code: "header-rate-unread",
            message: format!("{}; the time stamps give the rate", unread.message),
            hint: None,
        });
    }
    let mut settled = Settled {
        rate_hz,
        stretches: match &base {
            Some(base) => stretches(base, rate_hz),
            None => vec![Stretch {
                rows: 0..rows,
                start: 0.0,
            }],
        },
        repairs: std::mem::take(&mut raw.repairs),
        warnings: std::mem::take(&mut raw.warnings),
        channels: group.channels,
    };
    if let (Some(base), Some(stamps)) = (&base, &group.clock.stamps) {
        settled.say_gaps(base, settings);
        settled.even_out(base, stamps)?;
    }
    let empty = settled.empty_channels()?;
    if let Some(at) = empty
        .iter()
        .position(|e| *e)
        .filter(|_| !settings.only.is_empty())
    {
        let name = &settled.channels[at].name;
        return Err(channels::left_out(name, "holds no number in any row"));
    }
    settled.split_at_missing(&empty)?;
    settled.crop(settings)?;
    if !settings.only.is_empty() {
        // The trigger was read for its level alone.
        settled.channels.truncate(settings.only.len());
    }
    if settings.gaps == Gaps::Fill {
        settled.fill()?;
    }
    settled.finish(raw, group.clock.start, rate, &calibrations)
}

/// Rows without a gap.
struct Stretch {
    rows: Range<usize>,
    /// Where it begins, in steps from the first sample of the log.
    start: f64,
}

impl Stretch {
    /// The place after its last sample.
    fn end(&self) -> f64 {
        self.start + self.rows.len() as f64
    }

    /// A part of it.
    fn part(&self, rows: Range<usize>) -> Stretch {
        let start = self.start + (rows.start - self.rows.start) as f64;
        Stretch { rows, start }
    }
}

/// The stretches of a time base, on whole steps where their stamps are.
fn stretches(base: &TimeBase, rate_hz: f64) -> Vec<Stretch> {
    let first = base.starts.first().copied().unwrap_or(0.0);
    let place = |start_s: &f64| {
        let place = (start_s - first) * rate_hz;
        match (place - place.round()).abs() < WHOLE {
            true => place.round(),
            false => place,
        }
    };
    let both = base.stretches.iter().zip(&base.starts);
    both.map(|(rows, start_s)| Stretch {
        rows: rows.clone(),
        start: place(start_s),
    })
    .collect()
}

/// The channels on their way.
struct Settled {
    rate_hz: f64,
    stretches: Vec<Stretch>,
    channels: Vec<RawChannel>,
    repairs: Vec<Repair>,
    warnings: Vec<Warning>,
}

impl Settled {
    fn repair(&mut self, kind: &'static str, message: String) {
        self.repairs.push(Repair { kind, message });
    }

    /// Scales, and puts the stretches end to end.
    fn finish(
        self,
        raw: Raw,
        start: Option<String>,
        rate: rate::Rate,
        calibrations: &[Calibration],
    ) -> Result<Recording, Error> {
        let mut channels = Vec::new();
        for (channel, calibration) in self.channels.into_iter().zip(calibrations) {
            let overloads = channel.overloads;
            let whole =
                matches!(&self.stretches[..], [one] if one.rows == (0..channel.samples.len()));
            let samples = match whole && calibration.factor == 1.0 {
                true => channel.samples,
                false => {
                    let mut scaled = Column::default();
                    for stretch in &self.stretches {
                        copy(
                            &channel.samples,
                            stretch.rows.clone(),
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
        let packed = |s: &Stretch| {
            let start = at;
            at += s.rows.len();
            start..at
        };
        let stretches: Vec<Range<usize>> = self.stretches.iter().map(packed).collect();
        Ok(Recording {
            path: raw.path.clone(),
            dialect: raw.dialect,
            facts: raw.facts,
            rate_hz: self.rate_hz,
            rate_std: rate.std,
            rate_source: rate.source,
            samples: at,
            stretches,
            starts: self.stretches.iter().map(|s| s.start).collect(),
            start,
            files: vec![LogFile {
                path: raw.path.clone(),
                samples: 0..at,
            }],
            channels,
            repairs: self.repairs,
            warnings: self.warnings,
        })
    }
}

/// Appends a stretch of one column to another, times a factor.
fn copy(from: &Column, rows: Range<usize>, to: &mut Column, factor: f64) -> Result<(), Error> {
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
