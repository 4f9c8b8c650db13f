//! A state-space form as JSON, CSV, or a MATLAB file of level 5.
//!
//! The MATLAB format: The MathWorks, MAT-File Format (R2023), chapter 1, “Level 5 MAT-File Format”; uncompressed, little-endian.

use std::io::{self, Write};

use serde_json::{Value, json};

use super::system::StateSpace;
use crate::numeric::Matrix;

impl StateSpace {
    /// `a`, `b`, `c`, `d` by rows, `states`, `inputs`, `outputs`, `sample_time_s` and `hold` (null where continuous).
    pub fn to_json(&self) -> Value {
        let rows = |m: &Matrix| -> Vec<Vec<f64>> {
            (0..m.nrows())
                .map(|i| (0..m.ncols()).map(|j| m[(i, j)]).collect())
                .collect()
        };
        json!({
            "a": rows(&self.a), "b": rows(&self.b), "c": rows(&self.c), "d": rows(&self.d),
            "states": self.states, "inputs": self.inputs, "outputs": self.outputs,
            "sample_time_s": self.sample_time, "hold": self.hold.map(|hold| hold.name()),
        })
    }

    /// Four labelled blocks in one file: a line `a`, a heading of columns, a row for each state or output; a blank line between.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_csv(&self, to: &mut impl Write) -> io::Result<()> {
        if let Some(sample_time) = self.sample_time {
            writeln!(to, "sample_time_s,{sample_time:?}")?;
            writeln!(to, "hold,{}", self.hold.map_or("", |hold| hold.name()))?;
            writeln!(to)?;
        }
        let blocks = [
            ("a", &self.a, &self.states, &self.states),
            ("b", &self.b, &self.states, &self.inputs),
            ("c", &self.c, &self.outputs, &self.states),
            ("d", &self.d, &self.outputs, &self.inputs),
        ];
        for (at, (name, matrix, rows, columns)) in blocks.into_iter().enumerate() {
            if at > 0 {
                writeln!(to)?;
            }
            let heading: Vec<String> = columns.iter().map(|c| quoted(c)).collect();
            writeln!(
                to,
                "{}",
                std::iter::once(name.to_string())
                    .chain(heading)
                    .collect::<Vec<_>>()
                    .join(",")
            )?;
            for (i, row) in rows.iter().enumerate() {
                let values = (0..matrix.ncols()).map(|j| format!("{:?}", matrix[(i, j)]));
                writeln!(
                    to,
                    "{}",
                    std::iter::once(quoted(row))
                        .chain(values)
                        .collect::<Vec<_>>()
                        .join(",")
                )?;
            }
        }
        Ok(())
    }

    /// Variables `A`, `B`, `C`, `D`, `Ts` (0 where continuous), `hold`, and cells `states`, `inputs`, `outputs`, for
    /// `load` in MATLAB and `scipy.io.loadmat`: `sys = ss(A, B, C, D, Ts)`.
    ///
    /// # Errors
    /// Those of the writer; a matrix beyond 4 GB, which the format cannot hold.
    pub fn write_mat(&self, to: &mut impl Write) -> io::Result<()> {
        let mut header = format!(
            "{:116}",
            "MATLAB 5.0 MAT-file, written by geardyn: state space, SI units"
        )
        .into_bytes();
        header.extend([0; 8]); // no subsystem data
        header.extend(0x0100u16.to_le_bytes());
        header.extend(b"IM");
        to.write_all(&header)?;
        for (name, matrix) in [
            ("A", &self.a),
            ("B", &self.b),
            ("C", &self.c),
            ("D", &self.d),
        ] {
            to.write_all(&numbers(name, matrix)?)?;
        }
        let sample_time = self.sample_time.unwrap_or(0.0);
        to.write_all(&numbers("Ts", &Matrix::from_fn(1, 1, |_, _| sample_time))?)?;
        to.write_all(&text(
            "hold",
            self.hold.map_or("continuous", |hold| hold.name()),
        )?)?;
        for (name, list) in [
            ("states", &self.states),
            ("inputs", &self.inputs),
            ("outputs", &self.outputs),
        ] {
            to.write_all(&cells(name, list)?)?;
        }
        Ok(())
    }
}

fn quoted(field: &str) -> String {
    match field.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", field.replace('"', "\"\"")),
        false => field.to_string(),
    }
}

// Data types and array classes, tables 1-1 and 1-3.
const MI_INT8: u32 = 1;
const MI_UINT16: u32 = 4;
const MI_INT32: u32 = 5;
const MI_UINT32: u32 = 6;
const MI_DOUBLE: u32 = 9;
const MI_MATRIX: u32 = 14;
const MX_CELL: u32 = 1;
const MX_CHAR: u32 = 4;
const MX_DOUBLE: u32 = 6;

/// A tag and its data, filled up to eight bytes.
fn element(kind: u32, data: &[u8]) -> io::Result<Vec<u8>> {
    let length = u32::try_from(data.len())
        .map_err(|_| io::Error::other("a MATLAB level 5 file holds arrays up to 4 GB"))?;
    let mut bytes = Vec::with_capacity(data.len() + 16);
    bytes.extend(kind.to_le_bytes());
    bytes.extend(length.to_le_bytes());
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    Ok(bytes)
}

/// An array: flags, dimensions, name, then its contents.
fn array(name: &str, class: u32, dimensions: [usize; 2], contents: &[u8]) -> io::Result<Vec<u8>> {
    let mut data = element(MI_UINT32, &[class.to_le_bytes(), [0; 4]].concat())?;
    let [rows, columns] = dimensions.map(|d| (d as u32).to_le_bytes());
    data.extend(element(MI_INT32, &[rows, columns].concat())?);
    data.extend(element(MI_INT8, name.as_bytes())?);
    data.extend(contents);
    element(MI_MATRIX, &data)
}

fn numbers(name: &str, matrix: &Matrix) -> io::Result<Vec<u8>> {
    let (rows, columns) = (matrix.nrows(), matrix.ncols());
    let by_column = (0..columns).flat_map(|j| (0..rows).map(move |i| (i, j)));
    let bytes: Vec<u8> = by_column.flat_map(|at| matrix[at].to_le_bytes()).collect();
    array(
        name,
        MX_DOUBLE,
        [rows, columns],
        &element(MI_DOUBLE, &bytes)?,
    )
}

fn text(name: &str, value: &str) -> io::Result<Vec<u8>> {
    let units: Vec<u16> = value.encode_utf16().collect();
    let bytes: Vec<u8> = units.iter().flat_map(|u| u.to_le_bytes()).collect();
    array(
        name,
        MX_CHAR,
        [1, units.len()],
        &element(MI_UINT16, &bytes)?,
    )
}

fn cells(name: &str, values: &[String]) -> io::Result<Vec<u8>> {
    let mut contents = Vec::new();
    for value in values {
        contents.extend(text("", value)?);
    }
    array(name, MX_CELL, [values.len(), 1], &contents)
}
