//! Numbers with units as headers state them: thousands parted or not, a decimal point or comma.

use super::cells;
use crate::recording::channel_names;

/// Hertz in one of a rate's units, or seconds in one of an interval's. Only capitals tell mega from milli.
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

/// A number as a header states it, and the text after it.
pub(super) struct StatedNumber<'v> {
    pub number: f64,
    /// Value if the only mark is the decimal one, where it was taken for that of thousands.
    pub smaller: Option<f64>,
    pub digits: &'v str,
    pub unit: &'v str,
}

/// The number a value starts with, thousands joined by the file's decimal mark, and its unit; what is wrong with it where it is none.
pub(super) fn parse_number_with_unit(value: &str, decimal: u8) -> Result<StatedNumber<'_>, String> {
    let (first, others) = match value.find([';', '\t']).or_else(|| value.find(", ")) {
        Some(at) => (value[..at].trim(), value[at + 1..].trim()),
        None => (value.trim(), ""),
    };
    let end = digits_end(first);
    let digits = first[..end].trim_end_matches(['e', 'E', ',', '+', '-']);
    let unread = || format!("`{first}` is no number that can be read");
    let (number, smaller) = grouped(digits, decimal).ok_or_else(unread)?;
    let rest = first[digits.len()..].trim().trim_end_matches([',', ';']);
    let rest = match rest.split_once(" (").or_else(|| rest.split_once(" [")) {
        Some((unit, _note)) => unit,
        None => rest,
    };
    let mut unit = rest.trim_matches([' ', '[', ']', '(', ')']);
    let next = others.split([',', ';', '\t']).next().unwrap_or("").trim();
    if unit.is_empty() && !next.is_empty() {
        let same = grouped(next, decimal).is_some_and(|n| n.0 == number);
        if next.starts_with(|c: char| c.is_ascii_digit()) && !same {
            return Err(format!("`{value}` may be one number or several"));
        }
        let next = next.trim_matches(['[', ']', '(', ')']);
        if unit_factor(next, true).is_some() || channel_names::is_unit(next) {
            unit = next;
        }
    }
    Ok(StatedNumber {
        number,
        smaller,
        digits,
        unit,
    })
}

/// Signs that part thousands and are never a decimal mark.
fn parts_thousands(c: char) -> bool {
    matches!(c, ' ' | '\u{a0}' | '\u{2009}' | '\u{202f}' | '\'' | '’')
}

/// End of the number at the beginning of a text; blanks and apostrophes belong to it before three digits.
fn digits_end(text: &str) -> usize {
    let mut whole = 0;
    for (at, c) in text.char_indices() {
        let after = &text[at + c.len_utf8()..];
        let three = after.bytes().take_while(u8::is_ascii_digit).count() == 3;
        match c {
            '0'..='9' => whole += 1,
            '.' | ',' | '+' | '-' => whole = 0,
            'e' | 'E' if after.starts_with(|c: char| c.is_ascii_digit() || "+-".contains(c)) => {}
            c if parts_thousands(c) && three && (1..=3).contains(&whole) => whole = 0,
            _ => return at,
        }
    }
    text.len()
}

/// The value of digits whose thousands may be parted, and what it is where a lone mark before three digits is not one of thousands.
fn grouped(digits: &str, decimal: u8) -> Option<(f64, Option<f64>)> {
    let parts = |c: char| parts_thousands(c) || c == '.' || c == ',';
    let joined: String = digits.chars().filter(|c| !parts_thousands(*c)).collect();
    let (mantissa, exponent) = match joined.find(['e', 'E']) {
        Some(at) => joined.split_at(at),
        None => (joined.as_str(), ""),
    };
    let marks: Vec<char> = mantissa.chars().filter(|c| parts(*c)).collect();
    let read = |point: Option<char>| {
        let plain = |c: char| !parts(c) || Some(c) == point;
        let text: String = mantissa.chars().filter(|c| plain(*c)).collect();
        let mark = point.map_or(b'.', |p| p as u8);
        cells::number(format!("{text}{exponent}").as_bytes(), mark)
    };
    let groups = |text: &str| {
        let text = text.trim_start_matches(['+', '-']);
        let mut parts = text.split(parts);
        let first = parts.next().unwrap_or("");
        (1..=3).contains(&first.len()) && !first.starts_with('0') && parts.all(|p| p.len() == 3)
    };
    match marks[..] {
        [] => Some((read(None)?, None)),
        [one] if one as u8 == decimal || !groups(mantissa) => Some((read(Some(one))?, None)),
        // What stands before the last mark is parted by another sign.
        [one] if joined.len() < digits.len() => Some((read(Some(one))?, None)),
        [one] => Some((read(None)?, read(Some(one)))),
        [first, .., last] => {
            let rest = &marks[..marks.len() - 1];
            let whole = mantissa.rfind(last).map_or(mantissa, |at| &mantissa[..at]);
            match (first == last, rest.iter().all(|c| *c == first)) {
                (true, true) if groups(mantissa) => Some((read(None)?, None)),
                (false, true) if groups(whole) => Some((read(Some(last))?, None)),
                _ => None,
            }
        }
    }
}
