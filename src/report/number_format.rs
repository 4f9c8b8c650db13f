//! Number formatting: decimal alignment, significant digits, intervals, CSV cells.

/// Significant digits of a frequency in a table.
const MAX_ROWS: i32 = 6;

/// Texts for a column of non-negative numbers: fixed decimals where their sizes allow, powers of ten where not.
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
    let wide = largest / smallest > 1e9 || largest >= 1e9 || smallest < 1e-6;
    if wide {
        let digits = (MAX_ROWS - 1) as usize;
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
    let decimals = (MAX_ROWS - 1 - smallest.log10().floor() as i32)
        .clamp(0, 10)
        .min(decimals_for(largest)) as usize;
    values.iter().map(|x| format!("{x:.decimals$}")).collect()
}

/// No more than ten digits in all, and at least four decimals for what is not huge.
fn decimals_for(largest: f64) -> i32 {
    let whole = largest.log10().floor() as i32 + 1;
    (10 - whole)
        .clamp(0, 4)
        .max(if largest < 10.0 { MAX_ROWS } else { 0 })
}

fn power(x: f64, digits: usize) -> String {
    let text = format!("{x:.digits$e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    format!("{mantissa}e{exponent}")
}

/// One number with six significant digits, as a power of ten where it is very small or large.
pub fn significant(x: f64) -> String {
    match x.abs() {
        0.0 => "0".to_string(),
        size if (1e-3..1e6).contains(&size) => {
            let decimals = (MAX_ROWS - 1 - size.log10().floor() as i32).max(0) as usize;
            format!("{x:.decimals$}")
        }
        _ => power(x, (MAX_ROWS - 1) as usize),
    }
}

/// Both ends of an interval with two digits of its width, four of themselves at least.
pub fn interval(low: f64, high: f64) -> String {
    /// No width is meant finer than this share of an end.
    const DIGITS: i32 = 9;
    let width = (high - low).abs();
    let size = high.abs().max(low.abs());
    let fine = width > 0.0 && width.is_finite() && (1e-4..1e7).contains(&size);
    if !fine {
        return format!("{} … {}", four_digits(low), four_digits(high));
    }
    let whole = size.log10().floor() as i32;
    let decimals = (1 - width.log10().floor() as i32)
        .max(3 - whole)
        .clamp(0, DIGITS - whole) as usize;
    format!("{low:.decimals$} … {high:.decimals$}")
}

/// One number as short as four significant digits allow: `2000`, `0.03125`, `−1.500e-7`.
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

/// A number with the digits that hold where it may be off by `error`, four at most: the unit of the last is twice the error or more.
/// Absent where none holds.
pub fn significant_text(x: f64, error: f64) -> Option<String> {
    if error == 0.0 {
        return Some(four_digits(x));
    }
    let unit = (2.0 * error).log10().ceil();
    let size = x.abs().log10().floor();
    if unit <= size - 3.0 {
        return Some(four_digits(x));
    }
    // A NaN holds no digit.
    let holds = x.abs() >= 0.5 * 10f64.powf(unit);
    if !holds {
        return None;
    }
    let text = match unit <= 0.0 && size >= -4.0 {
        true => format!("{x:.*}", -unit as usize),
        false => format!("{x:.*e}", (size - unit).max(0.0) as usize),
    };
    Some(text.replace('-', "−").replace("e−", "e-"))
}

/// A text for people with the sign of every negative number as a minus, and none before nothing: `-40/13` becomes `−40/13`, `-0.0` becomes
/// ` 0.0`, as wide as it was. Exponents, ranges and words keep their hyphens.
pub fn with_minus_signs(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut before = ' ';
    let mut rest = text.chars().peekable();
    let mut at = 0;
    while let Some(c) = rest.next() {
        let opens = before.is_whitespace() || matches!(before, '(' | '[' | '±' | '…');
        let is_sign = c == '-' && opens && rest.peek().is_some_and(char::is_ascii_digit);
        if is_sign {
            let number = text[at + 1..].split(|d: char| !(d.is_ascii_digit() || d == '.'));
            let digits = number.into_iter().next().unwrap_or("");
            let next = text[at + 1 + digits.len()..].chars().next();
            let ends =
                next.is_none_or(|n| n.is_whitespace() || matches!(n, ',' | ';' | ')' | ']' | '%'));
            let nothing = ends && digits.chars().all(|d| matches!(d, '0' | '.'));
            out.push(if nothing { ' ' } else { '−' });
        } else {
            out.push(c);
        }
        before = c;
        at += c.len_utf8();
    }
    out
}

/// rpm of rad/s.
pub fn rpm(speed: f64) -> f64 {
    speed * 30.0 / std::f64::consts::PI
}

/// A unit in which the largest value is easily read.
pub fn choose_unit(largest: f64, unit: &'static str) -> (f64, String) {
    let (factor, prefix) = match (largest, unit) {
        (x, "m" | "rad") if x < 1e-3 => (1e6, "µ"),
        (x, "m" | "rad") if x < 1.0 => (1e3, "m"),
        (x, "N" | "N·m") if x >= 1e4 => (1e-3, "k"),
        _ => (1.0, ""),
    };
    (factor, format!("{prefix}{unit}"))
}

/// The label of an axis in SI, alone or behind a comma, in the unit of its largest value; and the factor of the values.
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
    let gap = if name.is_empty() { "" } else { ", " };
    (factor, format!("{name}{gap}{unit}"))
}

/// Footnote of a table of measured values: ± is [`Z_95`](crate::numeric::statistics::Z_95) standard deviations.
pub const INTERVAL_FOOTNOTE: &str = "± the 95 % interval, 1.96 standard deviations\n";

/// A value with how far it may be off, to two digits of that: `26.602 ± 0.014`.
pub fn with_deviation(value: f64, deviation: f64) -> String {
    if !(deviation > 0.0 && deviation.is_finite() && value.is_finite()) {
        return significant(value);
    }
    let decimals = (1.0 - deviation.log10().floor()).clamp(0.0, 12.0) as usize;
    format!("{value:.decimals$} ± {deviation:.decimals$}")
}

/// A share or a ratio as per cent with a sensible number of digits.
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
        for (x, error, shown) in [
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
            assert_eq!(text.as_deref().unwrap_or("–"), shown, "{x} {error}");
        }
    }

    #[test]
    fn exact_labels_in_the_unit_of_their_size() {
        for (label, largest, factor, shown) in [
            ("rad", 0.012, 1e3, "mrad"),
            ("displacement, m", 6e-5, 1e6, "displacement, µm"),
            ("force, N", 2.5e5, 1e-3, "force, kN"),
            ("force, N", 2.5e3, 1.0, "force, N"),
            ("amplitude, m/N", 1e-9, 1.0, "amplitude, m/N"),
            ("time, s", 1e-5, 1.0, "time, s"),
            ("rad", 0.0, 1.0, "rad"),
        ] {
            assert_eq!(scaled_label(label, largest), (factor, shown.to_string()));
        }
    }

    #[test]
    fn exact_minus_signs() {
        for (text, shown) in [
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
            assert_eq!(with_minus_signs(text), shown);
        }
        assert_eq!([-0.0, f64::NEG_INFINITY].map(four_digits), ["0", "−inf"]);
    }
}
