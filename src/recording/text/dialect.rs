//! Dialect detection of a text log: separators, first data row, data type of each column.
//!
//! Found from the first megabyte.

use super::cells::{self, Cell, CellIter, Separators};
use super::time_stamps::{self, StampFormat};
use crate::recording::read_options::DialectOptions;

/// Type of the cells of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CellType {
    /// Nothing yet.
    #[default]
    Empty,
    /// Numbers.
    Number,
    /// Complex numbers.
    Complex,
    /// Dates or times.
    Stamp(StampFormat),
    /// Words.
    Text,
}

/// The layout of the numbers of a text log.
#[derive(Debug, Clone)]
pub struct TableLayout {
    /// Delimiter and decimal mark.
    pub marks: Separators,
    /// Cell type of each column, trailing empty ones included.
    pub kinds: Vec<CellType>,
    /// Index of the first line of numbers among the lines of the head.
    pub first: usize,
    /// The decimal mark was taken where a thousands separator could be meant.
    pub ambiguous_comma: bool,
}

/// Lines looked at to choose the marks: the last of the head, which are the most likely to be numbers.
const SCORED_LINES: usize = 200;

/// Lines of numbers in a row that are taken for the beginning of the data.
const MIN_DATA_RUN: usize = 3;

/// Delimiters and decimal marks, the earlier one taken where two fit alike.
const SEPARATOR_CANDIDATES: &[(u8, u8)] = &[
    (b',', b'.'),
    (b';', b'.'),
    (b';', b','),
    (b'\t', b'.'),
    (b'\t', b','),
    (b'|', b'.'),
    (b'|', b','),
    (b',', b','),
    (b' ', b'.'),
    (b' ', b','),
];

/// Type of one cell.
pub fn cell_type(cell: &[u8], decimal: u8) -> CellType {
    match cells::parse_cell(cell, decimal) {
        Cell::Number(_) | Cell::Thousands { .. } => CellType::Number,
        Cell::Complex(..) => CellType::Complex,
        Cell::Missing | Cell::Overload => CellType::Empty,
        Cell::Text => time_stamps::detect_format(cell).map_or(CellType::Text, CellType::Stamp),
    }
}

/// Score of a line as a row of numbers, and its number of cells.
fn line_score(line: &str, marks: Separators) -> (f64, usize) {
    let (mut fit, mut count, mut numbers) = (0.0, 0, 0);
    for (_, cell) in CellIter::new(line.as_bytes(), marks.delimiter) {
        count += 1;
        let gain = match cells::parse_cell(cell, marks.decimal) {
            Cell::Number(_) | Cell::Complex(..) => 1.0,
            Cell::Thousands {
                unambiguous: true, ..
            } => 1.0,
            Cell::Thousands {
                unambiguous: false, ..
            } => 0.5,
            Cell::Missing | Cell::Overload => 0.0,
            Cell::Text if time_stamps::detect_format(cell).is_some() => 1.0,
            Cell::Text => -1.0,
        };
        numbers += usize::from(gain > 0.0);
        fit += gain;
    }
    (if numbers > 0 { fit } else { 0.0 }, count)
}

/// The sum of fits over lines of the most fitting number of cells, and that number.
fn score(lines: &[&str], marks: Separators) -> (f64, usize) {
    let mut by_count: Vec<(f64, usize)> = Vec::new();
    for line in lines {
        let (gain, count) = line_score(line, marks);
        if gain <= 0.0 {
            continue;
        }
        match by_count.iter_mut().find(|entry| entry.1 == count) {
            Some(entry) => entry.0 += gain,
            None => by_count.push((gain, count)),
        }
    }
    let best = by_count
        .into_iter()
        .reduce(|a, b| if b.0 > a.0 { b } else { a });
    best.unwrap_or((0.0, 0))
}

/// The layout of a log from the lines of its head; `None` where no line is a row of numbers.
pub fn detect(lines: &[&str], settings: &DialectOptions) -> Option<TableLayout> {
    let filled = |line: &&&str| !line.trim().is_empty();
    let mut sample: Vec<&str> = lines
        .iter()
        .rev()
        .filter(filled)
        .take(SCORED_LINES)
        .copied()
        .collect();
    sample.reverse();
    let (marks, width) = choose(&sample, settings)?;
    let kinds = column_types(&sample, marks, width);
    let first = match settings.header_lines {
        Some(n) => n,
        None => first_row(lines, marks, &kinds)?,
    };
    let in_doubt = |line: &&str| {
        CellIter::new(line.as_bytes(), marks.delimiter).all(|(_, cell)| {
            let cell = cells::trim_cell(cell);
            !cell.contains(&b',') || matches!(cells::parse_cell(cell, b'.'), Cell::Thousands { .. })
        })
    };
    let chosen = settings.decimal.is_none() && marks.decimal == b',';
    let data = || lines.get(first..).unwrap_or(&[]).iter().take(SCORED_LINES);
    Some(TableLayout {
        marks,
        first,
        ambiguous_comma: chosen && data().all(in_doubt),
        kinds,
    })
}

/// The marks that make the most numbers, and the number of cells of a row.
fn choose(sample: &[&str], settings: &DialectOptions) -> Option<(Separators, usize)> {
    let mut candidates: Vec<Separators> = SEPARATOR_CANDIDATES
        .iter()
        .map(|&(delimiter, decimal)| Separators { delimiter, decimal })
        .collect();
    if let Some(delimiter) = settings.delimiter.filter(char::is_ascii) {
        candidates = [b'.', b',']
            .map(|decimal| Separators {
                delimiter: delimiter as u8,
                decimal,
            })
            .to_vec();
    }
    if let Some(decimal) = settings.decimal.filter(char::is_ascii) {
        candidates.retain(|m| m.decimal == decimal as u8 || settings.delimiter.is_some());
        candidates
            .iter_mut()
            .for_each(|m| m.decimal = decimal as u8);
    }
    let mut best: Option<(f64, Separators, usize)> = None;
    for marks in candidates {
        // Where tabs part cells, blanks belong to the cells.
        let blanks_inside = marks.delimiter == b' '
            && best.is_some_and(|(fit, m, n)| m.delimiter == b'\t' && n > 1 && fit > 0.0);
        let (fit, width) = score(sample, marks);
        if !blanks_inside && fit > best.map_or(0.0, |b| b.0) {
            best = Some((fit, marks, width));
        }
    }
    let (_, marks, width) = best?;
    let guessed = settings.delimiter.is_none() && settings.decimal.is_none();
    if guessed
        && marks
            == (Separators {
                delimiter: b',',
                decimal: b'.',
            })
        && width == 2
        && is_one_column(sample)
    {
        return Some((
            Separators {
                delimiter: b';',
                decimal: b',',
            },
            1,
        ));
    }
    Some((marks, width))
}

/// Whether rows such as `0,123` are one column with a decimal comma and not two of whole numbers.
fn is_one_column(sample: &[&str]) -> bool {
    let (mut rows, mut zeros, mut exponents) = (0, 0, 0);
    for line in sample {
        let Some((whole, fraction)) = line.trim().split_once(',') else {
            continue;
        };
        if line_score(
            line,
            Separators {
                delimiter: b',',
                decimal: b'.',
            },
        )
        .0 < 2.0
        {
            // A row of two names, or of text.
            if line.contains(char::is_alphabetic) {
                return false;
            }
            continue;
        }
        let digits = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
        let (mantissa, exponent) = fraction.split_once(['e', 'E']).unwrap_or((fraction, ""));
        if !digits(whole.trim_start_matches(['+', '-'])) || !digits(mantissa) {
            return false;
        }
        rows += 1;
        zeros += usize::from(whole == "-0" || (fraction.len() > 1 && fraction.starts_with('0')));
        exponents += usize::from(!exponent.is_empty());
    }
    rows > 0 && (zeros > 0 || exponents == rows)
}

/// Most frequent cell type in each column of the rows with `width` cells.
fn column_types(sample: &[&str], marks: Separators, width: usize) -> Vec<CellType> {
    let mut votes: Vec<Vec<(CellType, usize)>> = vec![Vec::new(); width];
    for line in sample {
        let (gain, count) = line_score(line, marks);
        if gain <= 0.0 || count != width {
            continue;
        }
        for ((_, cell), votes) in CellIter::new(line.as_bytes(), marks.delimiter).zip(&mut votes) {
            let kind = cell_type(cell, marks.decimal);
            if kind == CellType::Empty {
                continue;
            }
            match votes.iter_mut().find(|vote| vote.0 == kind) {
                Some(vote) => vote.1 += 1,
                None => votes.push((kind, 1)),
            }
        }
    }
    let most = |votes: Vec<(CellType, usize)>| {
        let top = votes
            .into_iter()
            .reduce(|a, b| if b.1 > a.1 { b } else { a });
        top.map_or(CellType::Empty, |vote| vote.0)
    };
    votes.into_iter().map(most).collect()
}

/// Match of a line with the columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineKind {
    /// No sign but blanks.
    Blank,
    /// A row of the data.
    Row,
    /// Predominantly numbers, but not of the column types.
    PartialRow,
    /// Words.
    Words,
}

/// Match of a line with columns of these kinds.
pub fn line_kind(line: &str, marks: Separators, kinds: &[CellType]) -> LineKind {
    if line.trim().is_empty() {
        return LineKind::Blank;
    }
    let (mut count, mut right, mut numbers, mut words) = (0, true, 0, 0);
    for (_, cell) in CellIter::new(line.as_bytes(), marks.delimiter) {
        let is = cell_type(cell, marks.decimal);
        let wanted = kinds.get(count).copied().unwrap_or_default();
        right &= is == CellType::Empty
            || wanted == CellType::Text
            || wanted == is
            || (wanted == CellType::Empty && is == CellType::Number);
        words += usize::from(is == CellType::Text);
        numbers += usize::from(matches!(
            is,
            CellType::Number | CellType::Complex | CellType::Stamp(_)
        ));
        count += 1;
    }
    let required = kinds
        .iter()
        .rposition(|k| *k != CellType::Empty)
        .map_or(0, |at| at + 1);
    if right && numbers > 0 && count >= required && count <= kinds.len() {
        LineKind::Row
    } else if numbers > words && (numbers > 1 || kinds.len() == 1) {
        LineKind::PartialRow
    } else {
        LineKind::Words
    }
}

/// The first line of numbers: the first of a run of rows, and rows above it that only misfits part from it.
fn first_row(lines: &[&str], marks: Separators, kinds: &[CellType]) -> Option<usize> {
    let mut stances = Vec::new();
    let (mut best, mut start, mut run) = (None, 0, 0);
    for (at, line) in lines.iter().enumerate() {
        let stance = line_kind(line, marks, kinds);
        stances.push(stance);
        match stance {
            LineKind::Blank => continue,
            LineKind::Row => {
                start = if run == 0 { at } else { start };
                run += 1;
            }
            LineKind::PartialRow | LineKind::Words => run = 0,
        }
        if run > best.map_or(0, |(_, length)| length) {
            best = Some((start, run));
        }
        if run >= MIN_DATA_RUN {
            break;
        }
    }
    let (mut first, _): (usize, usize) = best?;
    for at in (0..first).rev() {
        match stances[at] {
            LineKind::Row => first = at,
            LineKind::Words if is_broken_row(lines[at], marks, kinds) => {}
            LineKind::Words => break,
            LineKind::Blank | LineKind::PartialRow => {}
        }
    }
    Some(first)
}

/// A row of the right width with a number in a column of numbers, whatever the others hold.
fn is_broken_row(line: &str, marks: Separators, kinds: &[CellType]) -> bool {
    let cells: Vec<&[u8]> = CellIter::new(line.as_bytes(), marks.delimiter)
        .map(|(_, cell)| cell)
        .collect();
    let is_number = |(cell, wanted): (&&[u8], &CellType)| {
        *wanted == CellType::Number && cell_type(cell, marks.decimal) == CellType::Number
    };
    cells.len() == kinds.len() && cells.iter().zip(kinds).any(is_number)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(text: &str) -> (char, char, usize, usize) {
        let lines: Vec<&str> = text.lines().collect();
        let found = detect(&lines, &DialectOptions::default()).unwrap();
        let marks = found.marks;
        (
            char::from(marks.delimiter),
            char::from(marks.decimal),
            found.kinds.len(),
            found.first,
        )
    }

    /// Delimiter, decimal mark, width and first row of small texts.
    #[test]
    fn exact_layouts() {
        assert_eq!(layout("t,a\n0,1.5\n1,2.5\n2,3\n"), (',', '.', 2, 1));
        assert_eq!(layout("1,5;2,5\n2,5;3,5\n"), (';', ',', 2, 0));
        assert_eq!(layout("1;2\n3;4\n"), (';', '.', 2, 0));
        assert_eq!(
            layout("01.02.2023 12:00:00\t1,5\t2,5\n01.02.2023 12:00:01\t1,5\t2,5\n"),
            ('\t', ',', 3, 0)
        );
        assert_eq!(layout("a\n0,123\n0,045\n-0,5\n"), (';', ',', 1, 1));
        assert_eq!(layout("  1.0   2.0 \n  3.0   4.0\n"), (' ', '.', 2, 0));
        assert_eq!(
            layout("\"1,5\",\"2,5\"\n\"3,5\",\"4,5\"\n"),
            (',', ',', 2, 0)
        );
        assert_eq!(layout("fs,5000\nx\n1.234,5;2\n2,5;3\n"), (';', ',', 2, 2));
        assert_eq!(
            layout("1,2,3\nt,a,b\n0,1,2\n1,2,3\n2,3,4\n"),
            (',', '.', 3, 2)
        );
    }
}
