//! Command-line flags as a TOML table: `--band 10:5` becomes `band = "10:5"`, with source spans in the flags as typed.

use std::ops::Range;
use std::sync::Arc;

use super::error::Errors;
use super::error_collector::ErrorCollector;
use super::load;
use super::source_span::{SourceFile, SourceSpan};
use super::table_reader::TableReader;
use super::toml::{Document, Entry, Item, Table, Value};

/// A command-line flag as typed.
#[derive(Debug, Clone)]
pub struct Flag {
    /// Name with its dashes, such as `--harmonic-balance`.
    pub name: String,
    /// TOML key that the flag sets.
    pub key: String,
    /// Values as typed.
    pub values: Vec<String>,
    /// True if the key takes a list.
    pub is_list: bool,
    /// True for a switch, whose name implies its value.
    pub is_switch: bool,
}

/// Flags as a table that overrides a table of a file.
#[derive(Debug, Clone)]
pub struct Flags {
    source: Arc<SourceFile>,
    table: Table,
}

impl Default for Flags {
    fn default() -> Flags {
        Flags::new(&[])
    }
}

impl Flags {
    /// Builds the table of `flags`.
    pub fn new(flags: &[Flag]) -> Flags {
        let mut text = String::new();
        let ranges: Vec<(Range<usize>, Vec<Range<usize>>)> =
            flags.iter().map(|flag| write(&mut text, flag)).collect();
        let source = load::source_from_text("command line".to_string(), &text);
        let span = |range: &Range<usize>| SourceSpan::new(source.clone(), range.clone());
        let entry = |(flag, (name, values)): (&Flag, &(Range<usize>, Vec<Range<usize>>))| {
            let texts = flag.values.iter().zip(values);
            let mut items = texts.map(|(text, range)| Item {
                value: Value::String(text.clone()),
                span: span(range),
            });
            let full_range = name.start..values.last().map_or(name.end, |last| last.end);
            let item = match flag.is_list {
                true => None,
                false => items.next(),
            };
            Entry {
                key: flag.key.clone(),
                key_span: span(name),
                item: item.unwrap_or_else(|| Item {
                    value: Value::List(items.collect()),
                    span: span(&full_range),
                }),
            }
        };
        let entries = flags.iter().zip(&ranges).map(entry).collect();
        Flags {
            table: Table { entries },
            source,
        }
    }

    /// True if no flag is given.
    pub fn is_empty(&self) -> bool {
        self.table.entries.is_empty()
    }

    /// Names of the flags with their dashes.
    pub fn names(&self) -> impl Iterator<Item = String> {
        self.table
            .entries
            .iter()
            .map(|entry| format!("--{}", entry.key.replace('_', "-")))
    }

    /// Copy without the flag of `key`.
    pub fn without(&self, key: &str) -> Flags {
        self.without_all(&[key])
    }

    /// Copy without the flags of `keys`.
    pub fn without_all(&self, keys: &[&str]) -> Flags {
        let mut remaining = self.clone();
        let is_unlisted = |entry: &Entry| !keys.contains(&entry.key.as_str());
        remaining.table.entries.retain(is_unlisted);
        remaining
    }

    /// Text of the flag of `key`; `None` if the flag is absent or a list.
    pub fn text(&self, key: &str) -> Option<&str> {
        match &self.table.get(key)?.item.value {
            Value::String(text) => Some(text),
            _ => None,
        }
    }

    /// Reads the flags merged over `base`, a table that was validated with its file.
    ///
    /// `bare_si` lists the files whose numbers without unit are SI; `title` names the table in messages.
    /// # Errors
    /// Invalid flags, and flags that contradict `base`.
    pub fn read<T>(
        &self,
        title: &str,
        base: Option<(&Table, &SourceSpan)>,
        bare_si: &[String],
        read: impl FnOnce(&mut TableReader) -> T,
    ) -> Result<T, Errors> {
        let empty = Table::default();
        let table = self.merged_with(base.map_or(&empty, |(table, _)| table));
        let span = match base {
            Some((_, span)) if self.is_empty() => span.clone(),
            _ => SourceSpan::new(self.source.clone(), 0..0),
        };
        let mut errors = ErrorCollector {
            bare_si: bare_si.to_vec(),
            flags: Some(self.source.clone()),
            ..ErrorCollector::default()
        };
        let mut f = TableReader::new(&table, span, title, &mut errors);
        let value = read(&mut f);
        f.finish();
        Errors::into_result(errors.errors, || value)
    }

    /// Reads the flags merged over the table `key` of a document; returns `unflagged`, the value read from the file, if no flag is given.
    ///
    /// # Errors
    /// As for [`Flags::read`].
    pub fn read_over<T>(
        &self,
        document: &Document,
        key: &str,
        bare_si: &[String],
        unflagged: T,
        read: impl FnOnce(&mut TableReader) -> T,
    ) -> Result<T, Errors> {
        match self.is_empty() {
            true => Ok(unflagged),
            false => self.read(&format!("[{key}]"), document.root.table(key), bare_si, read),
        }
    }

    /// Merges the flags with the keys that only `base` has; a value equal to that of the file keeps the span in the file.
    fn merged_with(&self, base: &Table) -> Table {
        let text = |entry: &Entry| match &entry.item.value {
            Value::String(text) => Some(text.clone()),
            _ => None,
        };
        let is_set = |flag: &&Entry| {
            let file_text = base.get(&flag.key).and_then(text);
            file_text.is_none() || file_text != text(flag)
        };
        let mut entries: Vec<Entry> = self.table.entries.iter().filter(is_set).cloned().collect();
        let is_unset = |entry: &&Entry| entries.iter().all(|flag| flag.key != entry.key);
        let inherited: Vec<Entry> = base.entries.iter().filter(is_unset).cloned().collect();
        entries.extend(inherited);
        Table { entries }
    }
}

/// Appends a flag to the text and returns the byte ranges of its name and its values.
fn write(text: &mut String, flag: &Flag) -> (Range<usize>, Vec<Range<usize>>) {
    let mut append = |separator: &str, part: &str| {
        if !text.is_empty() {
            *text += separator;
        }
        let start = text.len();
        *text += part;
        start..text.len()
    };
    let name = append(" ", &flag.name);
    if flag.is_switch {
        return (name.clone(), vec![name]);
    }
    let mut separator = " ";
    let values = flag
        .values
        .iter()
        .map(|value| append(std::mem::replace(&mut separator, ","), value));
    (name, values.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::error_collector::ValueRange;
    use crate::base::quantity_kind::QuantityKind;
    use crate::base::toml;

    fn flag(key: &str, values: &[&str], is_list: bool) -> Flag {
        Flag {
            name: format!("--{key}"),
            key: key.to_string(),
            values: values.iter().map(|value| value.to_string()).collect(),
            is_list,
            is_switch: false,
        }
    }

    fn read(f: &mut TableReader) -> (Option<f64>, Option<f64>, Vec<String>, Option<u32>) {
        f.accept_former("outputs", "output");
        f.exclusive("tolerance", "step");
        let step = f.optional_quantity("step", QuantityKind::Time, ValueRange::Positive);
        let tolerance = f.optional_number("tolerance", ValueRange::Positive);
        (
            step,
            tolerance,
            f.texts("output"),
            f.optional_count("samples", 1, 100),
        )
    }

    /// A flag replaces its key, its key's former name and a key that it excludes; the file supplies the other values.
    #[test]
    fn exact_flags_over_a_file() {
        let text = "step = \"1 ms\"\noutputs = [\"a\"]\nsamples = 7\nunread = 1\n";
        let document = toml::parse(&load::source_from_text("scene.toml".into(), text));
        let span = SourceSpan::whole_file("scene.toml");
        let base = Some((&document.root, &span));
        let flags = Flags::new(&[
            flag("tolerance", &["1e-6"], false),
            flag("output", &["b", "c"], true),
        ]);
        let (step, tolerance, output, samples) = flags.read("a", base, &[], read).unwrap();
        assert_eq!((step, tolerance, samples), (None, Some(1e-6), Some(7)));
        assert_eq!(output, ["b", "c"]);
        let merged = Flags::default().read("a", base, &[], read).unwrap();
        assert_eq!(merged, (Some(1e-3), None, vec!["a".to_string()], Some(7)));
    }

    /// An error points to the value as typed; a number without unit has the default unit of the command line.
    #[test]
    fn refuses_at_the_flag() {
        let flags = Flags::new(&[
            flag("step", &["2"], false),
            flag("samples", &["1e3"], false),
        ]);
        let errors = flags.read("a", None, &[], read).unwrap_err();
        let [error] = errors.as_slice() else {
            panic!("{errors}")
        };
        let span = error.span.as_ref().unwrap();
        assert_eq!(span.source().text, "--step 2 --samples 1e3");
        assert_eq!((span.text(), span.column()), ("1e3", 20));
        let exclusive = Flags::new(&[
            flag("step", &["2"], false),
            flag("tolerance", &["1"], false),
        ]);
        assert!(exclusive.read("a", None, &[], read).is_err());
        let unknown = Flags::new(&[flag("nothing", &["1"], false)]);
        let message = unknown.read("a", None, &[], read).unwrap_err().to_string();
        assert!(
            message.contains("--nothing has no effect here"),
            "{message}"
        );
    }
}
