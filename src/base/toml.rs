//! TOML to a tree in which every key and value knows its place. The only file that names the `toml` crate.

use std::fs;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use toml::de::{DeTable, DeValue};

use super::code::Code;
use super::error::Error;
use super::place::{Place, Source};

/// The largest file read, in bytes.
pub const LARGEST: u64 = 64 << 20;

/// Tables and lists inside each other, and parts of a dotted key; a model needs three.
const DEEPEST: usize = 32;

/// One value of a file.
#[derive(Debug, Clone)]
pub struct Item {
    /// What it says.
    pub value: Value,
    /// Where it stands.
    pub place: Place,
}

/// What a value says.
#[derive(Debug, Clone)]
pub enum Value {
    /// Text in quotes.
    Text(String),
    /// A whole number.
    Integer(i64),
    /// Any other number; infinite where it is beyond all numbers.
    Float(f64),
    /// `true` or `false`.
    Flag(bool),
    /// A date or a time of day.
    Date,
    /// A list.
    List(Vec<Item>),
    /// A table.
    Table(Table),
}

impl Value {
    /// What it is called in messages.
    pub fn name(&self) -> &'static str {
        match self {
            Value::Text(_) => "text",
            Value::Integer(_) | Value::Float(_) => "a number",
            Value::Flag(_) => "true or false",
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
    /// Where the key stands.
    pub key_place: Place,
    /// The value.
    pub item: Item,
}

impl Table {
    /// The entry of `key`.
    pub fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }
}

/// A file as far as it could be read.
#[derive(Debug)]
pub struct Document {
    /// The text.
    pub source: Arc<Source>,
    /// What stands in it, up to the line of the first syntax error.
    pub root: Table,
    /// The first syntax error.
    pub broken: Option<Error>,
}

/// The text of a file, refused before it is read where it cannot be a model.
pub fn load(path: &Path) -> Result<Arc<Source>, Error> {
    let name = path.display().to_string();
    let place = Place::new(source(name.clone(), ""), 0..0);
    let refuse =
        |code, message: String, hint: &str| Error::new(code, message).at(&place).hint(hint);
    let missing = |e: std::io::Error| {
        let hint = "paths are taken from the folder the command is run in";
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
    if facts.len() > LARGEST {
        let mega = facts.len() >> 20;
        let message = format!("{name} has {mega} MB; model files are limited to 64 MB");
        let hint = "a log is read by `geardyn identify` and `geardyn spectrum`";
        return Err(refuse(Code::FileTooLarge, message, hint));
    }
    let bytes = fs::read(path).map_err(missing)?;
    decode(name.clone(), bytes)
}

/// Bytes as text; a byte-order mark is taken off.
pub fn decode(path: String, bytes: Vec<u8>) -> Result<Arc<Source>, Error> {
    match String::from_utf8(bytes) {
        Ok(text) => Ok(source(path, &text)),
        Err(error) => {
            let at = error.utf8_error().valid_up_to();
            let bytes = error.into_bytes();
            let (good, bad) = bytes.split_at(at);
            let byte = bad.first().copied().unwrap_or_default();
            let good = String::from_utf8_lossy(good).into_owned();
            let place = Place::new(source(path, &good), good.len()..good.len());
            Err(Error::new(
                Code::NotText,
                format!(
                    "byte {at} ({byte:#04x}, line {}) is not UTF-8 text",
                    place.line()
                ),
            )
            .at(&place)
            .hint("save the file as UTF-8 in your editor"))
        }
    }
}

/// A text under the name `path`; a byte-order mark is taken off.
pub fn source(path: String, text: &str) -> Arc<Source> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text).to_string();
    Arc::new(Source { path, text })
}

/// The tree of a text. A syntax error ends it at the line before.
pub fn parse(source: &Arc<Source>) -> Document {
    let mut end = source.text.len();
    let mut broken = None;
    if let Some(at) = too_deep(&source.text) {
        broken = Some(
            Error::new(
                Code::Syntax,
                format!("tables or lists are nested more than {DEEPEST} deep"),
            )
            .at(&Place::new(source.clone(), at..at + 1))
            .hint("a model needs no more than a table and a list in it"),
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
                    broken,
                };
            }
            Err(error) => {
                let span = error.span().unwrap_or(end..end);
                let place = Place::new(source.clone(), within(&source.text, span));
                end = line_start(&source.text, place.span().start.min(end));
                broken = Some(syntax(error.message()).at(&place));
            }
        }
    }
    Document {
        source: source.clone(),
        root: Table::default(),
        broken,
    }
}

/// A span moved to where characters begin.
fn within(text: &str, span: Range<usize>) -> Range<usize> {
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

/// What the parser says, with a hint on what it usually comes from.
fn syntax(message: &str) -> Error {
    let hint = if message.contains("duplicate key") {
        "write each key once in a table; a second element starts with its own [[header]]"
    } else if message.contains("quoted")
        || message.contains("string")
        || message.contains("literal")
    {
        "text and quantities stand in quotes: k = \"85 kN/mm\""
    } else {
        "a line is a [[header]], key = value, or a # comment"
    };
    Error::new(Code::Syntax, super::units::shortened_to(message, 200)).hint(hint)
}

/// Where brackets or dotted keys nest deeper than any model needs, found before anything recurses over them.
fn too_deep(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let (mut at, mut open, mut dots) = (0, 0_usize, 0);
    // A quote inside a bare word belongs to the word, as in the parser.
    let mut word = false;
    while let Some(&byte) = bytes.get(at) {
        let quoted = matches!(byte, b'"' | b'\'') && !word;
        word = !(quoted || b".=,[]{} \t#\r\n".contains(&byte));
        match byte {
            b'#' => at += line_length(&bytes[at..]),
            _ if quoted => at += string_length(&bytes[at..], byte),
            b'[' | b'{' => (open, dots) = (open + 1, 0),
            b']' | b'}' => (open, dots) = (open.saturating_sub(1), 0),
            b'.' => dots += 1,
            b'\n' | b'=' | b',' => dots = 0,
            _ => {}
        }
        if open > DEEPEST || dots > DEEPEST {
            return Some(at);
        }
        at += 1;
    }
    None
}

/// Bytes up to the last of a line.
fn line_length(bytes: &[u8]) -> usize {
    bytes
        .iter()
        .position(|&b| b == b'\n' || b == b'\r')
        .unwrap_or(bytes.len())
        .saturating_sub(1)
}

/// Bytes up to the closing quote of a text, or up to where it breaks off.
fn string_length(bytes: &[u8], quote: u8) -> usize {
    let long = bytes.starts_with(&[quote; 3]);
    let mut at = if long { 3 } else { 1 };
    while let Some(&byte) = bytes.get(at) {
        let rest = &bytes[at..];
        match byte {
            b'\\' if quote == b'"' && rest.get(1) != Some(&b'\n') => at += 1,
            b'\n' if !long => return at - 1,
            _ if byte == quote && !long => return at,
            _ if long && rest.starts_with(&[quote; 3]) => {
                // Two more quotes may belong to the text.
                let more = rest[3..]
                    .iter()
                    .take(2)
                    .take_while(|&&b| b == quote)
                    .count();
                return at + 2 + more;
            }
            _ => {}
        }
        at += 1;
    }
    bytes.len()
}

fn table(source: &Arc<Source>, table: DeTable<'_>) -> Table {
    let place = |span| Place::new(source.clone(), span);
    let mut entries: Vec<Entry> = table
        .into_iter()
        .map(|(key, value)| Entry {
            key_place: place(key.span()),
            key: key.into_inner().into_owned(),
            item: Item {
                place: place(value.span()),
                value: self::value(source, value.into_inner()),
            },
        })
        .collect();
    entries.sort_by_key(|entry| entry.key_place.span().start);
    Table { entries }
}

fn value(source: &Arc<Source>, value: DeValue<'_>) -> Value {
    match value {
        DeValue::String(text) => Value::Text(text.into_owned()),
        DeValue::Integer(n) => i64::from_str_radix(n.as_str(), n.radix())
            .map_or_else(|_| Value::Float(f64::INFINITY), Value::Integer),
        DeValue::Float(x) => Value::Float(x.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(flag) => Value::Flag(flag),
        DeValue::Datetime(_) => Value::Date,
        DeValue::Array(list) => Value::List(
            list.into_iter()
                .map(|item| Item {
                    place: Place::new(source.clone(), item.span()),
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

    fn parsed(text: &str) -> Document {
        parse(&source("m.toml".into(), text))
    }

    #[test]
    fn exact_places_of_keys_and_values() {
        let document = parsed("\u{feff}title = \"a\"\n[[shaft]]\nk = \"µ\"\n");
        assert!(document.broken.is_none());
        let shaft = document.root.get("shaft").unwrap();
        let Value::List(list) = &shaft.item.value else {
            panic!("{shaft:?}");
        };
        assert_eq!(list[0].place.text(), "[[shaft]]");
        let Value::Table(table) = &list[0].value else {
            panic!("{list:?}");
        };
        let k = table.get("k").unwrap();
        assert_eq!((k.key_place.line(), k.key_place.column()), (3, 1));
        assert_eq!((k.item.place.text(), k.item.place.column()), ("\"µ\"", 5));
    }

    #[test]
    fn refuses_the_earliest_syntax_error_and_reads_up_to_it() {
        let document = parsed("a = 1\nb = 2\nb = 3\nc = \nd = 4\n");
        let error = document.broken.unwrap();
        assert_eq!(error.code, Code::Syntax);
        assert_eq!(error.place.unwrap().line(), 3);
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
            let error = parsed(&text).broken.unwrap();
            assert_eq!(error.code, Code::Syntax);
            assert!(error.message.len() < 300);
        }
        let dots = format!("a = \"{}\" # {}\n", ".[".repeat(100), "[.".repeat(100));
        assert!(parsed(&dots).broken.is_none());
        let long = format!(
            "a = '''\n{}''' \nb = \"\\\"{}\"",
            "[".repeat(100),
            "[".repeat(100)
        );
        assert!(parsed(&long).broken.is_none());
    }

    #[test]
    fn survives_the_deepest_tree_let_through() {
        let dots = ".a".repeat(DEEPEST);
        let text = format!("[a{dots}]\na{dots} = {{a=1}}");
        parsed(&text);
        let nested = format!("a{dots}={{").repeat(DEEPEST) + "a=1" + &"}".repeat(DEEPEST);
        parsed(&format!("{nested}\n{nested}\n"));
    }

    #[test]
    fn refuses_what_is_not_utf8() {
        let error = decode("m.toml".into(), b"a = 1\nb = \"\xb5m\"".to_vec()).unwrap_err();
        assert_eq!(error.code, Code::NotText);
        assert_eq!(error.message, "byte 11 (0xb5, line 2) is not UTF-8 text");
        assert_eq!(error.place.unwrap().line(), 2);
    }
}
