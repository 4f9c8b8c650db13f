//! Reads one `[table]` or every `[[table]]` under a key.

use std::sync::Arc;

use crate::base::error::Errors;
use crate::base::error_collector::ErrorCollector;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::TableReader;
use crate::base::toml::{self, Item, Table, Value};

/// Reads a whole file from its top.
///
/// # Errors
/// Everything wrong in it.
pub fn read_file<T>(
    source: &Arc<SourceFile>,
    name: &str,
    read: impl FnOnce(&mut TableReader) -> T,
) -> Result<T, Errors> {
    let document = toml::parse(source);
    let mut errors = ErrorCollector::default();
    errors.record_units(&document);
    let span = SourceSpan::new(source.clone(), 0..0);
    let mut f = TableReader::new(&document.root, span, name, &mut errors);
    let value = read(&mut f);
    f.finish();
    let mut errors = errors.errors;
    errors.extend(document.syntax_error);
    Errors::into_result(errors, || value)
}

/// Title of a file; reads `source` and `units` too.
pub fn read_heading(f: &mut TableReader) -> String {
    let title = f.optional_text("title").unwrap_or_default().to_string();
    f.optional_text("source");
    f.item("units", "the text \"SI\"");
    title
}

/// Every table under `[[key]]`.
pub fn read_tables<T>(
    f: &mut TableReader,
    key: &str,
    read: impl Fn(&mut TableReader) -> T,
) -> Vec<T> {
    let takes = format!("tables: write [[{key}]] above each");
    let Some(item) = f.item(key, takes.as_str()) else {
        return Vec::new();
    };
    let Value::List(list) = &item.value else {
        return f.wrong_type(key, item, &takes).unwrap_or_default();
    };
    let header = format!("[[{key}]]");
    let mut all = Vec::new();
    for item in list {
        match &item.value {
            Value::Table(table) => all.push(inner(f, table, item, &header, &read)),
            _ => {
                f.wrong_type::<()>(key, item, &takes);
            }
        }
    }
    all
}

/// The one table under `[key]`.
pub fn read_table<T>(f: &mut TableReader, key: &str, read: fn(&mut TableReader) -> T) -> Option<T> {
    let takes = format!("one table: write [{key}] above it");
    let item = f.item(key, takes.as_str())?;
    match &item.value {
        Value::Table(table) => Some(inner(f, table, item, &format!("[{key}]"), read)),
        _ => f.wrong_type(key, item, &takes),
    }
}

fn inner<T>(
    f: &mut TableReader,
    table: &Table,
    item: &Item,
    header: &str,
    read: impl Fn(&mut TableReader) -> T,
) -> T {
    let mut fields = TableReader::new(table, item.span.clone(), header, f.errors);
    let value = read(&mut fields);
    fields.finish();
    value
}
