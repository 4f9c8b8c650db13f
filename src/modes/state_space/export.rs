//! A state-space form as JSON, CSV, or a MATLAB file of level 5.

use std::io::{self, Write};

use serde_json::{Value, json};

use super::system::StateSpace;
use crate::base::mat5::write;
use crate::numeric::to_rows;

impl StateSpace {
    /// `a`, `b`, `c`, `d` by rows, `states`, `inputs`, `outputs`, `sample_time_s` and `method` (null where continuous).
    pub fn to_json(&self) -> Value {
        json!({
            "a": to_rows(&self.a), "b": to_rows(&self.b), "c": to_rows(&self.c), "d": to_rows(&self.d),
            "states": self.states, "inputs": self.inputs, "outputs": self.outputs,
            "sample_time_s": self.sample_time, "hold": self.method.map(|hold| hold.name()),
        })
    }

    /// Four labelled blocks in one file: a line `a`, a heading of columns, a row for each state or output; a blank line between.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_csv(&self, to: &mut impl Write) -> io::Result<()> {
        if let Some(sample_time) = self.sample_time {
            writeln!(to, "sample_time_s,{sample_time:?}")?;
            writeln!(to, "hold,{}", self.method.map_or("", |hold| hold.name()))?;
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

    /// Variables `A`, `B`, `C`, `D`, `Ts` (0 where continuous), `method`, and cells `states`, `inputs`, `outputs`, for
    /// `load` in MATLAB and `scipy.io.loadmat`: `sys = ss(A, B, C, D, Ts)`.
    ///
    /// # Errors
    /// Those of the writer; a matrix beyond 4 GB, which the format cannot hold.
    pub fn write_mat(&self, to: &mut impl Write) -> io::Result<()> {
        to.write_all(&write::header("state space, SI units"))?;
        for (name, matrix) in [
            ("A", &self.a),
            ("B", &self.b),
            ("C", &self.c),
            ("D", &self.d),
        ] {
            let dimensions = [matrix.nrows(), matrix.ncols()];
            let by_column =
                (0..matrix.ncols()).flat_map(|j| (0..matrix.nrows()).map(move |i| matrix[(i, j)]));
            to.write_all(&write::real(name, dimensions, by_column)?)?;
        }
        to.write_all(&write::real(
            "Ts",
            [1, 1],
            [self.sample_time.unwrap_or(0.0)],
        )?)?;
        to.write_all(&write::text(
            "hold",
            self.method.map_or("continuous", |hold| hold.name()),
        )?)?;
        for (name, list) in [
            ("states", &self.states),
            ("inputs", &self.inputs),
            ("outputs", &self.outputs),
        ] {
            to.write_all(&write::cell_strings(name, list)?)?;
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
