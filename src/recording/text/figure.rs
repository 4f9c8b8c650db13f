//! Parser of header numbers with units, with optional thousands separators and a decimal point or comma.

use super::cells;
use crate::recording::channel_names;

/// Factor of a unit of rate to Hz, or of a unit of interval to s. Only case distinguishes mega from milli.
pub(super) fn unit_factor(unit: &str, rate: bool) -> Option<f64> {
    match (unit, rate) {
        ("MHz" | "MHZ" | "MS/s" | "MSa/s" | "MSPS" | "Msps", true) => return Some(1e6),
        ("mHz", true) => return Some(1e-3),
        _ => {}
    }
    Some(match (unit.to_lowercase().as_str(), rate) {
        (
            "hz" | "s/s" | "sa/s" | "sps" | "samples/s" | "samples/sec" | "samples/second"
            | "samples per second" | "1/s",
            true,
        ) => 1.0,
        ("khz" | "ks/s" | "ksa/s" | "ksps", true) => 1e3,
        ("s" | "sec" | "secs" | "second" | "seconds", false) => 1.0,
        ("ms" | "msec" | "milliseconds", false) => 1e-3,
        ("us" | "µs" | "μs" | "usec" | "microseconds", false) => 1e-6,
        ("ns", false) => 1e-9,
        ("min" | "minutes", false) => 60.0,
        _ => return None,
    })
}

/// Number stated in a header, with its digits and unit as written.
pub(super) struct StatedNumber<'v> {
    pub number: f64,
    /// Alternative value if the only mark, taken for a thousands separator, is the decimal mark.
    pub alternative: Option<f64>,
    pub digits: &'v str,
    pub unit: &'v str,
}

/// Parses the leading number of a value, its thousands separators by the decimal mark of the file, and its unit; else the reason why not.
pub(super) fn parse_number_with_unit(value: &str, decimal: u8) -> Result<StatedNumber<'_>, String> {
    let (first, others) = match value.find([';', '\t']).or_else(|| value.find(", ")) {
        Some(at) => (value[..at].trim(), value[at + 1..].trim()),
        None => (value.trim(), ""),
    };
    let end = digits_end(first);
    let digits = first[..end].trim_end_matches(['e', 'E', ',', '+', '-']);
    let unreadable = || format!("`{first}` is no number that can be read");
    let (number, alternative) = grouped(digits, decimal).ok_or_else(unreadable)?;
    let rest = first[digits.len()..].trim().trim_end_matches([',', ';']);
    let rest = match rest.split_once(" (").or_else(|| rest.split_once(" [")) {
        Some((unit, _note)) => unit,
        None => rest,
    };
    let mut unit = rest.trim_matches([' ', '[', ']', '(', ')']);
    let next = others.split([',', ';', '\t']).next().unwrap_or("").trim();
    if unit.is_empty() && !next.is_empty() {
        let is_repeated = grouped(next, decimal).is_some_and(|n| n.0 == number);
        if next.starts_with(|c: char| c.is_ascii_digit()) && !is_repeated {
            return Err(format!("`{value}` may be one number or several"));
        }
        let next = next.trim_matches(['[', ']', '(', ')']);
        if unit_factor(next, true).is_some() || channel_names::is_unit(next) {
            unit = next;
        }
    }
    Ok(StatedNumber {
        number,
        alternative,
        digits,
        unit,
    })
}

/// Whether a character is a thousands separator and never a decimal mark.
fn is_separator(c: char) -> bool {
    matches!(c, ' ' | '\u{a0}' | '\u{2009}' | '\u{202f}' | '\'' | '’')
}

/// End of the leading number of a text, bytes; it includes blanks and apostrophes followed by three digits.
fn digits_end(text: &str) -> usize {
    let mut count = 0;
    for (at, c) in text.char_indices() {
        let after = &text[at + c.len_utf8()..];
        let is_group = after.bytes().take_while(u8::is_ascii_digit).count() == 3;
        match c {
            '0'..='9' => count += 1,
            '.' | ',' | '+' | '-' => count = 0,
            'e' | 'E' if after.starts_with(|c: char| c.is_ascii_digit() || "+-".contains(c)) => {}
            c if is_separator(c) && is_group && (1..=3).contains(&count) => count = 0,
            _ => return at,
        }
    }
    text.len()
}

/// Value of digits with optional thousands separators, and the alternative if a single mark before three digits is the decimal mark.
fn grouped(digits: &str, decimal: u8) -> Option<(f64, Option<f64>)> {
    let is_mark = |c: char| is_separator(c) || c == '.' || c == ',';
    let compact: String = digits.chars().filter(|c| !is_separator(*c)).collect();
    let (mantissa, exponent) = match compact.find(['e', 'E']) {
        Some(at) => compact.split_at(at),
        None => (compact.as_str(), ""),
    };
    let marks: Vec<char> = mantissa.chars().filter(|c| is_mark(*c)).collect();
    let read = |point: Option<char>| {
        let is_part = |c: char| !is_mark(c) || Some(c) == point;
        let text: String = mantissa.chars().filter(|c| is_part(*c)).collect();
        let mark = point.map_or(b'.', |p| p as u8);
        cells::number(format!("{text}{exponent}").as_bytes(), mark)
    };
    let in_groups = |text: &str| {
        let text = text.trim_start_matches(['+', '-']);
        let mut parts = text.split(is_mark);
        let first = parts.next().unwrap_or("");
        (1..=3).contains(&first.len()) && !first.starts_with('0') && parts.all(|p| p.len() == 3)
    };
    match marks[..] {
        [] => Some((read(None)?, None)),
        [mark] if mark as u8 == decimal || !in_groups(mantissa) => Some((read(Some(mark))?, None)),
        // Other characters separate the thousands, so the only mark is the decimal one.
        [mark] if compact.len() < digits.len() => Some((read(Some(mark))?, None)),
        [mark] => Some((read(None)?, read(Some(mark)))),
        [first, .., last] => {
            let leading = &marks[..marks.len() - 1];
            let integer = mantissa.rfind(last).map_or(mantissa, |at| &mantissa[..at]);
            match (first == last, leading.iter().all(|c| *c == first)) {
                (true, true) if in_groups(mantissa) => Some((read(None)?, None)),
                (false, true) if in_groups(integer) => Some((read(Some(last))?, None)),
                _ => None,
            }
        }
    }
}
