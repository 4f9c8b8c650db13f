//! Standard output and atomic file writing.

use std::io::{self, ErrorKind, IsTerminal, Write};

use serde_json::Value;

use super::interrupt;
use crate::base::code::Code;
use crate::base::error::Error;

/// Prints a result. A reader that has gone away (`| head`) is no error. Names from a file may hold signs that would command a
/// terminal; they are shown as unreadable.
///
/// # Errors
/// Standard output cannot be written for another reason.
pub fn print(text: &str) -> Result<(), Error> {
    let commands = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    let text = text.replace(commands, "\u{fffd}");
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Error::new(
            Code::OutputFailed,
            format!("standard output could not be written: {e}"),
        )),
        _ => Ok(()),
    }
}

/// Prints the one JSON document of a command; an interrupt lets it end.
///
/// # Errors
/// As for [`print()`].
pub fn document(document: &Value) -> Result<(), Error> {
    interrupt::begin_document();
    print(&format!("{document:#}\n"))
}

/// Prints a message on standard error. Where that cannot be written nobody reads it.
pub fn print_note(text: &str) {
    let _ = io::stderr().lock().write_all(text.as_bytes());
}

/// Says on a terminal what is worked at; the next line takes its place.
pub fn show_status(what: &str, quiet: bool) {
    if !quiet && io::stderr().is_terminal() {
        print_note(&format!("\r\x1b[K{what} …\r"));
    }
}
