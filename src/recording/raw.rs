//! Log file as written: values, units and time stamps before any repair.

use super::frequency_responses::{FrequencyResponses, StoredSpectrum};
use super::geometry::Geometry;
use super::resolution::Resolution;
use super::sample_column::SampleColumn;
use super::stated_rates::StatedRate;
use crate::base::error::{Diagnostic, Error};

/// Contents of one log file as interpreted by a reader.
#[derive(Debug, Default)]
pub struct RawLog {
    /// Path of the file as the user named it.
    pub path: String,
    /// Format and dialect as text: `CSV, semicolon, decimal comma, Latin-1, 3 header lines`.
    pub dialect: String,
    /// Layout of a text file, reusable as options.
    pub text_dialect: TextDialect,
    /// Header entries other than channels and rate, as written: date, operator, instrument.
    pub metadata: Vec<(String, String)>,
    /// Channels, grouped by their common clock; usually one group.
    pub groups: Vec<ChannelGroup>,
    /// Columns that are not channels: name and reason (`holds words`).
    pub skipped_columns: Vec<(String, &'static str)>,
    /// Frequency responses, if the file holds any.
    pub responses: Option<FrequencyResponses>,
    /// Spectra of the file.
    pub spectra: Vec<StoredSpectrum>,
    /// Test geometry of the file: points, lines and channels.
    pub geometry: Geometry,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// Parts skipped or changed on reading: footer lines, cells without a number.
    pub repairs: Vec<Repair>,
}

/// Layout of a text file; all fields are `None` for other formats.
#[derive(Debug, Default)]
pub struct TextDialect {
    /// Delimiter between cells; `None` for a single column.
    pub delimiter: Option<char>,
    /// Decimal mark, `.` or `,`.
    pub decimal: Option<char>,
    /// Encoding, as a label of the encoding standard.
    pub encoding: Option<String>,
    /// Number of lines above the first line of numbers.
    pub header_lines: Option<usize>,
}

/// Channels sampled by one clock.
#[derive(Debug, Default)]
pub struct ChannelGroup {
    /// Timing information of the file.
    pub timing: RawTiming,
    /// Channels, of equal length.
    pub channels: Vec<RawChannel>,
}

impl ChannelGroup {
    /// Number of samples of each channel.
    pub fn rows(&self) -> usize {
        self.channels.first().map_or(0, |c| c.samples.len())
    }
}

/// One channel as written.
#[derive(Debug, Default)]
pub struct RawChannel {
    /// Channel name; by default from the column number (`column 3`).
    pub name: String,
    /// Unit as written; empty if the file states none.
    pub unit: String,
    /// Values as written; NaN for cells that are blank, `NaN` or an overload word.
    pub samples: SampleColumn,
    /// Number of cells with an overload word.
    pub overloads: usize,
}

/// Timing information of a file for the clock of a channel group.
#[derive(Debug, Default)]
pub struct RawTiming {
    /// Time stamps of the rows, if any.
    pub stamps: Option<TimeStamps>,
    /// Sample rates stated by the file.
    pub stated_rates: Vec<StatedRate>,
    /// Error of a stated sample rate that cannot be read.
    pub invalid_rate: Option<Error>,
    /// Number of samples stated by the header.
    pub header_samples: Option<usize>,
    /// Date and time of the first sample as written.
    pub start: Option<String>,
    /// Line number of each row.
    pub lines: LineNumbers,
    /// Line numbers of repeated header lines between the rows.
    pub repeated_header: Vec<usize>,
}

/// Converts a sample interval, s, to a sample rate, Hz, rounded to an integer within the rounding error of the division.
pub(super) fn rate_from_interval(step_s: f64) -> f64 {
    /// Rounding of the division, and of the decimal step to binary.
    const ROUNDING: f64 = 4.0 * f64::EPSILON;
    let rate = step_s.recip();
    match (rate - rate.round()).abs() <= ROUNDING * rate {
        true => rate.round(),
        false => rate,
    }
}

/// Time stamps of the rows.
#[derive(Debug, Default)]
pub struct TimeStamps {
    /// Name of the column.
    pub name: String,
    /// Unit as written, or `date-time`.
    pub unit: String,
    /// First stamp as written in a text file.
    pub first: String,
    /// First stamp, s; 0 for dates and times of day.
    pub first_s: f64,
    /// Time since the first stamp, s.
    pub seconds: SampleColumn,
    /// Resolution of the stamps, given by the last digit written.
    pub resolution: Resolution,
}

/// Line number of each row of a text file, stored as runs (row, line) of consecutive lines.
#[derive(Debug, Clone, Default)]
pub struct LineNumbers(Vec<(usize, usize)>);

impl LineNumbers {
    /// Appends row `row` (from 0) on line `line` (from 1), in ascending order of rows.
    pub fn push(&mut self, row: usize, line: usize) {
        let expected = self.0.last().map(|&(r, l)| l + (row - r));
        if expected != Some(line) {
            self.0.push((row, line));
        }
    }

    /// Appends the rows of `part`, offset by `rows` rows and `lines` lines.
    pub fn append(&mut self, part: &LineNumbers, rows: usize, lines: usize) {
        for &(row, line) in &part.0 {
            self.push(rows + row, lines + line);
        }
    }

    /// Line number of a row; `None` for binary files.
    pub fn line_of_row(&self, row: usize) -> Option<usize> {
        let run = self.0.partition_point(|&(r, _)| r <= row).checked_sub(1)?;
        self.0.get(run).map(|&(r, l)| l + (row - r))
    }
}

/// A change made to the data, included in every report.
#[derive(Debug, Clone, PartialEq)]
pub struct Repair {
    /// Kind: `resampled`, `gap-split`, `gap-filled`, `cells-missing`, `footer-skipped`, `detrended`, `decimated`.
    pub kind: &'static str,
    /// Description of the change with its place and error.
    pub message: String,
}
