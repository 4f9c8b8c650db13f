//! Rendering of errors and diagnostics for the terminal and as JSON.

use std::io::IsTerminal;

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{
    AnnotationKind, Group, Level, Origin, Renderer, Snippet, normalize_untrusted_str,
};
use serde_json::{Value, json};

use crate::base::error::{Diagnostic, Error, Errors};
use crate::base::source_span::SourceSpan;

/// Number of errors rendered in full; the others are counted.
const MAX_RENDERED: usize = 3;

/// Mark for the omitted part of a long line.
const ELLIPSIS: char = '…';

/// Maximum number of errors in JSON; a file with more is not a model.
const MAX_JSON_ERRORS: usize = 1000;

/// Whether standard error is a terminal with colour: `NO_COLOR` is not set and `TERM` is not `dumb`.
pub fn use_colour() -> bool {
    let plain = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty())
        || std::env::var_os("TERM").is_some_and(|value| value == "dumb");
    !plain && std::io::stderr().is_terminal()
}

/// Replaces control characters in text from a file, which could control the terminal.
pub fn sanitise(text: &str) -> String {
    text.chars()
        .map(|c| {
            if c.is_control() {
                char::REPLACEMENT_CHARACTER
            } else {
                c
            }
        })
        .collect()
}

/// Renders the first errors of a file in full and the number of the others; ends in a line break.
pub fn render_errors(errors: &Errors, coloured: bool) -> String {
    let list = errors.as_slice();
    let rendered: Vec<String> = list
        .iter()
        .take(MAX_RENDERED)
        .map(|e| render_error(e, coloured))
        .collect();
    let more = match list.len().saturating_sub(MAX_RENDERED) {
        0 => String::new(),
        1 => "\nand 1 more error\n".to_string(),
        more => format!("\nand {more} more errors\n"),
    };
    rendered.join("\n") + &more
}

/// Renders an error with its source line; ends in a line break.
pub fn render_error(error: &Error, coloured: bool) -> String {
    let title = format!("{} [{}]", sanitise(&error.message), error.code.as_str());
    let label = error.label.as_deref().map(normalize_untrusted_str);
    let excerpt = error
        .span
        .as_ref()
        .filter(|span| !span.is_whole_file())
        .map(Excerpt::from_span);
    let mut group = Level::ERROR
        .primary_title(normalize_untrusted_str(&title))
        .elements(Vec::<Snippet<'_, annotate_snippets::Annotation<'_>>>::new());
    if let Some(excerpt) = &excerpt {
        let mark = AnnotationKind::Primary.span(excerpt.mark.clone());
        let mark = match label {
            Some(label) => mark.label(label),
            None => mark,
        };
        let snippet = Snippet::source(excerpt.text.as_str())
            .line_start(excerpt.line)
            .annotation(mark);
        group = if excerpt.text.is_empty() {
            group.element(Origin::path(excerpt.path.as_str()).line(excerpt.line))
        } else if excerpt.text.starts_with(ELLIPSIS) {
            let origin = Origin::path(excerpt.path.as_str())
                .line(excerpt.line)
                .char_column(excerpt.column);
            group.element(origin).element(snippet)
        } else {
            group.element(snippet.path(excerpt.path.as_str()))
        };
    } else if let Some(path) = unnamed_file(error) {
        let path = normalize_untrusted_str(path);
        return print(
            group.element(Origin::path(path)),
            error.hint.as_deref(),
            coloured,
        );
    }
    print(group, error.hint.as_deref(), coloured)
}

/// Renders a warning; ends in a line break.
pub fn render_diagnostic(diagnostic: &Diagnostic, coloured: bool) -> String {
    let title = format!("{} [{}]", sanitise(&diagnostic.message), diagnostic.code);
    let title = Level::WARNING.primary_title(normalize_untrusted_str(&title));
    print(
        Group::with_title(title),
        diagnostic.hint.as_deref(),
        coloured,
    )
}

fn print(group: Group<'_>, hint: Option<&str>, coloured: bool) -> String {
    const WIDTH: usize = 160;
    let renderer = if coloured {
        Renderer::styled()
    } else {
        Renderer::plain()
    };
    let renderer = renderer.decor_style(DecorStyle::Ascii).term_width(WIDTH);
    let mut text = renderer.render(&[group]) + "\n";
    if let Some(hint) = hint {
        let hint = normalize_untrusted_str(hint);
        let hint = Level::HELP.with_name("hint").primary_title(hint);
        text += &renderer.render(&[Group::with_title(hint)]);
        text += "\n";
    }
    text
}

/// Part of a source line around a span.
struct Excerpt {
    path: String,
    line: usize,
    column: usize,
    text: String,
    mark: std::ops::Range<usize>,
}

impl Excerpt {
    /// Maximum number of characters before the start of the span and from it on.
    const BEFORE: usize = 60;
    const AFTER: usize = 80;

    fn from_span(span: &SourceSpan) -> Excerpt {
        let source = span.source().text.as_str();
        let range = span.span();
        let (before, after) = source.split_at(range.start.min(source.len()));
        let start = before.rfind('\n').map_or(0, |i| i + 1);
        let line_end = after.find(['\n', '\r']).unwrap_or(after.len());
        let (before, after) = (&before[start..], &after[..line_end]);
        let cut = before
            .char_indices()
            .rev()
            .nth(Self::BEFORE)
            .map(|(i, _)| i);
        let end = after.char_indices().nth(Self::AFTER).map(|(i, _)| i);
        let head = cut.map_or(before.to_string(), |i| {
            format!("{ELLIPSIS}{}", &before[i..])
        });
        let tail = end.map_or(after.to_string(), |i| format!("{}{ELLIPSIS}", &after[..i]));
        let marked = (range.end - range.start).min(end.unwrap_or(after.len()));
        Excerpt {
            path: normalize_untrusted_str(&span.source().path),
            line: span.line(),
            column: span.column(),
            mark: head.len()..head.len() + marked,
            text: head + &tail,
        }
    }
}

/// Line number of an error; `None` if the error concerns the whole file.
fn line(error: &Error) -> Option<usize> {
    let span = error.span.as_ref().filter(|p| !p.is_whole_file());
    span.map(SourceSpan::line)
}

/// Path of the file of an error, unless the message contains it.
fn unnamed_file(error: &Error) -> Option<&str> {
    let path = error.span.as_ref()?.source().path.as_str();
    (!error.message.contains(path)).then_some(path)
}

/// Errors as `{"errors": [{code, message, file, line, hint}]}`; absent values are null.
pub fn json(errors: &Errors) -> Value {
    let list: Vec<Value> = errors
        .as_slice()
        .iter()
        .take(MAX_JSON_ERRORS)
        .map(|error| {
            json!({
                "code": error.code.as_str(),
                "message": error.message,
                "file": error.span.as_ref().map(|span| span.source().path.clone()),
                "line": line(error),
                "hint": error.hint,
            })
        })
        .collect();
    json!({ "errors": list })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::code::Code;
    use crate::scene::read_text;

    #[test]
    fn exact_look_of_an_error() {
        let text = "[[inertia]]\nname = \"a\"\nJ = \"1 kg·m²\"\n[[shaft]]\nname = \"s\"\nbetween = [\"a\", \"ground\"]\nstifness = \"85 kN·m/rad\"\n";
        let errors = read_text("models/gearbox.toml", text).unwrap_err();
        let shown = render_errors(&errors, false);
        let expected = "\
error: unknown key `stifness` [unknown-key]
 --> models/gearbox.toml:7:1
  |
7 | stifness = \"85 kN·m/rad\"
  | ^^^^^^^^ in [[shaft]] \"s\"
hint: did you mean `k`? it takes N·m/rad, kN·m/rad, N·m/deg
";
        assert_eq!(shown, expected);
        assert!(render_errors(&errors, true).contains("\u{1b}["));
        let json = json(&errors);
        assert_eq!(json["errors"][0]["code"], "unknown-key");
        assert_eq!(json["errors"][0]["line"], 7);
        assert_eq!(json["errors"][0]["file"], "models/gearbox.toml");
    }

    #[test]
    fn survives_a_line_of_ten_megabytes() {
        let long = "µ".repeat(5_000_000);
        for text in [
            format!("title = \"{long}\" x"),
            format!("units = \"{long}\""),
            format!("{long} = 1"),
            format!("\"{long}\" = 1"),
            format!("[[inertia]]\nname = \"a\"\nJ = \"{long}\"\n{long}"),
        ] {
            let errors = read_text("long.toml", &text).unwrap_err();
            let shown = render_errors(&errors, false);
            assert!(shown.len() < 4000, "{} bytes", shown.len());
            assert!(json(&errors).to_string().len() < 4000);
        }
    }

    #[test]
    fn exact_three_first_errors_and_a_count() {
        let text = "a = 1\nb = 2\nc = 3\nd = 4\n";
        let shown = render_errors(&read_text("m.toml", text).unwrap_err(), false);
        assert_eq!(shown.matches("error: ").count(), 3, "{shown}");
        assert!(shown.ends_with("and 1 more error\n"), "{shown}");
    }

    #[test]
    fn exact_look_without_a_place() {
        let error = Error::new(Code::BudgetExceeded, "1e9 modes need 8 EB");
        assert_eq!(
            render_error(&error, false),
            "error: 1e9 modes need 8 EB [budget-exceeded]\n"
        );
        let warning = Diagnostic {
            code: "no-load",
            message: "no load\u{1b}[31m".into(),
            hint: Some("add a [[load]]".into()),
        };
        let shown = render_diagnostic(&warning, false);
        assert!(shown.starts_with("warning: no load"), "{shown}");
        assert!(
            shown.ends_with("[no-load]\nhint: add a [[load]]\n"),
            "{shown}"
        );
        assert!(!shown.contains('\u{1b}'));
    }
}
