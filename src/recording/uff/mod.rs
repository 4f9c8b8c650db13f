//! UFF 58 files, text and binary: data sets "function at nodal degree of freedom".
//!
//! A data set is enclosed by two lines `-1`; its first line is its number. Source: Structural Dynamics Research
//! Corporation, “Universal File Datasets Summary”, data sets 58 and 58b; 15, 82 and 2411 for geometry; 164 for units. Other data sets
//! (mode shapes, elements) are skipped with a repair note.

pub(super) mod codes;

mod header;

mod cursor;

mod values;

mod names;

mod geometry;

mod assemble;

use std::collections::BTreeMap;

use cursor::{UffCursor, is_delimiter};
use geometry::UffGeometry;
use header::UffHeader;
use values::{BinaryHeader, UffValues};

use super::raw::{RawLog, Repair};
use super::read_options::ReadOptions;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error, Errors};
use crate::base::text::pluralise;

/// Number of header lines after the line with the number of the data set.
const HEADER_LINES: usize = 11;

/// Units code of data set 164 for SI.
const UNITS_SI: i64 = 1;

/// Data set 58: header and values.
struct DataSet58 {
    header: UffHeader,
    values: UffValues,
    is_binary: bool,
}

/// Reads a UFF file.
///
/// Time responses become channels, those of equal abscissa in one group; frequency responses with their coherence and
/// their nodes become responses; other functions of frequency become spectra.
///
/// # Errors
/// `broken-file` with the line, `empty-log` if no data set 58 holds values, `unknown-format` if the first line is
/// not `-1` or the floats are not those of IEEE 754.
pub fn read(path: &str, bytes: &[u8], options: &ReadOptions) -> Result<RawLog, Errors> {
    let mut log = RawLog {
        path: path.to_string(),
        ..RawLog::default()
    };
    let mut reader = UffReader::default();
    reader.read(&mut UffCursor::new(path, bytes), options, &mut log)?;
    reader.report_skipped(&mut log);
    let is_si = reader.units_code.is_none_or(|code| code == UNITS_SI);
    let has_binary = reader.data_sets.iter().any(|set| set.is_binary);
    let has_text = reader.data_sets.iter().any(|set| !set.is_binary);
    let kind = match (has_text, has_binary) {
        (true, true) => "text and binary",
        (false, true) => "binary",
        _ => "text",
    };
    log.dialect = format!(
        "UFF 58, {kind}, {}",
        pluralise(reader.data_sets.len(), "function")
    );
    reader.data_sets.retain(|set| !set.values.re.is_empty());
    let channels = assemble::channel_places(&reader.data_sets);
    let length_unit = reader.length_unit.unwrap_or(1.0);
    reader.geometry.finish(length_unit, channels, &mut log)?;
    if reader.data_sets.is_empty() {
        let skipped: Vec<String> = reader.skipped.keys().map(i64::to_string).collect();
        let held = match skipped.len() {
            0 if !log.geometry.is_empty() => "geometry".to_string(),
            0 => "no data set at all".to_string(),
            _ => format!("data sets {}", skipped.join(", ")),
        };
        return Err(Error::new(
            Code::EmptyLog,
            format!("the UFF file contains no data set 58 with values, only {held}"),
        )
        .with_hint("signals and frequency responses are in data sets 58: export these as well")
        .into());
    }
    assemble::assemble(reader.data_sets, is_si, options, &mut log)?;
    Ok(log)
}

/// Data sets read so far.
#[derive(Default)]
struct UffReader {
    data_sets: Vec<DataSet58>,
    /// Number of skipped data sets by their type number.
    skipped: BTreeMap<i64, usize>,
    /// Number of lines outside of any data set.
    stray_lines: usize,
    units_code: Option<i64>,
    /// Length unit of the coordinates, m.
    length_unit: Option<f64>,
    geometry: UffGeometry,
}

impl UffReader {
    fn read(
        &mut self,
        cursor: &mut UffCursor<'_>,
        options: &ReadOptions,
        log: &mut RawLog,
    ) -> Result<(), Error> {
        cursor.skip_blank();
        if !is_delimiter(cursor.peek()) {
            return Err(Error::new(
                Code::UnknownFormat,
                "a UFF file begins with a line `-1`, and this one does not",
            ));
        }
        while !cursor.rest.is_empty() {
            let Some(line) = cursor.next_line() else {
                break;
            };
            if !is_delimiter(line) {
                self.stray_lines += 1;
                cursor.skip_blank();
                continue;
            }
            // Delimiters may be repeated.
            cursor.skip_blank();
            if cursor.rest.is_empty() || is_delimiter(cursor.peek()) {
                continue;
            }
            self.read_data_set(cursor, options, log)?;
            cursor.skip_blank();
        }
        Ok(())
    }

    /// Reads a data set from the line with its number to its closing delimiter.
    fn read_data_set(
        &mut self,
        cursor: &mut UffCursor<'_>,
        options: &ReadOptions,
        log: &mut RawLog,
    ) -> Result<(), Error> {
        let first_line = cursor.line;
        let title = String::from_utf8_lossy(cursor.next_line().unwrap_or_default()).into_owned();
        let title = title.trim();
        let digits = title.bytes().take_while(u8::is_ascii_digit).count();
        let number: i64 = title[..digits].parse().map_err(|_| {
            let shown: String = title.chars().take(24).collect();
            cursor.error(
                first_line,
                title,
                format!("`{shown}` in place of the number of a data set"),
            )
        })?;
        if geometry::DATA_SETS.contains(&number) {
            self.geometry.read(number, first_line, cursor)?;
            return Ok(());
        }
        if number != 58 {
            *self.skipped.entry(number).or_default() += 1;
            if number == 164 {
                let line = String::from_utf8_lossy(cursor.peek()).into_owned();
                let code: String = line.chars().take(10).collect();
                self.units_code = code.trim().parse().ok();
                cursor.next_line();
                let factors = String::from_utf8_lossy(cursor.peek()).replace(['D', 'd'], "E");
                let length = factors.split_whitespace().next();
                // Numbers of the file divided by the factor are SI.
                let factor = length.and_then(|text| text.parse::<f64>().ok());
                self.length_unit = factor.filter(|f| *f > 0.0 && f.is_finite()).map(f64::recip);
            }
            cursor.skip_to_delimiter();
            cursor.next_line();
            return Ok(());
        }
        let rest = &title[digits..];
        let binary = rest.starts_with(['b', 'B']);
        let binary = binary.then(|| parse_binary_title(rest)).transpose();
        let binary = binary.map_err(|(code, message)| Error {
            code,
            ..cursor.error(first_line, title, message)
        })?;
        let mut lines = Vec::with_capacity(HEADER_LINES);
        while lines.len() < HEADER_LINES {
            match cursor.next_line() {
                Some(line) => lines.push(decode(line, options)),
                None => break,
            }
        }
        let header = header::parse(&lines).map_err(|(at, message)| {
            let text = lines.get(at).map_or("", String::as_str);
            cursor.error(first_line + 1 + at, text, message)
        })?;
        let values = match binary {
            Some(binary) => values::read_binary(cursor, &header, binary)?,
            None => values::read_text(cursor, &header)?,
        };
        self.read_end_delimiter(cursor, &header, &values, first_line, log)?;
        self.data_sets.push(DataSet58 {
            header,
            values,
            is_binary: binary.is_some(),
        });
        Ok(())
    }

    /// Reads the closing delimiter; warns if the header states another number of values than the data set holds.
    fn read_end_delimiter(
        &self,
        cursor: &mut UffCursor<'_>,
        header: &UffHeader,
        values: &UffValues,
        first_line: usize,
        log: &mut RawLog,
    ) -> Result<(), Error> {
        cursor.skip_blank();
        let is_complete = values.re.len() == header.count;
        if cursor.rest.is_empty() && !is_complete {
            let message = format!(
                "the data set 58 at line {first_line} states {} values and the file ends after {}",
                header.count,
                values.re.len()
            );
            return Err(cursor
                .error_here(message)
                .with_hint("the file was cut off: copy it again"));
        }
        if cursor.rest.is_empty() && !cursor.ended {
            let message = format!(
                "the file ends within the data set 58 at line {first_line}: its last number may be cut short"
            );
            return Err(cursor
                .error_here(message)
                .with_hint("the file was cut off: copy it again"));
        }
        // Remains of an older, longer file may follow the delimiter on its line.
        if !cursor.rest.is_empty() && !cursor.peek().starts_with(b"-1") {
            return Err(cursor.error_here(format!(
                "the mark -1 is missing here, after {} values",
                header.count
            )));
        }
        cursor.next_line();
        if !is_complete {
            log.diagnostics.push(Diagnostic {
                code: "values-missing",
                message: format!(
                    "the data set 58 at line {first_line} states {} values but contains {}",
                    header.count,
                    values.re.len()
                ),
                hint: Some("check whether the file was shortened by hand".into()),
            });
        }
        Ok(())
    }

    fn report_skipped(&self, log: &mut RawLog) {
        if !self.skipped.is_empty() {
            let counts = self
                .skipped
                .iter()
                .map(|(number, times)| format!("{number} ({times} ×)"));
            log.repairs.push(Repair {
                kind: "sets-skipped",
                message: format!(
                    "data sets other than 15, 58, 82 and 2411 skipped: {}",
                    counts.collect::<Vec<_>>().join(", ")
                ),
            });
        }
        if self.stray_lines > 0 {
            log.repairs.push(Repair {
                kind: "lines-skipped",
                message: format!("{} lines outside of any data set skipped", self.stray_lines),
            });
        }
    }
}

/// Parses byte order, float format and number of bytes after `58`: `b     1     2          11      889600`.
fn parse_binary_title(rest: &str) -> Result<BinaryHeader, (Code, String)> {
    let error = |message: &str| Err((Code::CorruptFile, message.to_string()));
    let mut fields = rest[1..].split_whitespace().map(str::parse::<usize>);
    let mut field = || fields.next().and_then(Result::ok);
    let (order, floats, _lines, bytes) = (field(), field(), field(), field());
    match floats {
        Some(2) => {}
        Some(1) => return Err(unsupported_float_format("DEC VMS")),
        Some(3) => return Err(unsupported_float_format("IBM 370")),
        _ => {
            return error("the format of floats is not 1, 2 or 3");
        }
    }
    let is_big_endian = match order {
        Some(1) => false,
        Some(2) => true,
        _ => {
            return error("the byte order is neither 1 (little) nor 2 (big)");
        }
    };
    Ok(BinaryHeader {
        is_big_endian,
        bytes: bytes.unwrap_or(0),
    })
}

fn unsupported_float_format(machine: &str) -> (Code, String) {
    let message = format!(
        "the data set 58b holds floats of {machine}; those of IEEE 754 are read, and text is whatever the machine"
    );
    (Code::UnknownFormat, message)
}

/// Decodes a header line: in the stated encoding, else as UTF-8 if valid, else as Windows-1252, a superset of Latin-1.
fn decode(line: &[u8], options: &ReadOptions) -> String {
    let stated = options.dialect.encoding.as_deref();
    let stated = stated.and_then(|label| encoding_rs::Encoding::for_label(label.as_bytes()));
    match (stated, std::str::from_utf8(line)) {
        (Some(encoding), _) => encoding.decode_without_bom_handling(line).0.into_owned(),
        (None, Ok(text)) => text.to_string(),
        (None, Err(_)) => encoding_rs::WINDOWS_1252
            .decode_without_bom_handling(line)
            .0
            .into_owned(),
    }
}
