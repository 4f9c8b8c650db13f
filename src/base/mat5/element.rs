//! The header of a MATLAB file of level 5, and its elements: a tag of type and length, then data.

use super::number_format::ByteOrder;
use super::types;
use crate::base::code::Code;
use crate::base::error::Error;

/// Bytes of the header.
pub(super) const HEADER_BYTES: usize = 128;

/// Description and byte order; refuses the other levels by name.
pub(super) fn header(bytes: &[u8]) -> Result<(String, ByteOrder), Error> {
    if bytes.starts_with(b"MATLAB 7.3") || bytes.starts_with(b"\x89HDF") {
        return Err(Error::new(
            Code::UnknownFormat,
            "the file is a MATLAB file of version 7.3, which is HDF5 inside and is not read",
        )
        .with_hint("save it again in MATLAB with save(\"name.mat\", \"-v7\")"));
    }
    let head = bytes.first_chunk::<4>();
    if head.is_some_and(|head| head.contains(&0)) {
        return Err(Error::new(
            Code::UnknownFormat,
            "the file appears to be a MATLAB file of level 4, which is not read",
        )
        .with_hint("load it in MATLAB and save it with save(\"name.mat\", \"-v7\")"));
    }
    let order = match bytes.get(126..HEADER_BYTES) {
        Some(b"IM") => ByteOrder::Little,
        Some(b"MI") => ByteOrder::Big,
        Some(_) => {
            return Err(Error::new(
                Code::UnknownFormat,
                "the file has no byte-order mark of MATLAB level 5 at byte 126",
            ));
        }
        None => {
            return Err(corrupt(format!(
                "the header of the MATLAB file has {} of 128 bytes",
                bytes.len()
            )));
        }
    };
    let description = String::from_utf8_lossy(&bytes[..116]);
    let description = description.trim_end_matches([' ', '\0']).to_string();
    Ok((description, order))
}

/// A tag with its data.
pub(super) struct DataElement<'a> {
    pub kind: u32,
    pub data: &'a [u8],
}

impl<'a> DataElement<'a> {
    /// Takes the first element, and what fills it up to eight bytes, off `rest`.
    pub fn split(rest: &mut &'a [u8], order: ByteOrder) -> Result<DataElement<'a>, Error> {
        let word = |at: usize| {
            let bytes = rest.get(at..at + 4).and_then(|b| b.first_chunk::<4>());
            bytes
                .map(|&b| order.u32(b))
                .ok_or_else(|| corrupt("the MATLAB file ends inside a tag"))
        };
        let first = word(0)?;
        // A small element has its length in the upper half of the first word and up to four bytes in the second.
        let (kind, length, start) = match first >> 16 {
            0 => (first, word(4)? as usize, 8),
            small => (first & 0xFFFF, small as usize, 4),
        };
        if start == 4 && length > 4 {
            return Err(corrupt(format!(
                "a small element of the MATLAB file claims {length} bytes of the 4 it has"
            )));
        }
        let end = start + length;
        let Some(data) = rest.get(start..end) else {
            return Err(corrupt(format!(
                "an element of the MATLAB file claims {length} bytes where {} are left",
                rest.len().saturating_sub(start)
            ))
            .with_hint("the file was cut off or damaged: copy it again"));
        };
        // Compressed elements alone are not filled up.
        let filled = match kind {
            types::COMPRESSED => end,
            _ => end.next_multiple_of(8),
        };
        *rest = rest.get(filled..).unwrap_or(&[]);
        Ok(DataElement { kind, data })
    }
}

pub(super) fn corrupt(message: impl Into<String>) -> Error {
    Error::new(Code::CorruptFile, message)
}
