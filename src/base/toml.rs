//! TOML parsed to a tree in which every key and value has its source span.
//!
//! The only file that names the `toml` crate.

use std::ops::Range;
use std::sync::Arc;

use toml::de::{DeTable, DeValue};

use super::code::Code;
use super::error::Error;
use super::nesting::{MAX_DEPTH, find_excess_depth};
use super::source_span::{SourceFile, SourceSpan};

/// One value of a file.
#[derive(Debug, Clone)]
pub struct Item {
    /// Value.
    pub value: Value,
    /// Place in the file.
    pub span: SourceSpan,
}

/// Contents of a value.
#[derive(Debug, Clone)]
pub enum Value {
    /// Text in quotes.
    String(String),
    /// A whole number.
    Integer(i64),
    /// Any other number; infinite where it is beyond all numbers.
    Float(f64),
    /// `true` or `false`.
    Bool(bool),
    /// A date or a time of day.
    Date,
    /// A list.
    List(Vec<Item>),
    /// A table.
    Table(Table),
}

impl Value {
    /// Name of the type in messages.
    pub fn name(&self) -> &'static str {
        match self {
            Value::String(_) => "text",
            Value::Integer(_) | Value::Float(_) => "a number",
            Value::Bool(_) => "true or false",
            Value::Date => "a date",
            Value::List(_) => "a list",
            Value::Table(_) => "a table",
        }
    }
}

/// Keys and values in the order they are written.
#[derive(Debug, Clone, Default)]
pub struct Table {
    /// The entries.
    pub entries: Vec<Entry>,
}

/// One line of a table.
#[derive(Debug, Clone)]
pub struct Entry {
    /// The key.
    pub key: String,
    /// Place of the key.
    pub key_place: SourceSpan,
    /// The value.
    pub item: Item,
}

impl Table {
    /// The entry of `key`.
    pub fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }

    /// The table under `key`, with its place.
    pub fn table(&self, key: &str) -> Option<(&Table, &SourceSpan)> {
        let item = &self.get(key)?.item;
        match &item.value {
            Value::Table(table) => Some((table, &item.span)),
            _ => None,
        }
    }

    /// Place of the value under a path of keys, `pinion.rack.dedendum`.
    pub fn place(&self, path: &str) -> Option<&SourceSpan> {
        match path.split_once('.') {
            None => Some(&self.get(path)?.item.span),
            Some((table, rest)) => self.table(table)?.0.place(rest),
        }
    }
}

/// A file as far as it could be read.
#[derive(Debug)]
pub struct Document {
    /// The text.
    pub source: Arc<SourceFile>,
    /// Contents, up to the line of the first syntax error.
    pub root: Table,
    /// The first syntax error.
    pub syntax_error: Option<Error>,
}

/// The tree of a text. A syntax error ends it at the line before.
pub fn parse(source: &Arc<SourceFile>) -> Document {
    let mut end = source.text.len();
    let mut broken = None;
    if let Some(at) = find_excess_depth(&source.text) {
        broken = Some(
            Error::new(
                Code::Syntax,
                format!("tables or lists are nested more than {MAX_DEPTH} deep"),
            )
            .with_span(&SourceSpan::new(source.clone(), at..at + 1))
            .with_hint("a model needs no more than a table and a list in it"),
        );
        end = line_start(&source.text, at);
    }
    // An error before the first one found, such as a double key, shows when the text up to it is read again.
    for _ in 0..4 {
        match DeTable::parse(&source.text[..end]) {
            Ok(root) => {
                return Document {
                    root: table(source, root.into_inner()),
                    source: source.clone(),
                    syntax_error: broken,
                };
            }
            Err(error) => {
                let span = error.span().unwrap_or(end..end);
                let place = SourceSpan::new(source.clone(), to_char_boundaries(&source.text, span));
                end = line_start(&source.text, place.span().start.min(end));
                broken = Some(syntax(error.message()).with_span(&place));
            }
        }
    }
    Document {
        source: source.clone(),
        root: Table::default(),
        syntax_error: broken,
    }
}

/// A span moved to where characters begin.
fn to_char_boundaries(text: &str, span: Range<usize>) -> Range<usize> {
    let floor = |mut at: usize| {
        at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    floor(span.start)..floor(span.end)
}

fn line_start(text: &str, at: usize) -> usize {
    text.get(..at)
        .and_then(|before| before.rfind('\n'))
        .map_or(0, |newline| newline + 1)
}

/// Error of the parser, with a hint on its usual cause.
fn syntax(message: &str) -> Error {
    let hint = if message.contains("duplicate key") {
        "write each key once in a table; a second element starts with its own [[header]]"
    } else if message.contains("quoted")
        || message.contains("string")
        || message.contains("literal")
    {
        "text and quantities take quotes: k = \"85 kN/mm\""
    } else {
        "a line is a [[header]], key = value, or a # comment"
    };
    Error::new(Code::Syntax, super::quantity::truncate_to(message, 200)).with_hint(hint)
}

fn table(source: &Arc<SourceFile>, table: DeTable<'_>) -> Table {
    let place = |span| SourceSpan::new(source.clone(), span);
    let mut entries: Vec<Entry> = table
        .into_iter()
        .map(|(key, value)| Entry {
            key_place: place(key.span()),
            key: key.into_inner().into_owned(),
            item: Item {
                span: place(value.span()),
                value: self::value(source, value.into_inner()),
            },
        })
        .collect();
    entries.sort_by_key(|entry| entry.key_place.span().start);
    Table { entries }
}

fn value(source: &Arc<SourceFile>, value: DeValue<'_>) -> Value {
    match value {
        DeValue::String(text) => Value::String(text.into_owned()),
        DeValue::Integer(n) => i64::from_str_radix(n.as_str(), n.radix())
            .map_or_else(|_| Value::Float(f64::INFINITY), Value::Integer),
        DeValue::Float(x) => Value::Float(x.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(flag) => Value::Bool(flag),
        DeValue::Datetime(_) => Value::Date,
        DeValue::Array(list) => Value::List(
            list.into_iter()
                .map(|item| Item {
                    span: SourceSpan::new(source.clone(), item.span()),
                    value: self::value(source, item.into_inner()),
                })
                .collect(),
        ),
        DeValue::Table(inner) => Value::Table(table(source, inner)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::load::source_from_text;

    fn parsed(text: &str) -> Document {
        parse(&source_from_text("m.toml".into(), text))
    }

    #[test]
    fn exact_places_of_keys_and_values() {
        let document = parsed("\u{feff}title = \"a\"\n[[shaft]]\nk = \"µ\"\n");
        assert!(document.syntax_error.is_none());
        let shaft = document.root.get("shaft").unwrap();
        let Value::List(list) = &shaft.item.value else {
            panic!("{shaft:?}");
        };
        assert_eq!(list[0].span.text(), "[[shaft]]");
        let Value::Table(table) = &list[0].value else {
            panic!("{list:?}");
        };
        let k = table.get("k").unwrap();
        assert_eq!((k.key_place.line(), k.key_place.column()), (3, 1));
        assert_eq!((k.item.span.text(), k.item.span.column()), ("\"µ\"", 5));
    }

    #[test]
    fn refuses_the_earliest_syntax_error_and_reads_up_to_it() {
        let document = parsed("a = 1\nb = 2\nb = 3\nc = \nd = 4\n");
        let error = document.syntax_error.unwrap();
        assert_eq!(error.code, Code::Syntax);
        assert_eq!(error.span.unwrap().line(), 3);
        assert_eq!(document.root.entries.len(), 2);
    }

    #[test]
    fn survives_deep_nesting() {
        let deep = 100_000;
        for text in [
            format!("a = {}", "[".repeat(deep)),
            format!("a = {}", "{a=".repeat(deep)),
            format!("a = {}{}", "[".repeat(deep), "]".repeat(deep)),
            "[".repeat(deep),
            format!("[a{}]", ".a".repeat(deep)),
            format!("a{} = 1", ".\"=,[\"".repeat(deep)),
            format!("a = {{a{} = 1}}", ". 'x' ".repeat(deep)),
            format!("a = \"\"\"b\"\"\"\" a{} = 1", ".a".repeat(deep)),
            format!("a' {} = 1", ".a".repeat(deep)),
            format!("# \ra{} = 1", ".a".repeat(deep)),
        ] {
            let error = parsed(&text).syntax_error.unwrap();
            assert_eq!(error.code, Code::Syntax);
            assert!(error.message.len() < 300);
        }
        let dots = format!("a = \"{}\" # {}\n", ".[".repeat(100), "[.".repeat(100));
        assert!(parsed(&dots).syntax_error.is_none());
        let long = format!(
            "a = '''\n{}''' \nb = \"\\\"{}\"",
            "[".repeat(100),
            "[".repeat(100)
        );
        assert!(parsed(&long).syntax_error.is_none());
    }

    #[test]
    fn survives_the_deepest_tree_let_through() {
        let dots = ".a".repeat(MAX_DEPTH);
        let text = format!("[a{dots}]\na{dots} = {{a=1}}");
        parsed(&text);
        let nested = format!("a{dots}={{").repeat(MAX_DEPTH) + "a=1" + &"}".repeat(MAX_DEPTH);
        parsed(&format!("{nested}\n{nested}\n"));
    }
}
