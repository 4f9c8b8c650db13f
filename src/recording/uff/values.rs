//! Values of data set 58: text columns or binary floats.

use super::cursor::{UffCursor, is_delimiter};
use super::header::{OrdinateType, UffHeader};
use crate::base::error::Error;
use crate::recording::decimal;

/// Values of a data set: abscissa if it is uneven, real part (or real ordinate), imaginary part if it is complex.
#[derive(Debug, Default)]
pub(super) struct UffValues {
    pub x: Vec<f64>,
    pub re: Vec<f64>,
    pub im: Vec<f64>,
    /// Number of cells that hold an overflow mark (`****`) or infinity.
    pub overloads: usize,
}

/// Fields of the first line of a binary data set.
#[derive(Debug, Clone, Copy)]
pub(super) struct BinaryHeader {
    pub is_big_endian: bool,
    /// Stated length of the values, bytes.
    pub bytes: usize,
}

impl UffHeader {
    /// Number of floats in one value: abscissa, real and imaginary part.
    fn width(&self) -> usize {
        usize::from(!self.is_uniform) + 1 + usize::from(self.ordinate_kind.is_complex)
    }
}

/// Splits the numbers in `flat` into abscissa, real and imaginary parts.
fn split_values(flat: &[f64], header: &UffHeader, overloads: usize) -> UffValues {
    let mut values = UffValues {
        overloads,
        ..UffValues::default()
    };
    for value in flat.chunks_exact(header.width()) {
        let mut value = value.iter().copied();
        if !header.is_uniform {
            values.x.extend(value.next());
        }
        values.re.extend(value.next());
        values.im.extend(value);
    }
    values
}

/// Reads numbers written as text, up to the count of the header or the closing delimiter, whichever comes first.
pub(super) fn read_text(
    cursor: &mut UffCursor<'_>,
    header: &UffHeader,
) -> Result<UffValues, Error> {
    let number_count = header.count.saturating_mul(header.width());
    // A number takes two bytes at least, so that a wrong count allocates no more than the file justifies.
    let mut flat = Vec::with_capacity(number_count.min(cursor.rest.len() / 2));
    let mut overloads = 0;
    while flat.len() < number_count && !cursor.rest.is_empty() {
        let mut line = cursor.peek();
        if is_delimiter(line) {
            break;
        }
        while flat.len() < number_count {
            line = line.trim_ascii_start();
            if line.is_empty() || is_delimiter(line) {
                break;
            }
            let (number, length) = number(line).ok_or_else(|| {
                let cell = line.split(|b| b.is_ascii_whitespace()).next();
                let cell = String::from_utf8_lossy(cell.unwrap_or_default());
                let shown: String = cell.chars().take(24).collect();
                cursor.error_here(format!("`{shown}` is not a number"))
            })?;
            let is_abscissa = !header.is_uniform && flat.len() % header.width() == 0;
            if is_abscissa && !number.is_finite() {
                return Err(cursor.error_here("the abscissa is not a finite number"));
            }
            let is_overload = line[0] == b'*' || number.is_infinite();
            overloads += usize::from(is_overload);
            flat.push(if is_overload { f64::NAN } else { number });
            line = &line[length..];
        }
        // Zeros that pad the last row are ignored; the delimiter may follow without a line end.
        let is_padding = |b: &u8| matches!(b, b'0' | b'.' | b'E' | b'e' | b'+' | b' ');
        if flat.len() == number_count
            && !line.is_empty()
            && !is_delimiter(line)
            && !line.iter().all(is_padding)
        {
            return Err(cursor.error_here(format!(
                "more numbers follow the {} values the header states",
                header.count
            )));
        }
        let is_attached = is_delimiter(line) && !line.is_empty();
        if is_attached {
            // The delimiter is left to the caller.
            let at = cursor.peek().len() - line.len();
            cursor.rest = &cursor.rest[at..];
            break;
        }
        cursor.next_line();
    }
    Ok(split_values(&flat, header, overloads))
}

/// First number of a line and its length, bytes; exponents may begin with `D`, or with their sign alone.
fn number(line: &[u8]) -> Option<(f64, usize)> {
    let end = line.iter().position(u8::is_ascii_whitespace);
    let token = &line[..end.unwrap_or(line.len())];
    if token[0] == b'*' || token.contains(&b'#') {
        return Some((f64::NAN, token.len()));
    }
    let (mut value, mut parsed_length) = decimal::parse_prefix(token, b'.')?;
    let fortran = match &token[parsed_length..] {
        [b'D' | b'd', exponent @ ..] => Some((exponent, 1)),
        exponent @ [b'+' | b'-', a, b, c, ..]
            if [a, b, c].iter().all(|d| d.is_ascii_digit()) && exponent.get(4) != Some(&b'.') =>
        {
            Some((&exponent[..4], 0))
        }
        _ => None,
    };
    if let Some((exponent, mark)) = fortran {
        let sign = usize::from(matches!(exponent.first(), Some(b'+' | b'-')));
        let digits = exponent[sign..].iter().take_while(|d| d.is_ascii_digit());
        let length = sign + digits.count();
        let mantissa = std::str::from_utf8(&token[..parsed_length]).ok()?;
        let exponent = std::str::from_utf8(&exponent[..length]).ok()?;
        value = decimal::parse(format!("{mantissa}E{exponent}").as_bytes(), b'.')?;
        parsed_length += mark + length;
    }
    Some((value, parsed_length))
}

/// Reads binary floats.
pub(super) fn read_binary(
    cursor: &mut UffCursor<'_>,
    header: &UffHeader,
    binary: BinaryHeader,
) -> Result<UffValues, Error> {
    let OrdinateType { is_double, .. } = header.ordinate_kind;
    let size = if is_double { 8 } else { 4 };
    let ordinates = header.width() - usize::from(!header.is_uniform);
    let per_value = |abscissa: usize| ordinates * size + abscissa;
    let byte_count = |abscissa: usize| header.count.saturating_mul(per_value(abscissa));
    // Most programs write an uneven abscissa in the precision of the ordinate, some in single precision.
    let abscissa = match (header.is_uniform, binary.bytes == byte_count(4)) {
        (true, _) => 0,
        (false, true) => 4,
        (false, false) => size,
    };
    let wanted = byte_count(abscissa);
    let Some((data, rest)) = cursor.rest.split_at_checked(wanted) else {
        let message = format!(
            "the binary data set 58 needs {wanted} bytes for its {} values, but {} remain",
            header.count,
            cursor.rest.len()
        );
        return Err(cursor
            .error_here(message)
            .with_hint("the file was cut off or damaged: copy it again, not as text"));
    };
    cursor.rest = rest;
    let width = header.width();
    let mut flat = Vec::with_capacity(header.count * width);
    for value in data.chunks_exact(per_value(abscissa).max(1)) {
        let (x, y) = value.split_at(abscissa);
        decode(x, abscissa == 8, binary.is_big_endian, &mut flat);
        decode(y, is_double, binary.is_big_endian, &mut flat);
    }
    let values = split_values(&flat, header, 0);
    if let Some(at) = values.x.iter().position(|x| !x.is_finite()) {
        let message = format!("the abscissa of value {} is not a finite number", at + 1);
        return Err(cursor.error_here(message));
    }
    Ok(values)
}

/// Decodes floats of one precision and byte order and appends them to `output`.
fn decode(bytes: &[u8], is_double: bool, is_big_endian: bool, output: &mut Vec<f64>) {
    match (is_double, is_big_endian) {
        (true, false) => output.extend(bytes.as_chunks().0.iter().map(|&b| f64::from_le_bytes(b))),
        (true, true) => output.extend(bytes.as_chunks().0.iter().map(|&b| f64::from_be_bytes(b))),
        (false, is_big_endian) => output.extend(bytes.as_chunks().0.iter().map(|&b| {
            f64::from(if is_big_endian {
                f32::from_be_bytes(b)
            } else {
                f32::from_le_bytes(b)
            })
        })),
    }
}
