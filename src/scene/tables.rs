//! Tables of a file by their headers.

use crate::base::fields::Fields;
use crate::base::toml::{Item, Table, Value};

/// Every table under `[[key]]`.
pub fn each<T>(f: &mut Fields, key: &str, read: impl Fn(&mut Fields) -> T) -> Vec<T> {
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
pub fn one<T>(f: &mut Fields, key: &str, read: fn(&mut Fields) -> T) -> Option<T> {
    let takes = format!("one table: write [{key}] above it");
    let item = f.item(key, takes.as_str())?;
    match &item.value {
        Value::Table(table) => Some(inner(f, table, item, &format!("[{key}]"), read)),
        _ => f.wrong_type(key, item, &takes),
    }
}

fn inner<T>(
    f: &mut Fields,
    table: &Table,
    item: &Item,
    header: &str,
    read: impl Fn(&mut Fields) -> T,
) -> T {
    let mut fields = Fields::new(table, item.place.clone(), header, f.notes);
    let value = read(&mut fields);
    fields.ends();
    value
}
