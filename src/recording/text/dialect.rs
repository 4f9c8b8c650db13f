//! Dialect detection of a text log: separators, first data row, data type of each column.
//!
//! The dialect is detected in the first megabyte of the file.

use super::cells::{self, Cell, CellIter, Separators};
use super::time_stamps::{self, StampFormat};
use crate::recording::read_options::DialectOptions;

/// Type of the cells of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CellType {
    /// Blank or missing.
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

/// Table layout of a text log.
#[derive(Debug, Clone)]
pub struct TableLayout {
    /// Delimiter and decimal mark.
    pub separators: Separators,
    /// Cell type of each column, trailing empty ones included.
    pub kinds: Vec<CellType>,
    /// Index of the first line of numbers among the lines of the head.
    pub first: usize,
    /// Whether a comma taken for the decimal mark may be a thousands separator.
    pub ambiguous_comma: bool,
}

/// Number of lines scored to choose the separators: the last of the head, which are most likely data rows.
const SCORED_LINES: usize = 200;

/// Number of consecutive data rows that mark the beginning of the data.
const MIN_DATA_RUN: usize = 3;

/// Candidate delimiters and decimal marks; the earlier one is chosen if the scores are equal.
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

/// Scores a line as a row of numbers and counts its cells.
fn line_score(line: &str, marks: Separators) -> (f64, usize) {
    let (mut score, mut count, mut numbers) = (0.0, 0, 0);
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
        score += gain;
    }
    (if numbers > 0 { score } else { 0.0 }, count)
}

/// Scores lines: the largest sum of line scores with an equal number of cells, and that number.
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

/// Detects the layout of a log from the lines of its head; `None` if no line is a row of numbers.
pub fn detect(lines: &[&str], settings: &DialectOptions) -> Option<TableLayout> {
    let is_filled = |line: &&&str| !line.trim().is_empty();
    let mut sample: Vec<&str> = lines
        .iter()
        .rev()
        .filter(is_filled)
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
    let is_ambiguous = |line: &&str| {
        CellIter::new(line.as_bytes(), marks.delimiter).all(|(_, cell)| {
            let cell = cells::trim_cell(cell);
            !cell.contains(&b',') || matches!(cells::parse_cell(cell, b'.'), Cell::Thousands { .. })
        })
    };
    let is_chosen = settings.decimal.is_none() && marks.decimal == b',';
    let data = || lines.get(first..).unwrap_or(&[]).iter().take(SCORED_LINES);
    Some(TableLayout {
        separators: marks,
        first,
        ambiguous_comma: is_chosen && data().all(is_ambiguous),
        kinds,
    })
}

/// Chooses the separators with the highest score, with the number of cells of a row.
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
        // If tabs delimit cells, blanks belong to the cells.
        let blanks_inside = marks.delimiter == b' '
            && best.is_some_and(|(fit, m, n)| m.delimiter == b'\t' && n > 1 && fit > 0.0);
        let (fit, width) = score(sample, marks);
        if !blanks_inside && fit > best.map_or(0.0, |b| b.0) {
            best = Some((fit, marks, width));
        }
    }
    let (_, marks, width) = best?;
    let is_automatic = settings.delimiter.is_none() && settings.decimal.is_none();
    if is_automatic
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

/// Whether rows such as `0,123` are one column with a decimal comma rather than two columns of integers.
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

/// Most frequent cell type of each column in the rows with `width` cells.
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
    let most_frequent = |votes: Vec<(CellType, usize)>| {
        let top = votes
            .into_iter()
            .reduce(|a, b| if b.1 > a.1 { b } else { a });
        top.map_or(CellType::Empty, |vote| vote.0)
    };
    votes.into_iter().map(most_frequent).collect()
}

/// Classification of a line by the cell types of the columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineKind {
    /// Blanks only.
    Blank,
    /// Data row with the cell types of the columns.
    Row,
    /// A majority of numbers, but not the cell types of the columns.
    PartialRow,
    /// Words.
    Words,
}

/// Classifies a line by the cell types of the columns.
pub fn line_kind(line: &str, marks: Separators, kinds: &[CellType]) -> LineKind {
    if line.trim().is_empty() {
        return LineKind::Blank;
    }
    let (mut count, mut is_match, mut numbers, mut words) = (0, true, 0, 0);
    for (_, cell) in CellIter::new(line.as_bytes(), marks.delimiter) {
        let kind = cell_type(cell, marks.decimal);
        let expected = kinds.get(count).copied().unwrap_or_default();
        is_match &= kind == CellType::Empty
            || expected == CellType::Text
            || expected == kind
            || (expected == CellType::Empty && kind == CellType::Number);
        words += usize::from(kind == CellType::Text);
        numbers += usize::from(matches!(
            kind,
            CellType::Number | CellType::Complex | CellType::Stamp(_)
        ));
        count += 1;
    }
    let required = kinds
        .iter()
        .rposition(|k| *k != CellType::Empty)
        .map_or(0, |at| at + 1);
    if is_match && numbers > 0 && count >= required && count <= kinds.len() {
        LineKind::Row
    } else if numbers > words && (numbers > 1 || kinds.len() == 1) {
        LineKind::PartialRow
    } else {
        LineKind::Words
    }
}

/// Index of the first data row: the first of a run of rows, or an earlier row separated from it only by blank, partial or broken rows.
fn first_row(lines: &[&str], marks: Separators, kinds: &[CellType]) -> Option<usize> {
    let mut line_kinds = Vec::new();
    let (mut best, mut start, mut run) = (None, 0, 0);
    for (at, line) in lines.iter().enumerate() {
        let kind = line_kind(line, marks, kinds);
        line_kinds.push(kind);
        match kind {
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
        match line_kinds[at] {
            LineKind::Row => first = at,
            LineKind::Words if is_broken_row(lines[at], marks, kinds) => {}
            LineKind::Words => break,
            LineKind::Blank | LineKind::PartialRow => {}
        }
    }
    Some(first)
}

/// Whether a row has the right width and a number in a number column.
fn is_broken_row(line: &str, marks: Separators, kinds: &[CellType]) -> bool {
    let cells: Vec<&[u8]> = CellIter::new(line.as_bytes(), marks.delimiter)
        .map(|(_, cell)| cell)
        .collect();
    let is_number = |(cell, expected): (&&[u8], &CellType)| {
        *expected == CellType::Number && cell_type(cell, marks.decimal) == CellType::Number
    };
    cells.len() == kinds.len() && cells.iter().zip(kinds).any(is_number)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(text: &str) -> (char, char, usize, usize) {
        let lines: Vec<&str> = text.lines().collect();
        let table = detect(&lines, &DialectOptions::default()).unwrap();
        let marks = table.separators;
        (
            char::from(marks.delimiter),
            char::from(marks.decimal),
            table.kinds.len(),
            table.first,
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
