//! Reader of MATLAB level-5 MAT-files: arrays of either byte order, compressed or not.
//!
//! Lengths are checked against the available bytes before memory is allocated.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::element::{DataElement, HEADER_BYTES, corrupt, header};
use super::number_format::{ByteOrder, NumberFormat};
use super::{classes, types};
use crate::base::code::Code;
use crate::base::error::Error;

/// Maximum nesting depth of cells and structures; a damaged file could nest without limit.
const MAX_DEPTH: usize = 32;

/// Maximum count of numbers in a file, 4 GB as doubles: bounds the memory that a small compressed file can claim.
const MAX_VALUES: usize = 1 << 29;

/// Maximum size of an unpacked variable, bytes: 4 GB is the limit of the format.
const MAX_BYTES: u64 = u32::MAX as u64;

/// A variable, a field of a structure or a cell.
#[derive(Debug, Clone)]
pub struct Array {
    /// Name of the variable or field; empty for cells.
    pub name: String,
    /// Numbers of rows, columns and further dimensions.
    pub dimensions: Vec<usize>,
    /// Contents.
    pub contents: Contents,
}

/// Contents of an array.
#[derive(Debug, Clone)]
pub enum Contents {
    /// Real numbers in column-major order, converted from the stored class.
    Real {
        /// Values in column-major order.
        values: Vec<f64>,
        /// Machine epsilon of the stored class: 2⁻⁵² for double, 2⁻²³ for single, 1 for integers.
        epsilon: f64,
    },
    /// Complex numbers in column-major order.
    Complex {
        /// Real parts.
        re: Vec<f64>,
        /// Imaginary parts.
        im: Vec<f64>,
    },
    /// Character array, one string per row.
    Text(Vec<String>),
    /// Cells in column-major order.
    Cells(Vec<Array>),
    /// Fields of the first structure, then of the second, and so on; each array has the name of its field.
    Structure(Vec<Array>),
    /// Description of unsupported contents, such as `an object of class timeseries`.
    Other(String),
}

/// Description text of the header, and the variables in file order.
///
/// # Errors
/// `unknown-format` for MATLAB files of level 4 and of version 7.3 (HDF5) and for anything else, `broken-file` for a
/// damaged one, `hopeless` for more than 2²⁹ numbers.
pub fn read(bytes: &[u8]) -> Result<(String, Vec<Array>), Error> {
    let (description, order) = header(bytes)?;
    let mut reader = ArrayReader {
        order,
        values_left: MAX_VALUES,
    };
    let mut variables = Vec::new();
    let mut rest = &bytes[HEADER_BYTES..];
    while !rest.is_empty() {
        let element = DataElement::split(&mut rest, order)?;
        let variable = match element.kind {
            types::MATRIX => reader.array(element.data, 0)?,
            types::COMPRESSED => reader.compressed(element.data)?,
            // Data elements outside an array have no name; no known program writes them.
            _ => continue,
        };
        variables.push(variable);
    }
    Ok((description, variables))
}

/// Reader of arrays with the remaining budget of numbers.
struct ArrayReader {
    order: ByteOrder,
    values_left: usize,
}

impl ArrayReader {
    fn compressed(&mut self, data: &[u8]) -> Result<Array, Error> {
        let mut unpacked = Vec::new();
        let outcome = ZlibDecoder::new(data)
            .take(MAX_BYTES.min(8 * self.values_left as u64 + MAX_BYTES / 64))
            .read_to_end(&mut unpacked);
        // A missing checksum at the end is ignored where the array is complete.
        if let (Err(error), true) = (&outcome, unpacked.is_empty()) {
            return Err(corrupt(format!(
                "a compressed variable of the MATLAB file cannot be unpacked: {error}"
            )));
        }
        let mut input = unpacked.as_slice();
        let element = DataElement::split(&mut input, self.order)?;
        match element.kind {
            types::MATRIX => self.array(element.data, 0),
            kind => Err(corrupt(format!(
                "a compressed variable of the MATLAB file has data of type {kind} instead of an array"
            ))),
        }
    }

    /// Reads the array in the data of a matrix element.
    fn array(&mut self, mut data: &[u8], depth: usize) -> Result<Array, Error> {
        if depth > MAX_DEPTH {
            return Err(corrupt(format!(
                "cells of the MATLAB file nest deeper than {MAX_DEPTH} levels"
            )));
        }
        if data.is_empty() {
            return Ok(Array {
                name: String::new(),
                dimensions: vec![0, 0],
                contents: Contents::Real {
                    values: Vec::new(),
                    epsilon: f64::EPSILON,
                },
            });
        }
        let order = self.order;
        let rest = &mut data;
        let flags = DataElement::split(rest, order)?;
        let flags = flags.data.first_chunk::<4>().map_or(0, |&b| order.u32(b));
        let (class, is_complex) = (flags & 0xFF, flags & 0x0800 != 0);
        if class == classes::OPAQUE {
            return opaque(rest, order);
        }
        let dimensions = dimensions(&DataElement::split(rest, order)?, order)?;
        let name = DataElement::split(rest, order)?;
        let name = String::from_utf8_lossy(name.data).into_owned();
        let count = dimensions
            .iter()
            .try_fold(1_usize, |n, &d| n.checked_mul(d));
        let count = count.ok_or_else(|| {
            corrupt(format!(
                "the dimensions {dimensions:?} of variable `{name}` overflow when multiplied"
            ))
        })?;
        let contents = match class {
            classes::CHAR => text(&DataElement::split(rest, order)?, &dimensions, order, &name)?,
            classes::CELL => Contents::Cells(self.children(rest, count, None, depth)?),
            classes::STRUCT => {
                let fields = fields(rest, order)?;
                let count = count.saturating_mul(fields.len());
                Contents::Structure(self.children(rest, count, Some(&fields), depth)?)
            }
            classes::DOUBLE..=classes::UINT64 => {
                let epsilon = match class {
                    classes::DOUBLE => f64::EPSILON,
                    classes::SINGLE => f64::from(f32::EPSILON),
                    _ => 1.0,
                };
                let values = self.numbers(rest, count, &name)?;
                match is_complex {
                    false => Contents::Real { values, epsilon },
                    true => Contents::Complex {
                        re: values,
                        im: self.numbers(rest, count, &name)?,
                    },
                }
            }
            classes::SPARSE => Contents::Other("a sparse matrix".into()),
            classes::OBJECT => {
                let class = DataElement::split(rest, order)?;
                let class = String::from_utf8_lossy(class.data);
                let class = class.trim_end_matches('\0');
                Contents::Other(format!("an object of class {class}"))
            }
            classes::FUNCTION => Contents::Other("a function handle".into()),
            _ => {
                return Err(corrupt(format!(
                    "variable `{name}` of the MATLAB file has the unknown class {class}"
                )));
            }
        };
        Ok(Array {
            name,
            dimensions,
            contents,
        })
    }

    /// Reads `count` numbers from one data element.
    fn numbers(&mut self, rest: &mut &[u8], count: usize, name: &str) -> Result<Vec<f64>, Error> {
        // Some writers omit the data element of an empty array.
        if count == 0 && rest.is_empty() {
            return Ok(Vec::new());
        }
        let element = DataElement::split(rest, self.order)?;
        let Some(scalars) = NumberFormat::from_type(element.kind, self.order) else {
            return Err(corrupt(format!(
                "variable `{name}` of the MATLAB file has data of the unknown type {}",
                element.kind
            )));
        };
        let held = element.data.len() / scalars.width();
        if held != count {
            return Err(corrupt(format!(
                "variable `{name}` of the MATLAB file has {held} numbers where its dimensions need {count}"
            )));
        }
        self.values_left = self.values_left.checked_sub(count).ok_or_else(|| {
            Error::new(
                Code::BudgetExceeded,
                format!("the MATLAB file has more than {MAX_VALUES} numbers"),
            )
            .with_hint(
                "save fewer variables, or write the signals to CSV, which is read piece by piece",
            )
        })?;
        Ok(scalars.decode(element.data))
    }

    /// Reads the arrays of cells, or of the fields of structures.
    fn children(
        &mut self,
        rest: &mut &[u8],
        count: usize,
        names: Option<&[String]>,
        depth: usize,
    ) -> Result<Vec<Array>, Error> {
        // Every child has a tag of at least eight bytes.
        let mut children = Vec::with_capacity(count.min(rest.len() / 8));
        for index in 0..count {
            let element = DataElement::split(rest, self.order)?;
            if element.kind != types::MATRIX {
                return Err(corrupt(format!(
                    "a cell of the MATLAB file has data of type {} instead of an array",
                    element.kind
                )));
            }
            let mut child = self.array(element.data, depth + 1)?;
            if let Some(names) = names {
                child.name.clone_from(&names[index % names.len()]);
            }
            children.push(child);
        }
        Ok(children)
    }
}

/// Reads name and class of an opaque object of a newer class, the only readable parts.
fn opaque(rest: &mut &[u8], order: ByteOrder) -> Result<Array, Error> {
    let name = DataElement::split(rest, order)?;
    let _system = DataElement::split(rest, order)?;
    let class = DataElement::split(rest, order)?;
    Ok(Array {
        name: String::from_utf8_lossy(name.data).into_owned(),
        dimensions: vec![1, 1],
        contents: Contents::Other(format!(
            "an object of class {}",
            String::from_utf8_lossy(class.data)
        )),
    })
}

fn dimensions(element: &DataElement<'_>, order: ByteOrder) -> Result<Vec<usize>, Error> {
    let (words, rest) = element.data.as_chunks::<4>();
    if words.len() < 2 || !rest.is_empty() {
        return Err(corrupt(format!(
            "an array of the MATLAB file has {} bytes of dimensions",
            element.data.len()
        )));
    }
    let sizes = words.iter().map(|&b| {
        let size = order.u32(b) as i32;
        usize::try_from(size).map_err(|_| {
            corrupt(format!(
                "an array of the MATLAB file has the dimension {size}"
            ))
        })
    });
    sizes.collect()
}

/// Reads the field names of a structure.
fn fields(rest: &mut &[u8], order: ByteOrder) -> Result<Vec<String>, Error> {
    let width = DataElement::split(rest, order)?;
    let width = width.data.first_chunk::<4>().map_or(0, |&b| order.u32(b)) as usize;
    let names = DataElement::split(rest, order)?.data;
    if width == 0 && !names.is_empty() {
        return Err(corrupt(
            "field names of a structure of the MATLAB file have no width",
        ));
    }
    let name = |field: &[u8]| {
        let end = field.iter().position(|&b| b == 0).unwrap_or(field.len());
        String::from_utf8_lossy(&field[..end]).into_owned()
    };
    Ok(names.chunks(width.max(1)).map(name).collect())
}

/// Reads the rows of a character array, stored in column-major order.
fn text(
    element: &DataElement<'_>,
    dimensions: &[usize],
    order: ByteOrder,
    name: &str,
) -> Result<Contents, Error> {
    let characters: Vec<char> = match element.kind {
        types::UTF8 => String::from_utf8_lossy(element.data).chars().collect(),
        types::UINT16 | types::UTF16 => {
            let units = element.data.as_chunks::<2>().0.iter();
            let units = units.map(|&b| order.u16(b));
            char::decode_utf16(units)
                .map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER))
                .collect()
        }
        types::UTF32 => {
            let words = element.data.as_chunks::<4>().0.iter();
            let characters = words.map(|&b| char::from_u32(order.u32(b)));
            characters
                .map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER))
                .collect()
        }
        types::INT8 | types::UINT8 => element.data.iter().map(|&b| char::from(b)).collect(),
        kind => {
            return Err(corrupt(format!(
                "text `{name}` of the MATLAB file has data of the unknown type {kind}"
            )));
        }
    };
    let rows = dimensions[0].min(characters.len());
    let row = |i: usize| characters.iter().skip(i).step_by(rows).collect();
    Ok(Contents::Text((0..rows).map(row).collect()))
}
