//! Column names and units above the data rows, and preamble lines.

use super::cells::{self, CellIter, Separators};
use super::dialect::{CellType, TableLayout};
use super::preamble::{is_comment, strip_comment};
use crate::recording::channel_names;

/// Contents of the lines above the numbers.
#[derive(Debug, Default)]
pub struct TableHeader {
    /// Name of each column as written; empty where there is none.
    pub raw_names: Vec<String>,
    /// Name of each column without its unit; empty where there is none.
    pub names: Vec<String>,
    /// Unit of each column; empty where there is none.
    pub units: Vec<String>,
    /// Lines of the preamble, by index.
    pub preamble: Vec<usize>,
    /// A row of words that could be names but for its number of cells: its index, and how many cells.
    pub misfit_row: Option<(usize, usize)>,
    /// A row below the names with a number in one column of numbers and words in another: its index, and that cell's.
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
    // The nearest line of words that fits, and the one next above it; between them and the numbers lies no other word.
    for (at, line) in above.iter().enumerate().rev() {
        if line.trim().is_empty() || !line.contains(char::is_alphabetic) {
            continue;
        }
        match row(line, layout.marks, required, width, rows.is_empty()) {
            Some(cells) => rows.push((at, cells)),
            None if rows.is_empty() => {
                let cells = CellIter::new(line.as_bytes(), layout.marks.delimiter).count();
                if !is_comment(line) && cells > 2 && layout.marks.delimiter != b' ' {
                    misfit = Some((at, cells));
                }
                // A line of words directly above the numbers that does not fit: there are no names.
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
    if let (Some((at, nearest)), Some((_, upper))) = (rows.first(), rows.get(1)) {
        header.broken_row = broken_cell(nearest, upper, layout).map(|cell| (*at, cell));
    }
    if let Some((at, cells)) = rows.first() {
        used.push(*at);
        let nearest_is_units = rows
            .get(1)
            .is_some_and(|(_, upper)| is_units_row(cells, upper));
        let upper_is_units = rows.get(1).is_some_and(|(_, upper)| {
            2 * units_in(upper) > upper.len() && units_in(upper) > units_in(cells)
        });
        let (written, units) = match rows.get(1) {
            Some((second, upper)) if nearest_is_units => {
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
        header.fill(written, &units, width);
    } else {
        header.fill(Vec::new(), &[], width);
    }
    header.preamble = (0..above.len())
        .filter(|at| !used.contains(at) && !above[*at].trim().is_empty())
        .collect();
    header
}

impl TableHeader {
    fn fill(&mut self, mut written: Vec<String>, units: &[String], width: usize) {
        written.resize(width, String::new());
        for (column, cell) in written.iter().enumerate() {
            let (name, mut unit) = channel_names::split_unit(cell);
            if let Some(own) = units.get(column).filter(|u| !u.is_empty()) {
                unit = channel_names::unit_of_cell(own);
            }
            self.names.push(name);
            self.units.push(unit);
        }
        self.raw_names = written;
    }
}

/// The cells of a row of words, where there are as many as columns; `free`ly parted where the delimiter does not fit.
fn row(
    line: &str,
    marks: Separators,
    required: usize,
    width: usize,
    free: bool,
) -> Option<Vec<String>> {
    let line = if is_comment(line) {
        strip_comment(line)
    } else {
        line
    };
    let by = |delimiter: u8| -> Vec<String> {
        let cells = CellIter::new(line.as_bytes(), delimiter);
        cells
            .map(|(start, cell)| clean(&line[start..start + cell.len()]))
            .collect()
    };
    let wide_gaps = || {
        line.split("  ")
            .map(clean)
            .filter(|c| !c.is_empty())
            .collect::<Vec<String>>()
    };
    let fits = |mut cells: Vec<String>| {
        while cells.len() > required && cells.last().is_some_and(String::is_empty) {
            cells.pop();
        }
        let filled = cells.iter().filter(|c| !c.is_empty()).count();
        let enough = cells.len() >= required
            && cells.len() <= width
            && 2 * filled >= cells.len().min(required);
        // A single name stands over columns without one where it has a unit.
        let with_unit = |c: &&String| !channel_names::split_unit(c).1.is_empty();
        let sparse = cells.len() == width
            && cells
                .iter()
                .filter(|c| !c.is_empty())
                .all(|c| with_unit(&c));
        ((enough || sparse) && filled > 0 && (width > 1 || !line.contains(['=', ':'])))
            .then_some(cells)
    };
    let others = [b'\t', b';', b',', b' '];
    fits(by(marks.delimiter)).or_else(|| {
        if width == 1 || (!free && marks.delimiter != b' ') {
            return None;
        }
        fits(wide_gaps()).or_else(|| {
            others
                .into_iter()
                .find_map(|d| fits(by(d)).filter(|c| c.len() == width))
        })
    })
}

/// The cell of words in a row that otherwise is one of numbers, below a row of words alone.
fn broken_cell(nearest: &[String], upper: &[String], layout: &TableLayout) -> Option<usize> {
    let decimal = layout.marks.decimal;
    let is_number = |cell: &String| cells::number(cell.as_bytes(), decimal).is_some();
    let of_numbers = |at: usize| layout.kinds.get(at) == Some(&CellType::Number);
    let numbers = (0..nearest.len()).any(|at| of_numbers(at) && is_number(&nearest[at]));
    if !numbers || upper.len() < nearest.len() || upper.iter().any(is_number) {
        return None;
    }
    (0..nearest.len())
        .find(|&at| of_numbers(at) && !is_number(&nearest[at]) && !nearest[at].is_empty())
}

/// A name without quotes and line breaks.
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

/// Whether the nearer of two rows of words holds units: more units than the upper one, or words that repeat where the upper one's do not.
fn is_units_row(nearest: &[String], upper: &[String]) -> bool {
    let repeats = |cells: &[String]| {
        let filled: Vec<&String> = cells.iter().filter(|c| !c.is_empty()).collect();
        (1..filled.len()).any(|i| filled[..i].contains(&filled[i]))
    };
    let numbers = |cells: &[String]| {
        cells
            .iter()
            .any(|c| cells::number(c.as_bytes(), b'.').is_some())
    };
    if numbers(upper) {
        return false;
    }
    units_in(nearest) > units_in(upper)
        || (units_in(nearest) > 0 && repeats(nearest) && !repeats(upper))
}
