//! Errors with source span, label and hint; diagnostics that accompany a result.

use std::fmt;

use super::code::Code;
use super::source_span::SourceSpan;

/// An error in the input or a failed computation, with its place and remedy.
#[derive(Debug, Clone)]
pub struct Error {
    /// Error code, an argument of `geardyn explain`.
    pub code: Code,
    /// Statement of the error, with the values and their units; one sentence, no full stop.
    pub message: String,
    /// Place in the user's file.
    pub span: Option<SourceSpan>,
    /// Text next to the caret.
    pub label: Option<String>,
    /// Remedy, in the imperative.
    pub hint: Option<String>,
    /// Key of the input that holds the value, such as `rack.dedendum` or `gear.teeth`; without a span, the file reader locates the key.
    pub key: Option<Box<str>>,
}

impl Error {
    /// Sort key: errors without a span last, then file and byte offset.
    fn sort_key(&self) -> (bool, Option<&str>, usize) {
        let span = self.span.as_ref();
        let path = span.map(|s| s.source().path.as_str());
        (span.is_none(), path, span.map_or(0, |s| s.span().start))
    }

    /// Creates an error without span, label, hint and key.
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

    /// Sets the key of the input, unless one is set.
    pub fn with_key(mut self, key: &str) -> Error {
        self.key.get_or_insert_with(|| key.into());
        self
    }

    /// Prefixes the key with `part.` and the message with `part: `; without a key, `part` becomes the key.
    pub fn with_part(mut self, part: &str) -> Error {
        self.key = Some(match self.key {
            Some(key) => format!("{part}.{key}").into(),
            None => part.into(),
        });
        self.message = format!("{part}: {}", self.message);
        self
    }

    /// Sets the place in the user's file.
    pub fn with_span(mut self, span: &SourceSpan) -> Error {
        self.span = Some(span.clone());
        self
    }

    /// Sets the span to the whole file at `path`, unless a span is set.
    pub fn with_file(mut self, path: &str) -> Error {
        self.span
            .get_or_insert_with(|| SourceSpan::whole_file(path));
        self
    }

    /// Sets the text next to the caret.
    pub fn with_label(mut self, label: impl Into<String>) -> Error {
        self.label = Some(label.into());
        self
    }

    /// Sets the remedy.
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

/// The errors of one file, sorted by place; never empty.
#[derive(Debug, Clone)]
pub struct Errors(Vec<Error>);

impl Errors {
    /// Returns `Ok(value())` if `errors` is empty, else the errors sorted by place.
    pub fn into_result<T>(mut errors: Vec<Error>, value: impl FnOnce() -> T) -> Result<T, Errors> {
        if errors.is_empty() {
            return Ok(value());
        }
        errors.sort_by(|a, b| Error::sort_key(a).cmp(&Error::sort_key(b)));
        Err(Errors(errors))
    }

    /// Sets the span of every error without one to the whole file at `path`.
    pub fn with_file(self, path: &str) -> Errors {
        Errors(self.0.into_iter().map(|e| e.with_file(path)).collect())
    }

    /// Errors in the order of their places.
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
        for (index, error) in self.0.iter().enumerate() {
            write!(f, "{}{error}", if index == 0 { "" } else { "\n" })?;
        }
        Ok(())
    }
}

impl std::error::Error for Errors {}

/// Diagnostic of a result: the result remains valid, and the warning is reported with it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// Diagnostic code, an argument of `geardyn explain`.
    pub code: &'static str,
    /// Statement of the warning.
    pub message: String,
    /// Remedy, in the imperative.
    pub hint: Option<String>,
}
