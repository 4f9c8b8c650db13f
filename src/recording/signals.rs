//! Channels with units on a uniform time base: what every analysis of a log starts from.

use std::ops::Range;

use super::column::Column;
use super::raw::Repair;
use crate::base::error::Warning;

/// Channels on a uniform time base.
#[derive(Debug)]
pub struct Recording {
    /// The file, as the user named it.
    pub path: String,
    /// Format and dialect in words.
    pub dialect: String,
    /// What the header says beside, as written.
    pub facts: Vec<(String, String)>,
    /// Samples a second, Hz.
    pub rate_hz: f64,
    /// Where the rate comes from, in words: `by regression over 12 403 stamps`.
    pub rate_source: String,
    /// Samples of every channel.
    pub samples: usize,
    /// Stretches without a gap, in samples, rising; at least one.
    pub stretches: Vec<Range<usize>>,
    /// Where each stretch begins, in steps of 1/rate from the log's first sample; whole but where a gap is not.
    pub starts: Vec<f64>,
    /// Date and time of the log's first sample as written.
    pub start: Option<String>,
    /// The channels.
    pub channels: Vec<Channel>,
    /// Everything done to the data.
    pub repairs: Vec<Repair>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// One channel in the unit it is analysed in.
#[derive(Debug)]
pub struct Channel {
    /// Its name.
    pub name: String,
    /// Its unit as shown; empty where unknown.
    pub unit: String,
    /// Samples in that unit; finite inside every stretch.
    pub samples: Column,
    /// Samples at or beyond this size are overloads, where somebody said so.
    pub overload_level: Option<f64>,
    /// Cells that held an overload word.
    pub overloads: usize,
}

impl Recording {
    /// A channel by its name.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|c| c.name == name)
    }

    /// When sample `at` of stretch `stretch` was taken, s from the log's first sample.
    pub fn time_s(&self, stretch: usize, at: usize) -> f64 {
        (self.starts[stretch] + at as f64) / self.rate_hz
    }

    /// Time that the samples cover, without the gaps, s.
    pub fn duration_s(&self) -> f64 {
        self.samples as f64 / self.rate_hz
    }
}
