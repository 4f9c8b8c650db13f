//! `Recording`: channels with units on a uniform time base, in segments without gaps.

use std::ops::Range;
use std::sync::Arc;

use super::raw::Repair;
use super::sample_column::SampleColumn;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error, Errors};

/// Channels sampled on a uniform time base, in segments without gaps.
#[derive(Debug, Clone)]
pub struct Recording {
    /// Path of the file as the user named it.
    pub path: String,
    /// Format and dialect as text.
    pub dialect: String,
    /// Other header entries, as written.
    pub metadata: Vec<(String, String)>,
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Source of the rate, as text: `by regression over 12 403 stamps`.
    pub rate_source: String,
    /// Relative standard deviation of the rate; zero for a stated rate.
    pub rate_std: f64,
    /// Number of samples of every channel.
    pub samples: usize,
    /// Sample ranges of the segments without gaps, ascending; at least one.
    pub segments: Vec<Range<usize>>,
    /// Start of each segment, in steps of 1/rate from the first sample of its file; fractional after a gap of fractional length.
    pub segment_starts: Vec<f64>,
    /// Date and time of the log's first sample as written.
    pub start: Option<String>,
    /// Source files of the samples, in order; empty without files.
    pub files: Vec<LogFile>,
    /// The channels.
    pub channels: Vec<Channel>,
    /// Repairs made to the data.
    pub repairs: Vec<Repair>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Source file with its sample range within a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct LogFile {
    /// Path of the file as the user named it.
    pub path: String,
    /// Sample range within the recording.
    pub samples: Range<usize>,
    /// Time of its first sample as written, s; 0 for dates or without stamps.
    pub first_s: f64,
}

/// Acquisition time of a sample.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleTime {
    /// Path of its source file, if the recording comes from several.
    pub file: Option<String>,
    /// Time by the stamps of that file, s; from its first sample for dates or without stamps.
    pub time_s: f64,
}

/// One channel in the unit of the analysis.
#[derive(Debug, Clone)]
pub struct Channel {
    /// Channel name.
    pub name: String,
    /// Unit; empty if unknown.
    pub unit: String,
    /// Samples in that unit, finite inside every segment, shared by the parts of a recording.
    pub samples: Arc<SampleColumn>,
    /// Magnitude from which samples count as overloads, if stated.
    pub overload_level: Option<f64>,
    /// Number of cells with an overload word.
    pub overloads: usize,
}

impl Channel {
    /// Reads all samples, in the unit of the channel.
    ///
    /// # Errors
    /// Failed reading of the stored samples of a long log.
    pub fn values(&self) -> Result<Vec<f64>, Error> {
        let mut values = vec![0.0; self.samples.len()];
        self.samples.read(0, &mut values)?;
        Ok(values)
    }
}

impl Recording {
    /// Builds a recording from arrays: sampling rate, Hz, and for each channel its name, its unit (`m/s²`, `N`; empty if unknown)
    /// and its samples.
    ///
    /// ```
    /// use geardyn::Recording;
    ///
    /// let rate = 1000.0;
    /// let sine: Vec<f64> = (0..4000).map(|k| (2.0 * 3.14159265 * 50.0 * k as f64 / rate).sin()).collect();
    /// let recording = Recording::from_arrays(rate, &[("ax", "m/s²", &sine)])?;
    /// let spectrum = recording.spectrum(&Default::default())?;
    /// assert_eq!(spectrum.channel_spectra.len(), 1);
    /// # Ok::<(), geardyn::Errors>(())
    /// ```
    ///
    /// # Errors
    /// A rate that is not positive; no samples; channels of different lengths; duplicate names; samples that are not finite.
    pub fn from_arrays(
        rate_hz: f64,
        channels: &[(&str, &str, &[f64])],
    ) -> Result<Recording, Errors> {
        let samples = channels.first().map_or(0, |c| c.2.len());
        check(rate_hz, channels, samples)?;
        let channel = |(name, unit, values): &(&str, &str, &[f64])| Channel {
            name: name.to_string(),
            unit: unit.to_string(),
            samples: Arc::new(SampleColumn::from_slice(values)),
            overload_level: None,
            overloads: 0,
        };
        Ok(Recording {
            path: String::new(),
            dialect: "arrays".to_string(),
            metadata: Vec::new(),
            rate_hz,
            rate_std: 0.0,
            rate_source: "as given".to_string(),
            samples,
            segments: std::iter::once(0..samples).collect(),
            segment_starts: vec![0.0],
            start: None,
            files: Vec::new(),
            channels: channels.iter().map(channel).collect(),
            repairs: Vec::new(),
            diagnostics: Vec::new(),
        })
    }

    /// Finds a channel by name.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|c| c.name == name)
    }

    /// Time of sample `at` of segment `segment`, s from the first sample of the log.
    pub fn time_s(&self, segment: usize, at: usize) -> f64 {
        (self.segment_starts[segment] + at as f64) / self.rate_hz
    }

    /// Acquisition time of sample `at` of the recording, in the time of its source file.
    pub fn sample_time(&self, at: usize) -> SampleTime {
        let before = self.segments.partition_point(|s| s.start <= at);
        let segment = before.saturating_sub(1);
        let start = self.segments.get(segment).map_or(0, |s| s.start);
        let file = self.files.iter().find(|f| f.samples.contains(&at));
        SampleTime {
            file: (file.filter(|_| self.files.len() > 1)).map(|f| f.path.clone()),
            time_s: file.map_or(0.0, |f| f.first_s) + self.time_s(segment, at - start),
        }
    }

    /// Passes the samples of every segment to `visit` in blocks: index of the first sample, samples, whether the block ends its segment.
    ///
    /// # Errors
    /// Failed reading of the samples.
    pub fn each_block(
        &self,
        channel: &Channel,
        mut visit: impl FnMut(usize, &[f64], bool),
    ) -> Result<(), Error> {
        const BLOCK: usize = 1 << 16;
        let mut block = vec![0.0; BLOCK.min(self.samples)];
        for segment in &self.segments {
            let mut at = segment.start;
            while at < segment.end {
                let count = BLOCK.min(segment.end - at);
                channel.samples.read(at, &mut block[..count])?;
                visit(at, &block[..count], at + count == segment.end);
                at += count;
            }
        }
        Ok(())
    }

    /// Duration of the samples without the gaps, s.
    pub fn duration_s(&self) -> f64 {
        self.samples as f64 / self.rate_hz
    }
}

fn check(rate_hz: f64, channels: &[(&str, &str, &[f64])], samples: usize) -> Result<(), Error> {
    if !(rate_hz > 0.0 && rate_hz.is_finite()) {
        let message = format!("sampling rate {rate_hz} Hz is not above zero");
        return Err(Error::new(Code::OutOfRange, message));
    }
    if samples == 0 {
        return Err(Error::new(Code::OutOfRange, "the recording has no samples"));
    }
    for (k, (name, _, values)) in channels.iter().enumerate() {
        if values.len() != samples {
            let message = format!(
                "channel {name} has {} samples, the first channel {samples}",
                values.len()
            );
            return Err(
                Error::new(Code::Conflict, message).with_hint("give channels of equal length")
            );
        }
        if channels[..k].iter().any(|other| other.0 == *name) {
            return Err(Error::new(
                Code::Conflict,
                format!("two channels are called {name}"),
            ));
        }
        if let Some(at) = values.iter().position(|x| !x.is_finite()) {
            let message = format!("sample {at} of channel {name} is {}", values[at]);
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("give the parts between gaps as separate recordings"));
        }
    }
    Ok(())
}
