//! A file of text lines and binary stretches, read from front to back.

/// The bytes that are left, and which line they start on.
#[derive(Clone)]
pub(super) struct Cursor<'a> {
    pub rest: &'a [u8],
    /// Of the file, from 1.
    pub line: usize,
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8]) -> Cursor<'a> {
        Cursor {
            rest: bytes,
            line: 1,
        }
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
    pub fn skip_to_mark(&mut self) -> bool {
        while !self.rest.is_empty() {
            if is_mark(self.peek()) {
                return true;
            }
            self.next_line();
        }
        false
    }
}

/// A line that begins or ends a data set: `-1` alone.
pub(super) fn is_mark(line: &[u8]) -> bool {
    line.trim_ascii() == b"-1"
}
