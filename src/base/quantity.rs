//! Parses quantities with units to SI; formats times and numbers for messages.

use std::f64::consts::TAU;

use super::code::Code;
use super::error::Error;
use super::quantity_kind::{Dimension, QuantityKind};
use super::unit_expression::UnitParser;

/// Parses a quantity with unit to SI; frequencies and speeds in rad/s, angles in rad.
///
/// `subject` is the key or the flag of the quantity, as messages name it: "`k`", "`--speed`".
pub fn parse(text: &str, kind: QuantityKind, subject: &str) -> Result<f64, Error> {
    let (value, unit) = number(text, subject)?;
    if unit.is_empty() {
        return Err(missing_unit(value.text, kind, subject));
    }
    in_notation(text, (value.value, unit), kind, subject)
}

/// Parses a quantity to SI; a number without unit is in `default_unit`.
pub fn parse_or_bare(
    text: &str,
    kind: QuantityKind,
    default_unit: &str,
    subject: &str,
) -> Result<f64, Error> {
    let (value, unit) = number(text, subject)?;
    let unit = if unit.is_empty() { default_unit } else { unit };
    in_notation(text, (value.value, unit), kind, subject)
}

/// Converts a quantity to SI: degrees with minutes, else a number with unit.
fn in_notation(
    text: &str,
    (value, unit): (f64, &str),
    kind: QuantityKind,
    subject: &str,
) -> Result<f64, Error> {
    match degrees_and_minutes(text, kind) {
        Some(angle) => angle,
        None => in_unit(value, unit, kind, subject),
    }
}

/// Parses an angle in degrees, minutes and seconds, `18°02′44″` as in machine-settings sheets, to rad; `None` for another form.
fn degrees_and_minutes(text: &str, kind: QuantityKind) -> Option<Result<f64, Error>> {
    let (degrees, remainder) = text.trim().split_once('°')?;
    let has_minutes = remainder
        .trim()
        .starts_with(|c: char| c.is_ascii_digit() || c == '-');
    if kind != QuantityKind::Angle || !has_minutes {
        return None;
    }
    let parsed = || {
        let (sign, degrees) = match degrees.strip_prefix(['-', '−']) {
            Some(size) => (-1.0, size),
            None => (1.0, degrees),
        };
        let sixtieths = |text: &str| {
            let text = text.trim();
            let is_number = text.starts_with(|c: char| c.is_ascii_digit());
            let value = text.parse::<f64>().ok().filter(|_| is_number);
            value.filter(|value| (0.0..60.0).contains(value))
        };
        let (minutes, remainder) = remainder.split_once(['′', '\''])?;
        let seconds = match remainder.trim().strip_suffix(['″', '"']) {
            Some(_) if minutes.contains('.') => return None,
            Some(seconds) => sixtieths(seconds)?,
            None => remainder.trim().is_empty().then_some(0.0)?,
        };
        let n_degrees = f64::from(degrees.trim().parse::<u32>().ok()?);
        Some(sign * (n_degrees + (sixtieths(minutes)? + seconds / 60.0) / 60.0).to_radians())
    };
    Some(parsed().ok_or_else(|| {
        let message = format!(
            "\"{}\" is not an angle in degrees, minutes and seconds",
            truncate(text)
        );
        let hint = "write whole degrees, then minutes and seconds below 60: \"18°02′44″\"";
        Error::new(Code::OutOfRange, message).with_hint(hint)
    }))
}

/// Parses a range `A:B` with 0 ≤ A < B to SI; units default as on the command line. `name` and `example` describe the range in messages.
///
/// # Errors
/// `OutOfRange` for a text that is not such a range.
pub fn parse_range(
    text: &str,
    kind: QuantityKind,
    (name, example): (&str, &str),
    subject: &str,
) -> Result<(f64, f64), Error> {
    let invalid = || {
        let message = format!("\"{}\" is not {name}", truncate(text));
        let hint = format!("{subject} takes first:last, the smaller first, such as {example}");
        Error::new(Code::OutOfRange, message).with_hint(hint)
    };
    let (low, high) = text.split_once(':').ok_or_else(invalid)?;
    let value = |text: &str| parse_or_bare(text, kind, kind.bare_unit(), subject);
    let (low, high) = (value(low)?, value(high)?);
    match low >= 0.0 && low < high && high.is_finite() {
        true => Ok((low, high)),
        false => Err(invalid()),
    }
}

/// Converts rad/s to Hz, rounded to fifteen digits: 700, not 699.999 999 999 999 9.
pub fn to_hertz(omega: f64) -> f64 {
    let hertz = omega / TAU;
    format!("{hertz:.14e}").parse().unwrap_or(hertz)
}

/// Factor to SI and dimension of a unit expression; `None` for an unknown unit.
pub fn parse_unit(unit: &str) -> Option<(f64, Dimension)> {
    UnitParser::parse(unit).ok()
}

/// Formats a time with three digits in s, ms, µs or ns: `2.35 ms`.
pub fn format_time(time_s: f64) -> String {
    let (factor, unit) = match time_s.abs() {
        t if t >= 1e6 => return format!("{time_s:.1e} s"),
        t if t >= 1.0 || t == 0.0 => (1.0, "s"),
        t if t >= 1e-3 => (1e3, "ms"),
        t if t >= 1e-6 => (1e6, "µs"),
        _ => (1e9, "ns"),
    };
    let scaled = time_s * factor;
    let digits = 2usize.saturating_sub(scaled.abs().max(1.0).log10() as usize);
    format!("{scaled:.digits$} {unit}")
}

/// Formats an instant in s with six digits.
pub fn format_instant(time_s: f64) -> String {
    format!("{} s", format_number(time_s))
}

/// Formats a number with six digits, in scientific notation if very small or large: `66.9221`, `1e300`.
pub fn format_number(x: f64) -> String {
    let rounded: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    match rounded.abs() {
        size if size == 0.0 || (1e-4..1e6).contains(&size) => format!("{rounded}"),
        _ => format!("{rounded:e}"),
    }
}

/// Formats a duration in its customary unit, from ns to years.
pub fn format_duration(time_s: f64) -> String {
    const MINUTE: f64 = 60.0;
    const HOUR: f64 = 60.0 * MINUTE;
    const DAY: f64 = 24.0 * HOUR;
    const YEAR: f64 = 365.25 * DAY;
    let rounded = |size: f64, unit: &str| match size {
        size if size < 10.0 => format!("{size:.1} {unit}"),
        size => format!("{size:.0} {unit}"),
    };
    match time_s {
        t if t < 2.0 * MINUTE => format_time(t),
        t if t < 2.0 * HOUR => rounded(t / MINUTE, "min"),
        t if t < 2.0 * DAY => rounded(t / HOUR, "h"),
        t if t < 2.0 * YEAR => rounded(t / DAY, "days"),
        t if t < 1e5 * YEAR => rounded(t / YEAR, "years"),
        t if t.is_finite() => format!("{:.0e} years", t / YEAR),
        _ => "for ever".to_string(),
    }
}

/// Time limit for an estimated run time, as the value of a flag: 10 % more, rounded up to hours.
pub fn suggested_time_limit(time_s: f64) -> String {
    const HOUR: f64 = 3600.0;
    match (1.1 * time_s / HOUR).ceil() {
        hours if hours < 1e5 => format!("{hours}h"),
        hours => format!("{hours:.0e}h"),
    }
}

/// Quotient of two units.
pub fn quotient_unit(output: &str, input: &str) -> String {
    match (output == input, input.contains(['·', '/'])) {
        (true, _) => "1".to_string(),
        (false, true) => format!("{output}/({input})"),
        (false, false) => format!("{output}/{input}"),
    }
}

/// Converts a number in the SI unit of `kind`; frequencies from Hz to rad/s.
pub fn value_in_si(value: f64, kind: QuantityKind) -> f64 {
    match kind {
        QuantityKind::Frequency => TAU * value,
        _ => value,
    }
}

/// Error for a quantity without unit.
pub fn missing_unit(number: &str, kind: QuantityKind, subject: &str) -> Error {
    let unit = kind.bare_unit();
    Error::new(Code::MissingUnit, format!("{subject} has no unit")).with_hint(format!(
        "{subject} takes {}: write \"{number} {unit}\" if {unit} is meant",
        kind.units()
    ))
}

/// Maximum length of the text of a quantity, bytes.
const MAX_LEN: usize = 200;

/// Truncates a text for messages.
pub fn truncate(text: &str) -> String {
    truncate_to(text, 40)
}

/// Truncates a text to `length` characters.
pub fn truncate_to(text: &str, length: usize) -> String {
    match text.char_indices().nth(length) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}

struct NumberText<'a> {
    value: f64,
    text: &'a str,
}

/// Splits a text into its number and its unit.
fn number<'a>(text: &'a str, subject: &str) -> Result<(NumberText<'a>, &'a str), Error> {
    let text = text.trim();
    let refuse = |why: &str, hint: &str| {
        Err(
            Error::new(Code::OutOfRange, format!("\"{}\" {why}", truncate(text)))
                .with_hint(format!("{subject} takes {hint}")),
        )
    };
    const FORM: &str = "a number, a space and a unit, such as \"85 kN/mm\"";
    if text.len() > MAX_LEN {
        return refuse("is too long for a quantity", FORM);
    }
    let letters: String = text
        .trim_start_matches(['+', '-'])
        .chars()
        .take_while(|c| c.is_alphabetic())
        .collect();
    if ["nan", "inf", "infinity"].contains(&letters.to_lowercase().as_str()) {
        return refuse("is not a finite number", "finite numbers only");
    }
    let length = number_length(text);
    let digits: String = text[..length]
        .chars()
        .filter(|c| !is_gap(*c))
        .map(|c| if c == '−' { '-' } else { c })
        .collect();
    let unit = text[length..].trim();
    if unit.starts_with(',') {
        return refuse("has a decimal comma", "a decimal point: write 0.5, not 0,5");
    }
    match digits.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok((
            NumberText {
                value,
                text: &text[..length],
            },
            unit,
        )),
        Ok(_) => refuse(
            "exceeds the largest double-precision number, 1.8e308",
            "finite numbers only",
        ),
        Err(_) => refuse("does not start with a number", FORM),
    }
}

/// True for a space that may group digits by three.
fn is_gap(c: char) -> bool {
    matches!(c, ' ' | '\u{a0}' | '\u{2009}' | '\u{202f}')
}

/// Length of the number at the start of a text, bytes: sign, digits, point and exponent.
fn number_length(text: &str) -> usize {
    let mut length = ['+', '-', '−']
        .iter()
        .find(|sign| text.starts_with(**sign))
        .map_or(0, |sign| sign.len_utf8());
    length += digits_length(&text[length..], true);
    if text[length..].starts_with('.') {
        length += 1;
        length += digits_length(&text[length..], false);
    }
    let Some(exponent) = text[length..].strip_prefix(['e', 'E']) else {
        return length;
    };
    let sign = usize::from(exponent.starts_with(['+', '-']));
    match digits_length(&exponent[sign..], false) {
        0 => length,
        digits => length + 1 + sign + digits,
    }
}

/// Length of the digits at the start of a text, bytes, with spaces before groups of three if `grouped`.
fn digits_length(text: &str, grouped: bool) -> usize {
    let run = |s: &str| s.bytes().take_while(u8::is_ascii_digit).count();
    let mut length = run(text);
    while grouped && length > 0 {
        let mut rest = text[length..].chars();
        match rest.next() {
            Some(gap) if is_gap(gap) && run(rest.as_str()) == 3 => length += gap.len_utf8() + 3,
            _ => break,
        }
    }
    length
}

fn in_unit(value: f64, unit: &str, kind: QuantityKind, subject: &str) -> Result<f64, Error> {
    let takes = format!("{subject} takes {}", kind.units());
    let notation = match kind {
        QuantityKind::Angle => ", or degrees with minutes and seconds, 18°02′44″",
        _ => "",
    };
    let (factor, dimension) = UnitParser::parse(unit).map_err(|unknown| {
        let suggested =
            suggest_unit(&unknown, kind).map_or(String::new(), |u| format!("did you mean {u}? "));
        Error::new(
            Code::WrongUnit,
            format!("\"{}\" is not a known unit", truncate(&unknown)),
        )
        .with_hint(format!("{suggested}{takes}{notation}"))
    })?;
    if !kind.accepts(dimension) {
        let actual = QuantityKind::from_dimension(dimension)
            .or_else(|| {
                QuantityKind::ALL
                    .iter()
                    .copied()
                    .find(|k| k.accepts(dimension))
            })
            .map_or_else(
                || format!("does not measure {}", article(kind.name())),
                |measured| format!("measures {}", article(measured.name())),
            );
        let is_rotation = matches!(kind, QuantityKind::Speed | QuantityKind::Frequency)
            && dimension == QuantityKind::PerSecond.dimension();
        let hint = if is_rotation {
            format!("{takes}; turns a minute are rpm, turns a second are Hz")
        } else {
            takes
        };
        return Err(Error::new(Code::WrongUnit, format!("{unit} {actual}")).with_hint(hint));
    }
    let si = value * factor;
    if !si.is_finite() || (si == 0.0 && value != 0.0) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("{value:e} {unit} is out of the range of numbers, 1e-308 to 1.8e308 in SI"),
        )
        .with_hint(takes));
    }
    Ok(si)
}

fn article(noun: &str) -> String {
    match noun {
        "mass"
        | "density"
        | "damping"
        | "torsional stiffness"
        | "torsional damping"
        | "translational stiffness"
        | "translational damping"
        | "time" => noun.to_string(),
        _ if noun.starts_with(['a', 'e', 'i', 'o', 'u']) => format!("an {noun}"),
        _ => format!("a {noun}"),
    }
}

/// Suggested unit of `kind` for a misspelt word.
fn suggest_unit(word: &str, kind: QuantityKind) -> Option<String> {
    let folded = word.to_lowercase();
    let matches = |known: &str| known.to_lowercase() == folded;
    let known: Vec<&str> = kind.units().split(", ").collect();
    known
        .iter()
        .copied()
        .chain(["rpm", "Hz", "kg", "mm", "N", "kN", "MPa", "deg", "rad"])
        .find(|name| matches(name))
        .or_else(|| {
            known
                .iter()
                .copied()
                .find(|name| strsim::damerau_levenshtein(name, word) <= 1)
        })
        .map(str::to_string)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn si(text: &str, kind: QuantityKind) -> f64 {
        parse(text, kind, "`k`").unwrap_or_else(|e| panic!("{text}: {e}"))
    }

    fn close(text: &str, kind: QuantityKind, expected: f64) {
        let value = si(text, kind);
        let error = (value - expected).abs();
        assert!(
            error <= 4.0 * f64::EPSILON * expected.abs(),
            "{text}: {value}"
        );
    }

    #[test]
    fn exact_units_of_every_shape() {
        close("85 kN/mm", QuantityKind::Stiffness, 85e6);
        close("1.2 kN·m/rad", QuantityKind::TorsionalStiffness, 1200.0);
        close("1200 N·m", QuantityKind::TorsionalStiffness, 1200.0);
        close("1 N m / deg", QuantityKind::TorsionalStiffness, 180.0 / PI);
        close("1 450 rpm", QuantityKind::Speed, 1450.0 * TAU / 60.0);
        close("1450rpm", QuantityKind::Speed, 1450.0 * TAU / 60.0);
        close("25 rev/s", QuantityKind::Speed, 25.0 * TAU);
        close("3 Hz", QuantityKind::Frequency, 3.0 * TAU);
        close("20 deg", QuantityKind::Angle, PI / 9.0);
        close("20°", QuantityKind::Angle, PI / 9.0);
        close("18°30′", QuantityKind::Angle, 18.5 * PI / 180.0);
        let bare = parse_or_bare("18°30′", QuantityKind::Angle, "rad", "`k`");
        assert_eq!(bare.ok(), parse("18.5°", QuantityKind::Angle, "`k`").ok());
        close("-0°01′30″", QuantityKind::Angle, -0.025 * PI / 180.0);
        close(
            "18° 02' 44.4\"",
            QuantityKind::Angle,
            64_964.4 * PI / 648_000.0,
        );
        for wrong in ["18°72′", "18°2", "18°2.5′4″", "18.5°30′", "1°-2′", "1°2′3"]
        {
            assert!(parse(wrong, QuantityKind::Angle, "`k`").is_err(), "{wrong}");
        }
        close("3″", QuantityKind::Angle, 3.0 * PI / 648_000.0);
        for text in ["0.0095 kg·m²", "0.0095 kg m2", "0.0095 kg*m^2", "95 kg·cm²"] {
            close(text, QuantityKind::Inertia, 0.0095);
        }
        for text in ["420 N/µm", "420 N/μm", "420 N/um", "4.2e2 MN/m"] {
            close(text, QuantityKind::Stiffness, 420e6);
        }
        close("-5 1/s", QuantityKind::PerSecond, -5.0);
        close("5 s⁻¹", QuantityKind::PerSecond, 5.0);
        close("5 s^-1", QuantityKind::PerSecond, 5.0);
        close("3 min", QuantityKind::Time, 180.0);
        close("2 in", QuantityKind::Length, 0.0508);
        close("7.85 g/cm³", QuantityKind::Density, 7850.0);
        close("1 N·m·s/rad", QuantityKind::TorsionalDamping, 1.0);
        close("1 N·m/(rad/s)", QuantityKind::TorsionalDamping, 1.0);
        close("3 N/(m/s)", QuantityKind::Damping, 3.0);
        close("80 GPa", QuantityKind::Pressure, 80e9);
        close("5 Nm", QuantityKind::Torque, 5.0);
        close(
            "1 lbf·ft",
            QuantityKind::Torque,
            0.453_592_37 * 9.80665 * 0.3048,
        );
    }

    #[test]
    fn exact_instants_have_six_digits() {
        for (time, words) in [
            (0.0, "0 s"),
            (2.0, "2 s"),
            (0.012_345_678, "0.0123457 s"),
            (123_456.78, "123457 s"),
            (1.5e-9, "1.5e-9 s"),
        ] {
            assert_eq!(format_instant(time), words);
        }
        assert_eq!(suggested_time_limit(100_000.0), "31h");
        assert_eq!([66.922_099, 1e300].map(format_number), ["66.9221", "1e300"]);
    }

    #[test]
    fn exact_bare_numbers_take_the_default_unit() {
        let speed = parse_or_bare("60", QuantityKind::Speed, "rpm", "`--speed`");
        assert!((speed.unwrap() - TAU).abs() < 1e-15);
    }

    #[test]
    fn refuses_what_is_not_a_quantity() {
        let cases = [
            ("5", QuantityKind::Inertia, Code::MissingUnit, "kg·m²"),
            (
                "5 N/m",
                QuantityKind::TorsionalStiffness,
                Code::WrongUnit,
                "N·m/rad",
            ),
            ("5 1/min", QuantityKind::Speed, Code::WrongUnit, "rpm"),
            (
                "5 RPM",
                QuantityKind::Speed,
                Code::WrongUnit,
                "did you mean rpm?",
            ),
            (
                "5 kg·furlong",
                QuantityKind::Inertia,
                Code::WrongUnit,
                "kg·m²",
            ),
            ("5 m/", QuantityKind::Length, Code::WrongUnit, "mm"),
            ("5 (m", QuantityKind::Length, Code::WrongUnit, "mm"),
            ("5 m^99", QuantityKind::Length, Code::WrongUnit, "mm"),
            (
                "0,5 mm",
                QuantityKind::Length,
                Code::OutOfRange,
                "decimal point",
            ),
            ("nan mm", QuantityKind::Length, Code::OutOfRange, "finite"),
            ("-inf mm", QuantityKind::Length, Code::OutOfRange, "finite"),
            ("1e400 mm", QuantityKind::Length, Code::OutOfRange, "finite"),
            ("1e306 km", QuantityKind::Length, Code::OutOfRange, "takes"),
            ("mm", QuantityKind::Length, Code::OutOfRange, "number"),
            ("", QuantityKind::Length, Code::OutOfRange, "number"),
            ("e5 m", QuantityKind::Length, Code::OutOfRange, "number"),
        ];
        for (text, kind, code, hint) in cases {
            let error = parse(text, kind, "`k`").unwrap_err();
            assert_eq!(error.code, code, "{text}: {error}");
            assert!(
                error.hint.clone().unwrap_or_default().contains(hint),
                "{text}: {error}"
            );
        }
        let error = parse("5 N/m", QuantityKind::TorsionalStiffness, "`k`").unwrap_err();
        assert_eq!(error.message, "N/m measures translational stiffness");
    }

    #[test]
    fn survives_long_and_odd_texts() {
        let long = "(".repeat(1_000_000);
        assert!(parse(&format!("1 {long}"), QuantityKind::Mass, "`m`").is_err());
        for text in [
            "1 ²",
            "1 /",
            "1 ·",
            "1 )",
            "1 (((",
            "− kg",
            "1 kg^^2",
            "1 kg^-",
            "1\u{0} kg",
            "1 🦀",
        ] {
            assert!(parse(text, QuantityKind::Mass, "`m`").is_err(), "{text}");
        }
    }
}
