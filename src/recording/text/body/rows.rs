//! Parser of the data rows in a piece of the file, up to its end or to the first line that is not a row.
//!
//! Rows are independent of earlier rows except for their time stamps, so that pieces are parsed on several threads.

use super::faults::{HINT_CELLS, RowError};
use super::{ColumnData, MAX_LINES_LISTED, RowReader, line_end_len};
use crate::base::code::Code;
use crate::recording::decimal::{self, Decimal};
use crate::recording::raw::LineNumbers;
use crate::recording::text::cells::{self, Cell};
use crate::recording::text::columns::{ColumnPlan, ColumnRole};
use crate::recording::text::time_stamps::StampParser;

/// Parsed rows of a piece; rows and lines are counted from 0 at its start. The value is reused for every piece to keep its
/// allocated memory.
#[derive(Default)]
pub(super) struct Rows {
    /// Samples by sink of the plan.
    pub columns: Vec<ColumnData<Vec<f64>>>,
    pub stamps: Vec<StampParser>,
    /// Number of rows.
    pub count: usize,
    /// Line index of each row.
    pub lines: LineNumbers,
    /// Number of lines, including blank lines between the rows.
    pub line_count: usize,
    /// Length of these lines, bytes.
    pub bytes: usize,
    /// Number of rows that hold only a time.
    pub time_only: usize,
    /// Error of the first line that is not a row and its length, bytes; `None` at the end of the piece.
    pub fault: Option<(RowError, usize)>,
    /// Sinks without a number in the current row, with the content of their cell.
    gaps: Vec<(usize, Cell)>,
    /// Sinks with thousands separators in the current row.
    groups: Vec<usize>,
}

/// Line at the front of a text. Its end is searched only on demand: after a number the next byte shows whether the line ends.
struct Line<'t> {
    text: &'t [u8],
    length: Option<usize>,
}

impl<'t> Line<'t> {
    fn bytes(&mut self) -> &'t [u8] {
        let text = self.text;
        let line_end = || memchr::memchr2(b'\n', b'\r', text).unwrap_or(text.len());
        &text[..*self.length.get_or_insert_with(line_end)]
    }

    /// Whether the line ends at byte `at`.
    fn ends_at(&self, at: usize) -> bool {
        matches!(self.text.get(at), None | Some(b'\n' | b'\r'))
    }
}

impl RowReader<'_> {
    /// Parses a piece into `rows`.
    pub(super) fn parse(&self, piece: &[u8], rows: &mut Rows) {
        rows.restart(self.plan);
        while rows.bytes < piece.len() {
            let mut line = Line {
                text: &piece[rows.bytes..],
                length: None,
            };
            let is_blank = line.text[0] <= b' ' && line.bytes().trim_ascii().is_empty();
            let length = match is_blank {
                true => line.bytes().len(),
                false => match self.parse_row(&mut line, rows) {
                    Ok(length) => {
                        rows.count_row();
                        length
                    }
                    Err(fault) => {
                        rows.drop_row();
                        rows.fault = Some((fault, line.bytes().len()));
                        return;
                    }
                },
            };
            rows.bytes += length + line_end_len(&line.text[length..]);
            rows.line_count += 1;
        }
    }

    /// Parses one row; returns its length, bytes.
    fn parse_row(&self, line: &mut Line<'_>, rows: &mut Rows) -> Result<usize, RowError> {
        let is_blank_delimited = self.marks.delimiter == b' ';
        let mut at = 0;
        let mut column = 0;
        loop {
            let role = self.plan.roles.get(column);
            let start = cells::skip_blanks_of(line.text, at, self.marks.delimiter);
            at = match role.and_then(|role| self.parse_plain(line, start, *role, rows)) {
                Some(next) => next,
                None => self.parse_any(line.bytes(), start, column, rows)?,
            };
            column += 1;
            if is_blank_delimited {
                at = cells::skip_blanks(line.text, at);
            }
            if line.ends_at(at) {
                break;
            }
            at += usize::from(!is_blank_delimited);
        }
        if column < self.plan.required {
            self.check_short_row(line.bytes(), column, rows)?;
        }
        if column < self.plan.roles.len() {
            let row_count = rows.count + 1;
            rows.columns
                .iter_mut()
                .for_each(|c| c.samples.resize(row_count, f64::NAN));
        }
        Ok(at)
    }

    /// Parses a number after optional blanks; returns the end of the cell, `None` for other content.
    #[inline]
    fn parse_plain(
        &self,
        line: &Line<'_>,
        start: usize,
        role: ColumnRole,
        rows: &mut Rows,
    ) -> Option<usize> {
        let blanks = line.text[start..].iter().take_while(|b| **b == b' ');
        let start = start + blanks.count();
        let text = &line.text[start..];
        let is_end = |at: usize| match text.get(at) {
            None | Some(b'\n' | b'\r') => true,
            Some(b'\t') if self.marks.delimiter == b' ' => true,
            Some(byte) => *byte == self.marks.delimiter,
        };
        let (sink, value, length) = match role {
            ColumnRole::Value(sink) => {
                let (value, length) = decimal::parse_prefix(text, self.marks.decimal)?;
                (sink, value, length)
            }
            ColumnRole::Time(sink, reader) if rows.stamps[reader].is_independent() => {
                let (decimal, length) = Decimal::scan(text, self.marks.decimal)?;
                if !is_end(length) {
                    return None;
                }
                (sink, rows.stamps[reader].plain_seconds(decimal)?, length)
            }
            _ => return None,
        };
        if !is_end(length) || !value.is_finite() {
            return None;
        }
        rows.columns[sink].samples.push(value);
        Some(start + length)
    }

    /// Parses a cell of any kind; returns its end.
    fn parse_any(
        &self,
        line: &[u8],
        start: usize,
        column: usize,
        rows: &mut Rows,
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
        let mut push = |sink: usize, value: f64| rows.columns[sink].samples.push(value);
        match role {
            ColumnRole::Skip => {}
            ColumnRole::Time(sink, reader) => match rows.stamps[reader].seconds(cell) {
                Ok(Some(seconds)) => push(sink, seconds),
                Ok(None) => {
                    push(sink, f64::NAN);
                    rows.gaps.push((sink, Cell::Missing));
                }
                Err(error) => return Err(self.invalid_stamp(error, sink, cell, start..end)),
            },
            ColumnRole::Value(sink) => match cells::parse_cell(cell, self.marks.decimal) {
                Cell::Number(value) => push(sink, value),
                Cell::Thousands { value, .. } => {
                    push(sink, value);
                    rows.groups.push(sink);
                }
                gap @ (Cell::Missing | Cell::Overload) => {
                    push(sink, f64::NAN);
                    rows.gaps.push((sink, gap));
                }
                Cell::Complex(..) | Cell::Text => {
                    return Err(self.not_a_number(sink, cell, start..end));
                }
            },
            ColumnRole::Complex(sink) => {
                let (re, im) = match cells::parse_cell(cell, self.marks.decimal) {
                    Cell::Complex(re, im) => (re, im),
                    Cell::Number(re) => (re, 0.0),
                    gap @ (Cell::Missing | Cell::Overload) => {
                        rows.gaps.extend([(sink, gap), (sink + 1, gap)]);
                        (f64::NAN, f64::NAN)
                    }
                    _ => return Err(self.not_a_number(sink, cell, start..end)),
                };
                push(sink, re);
                push(sink + 1, im);
            }
        }
        Ok(end)
    }

    /// Accepts a row with too few cells only if its one cell is a time.
    fn check_short_row(&self, line: &[u8], cells: usize, rows: &mut Rows) -> Result<(), RowError> {
        let time = match self.plan.roles.first() {
            Some(ColumnRole::Time(sink, _)) => rows.columns[*sink].samples.last(),
            _ => None,
        };
        if cells != 1 || !time.is_some_and(|t| t.is_finite()) {
            let required = self.plan.required;
            return Err(RowError {
                code: Code::RaggedRow,
                message: format!("the row has {cells} cells, the rows before it {required}"),
                span: 0..line.len(),
                label: format!("{cells} cells"),
                hint: HINT_CELLS,
            });
        }
        rows.time_only += 1;
        let sinks = self.plan.sinks.iter().enumerate();
        let channels = sinks.filter(|(_, sink)| sink.reader.is_none());
        rows.gaps
            .extend(channels.map(|(at, _)| (at, Cell::Missing)));
        Ok(())
    }
}

impl Rows {
    /// Clears the rows for the next piece.
    fn restart(&mut self, plan: &ColumnPlan) {
        let mut columns = std::mem::take(&mut self.columns);
        columns.resize_with(plan.sinks.len(), ColumnData::default);
        for column in &mut columns {
            let mut samples = std::mem::take(&mut column.samples);
            samples.clear();
            *column = ColumnData {
                samples,
                ..ColumnData::default()
            };
        }
        *self = Rows {
            columns,
            stamps: plan.stamp_parsers.clone(),
            ..Rows::default()
        };
    }

    /// Counts the row just parsed, with its gaps and thousands separators.
    fn count_row(&mut self) {
        let line = self.line_count;
        self.lines.push(self.count, line);
        self.count += 1;
        for (sink, cell) in self.gaps.drain(..) {
            let column = &mut self.columns[sink];
            column.missing += 1;
            column.overloads += usize::from(cell == Cell::Overload);
            if column.lines.len() < MAX_LINES_LISTED {
                column.lines.push(line);
            }
        }
        for sink in self.groups.drain(..) {
            self.columns[sink].grouped += 1;
        }
    }

    /// Discards the samples of a line that is not a row.
    fn drop_row(&mut self) {
        for column in &mut self.columns {
            column.samples.truncate(self.count);
        }
    }
}
