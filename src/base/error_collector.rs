//! Collects the errors of one reading; ranges of values that keys accept.

use std::sync::Arc;

use super::error::Error;
use super::source_span::{SourceFile, SourceSpan};
use super::toml::{Document, Value};

/// Errors of one reading, and which files state bare numbers in SI.
#[derive(Debug, Default)]
pub struct ErrorCollector {
    /// Errors found so far.
    pub errors: Vec<Error>,
    /// Paths of the files that say `units = "SI"`.
    pub bare_si: Vec<String>,
    /// The flags that lie over what is read.
    pub flags: Option<Arc<SourceFile>>,
}

impl ErrorCollector {
    /// The most errors kept; a file with more is not a model, and guessing what each meant takes long.
    const MAX_ERRORS: usize = 1000;

    /// Notes an error.
    pub fn push(&mut self, error: Error) {
        if !self.is_full() {
            self.errors.push(error);
        }
    }

    /// Remembers a file that states bare numbers in SI.
    pub fn record_units(&mut self, document: &Document) {
        let units = document.root.get("units").map(|entry| &entry.item.value);
        if matches!(units, Some(Value::String(text)) if text == "SI") {
            self.bare_si.push(document.source.path.clone());
        }
    }

    /// No more errors are kept.
    pub fn is_full(&self) -> bool {
        self.errors.len() >= ErrorCollector::MAX_ERRORS
    }

    /// `span` is in the flags of the command line.
    pub fn is_flag(&self, span: &SourceSpan) -> bool {
        (self.flags.as_ref()).is_some_and(|flags| Arc::ptr_eq(flags, span.source()))
    }

    /// Bare numbers at `place` are SI.
    pub fn is_si(&self, span: &SourceSpan) -> bool {
        self.bare_si.contains(&span.source().path)
    }
}

/// The largest number taken: products of a stiffness, two lengths and what they are compared with stay within the range of numbers.
pub const MAX_MAGNITUDE: f64 = 1e50;

/// Smallest size in SI units distinguished from zero, for the same reason.
pub const MIN_MAGNITUDE: f64 = 1e-50;

/// Which numbers a key takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ValueRange {
    /// Any finite number.
    Any,
    /// Zero or above.
    NotNegative,
    /// Above zero.
    Positive,
    /// At least the first, below the second; the text tells the limits with their units.
    HalfOpen(f64, f64, &'static str),
    /// Above the first, below the second; the text tells the limits with their units.
    Open(f64, f64, &'static str),
}

impl ValueRange {
    /// Violation of the limits by `value`, if any.
    pub fn violation(self, value: f64) -> Option<String> {
        let good = match self {
            ValueRange::Any => true,
            ValueRange::NotNegative => value >= 0.0,
            ValueRange::Positive => value > 0.0,
            ValueRange::HalfOpen(low, high, _) => (low..high).contains(&value),
            ValueRange::Open(low, high, _) => value > low && value < high,
        };
        if good && value.abs() <= MAX_MAGNITUDE {
            return None;
        }
        Some(match self {
            _ if good && value.is_finite() => format!(
                "must not exceed {MAX_MAGNITUDE:e} in SI units, beyond which products leave the range of numbers"
            ),
            _ if !value.is_finite() => "must be a finite number".into(),
            ValueRange::Any | ValueRange::NotNegative => "must not be negative".into(),
            ValueRange::Positive => "must be above zero".into(),
            ValueRange::HalfOpen(_, _, limits) | ValueRange::Open(_, _, limits) => {
                format!("must be {limits}")
            }
        })
    }
}
