//! LVM headers: keys with one value for the file or one per channel.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::source_span::SourceSpan;
use crate::recording::raw::{RawLog, Repair};
use crate::recording::read_options::ReadOptions;

/// Line that ends a header.
const END_OF_HEADER: &str = "***End_of_Header***";

/// Most channels; a wrong count allocates no more than this justifies.
const MAX_CHANNELS: usize = 1 << 16;

/// Lines of the file, from front to back.
pub(super) struct LineReader<'a> {
    path: &'a str,
    rest: &'a [u8],
    /// Number of the next line, from 1.
    pub number: usize,
    encoding: Option<&'static encoding_rs::Encoding>,
}

impl<'a> LineReader<'a> {
    pub fn new(path: &'a str, bytes: &'a [u8], options: &ReadOptions) -> LineReader<'a> {
        let label = options.dialect.encoding.as_deref();
        LineReader {
            path,
            rest: bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes),
            number: 1,
            encoding: label.and_then(|l| encoding_rs::Encoding::for_label(l.as_bytes())),
        }
    }

    /// The next line without its end, not taken.
    pub fn peek(&self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let end = memchr::memchr(b'\n', self.rest).unwrap_or(self.rest.len());
        let line = &self.rest[..end];
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    /// Takes the next line.
    pub fn next_line(&mut self) -> Option<&'a [u8]> {
        let line = self.peek()?;
        let end = memchr::memchr(b'\n', self.rest).map_or(self.rest.len(), |at| at + 1);
        self.rest = &self.rest[end..];
        self.number += 1;
        Some(line)
    }

    /// An error at a line, from 1.
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

    /// Text of a line: UTF-8 where it is that, else Windows-1252, the superset of Latin-1.
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
    /// Nowhere: the first column is blank.
    No,
    /// In the first column.
    FirstColumn,
    /// Before each channel.
    Multi,
}

/// Contents of the first header.
pub(super) struct FileHeader {
    pub separator: u8,
    pub abscissa: AbscissaLayout,
    /// Each segment has a header of its own; else `SampleEmitter` counts the first packet alone.
    pub many_headers: bool,
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
        many_headers: false,
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
            "Multi_Headings" => file.many_headers = value == "Yes",
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
    /// Columns hold comments from here on.
    pub columns: usize,
}

/// One channel of a segment.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct LvmChannel {
    pub name: String,
    pub unit: String,
    pub x_dimension: String,
    /// Samples the header states of the segment.
    pub samples: Option<usize>,
    /// Samples of the first packet of several, all that the header of a file with a single one states.
    pub first_packet: Option<usize>,
    pub x0: f64,
    pub delta_x: Option<f64>,
    pub date: String,
    pub time: String,
    /// Column of the channel, and that of its abscissa.
    pub column: usize,
    pub x_column: Option<usize>,
}

/// Reads the next segment's header and the line of headings under it; `None` at the end of the file.
pub(super) fn read_segment_header(
    lines: &mut LineReader<'_>,
    file: &FileHeader,
    log: &mut RawLog,
) -> Result<Option<SegmentHeader>, Error> {
    let separator = char::from(file.separator);
    let mut keys: Vec<(String, Vec<String>)> = Vec::new();
    let mut inside_special = false;
    let mut special = 0;
    let first_line = lines.number;
    let ended = loop {
        let Some(line) = lines.next_line() else {
            break false;
        };
        let text = lines.decode(line);
        let text = text.trim_end_matches([separator, ' ']);
        match text {
            "***Start_Special***" => inside_special = true,
            "***End_Special***" => inside_special = false,
            _ if inside_special => special += 1,
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
            message: format!("{special} lines of special blocks passed over"),
        });
    }
    match (ended, keys.is_empty()) {
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

/// Gives every channel its column and what the keys say of it.
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
    let n_stated = values("Channels")
        .and_then(|v| v.first())
        .and_then(|v| v.parse().ok());
    let is_channel =
        |(at, name): &(usize, &&str)| *at > 0 && **name != "X_Value" && **name != "Comment";
    let named = headings.iter().enumerate().filter(is_channel).count();
    let count = n_stated.unwrap_or(named);
    if count == 0 || count > MAX_CHANNELS {
        let message = format!("the header of the segment states {count} channels");
        return Err(lines.error(Code::CorruptFile, first_line, b"", message));
    }
    let per_channel = if file.abscissa == AbscissaLayout::Multi {
        2
    } else {
        1
    };
    let stated = |cell: &str| cell.parse::<usize>().ok();
    let channel = |at: usize| {
        let column = per_channel * at + 1;
        // Keys of files with an abscissa for each channel leave a cell blank for it.
        let cell = |key: &str| -> String {
            let cells = values(key).unwrap_or_default();
            let is_spread = per_channel == 2 && cells.len() > count;
            let place = if is_spread { 2 * at } else { at };
            cells.get(place).cloned().unwrap_or_default()
        };
        let name = headings.get(column).copied().unwrap_or_default();
        LvmChannel {
            name: match name {
                "" => format!("column {}", column + 1),
                name => name.to_string(),
            },
            unit: cell("Y_Unit_Label"),
            x_dimension: cell("X_Dimension"),
            samples: stated(&cell("Samples")).filter(|_| file.many_headers),
            first_packet: stated(&cell("Samples")).filter(|_| !file.many_headers),
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
