//! Cell parsing: number, missing sample, overload, complex number or text.

use crate::recording::decimal;

/// Delimiter between cells and decimal mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Separators {
    /// Delimiter; a space matches any run of spaces and tabs.
    pub delimiter: u8,
    /// `.` or `,`.
    pub decimal: u8,
}

/// Content of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cell {
    /// A finite number.
    Number(f64),
    /// A finite number with thousands separators.
    Thousands {
        /// The number.
        value: f64,
        /// Whether separators and decimal mark leave no other reading.
        unambiguous: bool,
    },
    /// `1+2i`: real and imaginary part.
    Complex(f64, f64),
    /// Missing sample: blank, `***`, `###` or one of `MISSING_WORDS`.
    Missing,
    /// Sample beyond the range of the instrument: one of `OVERLOAD_WORDS`.
    Overload,
    /// Anything else.
    Text,
}

/// Words for a missing sample, in lower case.
const MISSING_WORDS: &[&str] = &[
    "nan",
    "-nan",
    "+nan",
    "nan(ind)",
    "-nan(ind)",
    "inf",
    "-inf",
    "+inf",
    "infinity",
    "-infinity",
    "+infinity",
    "∞",
    "-∞",
    "+∞",
    "null",
    "none",
    "n/a",
    "na",
    "#n/a",
    "#nv",
    "#value!",
    "#num!",
    "#div/0!",
    "-",
    "--",
    "---",
    "?",
    "no data",
    "nodata",
    "missing",
    "invalid",
    "bad",
];

/// Words for a sample beyond the range of the instrument, in lower case, without sign.
const OVERLOAD_WORDS: &[&str] = &[
    "overload",
    "overld",
    "ovld",
    "ovl",
    "ovr",
    "over",
    "overrange",
    "over range",
    "overflow",
    "ol",
    "clip",
    "clipped",
    "saturated",
    "underrange",
    "under range",
    "underflow",
    "under",
    "überlast",
    "ueberlast",
    "übersteuert",
    "uebersteuert",
    "过载",
];

/// Maximum length of a number or one of the words, bytes.
const MAX_NUMBER_LEN: usize = 64;

/// Parsed content of a cell; surrounding blanks and quotes are ignored.
pub fn parse_cell(cell: &[u8], decimal: u8) -> Cell {
    let cell = trim_cell(cell);
    if cell.is_empty() {
        return Cell::Missing;
    }
    if cell.len() > MAX_NUMBER_LEN {
        return Cell::Text;
    }
    if let Some(value) = number(cell, decimal) {
        return Cell::Number(value);
    }
    if let Some((value, unambiguous)) = grouped(cell, decimal) {
        return Cell::Thousands { value, unambiguous };
    }
    if let Some((re, im)) = complex(cell, decimal) {
        return Cell::Complex(re, im);
    }
    parse_word(cell)
}

/// The cell without surrounding blanks and quotes.
pub fn trim_cell(cell: &[u8]) -> &[u8] {
    let cell = cell.trim_ascii();
    match cell {
        [b'"', inner @ .., b'"'] | [b'\'', inner @ .., b'\''] => inner.trim_ascii(),
        _ => cell,
    }
}

/// The finite number that fills the cell: sign, digits, decimal mark, exponent (`E`, `D`, or Fortran's bare three digits).
pub fn number(cell: &[u8], decimal: u8) -> Option<f64> {
    let can_start = |b: &u8| b.is_ascii_digit() || matches!(*b, b'+' | b'-' | b'.' | b',' | 0xE2);
    if !cell.first().is_some_and(can_start) || !cell.iter().any(u8::is_ascii_digit) {
        return None;
    }
    let cell = match cell {
        [b'+', rest @ ..] if rest.first().is_some_and(|b| !matches!(b, b'+' | b'-')) => rest,
        _ => cell,
    };
    let mut buffer = [0; MAX_NUMBER_LEN + 1];
    let mut n = 0;
    let mut rest = cell;
    while let Some((&byte, after)) = rest.split_first() {
        rest = after;
        *buffer.get_mut(n)? = match byte {
            b if b == decimal => b'.',
            b'.' | b',' => return None,
            b'd' | b'D' => b'E',
            // The typographic minus sign, U+2212.
            0xE2 => {
                rest = after.strip_prefix(&[0x88, 0x92])?;
                b'-'
            }
            b => b,
        };
        n += 1;
    }
    let text = &buffer[..n];
    let value = match decimal::parse(text, b'.') {
        Some(value) => value,
        None => {
            // `1.234567-100`: Fortran omits the letter before an exponent of three digits.
            let sign = n.checked_sub(4).filter(|&at| at > 2)?;
            let exponent = text[sign + 1..].iter().all(u8::is_ascii_digit);
            if !exponent || !matches!(text[sign], b'+' | b'-') || !text[..sign].contains(&b'.') {
                return None;
            }
            buffer.copy_within(sign..n, sign + 1);
            buffer[sign] = b'E';
            decimal::parse(&buffer[..=n], b'.')?
        }
    };
    value.is_finite().then_some(value)
}

/// The number of a cell with thousands separators, and whether no other reading is possible.
fn grouped(cell: &[u8], decimal: u8) -> Option<(f64, bool)> {
    let text = std::str::from_utf8(cell).ok()?;
    let sign = usize::from(text.starts_with(['+', '-']));
    let mark = char::from(decimal);
    let (whole, fraction) = match text[sign..].split_once(mark) {
        Some((whole, fraction)) => (whole, Some(fraction)),
        None => (&text[sign..], None),
    };
    let separator = whole.chars().find(|c| !c.is_ascii_digit())?;
    let separators = [' ', '\u{a0}', '\u{202f}', '\u{2009}', '\'', '’', '.', ','];
    if !separators.contains(&separator) || separator == mark {
        return None;
    }
    let mut digits = text[..sign].to_string();
    let mut groups = 0;
    for (index, group) in whole.split(separator).enumerate() {
        let is_valid = if index == 0 {
            (1..=3).contains(&group.len())
        } else {
            group.len() == 3
        };
        if !is_valid || !group.bytes().all(|b| b.is_ascii_digit()) {
            return None;
        }
        digits.push_str(group);
        groups += 1;
    }
    if let Some(fraction) = fraction {
        digits.push('.');
        digits.push_str(fraction);
    }
    let value = number(digits.as_bytes(), b'.')?;
    let unambiguous = groups > 2 || fraction.is_some() || !matches!(separator, '.' | ',');
    Some((value, unambiguous))
}

/// Real and imaginary part of `1+2i`, `(1.5-2e-3j)`, `1 - 2i`, `2i`.
fn complex(cell: &[u8], decimal: u8) -> Option<(f64, f64)> {
    let inner = match cell {
        [b'(', inner @ .., b')'] => inner,
        _ => cell,
    };
    let digits: Vec<u8> = inner.iter().copied().filter(|b| *b != b' ').collect();
    let [body @ .., b'i' | b'j' | b'I' | b'J'] = digits.as_slice() else {
        return None;
    };
    let body = body.strip_suffix(b"*").unwrap_or(body);
    let is_split = |at: &usize| {
        *at > 0 && matches!(body[*at], b'+' | b'-') && !matches!(body[*at - 1], b'e' | b'E')
    };
    match (0..body.len()).rev().find(is_split) {
        Some(at) => {
            let imaginary = match &body[at..] {
                b"+" => 1.0,
                b"-" => -1.0,
                part => number(part, decimal)?,
            };
            Some((number(&body[..at], decimal)?, imaginary))
        }
        None => Some((0.0, number(body, decimal)?)),
    }
}

/// Classifies a word as missing sample, overload or text.
fn parse_word(cell: &[u8]) -> Cell {
    if cell.iter().all(|b| *b == b'*') || cell.iter().all(|b| *b == b'#') {
        return Cell::Missing;
    }
    // A word that is not UTF-8 is taken as Latin-1.
    let latin = || cell.iter().map(|&b| char::from(b)).collect::<String>();
    let text = std::str::from_utf8(cell).map_or_else(|_| latin(), str::to_string);
    let text = text.to_lowercase();
    // Old Windows C libraries print -1.#IND, 1.#QNAN, 1.#INF00.
    let windows = text.trim_start_matches(['+', '-']).strip_prefix("1.#");
    if windows
        .is_some_and(|w| w.starts_with("ind") || w.starts_with("qnan") || w.starts_with("inf"))
        || MISSING_WORDS.contains(&text.as_str())
    {
        return Cell::Missing;
    }
    if OVERLOAD_WORDS.contains(&text.trim_start_matches(['+', '-', '>', '<'])) {
        return Cell::Overload;
    }
    Cell::Text
}

/// Iterator over the cells of a row with the byte index of their start; delimiters inside quotes do not split.
pub struct CellIter<'r> {
    row: &'r [u8],
    at: Option<usize>,
    delimiter: u8,
}

impl<'r> CellIter<'r> {
    /// Cells of `row`, which must not contain a line end.
    pub fn new(row: &'r [u8], delimiter: u8) -> CellIter<'r> {
        let at = if delimiter == b' ' {
            skip_blanks(row, 0)
        } else {
            0
        };
        let empty = delimiter == b' ' && at == row.len();
        CellIter {
            row,
            at: (!empty).then_some(at),
            delimiter,
        }
    }
}

impl<'r> Iterator for CellIter<'r> {
    type Item = (usize, &'r [u8]);

    fn next(&mut self) -> Option<(usize, &'r [u8])> {
        let start = self.at?;
        let end = cell_end(self.row, start, self.delimiter);
        self.at = if end >= self.row.len() {
            None
        } else if self.delimiter == b' ' {
            let next = skip_blanks(self.row, end);
            (next < self.row.len()).then_some(next)
        } else {
            Some(end + 1)
        };
        Some((start, &self.row[start..end]))
    }
}

/// End of the cell that begins at `start`.
pub fn cell_end(row: &[u8], start: usize, delimiter: u8) -> usize {
    let rest = &row[start..];
    let blanks = rest.iter().take_while(|b| **b == b' ').count();
    if rest.get(blanks) == Some(&b'"') {
        // A quote ends at the next one that is not doubled; an unclosed quote is an ordinary character.
        let mut at = blanks + 1;
        while let Some(offset) = memchr::memchr(b'"', &rest[at..]) {
            at += offset + 1;
            if rest.get(at) != Some(&b'"') {
                let end = at + len_to_delimiter(&rest[at..], delimiter);
                return start + end;
            }
            at += 1;
        }
    }
    start + len_to_delimiter(rest, delimiter)
}

/// Number of bytes before the next delimiter.
fn len_to_delimiter(rest: &[u8], delimiter: u8) -> usize {
    let position = match delimiter {
        b' ' => memchr::memchr2(b' ', b'\t', rest),
        delimiter => memchr::memchr(delimiter, rest),
    };
    position.unwrap_or(rest.len())
}

/// Start of the cell at `at`, after blanks if these are the delimiter.
pub fn skip_blanks_of(row: &[u8], at: usize, delimiter: u8) -> usize {
    if delimiter == b' ' {
        skip_blanks(row, at)
    } else {
        at
    }
}

/// Index of the first byte from `at` on that is not a blank.
pub fn skip_blanks(row: &[u8], at: usize) -> usize {
    let is_blank = |b: &&u8| matches!(**b, b' ' | b'\t');
    at + row[at..].iter().take_while(is_blank).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number formats of exports and of manual entry.
    #[test]
    fn exact_numbers_of_every_shape() {
        let plain: &[(&str, f64)] = &[
            ("1.5", 1.5),
            ("-1.5e3", -1500.0),
            ("+2", 2.0),
            ("1.5E-003", 1.5e-3),
            (" 7 ", 7.0),
            ("\"3.25\"", 3.25),
            (".5", 0.5),
            ("5.", 5.0),
            ("1.0D-02", 0.01),
            ("1.234-100", 1.234e-100),
            ("−4.5", -4.5),
            ("2.614265943586755E-4", 2.614265943586755e-4),
            ("1e-320", 1e-320),
        ];
        for &(text, value) in plain {
            assert_eq!(
                parse_cell(text.as_bytes(), b'.'),
                Cell::Number(value),
                "{text}"
            );
        }
        assert_eq!(parse_cell(b"-1,5E-3", b','), Cell::Number(-1.5e-3));
        let grouped: &[(&str, u8, f64, bool)] = &[
            ("1,234.5", b'.', 1234.5, true),
            ("1.234.567,5", b',', 1_234_567.5, true),
            ("1 234", b'.', 1234.0, true),
            ("1'234.5", b'.', 1234.5, true),
            ("1,234", b'.', 1234.0, false),
            ("-12\u{202f}345,25", b',', -12_345.25, true),
        ];
        for &(text, decimal, value, unambiguous) in grouped {
            assert_eq!(
                parse_cell(text.as_bytes(), decimal),
                Cell::Thousands { value, unambiguous },
                "{text}"
            );
        }
        assert_eq!(parse_cell(b"(1.5-2e-3j)", b'.'), Cell::Complex(1.5, -2e-3));
        assert_eq!(parse_cell(b"1E-2 + 2i", b'.'), Cell::Complex(1e-2, 2.0));
        assert_eq!(parse_cell(b"-2i", b'.'), Cell::Complex(0.0, -2.0));
    }

    /// Words for missing and overloaded samples; any other word is text.
    #[test]
    fn exact_words_for_no_number() {
        for text in [
            "",
            "  ",
            "NaN",
            "-1.#IND",
            "1.#QNAN00",
            "***",
            "∞",
            "-Inf",
            "#####",
            "N/A",
        ] {
            assert_eq!(parse_cell(text.as_bytes(), b'.'), Cell::Missing, "{text}");
        }
        for text in ["OVERLOAD", "Over", "-OVL", "Over range"] {
            assert_eq!(parse_cell(text.as_bytes(), b'.'), Cell::Overload, "{text}");
        }
        for text in [
            "abc", "1.2.3", "1,23,456", "1e400", "--5", "+-5", "i", "1-2", "1.5 g", "e5", "-",
        ] {
            let is = parse_cell(text.as_bytes(), b'.');
            assert!(is == Cell::Text || text == "-", "{text}: {is:?}");
        }
    }

    /// Delimiters inside quotes do not split; a run of blanks is one delimiter.
    #[test]
    fn exact_cells_of_a_row() {
        let split = |row: &'static str, delimiter| -> Vec<&str> {
            let cells = CellIter::new(row.as_bytes(), delimiter);
            cells
                .map(|(_, c)| std::str::from_utf8(c).unwrap())
                .collect()
        };
        assert_eq!(
            split("a,\"b,\"\"c\",d,", b','),
            ["a", "\"b,\"\"c\"", "d", ""]
        );
        assert_eq!(split("  1 \t 2  ", b' '), ["1", "2"]);
        assert_eq!(split("5\" pipe,2", b','), ["5\" pipe", "2"]);
        assert_eq!(split("\"open,2", b','), ["\"open", "2"]);
        assert_eq!(split("", b','), [""]);
    }
}
