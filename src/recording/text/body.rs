//! The rows of numbers: a stream in blocks, cells parsed where they stand, no allocation per row.

use std::io::Read;
use std::ops::Range;

use super::cells::{self, Cell, Marks};
use super::columns::{Plan, Role};
use super::encodings::Coding;
use super::stamps::Trouble;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::place::Place;
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
}

/// What is wrong with a row, and where.
struct Fault {
    code: Code,
    message: String,
    span: Range<usize>,
    label: String,
    hint: &'static str,
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
    /// A line that is no row: an error if a row follows, else the beginning of the footer.
    doubt: Option<(Error, usize, usize, String)>,
    line: usize,
}

const MEND: &str =
    "mend the file, or say how it is laid out: --delimiter, --decimal, --header-lines";

impl<'p> Reader<'p> {
    /// A reader of rows, the first of which stands on `line`.
    pub fn new(
        path: &'p str,
        plan: &'p mut Plan,
        marks: Marks,
        coding: Coding,
        line: usize,
    ) -> Reader<'p> {
        let n = plan.sinks.len();
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
            doubt: None,
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
                if let Some((error, ..)) = self.doubt.take() {
                    return Err(error);
                }
                self.commit(number)
            }
            Err(fault) => {
                self.batch.truncate(kept);
                self.doubted(fault, line, number)
            }
        }
    }

    /// A line that is no row: an error at once where it begins with a number, else perhaps the footer.
    fn doubted(&mut self, fault: Fault, line: &[u8], number: usize) -> Result<(), Error> {
        /// A summary below the rows has fewer lines of numbers than this.
        const FOOTER: usize = 20;
        if let Some((error, _, count, _)) = &mut self.doubt {
            *count += 1;
            let cells = cells::Cells::new(line, self.marks.delimiter);
            let (mut all, mut numbers) = (0, 0);
            for (_, cell) in cells {
                all += 1;
                numbers += usize::from(matches!(
                    cells::read(cell, self.marks.decimal),
                    Cell::Number(_)
                ));
            }
            let is_row = all >= self.plan.required && 2 * numbers >= all;
            return match is_row && *count > FOOTER {
                true => Err(error.clone()),
                false => Ok(()),
            };
        }
        let bare = || {
            let cells = cells::Cells::new(line, self.marks.delimiter);
            cells.map(|(_, cell)| cells::bare(cell))
        };
        let begins = bare().find(|c| !c.is_empty());
        let is_number = |c: &&[u8]| matches!(cells::read(c, self.marks.decimal), Cell::Number(_));
        // A row whose stamp or frequency alone cannot be.
        let is_row = bare().count() >= self.plan.required
            && begins.is_some_and(|c| c[0].is_ascii_digit())
            && bare().skip(1).any(|c| is_number(&c));
        let text_first = begins.is_some_and(|cell| {
            matches!(cells::read(cell, self.marks.decimal), Cell::Text)
                && super::stamps::form(cell).is_none()
        });
        let error = self.error(&fault, line, number);
        if !text_first || is_row || self.body.rows == 0 {
            return Err(error);
        }
        let text = self.coding.text(&line[..line.len().min(200)]);
        self.doubt = Some((error, number, 1, text));
        Ok(())
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

    fn too_many(&self, line: &[u8], span: Range<usize>) -> Fault {
        let cells = cells::Cells::new(line, self.marks.delimiter).count();
        let width = self.plan.roles.len();
        Fault {
            code: Code::RaggedRow,
            message: format!("the row has {cells} cells where the rows before it have {width}"),
            span,
            label: format!("beyond column {width}"),
            hint: MEND,
        }
    }

    fn no_number(&self, sink: usize, cell: &[u8], span: Range<usize>) -> Fault {
        let name = &self.plan.sinks[sink].name;
        let text = self.coding.text(cells::bare(cell));
        let text = crate::base::units::shortened(&text);
        Fault {
            code: Code::NotANumber,
            message: format!("\"{text}\" stands where a number of `{name}` is meant"),
            span,
            label: "not a number".into(),
            hint: "mend the cell, leave it blank if the sample is missing, or keep only other channels",
        }
    }

    fn no_stamp(&self, trouble: Trouble, sink: usize, cell: &[u8], span: Range<usize>) -> Fault {
        let name = &self.plan.sinks[sink].name;
        let text = self.coding.text(cells::bare(cell));
        let text = crate::base::units::shortened(&text);
        match trouble {
            Trouble::NotAStamp => Fault {
                code: Code::NotANumber,
                message: format!("\"{text}\" stands where a time stamp of `{name}` is meant"),
                span,
                label: "not a time stamp".into(),
                hint: "mend the cell, or say which column is the time",
            },
            Trouble::OtherOrder => Fault {
                code: Code::BadTime,
                message: format!(
                    "\"{text}\" of `{name}` cannot have day and month in the order stated"
                ),
                span,
                label: "no such month".into(),
                hint: "leave --day-first and --month-first out, and `dates` in the sidecar, or mend the cell",
            },
            Trouble::DayOrMonth => Fault {
                code: Code::BadTime,
                message: format!(
                    "\"{text}\" of `{name}` may have the day or the month first, and the dates do not tell"
                ),
                span,
                label: "day or month".into(),
                hint: "say which comes first: --day-first or --month-first, or `dates` in the sidecar",
            },
        }
    }

    fn error(&self, fault: &Fault, line: &[u8], number: usize) -> Error {
        // Lines far too long to be shown are shown around the cell.
        const SHOWN: usize = 2000;
        let from = if line.len() <= SHOWN {
            0
        } else {
            fault.span.start.saturating_sub(SHOWN / 2)
        };
        let to = line.len().min(from + SHOWN);
        let clip = |at: usize| at.clamp(from, to);
        let before = self.coding.text(&line[from..clip(fault.span.start)]);
        let within = self
            .coding
            .text(&line[clip(fault.span.start)..clip(fault.span.end)]);
        let after = self.coding.text(&line[clip(fault.span.end)..to]);
        let span = before.len()..before.len() + within.len();
        let place = Place::in_line(self.path, number, &format!("{before}{within}{after}"), span);
        Error::new(fault.code, fault.message.clone())
            .at(&place)
            .label(fault.label.clone())
            .hint(fault.hint)
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
        self.body.footer = self
            .doubt
            .take()
            .map(|(_, line, count, text)| (count, line, text));
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
