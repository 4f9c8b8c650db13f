//! Log file as written: values, units and time stamps, no repair applied.

use super::frequency_responses::{FrequencyResponses, StoredSpectrum};
use super::geometry::Geometry;
use super::resolution::Resolution;
use super::sample_column::SampleColumn;
use super::stated_rates::StatedRate;
use crate::base::error::{Diagnostic, Error};

/// Contents of one file as interpreted by a reader.
#[derive(Debug, Default)]
pub struct RawLog {
    /// The file, as the user named it.
    pub path: String,
    /// Format and dialect as text: `CSV, semicolon, decimal comma, Latin-1, 3 header lines`.
    pub dialect: String,
    /// Layout of the text, to be reused as options.
    pub text_dialect: TextDialect,
    /// Header entries other than channels and rate, as written: date, operator, instrument.
    pub metadata: Vec<(String, String)>,
    /// Channels, grouped by the clock they share; nearly always one group.
    pub groups: Vec<ChannelGroup>,
    /// Columns that are no channels: their names, and why (`holds words`).
    pub skipped_columns: Vec<(String, &'static str)>,
    /// Frequency responses, where the file holds them.
    pub responses: Option<FrequencyResponses>,
    /// Spectra, where the file holds them.
    pub spectra: Vec<StoredSpectrum>,
    /// Points, lines and channels of the test, where the file holds them.
    pub geometry: Geometry,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// Parts passed over or changed on reading (footer lines, cells that hold no number), never silently.
    pub repairs: Vec<Repair>,
}

/// Layout of a text file; nothing of other formats.
#[derive(Debug, Default)]
pub struct TextDialect {
    /// Between cells; none of a single column.
    pub delimiter: Option<char>,
    /// `.` or `,`.
    pub decimal: Option<char>,
    /// A label of the encoding standard.
    pub encoding: Option<String>,
    /// Lines above the first line of numbers.
    pub header_lines: Option<usize>,
}

/// Channels sampled by one clock.
#[derive(Debug, Default)]
pub struct ChannelGroup {
    /// Timing information stated by the file.
    pub timing: RawTiming,
    /// The channels, of equal length.
    pub channels: Vec<RawChannel>,
}

impl ChannelGroup {
    /// Rows of its channels.
    pub fn rows(&self) -> usize {
        self.channels.first().map_or(0, |c| c.samples.len())
    }
}

/// One channel as written.
#[derive(Debug, Default)]
pub struct RawChannel {
    /// Channel name; made up from the column number where the file has none (`column 3`).
    pub name: String,
    /// Unit as written; empty where the file has none.
    pub unit: String,
    /// Values as written; NaN where a cell is blank, `NaN` or an overload word.
    pub samples: SampleColumn,
    /// Number of cells that were an overload word.
    pub overloads: usize,
}

/// Timing information a file gives for the clock of its channels.
#[derive(Debug, Default)]
pub struct RawTiming {
    /// The stamps of the rows, where there are any.
    pub stamps: Option<TimeStamps>,
    /// Every sample rate that the file states.
    pub stated_rates: Vec<StatedRate>,
    /// Error of the sample rate the header states, where it states one that cannot be read.
    pub invalid_rate: Option<Error>,
    /// Number of samples the header states.
    pub header_samples: Option<usize>,
    /// Date and time of the first sample as written.
    pub start: Option<String>,
    /// Line of the file for each row.
    pub lines: LineNumbers,
    /// Lines between the rows that repeat one of the header.
    pub repeated_header: Vec<usize>,
}

/// The sample rate of a step from sample to sample, Hz; whole where only the rounding of the division keeps it from that.
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
    /// The first stamp as written, where text holds it.
    pub first: String,
    /// The first stamp where stamps are numbers, s; 0 of dates and clocks.
    pub first_s: f64,
    /// Seconds since the first stamp.
    pub seconds: SampleColumn,
    /// Value of the last digit written: stamps are rounded to it.
    pub resolution: Resolution,
}

/// Line of a text file for each row, as runs of consecutive lines.
#[derive(Debug, Clone, Default)]
pub struct LineNumbers(Vec<(usize, usize)>);

impl LineNumbers {
    /// Appends row `row` (from 0), which is on line `line` (from 1); rows in rising order.
    pub fn push(&mut self, row: usize, line: usize) {
        let expected = self.0.last().map(|&(r, l)| l + (row - r));
        if expected != Some(line) {
            self.0.push((row, line));
        }
    }

    /// Appends the rows of `part` behind `rows` rows and `lines` lines.
    pub fn append(&mut self, part: &LineNumbers, rows: usize, lines: usize) {
        for &(row, line) in &part.0 {
            self.push(rows + row, lines + line);
        }
    }

    /// The line of a row; `None` for files that are not text.
    pub fn line_of_row(&self, row: usize) -> Option<usize> {
        let run = self.0.partition_point(|&(r, _)| r <= row).checked_sub(1)?;
        self.0.get(run).map(|&(r, l)| l + (row - r))
    }
}

/// A change made to the data, included in every report.
#[derive(Debug, Clone, PartialEq)]
pub struct Repair {
    /// A word: `resampled`, `gap-split`, `gap-filled`, `cells-missing`, `footer-skipped`, `detrended`, `decimated`.
    pub kind: &'static str,
    /// The change, its place, and the size of its error.
    pub message: String,
}
