//! Opening of a log file: format detection from the first bytes (magic numbers), then the reader.

use std::fs::File;
use std::io::{self, Cursor, Read, Seek, SeekFrom};

use zip::ZipArchive;

use super::raw::RawLog;
use super::read_options::ReadOptions;
use super::{compression, lvm, mat, text, uff, wav};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};

/// Number of bytes from which the format is detected.
const SNIFF_LEN: usize = 4096;

/// Maximum nesting depth of containers.
const MAX_NESTING: usize = 3;

/// Reads a log.
///
/// # Errors
/// The file cannot be read, is of no known format, or breaks the rules of its format.
pub fn open(path: &str, options: &ReadOptions) -> Result<RawLog, Errors> {
    open_with_progress(path, options, &|_| {})
}

/// Reads a log and says from time to time which share of the file is read.
///
/// # Errors
/// As for [`open`].
pub fn open_with_progress(
    path: &str,
    options: &ReadOptions,
    progress: &dyn Fn(f64),
) -> Result<RawLog, Errors> {
    let mut log = open_file(path, options, progress).map_err(|e| e.with_file(path))?;
    log.repairs
        .splice(0..0, options.sidecar_reports.iter().cloned());
    Ok(log)
}

/// Reads the log in a file.
fn open_file(path: &str, options: &ReadOptions, progress: &dyn Fn(f64)) -> Result<RawLog, Errors> {
    let missing =
        |message: String, hint: &str| Error::new(Code::FileMissing, message).with_hint(hint);
    const HINT_RELATIVE_PATH: &str =
        "paths are relative to the working folder; a path in a file, to the folder of that file";
    const HINT_PERMISSION: &str = "the file exists: ask its owner for read permission";
    let unreadable = |e: io::Error| {
        let is_kept = e.kind() == io::ErrorKind::PermissionDenied;
        let hint = if is_kept {
            HINT_PERMISSION
        } else {
            HINT_RELATIVE_PATH
        };
        missing(format!("{path} cannot be read: {e}"), hint)
    };
    let facts = std::fs::metadata(path).map_err(unreadable)?;
    if !facts.is_file() {
        let what = if facts.is_dir() {
            "a folder"
        } else {
            "a device or a pipe"
        };
        let hint = "a log is read from a file: write what a pipe brings into one and name that";
        return Err(missing(format!("{path} is {what}, not a file"), hint).into());
    }
    let mut file = ProgressReader {
        file: File::open(path).map_err(unreadable)?,
        read: 0,
        size: facts.len(),
        progress,
    };
    let head = read_prefix(path, &mut file)?;
    file.seek(SeekFrom::Start(0)).map_err(unreadable)?;
    if head.starts_with(compression::ZIP) {
        return unzip(path, file, options, MAX_NESTING);
    }
    read_stream(path, &mut file, options, MAX_NESTING)
}

/// Reads a log from memory; `path` is what it is called in messages.
///
/// # Errors
/// As for [`open`].
pub fn from_bytes(path: &str, bytes: &[u8], options: &ReadOptions) -> Result<RawLog, Errors> {
    let read = match bytes.starts_with(compression::ZIP) {
        true => unzip(path, Cursor::new(bytes), options, MAX_NESTING),
        false => read_stream(path, &mut Cursor::new(bytes), options, MAX_NESTING),
    };
    read.map_err(|e| e.with_file(path))
}

/// A file that says how much of it is read.
struct ProgressReader<'p> {
    file: File,
    read: u64,
    size: u64,
    progress: &'p dyn Fn(f64),
}

impl Read for ProgressReader<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(bytes)?;
        self.read += count as u64;
        (self.progress)((self.read as f64 / self.size.max(1) as f64).min(1.0));
        Ok(count)
    }
}

impl Seek for ProgressReader<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.read = self.file.seek(to)?;
        Ok(self.read)
    }
}

/// The first bytes of a stream.
fn read_prefix(path: &str, reader: &mut dyn Read) -> Result<Vec<u8>, Error> {
    let mut head = Vec::new();
    let read = reader.take(SNIFF_LEN as u64).read_to_end(&mut head);
    read.map(|_| head)
        .map_err(|e| text::body::read_error(path, &e))
}

/// Reads the only log of a zip archive.
fn unzip<R: Read + Seek>(
    path: &str,
    reader: R,
    options: &ReadOptions,
    depth: usize,
) -> Result<RawLog, Errors> {
    let mut archive =
        ZipArchive::new(reader).map_err(|e| compression::invalid_archive(path, &e))?;
    let (index, name) = compression::find_log_member(path, &mut archive)?;
    let mut member = archive
        .by_index(index)
        .map_err(|e| compression::invalid_archive(path, &e))?;
    let mut log = read_stream(path, &mut member, options, depth - 1)?;
    log.dialect = format!("zip ({name}), {}", log.dialect);
    Ok(log)
}

/// Reads a log from a stream, unpacking what is packed.
fn read_stream(
    path: &str,
    reader: &mut dyn Read,
    options: &ReadOptions,
    depth: usize,
) -> Result<RawLog, Errors> {
    let head = read_prefix(path, reader)?;
    let packed = head.starts_with(compression::GZIP) || head.starts_with(compression::ZIP);
    if packed && depth == 0 {
        let message = format!("{path} contains nested archives");
        return Err(Error::new(Code::UnknownFormat, message)
            .with_hint("unpack it and name the log inside")
            .into());
    }
    let mut whole = Cursor::new(&head).chain(reader);
    if head.starts_with(compression::GZIP) {
        let mut inner = compression::gunzip(whole);
        let mut raw_log = read_stream(path, &mut inner, options, depth - 1)?;
        raw_log.dialect = format!("gzip, {}", raw_log.dialect);
        return Ok(raw_log);
    }
    if head.starts_with(compression::ZIP) {
        let mut bytes = Vec::new();
        whole
            .read_to_end(&mut bytes)
            .map_err(|e| text::body::read_error(path, &e))?;
        return unzip(path, Cursor::new(bytes), options, depth - 1);
    }
    match reader_for(&head) {
        Some(read) => {
            let mut bytes = Vec::new();
            whole
                .read_to_end(&mut bytes)
                .map_err(|e| text::body::read_error(path, &e))?;
            read(path, &bytes, options)
        }
        None => {
            reject_unsupported(path, &head)?;
            text::read(path, whole, options)
        }
    }
}

/// Reads the bytes of one format.
type ReadFn = fn(&str, &[u8], &ReadOptions) -> Result<RawLog, Errors>;

/// The reader of a format that has its own; `None` for delimited text.
fn reader_for(head: &[u8]) -> Option<ReadFn> {
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    if text.trim_ascii_start().starts_with(b"LabVIEW Measurement") {
        Some(lvm::read)
    } else if head.starts_with(b"RIFF") && head.get(8..12) == Some(b"WAVE") {
        Some(wav::read)
    } else if head.starts_with(b"MATLAB 5.0") {
        Some(mat::read)
    } else if is_uff(text) {
        Some(uff::read)
    } else {
        None
    }
}

/// Whether a text begins as a universal file: a line `-1`, then the number of a data set, `58` or `58b` with more on its line.
fn is_uff(text: &[u8]) -> bool {
    /// Columns of the mark and of the number, right-justified.
    const COLUMNS: usize = 6;
    let mut lines = text
        .split(|b| *b == b'\n')
        .map(<[u8]>::trim_ascii_end)
        .filter(|line| !line.is_empty());
    let (Some(mark), Some(set)) = (lines.next(), lines.next()) else {
        return false;
    };
    let by_columns = mark == b"    -1" && set.len() == COLUMNS;
    let (mark, set) = (mark.trim_ascii(), set.trim_ascii());
    if mark != b"-1" {
        return false;
    }
    if by_columns && set.iter().all(u8::is_ascii_digit) {
        return true;
    }
    let number = set
        .split(u8::is_ascii_whitespace)
        .next()
        .unwrap_or_default();
    let number = number.strip_suffix(b"b").unwrap_or(number);
    // A column of numbers may begin with -1 as well; its next number is hardly one of these.
    [
        &b"58"[..],
        b"151",
        b"164",
        b"55",
        b"15",
        b"82",
        b"2411",
        b"2412",
        b"2414",
        b"2420",
    ]
    .contains(&number)
}

/// Formats that are known and not read, by their first bytes, and what to do.
const UNSUPPORTED_FORMATS: &[(&[u8], &str, &str)] = &[
    (
        b"\x89HDF",
        "an HDF5 file",
        "export CSV; MATLAB writes level 5 with save(…, '-v7')",
    ),
    (
        b"MATLAB 7.3",
        "a MATLAB file of version 7.3",
        "save it as level 5: save(…, '-v7')",
    ),
    (
        b"\x93NUMPY",
        "a NumPy array",
        "write CSV: numpy.savetxt(…, delimiter=',', header=…)",
    ),
    (
        b"\x1a\x45\xdf\xa3",
        "an enDAQ .ide recording or another EBML file",
        "convert it to CSV or MATLAB level 5 with enDAQ Lab, or with the `ideexport` command of the Python package endaq-ide",
    ),
    (b"TDSm", "a LabVIEW TDMS file", "export LVM or CSV"),
    (b"MDF ", "an MDF file", "export CSV"),
    (b"%PDF", "a PDF document", "export the numbers as CSV"),
    (
        b"\xd0\xcf\x11\xe0",
        "an old Excel workbook",
        "save the sheet as CSV",
    ),
    (b"PAR1", "a Parquet file", "export CSV"),
    (
        b"{",
        "a JSON document",
        "`geardyn convert` writes CSV and UFF, which are read again",
    ),
];

/// Whether a file begins as a matrix of MATLAB's level 4: five numbers of 32 bits (type, rows, columns, imaginary part, length of the
/// name) and a name that ends in NUL. The MathWorks, “MAT-File Format”, chapter 2.
fn is_matlab_4(head: &[u8]) -> bool {
    const MAX_NAME: usize = 64;
    let number = |at: usize, read: fn([u8; 4]) -> u32| {
        let bytes = head.get(4 * at..4 * at + 4)?;
        bytes.try_into().ok().map(read)
    };
    [u32::from_le_bytes as fn([u8; 4]) -> u32, u32::from_be_bytes]
        .into_iter()
        .any(|read| {
            let fields: Option<Vec<u32>> = (0..5).map(|at| number(at, read)).collect();
            let Some(&[kind, _, _, imaginary, length]) = fields.as_deref() else {
                return false;
            };
            // Thousands: byte order, hundreds: zero, tens: precision, ones: full, text or sparse.
            let is_kind =
                kind <= 4052 && kind / 100 % 10 == 0 && kind / 10 % 10 <= 5 && kind % 10 <= 2;
            let name = head.get(20..20 + (length as usize).min(MAX_NAME + 1));
            let is_name = name
                .and_then(|n| n.split_last())
                .is_some_and(|(end, name)| {
                    *end == 0 && !name.is_empty() && name.iter().all(u8::is_ascii_graphic)
                });
            is_kind && imaginary <= 1 && is_name
        })
}

fn reject_unsupported(path: &str, head: &[u8]) -> Result<(), Error> {
    if is_matlab_4(head) {
        let message = format!("{path} is a MATLAB file of level 4, which is not read");
        return Err(Error::new(Code::UnknownFormat, message).with_hint(
            "save it as level 5: in MATLAB or Octave load it and save('new.mat', '-v7'), in Python scipy.io.loadmat and savemat",
        ));
    }
    match UNSUPPORTED_FORMATS
        .iter()
        .find(|(magic, ..)| head.starts_with(magic))
    {
        None => Ok(()),
        Some((_, what, hint)) => Err(Error::new(
            Code::UnknownFormat,
            format!("{path} is {what}, which is not read"),
        )
        .with_hint(*hint)),
    }
}
