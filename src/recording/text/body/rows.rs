//! The rows of a piece of the file, up to its end or to the first line that is no row.
//!
//! No row depends on those before it but by its stamps, so that pieces are parsed on several threads.

use super::faults::{HINT_CELLS, RowError};
use super::{ColumnData, MAX_LINES_LISTED, RowReader, line_end_len};
use crate::base::code::Code;
use crate::recording::decimal::{self, Decimal};
use crate::recording::raw::LineNumbers;
use crate::recording::text::cells::{self, Cell};
use crate::recording::text::columns::{ColumnPlan, ColumnRole};
use crate::recording::text::time_stamps::StampParser;

/// Rows from the beginning of a piece, counted from 0 as its lines are. One value serves piece after piece, so that its memory is
/// requested once.
#[derive(Default)]
pub(super) struct Rows {
    /// By sink of the plan.
    pub columns: Vec<ColumnData<Vec<f64>>>,
    pub stamps: Vec<StampParser>,
    /// Rows.
    pub count: usize,
    /// Line of each row.
    pub lines: LineNumbers,
    /// Lines of the rows and blank ones between them.
    pub line_count: usize,
    /// Bytes of these lines.
    pub bytes: usize,
    /// Rows that hold only a time.
    pub time_only: usize,
    /// Error of the line after them, and its length; `None` at the end of the piece.
    pub fault: Option<(RowError, usize)>,
    /// Sinks without a number in the present row, with what they hold instead.
    gaps: Vec<(usize, Cell)>,
    /// Sinks with grouped thousands in the present row.
    groups: Vec<usize>,
}

/// The line at the front of a text, its end found where it is needed: behind a number the next byte tells it.
struct Line<'t> {
    text: &'t [u8],
    length: Option<usize>,
}

impl<'t> Line<'t> {
    fn bytes(&mut self) -> &'t [u8] {
        let text = self.text;
        let find = || memchr::memchr2(b'\n', b'\r', text).unwrap_or(text.len());
        &text[..*self.length.get_or_insert_with(find)]
    }

    /// Whether the line ends at a byte.
    fn ends_at(&self, at: usize) -> bool {
        matches!(self.text.get(at), None | Some(b'\n' | b'\r'))
    }
}

impl RowReader<'_> {
    /// Reads the rows of a piece.
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
                false => match self.row(&mut line, rows) {
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

    /// Reads the row of a line to the end of the columns; its length.
    fn row(&self, line: &mut Line<'_>, rows: &mut Rows) -> Result<usize, RowError> {
        let blanks = self.marks.delimiter == b' ';
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
            if blanks {
                at = cells::skip_blanks(line.text, at);
            }
            if line.ends_at(at) {
                break;
            }
            at += usize::from(!blanks);
        }
        if column < self.plan.required {
            self.short_row(line.bytes(), column, rows)?;
        }
        if column < self.plan.roles.len() {
            let all = rows.count + 1;
            rows.columns
                .iter_mut()
                .for_each(|c| c.samples.resize(all, f64::NAN));
        }
        Ok(at)
    }

    /// A cell that holds a number and nothing but blanks before it: where it ends.
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

    /// A cell of any kind; where it ends.
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
                Err(trouble) => return Err(self.invalid_stamp(trouble, sink, cell, start..end)),
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

    /// A row with too few cells: right where it holds nothing but a time.
    fn short_row(&self, line: &[u8], cells: usize, rows: &mut Rows) -> Result<(), RowError> {
        let time = match self.plan.roles.first() {
            Some(ColumnRole::Time(sink, _)) => rows.columns[*sink].samples.last(),
            _ => None,
        };
        if cells != 1 || !time.is_some_and(|t| t.is_finite()) {
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
        rows.time_only += 1;
        let sinks = self.plan.sinks.iter().enumerate();
        let channels = sinks.filter(|(_, sink)| sink.reader.is_none());
        rows.gaps
            .extend(channels.map(|(at, _)| (at, Cell::Missing)));
        Ok(())
    }
}

impl Rows {
    /// Forgets the piece before.
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
            stamps: plan.accumulators.clone(),
            ..Rows::default()
        };
    }

    /// Counts the row that was just read.
    fn count_row(&mut self) {
        let line = self.line_count;
        self.lines.push(self.count, line);
        self.count += 1;
        for (sink, what) in self.gaps.drain(..) {
            let filled = &mut self.columns[sink];
            filled.missing += 1;
            filled.overloads += usize::from(what == Cell::Overload);
            if filled.lines.len() < MAX_LINES_LISTED {
                filled.lines.push(line);
            }
        }
        for sink in self.groups.drain(..) {
            self.columns[sink].grouped += 1;
        }
    }

    /// Takes back what was read of a line that is no row.
    fn drop_row(&mut self) {
        for column in &mut self.columns {
            column.samples.truncate(self.count);
        }
    }
}
