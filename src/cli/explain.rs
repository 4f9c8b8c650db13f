//! `geardyn explain`: the full text of an error, warning or repair code.

use super::output;
use crate::base::code::Code;
use crate::base::diagnostic::{self, DiagnosticKind};
use crate::base::error::Error;

/// Explains one word, or lists all.
///
/// # Errors
/// No such word.
pub fn run(word: Option<&str>) -> Result<u8, Error> {
    let all = catalogue();
    let text = match word {
        None => all
            .iter()
            .map(|(word, text, _)| format!("{word:<24} {}\n", first_sentence(text)))
            .collect(),
        Some(word) => {
            // One word may be an error, and a warning where an answer is still possible.
            let found = all.iter().filter(|(known, ..)| *known == word);
            let texts: Vec<String> = found
                .map(|(_, text, kind)| format!("{text}\n\n{kind}\n"))
                .collect();
            if texts.is_empty() {
                return Err(unknown(word, &all));
            }
            format!("{word}\n\n{}", texts.join("\n"))
        }
    };
    output::print(&text)?;
    Ok(0)
}

/// Every word, its explanation, and what it ends: errors first.
fn catalogue() -> Vec<(&'static str, &'static str, String)> {
    let errors = Code::ALL.iter().map(|code| {
        let kind = format!("exit code {}", code.exit_code());
        (code.as_str(), code.explanation(), kind)
    });
    let diagnostics = diagnostic::DIAGNOSTICS.iter().map(|(word, sort, text)| {
        let kind = match sort {
            DiagnosticKind::Warning => "a warning with the result; the exit code stays 0",
            DiagnosticKind::Repair => "what was done to a log: the exit code stays 0",
        };
        (*word, *text, kind.to_string())
    });
    errors.chain(diagnostics).collect()
}

fn first_sentence(text: &str) -> &str {
    text.find(". ").map_or(text, |at| &text[..=at])
}

fn unknown(word: &str, all: &[(&str, &str, String)]) -> Error {
    let near = all
        .iter()
        .map(|(known, ..)| *known)
        .max_by(|a, b| strsim::jaro_winkler(a, word).total_cmp(&strsim::jaro_winkler(b, word)));
    let hint = match near {
        Some(near) if strsim::jaro_winkler(near, word) > 0.75 => {
            format!("did you mean `{near}`? `geardyn explain` lists all")
        }
        _ => "`geardyn explain` lists all".to_string(),
    };
    Error::new(
        Code::Usage,
        format!("there is no error, warning or repair `{word}`"),
    )
    .with_hint(hint)
}
