//! What a text log is made of: marks, where its numbers begin, what each column holds. Found from the first megabyte.

use super::cells::{self, Cell, Cells, Marks};
use super::stamps::{self, Form};
use crate::recording::settings::DialectSettings;

/// What the cells of a column are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Kind {
    /// Nothing yet.
    #[default]
    Empty,
    /// Numbers.
    Number,
    /// Complex numbers.
    Complex,
    /// Dates or times.
    Stamp(Form),
    /// Words.
    Text,
}

/// The layout of the numbers of a text log.
#[derive(Debug, Clone)]
pub struct Layout {
    /// Delimiter and decimal mark.
    pub marks: Marks,
    /// What each column holds, trailing empty ones included.
    pub kinds: Vec<Kind>,
    /// Index of the first line of numbers among the lines of the head.
    pub first: usize,
    /// The decimal mark was taken where a thousands separator could be meant.
    pub comma_in_doubt: bool,
}

/// Lines looked at to choose the marks: the last of the head, which are the most likely to be numbers.
const SAMPLE: usize = 200;

/// Lines of numbers in a row that are taken for the beginning of the data.
const RUN: usize = 3;

/// Delimiters and decimal marks, the earlier one taken where two fit alike.
const CANDIDATES: &[(u8, u8)] = &[
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

/// What one cell is.
pub fn kind(cell: &[u8], decimal: u8) -> Kind {
    match cells::read(cell, decimal) {
        Cell::Number(_) | Cell::Grouped { .. } => Kind::Number,
        Cell::Complex(..) => Kind::Complex,
        Cell::Missing | Cell::Overload => Kind::Empty,
        Cell::Text => stamps::form(cell).map_or(Kind::Text, Kind::Stamp),
    }
}

/// How well a line fits as a row of numbers, and its number of cells.
fn fit(line: &str, marks: Marks) -> (f64, usize) {
    let (mut fit, mut count, mut numbers) = (0.0, 0, 0);
    for (_, cell) in Cells::new(line.as_bytes(), marks.delimiter) {
        count += 1;
        let gain = match cells::read(cell, marks.decimal) {
            Cell::Number(_) | Cell::Complex(..) => 1.0,
            Cell::Grouped { sure: true, .. } => 1.0,
            Cell::Grouped { sure: false, .. } => 0.5,
            Cell::Missing | Cell::Overload => 0.0,
            Cell::Text if stamps::form(cell).is_some() => 1.0,
            Cell::Text => -1.0,
        };
        numbers += usize::from(gain > 0.0);
        fit += gain;
    }
    (if numbers > 0 { fit } else { 0.0 }, count)
}

/// The sum of fits over lines of the most fitting number of cells, and that number.
fn score(lines: &[&str], marks: Marks) -> (f64, usize) {
    let mut by_count: Vec<(f64, usize)> = Vec::new();
    for line in lines {
        let (gain, count) = fit(line, marks);
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
pub fn find(lines: &[&str], settings: &DialectSettings) -> Option<Layout> {
    let filled = |line: &&&str| !line.trim().is_empty();
    let mut sample: Vec<&str> = lines
        .iter()
        .rev()
        .filter(filled)
        .take(SAMPLE)
        .copied()
        .collect();
    sample.reverse();
    let (marks, width) = choose(&sample, settings)?;
    let kinds = kinds(&sample, marks, width);
    let first = match settings.header_lines {
        Some(n) => n,
        None => first_row(lines, marks, &kinds)?,
    };
    let in_doubt = |line: &&str| {
        Cells::new(line.as_bytes(), marks.delimiter).all(|(_, cell)| {
            let cell = cells::bare(cell);
            !cell.contains(&b',') || matches!(cells::read(cell, b'.'), Cell::Grouped { .. })
        })
    };
    let chosen = settings.decimal.is_none() && marks.decimal == b',';
    let data = || lines.get(first..).unwrap_or(&[]).iter().take(SAMPLE);
    Some(Layout {
        marks,
        first,
        comma_in_doubt: chosen && data().all(in_doubt),
        kinds,
    })
}

/// The marks that make the most numbers, and the number of cells of a row.
fn choose(sample: &[&str], settings: &DialectSettings) -> Option<(Marks, usize)> {
    let mut candidates: Vec<Marks> = CANDIDATES
        .iter()
        .map(|&(delimiter, decimal)| Marks { delimiter, decimal })
        .collect();
    if let Some(delimiter) = settings.delimiter.filter(char::is_ascii) {
        candidates = [b'.', b',']
            .map(|decimal| Marks {
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
    let mut best: Option<(f64, Marks, usize)> = None;
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
            == (Marks {
                delimiter: b',',
                decimal: b'.',
            })
        && width == 2
        && is_one_column(sample)
    {
        return Some((
            Marks {
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
        if fit(
            line,
            Marks {
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

/// What each column of the rows with `width` cells mostly holds.
fn kinds(sample: &[&str], marks: Marks, width: usize) -> Vec<Kind> {
    let mut votes: Vec<Vec<(Kind, usize)>> = vec![Vec::new(); width];
    for line in sample {
        let (gain, count) = fit(line, marks);
        if gain <= 0.0 || count != width {
            continue;
        }
        for ((_, cell), votes) in Cells::new(line.as_bytes(), marks.delimiter).zip(&mut votes) {
            let kind = kind(cell, marks.decimal);
            if kind == Kind::Empty {
                continue;
            }
            match votes.iter_mut().find(|vote| vote.0 == kind) {
                Some(vote) => vote.1 += 1,
                None => votes.push((kind, 1)),
            }
        }
    }
    let most = |votes: Vec<(Kind, usize)>| {
        let top = votes
            .into_iter()
            .reduce(|a, b| if b.1 > a.1 { b } else { a });
        top.map_or(Kind::Empty, |vote| vote.0)
    };
    votes.into_iter().map(most).collect()
}

/// How a line stands to the columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stance {
    /// No sign but blanks.
    Blank,
    /// A row of the data.
    Row,
    /// Mostly numbers, but not as the columns want them.
    Misfit,
    /// Words.
    Words,
}

/// How a line stands to columns of these kinds.
pub fn stance(line: &str, marks: Marks, kinds: &[Kind]) -> Stance {
    if line.trim().is_empty() {
        return Stance::Blank;
    }
    let (mut count, mut right, mut numbers, mut words) = (0, true, 0, 0);
    for (_, cell) in Cells::new(line.as_bytes(), marks.delimiter) {
        let is = kind(cell, marks.decimal);
        let wanted = kinds.get(count).copied().unwrap_or_default();
        right &= is == Kind::Empty
            || wanted == Kind::Text
            || wanted == is
            || (wanted == Kind::Empty && is == Kind::Number);
        words += usize::from(is == Kind::Text);
        numbers += usize::from(matches!(is, Kind::Number | Kind::Complex | Kind::Stamp(_)));
        count += 1;
    }
    let required = kinds
        .iter()
        .rposition(|k| *k != Kind::Empty)
        .map_or(0, |at| at + 1);
    if right && numbers > 0 && count >= required && count <= kinds.len() {
        Stance::Row
    } else if numbers > words && (numbers > 1 || kinds.len() == 1) {
        Stance::Misfit
    } else {
        Stance::Words
    }
}

/// The first line of numbers: the first of a run of rows, and rows above it that only misfits part from it.
fn first_row(lines: &[&str], marks: Marks, kinds: &[Kind]) -> Option<usize> {
    let mut stances = Vec::new();
    let (mut best, mut start, mut run) = (None, 0, 0);
    for (at, line) in lines.iter().enumerate() {
        let stance = stance(line, marks, kinds);
        stances.push(stance);
        match stance {
            Stance::Blank => continue,
            Stance::Row => {
                start = if run == 0 { at } else { start };
                run += 1;
            }
            Stance::Misfit | Stance::Words => run = 0,
        }
        if run > best.map_or(0, |(_, length)| length) {
            best = Some((start, run));
        }
        if run >= RUN {
            break;
        }
    }
    let (mut first, _): (usize, usize) = best?;
    for at in (0..first).rev() {
        match stances[at] {
            Stance::Row => first = at,
            Stance::Words if is_broken_row(lines[at], marks, kinds) => {}
            Stance::Words => break,
            Stance::Blank | Stance::Misfit => {}
        }
    }
    Some(first)
}

/// A row of the right width with a number in a column of numbers, whatever stands in the others.
fn is_broken_row(line: &str, marks: Marks, kinds: &[Kind]) -> bool {
    let cells: Vec<&[u8]> = Cells::new(line.as_bytes(), marks.delimiter)
        .map(|(_, cell)| cell)
        .collect();
    let is_number = |(cell, wanted): (&&[u8], &Kind)| {
        *wanted == Kind::Number && kind(cell, marks.decimal) == Kind::Number
    };
    cells.len() == kinds.len() && cells.iter().zip(kinds).any(is_number)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(text: &str) -> (char, char, usize, usize) {
        let lines: Vec<&str> = text.lines().collect();
        let found = find(&lines, &DialectSettings::default()).unwrap();
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
