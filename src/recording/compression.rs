//! gzip and zip decompression of a log file.

use std::io::{Read, Seek};

use flate2::read::MultiGzDecoder;
use zip::ZipArchive;
use zip::result::ZipError;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::text;

/// The first bytes of gzip.
pub const GZIP: &[u8] = &[0x1f, 0x8b];

/// The first bytes of zip.
pub const ZIP: &[u8] = b"PK\x03\x04";

/// Ends of names that logs have.
const LOG_EXTENSIONS: &[&str] = &[
    ".csv", ".txt", ".tsv", ".dat", ".asc", ".log", ".lvm", ".uff", ".unv", ".wav", ".mat",
];

/// Decompressed contents of a gzip stream.
pub fn gunzip<R: Read>(reader: R) -> impl Read {
    MultiGzDecoder::new(reader)
}

/// The archive's only log: its index, and its name.
///
/// # Errors
/// The archive is broken, empty, or holds several members none or several of which are logs.
pub fn find_log_member<R: Read + Seek>(
    path: &str,
    archive: &mut ZipArchive<R>,
) -> Result<(usize, String), Error> {
    let mut members = Vec::new();
    for index in 0..archive.len() {
        let member = archive
            .by_index_raw(index)
            .map_err(|e| invalid_archive(path, &e))?;
        let name = member.name().to_string();
        let hidden = name.starts_with("__MACOSX/")
            || name.rsplit('/').next().is_some_and(|n| n.starts_with('.'));
        if member.is_file() && !hidden {
            members.push((index, name));
        }
    }
    if let [only] = members.as_slice() {
        return Ok(only.clone());
    }
    let is_log = |name: &str| {
        let name = name.to_lowercase();
        LOG_EXTENSIONS.iter().any(|end| name.ends_with(end))
    };
    let logs: Vec<&(usize, String)> = members.iter().filter(|m| is_log(&m.1)).collect();
    match logs.as_slice() {
        [only] => Ok((*only).clone()),
        _ if members.is_empty() => Err(Error::new(
            Code::EmptyLog,
            format!("{path} is a zip archive without members"),
        )
        .with_hint("check whether the right file was named")),
        _ if members.iter().any(|m| m.1 == "[Content_Types].xml") => Err(Error::new(
            Code::UnknownFormat,
            format!("{path} is an Office document, which is not read"),
        )
        .with_hint("save the sheet as CSV")),
        _ => Err(Error::new(
            Code::UnknownFormat,
            format!(
                "{path} contains {} files: {}",
                members.len(),
                text::quoted_list(members.iter().map(|m| m.1.as_str()))
            ),
        )
        .with_hint("unpack it and name the one that is the log")),
    }
}

/// The error of an archive that breaks its rules.
pub fn invalid_archive(path: &str, why: &ZipError) -> Error {
    Error::new(
        Code::CorruptFile,
        format!("{path} is a zip archive that cannot be unpacked: {why}"),
    )
    .with_hint("copy it again, or unpack it and name the log inside")
}
