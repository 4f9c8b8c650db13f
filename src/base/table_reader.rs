//! Reads one TOML table key by key; errors are collected with their spans and reading continues.

use super::code::Code;
use super::error::Error;
use super::error_collector::{ErrorCollector, MIN_MAGNITUDE, ValueRange};
use super::quantity;
use super::quantity_kind::QuantityKind;
use super::source_span::SourceSpan;
use super::text::{KEY_SYNONYMS, quoted_list, suggestion};
use super::toml::{Entry, Item, Table, Value};

/// A value that a key names by a word.
pub trait Word: Copy + 'static {
    /// Every word, its value and a help text.
    const WORDS: &'static [(&'static str, Self, &'static str)];
}

/// One table being read. Ask for every key it may have, then call `finish`.
pub struct TableReader<'a, 'n> {
    /// The table as written.
    pub table: &'a Table,
    /// Start of the table.
    pub span: SourceSpan,
    /// Title of the table in messages: `[[gear_pair]] "first_pair"`.
    pub title: String,
    known_keys: Vec<(String, String)>,
    /// Former names of keys, each before the one it has now.
    renamed: Vec<(&'static str, &'static str)>,
    /// Keys of the file that a flag takes the place of.
    replaced: Vec<String>,
    /// Any key is known.
    open: bool,
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
            open: false,
            errors,
        }
    }

    /// The entry of `key`, under its former name where it has one.
    fn entry(&self, key: &str) -> Option<&'a Entry> {
        let former = self.renamed.iter().find(|(_, now)| *now == key);
        let names = [Some(key), former.map(|(former, _)| *former)];
        let kept = |name: &&str| !self.replaced.iter().any(|replaced| replaced == name);
        let mut names = names.into_iter().flatten().filter(kept);
        names.find_map(|name| self.table.get(name))
    }

    /// The key is written, rightly or wrongly.
    pub fn has(&self, key: &str) -> bool {
        self.entry(key).is_some()
    }

    /// The key is given on the command line.
    pub fn has_flag(&self, key: &str) -> bool {
        (self.entry(key)).is_some_and(|entry| self.errors.is_flag(&entry.key_place))
    }

    /// Takes `former` for `key`, which was its name.
    pub fn accept_former(&mut self, former: &'static str, key: &'static str) {
        self.exclusive(former, key);
        self.renamed.push((former, key));
    }

    /// Leaves out `keys` of the file, where the command line gives `flag`.
    pub fn replace(&mut self, flag: &str, keys: &[&str]) {
        let replaces = self.has_flag(flag);
        let of_file = |key: &&&str| replaces && !self.has_flag(key);
        let replaced: Vec<String> = keys
            .iter()
            .filter(of_file)
            .map(|key| key.to_string())
            .collect();
        self.replaced.extend(replaced);
    }

    /// Place of the value of `key`; the table's place where it is absent.
    pub fn span_of(&self, key: &str) -> &SourceSpan {
        self.entry(key).map_or(&self.span, |entry| &entry.item.span)
    }

    /// The value of `key`, whatever it is; `takes` says what it should be.
    pub fn item(&mut self, key: &str, takes: impl Into<String>) -> Option<&'a Item> {
        self.known_keys.push((key.to_string(), takes.into()));
        self.entry(key).map(|entry| &entry.item)
    }

    /// The text of a flag; numbers are texts there.
    fn flag_text(&self, item: &'a Item) -> Option<&'a str> {
        match &item.value {
            Value::String(text) if self.errors.is_flag(&item.span) => Some(text),
            _ => None,
        }
    }

    /// Notes an error of this table at `span`.
    pub fn push(&mut self, error: Error, span: &SourceSpan) {
        let error = error.with_span(span);
        let error = match self.errors.is_flag(span) {
            true => error,
            false => error.with_label(format!("in {}", self.title)),
        };
        self.errors.push(error);
    }

    /// Notes that something is wrong at `span`, in this table.
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

    /// Notes that something is wrong with the value of `key`.
    pub fn report_key(&mut self, code: Code, key: &str, message: impl Into<String>, hint: &str) {
        let span = self.span_of(key).clone();
        self.report(code, message, &span, hint);
    }

    /// Notes that `key` is missing.
    pub fn report_missing(&mut self, key: &str, why: &str) {
        let takes = self
            .known_keys
            .iter()
            .find(|(asked, _)| asked == key)
            .map_or(String::new(), |(_, takes)| format!("`{key}` takes {takes}"));
        let span = self.span.clone();
        let message = format!("{} has no `{key}`{why}", self.title);
        self.report(Code::MissingKey, message, &span, &takes);
    }

    /// Notes that only one of two keys may be given, if both are; true if so. A flag takes the place of a key of the file.
    pub fn exclusive(&mut self, one: &str, other: &str) -> bool {
        self.replace(one, &[other]);
        self.replace(other, &[one]);
        let both = self.has(one) && self.has(other);
        if both {
            let hint = format!("leave one of `{one}` and `{other}` out");
            self.report_key(
                Code::Conflict,
                other,
                format!("`{other}` and `{one}` exclude each other"),
                &hint,
            );
        }
        both
    }

    /// Notes that `key` needs `other`, where only the first is given.
    pub fn requires(&mut self, key: &str, other: &str) {
        if self.has(key) && !self.has(other) {
            let hint = format!("give `{other}` too, or leave `{key}` out");
            self.report_key(
                Code::MissingKey,
                key,
                format!("`{key}` needs `{other}`"),
                &hint,
            );
        }
    }

    /// Text.
    pub fn optional_text(&mut self, key: &str) -> Option<&'a str> {
        let item = self.item(key, "text in quotes")?;
        match &item.value {
            Value::String(text) => Some(text),
            _ => self.wrong_type(key, item, "text in quotes"),
        }
    }

    /// A text that has a form of its own, which `parse` reads; the second argument is the key as messages name it.
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

    /// A list of texts, or one of them; empty where the key is absent.
    pub fn texts(&mut self, key: &str) -> Vec<String> {
        const TAKES: &str = "a list of texts";
        let mut all = Vec::new();
        for item in self.items(key, TAKES) {
            match &item.value {
                Value::String(text) => all.push(text.clone()),
                _ => {
                    self.wrong_type::<()>(key, item, TAKES);
                }
            }
        }
        all
    }

    /// A list of bare numbers, or one of them; empty where the key is absent.
    pub fn numbers(&mut self, key: &str, range: ValueRange) -> Vec<f64> {
        let items = self.items(key, "a list of numbers without units").iter();
        items
            .filter_map(|item| self.number_of(key, item, range))
            .collect()
    }

    /// The items of a list, or a single item.
    fn items(&mut self, key: &str, takes: &str) -> &'a [Item] {
        match self.item(key, takes) {
            None => &[],
            Some(item) => match &item.value {
                Value::List(list) => list,
                _ => std::slice::from_ref(item),
            },
        }
    }

    /// A quantity that may be left out.
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
                "`{key}` is below {MIN_MAGNITUDE:e} in SI units, where products are lost as zero, and is {written}"
            );
            let hint = "check its unit; for none write 0 or omit it";
            self.report(Code::OutOfRange, message, &item.span, hint);
            return None;
        }
        Some(value)
    }

    /// A quantity; NaN where it is missing or wrong, which is then noted.
    pub fn quantity(&mut self, key: &str, kind: QuantityKind, range: ValueRange) -> f64 {
        let value = self.optional_quantity(key, kind, range);
        self.require(key);
        value.unwrap_or(f64::NAN)
    }

    /// A list of quantities, of `count` if that is given.
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

    /// Reads one quantity for both values, or a list of two.
    pub fn optional_pair(
        &mut self,
        key: &str,
        kind: QuantityKind,
        range: ValueRange,
    ) -> Option<[f64; 2]> {
        if let Some(Value::List(_)) = self.entry(key).map(|entry| &entry.item.value) {
            let two = self.optional_quantities(key, kind, range, Some(2))?;
            return two.try_into().ok();
        }
        let one = self.optional_quantity(key, kind, range)?;
        Some([one, one])
    }

    /// Whether the key holds text that is a quantity of a kind.
    pub fn holds(&self, key: &str, kind: QuantityKind) -> bool {
        match self.entry(key).map(|entry| &entry.item.value) {
            Some(Value::String(text)) => quantity::parse(text, kind, key).is_ok(),
            _ => false,
        }
    }

    /// A bare number that may be left out.
    pub fn optional_number(&mut self, key: &str, range: ValueRange) -> Option<f64> {
        let item = self.item(key, "a number without unit")?;
        self.number_of(key, item, range)
    }

    /// A whole number in `low..=high` that may be left out.
    pub fn optional_count(&mut self, key: &str, low: u32, high: u32) -> Option<u32> {
        let item = self.item(key, format!("a whole number from {low} to {high}"))?;
        self.read_count(key, item, low, high)
    }

    /// A list of `N` whole numbers in `low..=high` that may be left out.
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

    /// `true` or `false`, where the key is there.
    pub fn optional_flag(&mut self, key: &str) -> Option<bool> {
        let item = self.item(key, "true or false")?;
        match &item.value {
            Value::Bool(flag) => Some(*flag),
            _ if self.flag_text(item) == Some("true") => Some(true),
            _ if self.flag_text(item) == Some("false") => Some(false),
            _ => self.wrong_type(key, item, "true or false"),
        }
    }

    /// One of a few words.
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
        let found = choices.iter().find(|(word, _)| word == text);
        if found.is_none() {
            let message = format!("`{key}` cannot be \"{}\"", quantity::truncate(text));
            let known = choices.iter().map(|(word, _)| *word);
            let meant = suggestion(text, known)
                .map_or(String::new(), |word| format!("did you mean \"{word}\"? "));
            let hint = format!("{meant}it takes {takes}");
            self.report(Code::OutOfRange, message, &item.span, &hint);
            // Kind and type say which other keys there are.
            self.open |= matches!(key, "kind" | "type");
        }
        found.map(|(_, value)| *value)
    }

    /// One of the words of a type.
    pub fn word<T: Word>(&mut self, key: &str) -> Option<T> {
        let choices: Vec<(&str, T)> = T::WORDS.iter().map(|w| (w.0, w.1)).collect();
        self.choice(key, &choices)
    }

    /// Notes `key` as missing where it is absent.
    pub fn require(&mut self, key: &str) {
        if !self.has(key) {
            self.report_missing(key, "");
        }
    }

    /// A key starts with `start`.
    pub fn has_prefix(&self, start: &str) -> bool {
        self.table.entries.iter().any(|e| e.key.starts_with(start))
    }

    /// Every entry as a quantity, for tables whose keys are names.
    pub fn all_quantities(
        &mut self,
        kind: QuantityKind,
        range: ValueRange,
    ) -> Vec<(&'a Entry, f64)> {
        self.open = true;
        let entries = self.table.entries.iter();
        entries
            .filter_map(|entry| {
                let value = self.read_quantity(&entry.key, &entry.item, kind, range)?;
                Some((entry, value))
            })
            .collect()
    }

    /// Reports every key that was not read.
    pub fn finish(mut self) {
        for entry in &self.table.entries {
            if self.open || self.errors.is_full() {
                return;
            }
            let former = |asked: &str| self.renamed.contains(&(entry.key.as_str(), asked));
            let is_known = |(asked, _): &(String, String)| *asked == entry.key || former(asked);
            if !self.known_keys.iter().any(is_known) {
                self.unknown(entry);
            }
        }
    }

    fn unknown(&mut self, entry: &Entry) {
        let takes = |f: &Self| {
            let known = f.known_keys.iter().map(|(asked, _)| asked.as_str());
            match f.known_keys.is_empty() {
                true => "leave it out".to_string(),
                false => format!("{} takes {}", f.title, quoted_list(known)),
            }
        };
        if self.errors.flags.is_some() {
            // The keys of the file were checked when the file was read.
            if self.errors.is_flag(&entry.key_place) {
                let message = format!("{} does nothing here", entry.key_place.text());
                let hint = takes(self);
                self.report(Code::Usage, message, &entry.key_place, &hint);
            }
            return;
        }
        let asked = |key: &str| self.known_keys.iter().any(|(asked, _)| asked == key);
        let synonyms = KEY_SYNONYMS.iter().filter(|(_, key)| asked(key));
        let known = self.known_keys.iter().map(|(asked, _)| asked.as_str());
        let words = known.chain(synonyms.map(|(word, _)| *word));
        let meant = suggestion(&entry.key, words).map(|word| {
            let synonym = KEY_SYNONYMS
                .iter()
                .find(|(w, key)| *w == word && asked(key));
            synonym.map_or(word, |(_, key)| *key)
        });
        let hint = match meant {
            Some(meant) => {
                let takes = self.known_keys.iter().find(|(asked, _)| *asked == meant);
                let takes = takes.map_or("", |(_, takes)| takes);
                format!("did you mean `{meant}`? it takes {takes}")
            }
            None => format!(
                "it takes {}",
                quoted_list(self.known_keys.iter().map(|a| a.0.as_str()))
            ),
        };
        let message = format!("unknown key `{}`", quantity::truncate(&entry.key));
        self.report(Code::UnknownKey, message, &entry.key_place, &hint);
    }

    /// The list in `item`, of `count` items if that is given.
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

    /// The bare number in `item`.
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
        let Some(why) = range.violation(value) else {
            return Some(value);
        };
        let written = quantity::truncate(item.span.text());
        let message = format!("`{key}` {why}, and is {written}");
        let hint = format!("`{key}` takes {takes}");
        self.report(Code::OutOfRange, message, &item.span, &hint);
        None
    }

    fn read_count(&mut self, key: &str, item: &'a Item, low: u32, high: u32) -> Option<u32> {
        let takes = format!("whole numbers from {low} to {high}");
        // A flag may say 1e6.
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

    /// Notes a value of the wrong type.
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
