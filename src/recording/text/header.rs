//! Column names and units above the data rows, and preamble lines.

use super::cells::{self, CellIter, Separators};
use super::dialect::{CellType, TableLayout};
use super::preamble::{is_comment, strip_comment};
use crate::recording::channel_names;

/// Names, units and preamble in the lines above the numbers.
#[derive(Debug, Default)]
pub struct TableHeader {
    /// Name of each column as written; empty if there is none.
    pub raw_names: Vec<String>,
    /// Name of each column without its unit; empty if there is none.
    pub names: Vec<String>,
    /// Unit of each column; empty if there is none.
    pub units: Vec<String>,
    /// Lines of the preamble, by index.
    pub preamble: Vec<usize>,
    /// Row that could hold the names but has a wrong number of cells: line index and number of cells.
    pub misfit_row: Option<(usize, usize)>,
    /// Row below the names with a number in one numeric column and words in another: line index and column of the words.
    pub broken_row: Option<(usize, usize)>,
}

/// Splits the lines above the numbers into names, units and preamble.
pub fn parse_header(lines: &[&str], layout: &TableLayout) -> TableHeader {
    let above = &lines[..layout.first.min(lines.len())];
    let width = layout.kinds.len();
    let required = layout
        .kinds
        .iter()
        .rposition(|k| *k != CellType::Empty)
        .map_or(0, |at| at + 1);
    let mut rows: Vec<(usize, Vec<String>)> = Vec::new();
    let mut misfit = None;
    // The last line of words that matches, and the one above it; no other words lie between them and the numbers.
    for (at, line) in above.iter().enumerate().rev() {
        if line.trim().is_empty() || !line.contains(char::is_alphabetic) {
            continue;
        }
        match row(line, layout.separators, required, width, rows.is_empty()) {
            Some(cells) => rows.push((at, cells)),
            None if rows.is_empty() => {
                let cells = CellIter::new(line.as_bytes(), layout.separators.delimiter).count();
                if !is_comment(line) && cells > 2 && layout.separators.delimiter != b' ' {
                    misfit = Some((at, cells));
                }
                // The words directly above the numbers do not match the columns: there are no names.
                break;
            }
            None => break,
        }
        if rows.len() == 2 {
            break;
        }
    }
    let mut header = TableHeader {
        misfit_row: misfit,
        ..TableHeader::default()
    };
    let mut used = Vec::new();
    if let (Some((at, lower)), Some((_, upper))) = (rows.first(), rows.get(1)) {
        header.broken_row = broken_cell(lower, upper, layout).map(|cell| (*at, cell));
    }
    if let Some((at, cells)) = rows.first() {
        used.push(*at);
        let lower_is_units = rows
            .get(1)
            .is_some_and(|(_, upper)| is_units_row(cells, upper));
        let upper_is_units = rows.get(1).is_some_and(|(_, upper)| {
            2 * units_in(upper) > upper.len() && units_in(upper) > units_in(cells)
        });
        let (raw_names, units) = match rows.get(1) {
            Some((second, upper)) if lower_is_units => {
                used.push(*second);
                (upper.clone(), cells.clone())
            }
            Some((second, upper)) if upper_is_units => {
                used.push(*second);
                (cells.clone(), upper.clone())
            }
            _ if width > 1
                && units_in(cells) == cells.len()
                && cells.iter().any(|c| c.chars().count() > 1) =>
            {
                (Vec::new(), cells.clone())
            }
            _ => (cells.clone(), Vec::new()),
        };
        header.fill(raw_names, &units, width);
    } else {
        header.fill(Vec::new(), &[], width);
    }
    header.preamble = (0..above.len())
        .filter(|at| !used.contains(at) && !above[*at].trim().is_empty())
        .collect();
    header
}

impl TableHeader {
    fn fill(&mut self, mut raw_names: Vec<String>, units: &[String], width: usize) {
        raw_names.resize(width, String::new());
        for (column, cell) in raw_names.iter().enumerate() {
            let (name, mut unit) = channel_names::split_unit(cell);
            if let Some(unit_cell) = units.get(column).filter(|u| !u.is_empty()) {
                unit = channel_names::unit_of_cell(unit_cell);
            }
            self.names.push(name);
            self.units.push(unit);
        }
        self.raw_names = raw_names;
    }
}

/// Cells of a row of words if their number matches the columns; `any_delimiter` tries others than that of the table.
fn row(
    line: &str,
    marks: Separators,
    required: usize,
    width: usize,
    any_delimiter: bool,
) -> Option<Vec<String>> {
    let line = if is_comment(line) {
        strip_comment(line)
    } else {
        line
    };
    let split_by = |delimiter: u8| -> Vec<String> {
        let cells = CellIter::new(line.as_bytes(), delimiter);
        cells
            .map(|(start, cell)| clean(&line[start..start + cell.len()]))
            .collect()
    };
    let split_at_gaps = || {
        line.split("  ")
            .map(clean)
            .filter(|c| !c.is_empty())
            .collect::<Vec<String>>()
    };
    let accept = |mut cells: Vec<String>| {
        while cells.len() > required && cells.last().is_some_and(String::is_empty) {
            cells.pop();
        }
        let n_filled = cells.iter().filter(|c| !c.is_empty()).count();
        let is_dense = cells.len() >= required
            && cells.len() <= width
            && 2 * n_filled >= cells.len().min(required);
        // A row with few names is accepted if each of them has a unit.
        let has_unit = |c: &&String| !channel_names::split_unit(c).1.is_empty();
        let is_sparse =
            cells.len() == width && cells.iter().filter(|c| !c.is_empty()).all(|c| has_unit(&c));
        ((is_dense || is_sparse) && n_filled > 0 && (width > 1 || !line.contains(['=', ':'])))
            .then_some(cells)
    };
    let delimiters = [b'\t', b';', b',', b' '];
    accept(split_by(marks.delimiter)).or_else(|| {
        if width == 1 || (!any_delimiter && marks.delimiter != b' ') {
            return None;
        }
        accept(split_at_gaps()).or_else(|| {
            delimiters
                .into_iter()
                .find_map(|d| accept(split_by(d)).filter(|c| c.len() == width))
        })
    })
}

/// Numeric column that holds words in a row with other numbers, below a row of words only.
fn broken_cell(lower: &[String], upper: &[String], layout: &TableLayout) -> Option<usize> {
    let decimal = layout.separators.decimal;
    let is_number = |cell: &String| cells::number(cell.as_bytes(), decimal).is_some();
    let is_numeric = |at: usize| layout.kinds.get(at) == Some(&CellType::Number);
    let has_number = (0..lower.len()).any(|at| is_numeric(at) && is_number(&lower[at]));
    if !has_number || upper.len() < lower.len() || upper.iter().any(is_number) {
        return None;
    }
    (0..lower.len()).find(|&at| is_numeric(at) && !is_number(&lower[at]) && !lower[at].is_empty())
}

/// The cell without quotes and line breaks.
fn clean(cell: &str) -> String {
    let cell = String::from_utf8_lossy(cells::trim_cell(cell.as_bytes())).replace("\"\"", "\"");
    cell.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Number of cells that are units, bare or in brackets.
fn units_in(cells: &[String]) -> usize {
    let bracketed = |c: &str| {
        (c.starts_with('[') && c.ends_with(']')) || (c.starts_with('(') && c.ends_with(')'))
    };
    cells
        .iter()
        .filter(|c| channel_names::is_unit(c) || bracketed(c))
        .count()
}

/// Whether the lower of two rows of words holds units: more units than the upper row, or repeated words where the upper has none.
fn is_units_row(lower: &[String], upper: &[String]) -> bool {
    let has_repeats = |cells: &[String]| {
        let words: Vec<&String> = cells.iter().filter(|c| !c.is_empty()).collect();
        (1..words.len()).any(|i| words[..i].contains(&words[i]))
    };
    let has_number = |cells: &[String]| {
        cells
            .iter()
            .any(|c| cells::number(c.as_bytes(), b'.').is_some())
    };
    if has_number(upper) {
        return false;
    }
    units_in(lower) > units_in(upper)
        || (units_in(lower) > 0 && has_repeats(lower) && !has_repeats(upper))
}
