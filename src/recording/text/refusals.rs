//! Refusals of a delimited text before its rows are read.

use super::{SAMPLE_LEN, body, cells, dialect, header, preamble};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::source_span::SourceSpan;

/// Refuses bytes that are no text.
pub(super) fn refuse_binary(path: &str, bytes: &[u8], is_whole: bool) -> Result<(), Error> {
    let strange = |b: &&u8| **b < 9 || (14..=31).contains(*b) && **b != 26;
    // NUL bytes at the end of a file are storage that was never written.
    let end = bytes.iter().rposition(|b| *b != 0).map_or(0, |at| at + 1);
    let text = if is_whole { &bytes[..end] } else { bytes };
    let taste = &text[..text.len().min(SAMPLE_LEN)];
    let n = taste.iter().filter(strange).count();
    // A stray control sign may stand in a note; one in two hundred does not. Lines with NUL bytes are refused where rows are read.
    if 200 * n <= taste.len() && end > 0 {
        return Ok(());
    }
    let shown: Vec<String> = bytes.iter().take(16).map(|b| format!("{b:02x}")).collect();
    Err(Error::new(
        Code::UnknownFormat,
        format!("{path} is not a log of a known format: it begins with the bytes {}", shown.join(" ")),
    )
    .with_hint("logs are delimited text (CSV), LVM, UFF 58, WAV or MATLAB level 5, also inside gzip or zip; export one of these"))
}

/// No row of numbers was found.
pub(super) fn no_data_rows(path: &str, lines: &[&str], is_whole: bool) -> Error {
    // Names and a row, at least.
    if !is_whole && lines.len() < 2 {
        let message = format!(
            "a line of {path} is longer than the {} bytes within which names and a row of numbers must occur",
            body::BLOCK
        );
        return Error::new(Code::EmptyLog, message)
            .with_hint("export fewer channels at a time, or one channel per column, not per row");
    }
    let first = lines
        .iter()
        .find(|l| !l.trim().is_empty())
        .copied()
        .unwrap_or("");
    let span = SourceSpan::within_line(path, 1, first, 0..0);
    Error::new(Code::EmptyLog, format!("{path} holds no row of numbers"))
        .with_span(&span)
        .with_hint("a log has rows of numbers with the same number of cells; this text has none")
}

/// Error for the sample rate of a line.
pub(super) fn invalid_rate(path: &str, lines: &[&str], unread: &preamble::InvalidRate) -> Error {
    let line = lines.get(unread.line - 1).copied().unwrap_or("");
    let span = SourceSpan::within_line(path, unread.line, line, 0..line.len());
    Error::new(Code::RateUnknown, &unread.message)
        .with_span(&span)
        .with_hint("state it: --rate HZ, or rate = \"… Hz\" in the sidecar")
}

/// Rows of numbers above the first row that fit neither as rows nor as names.
pub(super) fn refuse_misfits(
    path: &str,
    lines: &[&str],
    layout: &dialect::TableLayout,
    header: &header::TableHeader,
) -> Result<(), Error> {
    if let Some((at, column)) = header.broken_row {
        let mut cells = cells::CellIter::new(lines[at].as_bytes(), layout.separators.delimiter);
        let (start, cell) = cells.nth(column).unwrap_or((0, lines[at].as_bytes()));
        let span = SourceSpan::within_line(path, at + 1, lines[at], start..start + cell.len());
        return Err(Error::new(
            Code::NotANumber,
            "words in a row of numbers, below the names",
        )
        .with_span(&span)
        .with_label("not a number")
        .with_hint("mend the cell, or state how many lines precede the numbers: --header-lines"));
    }
    let above = &lines[..layout.first.min(lines.len())];
    refuse_double_commas(path, above, lines, layout)?;
    for (at, line) in above.iter().enumerate().rev() {
        match dialect::line_kind(line, layout.separators, &layout.kinds) {
            dialect::LineKind::Blank => {}
            dialect::LineKind::PartialRow
                if header.preamble.contains(&at) && !preamble::is_comment(line) =>
            {
                let (cells, width) = (
                    cells::CellIter::new(line.as_bytes(), layout.separators.delimiter).count(),
                    layout.kinds.len(),
                );
                let span = SourceSpan::within_line(path, at + 1, line, 0..line.len());
                let message = format!("the row has {cells} cells, the rows after it {width}");
                let code = if cells == width {
                    Code::NotANumber
                } else {
                    Code::RaggedRow
                };
                let message = if cells == width {
                    "the row holds a cell that is not what its column holds below".into()
                } else {
                    message
                };
                return Err(Error::new(code, message).with_span(&span).with_hint(
                    "correct the row, or state the number of lines before the numbers: --header-lines",
                ));
            }
            _ => break,
        }
    }
    Ok(())
}

/// Rows with twice as many whole numbers as the line above has words, all parted by commas: the comma is the decimal mark too.
fn refuse_double_commas(
    path: &str,
    above: &[&str],
    lines: &[&str],
    layout: &dialect::TableLayout,
) -> Result<(), Error> {
    let Some((at, names)) = (above.iter().enumerate().rev()).find(|(_, l)| !l.trim().is_empty())
    else {
        return Ok(());
    };
    let width = layout.kinds.len();
    let words = cells::CellIter::new(names.as_bytes(), b',').count();
    let is_whole = |(_, cell): (usize, &[u8])| {
        let digits = cell.strip_prefix(b"-").unwrap_or(cell);
        !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
    };
    let rows = lines
        .get(layout.first..)
        .unwrap_or(&[])
        .iter()
        .take(SAMPLE_LEN);
    let commas = layout.separators.delimiter == b',' && layout.separators.decimal == b'.';
    let doubled = commas
        && words > 1
        && width == 2 * words
        && names.contains(char::is_alphabetic)
        && rows
            .clone()
            .all(|row| cells::CellIter::new(row.as_bytes(), b',').all(is_whole));
    if !doubled {
        return Ok(());
    }
    let span = SourceSpan::within_line(path, at + 1, names, 0..names.len());
    let message = format!(
        "{words} names above rows of {width} cells: the comma is both delimiter and decimal mark"
    );
    Err(Error::new(Code::RaggedRow, message)
        .with_span(&span)
        .with_hint(
            "export with points as decimal marks, or with semicolons or tabs between the cells",
        ))
}
