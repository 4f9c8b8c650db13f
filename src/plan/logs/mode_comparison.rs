//! Comparison of identified modes with those of a `modes --json` or `identify --json` document: MAC over the common degrees of freedom.

use serde_json::Value;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::text::quoted_list;
use crate::identify::compare;
use crate::numeric::{Complex, Matrix};
use crate::recording::frequency_responses::ChannelLabel;

/// MAC above which two mode shapes are paired.
pub const SAME_SHAPE_MAC: f64 = 0.8;

/// Reference modes of a JSON document.
#[derive(Debug, Clone)]
pub struct ReferenceModes {
    /// Name of the file.
    pub file: String,
    /// Modes with a frequency above zero and a shape.
    pub modes: Vec<ReferenceMode>,
}

/// Mode of a JSON document.
#[derive(Debug, Clone)]
pub struct ReferenceMode {
    /// Mode number in the document.
    pub number: u64,
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Shape components with the names of their degrees of freedom.
    pub shape: Vec<(String, Complex)>,
}

/// MAC comparison of identified modes with reference modes.
#[derive(Debug)]
pub struct ModeComparison {
    /// Reference modes.
    pub reference: ReferenceModes,
    /// Names of the common degrees of freedom.
    pub common: Vec<String>,
    /// MAC matrix: one row per identified mode, one column per reference mode.
    pub mac: Matrix,
}

impl ReferenceModes {
    /// Reads the modes of a JSON document.
    ///
    /// # Errors
    /// `unknown-format` if the file is not such a document or contains no mode with a shape.
    pub fn read(file: &str, text: &str) -> Result<ReferenceModes, Error> {
        let format_error = |message: String| {
            Error::new(Code::UnknownFormat, message)
                .with_hint(
                    "write it by `geardyn modes MODEL --json` or `geardyn identify LOG --json`",
                )
                .with_file(file)
        };
        let document: Value = serde_json::from_str(text)
            .map_err(|e| format_error(format!("{file} is not a JSON document: {e}")))?;
        let modes = document["modes"].as_array();
        let modes = modes.ok_or_else(|| format_error(format!("{file} has no `modes`")))?;
        let modes: Vec<ReferenceMode> = modes.iter().filter_map(reference_mode).collect();
        match modes.is_empty() {
            true => Err(format_error(format!(
                "{file} has no mode with a frequency and a shape"
            ))),
            false => Ok(ReferenceModes {
                file: file.to_string(),
                modes,
            }),
        }
    }
}

/// Mode of a JSON object; `None` without a frequency above zero or a shape.
fn reference_mode(mode: &Value) -> Option<ReferenceMode> {
    let component = |(name, value): (&String, &Value)| {
        let part = |key: &str| value[key].as_f64();
        let value = match value.as_f64() {
            Some(re) => Complex::new(re, 0.0),
            None => Complex::new(part("re")?, part("im")?),
        };
        Some((name.clone(), value))
    };
    let frequency_hz = mode["frequency_hz"].as_f64().filter(|f| *f > 0.0)?;
    let shape: Option<Vec<_>> = mode["shape"].as_object()?.iter().map(component).collect();
    Some(ReferenceMode {
        number: mode["mode"].as_u64()?,
        frequency_hz,
        shape: shape.filter(|s| !s.is_empty())?,
    })
}

impl ModeComparison {
    /// Compares shapes over `outputs` with the reference shapes over the common degrees of freedom.
    ///
    /// # Errors
    /// `conflict` if fewer than two degrees of freedom are common.
    pub fn new<'s>(
        outputs: &[ChannelLabel],
        shapes: impl Iterator<Item = &'s [Complex]>,
        reference: ReferenceModes,
    ) -> Result<ModeComparison, Error> {
        let has_dof = |mode: &ReferenceMode, name: &str| mode.shape.iter().any(|(n, _)| n == name);
        let rows: Vec<usize> = (0..outputs.len())
            .filter(|&k| reference.modes.iter().all(|m| has_dof(m, &outputs[k].name)))
            .collect();
        if rows.len() < 2 {
            let outputs = quoted_list(outputs.iter().map(|o| o.name.as_str()));
            let others = reference.modes[0]
                .shape
                .iter()
                .map(|(name, _)| name.as_str());
            let message = format!(
                "the shapes have {} of two or more names in common: the outputs are {outputs}, {} has {}",
                rows.len(),
                reference.file,
                quoted_list(others.take(12))
            );
            return Err(Error::new(Code::Conflict, message).with_hint(
                "give the channels the names of the degrees of freedom: `rename` of [[channel]] in the sidecar",
            ));
        }
        let common: Vec<String> = rows.iter().map(|&k| outputs[k].name.clone()).collect();
        let component = |mode: &ReferenceMode, name: &String| {
            let entry = mode.shape.iter().find(|(n, _)| n == name);
            entry.map_or(Complex::ZERO, |(_, z)| *z)
        };
        let common_components =
            |shape: &[Complex]| rows.iter().filter_map(|&k| shape.get(k).copied()).collect();
        let identified: Vec<Vec<Complex>> = shapes.map(common_components).collect();
        let references: Vec<Vec<Complex>> = (reference.modes.iter())
            .map(|m| common.iter().map(|name| component(m, name)).collect())
            .collect();
        Ok(ModeComparison {
            mac: compare::mac(&identified, &references),
            reference,
            common,
        })
    }

    /// Column of the highest MAC for each identified mode; `None` unless it exceeds [`SAME_SHAPE_MAC`].
    pub fn pairs(&self) -> Vec<Option<usize>> {
        let best_column = |row: usize| {
            let columns = 0..self.mac.ncols();
            let best_column =
                columns.max_by(|&a, &b| self.mac[(row, a)].total_cmp(&self.mac[(row, b)]))?;
            (self.mac[(row, best_column)] > SAME_SHAPE_MAC).then_some(best_column)
        };
        (0..self.mac.nrows()).map(best_column).collect()
    }
}
