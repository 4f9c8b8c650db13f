//! Time-stamp parser: converts numbers, date and time, and time of day to seconds since the first stamp.

use super::cells;
use crate::recording::decimal::{Decimal, power_of_ten};
use crate::recording::resolution::Resolution;

/// Date and time as written.
#[derive(Debug, Clone, Copy, PartialEq)]
struct DateTime {
    date: Option<Date>,
    /// Nanoseconds since midnight UTC if a zone is written, else since local midnight.
    clock: Option<i64>,
    /// Number of digits of the fraction of a second.
    digits: u32,
}

/// Date as written; the order of day and month may be ambiguous.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Date {
    /// Year, month, day; and whether the day comes first, for dates written with slashes.
    Known(i64, i64, i64, Option<bool>),
    /// Day and month in unknown order, and the year.
    Ambiguous(i64, i64, i64),
}

/// Format of a column of stamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StampFormat {
    /// Number in a unit of time.
    Decimal,
    /// Date with time of day; cells may omit the time.
    DateTime,
    /// Date without time of day.
    Date,
    /// Time of day, or time since the start.
    Clock,
}

const SECOND: i64 = 1_000_000_000;
const DAY_S: i64 = 86_400;

/// Format of the stamp in a cell; `None` for plain numbers and text.
pub fn detect_format(cell: &[u8]) -> Option<StampFormat> {
    let stamp = parse_date_time(cells::trim_cell(cell))?;
    Some(match (stamp.date, stamp.clock) {
        (Some(_), Some(_)) => StampFormat::DateTime,
        (Some(_), None) => StampFormat::Date,
        (None, _) => StampFormat::Clock,
    })
}

/// Parses leading digits, at most nine: value, count, remaining text.
fn digits(text: &[u8]) -> Option<(i64, usize, &[u8])> {
    let n = text.iter().take_while(|b| b.is_ascii_digit()).count();
    if n == 0 || n > 9 {
        return None;
    }
    let value = text[..n]
        .iter()
        .fold(0, |v, b| 10 * v + i64::from(b - b'0'));
    Some((value, n, &text[n..]))
}

fn parse_date_time(cell: &[u8]) -> Option<DateTime> {
    // The shortest stamp is 1:02, the longest a date with nine decimals of a second and a zone.
    if !cell.first()?.is_ascii_digit() || cell.len() < 4 || cell.len() > 48 {
        return None;
    }
    let (date, rest) = match date(cell) {
        Some((date, rest)) => (Some(date), rest),
        None => (None, cell),
    };
    let rest = match (date, rest) {
        (None, rest) => rest,
        (Some(_), []) => {
            return Some(DateTime {
                date,
                clock: None,
                digits: 0,
            });
        }
        (Some(_), [b'T' | b't' | b' ' | b'_' | b';' | b',', rest @ ..]) => rest.trim_ascii(),
        _ => return None,
    };
    let (clock, digits) = clock(rest, date.is_some())?;
    Some(DateTime {
        date,
        clock: Some(clock),
        digits,
    })
}

/// Parses a leading date and returns the remaining text.
fn date(text: &[u8]) -> Option<(Date, &[u8])> {
    let (a, a_digits, rest) = digits(text)?;
    let (&separator, rest) = rest.split_first()?;
    if !matches!(separator, b'-' | b'/' | b'.' | b' ') {
        return None;
    }
    let (b, is_month_name, rest) = match month(rest) {
        Some((b, rest)) => (b, true, rest),
        None if separator == b' ' => return None,
        None => digits(rest)
            .filter(|d| d.1 <= 2)
            .map(|d| (d.0, false, d.2))?,
    };
    let rest = rest.strip_prefix(&[separator])?;
    let (c, c_digits, rest) = digits(rest)?;
    let year = |y: i64, n: usize| match n {
        4 => Some(y),
        2 => Some(if y < 70 { 2000 + y } else { 1900 + y }),
        _ => None,
    };
    let parsed = if a_digits == 4 {
        (c_digits <= 2 && is_day(a, b, c)).then_some(Date::Known(a, b, c, None))
    } else {
        let y = year(c, c_digits)?;
        let (day_first, month_first) = (is_day(y, b, a), is_day(y, a, b));
        if is_month_name || separator != b'/' {
            // With points and hyphens the day always comes first.
            day_first.then_some(Date::Known(y, b, a, None))
        } else if day_first && month_first && a != b {
            Some(Date::Ambiguous(a, b, y))
        } else if day_first && month_first {
            Some(Date::Known(y, b, a, None))
        } else if day_first {
            Some(Date::Known(y, b, a, Some(true)))
        } else {
            month_first.then_some(Date::Known(y, a, b, Some(false)))
        }
    };
    Some((parsed?, rest))
}

/// Whether the day exists in the month of the year.
fn is_day(year: i64, month: i64, day: i64) -> bool {
    let next = match month {
        12 => days(year + 1, 1, 1),
        _ => days(year, month + 1, 1),
    };
    (1..=12).contains(&month) && (1..=next - days(year, month, 1)).contains(&day)
}

/// Parses a leading abbreviated English month, from 1, and returns the remaining text.
fn month(text: &[u8]) -> Option<(i64, &[u8])> {
    const MONTHS: &[u8] = b"janfebmaraprmayjunjulaugsepoctnovdec";
    let word = text.get(..3)?.to_ascii_lowercase();
    let at = MONTHS.chunks(3).position(|m| m == word.as_slice())?;
    Some((at as i64 + 1, &text[3..]))
}

/// Parses a time that fills the text: nanoseconds and number of decimals; `of_day` limits it to a time of day.
fn clock(text: &[u8], of_day: bool) -> Option<(i64, u32)> {
    let (a, a_digits, rest) = digits(text)?;
    let (b, b_digits, rest) = digits(rest.strip_prefix(b":")?)?;
    if a_digits > 4 || b_digits != 2 || b > 59 {
        return None;
    }
    let (hours, minutes, seconds, rest) = match rest.strip_prefix(b":") {
        Some(rest) => {
            let (c, c_digits, rest) = digits(rest)?;
            if c_digits != 2 || c > 60 {
                return None;
            }
            (a, b, c, rest)
        }
        // Minutes and seconds in `01:02.5`, hours and minutes in `01:02`.
        None if matches!(rest.first(), Some(b'.' | b',')) => (0, a, b, rest),
        None => (a, b, 0, rest),
    };
    let (fraction, digits, rest) = match rest {
        [b'.' | b',' | b':', rest @ ..] => {
            let n = rest.iter().take_while(|b| b.is_ascii_digit()).count();
            let value = |v: i64, at| 10 * v + rest.get(at).map_or(0, |b| i64::from(b - b'0'));
            let nano = (0..9).fold(0, |v, at| if at < n { value(v, at) } else { 10 * v });
            (nano, n.min(9) as u32, &rest[n..])
        }
        _ => (0, 0, rest),
    };
    let (half_day, zone) = zone(rest.trim_ascii())?;
    // The last time of a day is 24:00:00.
    let is_late = 3600 * hours + 60 * minutes + seconds > DAY_S;
    if of_day && (is_late || (hours == 24 && fraction > 0)) {
        return None;
    }
    let hours = match half_day {
        Some(_) if !(1..=12).contains(&hours) => return None,
        Some(is_pm) => hours % 12 + if is_pm { 12 } else { 0 },
        None => hours,
    };
    let seconds = 3600 * hours + 60 * (minutes - zone) + seconds;
    Some((SECOND * seconds + fraction, digits))
}

/// Parses the suffix of a time (`AM`, `PM`, `Z`, `+01:00`): whether it is afternoon, and the zone offset, minutes.
fn zone(text: &[u8]) -> Option<(Option<bool>, i64)> {
    match text {
        b"" | b"Z" | b"z" | b"UTC" => Some((None, 0)),
        b"AM" | b"am" => Some((Some(false), 0)),
        b"PM" | b"pm" => Some((Some(true), 0)),
        [sign @ (b'+' | b'-'), rest @ ..] => {
            let (hours, n, rest) = digits(rest)?;
            let minutes = match rest {
                [] if n == 2 => 60 * hours,
                [] if n == 4 => 60 * (hours / 100) + hours % 100,
                [b':', rest @ ..] if n == 2 => {
                    60 * hours + digits(rest).filter(|d| d.2.is_empty())?.0
                }
                _ => return None,
            };
            Some((None, if *sign == b'-' { -minutes } else { minutes }))
        }
        _ => None,
    }
}

/// Days since 1970-01-01 in the Gregorian calendar: 365 per year plus leap days, months counted from March.
fn days(year: i64, month: i64, day: i64) -> i64 {
    let (y, m) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let leaps = y.div_euclid(4) - y.div_euclid(100) + y.div_euclid(400);
    365 * y + leaps + (153 * m + 2) / 5 + day - 1 - 719_468
}

/// Error of a cell that is not a valid stamp of its column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StampError {
    /// The cell cannot be read as a stamp.
    Invalid,
    /// The order of day and month is ambiguous.
    AmbiguousOrder,
    /// The order of day and month contradicts the stated order or the preceding stamps.
    ConflictingOrder,
}

/// Parser of the stamps of one column, in the order of the rows.
#[derive(Debug, Clone)]
pub struct StampParser {
    format: StampFormat,
    /// Unit of numeric stamps, s.
    unit_s: f64,
    decimal: u8,
    day_first: Option<bool>,
    first: Option<FirstStamp>,
    /// Nanoseconds added after midnight to times without date.
    midnight_offset: i64,
    last: i64,
    /// Finest resolution of the stamps read, in their unit.
    finest: f64,
    /// Maximum number of decimals of numbers without exponent.
    decimals: i32,
    /// Largest magnitude of these numbers, in units of the last digit.
    largest: u64,
    /// Maximum number of significant digits of numbers with exponent.
    digits: u32,
    /// First stamp as written.
    pub start: String,
}

#[derive(Debug, Clone, Copy)]
enum FirstStamp {
    /// Number without exponent: digits without the decimal point, and number of decimals.
    Exact(i64, i32),
    Float(f64),
    /// Date and nanoseconds of the day.
    Clock(Option<Date>, i64),
}

impl StampParser {
    /// Creates a parser of stamps of `format`; numbers have the unit `unit_s`, s.
    pub fn new(
        format: StampFormat,
        unit_s: f64,
        decimal: u8,
        day_first: Option<bool>,
    ) -> StampParser {
        StampParser {
            format,
            unit_s,
            decimal,
            day_first,
            first: None,
            midnight_offset: 0,
            last: 0,
            finest: f64::INFINITY,
            decimals: -1,
            largest: 0,
            digits: 0,
            start: String::new(),
        }
    }

    /// Resolution by the last digit written; numbers may omit trailing zeros, so the maximum number of digits applies.
    pub fn resolution(&self) -> Resolution {
        let first = match self.first {
            Some(FirstStamp::Clock(..)) | None => None,
            Some(_) => Some(self.first_s() / self.unit_s),
        };
        let finest_s = match self.finest.is_finite() {
            true => self.finest * self.unit_s,
            false => 0.0,
        };
        let count = self.largest.checked_ilog10().map_or(0, |n| n + 1);
        let digits = self.digits.max(count) as i32;
        match first {
            Some(first) => Resolution::from_digits(finest_s, digits, first, self.unit_s),
            None => Resolution::constant(finest_s),
        }
    }

    /// First numeric stamp, s; 0 for dates and times of day.
    pub fn first_s(&self) -> f64 {
        let first = match self.first {
            Some(FirstStamp::Exact(digits, after)) => digits as f64 / power_of_ten(after),
            Some(FirstStamp::Float(first)) => first,
            Some(FirstStamp::Clock(..)) | None => 0.0,
        };
        first * self.unit_s
    }

    /// Whether the order of day and month is ambiguous in the first stamp and not determined by later ones.
    pub fn is_ambiguous(&self) -> bool {
        let is_unknown = matches!(
            self.first,
            Some(FirstStamp::Clock(Some(Date::Ambiguous(..)), _))
        );
        is_unknown && self.day_first.is_none()
    }

    /// Whether stamps depend on the first stamp only, so that rows may be read in any order.
    pub fn is_independent(&self) -> bool {
        self.format == StampFormat::Decimal && self.first.is_some()
    }

    /// Merges the resolution found by a copy of this parser in other rows.
    pub fn merge(&mut self, other: &StampParser) {
        self.finest = self.finest.min(other.finest);
        self.decimals = self.decimals.max(other.decimals);
        self.largest = self.largest.max(other.largest);
        self.digits = self.digits.max(other.digits);
    }

    /// Parses a cell to seconds since the first stamp; `None` for a blank cell.
    ///
    /// # Errors
    /// The cell is not a valid stamp of this column.
    pub fn seconds(&mut self, cell: &[u8]) -> Result<Option<f64>, StampError> {
        let cell = cells::trim_cell(cell);
        if cell.is_empty() {
            return Ok(None);
        }
        if self.first.is_none() {
            self.start = String::from_utf8_lossy(cell).into_owned();
        }
        match self.format {
            StampFormat::Decimal => self.number(cell),
            StampFormat::DateTime | StampFormat::Date | StampFormat::Clock => {
                self.clock(cell).map(Some)
            }
        }
    }

    fn number(&mut self, cell: &[u8]) -> Result<Option<f64>, StampError> {
        let number = Decimal::scan(cell, self.decimal).filter(|(_, length)| *length == cell.len());
        match number.and_then(|(decimal, _)| self.plain_seconds(decimal)) {
            Some(seconds) => Ok(Some(seconds)),
            None => self.float(cell),
        }
    }

    /// Seconds since the first stamp for a number without exponent in a numeric column; `None` otherwise.
    #[inline]
    pub fn plain_seconds(&mut self, decimal: Decimal) -> Option<f64> {
        let (units, after) = decimal.fixed_point()?;
        if after > self.decimals {
            self.decimals = after;
            self.finest = self.finest.min(power_of_ten(-after));
        }
        self.largest = self.largest.max(units.unsigned_abs());
        let elapsed = match *self.first.get_or_insert(FirstStamp::Exact(units, after)) {
            FirstStamp::Exact(first, first_after) => difference(units, after, first, first_after),
            FirstStamp::Float(first) => units as f64 / power_of_ten(after) - first,
            FirstStamp::Clock(..) => return None,
        };
        Some(elapsed * self.unit_s)
    }

    fn float(&mut self, cell: &[u8]) -> Result<Option<f64>, StampError> {
        let value = match cells::parse_cell(cell, self.decimal) {
            cells::Cell::Number(value) | cells::Cell::Thousands { value, .. } => value,
            cells::Cell::Missing => return Ok(None),
            _ => return Err(StampError::Invalid),
        };
        let last = resolution(cell, self.decimal);
        // Zero has no significant digit and does not determine the resolution.
        if value != 0.0 {
            self.finest = self.finest.min(last);
            let count = 1.0 + value.abs().log10().floor() - last.log10().round();
            self.digits = self.digits.max(count.clamp(1.0, 18.0) as u32);
        }
        let elapsed = match *self.first.get_or_insert(FirstStamp::Float(value)) {
            FirstStamp::Float(first) => value - first,
            FirstStamp::Exact(first, after) => value - first as f64 / power_of_ten(after),
            FirstStamp::Clock(..) => return Err(StampError::Invalid),
        };
        Ok(Some(elapsed * self.unit_s))
    }

    fn clock(&mut self, cell: &[u8]) -> Result<f64, StampError> {
        let stamp = parse_date_time(cell).ok_or(StampError::Invalid)?;
        let nano = stamp.clock.unwrap_or(0);
        let digit = match stamp.clock {
            Some(_) => power_of_ten(-(stamp.digits as i32)),
            None => DAY_S as f64,
        };
        self.finest = self.finest.min(digit / self.unit_s);
        let first = *self
            .first
            .get_or_insert(FirstStamp::Clock(stamp.date, nano));
        if let (Some(Date::Known(.., Some(order))), Some(stated)) = (stamp.date, self.day_first)
            && order != stated
        {
            return Err(StampError::ConflictingOrder);
        }
        let FirstStamp::Clock(first_date, first_nano) = first else {
            return Err(StampError::Invalid);
        };
        let days = match (first_date, stamp.date) {
            (Some(first), Some(now)) => self.days_between(first, now)?,
            (None, None) => {
                // A decrease by more than half a day is a midnight crossing.
                if nano + self.midnight_offset < self.last - SECOND * DAY_S / 2 {
                    self.midnight_offset += SECOND * DAY_S;
                }
                self.last = nano + self.midnight_offset;
                self.midnight_offset / (SECOND * DAY_S)
            }
            _ => return Err(StampError::Invalid),
        };
        Ok((days * DAY_S) as f64 + (nano - first_nano) as f64 / SECOND as f64)
    }

    /// Days from one date to another; determines the order of day and month if it is ambiguous.
    fn days_between(&mut self, first: Date, second: Date) -> Result<i64, StampError> {
        if first == second {
            return Ok(0);
        }
        let day_number = |date: Date, day_first: bool| match date {
            Date::Known(y, m, d, _) => days(y, m, d),
            Date::Ambiguous(a, b, y) if day_first => days(y, b, a),
            Date::Ambiguous(a, b, y) => days(y, a, b),
        };
        let interval = |day_first| day_number(second, day_first) - day_number(first, day_first);
        let day_first = match (self.day_first, first, second) {
            (Some(day_first), ..) => day_first,
            // A later unambiguous date that matches one order only determines the order of the first date.
            (None, Date::Ambiguous(a, b, _), Date::Known(_, m, d, _))
                if (a == d || b == m) != (a == m || b == d) =>
            {
                a == d || b == m
            }
            (None, ..) => match (interval(true), interval(false)) {
                (1, other) if other != 1 => true,
                (other, 1) if other != 1 => false,
                (one, other) if one == other => true,
                // Time cannot decrease in a continuous log.
                (forward, back) if forward > 0 && back < 0 => true,
                (back, forward) if forward > 0 && back < 0 => false,
                _ => return Err(StampError::AmbiguousOrder),
            },
        };
        self.day_first = Some(day_first);
        Ok(interval(day_first))
    }
}

/// Difference of two decimal numbers, rounded once.
fn difference(a: i64, a_after: i32, b: i64, b_after: i32) -> f64 {
    let after = a_after.max(b_after);
    if a_after == b_after
        && let Some(units) = a.checked_sub(b)
    {
        return units as f64 / power_of_ten(after);
    }
    let scaled =
        |v: i64, digits: i32| i128::from(v) * 10_i128.pow((after - digits).clamp(0, 18) as u32);
    (scaled(a, a_after) - scaled(b, b_after)) as f64 / power_of_ten(after)
}

/// Value of one unit of the last digit of a number with an exponent.
fn resolution(cell: &[u8], decimal: u8) -> f64 {
    let is_e = |b: &u8| matches!(*b, b'e' | b'E' | b'd' | b'D');
    let (mantissa, exponent) = match cell.iter().position(is_e) {
        Some(at) => (&cell[..at], &cell[at + 1..]),
        None => (cell, &b""[..]),
    };
    let mark = mantissa.iter().position(|b| *b == decimal);
    let after = mark.map_or(0, |at| mantissa.len() - at - 1);
    let exponent = std::str::from_utf8(exponent)
        .ok()
        .and_then(|e| e.parse().ok());
    power_of_ten(exponent.unwrap_or(0) - after as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(format: StampFormat, unit_s: f64, cells: &[&str]) -> Vec<f64> {
        let mut reader = StampParser::new(format, unit_s, b'.', None);
        let read = |c: &&str| reader.seconds(c.as_bytes()).unwrap().unwrap();
        cells.iter().map(read).collect()
    }

    /// Differences of stamps are exact to the last digit.
    #[test]
    fn exact_stamps_since_the_first() {
        let dates = [
            "2022-11-04 08:36:24.897",
            "2022-11-04T08:36:24.907Z",
            "2022-11-05 08:36:24,897",
        ];
        assert_eq!(
            seconds(StampFormat::DateTime, 1.0, &dates),
            [0.0, 0.01, 86_400.0]
        );
        let clock = ["23:59:59.5", "00:00:00.25", "00:00:01.25"];
        assert_eq!(seconds(StampFormat::Clock, 1.0, &clock), [0.0, 0.75, 1.75]);
        let days = ["1.03.2024 23:00:00", "02.03.2024 01:00:00"];
        assert_eq!(seconds(StampFormat::DateTime, 1.0, &days), [0.0, 7200.0]);
        let ambiguous = ["1/2/2023 11:59:59 PM", "1/3/2023 12:00:00 AM"];
        assert_eq!(seconds(StampFormat::DateTime, 1.0, &ambiguous), [0.0, 1.0]);
        let epoch = ["1657065123456789001", "1657065123456789003"];
        assert_eq!(seconds(StampFormat::Decimal, 1e-9, &epoch), [0.0, 2e-9]);
        assert_eq!(
            seconds(StampFormat::Decimal, 1e-3, &["0", "0.5", "2E0"]),
            [0.0, 5e-4, 2e-3]
        );
        assert_eq!(days_of("29-Feb-2024 00:00:00", "01-Mar-2024 00:00:00"), 1.0);
        assert_eq!(days_of("2023-12-31", "2024-12-31"), 366.0);
    }

    fn days_of(a: &str, b: &str) -> f64 {
        seconds(StampFormat::DateTime, 1.0, &[a, b])[1] / 86_400.0
    }

    /// The resolution is the last digit written: that of the most decimals, else the last significant digit.
    #[test]
    fn exact_resolution_from_the_digits() {
        let resolution = |format, cells: &[&str]| {
            let mut reader = StampParser::new(format, 1.0, b'.', None);
            cells
                .iter()
                .for_each(|c| assert!(reader.seconds(c.as_bytes()).is_ok()));
            let resolution = reader.resolution();
            let last = reader.seconds(cells[cells.len() - 1].as_bytes());
            resolution.unit_at(last.unwrap().unwrap())
        };
        assert_eq!(
            resolution(StampFormat::Decimal, &["0.0", "0.002352083", "0.500000001"]),
            1e-9
        );
        assert_eq!(
            resolution(
                StampFormat::Decimal,
                &["0.00000E+0", "2.00000E-4", "1.39998E+1"]
            ),
            1e-4
        );
        assert_eq!(
            resolution(StampFormat::DateTime, &["2022-11-04 08:36:24.897"]),
            1e-3
        );
    }

    /// An undetermined order of day and month is an error.
    #[test]
    fn refuses_day_or_month_that_the_data_leave_open() {
        let mut reader = StampParser::new(StampFormat::DateTime, 1.0, b'.', None);
        assert_eq!(reader.seconds(b"03/04/2023 10:00"), Ok(Some(0.0)));
        assert_eq!(
            reader.seconds(b"05/07/2023 10:00"),
            Err(StampError::AmbiguousOrder)
        );
        for text in [
            "1.234.567",
            "2022-13-01",
            "1:2",
            "12:60:00",
            "abc",
            "2022-11-04x",
            "13/13/2023",
        ] {
            assert_eq!(detect_format(text.as_bytes()), None, "{text}");
        }
    }
}
