//! Parser of decimal numbers, correctly rounded to double precision.
//!
//! A number `± m · 10ᵉ` with `m < 2⁵³` and `|e| ≤ 22` takes one multiplication or division of two exact doubles, which rounds once
//! (Clinger 1990, “How to read floating point numbers accurately”, section 3); all others go to fast_float2.

/// Maximum length of a number with a decimal comma, bytes.
const MAX_LEN: usize = 64;

/// Maximum number of digits that always fit a `u64`.
const MAX_DIGITS: usize = 19;

/// Upper limit of the integers that doubles represent exactly.
const EXACT_INTEGERS: u64 = 1 << f64::MANTISSA_DIGITS;

/// Powers of ten that doubles represent exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// `10ⁿ`, from a table for `|n| ≤ 22`.
pub fn power_of_ten(n: i32) -> f64 {
    match POWERS.get(n.unsigned_abs() as usize) {
        Some(power) if n >= 0 => *power,
        Some(power) => power.recip(),
        None => 10_f64.powi(n),
    }
}

/// A number as written: `± digits · 10^exponent`.
#[derive(Debug, Clone, Copy)]
pub struct Decimal {
    is_negative: bool,
    digits: u64,
    exponent: i32,
    has_exponent: bool,
}

impl Decimal {
    /// Scans a number at the start of a text: the number and its length, bytes; `None` without a number or above 19 digits.
    #[inline(always)]
    pub fn scan(text: &[u8], mark: u8) -> Option<(Decimal, usize)> {
        let first = *text.first()?;
        let is_negative = first == b'-';
        let sign = usize::from(is_negative | (first == b'+'));
        let body = &text[sign..];
        let short = body
            .first_chunk()
            .and_then(|front| short_mantissa(*front, mark));
        let (digits, n_decimals, length) = match short {
            Some(mantissa) => mantissa,
            None => long_mantissa(body, mark)?,
        };
        let mut end = sign + length;
        let mut decimal = Decimal {
            is_negative,
            digits,
            exponent: -(n_decimals as i32),
            has_exponent: false,
        };
        if let Some(b'e' | b'E') = text.get(end)
            && let Some((power, length)) = exponent(&text[end + 1..])
        {
            decimal.exponent += power;
            decimal.has_exponent = true;
            end += 1 + length;
        }
        Some((decimal, end))
    }

    /// Fixed-point form: integer in units of the last digit, and number of decimals; `None` with an exponent or beyond the range of
    /// `i64`.
    #[inline]
    pub fn fixed_point(self) -> Option<(i64, i32)> {
        const MAX_DECIMALS: i32 = 18;
        let digits = i64::try_from(self.digits).ok()?;
        let is_fixed = !self.has_exponent && -self.exponent <= MAX_DECIMALS;
        is_fixed.then_some((
            if self.is_negative { -digits } else { digits },
            -self.exponent,
        ))
    }

    /// The nearest double, if one rounded operation gives it.
    #[inline(always)]
    fn value(self) -> Option<f64> {
        if self.digits >= EXACT_INTEGERS {
            return None;
        }
        let power = *POWERS.get(self.exponent.unsigned_abs() as usize)?;
        let digits = self.digits as f64;
        let size = match self.exponent < 0 {
            true => digits / power,
            false => digits * power,
        };
        // Signs come at random: no branch.
        let sign = u64::from(self.is_negative) << (u64::BITS - 1);
        Some(f64::from_bits(size.to_bits() | sign))
    }
}

/// Parses a number at the start of a text with decimal mark `mark`: value and length, bytes; `nan` and `inf` are numbers.
#[inline]
pub fn parse_prefix(text: &[u8], mark: u8) -> Option<(f64, usize)> {
    match Decimal::scan(text, mark) {
        Some((decimal, length)) => match decimal.value() {
            Some(value) => Some((value, length)),
            None => parse_long(text, mark),
        },
        None => parse_long(text, mark),
    }
}

/// Parses a text that is one number.
pub fn parse(text: &[u8], mark: u8) -> Option<f64> {
    let (value, length) = parse_prefix(text, mark)?;
    (length == text.len()).then_some(value)
}

/// Parses a number of any length as [`parse_prefix`].
#[cold]
fn parse_long(text: &[u8], mark: u8) -> Option<(f64, usize)> {
    if mark == b'.' {
        return fast_float2::parse_partial(text).ok();
    }
    let mut with_point = [0; MAX_LEN];
    for (target, &byte) in with_point.iter_mut().zip(text) {
        *target = match byte {
            b'.' => 0,
            byte if byte == mark => b'.',
            byte => byte,
        };
    }
    fast_float2::parse_partial(&with_point[..text.len().min(MAX_LEN)]).ok()
}

/// Mantissa within the first sixteen bytes: its digits as an integer, number of decimals, and length, bytes; `None` if it may be
/// longer.
#[inline(always)]
fn short_mantissa(front: [u8; 16], mark: u8) -> Option<(u64, usize, usize)> {
    let repeated = |byte: u8| u128::from_le_bytes([byte; 16]);
    let top_bits = repeated(0x80);
    let bytes = u128::from_le_bytes(front);
    // A digit gives a byte below 10; adding 118 sets the top bit of all others up to the first of them.
    let values = bytes ^ repeated(b'0');
    let non_digits = (values.wrapping_add(repeated(118)) | values) & top_bits;
    let first_non_digit = non_digits & non_digits.wrapping_neg();
    // Adding 127 leaves the top bit of the marks alone unset.
    let no_marks = (bytes ^ repeated(mark)).wrapping_add(repeated(127)) | (bytes ^ repeated(mark));
    let mark_bit = first_non_digit & !no_marks;
    let ends = non_digits ^ mark_bit;
    if ends == 0 {
        return None;
    }
    let length = ends.trailing_zeros() as usize / 8;
    let has_mark = usize::from(mark_bit != 0);
    let n_digits = length - has_mark;
    if n_digits == 0 {
        return None;
    }
    let n_integer = first_non_digit.trailing_zeros() as usize / 8;
    let integer_mask = (first_non_digit >> 7).wrapping_sub(1);
    let joined = match mark_bit {
        0 => values,
        _ => (values & integer_mask) | ((values >> 8) & !integer_mask),
    };
    let digits = joined << (128 - 8 * n_digits);
    let number = 100_000_000 * eight_digits(digits as u64) + eight_digits((digits >> 64) as u64);
    Some((number, n_digits - n_integer, length))
}

/// Mantissa of any length as [`short_mantissa`]; `None` without a digit or above [`MAX_DIGITS`].
#[cold]
fn long_mantissa(text: &[u8], mark: u8) -> Option<(u64, usize, usize)> {
    let (mut digits, mut count, mut mark_position) = (0_u64, 0, None);
    for &byte in text {
        match byte {
            b'0'..=b'9' => {
                digits = digits.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
                count += 1;
            }
            byte if byte == mark && mark_position.is_none() => mark_position = Some(count),
            _ => break,
        }
    }
    let n_decimals = count - mark_position.unwrap_or(count);
    let length = count + usize::from(mark_position.is_some());
    (1..=MAX_DIGITS)
        .contains(&count)
        .then_some((digits, n_decimals, length))
}

/// Value of eight digits, the first in the lowest byte: pairs, fours, then both (Lemire 2021, “Number parsing at a gigabyte
/// per second”, Software: Practice and Experience 51, section 7).
#[inline(always)]
fn eight_digits(bytes: u64) -> u64 {
    const PAIR: u64 = 0x0000_00FF_0000_00FF;
    let pairs = bytes.wrapping_mul(10).wrapping_add(bytes >> 8);
    let high = (pairs & PAIR).wrapping_mul(100 + (1_000_000 << 32));
    let low = ((pairs >> 16) & PAIR).wrapping_mul(1 + (10_000 << 32));
    high.wrapping_add(low) >> 32
}

/// Exponent after its letter, and its length, bytes.
fn exponent(text: &[u8]) -> Option<(i32, usize)> {
    const MAX_EXPONENT_DIGITS: usize = 5;
    let first = *text.first()?;
    let sign = usize::from(matches!(first, b'+' | b'-'));
    let digits = text[sign..].iter().take_while(|b| b.is_ascii_digit());
    let count = digits.clone().count();
    let size = match count {
        0 => return None,
        1..=MAX_EXPONENT_DIGITS => digits.fold(0, |size, b| 10 * size + i32::from(b - b'0')),
        // Beyond the range of any double: fast_float2 decides.
        _ => i32::from(i16::MAX),
    };
    Some((if first == b'-' { -size } else { size }, sign + count))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Random number, mainly in the format of data loggers, else of any number of digits and exponent.
    fn write_random(random: &mut fastrand::Rng) -> String {
        let sign = ["", "", "-", "+"][random.usize(..4)];
        let digits = |random: &mut fastrand::Rng, max_count: usize| -> String {
            let count = random.usize(..=max_count);
            (0..count)
                .map(|_| char::from(random.u8(b'0'..=b'9')))
                .collect()
        };
        let max_count = if random.u8(..4) == 0 { 24 } else { 8 };
        let integer = digits(random, max_count);
        let fraction = digits(random, max_count);
        let mark = if fraction.is_empty() && random.bool() {
            ""
        } else {
            "."
        };
        let exponent = match random.u8(..6) {
            0 => format!("e{}", random.i32(-30..30)),
            1 => format!("E{:+04}", random.i32(-330..330)),
            _ => String::new(),
        };
        format!("{sign}{integer}{mark}{fraction}{exponent}")
    }

    fn check_random(count: usize, seed: u64) {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut numbers = 0;
        for _ in 0..count {
            let text = write_random(&mut random);
            let parsed = parse(text.as_bytes(), b'.');
            let Ok(value) = text.parse::<f64>() else {
                assert_eq!(parsed, None, "{text}");
                continue;
            };
            numbers += 1;
            assert_eq!(parsed.map(f64::to_bits), Some(value.to_bits()), "{text}");
            // Within a row, and with a decimal comma.
            let row = format!("{text},-1.5\n");
            let (in_row, length) = parse_prefix(row.as_bytes(), b'.').unwrap();
            assert_eq!(
                (in_row.to_bits(), length),
                (value.to_bits(), text.len()),
                "{row}"
            );
            let row = format!("{};-1,5\n", text.replace('.', ","));
            let (in_row, length) = parse_prefix(row.as_bytes(), b',').unwrap();
            assert_eq!(
                (in_row.to_bits(), length),
                (value.to_bits(), text.len()),
                "{row}"
            );
        }
        assert!(numbers > count / 2, "{numbers} of {count}");
    }

    /// Numbers of every form equal those of the standard library, to the last bit.
    #[test]
    fn exact_random_decimals() {
        check_random(20_000, 1);
    }

    #[test]
    #[ignore = "two million decimals take some seconds"]
    fn exact_two_million_random_decimals() {
        check_random(2_000_000, 2);
    }

    /// Limits of the exact range, of doubles and of the notation.
    #[test]
    fn exact_decimals_at_the_edges() {
        for text in [
            "0",
            "-0",
            "-0.0",
            "5.",
            ".5",
            "+.5",
            "-.5e1",
            "1e22",
            "1e23",
            "1e-22",
            "1e-23",
            "9007199254740991",
            "9007199254740992",
            "9007199254740993",
            "9007199254740993e22",
            "0.30000000000000004",
            "12345678901234567890",
            "1234567890123456789",
            "0.0000000000000000000001",
            "100000000000000000000000.5",
            "1e-400",
            "1e400",
            "-1e400",
            "4.9e-324",
            "2.4e-324",
            "2.2250738585072011e-308",
            "1.7976931348623157e308",
            "1e000000000000000000001",
            "1e-99999999999",
            "1e4294967297",
            "123456.7e+05",
        ] {
            let value: f64 = text.parse().unwrap();
            let parsed = parse(text.as_bytes(), b'.').map(f64::to_bits);
            assert_eq!(parsed, Some(value.to_bits()), "{text}");
        }
        for (text, value, length) in [
            ("1e", 1.0, 1),
            ("1e+", 1.0, 1),
            ("1.5.2", 1.5, 3),
            ("2 ", 2.0, 1),
            ("3,4", 3.0, 1),
            ("7:30", 7.0, 1),
            ("1.25E5x", 1.25e5, 6),
        ] {
            assert_eq!(
                parse_prefix(text.as_bytes(), b'.'),
                Some((value, length)),
                "{text}"
            );
            assert_eq!(parse(text.as_bytes(), b'.'), None, "{text}");
        }
        for text in ["", "-", "+", ".", "e5", " 1", "--1", "+-1", "/1", ":", ",5"] {
            assert_eq!(parse_prefix(text.as_bytes(), b'.'), None, "{text}");
        }
        assert_eq!(parse_prefix(b"1.234,5", b','), Some((1.0, 1)));
        assert_eq!(parse(b"-0,25e1", b','), Some(-2.5));
    }
}
