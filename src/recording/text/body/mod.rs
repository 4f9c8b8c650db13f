//! Reader of the data rows of a text log, block by block; the pieces of a block are parsed in parallel.

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

/// Length of a piece and of the first read, bytes.
pub const BLOCK: usize = 1 << 20;

/// Maximum length of a line, bytes.
const MAX_LINE_LEN: usize = 64 << 20;

/// Number of pieces per thread and block.
const PIECES_PER_THREAD: usize = 2;

/// Maximum number of pieces of a block.
const MAX_PIECES: usize = 32;

/// Maximum number of lines listed in a report of missing cells.
const MAX_LINES_LISTED: usize = 5;

/// Samples and cell counts of one sink; the samples of a piece of the file are in memory.
#[derive(Debug, Default)]
pub struct ColumnData<S = SampleColumn> {
    /// Samples of the sink.
    pub samples: S,
    /// Number of cells without a number, including overloads.
    pub missing: usize,
    /// Number of cells with an overload word.
    pub overloads: usize,
    /// Number of cells with thousands separators.
    pub grouped: usize,
    /// First lines with missing cells.
    pub lines: Vec<usize>,
    /// Number of rows up to the last one with a number.
    pub last_row_with_value: usize,
}

/// Columns of a text log with the irregular lines found between and after the rows.
#[derive(Debug, Default)]
pub struct TableData {
    /// Data of each sink of the plan.
    pub sinks: Vec<ColumnData>,
    /// Number of rows.
    pub rows: usize,
    /// Line number of each row.
    pub lines: LineNumbers,
    /// Number of rows with a time stamp alone.
    pub time_only_rows: usize,
    /// Lines after the rows: their count, line number and text of the first.
    pub footer: Option<(usize, usize, String)>,
    /// Line number and text of a truncated last row.
    pub cut: Option<(usize, String)>,
    /// Lines between the rows that repeat a header line.
    pub repeated: Vec<usize>,
}

/// Reader of the data rows below the header.
pub struct RowReader<'p> {
    path: &'p str,
    plan: &'p mut ColumnPlan,
    marks: Separators,
    encoding: TextEncoding,
    body: TableData,
    /// Line that is not a row: an error if a row follows.
    unparsed: Option<UnparsedLine>,
    /// Header lines with letters.
    header: Vec<&'p [u8]>,
    line: usize,
}

impl ColumnData {
    /// Appends a piece that follows `rows` rows and `lines` lines.
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
        encoding: TextEncoding,
        above: &'p [u8],
        line: usize,
    ) -> RowReader<'p> {
        let n = plan.sinks.len();
        let lines = above.split(|b| matches!(b, b'\n' | b'\r'));
        let has_letters = |l: &&[u8]| l.iter().any(u8::is_ascii_alphabetic);
        RowReader {
            path,
            plan,
            marks,
            encoding,
            body: TableData {
                sinks: (0..n).map(|_| ColumnData::default()).collect(),
                ..TableData::default()
            },
            unparsed: None,
            header: lines.map(<[u8]>::trim_ascii).filter(has_letters).collect(),
            line,
        }
    }

    /// Reads the rows in `head` and, unless it is the complete file, those in `rest`.
    ///
    /// # Errors
    /// The file cannot be read; a row has a wrong number of cells; a cell is text.
    pub fn read_all(
        mut self,
        head: &[u8],
        is_complete: bool,
        rest: &mut dyn Read,
    ) -> Result<TableData, Error> {
        let mut parsed = Vec::new();
        if is_complete {
            self.lines(head, true, &mut parsed)?;
            return Ok(self.finish());
        }
        let step = BLOCK * (PIECES_PER_THREAD * parallel::threads()).min(MAX_PIECES);
        let mut block = head.to_vec();
        let mut filled = block.len();
        loop {
            block.resize(block.len().max(filled + step), 0);
            let n = read_full(rest, &mut block[filled..]).map_err(|e| read_error(self.path, &e))?;
            let eof = n < block.len() - filled;
            filled += n;
            let used = self.lines(&block[..filled], eof, &mut parsed)?;
            if eof {
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

    /// Parses the complete lines of a block, with `parsed` as the buffer of the pieces, and returns their length, bytes. The last line is
    /// complete if the file ends.
    fn lines(&mut self, block: &[u8], eof: bool, parsed: &mut Vec<Rows>) -> Result<usize, Error> {
        let (pieces, used) = split(block, eof);
        parsed.resize_with(parsed.len().max(pieces.len()), Rows::default);
        let mut pieces: Vec<(&[u8], &mut Rows)> = pieces.into_iter().zip(&mut *parsed).collect();
        // Time stamps that depend on earlier ones are parsed sequentially.
        let readers = &self.plan.stamp_parsers;
        let is_independent = readers.iter().all(StampParser::is_independent);
        if is_independent {
            parallel::for_each(&mut pieces, |(piece, rows)| self.parse(piece, rows));
        }
        for (piece, rows) in pieces {
            if !is_independent {
                self.parse(piece, rows);
            }
            self.append_piece(piece, rows)?;
        }
        let last = &block[used..];
        if !eof || last.is_empty() {
            return Ok(used);
        }
        let mut rows = Rows::default();
        self.parse(last, &mut rows);
        match self.is_cut_stamp(&rows) {
            true => self.body.cut = Some((self.line, self.encoding.text(last))),
            false => self.append_piece(last, &mut rows)?,
        }
        Ok(block.len())
    }

    /// Appends the rows of a piece and handles its lines that are not rows.
    fn append_piece(&mut self, mut piece: &[u8], rows: &mut Rows) -> Result<(), Error> {
        loop {
            self.append(rows)?;
            let Some((fault, length)) = &rows.fault else {
                return Ok(());
            };
            let (line, rest) = piece[rows.bytes..].split_at(*length);
            let number = self.line;
            self.line += 1;
            self.handle_unparsed(fault, line, number)?;
            piece = &rest[line_end_len(rest)..];
            self.parse(piece, rows);
        }
    }

    /// Appends rows to the columns.
    fn append(&mut self, rows: &Rows) -> Result<(), Error> {
        if rows.count > 0
            && let Some(unparsed) = self.unparsed.take()
        {
            return Err(unparsed.error);
        }
        let (before, lines) = (self.body.rows, self.line);
        for (sink, part) in self.body.sinks.iter_mut().zip(&rows.columns) {
            sink.append(part, before, lines)?;
        }
        self.body.lines.append(&rows.lines, before, lines);
        for (accumulator, parsed) in self.plan.stamp_parsers.iter_mut().zip(&rows.stamps) {
            match accumulator.is_independent() {
                true => accumulator.merge(parsed),
                false => accumulator.clone_from(parsed),
            }
        }
        self.body.rows += rows.count;
        self.body.time_only_rows += rows.time_only;
        self.line += rows.line_count;
        Ok(())
    }

    /// True if the last line of the file, without a line end, is a truncated time stamp: no other row holds only a time.
    fn is_cut_stamp(&self, last: &Rows) -> bool {
        let sinks = self.plan.sinks.iter().zip(&last.columns);
        let mut channels = sinks.filter(|(sink, _)| sink.reader.is_none());
        last.count == 1
            && self.unparsed.is_none()
            && self.body.time_only_rows + last.time_only == 1
            && channels.all(|(_, column)| column.samples[0].is_nan())
    }

    fn finish(mut self) -> TableData {
        if let Some(last) = self.unparsed.take() {
            match last.is_cut {
                true => self.body.cut = Some((last.line, last.text)),
                false => self.body.footer = Some((last.count, last.line, last.text)),
            }
        }
        self.body
    }
}

/// Splits a block into pieces of [`BLOCK`] bytes plus the rest of a line, and returns their total length; bytes after the last line end are excluded.
fn split(block: &[u8], eof: bool) -> (Vec<&[u8]>, usize) {
    let mut pieces = Vec::new();
    let mut used = 0;
    loop {
        let rest = &block[used..];
        let end = match rest.get(BLOCK..) {
            Some(tail) => memchr::memchr2(b'\n', b'\r', tail).map(|at| BLOCK + at),
            None => None,
        };
        let last = || memchr::memrchr2(b'\n', b'\r', rest);
        let Some(mut end) = end.or_else(last) else {
            return (pieces, used);
        };
        // A line feed may follow in the next block.
        if !eof && end + 1 == rest.len() && rest[end] == b'\r' {
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

/// Length of the line end at the front of a text, bytes: LF, CR or CR LF.
fn line_end_len(text: &[u8]) -> usize {
    match text {
        [b'\r', b'\n', ..] => 2,
        [b'\r' | b'\n', ..] => 1,
        _ => 0,
    }
}

/// Reads until the block is full or the file ends; returns the number of bytes read.
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

/// Error of a stream that cannot be read to its end.
pub fn read_error(path: &str, why: &std::io::Error) -> Error {
    Error::new(
        Code::CorruptFile,
        format!("{path} cannot be read to its end: {why}"),
    )
    .with_hint("the file was cut off or damaged: copy it again from where it was recorded")
}
