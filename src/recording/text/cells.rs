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
    /// A finite number with thousands separators; `unambiguous` where it cannot be read otherwise.
    Thousands {
        /// The number.
        value: f64,
        /// Whether separators and decimal mark leave no other reading.
        unambiguous: bool,
    },
    /// `1+2i`: real and imaginary part.
    Complex(f64, f64),
    /// Blank, `NaN`, `***` and their kin.
    Missing,
    /// `OVERLOAD_WORDS` and its kin.
    Overload,
    /// Anything else.
    Text,
}

/// Words for a sample that is not there, in lower case.
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

/// The longest text a number or one of the words takes, bytes.
const MAX_NUMBER_LEN: usize = 64;

/// Parsed content of a cell; blanks and quotes around it do not matter.
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
    if let Some((value, sure)) = grouped(cell, decimal) {
        return Cell::Thousands {
            value,
            unambiguous: sure,
        };
    }
    if let Some((re, im)) = complex(cell, decimal) {
        return Cell::Complex(re, im);
    }
    parse_word(cell)
}

/// A cell without the blanks and quotes around it.
pub fn trim_cell(cell: &[u8]) -> &[u8] {
    let cell = cell.trim_ascii();
    match cell {
        [b'"', inner @ .., b'"'] | [b'\'', inner @ .., b'\''] => inner.trim_ascii(),
        _ => cell,
    }
}

/// A finite number that fills the cell: sign, digits, decimal mark, exponent (`E`, `D`, or Fortran's bare three digits).
pub fn number(cell: &[u8], decimal: u8) -> Option<f64> {
    let starts = |b: &u8| b.is_ascii_digit() || matches!(*b, b'+' | b'-' | b'.' | b',' | 0xE2);
    if !cell.first().is_some_and(starts) || !cell.iter().any(u8::is_ascii_digit) {
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
            // The minus sign of typography, U+2212.
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
            // `1.234567-100`: a field of Fortran too narrow for the letter.
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

/// A number whose digits are grouped by three, and whether it can be read in no other way.
fn grouped(cell: &[u8], decimal: u8) -> Option<(f64, bool)> {
    let text = std::str::from_utf8(cell).ok()?;
    let sign = usize::from(text.starts_with(['+', '-']));
    let mark = char::from(decimal);
    let (whole, fraction) = match text[sign..].split_once(mark) {
        Some((whole, fraction)) => (whole, Some(fraction)),
        None => (&text[sign..], None),
    };
    let separator = whole.chars().find(|c| !c.is_ascii_digit())?;
    let allowed = [' ', '\u{a0}', '\u{202f}', '\u{2009}', '\'', '’', '.', ','];
    if !allowed.contains(&separator) || separator == mark {
        return None;
    }
    let mut digits = text[..sign].to_string();
    let mut groups = 0;
    for (place, group) in whole.split(separator).enumerate() {
        let right = if place == 0 {
            (1..=3).contains(&group.len())
        } else {
            group.len() == 3
        };
        if !right || !group.bytes().all(|b| b.is_ascii_digit()) {
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
    let sure = groups > 2 || fraction.is_some() || !matches!(separator, '.' | ',');
    Some((value, sure))
}

/// `1+2i`, `(1.5-2e-3j)`, `1 - 2i`, `2i`.
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
    let splits = |at: &usize| {
        *at > 0 && matches!(body[*at], b'+' | b'-') && !matches!(body[*at - 1], b'e' | b'E')
    };
    match (0..body.len()).rev().find(splits) {
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

/// A word for no sample, or text.
fn parse_word(cell: &[u8]) -> Cell {
    if cell.iter().all(|b| *b == b'*') || cell.iter().all(|b| *b == b'#') {
        return Cell::Missing;
    }
    // What is no UTF-8 is Latin-1 in most words that could be meant.
    let latin = || cell.iter().map(|&b| char::from(b)).collect::<String>();
    let text = std::str::from_utf8(cell).map_or_else(|_| latin(), str::to_string);
    let text = text.to_lowercase();
    // What old C libraries of Windows print: -1.#IND, 1.#QNAN, 1.#INF00.
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

/// The cells of a row with the byte each begins at; quotes keep delimiters in.
pub struct CellIter<'r> {
    row: &'r [u8],
    at: Option<usize>,
    delimiter: u8,
}

impl<'r> CellIter<'r> {
    /// The cells of `row`, which holds no line end.
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
        // A quote ends at the next one that is not doubled; a quote never closed is an ordinary sign.
        let mut at = blanks + 1;
        while let Some(found) = memchr::memchr(b'"', &rest[at..]) {
            at += found + 1;
            if rest.get(at) != Some(&b'"') {
                let after = at + len_to_delimiter(&rest[at..], delimiter);
                return start + after;
            }
            at += 1;
        }
    }
    start + len_to_delimiter(rest, delimiter)
}

/// Bytes before the next delimiter.
fn len_to_delimiter(rest: &[u8], delimiter: u8) -> usize {
    let found = match delimiter {
        b' ' => memchr::memchr2(b' ', b'\t', rest),
        delimiter => memchr::memchr(delimiter, rest),
    };
    found.unwrap_or(rest.len())
}

/// Start of the cell at `at`: past blanks where these are the delimiter.
pub fn skip_blanks_of(row: &[u8], at: usize, delimiter: u8) -> usize {
    if delimiter == b' ' {
        skip_blanks(row, at)
    } else {
        at
    }
}

/// The first byte from `at` on that is no blank.
pub fn skip_blanks(row: &[u8], at: usize) -> usize {
    let blank = |b: &&u8| matches!(**b, b' ' | b'\t');
    at + row[at..].iter().take_while(blank).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers as programs and people write them.
    #[test]
    fn exact_numbers_of_every_shape() {
        let point: &[(&str, f64)] = &[
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
        for &(text, value) in point {
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
        for &(text, decimal, value, sure) in grouped {
            assert_eq!(
                parse_cell(text.as_bytes(), decimal),
                Cell::Thousands {
                    value,
                    unambiguous: sure
                },
                "{text}"
            );
        }
        assert_eq!(parse_cell(b"(1.5-2e-3j)", b'.'), Cell::Complex(1.5, -2e-3));
        assert_eq!(parse_cell(b"1E-2 + 2i", b'.'), Cell::Complex(1e-2, 2.0));
        assert_eq!(parse_cell(b"-2i", b'.'), Cell::Complex(0.0, -2.0));
    }

    /// Missing and overloaded samples are words; everything else is text.
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

    /// Quotes keep delimiters in; runs of blanks part cells once.
    #[test]
    fn exact_cells_of_a_row() {
        let of = |row: &'static str, delimiter| -> Vec<&str> {
            let cells = CellIter::new(row.as_bytes(), delimiter);
            cells
                .map(|(_, c)| std::str::from_utf8(c).unwrap())
                .collect()
        };
        assert_eq!(of("a,\"b,\"\"c\",d,", b','), ["a", "\"b,\"\"c\"", "d", ""]);
        assert_eq!(of("  1 \t 2  ", b' '), ["1", "2"]);
        assert_eq!(of("5\" pipe,2", b','), ["5\" pipe", "2"]);
        assert_eq!(of("\"open,2", b','), ["\"open", "2"]);
        assert_eq!(of("", b','), [""]);
    }
}
