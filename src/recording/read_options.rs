//! Options for reading a log, from flags or the `[log]` table of a sidecar file; `None`: detected.

use std::path::PathBuf;

use super::geometry::Geometry;
use super::raw::Repair;

/// Options for reading a log. Options that are `None` are found from the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// Layout of the text.
    pub dialect: DialectOptions,
    /// Which rate is trusted.
    pub rate: Option<RateSource>,
    /// The column of time stamps; `Some("none")` where no column is one.
    pub time_column: Option<String>,
    /// Unit of the time stamps, such as `ms`.
    pub time_unit: Option<String>,
    /// Options of single channels.
    pub channels: Vec<ChannelOptions>,
    /// Points, lines and channels of the test.
    pub geometry: Geometry,
    /// Only these channels are kept, in this order; all where empty.
    pub keep_channels: Vec<String>,
    /// Treatment of gaps.
    pub gaps: GapPolicy,
    /// Nothing before this time is kept, s from the first sample.
    pub from_s: Option<f64>,
    /// Nothing from this time on is kept, s from the first sample.
    pub to_s: Option<f64>,
    /// The part used begins where a channel reaches a level.
    pub trigger: Option<Trigger>,
    /// The logs of one test that these settings are for, where a sidecar lists them.
    pub files: Vec<PathBuf>,
    /// The transducer that is at another point in each of these logs.
    pub roving: Option<Roving>,
    /// Sidecar files read for these options, included in every report.
    pub sidecar_reports: Vec<Repair>,
}

/// The transducer that is at another point in every file of a test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Roving {
    /// The force, as of a roving hammer.
    Input,
    /// The sensor of the response.
    Output,
}

/// A level that begins the part of a log that is used.
#[derive(Debug, Clone, PartialEq)]
pub struct Trigger {
    /// The channel.
    pub channel: String,
    /// The size its numbers reach.
    pub level: f64,
    /// Time kept before the trigger, s.
    pub before_s: f64,
}

impl ReadOptions {
    /// The channels to read: those kept, then the one that triggers; all where none is named.
    pub fn channels_to_read(&self) -> Vec<String> {
        let mut read = self.keep_channels.clone();
        let own = self.trigger.iter().map(|t| &t.channel);
        let more: Vec<&String> = own.filter(|t| !read.contains(t)).collect();
        if !read.is_empty() {
            read.extend(more.into_iter().cloned());
        }
        read
    }
}

/// Layout of a text log.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DialectOptions {
    /// Between cells.
    pub delimiter: Option<char>,
    /// `.` or `,`.
    pub decimal: Option<char>,
    /// A label of the encoding standard, such as `latin1`, `gbk`, `utf-16le`.
    pub encoding: Option<String>,
    /// Lines above the first line of numbers.
    pub header_lines: Option<usize>,
    /// Whether `03/04/2023` is the third of April; where the data do not tell.
    pub day_first: Option<bool>,
}

/// Source of the sample rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RateSource {
    /// This, Hz.
    Hertz(f64),
    /// The time stamps.
    TimeStamps,
    /// The rate stated in the header.
    Header,
}

/// Options of one channel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ChannelOptions {
    /// Channel name in the file.
    pub name: String,
    /// Name of the channel after renaming.
    pub rename: Option<String>,
    /// The unit its numbers are in, instead of what the file says.
    pub unit: Option<String>,
    /// Sensitivity of the sensor as text, such as `"100 mV/g"`: numbers in V divided by it are the quantity.
    pub sensitivity: Option<String>,
    /// Numbers at or beyond this size are overloads.
    pub overload: Option<f64>,
}

/// Treatment of samples that are missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GapPolicy {
    /// The recording is divided into segments; averages are taken inside each.
    #[default]
    Split,
    /// Straight lines bridge them, and this is reported.
    Fill,
}
