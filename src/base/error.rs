//! Errors with source span, label and hint; diagnostics that accompany a result.

use std::fmt;

use super::code::Code;
use super::source_span::SourceSpan;

/// One thing that is wrong with the input, or one computation that failed.
#[derive(Debug, Clone)]
pub struct Error {
    /// The word `geardyn explain` takes.
    pub code: Code,
    /// Statement of the error, with the values and their units; one sentence, no full stop.
    pub message: String,
    /// Place in the user's file.
    pub span: Option<SourceSpan>,
    /// Text next to the caret.
    pub label: Option<String>,
    /// Remedy, in the imperative.
    pub hint: Option<String>,
    /// Key of the input that holds the value, `rack.dedendum` or `gear.teeth`: where no place is known, the reader of the file finds it.
    pub key: Option<Box<str>>,
}

impl Error {
    /// Sorts by file and place, those without a place last.
    fn sort_key(&self) -> (bool, Option<&str>, usize) {
        let span = self.span.as_ref();
        let path = span.map(|p| p.source().path.as_str());
        (span.is_none(), path, span.map_or(0, |p| p.span().start))
    }

    /// An error without a place.
    pub fn new(code: Code, message: impl Into<String>) -> Error {
        Error {
            code,
            message: message.into(),
            span: None,
            label: None,
            hint: None,
            key: None,
        }
    }

    /// The same error, of the value of a key; one that names a key keeps it.
    pub fn about(mut self, key: &str) -> Error {
        self.key.get_or_insert_with(|| key.into());
        self
    }

    /// The same error, of the part `part` of the input: its key becomes `part.key`, and the message names the part.
    pub fn in_part(mut self, part: &str) -> Error {
        self.key = Some(match self.key {
            Some(key) => format!("{part}.{key}").into(),
            None => part.into(),
        });
        self.message = format!("{part}: {}", self.message);
        self
    }

    /// The same error, pointing at `span`.
    pub fn with_span(mut self, span: &SourceSpan) -> Error {
        self.span = Some(span.clone());
        self
    }

    /// The same error, assigned to a file where it has no place in one.
    pub fn with_file(mut self, path: &str) -> Error {
        self.span
            .get_or_insert_with(|| SourceSpan::whole_file(path));
        self
    }

    /// The same error with a word next to the caret.
    pub fn with_label(mut self, label: impl Into<String>) -> Error {
        self.label = Some(label.into());
        self
    }

    /// The same error with advice.
    pub fn with_hint(mut self, hint: impl Into<String>) -> Error {
        self.hint = Some(hint.into());
        self
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.span {
            Some(span) if span.is_whole_file() => write!(f, "{}: ", span.source().path)?,
            Some(span) => {
                let (path, line, column) = (&span.source().path, span.line(), span.column());
                write!(f, "{path}:{line}:{column}: ")?;
            }
            None => {}
        }
        write!(f, "{} [{}]", self.message, self.code.as_str())?;
        match &self.hint {
            Some(hint) => write!(f, " (hint: {hint})"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for Error {}

/// Every error of one file, sorted by place; never empty.
#[derive(Debug, Clone)]
pub struct Errors(Vec<Error>);

impl Errors {
    /// `Ok(value)` where nothing is wrong, else all that is, sorted by place.
    pub fn into_result<T>(mut errors: Vec<Error>, value: impl FnOnce() -> T) -> Result<T, Errors> {
        if errors.is_empty() {
            return Ok(value());
        }
        errors.sort_by(|a, b| Error::sort_key(a).cmp(&Error::sort_key(b)));
        Err(Errors(errors))
    }

    /// The same errors, assigned to a file where they have no place in one.
    pub fn with_file(self, path: &str) -> Errors {
        Errors(self.0.into_iter().map(|e| e.with_file(path)).collect())
    }

    /// The errors, the first in the file first.
    pub fn as_slice(&self) -> &[Error] {
        &self.0
    }
}

impl From<Error> for Errors {
    fn from(error: Error) -> Errors {
        Errors(vec![error])
    }
}

impl fmt::Display for Errors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, error) in self.0.iter().enumerate() {
            write!(f, "{}{error}", if at == 0 { "" } else { "\n" })?;
        }
        Ok(())
    }
}

impl std::error::Error for Errors {}

/// Diagnostic of a result: the result remains valid, and the warning is reported with it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// A word, as with errors.
    pub code: &'static str,
    /// Statement of the warning.
    pub message: String,
    /// Remedy that would settle the warning.
    pub hint: Option<String>,
}
