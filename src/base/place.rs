//! Where in a file something stands.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// A file's text under the name the user gave it.
#[derive(Debug, PartialEq, Eq)]
pub struct Source {
    /// The name as the user gave it.
    pub path: String,
    /// All of it, or the part that matters of a file too large to keep.
    pub text: String,
    /// The line of the file the text begins on, counted from 1.
    pub first_line: usize,
}

/// A stretch of a file. Cheap to clone: the text is shared.
#[derive(Clone, PartialEq, Eq)]
pub struct Place {
    source: Arc<Source>,
    span: Range<usize>,
}

impl Place {
    /// The stretch `span`, in bytes, of `source`; cut to the text where it reaches past it.
    pub fn new(source: Arc<Source>, span: Range<usize>) -> Place {
        let end = source.text.len();
        let start = span.start.min(end);
        let stop = span.end.clamp(start, end);
        Place {
            source,
            span: start..stop,
        }
    }

    /// A stretch of one line of a file too large to keep: `line` (from 1) has the text `text`, and `span` of it is meant.
    pub fn in_line(path: &str, line: usize, text: &str, span: Range<usize>) -> Place {
        let source = Source {
            path: path.to_string(),
            text: text.to_string(),
            first_line: line,
        };
        Place::new(Arc::new(source), span)
    }

    /// A file as a whole.
    pub fn of_file(path: &str) -> Place {
        Place::in_line(path, 1, "", 0..0)
    }

    /// A line, from 1, of a file that is no longer at hand.
    pub fn of_line(path: &str, line: usize) -> Place {
        Place::in_line(path, line, "", 0..0)
    }

    /// It says which file and no line of it.
    pub fn is_whole_file(&self) -> bool {
        self.source.text.is_empty() && self.source.first_line == 1
    }

    /// The file it is in.
    pub fn source(&self) -> &Arc<Source> {
        &self.source
    }

    /// The bytes it covers.
    pub fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// The text it covers.
    pub fn text(&self) -> &str {
        self.source.text.get(self.span.clone()).unwrap_or("")
    }

    /// The line it begins in, counted from 1.
    pub fn line(&self) -> usize {
        self.source.first_line + self.before().bytes().filter(|&b| b == b'\n').count()
    }

    /// The character of the line it begins at, counted from 1.
    pub fn column(&self) -> usize {
        let before = self.before();
        let line = before.rfind('\n').map_or(before, |at| &before[at + 1..]);
        1 + line.chars().count()
    }

    fn before(&self) -> &str {
        self.source.text.get(..self.span.start).unwrap_or("")
    }
}

impl fmt::Debug for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.source.path, self.line(), self.column())
    }
}
