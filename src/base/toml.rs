//! TOML documents parsed to a tree in which every key and value has its source span.
//!
//! The only file that names the `toml` crate.

use std::ops::Range;
use std::sync::Arc;

use toml::de::{DeTable, DeValue};

use super::code::Code;
use super::error::Error;
use super::nesting::{MAX_DEPTH, find_excess_depth};
use super::source_span::{SourceFile, SourceSpan};

/// A value with its source span.
#[derive(Debug, Clone)]
pub struct Item {
    /// Contents.
    pub value: Value,
    /// Source span of the value.
    pub span: SourceSpan,
}

/// A TOML value by type.
#[derive(Debug, Clone)]
pub enum Value {
    /// String.
    String(String),
    /// Integer within the range of `i64`.
    Integer(i64),
    /// Any other number; infinite beyond the range of `i64` or `f64`.
    Float(f64),
    /// Boolean.
    Bool(bool),
    /// Date, time of day or both.
    Date,
    /// Array.
    List(Vec<Item>),
    /// Table.
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

/// Table of keys and values in source order.
#[derive(Debug, Clone, Default)]
pub struct Table {
    /// Entries in source order.
    pub entries: Vec<Entry>,
}

/// Key of a table with its value.
#[derive(Debug, Clone)]
pub struct Entry {
    /// Key without quotes.
    pub key: String,
    /// Source span of the key.
    pub key_span: SourceSpan,
    /// Value with its source span.
    pub item: Item,
}

impl Table {
    /// Entry of `key`; `None` where the key is absent.
    pub fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }

    /// Table under `key` with its source span; `None` where the key is absent or its value is of another type.
    pub fn table(&self, key: &str) -> Option<(&Table, &SourceSpan)> {
        let item = &self.get(key)?.item;
        match &item.value {
            Value::Table(table) => Some((table, &item.span)),
            _ => None,
        }
    }

    /// Source span of the value at a dotted path of keys, such as `pinion.rack.dedendum`.
    pub fn place(&self, path: &str) -> Option<&SourceSpan> {
        match path.split_once('.') {
            None => Some(&self.get(path)?.item.span),
            Some((table, rest)) => self.table(table)?.0.place(rest),
        }
    }
}

/// A parsed document, complete up to the first syntax error.
#[derive(Debug)]
pub struct Document {
    /// Source text.
    pub source: Arc<SourceFile>,
    /// Root table, up to the line before the first syntax error.
    pub root: Table,
    /// First syntax error.
    pub syntax_error: Option<Error>,
}

/// Parses a source text; the tree ends at the line before the first syntax error.
pub fn parse(source: &Arc<SourceFile>) -> Document {
    let mut end = source.text.len();
    let mut syntax_error = None;
    if let Some(offset) = find_excess_depth(&source.text) {
        syntax_error = Some(
            Error::new(
                Code::Syntax,
                format!("tables or lists are nested more than {MAX_DEPTH} deep"),
            )
            .with_span(&SourceSpan::new(source.clone(), offset..offset + 1))
            .with_hint("a table and a list in it are sufficient for a model"),
        );
        end = line_start(&source.text, offset);
    }
    // The parser may report a later error first; parsing the text before it again finds an earlier one, such as a duplicate key.
    for _ in 0..4 {
        match DeTable::parse(&source.text[..end]) {
            Ok(root) => {
                return Document {
                    root: table(source, root.into_inner()),
                    source: source.clone(),
                    syntax_error,
                };
            }
            Err(error) => {
                let range = error.span().unwrap_or(end..end);
                let span = SourceSpan::new(source.clone(), to_char_boundaries(&source.text, range));
                end = line_start(&source.text, span.span().start.min(end));
                syntax_error = Some(syntax(error.message()).with_span(&span));
            }
        }
    }
    Document {
        source: source.clone(),
        root: Table::default(),
        syntax_error,
    }
}

/// Moves both ends of a span down to character boundaries.
fn to_char_boundaries(text: &str, span: Range<usize>) -> Range<usize> {
    let floor = |mut offset: usize| {
        offset = offset.min(text.len());
        while !text.is_char_boundary(offset) {
            offset -= 1;
        }
        offset
    };
    floor(span.start)..floor(span.end)
}

fn line_start(text: &str, offset: usize) -> usize {
    text.get(..offset)
        .and_then(|head| head.rfind('\n'))
        .map_or(0, |newline| newline + 1)
}

/// Syntax error with the message of the parser and a hint on the usual cause.
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
    let span_of = |range| SourceSpan::new(source.clone(), range);
    let mut entries: Vec<Entry> = table
        .into_iter()
        .map(|(key, value)| Entry {
            key_span: span_of(key.span()),
            key: key.into_inner().into_owned(),
            item: Item {
                span: span_of(value.span()),
                value: self::value(source, value.into_inner()),
            },
        })
        .collect();
    entries.sort_by_key(|entry| entry.key_span.span().start);
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

    fn parse_text(text: &str) -> Document {
        parse(&source_from_text("m.toml".into(), text))
    }

    #[test]
    fn exact_places_of_keys_and_values() {
        let document = parse_text("\u{feff}title = \"a\"\n[[shaft]]\nk = \"µ\"\n");
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
        assert_eq!((k.key_span.line(), k.key_span.column()), (3, 1));
        assert_eq!((k.item.span.text(), k.item.span.column()), ("\"µ\"", 5));
    }

    #[test]
    fn refuses_the_earliest_syntax_error_and_reads_up_to_it() {
        let document = parse_text("a = 1\nb = 2\nb = 3\nc = \nd = 4\n");
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
            let error = parse_text(&text).syntax_error.unwrap();
            assert_eq!(error.code, Code::Syntax);
            assert!(error.message.len() < 300);
        }
        let dots = format!("a = \"{}\" # {}\n", ".[".repeat(100), "[.".repeat(100));
        assert!(parse_text(&dots).syntax_error.is_none());
        let long = format!(
            "a = '''\n{}''' \nb = \"\\\"{}\"",
            "[".repeat(100),
            "[".repeat(100)
        );
        assert!(parse_text(&long).syntax_error.is_none());
    }

    #[test]
    fn survives_the_deepest_tree_let_through() {
        let dots = ".a".repeat(MAX_DEPTH);
        let text = format!("[a{dots}]\na{dots} = {{a=1}}");
        parse_text(&text);
        let nested = format!("a{dots}={{").repeat(MAX_DEPTH) + "a=1" + &"}".repeat(MAX_DEPTH);
        parse_text(&format!("{nested}\n{nested}\n"));
    }
}
