//! Options for reading a log, from flags or from the `[log]` table of a sidecar file.

use std::path::PathBuf;

use super::geometry::Geometry;
use super::raw::Repair;

/// Options for reading a log; options that are `None` are detected from the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// Layout of the text.
    pub dialect: DialectOptions,
    /// Source of the sample rate.
    pub rate: Option<RateSource>,
    /// Column of the time stamps; `Some("none")` for a file without time stamps.
    pub time_column: Option<String>,
    /// Unit of the time stamps, such as `ms`.
    pub time_unit: Option<String>,
    /// Options of individual channels.
    pub channels: Vec<ChannelOptions>,
    /// Geometry of the test: points, lines, channels.
    pub geometry: Geometry,
    /// Selected channels, in this order; all channels if empty.
    pub keep_channels: Vec<String>,
    /// Treatment of gaps.
    pub gaps: GapPolicy,
    /// Start of the analysed part, s from the first sample.
    pub from_s: Option<f64>,
    /// End of the analysed part, s from the first sample.
    pub to_s: Option<f64>,
    /// Trigger that starts the analysed part.
    pub trigger: Option<Trigger>,
    /// Logs of one test to which the options apply, if a sidecar lists them.
    pub files: Vec<PathBuf>,
    /// Transducer that moves from point to point between these logs.
    pub roving: Option<Roving>,
    /// Reports of the sidecar files from which the options were read.
    pub sidecar_reports: Vec<Repair>,
}

/// Roving transducer of a test with several files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Roving {
    /// Force transducer, such as a roving hammer.
    Input,
    /// Response transducer.
    Output,
}

/// Trigger level of a channel that starts the analysed part of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Trigger {
    /// Name of the trigger channel.
    pub channel: String,
    /// Absolute value that the samples reach.
    pub level: f64,
    /// Pre-trigger time, s.
    pub before_s: f64,
}

impl ReadOptions {
    /// Channels to read: the selected channels, then the trigger channel; empty for all channels.
    pub fn channels_to_read(&self) -> Vec<String> {
        let mut names = self.keep_channels.clone();
        let trigger = self.trigger.iter().map(|t| &t.channel);
        let additional: Vec<&String> = trigger.filter(|t| !names.contains(t)).collect();
        if !names.is_empty() {
            names.extend(additional.into_iter().cloned());
        }
        names
    }
}

/// Layout of a text log.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DialectOptions {
    /// Delimiter of the cells.
    pub delimiter: Option<char>,
    /// Decimal mark, `.` or `,`.
    pub decimal: Option<char>,
    /// Label of the Encoding Standard, such as `latin1`, `gbk`, `utf-16le`.
    pub encoding: Option<String>,
    /// Number of lines above the first data row.
    pub header_lines: Option<usize>,
    /// True if `03/04/2023` is 3 April; used for ambiguous dates.
    pub day_first: Option<bool>,
}

/// Source of the sample rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RateSource {
    /// Stated rate, Hz.
    Hertz(f64),
    /// Time stamps.
    TimeStamps,
    /// Rate stated in the header.
    Header,
}

/// Options of one channel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ChannelOptions {
    /// Name of the channel in the file.
    pub name: String,
    /// New name of the channel.
    pub rename: Option<String>,
    /// Unit of the samples, replacing that of the file.
    pub unit: Option<String>,
    /// Sensitivity of the transducer as text, such as `"100 mV/g"`; samples in V are divided by it.
    pub sensitivity: Option<String>,
    /// Overload level: absolute value at or beyond which a sample is an overload.
    pub overload: Option<f64>,
}

/// Treatment of missing samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GapPolicy {
    /// Gaps split the recording into segments; averages use blocks within a segment.
    #[default]
    Split,
    /// Linear interpolation fills the gaps; a repair is reported.
    Fill,
}
