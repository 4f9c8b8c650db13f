//! Data rows of one LVM segment, up to a blank line, the next header or the end of the file.

use super::header::{FileHeader, LineReader, LvmChannel, SegmentHeader};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::recording::decimal;
use crate::recording::raw;
use crate::recording::sample_column::SampleColumn;

/// Numbers of a series collected before they are handed on.
const BUFFER_LEN: usize = 1 << 13;

/// Comments kept.
const MAX_COMMENTS: usize = 20;

/// The numbers of one column; blanks at its end are held back, since a shorter channel ends there.
#[derive(Debug, Default)]
pub(super) struct ColumnReader {
    pub column: SampleColumn,
    block: Vec<f64>,
    /// Blank cells since the last number.
    pub blanks: usize,
    /// Coarsest unit of a last digit met.
    pub resolution: f64,
    /// Cells that hold `Inf`, which LabVIEW writes beyond the range.
    pub overloads: usize,
}

impl ColumnReader {
    fn push(&mut self, value: f64) -> Result<(), Error> {
        while self.blanks > 0 {
            self.blanks -= 1;
            self.push_value(f64::NAN)?;
        }
        match value.is_infinite() {
            true => {
                self.overloads += 1;
                self.push_value(f64::NAN)
            }
            false => self.push_value(value),
        }
    }

    fn push_value(&mut self, value: f64) -> Result<(), Error> {
        self.block.push(value);
        if self.block.len() == BUFFER_LEN {
            self.flush()?;
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), Error> {
        self.column.push(&self.block)?;
        self.block.clear();
        Ok(())
    }

    /// Makes the blanks held back missing samples.
    pub fn mark_blanks_missing(&mut self) -> Result<(), Error> {
        while self.blanks > 0 {
            self.blanks -= 1;
            self.push_value(f64::NAN)?;
        }
        self.flush()
    }
}

/// A segment read.
pub(super) struct LvmSegment {
    pub channels: Vec<LvmChannel>,
    /// Numbers by channel.
    pub samples: Vec<ColumnReader>,
    /// Abscissas: one for all channels, one for each, or none.
    pub abscissas: Vec<ColumnReader>,
    pub rows: usize,
    pub lines: raw::LineNumbers,
    /// Row and text of comments.
    pub comments: Vec<(usize, String)>,
    pub comments_left_out: usize,
    pub has_comma: bool,
    /// Line and text of a last row that breaks off.
    pub cut: Option<(usize, String)>,
}

/// Reads the rows below a header.
pub(super) fn read_segment(
    lines: &mut LineReader<'_>,
    file: &FileHeader,
    header: SegmentHeader,
) -> Result<LvmSegment, Error> {
    let count = header.channels.len();
    let n_abscissas = match header.channels.iter().filter_map(|c| c.x_column).max() {
        None => 0,
        Some(0) => 1,
        Some(_) => count,
    };
    let mut segment = LvmSegment {
        samples: (0..count).map(|_| ColumnReader::default()).collect(),
        abscissas: (0..n_abscissas).map(|_| ColumnReader::default()).collect(),
        channels: header.channels,
        rows: 0,
        lines: raw::LineNumbers::default(),
        comments: Vec::new(),
        comments_left_out: 0,
        has_comma: false,
        cut: None,
    };
    let mut cells: Vec<&[u8]> = Vec::new();
    while let Some(line) = lines.peek() {
        let is_blank = line.iter().all(|&b| b == file.separator || b == b' ');
        if is_blank || is_key(line) {
            break;
        }
        let number = lines.number;
        lines.next_line();
        cells.clear();
        cells.extend(line.split(|&b| b == file.separator));
        let at = RowPosition {
            lines,
            number,
            line,
        };
        // A logger that is switched off leaves its last row incomplete; a file of one such row holds nothing.
        let is_last = lines.peek().is_none() && segment.rows > 0;
        if is_last && !segment.holds_all(&cells, &at) {
            segment.cut = Some((number, lines.decode(line)));
            break;
        }
        segment.read_row(&cells, header.columns, &at)?;
    }
    for series in segment.samples.iter_mut().chain(&mut segment.abscissas) {
        series.flush()?;
    }
    Ok(segment)
}

/// A line of the next header: a blank line may be missing above it.
fn is_key(line: &[u8]) -> bool {
    line.starts_with(b"Channels") || line.starts_with(b"***") || line.starts_with(b"Notes")
}

/// Position of a row in the file.
struct RowPosition<'a> {
    lines: &'a LineReader<'a>,
    number: usize,
    line: &'a [u8],
}

impl RowPosition<'_> {
    fn error(&self, code: Code, message: String) -> Error {
        self.lines.error(code, self.number, self.line, message)
    }
}

impl LvmSegment {
    /// A row holds a number or a blank for every channel that has not ended.
    fn holds_all(&self, cells: &[&[u8]], at: &RowPosition<'_>) -> bool {
        self.channels.iter().all(|channel| {
            let ended = channel.samples.is_some_and(|samples| self.rows >= samples);
            let reaches = ended || channel.column < cells.len();
            let own = parse_number(cells, channel.column, &channel.name, at).is_ok();
            let x = channel
                .x_column
                .map(|x| parse_number(cells, x, "X_Value", at));
            reaches && own && x.is_none_or(|x| x.is_ok())
        })
    }

    fn read_row(
        &mut self,
        cells: &[&[u8]],
        columns: usize,
        at: &RowPosition<'_>,
    ) -> Result<(), Error> {
        let row = self.rows;
        for (which, series) in self.abscissas.iter_mut().enumerate() {
            let column = self.channels[which].x_column.unwrap_or(0);
            match parse_number(cells, column, "X_Value", at)? {
                Some((x, comma)) => {
                    self.has_comma |= comma;
                    let cell = cells[column].trim_ascii();
                    series.resolution = series.resolution.max(resolution_of(cell));
                    series.push(x)?;
                }
                None => series.blanks += 1,
            }
        }
        for (channel, series) in self.channels.iter().zip(&mut self.samples) {
            // A row ends early only where the channels that follow have ended before.
            let ended = channel.samples.is_some_and(|samples| row >= samples);
            if channel.column >= cells.len() && !ended {
                return Err(at.error(
                    Code::RaggedRow,
                    format!(
                        "the row has {} cells, but channel `{}` is in column {}",
                        cells.len(),
                        channel.name,
                        channel.column + 1
                    ),
                ));
            }
            match parse_number(cells, channel.column, &channel.name, at)? {
                Some((value, comma)) => {
                    self.has_comma |= comma;
                    series.push(value)?;
                }
                None => series.blanks += 1,
            }
        }
        let comment = cells.get(columns..).unwrap_or_default();
        let comment = comment.iter().find(|cell| !cell.trim_ascii().is_empty());
        match comment {
            Some(comment) if self.comments.len() < MAX_COMMENTS => {
                self.comments
                    .push((row, at.lines.decode(comment.trim_ascii())));
            }
            Some(_) => self.comments_left_out += 1,
            None => {}
        }
        self.lines.push(row, at.number);
        self.rows += 1;
        Ok(())
    }
}

/// The number in a cell, and whether it has a decimal comma; `None` where the cell is blank.
fn parse_number(
    cells: &[&[u8]],
    column: usize,
    name: &str,
    at: &RowPosition<'_>,
) -> Result<Option<(f64, bool)>, Error> {
    let cell = cells.get(column).copied().unwrap_or_default().trim_ascii();
    if cell.is_empty() {
        return Ok(None);
    }
    if let Some(value) = decimal::parse(cell, b'.') {
        return Ok(Some((value, false)));
    }
    match decimal::parse(cell, b',') {
        Some(value) => Ok(Some((value, true))),
        None => {
            let shown: String = String::from_utf8_lossy(cell).chars().take(24).collect();
            Err(at.error(
                Code::NotANumber,
                format!("`{shown}` in channel `{name}` is not a number"),
            ))
        }
    }
}

/// One unit of the last digit of a number as written: 1e-6 for `0.000312`, 1e-11 for `1.953125E-5`.
fn resolution_of(cell: &[u8]) -> f64 {
    let (mantissa, exponent) = match cell.iter().position(|b| matches!(b, b'e' | b'E')) {
        Some(at) => (&cell[..at], &cell[at + 1..]),
        None => (cell, &b"0"[..]),
    };
    let mark = mantissa.iter().position(|b| matches!(b, b'.' | b','));
    let decimals = mark.map_or(0, |at| mantissa.len() - at - 1) as i32;
    let exponent = std::str::from_utf8(exponent).ok();
    let exponent: i32 = exponent.and_then(|e| e.parse().ok()).unwrap_or(0);
    10.0_f64.powi(exponent.saturating_sub(decimals))
}
