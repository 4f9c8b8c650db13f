//! Renders errors and diagnostics for the terminal and as JSON.

use std::io::IsTerminal;

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{
    AnnotationKind, Group, Level, Origin, Renderer, Snippet, normalize_untrusted_str,
};
use serde_json::{Value, json};

use crate::base::error::{Diagnostic, Error, Errors};
use crate::base::source_span::SourceSpan;

/// Errors shown at length; the rest are counted.
const SHOWN: usize = 3;

/// Mark in place of the omitted part of a long line.
const ELLIPSIS: char = '…';

/// Errors listed in JSON; beyond that a file is not a model.
const MAX_JSON_ERRORS: usize = 1000;

/// Colour suits standard error: it is a terminal and `NO_COLOR` is not set.
pub fn use_colour() -> bool {
    let plain = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty())
        || std::env::var_os("TERM").is_some_and(|value| value == "dumb");
    !plain && std::io::stderr().is_terminal()
}

/// Text from a file as a terminal may show it: control characters would command it.
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

/// The first errors of a file at length, and how many more there are; ends in a line break.
pub fn render_errors(errors: &Errors, coloured: bool) -> String {
    let list = errors.as_slice();
    let shown: Vec<String> = list
        .iter()
        .take(SHOWN)
        .map(|e| render_error(e, coloured))
        .collect();
    let more = match list.len().saturating_sub(SHOWN) {
        0 => String::new(),
        1 => "\nand 1 more error\n".to_string(),
        more => format!("\nand {more} more errors\n"),
    };
    shown.join("\n") + &more
}

/// One error with its source line; ends in a line break.
pub fn render_error(error: &Error, coloured: bool) -> String {
    let title = format!("{} [{}]", sanitise(&error.message), error.code.as_str());
    let label = error.label.as_deref().map(normalize_untrusted_str);
    let window = error
        .span
        .as_ref()
        .filter(|span| !span.is_whole_file())
        .map(Excerpt::from_span);
    let mut group = Level::ERROR
        .primary_title(normalize_untrusted_str(&title))
        .elements(Vec::<Snippet<'_, annotate_snippets::Annotation<'_>>>::new());
    if let Some(window) = &window {
        let mark = AnnotationKind::Primary.span(window.mark.clone());
        let mark = match label {
            Some(label) => mark.label(label),
            None => mark,
        };
        let snippet = Snippet::source(window.text.as_str())
            .line_start(window.line)
            .annotation(mark);
        group = if window.text.is_empty() {
            group.element(Origin::path(window.path.as_str()).line(window.line))
        } else if window.text.starts_with(ELLIPSIS) {
            let origin = Origin::path(window.path.as_str())
                .line(window.line)
                .char_column(window.column);
            group.element(origin).element(snippet)
        } else {
            group.element(snippet.path(window.path.as_str()))
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

/// One warning; ends in a line break.
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

/// The part of a line shown around a place.
struct Excerpt {
    path: String,
    line: usize,
    column: usize,
    text: String,
    mark: std::ops::Range<usize>,
}

impl Excerpt {
    /// Characters kept before the place and from it on.
    const BEFORE: usize = 60;
    const AFTER: usize = 80;

    fn from_span(place: &SourceSpan) -> Excerpt {
        let all = place.source().text.as_str();
        let span = place.span();
        let (before, after) = all.split_at(span.start.min(all.len()));
        let start = before.rfind('\n').map_or(0, |at| at + 1);
        let stop = after.find(['\n', '\r']).unwrap_or(after.len());
        let (before, after) = (&before[start..], &after[..stop]);
        let cut = before
            .char_indices()
            .rev()
            .nth(Self::BEFORE)
            .map(|(at, _)| at);
        let end = after.char_indices().nth(Self::AFTER).map(|(at, _)| at);
        let head = cut.map_or(before.to_string(), |at| {
            format!("{ELLIPSIS}{}", &before[at..])
        });
        let tail = end.map_or(after.to_string(), |at| {
            format!("{}{ELLIPSIS}", &after[..at])
        });
        let marked = (span.end - span.start).min(end.unwrap_or(after.len()));
        Excerpt {
            path: normalize_untrusted_str(&place.source().path),
            line: place.line(),
            column: place.column(),
            mark: head.len()..head.len() + marked,
            text: head + &tail,
        }
    }
}

/// The line of an error; absent if it concerns the file as a whole.
fn line(error: &Error) -> Option<usize> {
    let span = error.span.as_ref().filter(|p| !p.is_whole_file());
    span.map(SourceSpan::line)
}

/// The file of an error that names no line, where its message does not name the file.
fn unnamed_file(error: &Error) -> Option<&str> {
    let path = error.span.as_ref()?.source().path.as_str();
    (!error.message.contains(path)).then_some(path)
}

/// `{"errors": [{code, message, file, line, hint}]}`; what an error does not have is null.
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
        let found = read_text("models/gearbox.toml", text).unwrap_err();
        let shown = render_errors(&found, false);
        let expected = "\
error: unknown key `stifness` [unknown-key]
 --> models/gearbox.toml:7:1
  |
7 | stifness = \"85 kN·m/rad\"
  | ^^^^^^^^ in [[shaft]] \"s\"
hint: did you mean `k`? it takes N·m/rad, kN·m/rad, N·m/deg
";
        assert_eq!(shown, expected);
        assert!(render_errors(&found, true).contains("\u{1b}["));
        let json = json(&found);
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
            let found = read_text("long.toml", &text).unwrap_err();
            let shown = render_errors(&found, false);
            assert!(shown.len() < 4000, "{} bytes", shown.len());
            assert!(json(&found).to_string().len() < 4000);
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
        let doubt = Diagnostic {
            code: "no-load",
            message: "no load\u{1b}[31m".into(),
            hint: Some("add a [[load]]".into()),
        };
        let shown = render_diagnostic(&doubt, false);
        assert!(shown.starts_with("warning: no load"), "{shown}");
        assert!(
            shown.ends_with("[no-load]\nhint: add a [[load]]\n"),
            "{shown}"
        );
        assert!(!shown.contains('\u{1b}'));
    }
}
