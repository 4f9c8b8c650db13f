//! Results as tables, JSON, CSV and pictures. Computes nothing.

/// Columns of numbers.
pub mod number;

/// Modes in words.
pub mod words;

/// JSON documents.
pub mod json;

/// CSV files.
pub mod csv;

/// Tables for a terminal.
#[cfg(feature = "cli")]
pub mod table;
