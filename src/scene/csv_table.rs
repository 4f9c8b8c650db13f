//! Columns of numbers from a CSV file whose first line names them with their units: `angle_1 [deg],angle_2 [deg]`.

use std::path::Path;
use std::sync::Arc;

use super::limit_table::{cells, lines};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::load;
use crate::base::quantity::{self, truncate};
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};

/// Most rows: a table of a curve needs no more.
const MAX_ROWS: usize = 100_000;

/// Columns in SI, and the place of each row.
#[derive(Debug, Clone)]
pub struct CsvTable {
    /// Values by column, as requested.
    pub columns: Vec<Vec<f64>>,
    /// Start of each row in the text.
    rows: Vec<std::ops::Range<usize>>,
    /// The file.
    pub source: Arc<SourceFile>,
}

impl CsvTable {
    /// Reads the named columns of a file, each of a kind.
    ///
    /// # Errors
    /// Everything wrong in it.
    pub fn read(path: &Path, names: &[(&str, QuantityKind)]) -> Result<CsvTable, Errors> {
        let names: Vec<_> = names
            .iter()
            .map(|(name, kind)| (*name, Some(*kind)))
            .collect();
        CsvTable::parse(load::load(path)?, &names)
    }

    /// Reads the named columns of a text, each of a kind; bare numbers without one.
    ///
    /// # Errors
    /// Everything wrong in it.
    pub fn parse(
        source: Arc<SourceFile>,
        names: &[(&str, Option<QuantityKind>)],
    ) -> Result<CsvTable, Errors> {
        let at = |range: std::ops::Range<usize>| SourceSpan::new(source.clone(), range);
        let mut lines = lines(&source);
        let (start, head) = lines.next().unwrap_or((0, ""));
        let heads = heads(head);
        let mut found = Vec::new();
        for (name, kind) in names {
            let column = heads.iter().position(|(head, _)| head == name);
            let Some((column, (_, unit))) = column.map(|k| (k, heads[k])) else {
                let message = format!("the table has no column `{name}`");
                return Err(Error::new(Code::MissingKey, message)
                    .with_span(&at(start..start + head.len()))
                    .with_hint(format!(
                        "its first line names columns with units, such as {}",
                        names
                            .iter()
                            .map(|(name, kind)| head_example(name, *kind))
                            .collect::<Vec<_>>()
                            .join(",")
                    ))
                    .into());
            };
            let scale = match kind {
                Some(kind) => {
                    quantity::parse(&format!("1 {unit}"), *kind, &format!("column `{name}`"))
                }
                None => Ok(1.0),
            };
            found.push((
                column,
                scale.map_err(|e| e.with_span(&at(start..start + head.len())))?,
            ));
        }
        let (mut columns, mut rows) = (vec![Vec::new(); names.len()], Vec::new());
        for (start, text) in lines {
            let place = start..start + text.len();
            let row = cells(text);
            for ((column, scale), values) in found.iter().zip(&mut columns) {
                let cell = row.get(*column).copied().unwrap_or("");
                // Commas are left in cells between semicolons alone, as decimal signs.
                let number: Option<f64> = cell.replace(',', ".").parse().ok();
                let number = number.filter(|x| x.is_finite());
                let Some(number) = number else {
                    let message = format!("\"{}\" is not a number", truncate(cell));
                    return Err(Error::new(Code::NotANumber, message)
                        .with_span(&at(place))
                        .with_hint(
                            "write columns separated by commas and numbers with a decimal point, or semicolons and decimal commas",
                        )
                        .into());
                };
                values.push(scale * number);
            }
            rows.push(place);
            if rows.len() > MAX_ROWS {
                let message = format!("the table has more than {MAX_ROWS} rows");
                return Err(Error::new(Code::OutOfRange, message)
                    .with_span(&SourceSpan::whole_file(&source.path))
                    .with_hint("keep fewer points")
                    .into());
            }
        }
        Ok(CsvTable {
            columns,
            rows,
            source,
        })
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// No row holds numbers.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Place of a row, counted from 0.
    pub fn row_span(&self, row: usize) -> SourceSpan {
        let range = self.rows.get(row).cloned().unwrap_or(0..0);
        SourceSpan::new(self.source.clone(), range)
    }

    /// An error of a curve through the rows, at the row that its message names first, else at the table.
    pub fn locate(&self, error: Error) -> Error {
        let named = error.message.strip_prefix("row");
        let number = named.and_then(|text| {
            let text = text.trim_start_matches('s').trim_start();
            let end = text
                .find(|c: char| !c.is_ascii_digit())
                .unwrap_or(text.len());
            text[..end].parse::<usize>().ok()
        });
        let row = number.and_then(|row| self.rows.get(row.checked_sub(1)?));
        let error = match error.hint {
            Some(_) => error,
            None => error.with_hint("correct the row, or omit it"),
        };
        match row {
            Some(row) => error.with_span(&SourceSpan::new(self.source.clone(), row.clone())),
            None => error.with_span(&SourceSpan::whole_file(&self.source.path)),
        }
    }
}

/// Names and units of the columns in the first line of a text.
pub fn column_heads(source: &SourceFile) -> Vec<(&str, &str)> {
    lines(source)
        .next()
        .map_or(Vec::new(), |(_, head)| heads(head))
}

fn heads(line: &str) -> Vec<(&str, &str)> {
    let split = |cell| {
        let parts = str::strip_suffix(cell, "]").and_then(|cell| cell.split_once('['));
        parts.map_or((cell, ""), |(name, unit)| (name.trim(), unit))
    };
    cells(line).into_iter().map(split).collect()
}

fn head_example(name: &str, kind: Option<QuantityKind>) -> String {
    match kind {
        Some(kind) => format!("{name} [{}]", usual_unit(kind)),
        None => name.to_string(),
    }
}

fn usual_unit(kind: QuantityKind) -> &'static str {
    match kind {
        QuantityKind::Angle => "deg",
        QuantityKind::Time => "s",
        _ => "mm",
    }
}
