//! Reads a file as UTF-8 text; rejects folders, pipes and files above 64 MB first.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use super::code::Code;
use super::error::Error;
use super::source_span::{SourceFile, SourceSpan};

/// The largest file read, in bytes.
pub const MAX_FILE_BYTES: u64 = 64 << 20;

/// The text of a file, refused before it is read where it cannot be a model.
pub fn load(path: &Path) -> Result<Arc<SourceFile>, Error> {
    let name = path.display().to_string();
    let span = SourceSpan::whole_file(&name);
    let refuse = |code, message: String, hint: &str| {
        Error::new(code, message).with_span(&span).with_hint(hint)
    };
    let missing = |e: std::io::Error| {
        let hint = "paths are relative to the working folder";
        refuse(
            Code::FileMissing,
            format!("{name} cannot be read: {e}"),
            hint,
        )
    };
    let facts = fs::metadata(path).map_err(missing)?;
    if !facts.is_file() {
        let what = if facts.is_dir() {
            "is a folder"
        } else {
            "is a device or a pipe"
        };
        let message = format!("{name} {what}, not a file");
        return Err(refuse(
            Code::FileMissing,
            message,
            "name a model or scene file",
        ));
    }
    if facts.len() > MAX_FILE_BYTES {
        let mega = facts.len() >> 20;
        let message = format!("{name} has {mega} MB; model files are limited to 64 MB");
        let hint = "read logs by `geardyn identify` or `geardyn spectrum`";
        return Err(refuse(Code::FileTooLarge, message, hint));
    }
    let bytes = fs::read(path).map_err(missing)?;
    decode(name.clone(), bytes)
}

/// Bytes as text; a byte-order mark is taken off.
pub fn decode(path: String, bytes: Vec<u8>) -> Result<Arc<SourceFile>, Error> {
    match String::from_utf8(bytes) {
        Ok(text) => Ok(source_from_text(path, &text)),
        Err(error) => {
            let at = error.utf8_error().valid_up_to();
            let bytes = error.into_bytes();
            let (good, bad) = bytes.split_at(at);
            let byte = bad.first().copied().unwrap_or_default();
            let good = String::from_utf8_lossy(good).into_owned();
            let span = SourceSpan::new(source_from_text(path, &good), good.len()..good.len());
            Err(Error::new(
                Code::NotText,
                format!(
                    "byte {at} ({byte:#04x}, line {}) is not UTF-8 text",
                    span.line()
                ),
            )
            .with_span(&span)
            .with_hint("save the file as UTF-8 in your editor"))
        }
    }
}

/// A text under the name `path`; a byte-order mark is taken off.
pub fn source_from_text(path: String, text: &str) -> Arc<SourceFile> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text).to_string();
    Arc::new(SourceFile {
        path,
        text,
        first_line: 1,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_what_is_not_utf8() {
        let error = decode("m.toml".into(), b"a = 1\nb = \"\xb5m\"".to_vec()).unwrap_err();
        assert_eq!(error.code, Code::NotText);
        assert_eq!(error.message, "byte 11 (0xb5, line 2) is not UTF-8 text");
        assert_eq!(error.span.unwrap().line(), 2);
    }
}
