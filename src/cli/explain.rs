//! `geardyn explain`: an error code at length.

use super::output;
use crate::base::code::Code;
use crate::base::error::Error;

/// Explains one code, or lists all.
///
/// # Errors
/// No such code.
pub fn run(word: Option<&str>) -> Result<u8, Error> {
    let text = match word {
        None => Code::ALL
            .iter()
            .map(|code| {
                format!(
                    "{:<22} {}\n",
                    code.word(),
                    first_sentence(code.explanation())
                )
            })
            .collect(),
        Some(word) => {
            let code = Code::from_word(word).ok_or_else(|| unknown(word))?;
            format!(
                "{}\n\n{}\n\nexit code {}\n",
                code.word(),
                code.explanation(),
                code.exit()
            )
        }
    };
    output::print(&text)?;
    Ok(0)
}

fn first_sentence(text: &str) -> &str {
    text.find(". ").map_or(text, |at| &text[..=at])
}

fn unknown(word: &str) -> Error {
    let near = Code::ALL
        .iter()
        .map(|code| code.word())
        .max_by(|a, b| strsim::jaro_winkler(a, word).total_cmp(&strsim::jaro_winkler(b, word)));
    let hint = match near {
        Some(near) if strsim::jaro_winkler(near, word) > 0.75 => {
            format!("did you mean `{near}`? `geardyn explain` lists all")
        }
        _ => "`geardyn explain` lists all".to_string(),
    };
    Error::new(Code::Usage, format!("there is no error code `{word}`")).hint(hint)
}
