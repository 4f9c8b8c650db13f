//! The rows of numbers: a stream in blocks, cells parsed where they stand, no allocation per row.

/// What is wrong with a row.
mod faults;

/// Lines that are no rows.
mod no_row;

use std::io::Read;

use faults::{Fault, MEND};
use no_row::NoRow;

use super::cells::{self, Cell, Marks};
use super::columns::{Plan, Role};
use super::encodings::Coding;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::recording::column::Column;
use crate::recording::raw::Lines;

/// Bytes read at a time.
pub const BLOCK: usize = 1 << 20;

/// The longest line that is taken for a row, bytes.
const LONGEST_LINE: usize = 64 << 20;

/// Samples put in order before they go to their columns.
const BATCH: usize = 64 << 10;

/// Lines named in a report of missing cells.
const NAMED: usize = 5;

/// What came of a sink.
#[derive(Debug, Default)]
pub struct Filled {
    /// Its samples.
    pub samples: Column,
    /// Cells that hold no number, overloads included.
    pub missing: usize,
    /// Cells that are an overload word.
    pub overloads: usize,
    /// Cells whose thousands are grouped.
    pub grouped: usize,
    /// The first lines with missing cells.
    pub lines: Vec<usize>,
    /// Rows up to the last that holds a number.
    pub present: usize,
}

/// What came of the rows.
#[derive(Debug, Default)]
pub struct Body {
    /// By sink of the plan.
    pub sinks: Vec<Filled>,
    /// Rows.
    pub rows: usize,
    /// Line of the file of each row.
    pub lines: Lines,
    /// Rows that hold only a time.
    pub only_time: usize,
    /// Lines after the rows: how many, the number and the text of the first.
    pub footer: Option<(usize, usize, String)>,
    /// The last row, where it breaks off: its line and text.
    pub cut: Option<(usize, String)>,
    /// Lines between the rows that repeat one of the header: how many, and the first.
    pub repeated: Option<(usize, usize)>,
}

/// What the rows are read with.
pub struct Reader<'p> {
    path: &'p str,
    plan: &'p mut Plan,
    marks: Marks,
    coding: Coding,
    body: Body,
    /// Samples row by row.
    batch: Vec<f64>,
    batch_rows: usize,
    /// Sinks without a number in this row, with what they hold instead.
    gaps: Vec<(usize, Cell)>,
    /// Sinks with grouped thousands in this row.
    groups: Vec<usize>,
    /// A line that is no row: an error if a row follows.
    no_row: Option<NoRow>,
    /// The lines of words above the rows.
    header: Vec<&'p [u8]>,
    line: usize,
}

impl<'p> Reader<'p> {
    /// A reader of rows below the lines `above`, the first of which stands on `line`.
    pub fn new(
        path: &'p str,
        plan: &'p mut Plan,
        marks: Marks,
        coding: Coding,
        above: &'p [u8],
        line: usize,
    ) -> Reader<'p> {
        let n = plan.sinks.len();
        let lines = above.split(|b| matches!(b, b'\n' | b'\r'));
        let words = |l: &&[u8]| l.iter().any(u8::is_ascii_alphabetic);
        Reader {
            path,
            plan,
            marks,
            coding,
            body: Body {
                sinks: (0..n).map(|_| Filled::default()).collect(),
                ..Body::default()
            },
            batch: Vec::with_capacity(BATCH + n),
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
    pub fn run(mut self, head: &[u8], whole: bool, rest: &mut dyn Read) -> Result<Body, Error> {
        if whole {
            self.lines(head, true)?;
            return self.finish();
        }
        let mut block = head.to_vec();
        let mut filled = block.len();
        loop {
            if block.len() < filled + BLOCK {
                block.resize(filled + BLOCK, 0);
            }
            let n = fill(rest, &mut block[filled..]).map_err(|e| broken(self.path, &e))?;
            let ended = n < block.len() - filled;
            filled += n;
            let used = self.lines(&block[..filled], ended)?;
            if ended {
                return self.finish();
            }
            block.copy_within(used..filled, 0);
            filled -= used;
            if filled > LONGEST_LINE {
                return Err(Error::new(
                    Code::BrokenFile,
                    format!(
                        "line {} is longer than {} MB",
                        self.line,
                        LONGEST_LINE >> 20
                    ),
                )
                .hint("look whether this is a text log with one row a line"));
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
            self.line(&block[at..end])?;
            at = next;
        }
        if ended && at < block.len() {
            self.line(&block[at..])?;
            at = block.len();
        }
        Ok(at)
    }

    fn line(&mut self, line: &[u8]) -> Result<(), Error> {
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
                self.commit(number)
            }
            Err(fault) => {
                self.batch.truncate(kept);
                self.no_row(&fault, line, number)
            }
        }
    }

    /// Reads one row to the end of the batch.
    fn row(&mut self, line: &[u8]) -> Result<(), Fault> {
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
                Some(Role::Value(sink)) => match self.quick(&line[start..]) {
                    Some((value, length)) => {
                        self.batch[base + sink] = value;
                        start + length
                    }
                    None => self.slow(line, start, column, base)?,
                },
                _ => self.slow(line, start, column, base)?,
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
            self.short(line, column, base)?;
        }
        Ok(())
    }

    /// A plain number up to the next delimiter: its value and length.
    #[inline]
    fn quick(&self, rest: &[u8]) -> Option<(f64, usize)> {
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
    fn slow(
        &mut self,
        line: &[u8],
        start: usize,
        column: usize,
        base: usize,
    ) -> Result<usize, Fault> {
        let end = cells::cell_end(line, start, self.marks.delimiter);
        let cell = &line[start..end];
        let Some(role) = self.plan.roles.get(column).copied() else {
            return if cells::bare(cell).is_empty() {
                Ok(end)
            } else {
                Err(self.too_many(line, start..end))
            };
        };
        match role {
            Role::Skip => {}
            Role::Time(sink, reader) => match self.plan.readers[reader].seconds(cell) {
                Ok(Some(seconds)) => self.batch[base + sink] = seconds,
                Ok(None) => self.gaps.push((sink, Cell::Missing)),
                Err(trouble) => return Err(self.no_stamp(trouble, sink, cell, start..end)),
            },
            Role::Value(sink) => match cells::read(cell, self.marks.decimal) {
                Cell::Number(value) => self.batch[base + sink] = value,
                Cell::Grouped { value, .. } => {
                    self.batch[base + sink] = value;
                    self.groups.push(sink);
                }
                gap @ (Cell::Missing | Cell::Overload) => self.gaps.push((sink, gap)),
                Cell::Complex(..) | Cell::Text => {
                    return Err(self.no_number(sink, cell, start..end));
                }
            },
            Role::Complex(sink) => match cells::read(cell, self.marks.decimal) {
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
                _ => return Err(self.no_number(sink, cell, start..end)),
            },
        }
        Ok(end)
    }

    /// A row with too few cells: right where it holds nothing but a time.
    fn short(&mut self, line: &[u8], cells: usize, base: usize) -> Result<(), Fault> {
        let only_time = cells == 1
            && matches!(self.plan.roles.first(), Some(Role::Time(sink, _)) if self.batch[base + sink].is_finite());
        if !only_time {
            let required = self.plan.required;
            return Err(Fault {
                code: Code::RaggedRow,
                message: format!(
                    "the row has {cells} cells where the rows before it have {required}"
                ),
                span: 0..line.len(),
                label: format!("{cells} cells"),
                hint: MEND,
            });
        }
        self.body.only_time += 1;
        for sink in 0..self.plan.sinks.len() {
            if self.plan.sinks[sink].reader.is_none() {
                self.gaps.push((sink, Cell::Missing));
            }
        }
        Ok(())
    }

    /// Counts the row that was just read.
    fn commit(&mut self, line: usize) -> Result<(), Error> {
        self.body.lines.note(self.body.rows, line);
        self.body.rows += 1;
        self.batch_rows += 1;
        for &(sink, what) in &self.gaps {
            let filled = &mut self.body.sinks[sink];
            filled.missing += 1;
            filled.overloads += usize::from(what == Cell::Overload);
            if filled.lines.len() < NAMED {
                filled.lines.push(line);
            }
        }
        for &sink in &self.groups {
            self.body.sinks[sink].grouped += 1;
        }
        if self.batch.len() >= BATCH {
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
                filled.present = before + last + 1;
            }
            filled.samples.push(&samples)?;
        }
        self.batch.clear();
        self.batch_rows = 0;
        Ok(())
    }

    fn finish(mut self) -> Result<Body, Error> {
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
pub fn fill(reader: &mut dyn Read, block: &mut [u8]) -> std::io::Result<usize> {
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
pub fn broken(path: &str, why: &std::io::Error) -> Error {
    Error::new(
        Code::BrokenFile,
        format!("{path} cannot be read to its end: {why}"),
    )
    .hint("the file was cut off or damaged: copy it again from where it was recorded")
}
