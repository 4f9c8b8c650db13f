//! Byte cursor over text lines and binary blocks of a UFF file.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::source_span::SourceSpan;

/// The bytes that are left, and which line they start on.
#[derive(Clone)]
pub(super) struct UffCursor<'a> {
    path: &'a str,
    pub rest: &'a [u8],
    /// Line number in the file, from 1.
    pub line: usize,
    /// The last line of the file is ended.
    pub ended: bool,
}

impl<'a> UffCursor<'a> {
    pub fn new(path: &'a str, bytes: &'a [u8]) -> UffCursor<'a> {
        UffCursor {
            path,
            rest: bytes,
            line: 1,
            ended: bytes.ends_with(b"\n") || bytes.ends_with(b"\r"),
        }
    }

    /// An error at a line with this text.
    pub fn error(&self, line: usize, text: &str, message: impl Into<String>) -> Error {
        let span = SourceSpan::within_line(self.path, line, text, 0..0);
        Error::new(Code::CorruptFile, message).with_span(&span)
    }

    /// An error at the next line.
    pub fn error_here(&self, message: impl Into<String>) -> Error {
        /// Bytes of a line shown; what should be text may be binary.
        const SHOWN: usize = 200;
        let line = self.peek();
        let text = String::from_utf8_lossy(&line[..line.len().min(SHOWN)]);
        self.error(self.line, &text, message)
    }

    /// The next line without its end; `None` at the end of the file.
    pub fn next_line(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let line = self.peek();
        let end = memchr::memchr(b'\n', self.rest).map_or(self.rest.len(), |at| at + 1);
        self.rest = &self.rest[end..];
        self.line += 1;
        Some(line)
    }

    /// The next line without its end, not taken.
    pub fn peek(&self) -> &'a [u8] {
        let end = memchr::memchr(b'\n', self.rest).unwrap_or(self.rest.len());
        self.rest[..end].trim_ascii_end()
    }

    /// Takes blanks and line ends.
    pub fn skip_blank(&mut self) {
        let blank = self.rest.iter().position(|b| !b.is_ascii_whitespace());
        let (blank, rest) = self.rest.split_at(blank.unwrap_or(self.rest.len()));
        self.line += memchr::memchr_iter(b'\n', blank).count();
        self.rest = rest;
    }

    /// Takes lines up to the next mark `-1`, which is not taken; whether there is one.
    pub fn skip_to_delimiter(&mut self) -> bool {
        while !self.rest.is_empty() {
            if is_delimiter(self.peek()) {
                return true;
            }
            self.next_line();
        }
        false
    }
}

/// A line that begins or ends a data set: `-1` alone.
pub(super) fn is_delimiter(line: &[u8]) -> bool {
    line.trim_ascii() == b"-1"
}
