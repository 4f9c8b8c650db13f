//! Errors collected while model files are read, and the value ranges that keys accept.

use std::sync::Arc;

use super::error::Error;
use super::source_span::{SourceFile, SourceSpan};
use super::toml::{Document, Value};

/// Errors collected while files are read, with the files that state bare numbers in SI units.
#[derive(Debug, Default)]
pub struct ErrorCollector {
    /// Errors found so far.
    pub errors: Vec<Error>,
    /// Paths of the files that say `units = "SI"`.
    pub bare_si: Vec<String>,
    /// Command-line flags that override keys of the files.
    pub flags: Option<Arc<SourceFile>>,
}

impl ErrorCollector {
    /// Maximum number of errors; a file with more is not a model, and the spelling suggestions for its keys would take long.
    const MAX_ERRORS: usize = 1000;

    /// Adds an error unless the collector is full.
    pub fn push(&mut self, error: Error) {
        if !self.is_full() {
            self.errors.push(error);
        }
    }

    /// Records a document with `units = "SI"`.
    pub fn record_units(&mut self, document: &Document) {
        let units = document.root.get("units").map(|entry| &entry.item.value);
        if matches!(units, Some(Value::String(text)) if text == "SI") {
            self.bare_si.push(document.source.path.clone());
        }
    }

    /// Whether the maximum number of errors is reached; further ones are dropped.
    pub fn is_full(&self) -> bool {
        self.errors.len() >= ErrorCollector::MAX_ERRORS
    }

    /// Whether `span` lies in the command-line flags.
    pub fn is_flag(&self, span: &SourceSpan) -> bool {
        (self.flags.as_ref()).is_some_and(|flags| Arc::ptr_eq(flags, span.source()))
    }

    /// Whether bare numbers at `span` are in SI units.
    pub fn is_si(&self, span: &SourceSpan) -> bool {
        self.bare_si.contains(&span.source().path)
    }
}

/// Largest magnitude accepted, in SI units: products such as stiffness times two lengths stay within the range of `f64`.
pub const MAX_MAGNITUDE: f64 = 1e50;

/// Smallest magnitude in SI units distinguished from zero, for the same reason.
pub const MIN_MAGNITUDE: f64 = 1e-50;

/// Range of the numbers that a key accepts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ValueRange {
    /// Any finite number.
    Any,
    /// Zero or above.
    NotNegative,
    /// Above zero.
    Positive,
    /// From the first limit, included, to the second, excluded; the text states both with their units.
    HalfOpen(f64, f64, &'static str),
    /// Between both limits, excluded; the text states them with their units.
    Open(f64, f64, &'static str),
}

impl ValueRange {
    /// Message on the violation of the range by `value`, SI; `None` for an accepted value.
    pub fn violation(self, value: f64) -> Option<String> {
        let in_range = match self {
            ValueRange::Any => true,
            ValueRange::NotNegative => value >= 0.0,
            ValueRange::Positive => value > 0.0,
            ValueRange::HalfOpen(low, high, _) => (low..high).contains(&value),
            ValueRange::Open(low, high, _) => value > low && value < high,
        };
        if in_range && value.abs() <= MAX_MAGNITUDE {
            return None;
        }
        Some(match self {
            _ if in_range && value.is_finite() => format!(
                "must not exceed {MAX_MAGNITUDE:e} in SI units, beyond which products overflow"
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
