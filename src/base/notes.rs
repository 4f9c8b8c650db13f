//! What a reading found wrong, and which numbers keys take.

use super::error::Error;
use super::place::Place;

/// Errors of one reading, and which files state bare numbers in SI.
#[derive(Debug, Default)]
pub struct Notes {
    /// What was found wrong so far.
    pub errors: Vec<Error>,
    /// Paths of the files that say `units = "SI"`.
    pub bare_si: Vec<String>,
}

impl Notes {
    /// The most errors kept; a file with more is not a model, and guessing what each meant takes long.
    const MOST: usize = 1000;

    /// Notes an error.
    pub fn push(&mut self, error: Error) {
        if !self.full() {
            self.errors.push(error);
        }
    }

    /// No more errors are kept.
    pub fn full(&self) -> bool {
        self.errors.len() >= Notes::MOST
    }

    /// Bare numbers at `place` are SI.
    pub fn is_si(&self, place: &Place) -> bool {
        self.bare_si.contains(&place.source().path)
    }
}

/// The largest number taken: products of a stiffness, two lengths and what they are compared with stay within the range of numbers.
pub const LARGEST: f64 = 1e50;

/// The smallest size in SI units that is told from zero, for the same reason.
pub const SMALLEST: f64 = 1e-50;

/// Which numbers a key takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// Any finite number.
    Any,
    /// Zero or above.
    NotNegative,
    /// Above zero.
    Positive,
    /// At least the first, below the second; the text tells the limits with their units.
    Within(f64, f64, &'static str),
    /// Above the first, below the second; the text tells the limits with their units.
    Between(f64, f64, &'static str),
}

impl Range {
    /// What is wrong with `value`, if anything.
    pub fn refuses(self, value: f64) -> Option<String> {
        let good = match self {
            Range::Any => true,
            Range::NotNegative => value >= 0.0,
            Range::Positive => value > 0.0,
            Range::Within(low, high, _) => (low..high).contains(&value),
            Range::Between(low, high, _) => value > low && value < high,
        };
        if good && value.abs() <= LARGEST {
            return None;
        }
        Some(match self {
            _ if good && value.is_finite() => format!(
                "must not exceed {LARGEST:e} in SI units, beyond which products leave the range of numbers"
            ),
            _ if !value.is_finite() => "must be a finite number".into(),
            Range::Any | Range::NotNegative => "must not be negative".into(),
            Range::Positive => "must be above zero".into(),
            Range::Within(_, _, limits) | Range::Between(_, _, limits) => {
                format!("must be {limits}")
            }
        })
    }
}
