//! Delimited text as labs export it: the layout is found from the first megabyte, the numbers are streamed.

use std::io::{Cursor, Read};

use super::column::Column;
use super::raw::{Clock, Group, Layout, Raw, RawChannel, Repair, Stamps};
use super::settings::Settings;
use super::stated_rates::agreed;
use crate::base::code::Code;
use crate::base::error::{Error, Errors, Warning};
use crate::base::place::Place;
use crate::base::words::counted;

/// Bytes to characters.
pub mod encodings;

/// A cell: number, missing, overload, complex, text.
pub mod cells;

/// Time stamps.
pub mod stamps;

/// Marks, first row, kinds of columns.
pub mod dialect;

/// Keys and values above the names.
pub mod preamble;

/// Names and units.
pub mod header;

/// Tables over frequency.
pub mod table;

/// What becomes of each column.
pub mod columns;

/// The rows.
pub mod body;

/// Bytes from which the encoding is told.
const TASTE: usize = 64 << 10;

/// The beginning of a file as lines.
struct Head {
    bytes: Vec<u8>,
    /// The file ends within.
    whole: bool,
    text: String,
    /// Where each complete line begins in `bytes`.
    starts: Vec<usize>,
}

/// Reads a delimited text log.
///
/// # Errors
/// What the message says of the file: no numbers, a ragged row, text where a number is meant, a channel that is not there.
pub fn read(path: &str, mut reader: impl Read, settings: &Settings) -> Result<Raw, Errors> {
    let mut taste = Vec::new();
    take(&mut reader, TASTE, &mut taste, path)?;
    let coding = encodings::Coding::detect(&taste, settings.dialect.encoding.as_deref())?;
    let (coding_name, label) = (coding.name(&taste), coding.label());
    let whole = Cursor::new(taste).chain(reader);
    let mut stream: Box<dyn Read + '_> = if coding.is_wide() {
        coding.to_utf8(whole)
    } else {
        Box::new(whole)
    };
    let head = head(path, &mut stream, &coding)?;
    let lines: Vec<&str> = split(&head.text).take(head.starts.len()).collect();
    let Some(layout) = dialect::find(&lines, &settings.dialect) else {
        return Err(no_rows(path, &lines, head.whole).into());
    };
    let header = header::read(&lines, &layout);
    refuse_misfits(path, &lines, &layout, &header)?;
    let above: Vec<(usize, &str)> = header
        .preamble
        .iter()
        .map(|&at| (at + 1, lines[at]))
        .collect();
    let said = preamble::read(&above, layout.marks);
    let rows = lines.get(layout.first..).unwrap_or(&[]);
    let rate = agreed(&said.rates, false).ok().flatten().map(|r| r.hertz);
    let mut plan = columns::plan(&header, &layout.kinds, layout.marks, rows, rate, settings)?;
    let start = head
        .starts
        .get(layout.first)
        .copied()
        .unwrap_or(head.bytes.len());
    // Cells of the names may hold line ends.
    let above = &head.bytes[..start];
    let ends = memchr::memchr2_iter(b'\n', b'\r', above);
    let pairs = memchr::memmem::find_iter(above, b"\r\n").count();
    let line = 1 + ends.count() - pairs;
    let body = body::Reader::new(path, &mut plan, layout.marks, coding, above, line).run(
        &head.bytes[start..],
        head.whole,
        &mut stream,
    )?;
    let mut raw = Raw {
        path: path.to_string(),
        dialect: in_words(&layout, coding_name),
        layout: Layout {
            delimiter: (layout.kinds.len() > 1).then(|| char::from(layout.marks.delimiter)),
            decimal: Some(char::from(layout.marks.decimal)),
            encoding: Some(label.to_lowercase()),
            header_lines: Some(layout.first),
        },
        facts: said.facts.clone(),
        warnings: said.warnings.clone(),
        ..Raw::default()
    };
    doubts(&mut raw, &layout, &header);
    tell_other_dialect(&mut raw, &lines, &layout);
    assemble(&mut raw, plan, body, &said, settings)?;
    let unread = said.unread.map(|u| unread_rate(path, &lines, &u));
    for group in &mut raw.groups {
        group.clock.unread_rate.clone_from(&unread);
    }
    Ok(raw)
}

/// Reads up to `n` bytes.
fn take(reader: &mut impl Read, n: usize, bytes: &mut Vec<u8>, path: &str) -> Result<(), Error> {
    reader
        .take(n as u64)
        .read_to_end(bytes)
        .map(drop)
        .map_err(|e| body::broken(path, &e))
}

fn head(
    path: &str,
    stream: &mut Box<dyn Read + '_>,
    coding: &encodings::Coding,
) -> Result<Head, Error> {
    let mut bytes = Vec::new();
    take(stream, body::BLOCK, &mut bytes, path)?;
    let whole = bytes.len() < body::BLOCK;
    if !coding.is_wide() {
        bytes.drain(..coding.mark.min(bytes.len()));
    }
    if bytes.trim_ascii().is_empty() && whole {
        let message = if bytes.is_empty() {
            "is empty"
        } else {
            "holds nothing but blanks"
        };
        return Err(Error::new(Code::EmptyLog, format!("{path} {message}"))
            .hint("record again, or look whether the export was finished"));
    }
    refuse_binary(path, &bytes, whole)?;
    let mut starts = Vec::new();
    let mut at = 0;
    while let Some(length) = end_of_line(&bytes[at..]) {
        starts.push(at);
        let end = at + length;
        at = if bytes[end..].starts_with(b"\r\n") {
            end + 2
        } else {
            end + 1
        };
    }
    if whole && at < bytes.len() {
        starts.push(at);
    }
    Ok(Head {
        text: coding.text(&bytes),
        bytes,
        whole,
        starts,
    })
}

/// Where the line at the front ends; a cell in quotes may hold line ends.
fn end_of_line(text: &[u8]) -> Option<usize> {
    /// More lines than this have a quote that was never closed.
    const IN_ONE_CELL: usize = 4;
    let parts = |byte: u8| matches!(byte, b',' | b';' | b'\t' | b'|' | b'\n' | b'\r');
    let first = memchr::memchr2(b'\n', b'\r', text)?;
    let (mut quoted, mut begins, mut at, mut ends) = (false, true, 0, 0);
    while let Some(&byte) = text.get(at) {
        match byte {
            b'"' if quoted && text.get(at + 1) == Some(&b'"') => at += 1,
            b'"' if quoted && text.get(at + 1).is_none_or(|b| parts(*b)) => quoted = false,
            b'"' if begins => quoted = true,
            b'\n' | b'\r' if !quoted => return Some(at),
            b'\n' => {
                ends += 1;
                if ends > IN_ONE_CELL {
                    return Some(first);
                }
            }
            _ => {}
        }
        begins = !quoted && (parts(byte) || (begins && byte == b' '));
        at += 1;
    }
    quoted.then_some(first)
}

/// The lines of a text, ended by CR, LF or both.
fn split(text: &str) -> impl Iterator<Item = &str> {
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

fn refuse_binary(path: &str, bytes: &[u8], is_whole: bool) -> Result<(), Error> {
    let strange = |b: &&u8| **b < 9 || (14..=31).contains(*b) && **b != 26;
    // NUL bytes at the end of a file are storage that was never written.
    let end = bytes.iter().rposition(|b| *b != 0).map_or(0, |at| at + 1);
    let text = if is_whole { &bytes[..end] } else { bytes };
    let taste = &text[..text.len().min(TASTE)];
    let n = taste.iter().filter(strange).count();
    // A stray control sign may stand in a note; one in two hundred does not. Lines with NUL bytes are refused where rows are read.
    if 200 * n <= taste.len() && end > 0 {
        return Ok(());
    }
    let shown: Vec<String> = bytes.iter().take(16).map(|b| format!("{b:02x}")).collect();
    Err(Error::new(
        Code::UnknownFormat,
        format!("{path} is no log of a known format: it begins with the bytes {}", shown.join(" ")),
    )
    .hint("logs are delimited text (CSV), LVM, UFF 58, WAV or MATLAB level 5, also inside gzip or zip; export one of these"))
}

fn no_rows(path: &str, lines: &[&str], is_whole: bool) -> Error {
    // Names and a row, at least.
    if !is_whole && lines.len() < 2 {
        let message = format!(
            "a line of {path} is longer than the {} bytes in which names and a row of numbers must stand",
            body::BLOCK
        );
        return Error::new(Code::EmptyLog, message)
            .hint("export fewer channels at a time, or one channel a column, not one a row");
    }
    let first = lines
        .iter()
        .find(|l| !l.trim().is_empty())
        .copied()
        .unwrap_or("");
    let place = Place::in_line(path, 1, first, 0..0);
    Error::new(Code::EmptyLog, format!("{path} holds no row of numbers"))
        .at(&place)
        .hint("a log has rows of numbers with the same number of cells; this text has none")
}

/// What is wrong with the sample rate that stands in a line.
fn unread_rate(path: &str, lines: &[&str], unread: &preamble::Unread) -> Error {
    let line = lines.get(unread.line - 1).copied().unwrap_or("");
    let place = Place::in_line(path, unread.line, line, 0..line.len());
    Error::new(Code::RateUnknown, &unread.message)
        .at(&place)
        .hint("state it: --rate HZ, or rate = \"… Hz\" in the sidecar")
}

/// Rows of numbers above the first row that fit neither as rows nor as names.
fn refuse_misfits(
    path: &str,
    lines: &[&str],
    layout: &dialect::Layout,
    header: &header::Header,
) -> Result<(), Error> {
    if let Some((at, column)) = header.broken {
        let mut cells = cells::Cells::new(lines[at].as_bytes(), layout.marks.delimiter);
        let (start, cell) = cells.nth(column).unwrap_or((0, lines[at].as_bytes()));
        let place = Place::in_line(path, at + 1, lines[at], start..start + cell.len());
        return Err(Error::new(
            Code::NotANumber,
            "words stand in a row of numbers, below the names",
        )
        .at(&place)
        .label("not a number")
        .hint("mend the cell, or state how many lines stand above the numbers: --header-lines"));
    }
    let above = &lines[..layout.first.min(lines.len())];
    refuse_double_commas(path, above, lines, layout)?;
    for (at, line) in above.iter().enumerate().rev() {
        match dialect::stance(line, layout.marks, &layout.kinds) {
            dialect::Stance::Blank => {}
            dialect::Stance::Misfit
                if header.preamble.contains(&at) && !preamble::is_comment(line) =>
            {
                let (cells, width) = (
                    cells::Cells::new(line.as_bytes(), layout.marks.delimiter).count(),
                    layout.kinds.len(),
                );
                let place = Place::in_line(path, at + 1, line, 0..line.len());
                let message =
                    format!("the row has {cells} cells where the rows after it have {width}");
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
                return Err(Error::new(code, message).at(&place).hint(
                    "mend the row, or state how many lines stand above the numbers: --header-lines",
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
    layout: &dialect::Layout,
) -> Result<(), Error> {
    let Some((at, names)) = (above.iter().enumerate().rev()).find(|(_, l)| !l.trim().is_empty())
    else {
        return Ok(());
    };
    let width = layout.kinds.len();
    let words = cells::Cells::new(names.as_bytes(), b',').count();
    let is_whole = |(_, cell): (usize, &[u8])| {
        let digits = cell.strip_prefix(b"-").unwrap_or(cell);
        !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
    };
    let rows = lines.get(layout.first..).unwrap_or(&[]).iter().take(TASTE);
    let commas = layout.marks.delimiter == b',' && layout.marks.decimal == b'.';
    let doubled = commas
        && words > 1
        && width == 2 * words
        && names.contains(char::is_alphabetic)
        && rows
            .clone()
            .all(|row| cells::Cells::new(row.as_bytes(), b',').all(is_whole));
    if !doubled {
        return Ok(());
    }
    let place = Place::in_line(path, at + 1, names, 0..names.len());
    let message = format!(
        "{words} names stand over rows of {width} cells: the comma parts the cells and is the decimal mark as well"
    );
    Err(Error::new(Code::RaggedRow, message)
        .at(&place)
        .hint("export with points as decimal marks, or with semicolons or tabs between the cells"))
}

/// Format and dialect in words.
fn in_words(layout: &dialect::Layout, coding: Option<&str>) -> String {
    let delimiter = match layout.marks.delimiter {
        _ if layout.kinds.len() == 1 => "one column".to_string(),
        b',' => "comma".into(),
        b';' => "semicolon".into(),
        b'\t' => "tab".into(),
        b' ' => "blanks".into(),
        other => format!("`{}`", char::from(other)),
    };
    let mut words = vec!["CSV".to_string(), delimiter];
    if layout.marks.decimal == b',' {
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

/// Rows of as many cells right above the first row that other marks than those of the log make numbers: they were passed over.
fn tell_other_dialect(raw: &mut Raw, lines: &[&str], layout: &dialect::Layout) {
    let width = layout.kinds.len();
    let by = |line: &str, delimiter: u8, decimal: u8| {
        let mut count = 0;
        for (at, (_, cell)) in cells::Cells::new(line.as_bytes(), delimiter).enumerate() {
            let cell = cells::bare(cell);
            // Stamps of the time may be dates.
            let is_stamp = at == 0 && cell.first().is_some_and(u8::is_ascii_digit);
            if !is_stamp && cells::number(cell, decimal).is_none() {
                return false;
            }
            count += 1;
        }
        count == width
    };
    let is_row = |line: &&&str| {
        let all = [b',', b';', b'\t', b' '].map(|delimiter| {
            [b'.', b','].map(|decimal| delimiter != decimal && by(line, delimiter, decimal))
        });
        all.as_flattened().contains(&true)
    };
    let above = &lines[..layout.first.min(lines.len())];
    let count = above.iter().rev().take_while(is_row).count();
    if width < 2 || count == 0 {
        return;
    }
    note(
        raw,
        "rows-of-another-dialect",
        format!(
            "{} of numbers above the first row passed over, lines {} to {}: other marks part their cells or stand before their decimals",
            counted(count, "row"),
            above.len() - count + 1,
            above.len()
        ),
    );
}

fn doubts(raw: &mut Raw, layout: &dialect::Layout, header: &header::Header) {
    if layout.comma_in_doubt {
        raw.warnings.push(Warning {
            code: "decimal-comma",
            message: "every comma stands before three digits: it is taken for the decimal mark, not for thousands".into(),
            hint: Some("say so if it is not: --decimal .".into()),
        });
    }
    if let Some((at, cells)) = header.misfit {
        raw.warnings.push(Warning {
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

/// Puts what was read in its place.
fn assemble(
    raw: &mut Raw,
    plan: columns::Plan,
    mut body: body::Body,
    said: &preamble::Preamble,
    settings: &Settings,
) -> Result<(), Error> {
    let present = |body: &body::Body, group: Option<usize>| {
        let of = |s: &&columns::Sink| group.is_none_or(|g| s.group == g);
        let sinks = plan.sinks.iter().zip(&body.sinks).filter(|(s, _)| of(s));
        sinks.map(|(_, filled)| filled.present).max().unwrap_or(0)
    };
    if present(&body, None) == 0 {
        return Err(Error::new(
            Code::EmptyLog,
            format!("{} holds no number in any row", raw.path),
        )
        .hint("record again, or look whether the export was finished"));
    }
    for (name, why) in &plan.left_out {
        leave_out(raw, name, why);
    }
    raw.warnings.extend(plan.warnings.iter().cloned());
    let trailing = body.rows - present(&body, None);
    if trailing > 0 {
        note(
            raw,
            "footer-skipped",
            format!(
                "{} without any number at the end passed over",
                counted(trailing, "row")
            ),
        );
    }
    if let Some((count, line, text)) = &body.footer {
        let text = crate::base::units::shortened(text.trim());
        note(
            raw,
            "footer-skipped",
            format!(
                "{} after the rows passed over, from line {line} on: \"{text}\"",
                counted(*count, "line")
            ),
        );
    }
    if let Some((line, text)) = &body.cut {
        let text = crate::base::units::shortened(text.trim());
        let message = format!("the last row, line {line}, breaks off and is left out: \"{text}\"");
        note(raw, "row-incomplete", message);
    }
    if let Some((count, first)) = body.repeated {
        let message = format!(
            "{} of the header repeated between the rows passed over, the first line {first}: rows on either side are joined, and only time stamps tell what passed",
            counted(count, "line")
        );
        note(raw, "header-repeated", message);
    }
    if body.only_time > 0 {
        note(
            raw,
            "cells-missing",
            format!("only a time in {}", counted(body.only_time, "row")),
        );
    }
    let lengths: Vec<usize> = (0..plan.groups)
        .map(|group| present(&body, Some(group)))
        .collect();
    raw.groups = lengths.iter().map(|_| Group::default()).collect();
    let lines = std::mem::take(&mut body.lines);
    for (sink, mut filled) in plan.sinks.iter().zip(std::mem::take(&mut body.sinks)) {
        let length = lengths[sink.group];
        let cut = body.rows - length;
        filled.samples.truncate(length)?;
        filled.missing = filled.missing.saturating_sub(cut);
        let last = lines.of(length.saturating_sub(1)).unwrap_or(usize::MAX);
        filled.lines.retain(|line| *line <= last);
        if filled.missing == length && sink.reader.is_none() && filled.overloads == 0 && length > 0
        {
            leave_out(raw, &sink.name, "holds no number in any row");
            continue;
        }
        report_cells(raw, sink, &filled);
        let group = &mut raw.groups[sink.group];
        match sink.reader.map(|at| &plan.readers[at]) {
            Some(reader) => {
                if reader.is_in_doubt() {
                    raw.warnings.push(Warning {
                        code: "date-order",
                        message: format!(
                            "{} of `{}` may have the day or the month first: only what passed since is known",
                            reader.start, sink.name
                        ),
                        hint: Some("say which comes first: --day-first or --month-first".into()),
                    });
                }
                group.clock.start = (sink.unit == "date-time").then(|| reader.start.clone());
                group.clock.stamps = Some(Stamps {
                    name: sink.name.clone(),
                    unit: sink.unit.clone(),
                    first: reader.start.clone(),
                    seconds: filled.samples,
                    resolution: reader.resolution(),
                });
            }
            None => group
                .channels
                .push(channel(sink, filled.samples, filled.overloads)),
        }
    }
    raw.groups.retain(|group| !group.channels.is_empty());
    for group in &mut raw.groups {
        let start = group.clock.start.take();
        group.clock = Clock {
            stamps: group.clock.stamps.take(),
            stated_rates: said.rates.clone(),
            unread_rate: None,
            header_samples: said.samples,
            start: start.or_else(|| said.start.clone()),
            lines: lines.clone(),
        };
    }
    if raw.groups.is_empty() {
        return Err(Error::new(
            Code::EmptyLog,
            format!("{} holds time stamps and no channel", raw.path),
        )
        .hint("say that no column is the time, if the numbers are a channel: --time none"));
    }
    in_order(raw, settings);
    if plan.over_frequency {
        let channels = raw.groups.pop().map(|g| g.channels).unwrap_or_default();
        raw.responses = Some(table::responses(&raw.path, &channels)?);
        raw.groups.clear();
    } else if let Some(channel) = complex_channel(&raw.groups, &plan) {
        return Err(Error::new(
            Code::NotANumber,
            format!(
                "`{channel}` of {} holds complex numbers, and no column gives their frequencies",
                raw.path
            ),
        )
        .hint(
            "frequency responses need a first column of frequencies, named such as frequency_Hz",
        ));
    }
    Ok(())
}

fn complex_channel(groups: &[Group], plan: &columns::Plan) -> Option<String> {
    let sink = plan.roles.iter().find_map(|role| match role {
        columns::Role::Complex(sink) => Some(*sink),
        _ => None,
    })?;
    let name = plan.sinks[sink].name.trim_end_matches(" re").to_string();
    (!groups.is_empty()).then_some(name)
}

fn note(raw: &mut Raw, kind: &'static str, message: String) {
    raw.repairs.push(Repair { kind, message });
}

fn leave_out(raw: &mut Raw, name: &str, why: &'static str) {
    let message = format!("column `{name}` {why}: it is no channel");
    note(raw, "column-left-out", message);
    raw.left_out.push((name.to_string(), why));
}

fn channel(sink: &columns::Sink, samples: Column, overloads: usize) -> RawChannel {
    RawChannel {
        name: sink.name.clone(),
        unit: sink.unit.clone(),
        samples,
        overloads,
    }
}

/// Says which cells hold no number, and where thousands were grouped.
fn report_cells(raw: &mut Raw, sink: &columns::Sink, filled: &body::Filled) {
    let name = &sink.name;
    if filled.missing > 0 {
        let lines: Vec<String> = filled.lines.iter().map(usize::to_string).collect();
        let line = if filled.missing == 1 { "line" } else { "lines" };
        let more = filled.missing.saturating_sub(filled.lines.len());
        let more = if more > 0 {
            format!(" and {more} more")
        } else {
            String::new()
        };
        let overloads = match filled.overloads {
            0 => String::new(),
            n => format!(", {n} of them overloads"),
        };
        note(
            raw,
            "cells-missing",
            format!(
                "no number in {} of `{name}`{overloads}: {line} {}{more}",
                counted(filled.missing, "cell"),
                lines.join(", ")
            ),
        );
    }
    if filled.grouped > 0 {
        note(
            raw,
            "thousands-joined",
            format!(
                "thousands separators in {} of `{name}`",
                counted(filled.grouped, "cell")
            ),
        );
    }
}

/// The channels asked for, in the order asked for.
fn in_order(raw: &mut Raw, settings: &Settings) {
    if settings.only.is_empty() {
        return;
    }
    let place = |name: &str| {
        let means = |word: &String| {
            let renamed = settings
                .channels
                .iter()
                .find(|c| c.rename.as_deref() == Some(word.as_str()));
            super::names::means(renamed.map_or(word.as_str(), |c| c.name.as_str()), name)
        };
        settings.only.iter().position(means)
    };
    for group in &mut raw.groups {
        group.channels.sort_by_key(|channel| place(&channel.name));
    }
}
