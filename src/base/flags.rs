//! Flags of a command line as a TOML table: `--band 10:5` is `band = "10:5"`, whose place is in the flags as they were typed.

use std::ops::Range;
use std::sync::Arc;

use super::error::Errors;
use super::error_collector::ErrorCollector;
use super::load;
use super::source_span::{SourceFile, SourceSpan};
use super::table_reader::TableReader;
use super::toml::{Document, Entry, Item, Table, Value};

/// One flag as it was typed.
#[derive(Debug, Clone)]
pub struct Flag {
    /// Name with its dashes, such as `--harmonic-balance`.
    pub name: String,
    /// The key it sets.
    pub key: String,
    /// Values as typed.
    pub values: Vec<String>,
    /// The key takes a list.
    pub is_list: bool,
    /// The value was not typed: the name of a switch implies it.
    pub is_switch: bool,
}

/// Flags that lie over a table of a file.
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
    /// The table of `flags`.
    pub fn new(flags: &[Flag]) -> Flags {
        let mut text = String::new();
        let places: Vec<(Range<usize>, Vec<Range<usize>>)> =
            flags.iter().map(|flag| write(&mut text, flag)).collect();
        let source = load::source_from_text("command line".to_string(), &text);
        let place = |range: &Range<usize>| SourceSpan::new(source.clone(), range.clone());
        let entry = |(flag, (name, ranges)): (&Flag, &(Range<usize>, Vec<Range<usize>>))| {
            let texts = flag.values.iter().zip(ranges);
            let mut items = texts.map(|(text, range)| Item {
                value: Value::String(text.clone()),
                span: place(range),
            });
            let whole = name.start..ranges.last().map_or(name.end, |last| last.end);
            let item = match flag.is_list {
                true => None,
                false => items.next(),
            };
            Entry {
                key: flag.key.clone(),
                key_place: place(name),
                item: item.unwrap_or_else(|| Item {
                    value: Value::List(items.collect()),
                    span: place(&whole),
                }),
            }
        };
        let entries = flags.iter().zip(&places).map(entry).collect();
        Flags {
            table: Table { entries },
            source,
        }
    }

    /// No flag is given.
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

    /// The flags but that of `key`.
    pub fn without(&self, key: &str) -> Flags {
        self.without_all(&[key])
    }

    /// The flags but those of `keys`.
    pub fn without_all(&self, keys: &[&str]) -> Flags {
        let mut others = self.clone();
        let is_other = |entry: &Entry| !keys.contains(&entry.key.as_str());
        others.table.entries.retain(is_other);
        others
    }

    /// The text given for `key`, where it is one.
    pub fn text(&self, key: &str) -> Option<&str> {
        match &self.table.get(key)?.item.value {
            Value::String(text) => Some(text),
            _ => None,
        }
    }

    /// Reads the flags laid over `base`, a table of files that were checked when they were read, of which `bare_si` state bare numbers in
    /// SI. `title` names what is read.
    ///
    /// # Errors
    /// Everything wrong in the flags, and between them and `base`.
    pub fn read<T>(
        &self,
        title: &str,
        base: Option<(&Table, &SourceSpan)>,
        bare_si: &[String],
        read: impl FnOnce(&mut TableReader) -> T,
    ) -> Result<T, Errors> {
        let empty = Table::default();
        let table = self.over(base.map_or(&empty, |(table, _)| table));
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

    /// Reads the flags laid over the table `key` of a document; `unflagged`, the value read before, where no flag is given.
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

    /// The flags, then the keys that only `base` has. An equal value stays that of the file.
    fn over(&self, base: &Table) -> Table {
        let text = |entry: &Entry| match &entry.item.value {
            Value::String(text) => Some(text.clone()),
            _ => None,
        };
        let is_new = |flag: &&Entry| {
            let listed = base.get(&flag.key).and_then(text);
            listed.is_none() || listed != text(flag)
        };
        let mut entries: Vec<Entry> = self.table.entries.iter().filter(is_new).cloned().collect();
        let is_free = |entry: &&Entry| entries.iter().all(|flag| flag.key != entry.key);
        let rest: Vec<Entry> = base.entries.iter().filter(is_free).cloned().collect();
        entries.extend(rest);
        Table { entries }
    }
}

/// Appends a flag to the text; the places of its name and its values.
fn write(text: &mut String, flag: &Flag) -> (Range<usize>, Vec<Range<usize>>) {
    let mut put = |between: &str, word: &str| {
        if !text.is_empty() {
            *text += between;
        }
        let start = text.len();
        *text += word;
        start..text.len()
    };
    let name = put(" ", &flag.name);
    if flag.is_switch {
        return (name.clone(), vec![name]);
    }
    let mut between = " ";
    let values = flag
        .values
        .iter()
        .map(|value| put(std::mem::replace(&mut between, ","), value));
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

    /// A flag takes the place of its key, under its former name too, and of a key that it excludes; the rest is the file's.
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
        let alone = Flags::default().read("a", base, &[], read).unwrap();
        assert_eq!(alone, (Some(1e-3), None, vec!["a".to_string()], Some(7)));
    }

    /// An error points to the value as it was typed; a bare number has the unit of the command line.
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
        let both = Flags::new(&[
            flag("step", &["2"], false),
            flag("tolerance", &["1"], false),
        ]);
        assert!(both.read("a", None, &[], read).is_err());
        let idle = Flags::new(&[flag("nothing", &["1"], false)]);
        let said = idle.read("a", None, &[], read).unwrap_err().to_string();
        assert!(said.contains("--nothing does nothing here"), "{said}");
    }
}
