//! Errors with places and hints, units, and the reading of TOML with places.

/// Where in a file something stands.
pub mod place;

/// The words errors go by.
pub mod code;

/// The words of warnings and repairs.
pub mod remark;

/// What went wrong, where, and what to do now.
pub mod error;

/// What a key can measure.
pub mod kind;

/// Unit expressions.
mod unit;

/// Quantities with units, to SI.
pub mod units;

/// Files to text.
pub mod load;

/// MATLAB files of level 5.
pub mod mat5;

/// How deep a text nests.
mod nesting;

/// TOML with places.
pub mod toml;

/// Guessing what a misspelt word was meant to be.
pub mod words;

/// When work is to end before its time.
pub mod stop;

/// What a reading found wrong.
pub mod notes;

/// One table handing out typed values.
pub mod fields;
