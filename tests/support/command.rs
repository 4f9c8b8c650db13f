//! The command as a test calls it: from the project's folder, without colours.
#![allow(dead_code, reason = "each test file uses its part")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// Runs `geardyn`.
pub fn geardyn(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_geardyn"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .env("NO_COLOR", "1")
        .output()
        .unwrap()
}

/// How it ends, and what it says on standard output and beside it.
pub fn said(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = geardyn(arguments);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (
        output.status.code(),
        text(&output.stdout),
        text(&output.stderr),
    )
}

/// What it prints, which must be JSON, however it ends.
pub fn printed(arguments: &[&str]) -> Value {
    let output = geardyn(arguments);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| {
        let said = String::from_utf8_lossy(&output.stderr);
        panic!("{arguments:?}: {e}\n{said}")
    })
}

/// What it prints, which must be JSON, and end with 0.
pub fn document(arguments: &[&str]) -> Value {
    let output = geardyn(arguments);
    let text = String::from_utf8(output.stdout).unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}\n{text}{said}");
    serde_json::from_str(&text).unwrap()
}

/// Code and message of the first error, which must end the command with 2 and carry a hint.
pub fn refusal(arguments: &[&str]) -> (String, String) {
    let output = geardyn(&[arguments, &["--json"]].concat());
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}\n{text}");
    let found: Value = serde_json::from_str(&text).unwrap();
    let first = &found["errors"][0];
    assert!(first["hint"].is_string(), "{first}");
    let word = |key: &str| first[key].as_str().unwrap().to_string();
    (word("code"), word("message"))
}

/// A file in a folder.
pub fn put(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// A text with one to three of its digits changed, removed or joined by another sign, by the seed of `fastrand`.
pub fn with_other_digits(text: &str) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..fastrand::usize(1..4) {
        let digits: Vec<usize> = (0..bytes.len())
            .filter(|i| bytes[*i].is_ascii_digit())
            .collect();
        let at = digits[fastrand::usize(..digits.len())];
        match fastrand::u8(..4) {
            0 => bytes[at] = b'0' + fastrand::u8(..10),
            1 => drop(bytes.remove(at)),
            2 => bytes.insert(at, b"0123456789-.e"[fastrand::usize(..13)]),
            _ => bytes[at] = b'-',
        }
    }
    String::from_utf8(bytes).unwrap_or_default()
}
