//! Lines that are no rows: a header that is repeated, a footer, a last row that breaks off where a logger was switched off.

use super::{RowError, RowReader};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::source_span::SourceSpan;
use crate::base::text::pluralise;
use crate::recording::text::cells::{self, Cell, CellIter};
use crate::recording::text::time_stamps;

/// A line that is no row, until the lines after it tell what it is.
pub(super) struct UnparsedLine {
    /// Error, if a row follows.
    pub error: Error,
    /// Line number.
    pub line: usize,
    /// Text of the line, shortened.
    pub text: String,
    /// Lines of the footer.
    pub count: usize,
    /// A row that breaks off; else the beginning of a footer.
    pub is_cut: bool,
}

impl RowReader<'_> {
    /// Takes a line that is no row: an error where it begins with a number, unless it is the last and breaks off.
    pub(super) fn handle_unparsed(
        &mut self,
        fault: &RowError,
        line: &[u8],
        number: usize,
    ) -> Result<(), Error> {
        if line.contains(&0) {
            return self.empty_storage(line, number);
        }
        if self.header.contains(&line.trim_ascii()) && self.is_before_header() {
            self.unparsed = None;
            self.body.repeated.push(number);
            return Ok(());
        }
        if self.unparsed.is_some() {
            return self.below_rows(line);
        }
        let bare =
            || CellIter::new(line, self.marks.delimiter).map(|(_, cell)| cells::trim_cell(cell));
        let begins = bare().find(|c| !c.is_empty());
        let is_number =
            |c: &&[u8]| matches!(cells::parse_cell(c, self.marks.decimal), Cell::Number(_));
        // A row whose stamp or frequency alone cannot be.
        let is_row = bare().count() >= self.plan.required
            && begins.is_some_and(|c| c[0].is_ascii_digit())
            && bare().skip(1).any(|c| is_number(&c));
        let text_first = begins.is_some_and(|cell| {
            matches!(cells::parse_cell(cell, self.marks.decimal), Cell::Text)
                && time_stamps::detect_format(cell).is_none()
        });
        let is_footer = text_first && !is_row;
        let error = self.error(fault, line, number);
        if self.body.rows == 0 || !(is_footer || self.breaks_off(fault, line)) {
            return Err(error);
        }
        self.hold(error, line, number, !is_footer);
        Ok(())
    }

    /// Holds a line back until those after it tell what it is.
    fn hold(&mut self, error: Error, line: &[u8], number: usize, is_cut: bool) {
        const MAX_LINE_SHOWN: usize = 200;
        self.unparsed = Some(UnparsedLine {
            error,
            line: number,
            text: self.encoding.text(&line[..line.len().min(MAX_LINE_SHOWN)]),
            count: 1,
            is_cut,
        });
    }

    /// Whether the lines held back may precede the names of a header that is repeated.
    fn is_before_header(&self) -> bool {
        let before = self.unparsed.as_ref();
        before.is_none_or(|b| !b.is_cut && b.count < self.header.len())
    }

    /// Whether a row ends too early, in the middle of a cell or between two.
    fn breaks_off(&self, fault: &RowError, line: &[u8]) -> bool {
        let count = CellIter::new(line, self.marks.delimiter).count();
        let cell = line
            .get(fault.span.clone())
            .map_or(&b""[..], cells::trim_cell);
        // What a digit makes a number is the beginning of one.
        let begins_number = || {
            let whole = [cell, b"0"].concat();
            matches!(
                cells::parse_cell(&whole, self.marks.decimal),
                Cell::Number(_)
            )
        };
        fault.span.end >= line.trim_ascii_end().len()
            && count <= self.plan.roles.len()
            && (count < self.plan.required || begins_number())
    }

    /// A line after one that is no row.
    fn below_rows(&mut self, line: &[u8]) -> Result<(), Error> {
        /// A summary below the rows has fewer lines of numbers than this.
        const MAX_FOOTER_LINES: usize = 20;
        let Some(before) = &mut self.unparsed else {
            return Ok(());
        };
        before.count += 1;
        let (mut all, mut numbers) = (0, 0);
        for (_, cell) in CellIter::new(line, self.marks.delimiter) {
            all += 1;
            let is_number = matches!(cells::parse_cell(cell, self.marks.decimal), Cell::Number(_));
            numbers += usize::from(is_number);
        }
        let is_row = all >= self.plan.required && 2 * numbers >= all;
        match before.is_cut || (is_row && before.count > MAX_FOOTER_LINES) {
            true => Err(before.error.clone()),
            false => Ok(()),
        }
    }

    /// A line with NUL bytes: at the end of a log, storage that was reserved and never written; elsewhere an error.
    fn empty_storage(&mut self, line: &[u8], number: usize) -> Result<(), Error> {
        let count = line.iter().filter(|b| **b == 0).count();
        let end = line.iter().rposition(|b| *b != 0).map_or(0, |at| at + 1);
        let span = SourceSpan::whole_line(self.path, number);
        let message = format!("line {number} contains {}", pluralise(count, "NUL byte"));
        let error = Error::new(Code::CorruptFile, message).with_span(&span).with_hint(
            "the file is damaged or incomplete; cut it there, or remove the bytes: tr -d '\\0' < LOG > NEW",
        );
        let is_padding = !line[..end].contains(&0) && self.body.rows > 0;
        if !is_padding || self.unparsed.is_some() {
            return Err(error);
        }
        self.hold(error, &line[..end], number, true);
        Ok(())
    }
}
