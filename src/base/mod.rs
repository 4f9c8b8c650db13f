//! Errors with places and hints, units, and the reading of TOML with places.

pub mod source_span;

pub mod code;

pub mod diagnostic;

pub mod error;

pub mod quantity_kind;

mod unit_expression;

pub mod quantity;

pub mod bound;

pub mod load;

pub mod mat5;

mod nesting;

pub mod toml;

pub mod text;

pub mod time_budget;

pub mod error_collector;

pub mod table_reader;

pub mod flags;

pub mod tables;
