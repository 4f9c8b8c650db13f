//! Comparison of identified modes with those of a document of `modes --json` or `identify --json`: MAC by common degrees of freedom.

use serde_json::Value;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::text::quoted_list;
use crate::identify::compare;
use crate::numeric::{Complex, Matrix};
use crate::recording::frequency_responses::ChannelLabel;

/// MAC above which two shapes count as the same.
pub const SAME_SHAPE_MAC: f64 = 0.8;

/// Modes of a document.
#[derive(Debug, Clone)]
pub struct ReferenceModes {
    /// Name of the file.
    pub file: String,
    /// Modes that oscillate.
    pub modes: Vec<ReferenceMode>,
}

/// A mode of a document.
#[derive(Debug, Clone)]
pub struct ReferenceMode {
    /// Number in its document.
    pub number: u64,
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Components of the shape with their names.
    pub shape: Vec<(String, Complex)>,
}

/// Identified modes compared with others.
#[derive(Debug)]
pub struct ModeComparison {
    /// The other modes.
    pub reference: ReferenceModes,
    /// Names of the components that both have.
    pub common: Vec<String>,
    /// MAC: a row for each identified mode, a column for each of the others.
    pub mac: Matrix,
}

impl ReferenceModes {
    /// Reads a document.
    ///
    /// # Errors
    /// `unknown-format` for a file that is no such document or holds no mode with a shape.
    pub fn read(file: &str, text: &str) -> Result<ReferenceModes, Error> {
        let wrong = |message: String| {
            Error::new(Code::UnknownFormat, message)
                .with_hint(
                    "write it by `geardyn modes MODEL --json` or `geardyn identify LOG --json`",
                )
                .with_file(file)
        };
        let document: Value = serde_json::from_str(text)
            .map_err(|e| wrong(format!("{file} is no JSON document: {e}")))?;
        let modes = document["modes"].as_array();
        let modes = modes.ok_or_else(|| wrong(format!("{file} holds no `modes`")))?;
        let modes: Vec<ReferenceMode> = modes.iter().filter_map(reference_mode).collect();
        match modes.is_empty() {
            true => Err(wrong(format!(
                "{file} holds no mode with a frequency and a shape"
            ))),
            false => Ok(ReferenceModes {
                file: file.to_string(),
                modes,
            }),
        }
    }
}

/// A mode with a frequency above zero and a shape.
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
    /// Compares shapes over outputs with others by the components that both have.
    ///
    /// # Errors
    /// `conflict` where they have fewer than two components in common.
    pub fn new<'s>(
        outputs: &[ChannelLabel],
        shapes: impl Iterator<Item = &'s [Complex]>,
        reference: ReferenceModes,
    ) -> Result<ModeComparison, Error> {
        let names = |mode: &ReferenceMode, name: &str| mode.shape.iter().any(|(n, _)| n == name);
        let own: Vec<usize> = (0..outputs.len())
            .filter(|&k| reference.modes.iter().all(|m| names(m, &outputs[k].name)))
            .collect();
        if own.len() < 2 {
            let outputs = quoted_list(outputs.iter().map(|o| o.name.as_str()));
            let others = reference.modes[0]
                .shape
                .iter()
                .map(|(name, _)| name.as_str());
            let message = format!(
                "the shapes have {} of two or more names in common: the outputs are {outputs}, {} has {}",
                own.len(),
                reference.file,
                quoted_list(others.take(12))
            );
            return Err(Error::new(Code::Conflict, message).with_hint(
                "give the channels the names of the degrees of freedom: `rename` of [[channel]] in the sidecar",
            ));
        }
        let common: Vec<String> = own.iter().map(|&k| outputs[k].name.clone()).collect();
        let component = |mode: &ReferenceMode, name: &String| {
            let own = mode.shape.iter().find(|(n, _)| n == name);
            own.map_or(Complex::ZERO, |(_, z)| *z)
        };
        let of_common =
            |shape: &[Complex]| own.iter().filter_map(|&k| shape.get(k).copied()).collect();
        let measured: Vec<Vec<Complex>> = shapes.map(of_common).collect();
        let others: Vec<Vec<Complex>> = (reference.modes.iter())
            .map(|m| common.iter().map(|name| component(m, name)).collect())
            .collect();
        Ok(ModeComparison {
            mac: compare::mac(&measured, &others),
            reference,
            common,
        })
    }

    /// For each identified mode the column with the highest MAC, where that is above [`SAME_SHAPE_MAC`].
    pub fn pairs(&self) -> Vec<Option<usize>> {
        let best = |row: usize| {
            let columns = 0..self.mac.ncols();
            let best =
                columns.max_by(|&a, &b| self.mac[(row, a)].total_cmp(&self.mac[(row, b)]))?;
            (self.mac[(row, best)] > SAME_SHAPE_MAC).then_some(best)
        };
        (0..self.mac.nrows()).map(best).collect()
    }
}
