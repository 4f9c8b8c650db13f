//! Data rows of a text log, read by the block; the pieces of a block are parsed on several threads.

mod faults;

mod rows;

mod unparsed_line;

use std::io::Read;

use faults::RowError;
use rows::Rows;
use unparsed_line::UnparsedLine;

use super::cells::Separators;
use super::columns::ColumnPlan;
use super::encodings::TextEncoding;
use super::time_stamps::StampParser;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::parallel;
use crate::recording::raw::LineNumbers;
use crate::recording::sample_column::SampleColumn;

/// Bytes of a piece, and of what is read first.
pub const BLOCK: usize = 1 << 20;

/// The longest line that is taken for a row, bytes.
const MAX_LINE_LEN: usize = 64 << 20;

/// Pieces that a thread has at a time.
const PIECES_PER_THREAD: usize = 2;

/// Pieces of a block at most.
const MAX_PIECES: usize = 32;

/// Lines named in a report of missing cells.
const MAX_LINES_LISTED: usize = 5;

/// Samples and cell counts of one sink; in a piece of the file its samples are in memory.
#[derive(Debug, Default)]
pub struct ColumnData<S = SampleColumn> {
    /// Samples read.
    pub samples: S,
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
    /// A line that is no row: an error if a row follows.
    no_row: Option<UnparsedLine>,
    /// The lines of words above the rows.
    header: Vec<&'p [u8]>,
    line: usize,
}

impl ColumnData {
    /// Appends a piece behind `rows` rows and `lines` lines.
    fn append(
        &mut self,
        part: &ColumnData<Vec<f64>>,
        rows: usize,
        lines: usize,
    ) -> Result<(), Error> {
        self.missing += part.missing;
        self.overloads += part.overloads;
        self.grouped += part.grouped;
        let room = MAX_LINES_LISTED - self.lines.len();
        self.lines
            .extend(part.lines.iter().take(room).map(|line| lines + line));
        if let Some(last) = part.samples.iter().rposition(|x| x.is_finite()) {
            self.last_row_with_value = rows + last + 1;
        }
        self.samples.push(&part.samples)
    }
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
        let mut parsed = Vec::new();
        if whole {
            self.lines(head, true, &mut parsed)?;
            return Ok(self.finish());
        }
        let step = BLOCK * (PIECES_PER_THREAD * parallel::threads()).min(MAX_PIECES);
        let mut block = head.to_vec();
        let mut filled = block.len();
        loop {
            block.resize(block.len().max(filled + step), 0);
            let n = read_full(rest, &mut block[filled..]).map_err(|e| read_error(self.path, &e))?;
            let ended = n < block.len() - filled;
            filled += n;
            let used = self.lines(&block[..filled], ended, &mut parsed)?;
            if ended {
                return Ok(self.finish());
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

    /// Takes the complete lines of a block, piece by piece through `parsed`; the last line is complete where the file has ended. Bytes
    /// used.
    fn lines(&mut self, block: &[u8], ended: bool, parsed: &mut Vec<Rows>) -> Result<usize, Error> {
        let (pieces, used) = split(block, ended);
        parsed.resize_with(parsed.len().max(pieces.len()), Rows::default);
        let mut pieces: Vec<(&[u8], &mut Rows)> = pieces.into_iter().zip(&mut *parsed).collect();
        // Stamps that depend on those before them are read in order.
        let readers = &self.plan.accumulators;
        let is_independent = readers.iter().all(StampParser::is_independent);
        if is_independent {
            parallel::for_each(&mut pieces, |(piece, rows)| self.parse(piece, rows));
        }
        for (piece, rows) in pieces {
            if !is_independent {
                self.parse(piece, rows);
            }
            self.take(piece, rows)?;
        }
        let last = &block[used..];
        if !ended || last.is_empty() {
            return Ok(used);
        }
        let mut rows = Rows::default();
        self.parse(last, &mut rows);
        match self.is_cut_stamp(&rows) {
            true => self.body.cut = Some((self.line, self.coding.text(last))),
            false => self.take(last, &mut rows)?,
        }
        Ok(block.len())
    }

    /// Takes the rows of a piece, and the lines in it that are none.
    fn take(&mut self, mut piece: &[u8], rows: &mut Rows) -> Result<(), Error> {
        loop {
            self.append(rows)?;
            let Some((fault, length)) = &rows.fault else {
                return Ok(());
            };
            let (line, rest) = piece[rows.bytes..].split_at(*length);
            let number = self.line;
            self.line += 1;
            self.no_row(fault, line, number)?;
            piece = &rest[line_end_len(rest)..];
            self.parse(piece, rows);
        }
    }

    /// Appends rows to the columns.
    fn append(&mut self, rows: &Rows) -> Result<(), Error> {
        if rows.count > 0
            && let Some(before) = self.no_row.take()
        {
            return Err(before.error);
        }
        let (before, lines) = (self.body.rows, self.line);
        for (filled, part) in self.body.sinks.iter_mut().zip(&rows.columns) {
            filled.append(part, before, lines)?;
        }
        self.body.lines.append(&rows.lines, before, lines);
        for (own, read) in self.plan.accumulators.iter_mut().zip(&rows.stamps) {
            match own.is_independent() {
                true => own.merge(read),
                false => own.clone_from(read),
            }
        }
        self.body.rows += rows.count;
        self.body.time_only_rows += rows.time_only;
        self.line += rows.line_count;
        Ok(())
    }

    /// Whether the last line of the file, which no line end follows, is the beginning of a time stamp: no other row holds a time alone.
    fn is_cut_stamp(&self, last: &Rows) -> bool {
        let both = self.plan.sinks.iter().zip(&last.columns);
        let mut channels = both.filter(|(sink, _)| sink.reader.is_none());
        last.count == 1
            && self.no_row.is_none()
            && self.body.time_only_rows + last.time_only == 1
            && channels.all(|(_, column)| column.samples[0].is_nan())
    }

    fn finish(mut self) -> TableData {
        if let Some(last) = self.no_row.take() {
            match last.is_cut {
                true => self.body.cut = Some((last.line, last.text)),
                false => self.body.footer = Some((last.count, last.line, last.text)),
            }
        }
        self.body
    }
}

/// Pieces of [`BLOCK`] bytes and the rest of a line, and how many bytes they have together: what follows the last line end is in none.
fn split(block: &[u8], ended: bool) -> (Vec<&[u8]>, usize) {
    let mut pieces = Vec::new();
    let mut used = 0;
    loop {
        let rest = &block[used..];
        let end = match rest.get(BLOCK..) {
            Some(beyond) => memchr::memchr2(b'\n', b'\r', beyond).map(|at| BLOCK + at),
            None => None,
        };
        let last = || memchr::memrchr2(b'\n', b'\r', rest);
        let Some(mut end) = end.or_else(last) else {
            return (pieces, used);
        };
        // The line end may go on in the next block.
        if !ended && end + 1 == rest.len() && rest[end] == b'\r' {
            match memchr::memrchr2(b'\n', b'\r', &rest[..end]) {
                Some(before) => end = before,
                None => return (pieces, used),
            }
        }
        let end = end + line_end_len(&rest[end..]);
        pieces.push(&rest[..end]);
        used += end;
    }
}

/// Bytes of the line end at the front of a text: LF, CR, or both.
fn line_end_len(text: &[u8]) -> usize {
    match text {
        [b'\r', b'\n', ..] => 2,
        [b'\r' | b'\n', ..] => 1,
        _ => 0,
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
