//! Delimited text logs: dialect detected from the first megabyte, data rows streamed.

use std::io::{Cursor, Read};

use super::raw::{RawLog, TextDialect};
use super::read_options::ReadOptions;
use super::stated_rates::agreed_rate;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error, Errors};
use crate::base::text::pluralise;

pub mod encodings;

pub mod cells;

pub mod time_stamps;

pub mod dialect;

mod figure;

pub mod preamble;

pub mod header;

pub mod frequency_table;

pub mod columns;

pub mod body;

mod refusals;

mod assemble;

/// Length of the sample from which the encoding is detected, bytes.
const SAMPLE_LEN: usize = 64 << 10;

/// First block of a file, with its lines.
struct FileHead {
    bytes: Vec<u8>,
    /// Whether the file ends within this block.
    is_complete: bool,
    text: String,
    /// Start of each complete line in `bytes`.
    line_starts: Vec<usize>,
}

/// Reads a delimited text log.
///
/// # Errors
/// A file without numbers, a ragged row, text in a numeric column, an unknown channel.
pub fn read(path: &str, mut reader: impl Read, options: &ReadOptions) -> Result<RawLog, Errors> {
    let mut sample = Vec::new();
    read_up_to(&mut reader, SAMPLE_LEN, &mut sample, path)?;
    let coding = encodings::TextEncoding::detect(&sample, options.dialect.encoding.as_deref())?;
    let (coding_name, label) = (coding.name(&sample), coding.label());
    let input = Cursor::new(sample).chain(reader);
    let mut stream: Box<dyn Read + '_> = if coding.is_utf16() {
        coding.to_utf8(input)
    } else {
        Box::new(input)
    };
    let head = read_head(path, &mut stream, &coding)?;
    let lines: Vec<&str> = lines(&head.text).take(head.line_starts.len()).collect();
    let Some(layout) = dialect::detect(&lines, &options.dialect) else {
        return Err(refusals::no_data_rows(path, &lines, head.is_complete).into());
    };
    let header = header::parse_header(&lines, &layout);
    refusals::refuse_misfits(path, &lines, &layout, &header)?;
    let above: Vec<(usize, &str)> = header
        .preamble
        .iter()
        .map(|&at| (at + 1, lines[at]))
        .collect();
    let preamble = preamble::read(&above, layout.separators);
    let rows = lines.get(layout.first..).unwrap_or(&[]);
    let rate = agreed_rate(&preamble.rates, false)
        .ok()
        .flatten()
        .map(|r| r.hertz);
    let mut plan = columns::plan(
        &header,
        &layout.kinds,
        layout.separators,
        rows,
        rate,
        options,
    )?;
    let start = head
        .line_starts
        .get(layout.first)
        .copied()
        .unwrap_or(head.bytes.len());
    // Cells of the header may contain line ends.
    let header_bytes = &head.bytes[..start];
    let ends = memchr::memchr2_iter(b'\n', b'\r', header_bytes);
    let pairs = memchr::memmem::find_iter(header_bytes, b"\r\n").count();
    let line = 1 + ends.count() - pairs;
    let body = body::RowReader::new(
        path,
        &mut plan,
        layout.separators,
        coding,
        header_bytes,
        line,
    )
    .read_all(&head.bytes[start..], head.is_complete, &mut stream)?;
    let mut log = RawLog {
        path: path.to_string(),
        dialect: describe_dialect(&layout, coding_name),
        text_dialect: TextDialect {
            delimiter: (layout.kinds.len() > 1).then(|| char::from(layout.separators.delimiter)),
            decimal: Some(char::from(layout.separators.decimal)),
            encoding: Some(label.to_lowercase()),
            header_lines: Some(layout.first),
        },
        metadata: preamble.metadata.clone(),
        diagnostics: preamble.diagnostics.clone(),
        ..RawLog::default()
    };
    add_warnings(&mut log, &layout, &header);
    warn_other_dialect(&mut log, &lines, &layout);
    assemble::assemble(&mut log, plan, body, &preamble, options)?;
    let invalid_rate = preamble
        .invalid_rate
        .map(|u| refusals::invalid_rate(path, &lines, &u));
    for group in &mut log.groups {
        group.timing.invalid_rate.clone_from(&invalid_rate);
    }
    Ok(log)
}

/// Reads up to `n` bytes.
fn read_up_to(
    reader: &mut impl Read,
    n: usize,
    bytes: &mut Vec<u8>,
    path: &str,
) -> Result<(), Error> {
    reader
        .take(n as u64)
        .read_to_end(bytes)
        .map(drop)
        .map_err(|e| body::read_error(path, &e))
}

fn read_head(
    path: &str,
    stream: &mut Box<dyn Read + '_>,
    coding: &encodings::TextEncoding,
) -> Result<FileHead, Error> {
    let mut bytes = Vec::new();
    read_up_to(stream, body::BLOCK, &mut bytes, path)?;
    let is_complete = bytes.len() < body::BLOCK;
    if !coding.is_utf16() {
        bytes.drain(..coding.mark.min(bytes.len()));
    }
    if bytes.trim_ascii().is_empty() && is_complete {
        let message = if bytes.is_empty() {
            "is empty"
        } else {
            "contains only blanks"
        };
        return Err(Error::new(Code::EmptyLog, format!("{path} {message}"))
            .with_hint("record again, or check whether the export was finished"));
    }
    refusals::refuse_binary(path, &bytes, is_complete)?;
    let mut line_starts = Vec::new();
    let mut at = 0;
    while let Some(length) = end_of_line(&bytes[at..]) {
        line_starts.push(at);
        let end = at + length;
        at = if bytes[end..].starts_with(b"\r\n") {
            end + 2
        } else {
            end + 1
        };
    }
    if is_complete && at < bytes.len() {
        line_starts.push(at);
    }
    Ok(FileHead {
        text: coding.text(&bytes),
        bytes,
        is_complete,
        line_starts,
    })
}

/// Length of the first line, bytes; a quoted cell may contain line ends.
fn end_of_line(text: &[u8]) -> Option<usize> {
    /// A quote that spans more lines than this is taken as unclosed.
    const MAX_QUOTED_LINES: usize = 4;
    let ends_cell = |byte: u8| matches!(byte, b',' | b';' | b'\t' | b'|' | b'\n' | b'\r');
    let first = memchr::memchr2(b'\n', b'\r', text)?;
    let (mut quoted, mut is_cell_start, mut at, mut line_ends) = (false, true, 0, 0);
    while let Some(&byte) = text.get(at) {
        match byte {
            b'"' if quoted && text.get(at + 1) == Some(&b'"') => at += 1,
            b'"' if quoted && text.get(at + 1).is_none_or(|b| ends_cell(*b)) => quoted = false,
            b'"' if is_cell_start => quoted = true,
            b'\n' | b'\r' if !quoted => return Some(at),
            b'\n' => {
                line_ends += 1;
                if line_ends > MAX_QUOTED_LINES {
                    return Some(first);
                }
            }
            _ => {}
        }
        is_cell_start = !quoted && (ends_cell(byte) || (is_cell_start && byte == b' '));
        at += 1;
    }
    quoted.then_some(first)
}

/// Lines of a text, ended by CR, LF or CR LF.
fn lines(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = Some(text);
    std::iter::from_fn(move || {
        let text = rest?;
        match end_of_line(text.as_bytes()) {
            Some(end) => {
                let after = &text[end..];
                rest = Some(after.strip_prefix("\r\n").unwrap_or(&after[1..]));
                Some(&text[..end])
            }
            None => {
                rest = None;
                Some(text)
            }
        }
    })
}

/// Description of format and dialect: `CSV, comma, 1 header line`.
fn describe_dialect(layout: &dialect::TableLayout, coding: Option<&str>) -> String {
    let delimiter = match layout.separators.delimiter {
        _ if layout.kinds.len() == 1 => "one column".to_string(),
        b',' => "comma".into(),
        b';' => "semicolon".into(),
        b'\t' => "tab".into(),
        b' ' => "blanks".into(),
        other => format!("`{}`", char::from(other)),
    };
    let mut words = vec!["CSV".to_string(), delimiter];
    if layout.separators.decimal == b',' {
        words.push("decimal comma".into());
    }
    words.extend(coding.map(str::to_string));
    words.push(match layout.first {
        0 => "no header".into(),
        1 => "1 header line".into(),
        n => format!("{n} header lines"),
    });
    words.join(", ")
}

/// Warns about skipped rows directly above the first row that are numeric with another delimiter or decimal mark.
fn warn_other_dialect(log: &mut RawLog, lines: &[&str], layout: &dialect::TableLayout) {
    let width = layout.kinds.len();
    let is_numeric = |line: &str, delimiter: u8, decimal: u8| {
        let mut count = 0;
        for (at, (_, cell)) in cells::CellIter::new(line.as_bytes(), delimiter).enumerate() {
            let cell = cells::trim_cell(cell);
            // Time stamps may be dates.
            let is_stamp = at == 0 && cell.first().is_some_and(u8::is_ascii_digit);
            if !is_stamp && cells::number(cell, decimal).is_none() {
                return false;
            }
            count += 1;
        }
        count == width
    };
    let is_row = |line: &&&str| {
        let matches = [b',', b';', b'\t', b' '].map(|delimiter| {
            [b'.', b','].map(|decimal| delimiter != decimal && is_numeric(line, delimiter, decimal))
        });
        matches.as_flattened().contains(&true)
    };
    let above = &lines[..layout.first.min(lines.len())];
    let count = above.iter().rev().take_while(is_row).count();
    if width < 2 || count == 0 {
        return;
    }
    assemble::note(
        log,
        "rows-of-another-dialect",
        format!(
            "{} of numbers above the first row ignored, lines {} to {}: they have another delimiter or decimal mark, or are skipped by --header-lines",
            pluralise(count, "row"),
            above.len() - count + 1,
            above.len()
        ),
    );
}

fn add_warnings(log: &mut RawLog, layout: &dialect::TableLayout, header: &header::TableHeader) {
    if layout.ambiguous_comma {
        log.diagnostics.push(Diagnostic {
            code: "decimal-comma",
            message: "every comma precedes three digits: it is taken for the decimal mark, not for thousands".into(),
            hint: Some("state it if it is not: --decimal .".into()),
        });
    }
    if let Some((at, cells)) = header.misfit_row {
        log.diagnostics.push(Diagnostic {
            code: "names-misfit",
            message: format!(
                "line {} has {cells} words over {} columns: the columns are numbered instead",
                at + 1,
                layout.kinds.len()
            ),
            hint: None,
        });
    }
}
