//! The command: the only place that touches the terminal.

/// Errors and warnings as text and as JSON.
pub mod diagnostic;
