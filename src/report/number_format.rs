//! Number formatting: decimal alignment, significant digits, intervals, CSV cells.

/// Significant digits of a number in a table.
const DIGITS: i32 = 6;

/// Formats a column of non-negative numbers with fixed decimals, or as powers of ten if they differ too much in size.
pub fn column(values: &[f64]) -> Vec<String> {
    let sizes = || {
        values
            .iter()
            .map(|x| x.abs())
            .filter(|&x| x > 0.0 && x.is_finite())
    };
    let (smallest, largest) = sizes().fold((f64::INFINITY, 0.0f64), |(lo, hi), x| {
        (lo.min(x), hi.max(x))
    });
    if largest == 0.0 {
        return values.iter().map(|x| format!("{x:.4}")).collect();
    }
    let as_power = largest / smallest > 1e9 || largest >= 1e9 || smallest < 1e-6;
    if as_power {
        let digits = (DIGITS - 1) as usize;
        return values
            .iter()
            .map(|&x| {
                if x == 0.0 {
                    "0".to_string()
                } else {
                    power(x, digits)
                }
            })
            .collect();
    }
    let decimals = (DIGITS - 1 - smallest.log10().floor() as i32)
        .clamp(0, 10)
        .min(decimals_for(largest)) as usize;
    values.iter().map(|x| format!("{x:.decimals$}")).collect()
}

/// Largest number of decimals of a column: four within ten digits in total, six below 10.
fn decimals_for(largest: f64) -> i32 {
    let integer_digits = largest.log10().floor() as i32 + 1;
    (10 - integer_digits)
        .clamp(0, 4)
        .max(if largest < 10.0 { DIGITS } else { 0 })
}

fn power(x: f64, digits: usize) -> String {
    let text = format!("{x:.digits$e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    format!("{mantissa}e{exponent}")
}

/// Formats a number with six significant digits, as a power of ten below 1e-3 and from 1e6.
pub fn significant(x: f64) -> String {
    match x.abs() {
        0.0 => "0".to_string(),
        size if (1e-3..1e6).contains(&size) => {
            let decimals = (DIGITS - 1 - size.log10().floor() as i32).max(0) as usize;
            format!("{x:.decimals$}")
        }
        _ => power(x, (DIGITS - 1) as usize),
    }
}

/// Formats an interval with two significant digits of its width and at least four of its ends.
pub fn interval(low: f64, high: f64) -> String {
    /// Largest number of digits after the leading digit of an end.
    const MAX_DIGITS: i32 = 9;
    let width = (high - low).abs();
    let size = high.abs().max(low.abs());
    let is_regular = width > 0.0 && width.is_finite() && (1e-4..1e7).contains(&size);
    if !is_regular {
        return format!("{} … {}", four_digits(low), four_digits(high));
    }
    let exponent = size.log10().floor() as i32;
    let decimals = (1 - width.log10().floor() as i32)
        .max(3 - exponent)
        .clamp(0, MAX_DIGITS - exponent) as usize;
    format!("{low:.decimals$} … {high:.decimals$}")
}

/// Formats a number with four significant digits without trailing zeros: `2000`, `0.03125`, `−1.500e-7`.
pub fn four_digits(x: f64) -> String {
    if x == 0.0 {
        return "0".to_string();
    }
    if !x.is_finite() {
        return format!("{x}").replace('-', "−");
    }
    let size = x.abs().log10().floor();
    let text = match (-4.0..7.0).contains(&size) {
        true => {
            let text = format!("{x:.*}", (3.0 - size).max(0.0) as usize);
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
                false => text,
            }
        }
        false => format!("{x:.3e}"),
    };
    text.replace('-', "−").replace("e−", "e-")
}

/// Formats a number with its significant digits, four at most: the unit of the last digit is at least twice `error`. `None` if no digit
/// is significant.
pub fn significant_text(x: f64, error: f64) -> Option<String> {
    if error == 0.0 {
        return Some(four_digits(x));
    }
    let unit = (2.0 * error).log10().ceil();
    let size = x.abs().log10().floor();
    if unit <= size - 3.0 {
        return Some(four_digits(x));
    }
    // A NaN has no significant digit.
    let has_digit = x.abs() >= 0.5 * 10f64.powf(unit);
    if !has_digit {
        return None;
    }
    let text = match unit <= 0.0 && size >= -4.0 {
        true => format!("{x:.*}", -unit as usize),
        false => format!("{x:.*e}", (size - unit).max(0.0) as usize),
    };
    Some(text.replace('-', "−").replace("e−", "e-"))
}

/// Replaces the hyphen of negative numbers by a minus sign, and that of a zero by a blank: `-40/13` becomes `−40/13`, `-0.0` becomes
/// ` 0.0`. Exponents, ranges and words keep their hyphens.
pub fn with_minus_signs(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut previous = ' ';
    let mut chars = text.chars().peekable();
    let mut position = 0;
    while let Some(c) = chars.next() {
        let starts_number = previous.is_whitespace() || matches!(previous, '(' | '[' | '±' | '…');
        let is_sign = c == '-' && starts_number && chars.peek().is_some_and(char::is_ascii_digit);
        if is_sign {
            let number = text[position + 1..].split(|d: char| !(d.is_ascii_digit() || d == '.'));
            let digits = number.into_iter().next().unwrap_or("");
            let next = text[position + 1 + digits.len()..].chars().next();
            let is_complete =
                next.is_none_or(|n| n.is_whitespace() || matches!(n, ',' | ';' | ')' | ']' | '%'));
            let is_zero = is_complete && digits.chars().all(|d| matches!(d, '0' | '.'));
            out.push(if is_zero { ' ' } else { '−' });
        } else {
            out.push(c);
        }
        previous = c;
        position += c.len_utf8();
    }
    out
}

/// Converts rad/s to rpm.
pub fn rpm(speed: f64) -> f64 {
    speed * 30.0 / std::f64::consts::PI
}

/// Prefixed unit suited to the largest value, with the factor from the base unit.
pub fn choose_unit(largest: f64, unit: &'static str) -> (f64, String) {
    let (factor, prefix) = match (largest, unit) {
        (x, "m" | "rad") if x < 1e-3 => (1e6, "µ"),
        (x, "m" | "rad") if x < 1.0 => (1e3, "m"),
        (x, "N" | "N·m") if x >= 1e4 => (1e-3, "k"),
        _ => (1.0, ""),
    };
    (factor, format!("{prefix}{unit}"))
}

/// Scales an SI axis label (`unit` or `name, unit`) to the unit of its largest value; returns the factor of the values and the label.
pub fn scaled_label(label: &str, largest: f64) -> (f64, String) {
    const SCALED: [&str; 4] = ["m", "rad", "N", "N·m"];
    let (name, unit) = label.rsplit_once(", ").unwrap_or(("", label));
    let Some(unit) = SCALED.into_iter().find(|u| *u == unit) else {
        return (1.0, label.to_string());
    };
    if largest == 0.0 || !largest.is_finite() {
        return (1.0, label.to_string());
    }
    let (factor, unit) = choose_unit(largest, unit);
    let separator = if name.is_empty() { "" } else { ", " };
    (factor, format!("{name}{separator}{unit}"))
}

/// Footnote of a table of measured values: ± is [`Z_95`](crate::numeric::statistics::Z_95) standard deviations.
pub const INTERVAL_FOOTNOTE: &str = "± the 95 % interval, 1.96 standard deviations\n";

/// Formats a value with its deviation to two digits of the deviation: `26.602 ± 0.014`.
pub fn with_deviation(value: f64, deviation: f64) -> String {
    if !(deviation > 0.0 && deviation.is_finite() && value.is_finite()) {
        return significant(value);
    }
    let decimals = (1.0 - deviation.log10().floor()).clamp(0.0, 12.0) as usize;
    format!("{value:.decimals$} ± {deviation:.decimals$}")
}

/// Formats a ratio in per cent: one decimal from 10 %, two from 0.01 %, else two digits as a power of ten.
pub fn percent(x: f64) -> String {
    let value = 100.0 * x;
    match value.abs() {
        size if size < 1e-6 => "0".to_string(),
        size if size >= 10.0 => format!("{value:.1}"),
        size if size >= 0.01 => format!("{value:.2}"),
        _ => format!("{value:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_columns() {
        assert_eq!(
            column(&[0.0, 16.431942, 5774.03927]),
            ["0.0000", "16.4319", "5774.0393"]
        );
        assert_eq!(
            column(&[0.0, 0.00050331, 5.0329e9]),
            ["0", "5.03310e-4", "5.03290e9"]
        );
        assert_eq!(column(&[0.0]), ["0.0000"]);
        assert_eq!(
            [2000.1, 0.031254, -1.5e-7, -12.0].map(four_digits),
            ["2000", "0.03125", "−1.500e-7", "−12"]
        );
        assert_eq!(
            column(&[0.61803398875, 1.61803398875]),
            ["0.618034", "1.618034"]
        );
    }

    #[test]
    fn exact_digits_that_hold() {
        for (x, error, expected) in [
            (5897.3, 0.0, "5897"),
            (5897.3, 0.3, "5897"),
            (5897.3, 4.0, "5.90e3"),
            (-5897.3, 400.0, "−6e3"),
            (0.028, 0.2, "–"),
            (0.028, f64::INFINITY, "–"),
            (12.3456, 0.04, "12.3"),
            (12.3456, 0.4, "12"),
            (3.4567e-7, 1e-9, "3.5e-7"),
        ] {
            let text = significant_text(x, error);
            assert_eq!(text.as_deref().unwrap_or("–"), expected, "{x} {error}");
        }
    }

    #[test]
    fn exact_labels_in_the_unit_of_their_size() {
        for (label, largest, factor, expected) in [
            ("rad", 0.012, 1e3, "mrad"),
            ("displacement, m", 6e-5, 1e6, "displacement, µm"),
            ("force, N", 2.5e5, 1e-3, "force, kN"),
            ("force, N", 2.5e3, 1.0, "force, N"),
            ("amplitude, m/N", 1e-9, 1.0, "amplitude, m/N"),
            ("time, s", 1e-5, 1.0, "time, s"),
            ("rad", 0.0, 1.0, "rad"),
        ] {
            assert_eq!(scaled_label(label, largest), (factor, expected.to_string()));
        }
    }

    #[test]
    fn exact_minus_signs() {
        for (text, expected) in [
            ("a -40/13 b", "a −40/13 b"),
            ("  -0.00  -0  0", "   0.00   0  0"),
            ("(-3.5, -0.05)", "(−3.5, −0.05)"),
            (
                "-1.5e-7 teeth 30-37 --lines -x",
                "−1.5e-7 teeth 30-37 --lines -x",
            ),
            ("-0.0001e-3 ± -2", "−0.0001e-3 ± −2"),
            ("", ""),
            ("−-5 µ-6", "−-5 µ-6"),
        ] {
            assert_eq!(with_minus_signs(text), expected);
        }
        assert_eq!([-0.0, f64::NEG_INFINITY].map(four_digits), ["0", "−inf"]);
    }
}
