//! LabVIEW measurement files (LVM): a file header, then segments, each with a header and rows.
//!
//! National Instruments, “Specification for the LabVIEW Measurement File (.lvm)”. Cells stand apart by tabs or commas,
//! the decimal mark is a point or a comma whatever the header says, `X_Columns` is `No`, `One` or `Multi`, a last column
//! may hold comments.

mod header;

mod rows;

mod assemble;

use super::raw::{RawLog, Repair};
use super::read_options::ReadOptions;
use crate::base::code::Code;
use crate::base::error::{Error, Errors};

/// Reads an LVM file whole.
///
/// Channels with the same abscissa make a group; a channel shorter than the others one of its own. Segments of the same
/// channels follow each other in time by their date, time and `X0`; where those do not rise, each segment is a group.
/// Both the rate of the header and the stamps of the rows are handed on. Channels named after a Fourier transform are
/// spectra, whatever `X_Dimension` says.
///
/// # Errors
/// `broken-file`; `ragged-row` and `not-a-number` with the line, unless it is the last of the file, which is a repair; `empty-log` where no row holds a number.
pub fn read(path: &str, bytes: &[u8], options: &ReadOptions) -> Result<RawLog, Errors> {
    let mut lines = header::LineReader::new(path, bytes, options);
    let file = header::read_file_header(&mut lines)?;
    let mut log = RawLog {
        path: path.to_string(),
        ..RawLog::default()
    };
    let mut segments = Vec::new();
    while let Some(segment) = header::read_segment_header(&mut lines, &file, &mut log)? {
        let segment = rows::read_segment(&mut lines, &file, segment)?;
        if let Some((line, text)) = &segment.cut {
            let text = crate::base::quantity::truncate(text.trim());
            log.repairs.push(Repair {
                kind: "row-incomplete",
                message: format!(
                    "the last row, line {line}, breaks off and is left out: \"{text}\""
                ),
            });
        }
        segments.push(segment);
    }
    if segments.iter().all(|segment| segment.rows == 0) {
        return Err(Error::new(Code::EmptyLog, "the LVM file holds no row of numbers").into());
    }
    let mark = match segments.iter().any(|segment| segment.has_comma) {
        true => "decimal comma",
        false => "decimal point",
    };
    log.dialect = format!(
        "LabVIEW LVM, {}, {mark}, {} segment{}",
        if file.separator == b'\t' {
            "tab"
        } else {
            "comma"
        },
        segments.len(),
        if segments.len() == 1 { "" } else { "s" },
    );
    log.metadata.extend(file.metadata);
    assemble::assemble(segments, options, &mut log)?;
    Ok(log)
}
