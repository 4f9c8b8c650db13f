//! Reader of a TOML table, key by key; it collects errors with their spans and continues.

use super::code::Code;
use super::error::Error;
use super::error_collector::{ErrorCollector, MIN_MAGNITUDE, ValueRange};
use super::quantity;
use super::quantity_kind::QuantityKind;
use super::source_span::SourceSpan;
use super::text::{KEY_SYNONYMS, quoted_list, suggestion};
use super::toml::{Entry, Item, Table, Value};

/// Enumerated value of a key, named by a word.
pub trait Word: Copy + 'static {
    /// Words with their values and help texts.
    const WORDS: &'static [(&'static str, Self, &'static str)];
}

/// Reader of one table. Read every permitted key, then call `finish`.
pub struct TableReader<'a, 'n> {
    /// Table as written.
    pub table: &'a Table,
    /// Start of the table.
    pub span: SourceSpan,
    /// Title of the table in messages: `[[gear_pair]] "first_pair"`.
    pub title: String,
    known_keys: Vec<(String, String)>,
    /// Renamed keys: former name, current name.
    renamed: Vec<(&'static str, &'static str)>,
    /// Keys of the file that a flag replaces.
    replaced: Vec<String>,
    /// True if any key is permitted.
    allow_any_key: bool,
    /// Collected errors.
    pub errors: &'n mut ErrorCollector,
}

impl<'a, 'n> TableReader<'a, 'n> {
    /// Starts reading `table`, which begins at `span` under the header `header`.
    pub fn new(
        table: &'a Table,
        span: SourceSpan,
        header: &str,
        errors: &'n mut ErrorCollector,
    ) -> TableReader<'a, 'n> {
        let title = match table.get("name").map(|entry| &entry.item.value) {
            Some(Value::String(name)) => format!("{header} \"{}\"", quantity::truncate(name)),
            _ => header.to_string(),
        };
        TableReader {
            table,
            span,
            title,
            known_keys: Vec::new(),
            renamed: Vec::new(),
            replaced: Vec::new(),
            allow_any_key: false,
            errors,
        }
    }

    /// Entry of `key`, by its current or former name.
    fn entry(&self, key: &str) -> Option<&'a Entry> {
        let former = self.renamed.iter().find(|(_, current)| *current == key);
        let names = [Some(key), former.map(|(former, _)| *former)];
        let is_effective = |name: &&str| !self.replaced.iter().any(|replaced| replaced == name);
        let mut names = names.into_iter().flatten().filter(is_effective);
        names.find_map(|name| self.table.get(name))
    }

    /// True if the key is present, valid or not.
    pub fn has(&self, key: &str) -> bool {
        self.entry(key).is_some()
    }

    /// True if the key is given on the command line.
    pub fn has_flag(&self, key: &str) -> bool {
        (self.entry(key)).is_some_and(|entry| self.errors.is_flag(&entry.key_span))
    }

    /// Accepts the former name `former` of `key`.
    pub fn accept_former(&mut self, former: &'static str, key: &'static str) {
        self.exclusive(former, key);
        self.renamed.push((former, key));
    }

    /// Ignores `keys` of the file if the command line gives `flag`.
    pub fn replace(&mut self, flag: &str, keys: &[&str]) {
        let is_given = self.has_flag(flag);
        let of_file = |key: &&&str| is_given && !self.has_flag(key);
        let replaced: Vec<String> = keys
            .iter()
            .filter(of_file)
            .map(|key| key.to_string())
            .collect();
        self.replaced.extend(replaced);
    }

    /// Span of the value of `key`, or of the table if it is absent.
    pub fn span_of(&self, key: &str) -> &SourceSpan {
        self.entry(key).map_or(&self.span, |entry| &entry.item.span)
    }

    /// Value of `key` of any type; `takes` describes the expected value.
    pub fn item(&mut self, key: &str, takes: impl Into<String>) -> Option<&'a Item> {
        self.known_keys.push((key.to_string(), takes.into()));
        self.entry(key).map(|entry| &entry.item)
    }

    /// Text of a flag; numbers of flags are texts.
    fn flag_text(&self, item: &'a Item) -> Option<&'a str> {
        match &item.value {
            Value::String(text) if self.errors.is_flag(&item.span) => Some(text),
            _ => None,
        }
    }

    /// Adds an error of this table at `span`.
    pub fn push(&mut self, error: Error, span: &SourceSpan) {
        let error = error.with_span(span);
        let error = match self.errors.is_flag(span) {
            true => error,
            false => error.with_label(format!("in {}", self.title)),
        };
        self.errors.push(error);
    }

    /// Reports an error at `span` of this table.
    pub fn report(
        &mut self,
        code: Code,
        message: impl Into<String>,
        span: &SourceSpan,
        hint: &str,
    ) {
        let error = Error::new(code, message);
        let error = match hint.is_empty() {
            true => error,
            false => error.with_hint(hint),
        };
        self.push(error, span);
    }

    /// Reports an error of the value of `key`.
    pub fn report_key(&mut self, code: Code, key: &str, message: impl Into<String>, hint: &str) {
        let span = self.span_of(key).clone();
        self.report(code, message, &span, hint);
    }

    /// Reports a missing `key`.
    pub fn report_missing(&mut self, key: &str, why: &str) {
        let takes = self
            .known_keys
            .iter()
            .find(|(known, _)| known == key)
            .map_or(String::new(), |(_, takes)| format!("`{key}` takes {takes}"));
        let span = self.span.clone();
        let message = format!("{} has no `{key}`{why}", self.title);
        self.report(Code::MissingKey, message, &span, &takes);
    }

    /// Reports two mutually exclusive keys; true if both are given. A flag replaces a key of the file.
    pub fn exclusive(&mut self, first: &str, second: &str) -> bool {
        self.replace(first, &[second]);
        self.replace(second, &[first]);
        let both = self.has(first) && self.has(second);
        if both {
            let hint = format!("omit `{first}` or `{second}`");
            self.report_key(
                Code::Conflict,
                second,
                format!("`{second}` and `{first}` exclude each other"),
                &hint,
            );
        }
        both
    }

    /// Reports a `key` without the required `other`.
    pub fn requires(&mut self, key: &str, other: &str) {
        if self.has(key) && !self.has(other) {
            let hint = format!("give `{other}` too, or omit `{key}`");
            self.report_key(
                Code::MissingKey,
                key,
                format!("`{key}` needs `{other}`"),
                &hint,
            );
        }
    }

    /// Optional text.
    pub fn optional_text(&mut self, key: &str) -> Option<&'a str> {
        let item = self.item(key, "text in quotes")?;
        match &item.value {
            Value::String(text) => Some(text),
            _ => self.wrong_type(key, item, "text in quotes"),
        }
    }

    /// Optional text parsed by `parse`; its second argument is the key as messages name it.
    pub fn parsed<T>(
        &mut self,
        key: &str,
        parse: impl Fn(&str, &str) -> Result<T, Error>,
    ) -> Option<T> {
        let text = self.optional_text(key)?;
        let error = match parse(text, &format!("`{key}`")) {
            Ok(value) => return Some(value),
            Err(error) => error,
        };
        let span = self.span_of(key).clone();
        self.push(error, &span);
        None
    }

    /// List of texts, or a single text; empty if the key is absent.
    pub fn texts(&mut self, key: &str) -> Vec<String> {
        const TAKES: &str = "a list of texts";
        let mut texts = Vec::new();
        for item in self.items(key, TAKES) {
            match &item.value {
                Value::String(text) => texts.push(text.clone()),
                _ => {
                    self.wrong_type::<()>(key, item, TAKES);
                }
            }
        }
        texts
    }

    /// List of numbers without units, or a single number; empty if the key is absent.
    pub fn numbers(&mut self, key: &str, range: ValueRange) -> Vec<f64> {
        let items = self.items(key, "a list of numbers without units").iter();
        items
            .filter_map(|item| self.number_of(key, item, range))
            .collect()
    }

    /// Items of a list, or a single item.
    fn items(&mut self, key: &str, takes: &str) -> &'a [Item] {
        match self.item(key, takes) {
            None => &[],
            Some(item) => match &item.value {
                Value::List(list) => list,
                _ => std::slice::from_ref(item),
            },
        }
    }

    /// Optional quantity, SI.
    pub fn optional_quantity(
        &mut self,
        key: &str,
        kind: QuantityKind,
        range: ValueRange,
    ) -> Option<f64> {
        let item = self.item(key, kind.units())?;
        let value = self.read_quantity(key, item, kind, range)?;
        if value != 0.0 && value.abs() < MIN_MAGNITUDE && range != ValueRange::Any {
            let written = quantity::truncate(item.span.text());
            let message = format!(
                "`{key}` is below {MIN_MAGNITUDE:e} in SI units, where products underflow to zero, and is {written}"
            );
            let hint = "check its unit; for none write 0 or omit it";
            self.report(Code::OutOfRange, message, &item.span, hint);
            return None;
        }
        Some(value)
    }

    /// Required quantity, SI; NaN with a reported error if it is missing or invalid.
    pub fn quantity(&mut self, key: &str, kind: QuantityKind, range: ValueRange) -> f64 {
        let value = self.optional_quantity(key, kind, range);
        self.require(key);
        value.unwrap_or(f64::NAN)
    }

    /// Optional list of quantities, SI, of length `count` if given.
    pub fn optional_quantities(
        &mut self,
        key: &str,
        kind: QuantityKind,
        range: ValueRange,
        count: Option<usize>,
    ) -> Option<Vec<f64>> {
        let takes = match count {
            Some(count) => format!("a list of {count}, each in {}", kind.units()),
            None => format!("a list, each in {}", kind.units()),
        };
        let item = self.item(key, takes.as_str())?;
        let list = self.read_list(key, item, count, &takes)?;
        let values: Vec<f64> = list
            .iter()
            .filter_map(|item| self.read_quantity(key, item, kind, range))
            .collect();
        (values.len() == list.len()).then_some(values)
    }

    /// Optional pair of quantities, SI: a list of two, or one quantity for both.
    pub fn optional_pair(
        &mut self,
        key: &str,
        kind: QuantityKind,
        range: ValueRange,
    ) -> Option<[f64; 2]> {
        if let Some(Value::List(_)) = self.entry(key).map(|entry| &entry.item.value) {
            let pair = self.optional_quantities(key, kind, range, Some(2))?;
            return pair.try_into().ok();
        }
        let value = self.optional_quantity(key, kind, range)?;
        Some([value, value])
    }

    /// True if the value of the key is a quantity of `kind`.
    pub fn holds(&self, key: &str, kind: QuantityKind) -> bool {
        match self.entry(key).map(|entry| &entry.item.value) {
            Some(Value::String(text)) => quantity::parse(text, kind, key).is_ok(),
            _ => false,
        }
    }

    /// Optional number without unit.
    pub fn optional_number(&mut self, key: &str, range: ValueRange) -> Option<f64> {
        let item = self.item(key, "a number without unit")?;
        self.number_of(key, item, range)
    }

    /// Optional integer in `low..=high`.
    pub fn optional_count(&mut self, key: &str, low: u32, high: u32) -> Option<u32> {
        let item = self.item(key, format!("a whole number from {low} to {high}"))?;
        self.read_count(key, item, low, high)
    }

    /// Optional list of `N` integers in `low..=high`.
    pub fn optional_counts<const N: usize>(
        &mut self,
        key: &str,
        low: u32,
        high: u32,
    ) -> Option<[u32; N]> {
        let takes = format!("a list of {N} whole numbers from {low} to {high}");
        let item = self.item(key, takes.as_str())?;
        let list = self.read_list(key, item, Some(N), &takes)?;
        let values: Vec<u32> = list
            .iter()
            .filter_map(|item| self.read_count(key, item, low, high))
            .collect();
        values.try_into().ok()
    }

    /// `true` or `false`; false by default.
    pub fn flag(&mut self, key: &str) -> bool {
        self.optional_flag(key).unwrap_or(false)
    }

    /// Optional `true` or `false`.
    pub fn optional_flag(&mut self, key: &str) -> Option<bool> {
        let item = self.item(key, "true or false")?;
        match &item.value {
            Value::Bool(flag) => Some(*flag),
            _ if self.flag_text(item) == Some("true") => Some(true),
            _ if self.flag_text(item) == Some("false") => Some(false),
            _ => self.wrong_type(key, item, "true or false"),
        }
    }

    /// Optional word of `choices`.
    pub fn choice<T: Copy>(&mut self, key: &str, choices: &[(&str, T)]) -> Option<T> {
        let words: Vec<String> = choices
            .iter()
            .map(|(word, _)| format!("\"{word}\""))
            .collect();
        let takes = words.join(", ");
        let item = self.item(key, takes.as_str())?;
        let Value::String(text) = &item.value else {
            return self.wrong_type(key, item, &takes);
        };
        let choice = choices.iter().find(|(word, _)| word == text);
        if choice.is_none() {
            let message = format!("`{key}` cannot be \"{}\"", quantity::truncate(text));
            let known = choices.iter().map(|(word, _)| *word);
            let meant = suggestion(text, known)
                .map_or(String::new(), |word| format!("did you mean \"{word}\"? "));
            let hint = format!("{meant}it takes {takes}");
            self.report(Code::OutOfRange, message, &item.span, &hint);
            // Kind and type determine the other keys.
            self.allow_any_key |= matches!(key, "kind" | "type");
        }
        choice.map(|(_, value)| *value)
    }

    /// Optional word of an enumeration.
    pub fn word<T: Word>(&mut self, key: &str) -> Option<T> {
        let choices: Vec<(&str, T)> = T::WORDS.iter().map(|w| (w.0, w.1)).collect();
        self.choice(key, &choices)
    }

    /// Reports `key` if it is missing.
    pub fn require(&mut self, key: &str) {
        if !self.has(key) {
            self.report_missing(key, "");
        }
    }

    /// True if any key starts with `start`.
    pub fn has_prefix(&self, start: &str) -> bool {
        self.table.entries.iter().any(|e| e.key.starts_with(start))
    }

    /// Quantities of all entries, SI, for tables whose keys are names.
    pub fn all_quantities(
        &mut self,
        kind: QuantityKind,
        range: ValueRange,
    ) -> Vec<(&'a Entry, f64)> {
        self.allow_any_key = true;
        let entries = self.table.entries.iter();
        entries
            .filter_map(|entry| {
                let value = self.read_quantity(&entry.key, &entry.item, kind, range)?;
                Some((entry, value))
            })
            .collect()
    }

    /// Reports every unknown key.
    pub fn finish(mut self) {
        for entry in &self.table.entries {
            if self.allow_any_key || self.errors.is_full() {
                return;
            }
            let former = |known: &str| self.renamed.contains(&(entry.key.as_str(), known));
            let is_known = |(known, _): &(String, String)| *known == entry.key || former(known);
            if !self.known_keys.iter().any(is_known) {
                self.unknown(entry);
            }
        }
    }

    fn unknown(&mut self, entry: &Entry) {
        let takes = |f: &Self| {
            let known = f.known_keys.iter().map(|(name, _)| name.as_str());
            match f.known_keys.is_empty() {
                true => "leave it out".to_string(),
                false => format!("{} takes {}", f.title, quoted_list(known)),
            }
        };
        if self.errors.flags.is_some() {
            // The keys of the file were checked when the file was read.
            if self.errors.is_flag(&entry.key_span) {
                let message = format!("{} has no effect here", entry.key_span.text());
                let hint = takes(self);
                self.report(Code::Usage, message, &entry.key_span, &hint);
            }
            return;
        }
        let is_known = |key: &str| self.known_keys.iter().any(|(name, _)| name == key);
        let synonyms = KEY_SYNONYMS.iter().filter(|(_, key)| is_known(key));
        let known = self.known_keys.iter().map(|(name, _)| name.as_str());
        let words = known.chain(synonyms.map(|(word, _)| *word));
        let meant = suggestion(&entry.key, words).map(|word| {
            let synonym = KEY_SYNONYMS
                .iter()
                .find(|(w, key)| *w == word && is_known(key));
            synonym.map_or(word, |(_, key)| *key)
        });
        let hint = match meant {
            Some(meant) => {
                let takes = self.known_keys.iter().find(|(name, _)| *name == meant);
                let takes = takes.map_or("", |(_, takes)| takes);
                format!("did you mean `{meant}`? it takes {takes}")
            }
            None => format!(
                "it takes {}",
                quoted_list(self.known_keys.iter().map(|a| a.0.as_str()))
            ),
        };
        let message = format!("unknown key `{}`", quantity::truncate(&entry.key));
        self.report(Code::UnknownKey, message, &entry.key_span, &hint);
    }

    /// List of `item`, of length `count` if given.
    fn read_list(
        &mut self,
        key: &str,
        item: &'a Item,
        count: Option<usize>,
        takes: &str,
    ) -> Option<&'a [Item]> {
        match &item.value {
            Value::List(list) if count.is_none_or(|count| count == list.len()) => Some(list),
            Value::List(list) => {
                let message = format!("`{key}` has {} values", list.len());
                let hint = format!("`{key}` takes {takes}");
                self.report(Code::WrongType, message, &item.span, &hint);
                None
            }
            _ => self.wrong_type(key, item, takes),
        }
    }

    fn read_quantity(
        &mut self,
        key: &str,
        item: &'a Item,
        kind: QuantityKind,
        range: ValueRange,
    ) -> Option<f64> {
        let subject = format!("`{key}`");
        let si = self.errors.is_si(&item.span);
        let value = match &item.value {
            Value::String(text) if self.errors.is_flag(&item.span) => {
                quantity::parse_or_bare(text, kind, kind.bare_unit(), &subject)
            }
            Value::String(text) if si => {
                quantity::parse_or_bare(text, kind, kind.si_unit(), &subject)
            }
            Value::String(text) => quantity::parse(text, kind, &subject),
            Value::Integer(n) if si => Ok(quantity::value_in_si(*n as f64, kind)),
            Value::Float(x) if si || !x.is_finite() => Ok(quantity::value_in_si(*x, kind)),
            Value::Integer(_) | Value::Float(_) => {
                Err(quantity::missing_unit(item.span.text(), kind, &subject))
            }
            _ => {
                return self.wrong_type(
                    key,
                    item,
                    &format!("text such as \"1 {}\"", kind.si_unit()),
                );
            }
        };
        match value {
            Ok(value) => self.in_range(key, item, value, range, kind.units()),
            Err(error) => {
                self.push(error, &item.span);
                None
            }
        }
    }

    /// Number without unit of `item`.
    pub fn number_of(&mut self, key: &str, item: &'a Item, range: ValueRange) -> Option<f64> {
        let flag = self.flag_text(item).map(str::parse);
        let value = match (&item.value, flag) {
            (Value::Integer(n), _) => *n as f64,
            (Value::Float(x), _) => *x,
            (_, Some(Ok(x))) => x,
            _ => return self.wrong_type(key, item, "a number without unit"),
        };
        self.in_range(key, item, value, range, "a number without unit")
    }

    fn in_range(
        &mut self,
        key: &str,
        item: &Item,
        value: f64,
        range: ValueRange,
        takes: &str,
    ) -> Option<f64> {
        let Some(violation) = range.violation(value) else {
            return Some(value);
        };
        let written = quantity::truncate(item.span.text());
        let message = format!("`{key}` {violation}, and is {written}");
        let hint = format!("`{key}` takes {takes}");
        self.report(Code::OutOfRange, message, &item.span, &hint);
        None
    }

    fn read_count(&mut self, key: &str, item: &'a Item, low: u32, high: u32) -> Option<u32> {
        let takes = format!("whole numbers from {low} to {high}");
        // A flag may be 1e6.
        let flag = self.flag_text(item).map(str::parse::<f64>);
        let count = match (&item.value, flag) {
            (Value::Integer(n), _) => u32::try_from(*n).ok(),
            (_, Some(Ok(x))) if x.fract() == 0.0 && x >= 0.0 && x <= f64::from(u32::MAX) => {
                Some(x as u32)
            }
            (Value::Float(_), _) | (_, Some(_)) => None,
            _ => return self.wrong_type(key, item, &takes),
        };
        let count = count.filter(|n| (low..=high).contains(n));
        if count.is_none() {
            let message = format!("`{key}` cannot be {}", quantity::truncate(item.span.text()));
            let hint = format!("`{key}` takes {takes}");
            self.report(Code::OutOfRange, message, &item.span, &hint);
        }
        count
    }

    /// Reports a value of the wrong type.
    pub fn wrong_type<T>(&mut self, key: &str, item: &Item, takes: &str) -> Option<T> {
        let message = match self.errors.is_flag(&item.span) {
            true => format!("`{key}` cannot be {}", quantity::truncate(item.span.text())),
            false => format!("`{key}` is {}", item.value.name()),
        };
        let hint = format!("`{key}` takes {takes}");
        self.report(Code::WrongType, message, &item.span, &hint);
        None
    }
}
