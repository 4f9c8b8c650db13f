//! LVM headers: keys with one value for the file or one value per channel.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::source_span::SourceSpan;
use crate::recording::raw::{RawLog, Repair};
use crate::recording::read_options::ReadOptions;

/// Line that ends a header.
const END_OF_HEADER: &str = "***End_of_Header***";

/// Maximum number of channels, a limit of the memory that a wrong count can allocate.
const MAX_CHANNELS: usize = 1 << 16;

/// Sequential reader of the lines of a file.
pub(super) struct LineReader<'a> {
    path: &'a str,
    unread: &'a [u8],
    /// Number of the next line, from 1.
    pub number: usize,
    encoding: Option<&'static encoding_rs::Encoding>,
}

impl<'a> LineReader<'a> {
    pub fn new(path: &'a str, bytes: &'a [u8], options: &ReadOptions) -> LineReader<'a> {
        let label = options.dialect.encoding.as_deref();
        LineReader {
            path,
            unread: bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes),
            number: 1,
            encoding: label.and_then(|l| encoding_rs::Encoding::for_label(l.as_bytes())),
        }
    }

    /// Next line without its line end; does not advance.
    pub fn peek(&self) -> Option<&'a [u8]> {
        if self.unread.is_empty() {
            return None;
        }
        let end = memchr::memchr(b'\n', self.unread).unwrap_or(self.unread.len());
        let line = &self.unread[..end];
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    /// Reads the next line.
    pub fn next_line(&mut self) -> Option<&'a [u8]> {
        let line = self.peek()?;
        let end = memchr::memchr(b'\n', self.unread).map_or(self.unread.len(), |at| at + 1);
        self.unread = &self.unread[end..];
        self.number += 1;
        Some(line)
    }

    /// Error at a line; lines are numbered from 1.
    pub fn error(
        &self,
        code: Code,
        number: usize,
        line: &[u8],
        message: impl Into<String>,
    ) -> Error {
        let span = SourceSpan::within_line(self.path, number, &self.decode(line), 0..0);
        Error::new(code, message).with_span(&span)
    }

    /// Text of a line in the stated encoding; by default UTF-8 if valid, else Windows-1252, a superset of Latin-1.
    pub fn decode(&self, line: &[u8]) -> String {
        match (self.encoding, std::str::from_utf8(line)) {
            (Some(encoding), _) => encoding.decode_without_bom_handling(line).0.into_owned(),
            (None, Ok(text)) => text.to_string(),
            (None, Err(_)) => {
                let decoded = encoding_rs::WINDOWS_1252.decode_without_bom_handling(line);
                decoded.0.into_owned()
            }
        }
    }
}

/// Position of the abscissa in a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AbscissaLayout {
    /// No abscissa: the first column is blank.
    No,
    /// One abscissa in the first column.
    FirstColumn,
    /// A column of abscissas before each channel.
    Multi,
}

/// Contents of the first header.
pub(super) struct FileHeader {
    pub separator: u8,
    pub abscissa: AbscissaLayout,
    /// True if every segment has a header; otherwise its `Samples` counts only the first packet.
    pub has_segment_headers: bool,
    pub metadata: Vec<(String, String)>,
}

/// Reads the first header.
pub(super) fn read_file_header(lines: &mut LineReader<'_>) -> Result<FileHeader, Error> {
    let first = lines
        .next_line()
        .map(|line| lines.decode(line))
        .unwrap_or_default();
    if !first.starts_with("LabVIEW Measurement") {
        return Err(Error::new(
            Code::UnknownFormat,
            "an LVM file begins with `LabVIEW Measurement`, and this one does not",
        ));
    }
    let mut file = FileHeader {
        separator: b'\t',
        abscissa: AbscissaLayout::FirstColumn,
        has_segment_headers: false,
        metadata: Vec::new(),
    };
    while let Some(line) = lines.next_line() {
        let text = lines.decode(line);
        if text.starts_with(END_OF_HEADER) {
            return Ok(file);
        }
        // The line that names the separator already uses it.
        if let Some(rest) = text.strip_prefix("Separator") {
            file.separator = if rest.starts_with(',') || rest.contains("Comma") {
                b','
            } else {
                b'\t'
            };
            continue;
        }
        let Some((key, value)) = text.split_once(char::from(file.separator)) else {
            continue;
        };
        let value = value.trim_end_matches(char::from(file.separator)).trim();
        match key.trim() {
            "X_Columns" => {
                file.abscissa = match value {
                    "No" => AbscissaLayout::No,
                    "Multi" => AbscissaLayout::Multi,
                    _ => AbscissaLayout::FirstColumn,
                }
            }
            "Multi_Headings" => file.has_segment_headers = value == "Yes",
            key @ ("Date" | "Time" | "Operator" | "Project" | "Description" | "Test"
            | "Time_Pref") => {
                file.metadata.push((key.to_string(), value.to_string()));
            }
            _ => {}
        }
    }
    Err(Error::new(
        Code::CorruptFile,
        format!("the LVM file ends inside its header, without {END_OF_HEADER}"),
    ))
}

/// Contents of the header of a segment.
#[derive(Debug, Default)]
pub(super) struct SegmentHeader {
    pub channels: Vec<LvmChannel>,
    /// Number of data columns; the columns after them hold comments.
    pub columns: usize,
}

/// Channel of a segment with the values of its header keys.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct LvmChannel {
    pub name: String,
    pub unit: String,
    pub x_dimension: String,
    /// Number of samples of the segment, stated by its header.
    pub samples: Option<usize>,
    /// Number of samples of the first packet, stated by the header of a file with a single header.
    pub first_packet: Option<usize>,
    pub x0: f64,
    pub delta_x: Option<f64>,
    pub date: String,
    pub time: String,
    /// Column of the channel; `x_column` is that of its abscissa.
    pub column: usize,
    pub x_column: Option<usize>,
}

/// Reads the next segment header and the line of column headings; `None` at the end of the file.
pub(super) fn read_segment_header(
    lines: &mut LineReader<'_>,
    file: &FileHeader,
    log: &mut RawLog,
) -> Result<Option<SegmentHeader>, Error> {
    let separator = char::from(file.separator);
    let mut keys: Vec<(String, Vec<String>)> = Vec::new();
    let mut is_in_special = false;
    let mut special = 0;
    let first_line = lines.number;
    let is_complete = loop {
        let Some(line) = lines.next_line() else {
            break false;
        };
        let text = lines.decode(line);
        let text = text.trim_end_matches([separator, ' ']);
        match text {
            "***Start_Special***" => is_in_special = true,
            "***End_Special***" => is_in_special = false,
            _ if is_in_special => special += 1,
            _ if text.starts_with(END_OF_HEADER) => break true,
            "" => {}
            _ => {
                let mut cells = text.split(separator).map(|cell| cell.trim().to_string());
                let key = cells.next().unwrap_or_default();
                keys.push((key, cells.collect()));
            }
        }
    };
    if special > 0 {
        log.repairs.push(Repair {
            kind: "lines-skipped",
            message: format!("{special} lines of special blocks skipped"),
        });
    }
    match (is_complete, keys.is_empty()) {
        (false, true) => return Ok(None),
        (false, false) => {
            return Err(lines.error(
                Code::CorruptFile,
                first_line,
                b"",
                format!("the file ends inside the header of a segment, without {END_OF_HEADER}"),
            ));
        }
        (true, _) => {}
    }
    if let Some((_, notes)) = keys.iter().find(|(key, _)| key == "Notes") {
        log.metadata.push(("Notes".to_string(), notes.join(" ")));
    }
    let headings = lines
        .next_line()
        .map(|line| lines.decode(line))
        .unwrap_or_default();
    let headings: Vec<&str> = headings.split(separator).map(str::trim).collect();
    let header = assign_columns(&keys, &headings, file, lines, first_line)?;
    Ok(Some(header))
}

/// Assigns its column and the values of the keys to every channel.
fn assign_columns(
    keys: &[(String, Vec<String>)],
    headings: &[&str],
    file: &FileHeader,
    lines: &LineReader<'_>,
    first_line: usize,
) -> Result<SegmentHeader, Error> {
    let values = |key: &str| {
        keys.iter()
            .find(|(k, _)| k == key)
            .map(|(_, v)| v.as_slice())
    };
    let stated_count = values("Channels")
        .and_then(|v| v.first())
        .and_then(|v| v.parse().ok());
    let is_channel =
        |(index, name): &(usize, &&str)| *index > 0 && **name != "X_Value" && **name != "Comment";
    let named_count = headings.iter().enumerate().filter(is_channel).count();
    let count = stated_count.unwrap_or(named_count);
    if count == 0 || count > MAX_CHANNELS {
        let message = format!("the header of the segment states {count} channels");
        return Err(lines.error(Code::CorruptFile, first_line, b"", message));
    }
    let per_channel = if file.abscissa == AbscissaLayout::Multi {
        2
    } else {
        1
    };
    let parse_count = |cell: &str| cell.parse::<usize>().ok();
    let channel = |index: usize| {
        let column = per_channel * index + 1;
        // With an abscissa for each channel, the keys have a blank cell for every abscissa.
        let cell = |key: &str| -> String {
            let cells = values(key).unwrap_or_default();
            let has_abscissa_cells = per_channel == 2 && cells.len() > count;
            let cell_index = if has_abscissa_cells { 2 * index } else { index };
            cells.get(cell_index).cloned().unwrap_or_default()
        };
        let name = headings.get(column).copied().unwrap_or_default();
        LvmChannel {
            name: match name {
                "" => format!("column {}", column + 1),
                name => name.to_string(),
            },
            unit: cell("Y_Unit_Label"),
            x_dimension: cell("X_Dimension"),
            samples: parse_count(&cell("Samples")).filter(|_| file.has_segment_headers),
            first_packet: parse_count(&cell("Samples")).filter(|_| !file.has_segment_headers),
            x0: parse_number(&cell("X0")).unwrap_or(0.0),
            delta_x: parse_number(&cell("Delta_X")).filter(|dx| *dx > 0.0),
            date: cell("Date"),
            time: cell("Time"),
            column,
            x_column: match file.abscissa {
                AbscissaLayout::No => None,
                AbscissaLayout::FirstColumn => Some(0),
                AbscissaLayout::Multi => Some(column - 1),
            },
        }
    };
    Ok(SegmentHeader {
        channels: (0..count).map(channel).collect(),
        columns: per_channel * (count - 1) + 2,
    })
}

/// A finite number with a decimal point or comma.
fn parse_number(cell: &str) -> Option<f64> {
    let number: f64 = cell.replace(',', ".").parse().ok()?;
    number.is_finite().then_some(number)
}
