//! Arrays to bytes of a MATLAB file of level 5: little-endian, uncompressed.
//!
//! A file is the `header` and then its variables, each the bytes of one of the functions below.

use std::io;

use super::{classes, types};

/// Space for the description in the header, bytes.
const DESCRIPTION: usize = 116;

/// A complex array, among the flags of an array.
const COMPLEX: u32 = 0x0800;

/// The 128 bytes a file begins with; `description` is cut after 80 characters, and shown by `load` and `file`.
pub fn header(description: &str) -> Vec<u8> {
    let text: String = format!("MATLAB 5.0 MAT-file, written by geardyn: {description}")
        .chars()
        .map(|c| if c.is_ascii() { c } else { '?' })
        .take(DESCRIPTION)
        .collect();
    let mut header = format!("{text:DESCRIPTION$}").into_bytes();
    header.extend([0; 8]); // no subsystem data
    header.extend(0x0100u16.to_le_bytes());
    header.extend(b"IM");
    header
}

/// A real matrix of `[rows, columns]`, its values by columns.
///
/// # Errors
/// More than 4 GB, which the format cannot hold.
pub fn real(
    name: &str,
    dimensions: [usize; 2],
    values: impl IntoIterator<Item = f64>,
) -> io::Result<Vec<u8>> {
    array(name, classes::DOUBLE, dimensions, &doubles(values)?)
}

/// A complex matrix of `[rows, columns]`, its real and imaginary parts by columns.
///
/// # Errors
/// More than 4 GB, which the format cannot hold.
pub fn complex(
    name: &str,
    dimensions: [usize; 2],
    re: impl IntoIterator<Item = f64>,
    im: impl IntoIterator<Item = f64>,
) -> io::Result<Vec<u8>> {
    let mut contents = doubles(re)?;
    contents.extend(doubles(im)?);
    array(name, classes::DOUBLE | COMPLEX, dimensions, &contents)
}

/// A row of characters.
///
/// # Errors
/// More than 4 GB, which the format cannot hold.
pub fn text(name: &str, value: &str) -> io::Result<Vec<u8>> {
    let units: Vec<u16> = value.encode_utf16().collect();
    let bytes: Vec<u8> = units.iter().flat_map(|u| u.to_le_bytes()).collect();
    // As UTF-16 rather than 16-bit integers, which scipy cuts to bytes.
    let contents = element(types::UTF16, &bytes)?;
    array(name, classes::CHAR, [1, units.len()], &contents)
}

/// A column of cells, each the bytes of an array without a name.
///
/// # Errors
/// More than 4 GB, which the format cannot hold.
pub fn cell_array(name: &str, arrays: &[Vec<u8>]) -> io::Result<Vec<u8>> {
    array(name, classes::CELL, [arrays.len(), 1], &arrays.concat())
}

/// A column of cells that hold text.
///
/// # Errors
/// More than 4 GB, which the format cannot hold.
pub fn cell_strings(name: &str, values: &[String]) -> io::Result<Vec<u8>> {
    let arrays: io::Result<Vec<Vec<u8>>> = values.iter().map(|value| text("", value)).collect();
    cell_array(name, &arrays?)
}

/// An element of doubles.
fn doubles(values: impl IntoIterator<Item = f64>) -> io::Result<Vec<u8>> {
    let bytes: Vec<u8> = values.into_iter().flat_map(f64::to_le_bytes).collect();
    element(types::DOUBLE, &bytes)
}

/// A tag and its data, filled up to eight bytes.
fn element(kind: u32, data: &[u8]) -> io::Result<Vec<u8>> {
    let length = u32::try_from(data.len())
        .map_err(|_| io::Error::other("a MATLAB level 5 file takes arrays up to 4 GB"))?;
    let mut bytes = Vec::with_capacity(data.len() + 16);
    bytes.extend(kind.to_le_bytes());
    bytes.extend(length.to_le_bytes());
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    Ok(bytes)
}

/// An array: flags with its class, dimensions, name, then its contents.
fn array(name: &str, flags: u32, dimensions: [usize; 2], contents: &[u8]) -> io::Result<Vec<u8>> {
    let mut data = element(types::UINT32, &[flags.to_le_bytes(), [0; 4]].concat())?;
    let [rows, columns] = dimensions.map(|d| (d as u32).to_le_bytes());
    data.extend(element(types::INT32, &[rows, columns].concat())?);
    data.extend(element(types::INT8, name.as_bytes())?);
    data.extend(contents);
    element(types::MATRIX, &data)
}
