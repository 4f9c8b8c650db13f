//! `[set]` of a scene: `"element.key" = value` pairs put into the model's tables before these are read.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::error_collector::ErrorCollector;
use crate::base::text::suggestion;

use crate::base::quantity::truncate;
use crate::base::source_span::SourceSpan;
use crate::base::toml::{Entry, Item, Table, Value};

/// Tables without a name, which `[set]` reaches by their header.
const SINGLE: [&str; 2] = ["speed", "damping"];

/// Puts every pair of `set` into `model`.
pub fn apply(set: &Entry, model: &mut Table, errors: &mut ErrorCollector) {
    let Value::Table(pairs) = &set.item.value else {
        errors.push(
            Error::new(
                Code::WrongType,
                format!("`set` is {}", set.item.value.name()),
            )
            .with_span(&set.key_place)
            .with_hint("write [set] and below it \"element.key\" = value"),
        );
        return;
    };
    let given: Vec<String> = pairs.entries.iter().flat_map(names_of).collect();
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
                        (&pair.key, &given),
                        &pair.key_place,
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
                replace(model, (element, &given), &pair.key_place, entry, errors);
            }
            (_, None) => errors.push(
                Error::new(
                    Code::UnknownKey,
                    format!("`{}` names no key of an element", truncate(&pair.key)),
                )
                .with_span(&pair.key_place)
                .with_label("in [set]")
                .with_hint("write \"element.key\", such as \"roll_shaft.k\""),
            ),
        }
    }
}

/// `element.key` of what an entry of `[set]` sets.
fn names_of(pair: &Entry) -> Vec<String> {
    match &pair.item.value {
        Value::Table(inner) if !pair.key.contains('.') => {
            let whole = |entry: &Entry| format!("{}.{}", pair.key, entry.key);
            inner.entries.iter().map(whole).collect()
        }
        _ => vec![pair.key.clone()],
    }
}

/// Keys of which a stiffness takes one: another in its place changes the kind of loss.
const LOSSES: [&str; 3] = ["c", "damping_ratio", "loss_factor"];

/// A bearing has one `damping_ratio` or `loss_factor` for all its springs, or dampers `c_…` by axis.
fn are_losses_of_a_bearing(key: &str, other: &str) -> bool {
    let is_common = |key: &str| ["damping_ratio", "loss_factor"].contains(&key);
    let is_damper = |key: &str| key.starts_with("c_");
    is_common(key) && is_damper(other) || is_damper(key) && is_common(other)
}

/// Keys that go by a loss set in place of another, all with the same suffix.
fn other_losses(key: &str) -> Vec<String> {
    let suffix = |base: &str| {
        let rest = key.strip_prefix(base)?;
        (rest.is_empty() || rest.starts_with('_')).then(|| rest.to_string())
    };
    match LOSSES
        .into_iter()
        .find_map(|base| Some((base, suffix(base)?)))
    {
        Some((own, suffix)) => {
            let others = LOSSES.into_iter().filter(|base| *base != own);
            others.map(|base| format!("{base}{suffix}")).collect()
        }
        None => Vec::new(),
    }
}

fn replace(
    model: &mut Table,
    (element, given): (&str, &[String]),
    at: &SourceSpan,
    entry: Entry,
    errors: &mut ErrorCollector,
) {
    if SINGLE.contains(&element) && model.get(element).is_none() {
        model.entries.push(Entry {
            key: element.to_string(),
            key_place: at.clone(),
            item: Item {
                value: Value::Table(Table::default()),
                span: at.clone(),
            },
        });
    }
    let Some(table) = find(model, element) else {
        let known = names(model);
        let hint = match suggestion(element, known.iter().map(String::as_str)) {
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
    // Both set by the scene are left for the reader of the element to refuse.
    let others = other_losses(&entry.key);
    let goes = |key: &String| {
        let is_other = others.contains(key) || are_losses_of_a_bearing(&entry.key, key);
        is_other && !given.iter().any(|one| *one == format!("{element}.{key}"))
    };
    table.entries.retain(|old| !goes(&old.key));
    match table.entries.iter_mut().find(|old| old.key == entry.key) {
        Some(old) => *old = entry,
        None => table.entries.push(entry),
    }
}

fn has_name(table: &Table, name: &str) -> bool {
    matches!(table.get("name").map(|e| &e.item.value), Some(Value::String(text)) if text == name)
}

/// The table of an element.
fn find<'m>(model: &'m mut Table, element: &str) -> Option<&'m mut Table> {
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

/// The names of all elements.
fn names(model: &Table) -> Vec<String> {
    let lists = model
        .entries
        .iter()
        .filter_map(|entry| match &entry.item.value {
            Value::List(list) => Some(list),
            _ => None,
        });
    let names = lists.flatten().filter_map(|item| match &item.value {
        Value::Table(table) => match &table.get("name")?.item.value {
            Value::String(text) => Some(text.clone()),
            _ => None,
        },
        _ => None,
    });
    names.chain(SINGLE.map(str::to_string)).collect()
}
