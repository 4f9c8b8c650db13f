//! Data rows of a text log, parsed in blocks without allocation per row.

mod faults;

mod unparsed_line;

mod plain_rows;

use std::io::Read;

use faults::{HINT_CELLS, RowError};
use unparsed_line::UnparsedLine;

use super::cells::{self, Cell, Separators};
use super::columns::{ColumnPlan, ColumnRole};
use super::encodings::TextEncoding;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::recording::raw::LineNumbers;
use crate::recording::sample_column::SampleColumn;

/// Bytes read at a time.
pub const BLOCK: usize = 1 << 20;

/// The longest line that is taken for a row, bytes.
const MAX_LINE_LEN: usize = 64 << 20;

/// Samples put in order before they go to their columns.
const BATCH_SAMPLES: usize = 64 << 10;

/// Lines named in a report of missing cells.
const MAX_LINES_LISTED: usize = 5;

/// Samples and cell counts of one sink.
#[derive(Debug, Default)]
pub struct ColumnData {
    /// Samples read.
    pub samples: SampleColumn,
    /// Cells that hold no number, overloads included.
    pub missing: usize,
    /// Cells that are an overload word.
    pub overloads: usize,
    /// Cells whose thousands are grouped.
    pub grouped: usize,
    /// The first lines with missing cells.
    pub lines: Vec<usize>,
    /// Rows up to the last that holds a number.
    pub last_row_with_value: usize,
}

/// Data read from the rows.
#[derive(Debug, Default)]
pub struct TableData {
    /// By sink of the plan.
    pub sinks: Vec<ColumnData>,
    /// Rows.
    pub rows: usize,
    /// Line of the file of each row.
    pub lines: LineNumbers,
    /// Rows that hold only a time.
    pub time_only_rows: usize,
    /// Lines after the rows: how many, the number and the text of the first.
    pub footer: Option<(usize, usize, String)>,
    /// The last row, where it breaks off: its line and text.
    pub cut: Option<(usize, String)>,
    /// Lines between the rows that repeat one of the header.
    pub repeated: Vec<usize>,
}

/// Reader of the rows.
pub struct RowReader<'p> {
    path: &'p str,
    plan: &'p mut ColumnPlan,
    marks: Separators,
    coding: TextEncoding,
    body: TableData,
    /// Samples row by row.
    batch: Vec<f64>,
    batch_rows: usize,
    /// Sinks without a number in this row, with what they hold instead.
    gaps: Vec<(usize, Cell)>,
    /// Sinks with grouped thousands in this row.
    groups: Vec<usize>,
    /// A line that is no row: an error if a row follows.
    no_row: Option<UnparsedLine>,
    /// The lines of words above the rows.
    header: Vec<&'p [u8]>,
    line: usize,
}

impl<'p> RowReader<'p> {
    /// A reader of rows below the lines `above`, the first of which is line `line`.
    pub fn new(
        path: &'p str,
        plan: &'p mut ColumnPlan,
        marks: Separators,
        coding: TextEncoding,
        above: &'p [u8],
        line: usize,
    ) -> RowReader<'p> {
        let n = plan.sinks.len();
        let lines = above.split(|b| matches!(b, b'\n' | b'\r'));
        let words = |l: &&[u8]| l.iter().any(u8::is_ascii_alphabetic);
        RowReader {
            path,
            plan,
            marks,
            coding,
            body: TableData {
                sinks: (0..n).map(|_| ColumnData::default()).collect(),
                ..TableData::default()
            },
            batch: Vec::with_capacity(BATCH_SAMPLES + n),
            batch_rows: 0,
            gaps: Vec::new(),
            groups: Vec::new(),
            no_row: None,
            header: lines.map(<[u8]>::trim_ascii).filter(words).collect(),
            line,
        }
    }

    /// Reads all rows: those in `head`, then those of `rest` unless the head is the whole file.
    ///
    /// # Errors
    /// The file cannot be read, a row is ragged, a cell is text.
    pub fn read_all(
        mut self,
        head: &[u8],
        whole: bool,
        rest: &mut dyn Read,
    ) -> Result<TableData, Error> {
        if whole {
            self.lines(head, true)?;
            return self.finish();
        }
        let mut block = head.to_vec();
        let mut filled = block.len();
        let mut step = BLOCK;
        loop {
            if block.len() < filled + step {
                block.resize(filled + step, 0);
            }
            let n = read_full(rest, &mut block[filled..]).map_err(|e| read_error(self.path, &e))?;
            let ended = n < block.len() - filled;
            filled += n;
            let used = self.lines_in_parallel(&block[..filled], ended)?;
            step = plain_rows::block_len();
            if ended {
                return self.finish();
            }
            block.copy_within(used..filled, 0);
            filled -= used;
            if filled > MAX_LINE_LEN {
                return Err(Error::new(
                    Code::CorruptFile,
                    format!(
                        "line {} is longer than {} MB",
                        self.line,
                        MAX_LINE_LEN >> 20
                    ),
                )
                .with_hint("check whether this is a text log with one row a line"));
            }
        }
    }

    /// Takes the complete lines of a block; the last line is complete where the file has ended. Bytes used.
    fn lines(&mut self, block: &[u8], ended: bool) -> Result<usize, Error> {
        let mut at = 0;
        while let Some(length) = memchr::memchr2(b'\n', b'\r', &block[at..]) {
            let end = at + length;
            let mut next = end + 1;
            if block[end] == b'\r' {
                match block.get(next) {
                    Some(b'\n') => next += 1,
                    // The line end may go on in the next block.
                    None if !ended => return Ok(at),
                    _ => {}
                }
            }
            self.line(&block[at..end], true)?;
            at = next;
        }
        if ended && at < block.len() {
            self.line(&block[at..], false)?;
            at = block.len();
        }
        Ok(at)
    }

    /// Takes a line; `ends` where a line end follows.
    fn line(&mut self, line: &[u8], ends: bool) -> Result<(), Error> {
        let number = self.line;
        self.line += 1;
        if line.trim_ascii().is_empty() {
            return Ok(());
        }
        let kept = self.batch.len();
        self.gaps.clear();
        self.groups.clear();
        match self.row(line) {
            Ok(()) => {
                if let Some(before) = self.no_row.take() {
                    return Err(before.error);
                }
                // Beginning of a time stamp, where no other row holds a time alone.
                if !ends && self.body.time_only_rows == 1 && self.is_time_only(kept) {
                    self.batch.truncate(kept);
                    self.body.time_only_rows = 0;
                    self.body.cut = Some((number, self.coding.text(line)));
                    return Ok(());
                }
                self.count_row(number)
            }
            Err(fault) => {
                self.batch.truncate(kept);
                self.no_row(&fault, line, number)
            }
        }
    }

    /// Reads one row to the end of the batch.
    fn row(&mut self, line: &[u8]) -> Result<(), RowError> {
        let blanks = self.marks.delimiter == b' ';
        let end = if blanks {
            line.trim_ascii_end().len()
        } else {
            line.len()
        };
        let line = &line[..end];
        let base = self.batch.len();
        self.batch.resize(base + self.plan.sinks.len(), f64::NAN);
        let mut at = cells::skip_blanks_of(line, 0, self.marks.delimiter);
        let mut column = 0;
        let mut more = true;
        while more {
            let start = at;
            let role = self.plan.roles.get(column).copied();
            let next = match role {
                Some(ColumnRole::Value(sink)) => match self.parse_plain(&line[start..]) {
                    Some((value, length)) => {
                        self.batch[base + sink] = value;
                        start + length
                    }
                    None => self.parse_any(line, start, column, base)?,
                },
                _ => self.parse_any(line, start, column, base)?,
            };
            more = next < line.len();
            at = if blanks {
                cells::skip_blanks(line, next)
            } else {
                next + 1
            };
            column += 1;
        }
        if column < self.plan.required {
            self.short_row(line, column, base)?;
        }
        Ok(())
    }

    /// A plain number up to the next delimiter: its value and length.
    #[inline]
    fn parse_plain(&self, rest: &[u8]) -> Option<(f64, usize)> {
        if self.marks.decimal != b'.' {
            return None;
        }
        let (value, length) = fast_float2::parse_partial::<f64, _>(rest).ok()?;
        let ends = match rest.get(length) {
            None => true,
            Some(b'\t') if self.marks.delimiter == b' ' => true,
            Some(byte) => *byte == self.marks.delimiter,
        };
        (ends && value.is_finite()).then_some((value, length))
    }

    /// A cell of any kind; where it ends.
    fn parse_any(
        &mut self,
        line: &[u8],
        start: usize,
        column: usize,
        base: usize,
    ) -> Result<usize, RowError> {
        let end = cells::cell_end(line, start, self.marks.delimiter);
        let cell = &line[start..end];
        let Some(role) = self.plan.roles.get(column).copied() else {
            return if cells::trim_cell(cell).is_empty() {
                Ok(end)
            } else {
                Err(self.too_many(line, start..end))
            };
        };
        match role {
            ColumnRole::Skip => {}
            ColumnRole::Time(sink, reader) => match self.plan.accumulators[reader].seconds(cell) {
                Ok(Some(seconds)) => self.batch[base + sink] = seconds,
                Ok(None) => self.gaps.push((sink, Cell::Missing)),
                Err(trouble) => return Err(self.invalid_stamp(trouble, sink, cell, start..end)),
            },
            ColumnRole::Value(sink) => match cells::parse_cell(cell, self.marks.decimal) {
                Cell::Number(value) => self.batch[base + sink] = value,
                Cell::Thousands { value, .. } => {
                    self.batch[base + sink] = value;
                    self.groups.push(sink);
                }
                gap @ (Cell::Missing | Cell::Overload) => self.gaps.push((sink, gap)),
                Cell::Complex(..) | Cell::Text => {
                    return Err(self.not_a_number(sink, cell, start..end));
                }
            },
            ColumnRole::Complex(sink) => match cells::parse_cell(cell, self.marks.decimal) {
                Cell::Complex(re, im) => {
                    self.batch[base + sink] = re;
                    self.batch[base + sink + 1] = im;
                }
                Cell::Number(re) => {
                    self.batch[base + sink] = re;
                    self.batch[base + sink + 1] = 0.0;
                }
                gap @ (Cell::Missing | Cell::Overload) => {
                    self.gaps.extend([(sink, gap), (sink + 1, gap)]);
                }
                _ => return Err(self.not_a_number(sink, cell, start..end)),
            },
        }
        Ok(end)
    }

    /// A row with too few cells: right where it holds nothing but a time.
    fn short_row(&mut self, line: &[u8], cells: usize, base: usize) -> Result<(), RowError> {
        let only_time = cells == 1
            && matches!(self.plan.roles.first(), Some(ColumnRole::Time(sink, _)) if self.batch[base + sink].is_finite());
        if !only_time {
            let required = self.plan.required;
            return Err(RowError {
                code: Code::RaggedRow,
                message: format!(
                    "the row has {cells} cells where the rows before it have {required}"
                ),
                span: 0..line.len(),
                label: format!("{cells} cells"),
                hint: HINT_CELLS,
            });
        }
        self.body.time_only_rows += 1;
        for sink in 0..self.plan.sinks.len() {
            if self.plan.sinks[sink].reader.is_none() {
                self.gaps.push((sink, Cell::Missing));
            }
        }
        Ok(())
    }

    /// Whether the row at the end of the batch, from `base` on, holds a time and no value.
    fn is_time_only(&self, base: usize) -> bool {
        let sinks = self.plan.sinks.iter().zip(&self.batch[base..]);
        sinks
            .filter(|(sink, _)| sink.reader.is_none())
            .all(|(_, x)| x.is_nan())
    }

    /// Counts the row that was just read.
    fn count_row(&mut self, line: usize) -> Result<(), Error> {
        self.body.lines.push(self.body.rows, line);
        self.body.rows += 1;
        self.batch_rows += 1;
        for &(sink, what) in &self.gaps {
            let filled = &mut self.body.sinks[sink];
            filled.missing += 1;
            filled.overloads += usize::from(what == Cell::Overload);
            if filled.lines.len() < MAX_LINES_LISTED {
                filled.lines.push(line);
            }
        }
        for &sink in &self.groups {
            self.body.sinks[sink].grouped += 1;
        }
        if self.batch.len() >= BATCH_SAMPLES {
            self.flush()?;
        }
        Ok(())
    }

    /// Moves the batch to the columns.
    fn flush(&mut self) -> Result<(), Error> {
        let width = self.plan.sinks.len();
        let before = self.body.rows - self.batch_rows;
        let mut samples = Vec::with_capacity(self.batch_rows);
        for (sink, filled) in self.body.sinks.iter_mut().enumerate() {
            samples.clear();
            samples.extend(self.batch.iter().skip(sink).step_by(width));
            if let Some(last) = samples.iter().rposition(|x: &f64| x.is_finite()) {
                filled.last_row_with_value = before + last + 1;
            }
            filled.samples.push(&samples)?;
        }
        self.batch.clear();
        self.batch_rows = 0;
        Ok(())
    }

    fn finish(mut self) -> Result<TableData, Error> {
        self.flush()?;
        if let Some(last) = self.no_row.take() {
            match last.is_cut {
                true => self.body.cut = Some((last.line, last.text)),
                false => self.body.footer = Some((last.count, last.line, last.text)),
            }
        }
        Ok(self.body)
    }
}

/// Reads until the block is full or the file ends.
pub fn read_full(reader: &mut dyn Read, block: &mut [u8]) -> std::io::Result<usize> {
    let mut filled = 0;
    while filled < block.len() {
        match reader.read(&mut block[filled..]) {
            Ok(0) => break,
            Ok(n) => filled += n,
            Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(filled)
}

/// The error of a stream that ends or breaks within.
pub fn read_error(path: &str, why: &std::io::Error) -> Error {
    Error::new(
        Code::CorruptFile,
        format!("{path} cannot be read to its end: {why}"),
    )
    .with_hint("the file was cut off or damaged: copy it again from where it was recorded")
}
