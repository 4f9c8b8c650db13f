//! Scripts and styles of a page without comments and needless spaces.

/// A script without comments, and with spaces and line ends only where they part words or statements.
///
/// Strings, templates and regular expressions stay as they are. Scripts are those of this folder: a line that ends with an operator, a
/// comma or an opening bracket goes on, and a regular expression follows one of `( , = : [ ! & | ? { } ;` or a line end.
pub fn script(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let (mut rest, mut gap) = (text, Gap::None);
    // For each open brace, whether it is that of a placeholder of a template.
    let mut braces: Vec<bool> = Vec::new();
    while let Some(first) = rest.chars().next() {
        let length = match first {
            ' ' | '\n' => rest.len() - rest.trim_start_matches([' ', '\n']).len(),
            '/' if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
            '"' | '\'' => literal(rest, first),
            '`' => template(rest, &mut braces),
            '}' if braces.pop() == Some(true) => template(rest, &mut braces),
            '/' if out.is_empty() || out.ends_with(BEFORE_EXPRESSION) => literal(rest, '/'),
            c if is_word(c) => rest.find(|c| !is_word(c)).unwrap_or(rest.len()),
            c => c.len_utf8(),
        };
        if first == '{' {
            braces.push(false);
        }
        let (part, after) = rest.split_at(length);
        rest = after;
        match first {
            ' ' | '\n' if part.contains('\n') => gap = Gap::Line,
            ' ' | '\n' => gap = gap.max(Gap::Space),
            '/' if part.starts_with("//") => {}
            _ => {
                let before = out.chars().next_back().unwrap_or('\n');
                out += gap.between(before, first);
                out += part;
                gap = Gap::None;
            }
        }
    }
    out + "\n"
}

/// A style sheet without the spaces about its signs; one rule a line.
pub fn style(text: &str) -> String {
    let signs = ["{", "}", ";", ",", ": "];
    let lines = text.lines().map(str::trim).map(|line| {
        signs.iter().fold(line.to_string(), |line, sign| {
            let bare = sign.trim();
            (line.replace(&format!(" {bare}"), bare)).replace(&format!("{bare} "), bare)
        })
    });
    lines.map(|line| line.replace(";}", "}")).collect()
}

/// Characters that may precede a regular expression but not a division.
const BEFORE_EXPRESSION: &[char] = &[
    '(', ',', '=', ':', '[', '!', '&', '|', '?', '{', '}', ';', '\n',
];

/// Space between two parts of a script.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Gap {
    None,
    Space,
    Line,
}

impl Gap {
    /// The rest of the gap between two characters.
    fn between(self, before: char, after: char) -> &'static str {
        let goes_on = ";{,([\n:?&|=+-*<>".contains(before);
        let is_sign = |c: char| c == '+' || c == '-';
        match self {
            Gap::Line if !goes_on => "\n",
            Gap::None => "",
            _ if is_word(before) && is_word(after) || is_sign(before) && is_sign(after) => " ",
            _ => "",
        }
    }
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_' || c == '$'
}

/// Length of a string or a regular expression with its ends; in brackets of an expression its sign is an ordinary one.
fn literal(text: &str, end: char) -> usize {
    let (mut escaped, mut in_class) = (false, false);
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '[' if end == '/' => in_class = true,
            ']' if end == '/' => in_class = false,
            c if c == end && !in_class => return at + 1,
            _ => {}
        }
    }
    text.len()
}

/// Length of a piece of a template: up to its end or to its next placeholder, which opens a brace.
fn template(text: &str, braces: &mut Vec<bool>) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '`' => return at + 1,
            '$' if text[at..].starts_with("${") => {
                braces.push(true);
                return at + 2;
            }
            _ => {}
        }
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_scripts_keep_their_meaning() {
        let same = [
            ("const a = b - -c; // why\n", "const a=b- -c;\n"),
            ("f(\"a , // b\", 'it''s')\n", "f(\"a , // b\",'it''s')\n"),
            ("let x = y\nlet z", "let x=y\nlet z\n"),
            (
                "`a  ${ { b: `c ${ d } e` }.b }  f` + g",
                "`a  ${{b:`c ${d} e`}.b}  f`+g\n",
            ),
            (
                "x.replace(/[/ ]\\/ \"/g, '') / 2 / 3",
                "x.replace(/[/ ]\\/ \"/g,'')/2/3\n",
            ),
            (
                "if (a) return b;\n  else c();\n",
                "if(a)return b;else c();\n",
            ),
        ];
        for (text, expected) in same {
            assert_eq!(script(text), expected);
        }
    }

    #[test]
    fn exact_styles_keep_their_meaning() {
        let text = "a:hover .b > c { margin: 0 1px; color: var(--x); }\n@media (max-width: 760px) { .v { gap: 0; } }\n";
        let expected =
            "a:hover .b > c{margin:0 1px;color:var(--x)}@media (max-width:760px){.v{gap:0}}";
        assert_eq!(style(text), expected);
    }
}
