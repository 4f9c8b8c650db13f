//! `[set]` of a scene: pairs `"element.key" = value` that override keys in the tables of the model before these are read.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::error_collector::ErrorCollector;
use crate::base::text::suggestion;

use crate::base::quantity::truncate;
use crate::base::source_span::SourceSpan;
use crate::base::toml::{Entry, Item, Table, Value};

/// Tables without a name, addressed by their header in `[set]`.
const SINGLE: [&str; 2] = ["speed", "damping"];

/// Applies every pair of `set` to `model`.
pub fn apply(set: &Entry, model: &mut Table, errors: &mut ErrorCollector) {
    let Value::Table(pairs) = &set.item.value else {
        errors.push(
            Error::new(
                Code::WrongType,
                format!("`set` is {}", set.item.value.name()),
            )
            .with_span(&set.key_span)
            .with_hint("write [set] and below it \"element.key\" = value"),
        );
        return;
    };
    let set_keys: Vec<String> = pairs.entries.iter().flat_map(full_keys).collect();
    for pair in &pairs.entries {
        if errors.is_full() {
            return;
        }
        match (&pair.item.value, pair.key.rsplit_once('.')) {
            // Unquoted, `element.key = value` is a table `element` in TOML.
            (Value::Table(inner), None) => {
                for entry in &inner.entries {
                    replace(
                        model,
                        (&pair.key, &set_keys),
                        &pair.key_span,
                        entry.clone(),
                        errors,
                    );
                }
            }
            (_, Some((element, key))) => {
                let entry = Entry {
                    key: key.to_string(),
                    ..pair.clone()
                };
                replace(model, (element, &set_keys), &pair.key_span, entry, errors);
            }
            (_, None) => errors.push(
                Error::new(
                    Code::UnknownKey,
                    format!("`{}` names no key of an element", truncate(&pair.key)),
                )
                .with_span(&pair.key_span)
                .with_label("in [set]")
                .with_hint("write \"element.key\", such as \"roll_shaft.k\""),
            ),
        }
    }
}

/// Full keys `element.key` set by an entry of `[set]`.
fn full_keys(pair: &Entry) -> Vec<String> {
    match &pair.item.value {
        Value::Table(inner) if !pair.key.contains('.') => {
            let full_key = |entry: &Entry| format!("{}.{}", pair.key, entry.key);
            inner.entries.iter().map(full_key).collect()
        }
        _ => vec![pair.key.clone()],
    }
}

/// Keys for the loss of a stiffness, which accepts one of them; setting another one replaces it.
const LOSSES: [&str; 3] = ["c", "damping_ratio", "loss_factor"];

/// Whether two keys are alternative losses of a bearing: `damping_ratio` or `loss_factor` for all springs, or dampers `c_…` by axis.
fn are_bearing_losses(key: &str, other: &str) -> bool {
    let is_common = |key: &str| ["damping_ratio", "loss_factor"].contains(&key);
    let is_damper = |key: &str| key.starts_with("c_");
    is_common(key) && is_damper(other) || is_damper(key) && is_common(other)
}

/// Loss keys replaced by setting `key`, all with the same suffix.
fn other_losses(key: &str) -> Vec<String> {
    let suffix = |base: &str| {
        let rest = key.strip_prefix(base)?;
        (rest.is_empty() || rest.starts_with('_')).then(|| rest.to_string())
    };
    match LOSSES
        .into_iter()
        .find_map(|base| Some((base, suffix(base)?)))
    {
        Some((loss, suffix)) => {
            let others = LOSSES.into_iter().filter(|base| *base != loss);
            others.map(|base| format!("{base}{suffix}")).collect()
        }
        None => Vec::new(),
    }
}

fn replace(
    model: &mut Table,
    (element, set_keys): (&str, &[String]),
    at: &SourceSpan,
    entry: Entry,
    errors: &mut ErrorCollector,
) {
    if SINGLE.contains(&element) && model.get(element).is_none() {
        model.entries.push(Entry {
            key: element.to_string(),
            key_span: at.clone(),
            item: Item {
                value: Value::Table(Table::default()),
                span: at.clone(),
            },
        });
    }
    let Some(table) = find_element(model, element) else {
        let candidates = element_names(model);
        let hint = match suggestion(element, candidates.iter().map(String::as_str)) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => "the part before the dot is the name of an element of the model".to_string(),
        };
        let message = format!("the model has no element `{}`", truncate(element));
        errors.push(
            Error::new(Code::UnknownKey, message)
                .with_span(at)
                .with_label("in [set]")
                .with_hint(hint),
        );
        return;
    };
    if entry.key == "name" {
        let error = Error::new(
            Code::Conflict,
            "`name` cannot be set: the model's branches use it",
        );
        errors.push(error.with_span(at).with_label("in [set]"));
        return;
    }
    // Two losses set by the scene itself are both kept; the reader of the element rejects them.
    let others = other_losses(&entry.key);
    let is_replaced = |key: &String| {
        let is_other = others.contains(key) || are_bearing_losses(&entry.key, key);
        is_other && !set_keys.iter().any(|k| *k == format!("{element}.{key}"))
    };
    table.entries.retain(|old| !is_replaced(&old.key));
    match table.entries.iter_mut().find(|old| old.key == entry.key) {
        Some(old) => *old = entry,
        None => table.entries.push(entry),
    }
}

fn has_name(table: &Table, name: &str) -> bool {
    matches!(table.get("name").map(|e| &e.item.value), Some(Value::String(text)) if text == name)
}

/// Table of an element.
fn find_element<'m>(model: &'m mut Table, element: &str) -> Option<&'m mut Table> {
    model
        .entries
        .iter_mut()
        .find_map(|entry| match &mut entry.item.value {
            Value::Table(table) if entry.key == element && SINGLE.contains(&element) => Some(table),
            Value::List(list) => list.iter_mut().find_map(|item| match &mut item.value {
                Value::Table(table) if has_name(table, element) => Some(table),
                _ => None,
            }),
            _ => None,
        })
}

/// Names of all elements.
fn element_names(model: &Table) -> Vec<String> {
    let lists = model
        .entries
        .iter()
        .filter_map(|entry| match &entry.item.value {
            Value::List(list) => Some(list),
            _ => None,
        });
    let element_names = lists.flatten().filter_map(|item| match &item.value {
        Value::Table(table) => match &table.get("name")?.item.value {
            Value::String(text) => Some(text.clone()),
            _ => None,
        },
        _ => None,
    });
    element_names.chain(SINGLE.map(str::to_string)).collect()
}
