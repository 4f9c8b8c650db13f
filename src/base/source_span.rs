//! Source files and spans in them: path, line and column for messages.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// A file's text under the name the user gave it.
#[derive(Debug, PartialEq, Eq)]
pub struct SourceFile {
    /// The name as the user gave it.
    pub path: String,
    /// All of it, or the part that matters of a file too large to keep.
    pub text: String,
    /// The line of the file the text begins on, counted from 1.
    pub first_line: usize,
}

/// An interval of a file. Cheap to clone: the text is shared.
#[derive(Clone, PartialEq, Eq)]
pub struct SourceSpan {
    source: Arc<SourceFile>,
    span: Range<usize>,
}

impl SourceSpan {
    /// Range `span`, in bytes, of `source`; cut to the text where it reaches past it.
    pub fn new(source: Arc<SourceFile>, span: Range<usize>) -> SourceSpan {
        let end = source.text.len();
        let start = span.start.min(end);
        let stop = span.end.clamp(start, end);
        SourceSpan {
            source,
            span: start..stop,
        }
    }

    /// An interval of one line of a file too large to keep: `line` (from 1) has the text `text`, and `span` of it is meant.
    pub fn within_line(path: &str, line: usize, text: &str, span: Range<usize>) -> SourceSpan {
        let source = SourceFile {
            path: path.to_string(),
            text: text.to_string(),
            first_line: line,
        };
        SourceSpan::new(Arc::new(source), span)
    }

    /// A file as a whole.
    pub fn whole_file(path: &str) -> SourceSpan {
        SourceSpan::within_line(path, 1, "", 0..0)
    }

    /// A line, from 1, of a file that is no longer at hand.
    pub fn whole_line(path: &str, line: usize) -> SourceSpan {
        SourceSpan::within_line(path, line, "", 0..0)
    }

    /// It says which file and no line of it.
    pub fn is_whole_file(&self) -> bool {
        self.source.text.is_empty() && self.source.first_line == 1
    }

    /// The file it is in.
    pub fn source(&self) -> &Arc<SourceFile> {
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

impl fmt::Debug for SourceSpan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.source.path, self.line(), self.column())
    }
}
