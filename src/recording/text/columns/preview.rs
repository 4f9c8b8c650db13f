//! Column preview from the head of a file: unique names, cell types, first values.

use std::collections::HashSet;

use super::causal::{ColumnPair, ComplexColumns, column_pair};
use super::time_unit::unit_seconds;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::text;
use crate::recording::channel_names;
use crate::recording::text::cells::{self, Cell, CellIter, Separators};
use crate::recording::text::dialect::CellType;
use crate::recording::text::frequency_table;
use crate::recording::text::header::TableHeader;

/// Names of a frequency column, folded by [`fold_name`].
const FREQUENCY_NAMES: &[&str] = &[
    "frequency",
    "freq",
    "f",
    "frequenz",
    "frequency hz",
    "freq hz",
    "f hz",
    "频率",
    "fréquence",
    "frecuencia",
    "hz",
];

/// Number of rows of the preview.
const PREVIEW_ROWS: usize = 200;

/// Columns with names, cell types and first values.
pub(super) struct ColumnPreview<'a> {
    pub(super) header: &'a TableHeader,
    pub(super) kinds: &'a [CellType],
    /// Name of each column; repeated names are numbered.
    pub(super) names: Vec<String>,
    /// Values of the first rows, by column; NaN for cells that are not numbers.
    pub(super) sample: Vec<Vec<f64>>,
    /// Whether unnamed columns were identified as frequency responses by their values.
    are_responses: bool,
}

impl<'a> ColumnPreview<'a> {
    pub(super) fn new(
        header: &'a TableHeader,
        kinds: &'a [CellType],
        rows: &[&str],
        marks: Separators,
    ) -> ColumnPreview<'a> {
        ColumnPreview {
            header,
            kinds,
            names: unique_names(header, kinds.len()),
            sample: sample_values(rows, marks, kinds.len(), PREVIEW_ROWS),
            are_responses: false,
        }
    }

    /// Names unnamed columns that are frequency responses over uniform lines by their values, optionally with a coherence; returns
    /// whether they are.
    ///
    /// # Errors
    /// `UnknownFormat`: the values may be frequency responses or signals.
    pub(super) fn name_responses(
        &mut self,
        rows: &[&str],
        marks: Separators,
    ) -> Result<bool, Error> {
        /// Steps below this are time steps, s: recorders sample faster than 20 Hz, spectral lines are rarely closer than 0.05 Hz.
        const MAX_TIME_STEP: f64 = 0.05;
        let width = self.kinds.len();
        let unnamed = self.header.raw_names.iter().all(String::is_empty);
        let numbers = (0..width).all(|c| self.is_number(c));
        if !unnamed || !numbers || width < 3 || !self.is_uniform(0) {
            return Ok(false);
        }
        let first = &self.sample[0];
        if first[0] < 0.0 || first[1] - first[0] < MAX_TIME_STEP {
            return Ok(false);
        }
        let values = sample_values(rows, marks, width, usize::MAX);
        let chunks = values[1..].chunks_exact(2);
        let is_coherence = |column: &Vec<f64>| column.iter().all(|x| (0.0..=1.0).contains(x));
        let (is_complete, unpaired) = (
            chunks.remainder().iter().all(is_coherence),
            chunks.remainder(),
        );
        let pairs: Vec<ColumnPair> = chunks.map(|p| column_pair(&p[0], &p[1])).collect();
        if pairs.iter().all(|pair| *pair == ColumnPair::Signals) {
            return Ok(false);
        }
        let forms = pairs.iter().map(|pair| match pair {
            ColumnPair::Response(form) if is_complete => Some(*form),
            _ => None,
        });
        let forms: Option<Vec<ComplexColumns>> = forms.collect();
        let forms = forms.ok_or_else(uncertain_columns)?;
        for (at, pair) in forms.iter().enumerate() {
            for (half, ending) in pair.suffixes().into_iter().enumerate() {
                self.names[1 + 2 * at + half] = format!("H{}_{ending}", at + 1);
            }
        }
        if !unpaired.is_empty() {
            self.names[width - 1] = format!("H{}_coherence", forms.len());
        }
        self.are_responses = true;
        Ok(true)
    }

    pub(super) fn is_named(&self, column: usize, table: &[&str]) -> bool {
        let name = fold_name(&self.header.names[column]);
        // Logs with a clock per channel have names such as `time1`, `Time 2`, `Time_acc`.
        let bare = name
            .trim_end_matches(|c: char| c.is_ascii_digit())
            .trim_end();
        let named = !self.header.raw_names[column].is_empty();
        named && (table.contains(&name.as_str()) || (!bare.is_empty() && table.contains(&bare)))
    }

    /// Whether the numbers are non-decreasing and not constant; true for a single row.
    pub(super) fn is_rising(&self, column: usize) -> bool {
        let numbers: Vec<f64> = self.sample[column]
            .iter()
            .copied()
            .filter(|x| x.is_finite())
            .collect();
        let last = numbers.len().saturating_sub(1);
        numbers.windows(2).all(|w| w[1] >= w[0]) && (last == 0 || numbers[last] > numbers[0])
    }

    /// Whether the numbers are integers that increase by one.
    pub(super) fn is_counting(&self, column: usize) -> bool {
        let numbers = &self.sample[column];
        numbers.len() > 1
            && numbers.windows(2).all(|w| w[1] == w[0] + 1.0)
            && numbers[0].fract() == 0.0
    }

    /// Whether all steps exceed half of the largest: criterion of a clock without name.
    pub(super) fn is_uniform(&self, column: usize) -> bool {
        const MIN_ROWS: usize = 8;
        let steps: Vec<f64> = self.sample[column]
            .windows(2)
            .map(|w| w[1] - w[0])
            .collect();
        let (least, most) = steps
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(a, b), s| (a.min(*s), b.max(*s)));
        steps.len() + 1 >= MIN_ROWS && least > 0.5 * most && steps.iter().all(|s| s.is_finite())
    }

    /// Whether all numbers are integers.
    pub(super) fn is_integer(&self, column: usize) -> bool {
        let numbers = &self.sample[column];
        numbers.len() > 1 && numbers.iter().all(|x| x.fract() == 0.0)
    }

    pub(super) fn unit_s(&self, column: usize) -> Option<f64> {
        unit_seconds(&self.header.units[column])
    }

    pub(super) fn is_number(&self, column: usize) -> bool {
        self.kinds[column] == CellType::Number
    }
}

/// Whether the first column holds frequencies.
pub(super) fn over_frequency(columns: &ColumnPreview<'_>, width: usize) -> bool {
    let is_hertz = || columns.header.units[0].trim().eq_ignore_ascii_case("hz");
    let named = columns.is_named(0, FREQUENCY_NAMES);
    let has_complex = columns.kinds[1..width.max(1)].contains(&CellType::Complex);
    let unnamed = columns.header.raw_names[0].is_empty();
    let are_parts = || (1..width).all(|c| frequency_table::is_part(&columns.header.names[c]));
    let is_table = named && width > 2 && are_parts();
    let is_likely = named || (unnamed && (is_hertz() || has_complex));
    let matches = is_table || columns.are_responses || (is_likely && columns.is_rising(0));
    width > 1 && columns.is_number(0) && matches
}

/// Values of at most `max_rows` rows by column; NaN for cells that are not numbers.
fn sample_values(rows: &[&str], marks: Separators, width: usize, max_rows: usize) -> Vec<Vec<f64>> {
    let mut sample = vec![Vec::new(); width];
    for row in rows.iter().filter(|r| !r.trim().is_empty()).take(max_rows) {
        let mut cells = CellIter::new(row.as_bytes(), marks.delimiter);
        for column in &mut sample {
            let value = match cells
                .next()
                .map(|(_, cell)| cells::parse_cell(cell, marks.decimal))
            {
                Some(Cell::Number(value) | Cell::Thousands { value, .. }) => value,
                _ => f64::NAN,
            };
            column.push(value);
        }
    }
    sample
}

/// Finds the column of a name.
pub(super) fn column_position(
    columns: &ColumnPreview<'_>,
    width: usize,
    name: &str,
) -> Result<usize, Error> {
    let header = columns.header;
    let is_number = |c: usize| format!("column {}", c + 1) == name;
    let is_name = |c: &usize| columns.names[*c] == name;
    (0..width)
        .find(is_name)
        .or_else(|| (0..width).find(|c| header.raw_names[*c] == name || is_number(*c)))
        .or_else(|| {
            (0..width).find(|c| {
                !header.names[*c].is_empty() && channel_names::matches(name, &header.names[*c])
            })
        })
        .or_else(|| {
            channel_names::find_channel(name, &header.names[..width.min(header.names.len())])
        })
        .ok_or_else(|| unknown_column(name, &columns.names[..width]))
}

/// Name of each column; repeated names are numbered.
fn unique_names(header: &TableHeader, width: usize) -> Vec<String> {
    let mut used = HashSet::new();
    let unique_name = |column: usize| {
        let name = column_name(header, column);
        let numbered = (2..).map(|n| format!("{name} {n}"));
        let mut candidates = std::iter::once(name.clone()).chain(numbered);
        let unique = candidates.find(|n| !used.contains(n)).unwrap_or(name);
        used.insert(unique.clone());
        unique
    };
    (0..width).map(unique_name).collect()
}

/// Name of a column; `column N` without a name in the header.
pub(super) fn column_name(header: &TableHeader, column: usize) -> String {
    match header.names[column].as_str() {
        "" => format!("column {}", column + 1),
        name => name.to_string(),
    }
}

/// Error of unnamed columns that may be frequency responses or signals.
fn uncertain_columns() -> Error {
    Error::new(
        Code::UnknownFormat,
        "no column has a name, and the values may be frequency responses or time signals",
    )
    .with_hint(
        "name the columns above the rows, such as frequency_Hz,H1_mag_dB,H1_phase_deg or frequency_Hz,H1_re,H1_im; if the first is the time: --time \"column 1\"",
    )
}

fn unknown_column(name: &str, known: &[String]) -> Error {
    let names = || known.iter().map(String::as_str);
    let hint = match text::suggestion(name, names()) {
        Some(near) => format!(
            "did you mean `{near}`? the columns are {}",
            text::quoted_list(names())
        ),
        None => format!("the columns are {}", text::quoted_list(names())),
    };
    Error::new(Code::NoChannel, format!("the log has no column `{name}`")).with_hint(hint)
}

/// Folds a name to lower case with single spaces between words.
pub(super) fn fold_name(name: &str) -> String {
    let spaced: String = name
        .chars()
        .map(|c| if matches!(c, '_' | '-' | '.') { ' ' } else { c })
        .collect();
    spaced
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
        .to_lowercase()
}
