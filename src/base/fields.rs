//! One table of a file, handing out typed values by key; what is wrong is noted with its place, and reading goes on.

use super::code::Code;
use super::error::Error;
use super::kind::Kind;
use super::notes::{Notes, Range, SMALLEST};
use super::place::Place;
use super::toml::{Entry, Item, Table, Value};
use super::units;
use super::words::{SYNONYMS, listed, suggestion};

/// One table being read. Ask for every key it may have, then call `ends`.
pub struct Fields<'a, 'n> {
    table: &'a Table,
    /// Where the table begins.
    pub place: Place,
    /// What it is called in messages: `[[gear_pair]] "first_pair"`.
    pub title: String,
    asked: Vec<(String, String)>,
    /// Any key is known.
    open: bool,
    /// What was found wrong.
    pub notes: &'n mut Notes,
}

impl<'a, 'n> Fields<'a, 'n> {
    /// Starts reading `table`, which begins at `place` under the header `header`.
    pub fn new(
        table: &'a Table,
        place: Place,
        header: &str,
        notes: &'n mut Notes,
    ) -> Fields<'a, 'n> {
        let title = match table.get("name").map(|entry| &entry.item.value) {
            Some(Value::Text(name)) => format!("{header} \"{}\"", units::shortened(name)),
            _ => header.to_string(),
        };
        Fields {
            table,
            place,
            title,
            asked: Vec::new(),
            open: false,
            notes,
        }
    }

    /// The key is written, rightly or wrongly.
    pub fn has(&self, key: &str) -> bool {
        self.table.get(key).is_some()
    }

    /// Where the value of `key` stands; the table's place where it is absent.
    pub fn place_of(&self, key: &str) -> &Place {
        self.table
            .get(key)
            .map_or(&self.place, |entry| &entry.item.place)
    }

    /// The value of `key`, whatever it is; `takes` says what it should be.
    pub fn item(&mut self, key: &str, takes: impl Into<String>) -> Option<&'a Item> {
        self.asked.push((key.to_string(), takes.into()));
        self.table.get(key).map(|entry| &entry.item)
    }

    /// Notes that something is wrong at `place`, in this table.
    pub fn refuse(&mut self, code: Code, message: impl Into<String>, place: &Place, hint: &str) {
        let error = Error::new(code, message)
            .at(place)
            .label(format!("in {}", self.title));
        self.notes.push(if hint.is_empty() {
            error
        } else {
            error.hint(hint)
        });
    }

    /// Notes that something is wrong with the value of `key`.
    pub fn refuse_key(&mut self, code: Code, key: &str, message: impl Into<String>, hint: &str) {
        let place = self.place_of(key).clone();
        self.refuse(code, message, &place, hint);
    }

    /// Notes that `key` is missing.
    pub fn missing(&mut self, key: &str, why: &str) {
        let takes = self
            .asked
            .iter()
            .find(|(asked, _)| asked == key)
            .map_or(String::new(), |(_, takes)| format!("`{key}` takes {takes}"));
        let place = self.place.clone();
        let message = format!("{} has no `{key}`{why}", self.title);
        self.refuse(Code::MissingKey, message, &place, &takes);
    }

    /// Notes that only one of two keys may be given, if both are; true if so.
    pub fn exclusive(&mut self, one: &str, other: &str) -> bool {
        let both = self.has(one) && self.has(other);
        if both {
            let hint = format!("leave one of `{one}` and `{other}` out");
            self.refuse_key(
                Code::Conflict,
                other,
                format!("`{other}` and `{one}` exclude each other"),
                &hint,
            );
        }
        both
    }

    /// Text.
    pub fn optional_text(&mut self, key: &str) -> Option<&'a str> {
        let item = self.item(key, "text in quotes")?;
        match &item.value {
            Value::Text(text) => Some(text),
            _ => self.wrong_type(key, item, "text in quotes"),
        }
    }

    /// A quantity that may be left out.
    pub fn optional_quantity(&mut self, key: &str, kind: Kind, range: Range) -> Option<f64> {
        let item = self.item(key, kind.units())?;
        let value = self.quantity_of(key, item, kind, range)?;
        if value != 0.0 && value.abs() < SMALLEST && range != Range::Any {
            let written = units::shortened(item.place.text());
            let message = format!(
                "`{key}` is below {SMALLEST:e} in SI units, where products are lost as zero, and is {written}"
            );
            let hint = "look at its unit; where nothing is meant, write 0 or leave it out";
            self.refuse(Code::OutOfRange, message, &item.place, hint);
            return None;
        }
        Some(value)
    }

    /// A quantity; NaN where it is missing or wrong, which is then noted.
    pub fn quantity(&mut self, key: &str, kind: Kind, range: Range) -> f64 {
        let value = self.optional_quantity(key, kind, range);
        self.need(key);
        value.unwrap_or(f64::NAN)
    }

    /// A list of quantities, of `count` if that is given.
    pub fn optional_quantities(
        &mut self,
        key: &str,
        kind: Kind,
        range: Range,
        count: Option<usize>,
    ) -> Option<Vec<f64>> {
        let takes = match count {
            Some(count) => format!("a list of {count}, each in {}", kind.units()),
            None => format!("a list, each in {}", kind.units()),
        };
        let item = self.item(key, takes.as_str())?;
        let list = self.list_of(key, item, count, &takes)?;
        let values: Vec<f64> = list
            .iter()
            .filter_map(|item| self.quantity_of(key, item, kind, range))
            .collect();
        (values.len() == list.len()).then_some(values)
    }

    /// One quantity that stands for two, or a list of two.
    pub fn optional_pair(&mut self, key: &str, kind: Kind, range: Range) -> Option<[f64; 2]> {
        if let Some(Value::List(_)) = self.table.get(key).map(|entry| &entry.item.value) {
            let two = self.optional_quantities(key, kind, range, Some(2))?;
            return two.try_into().ok();
        }
        let one = self.optional_quantity(key, kind, range)?;
        Some([one, one])
    }

    /// A bare number that may be left out.
    pub fn optional_number(&mut self, key: &str, range: Range) -> Option<f64> {
        let item = self.item(key, "a bare number")?;
        self.number_of(key, item, range)
    }

    /// A whole number in `low..=high` that may be left out.
    pub fn optional_count(&mut self, key: &str, low: u32, high: u32) -> Option<u32> {
        let item = self.item(key, format!("a whole number from {low} to {high}"))?;
        self.count_of(key, item, low, high)
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
        let list = self.list_of(key, item, Some(N), &takes)?;
        let values: Vec<u32> = list
            .iter()
            .filter_map(|item| self.count_of(key, item, low, high))
            .collect();
        values.try_into().ok()
    }

    /// `true` or `false`; false where left out.
    pub fn flag(&mut self, key: &str) -> bool {
        self.optional_flag(key).unwrap_or(false)
    }

    /// `true` or `false`, where the key is there.
    pub fn optional_flag(&mut self, key: &str) -> Option<bool> {
        let item = self.item(key, "true or false")?;
        match &item.value {
            Value::Flag(flag) => Some(*flag),
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
        let Value::Text(text) = &item.value else {
            return self.wrong_type(key, item, &takes);
        };
        let found = choices.iter().find(|(word, _)| word == text);
        if found.is_none() {
            let message = format!("`{key}` cannot be \"{}\"", units::shortened(text));
            let known = choices.iter().map(|(word, _)| *word);
            let meant = suggestion(text, known)
                .map_or(String::new(), |word| format!("did you mean \"{word}\"? "));
            let hint = format!("{meant}it takes {takes}");
            self.refuse(Code::OutOfRange, message, &item.place, &hint);
            // The kind says which other keys there are.
            self.open |= key == "kind";
        }
        found.map(|(_, value)| *value)
    }

    /// Notes `key` as missing where it is absent.
    pub fn need(&mut self, key: &str) {
        if !self.has(key) {
            self.missing(key, "");
        }
    }

    /// A key starts with `start`.
    pub fn has_any(&self, start: &str) -> bool {
        self.table.entries.iter().any(|e| e.key.starts_with(start))
    }

    /// Every entry as a quantity, for tables whose keys are names.
    pub fn every_quantity(&mut self, kind: Kind, range: Range) -> Vec<(&'a Entry, f64)> {
        self.open = true;
        let entries = self.table.entries.iter();
        entries
            .filter_map(|entry| {
                let value = self.quantity_of(&entry.key, &entry.item, kind, range)?;
                Some((entry, value))
            })
            .collect()
    }

    /// Notes every key that was not asked for.
    pub fn ends(mut self) {
        for entry in &self.table.entries {
            if self.open || self.notes.full() {
                return;
            }
            if !self.asked.iter().any(|(asked, _)| *asked == entry.key) {
                self.unknown(entry);
            }
        }
    }

    fn unknown(&mut self, entry: &Entry) {
        let asked = |key: &str| self.asked.iter().any(|(asked, _)| asked == key);
        let synonyms = SYNONYMS.iter().filter(|(_, key)| asked(key));
        let known = self.asked.iter().map(|(asked, _)| asked.as_str());
        let words = known.chain(synonyms.map(|(word, _)| *word));
        let meant = suggestion(&entry.key, words).map(|word| {
            let synonym = SYNONYMS.iter().find(|(w, key)| *w == word && asked(key));
            synonym.map_or(word, |(_, key)| *key)
        });
        let hint = match meant {
            Some(meant) => {
                let takes = self.asked.iter().find(|(asked, _)| *asked == meant);
                let takes = takes.map_or("", |(_, takes)| takes);
                format!("did you mean `{meant}`? it takes {takes}")
            }
            None => format!(
                "it takes {}",
                listed(self.asked.iter().map(|a| a.0.as_str()))
            ),
        };
        let message = format!("unknown key `{}`", units::shortened(&entry.key));
        self.refuse(Code::UnknownKey, message, &entry.key_place, &hint);
    }

    /// The list in `item`, of `count` items if that is given.
    fn list_of(
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
                self.refuse(Code::WrongType, message, &item.place, &hint);
                None
            }
            _ => self.wrong_type(key, item, takes),
        }
    }

    fn quantity_of(&mut self, key: &str, item: &Item, kind: Kind, range: Range) -> Option<f64> {
        let subject = format!("`{key}`");
        let si = self.notes.is_si(&item.place);
        let value = match &item.value {
            Value::Text(text) if si => units::parse_or_bare(text, kind, kind.si_unit(), &subject),
            Value::Text(text) => units::parse(text, kind, &subject),
            Value::Integer(n) if si => Ok(units::bare_si(*n as f64, kind)),
            Value::Float(x) if si || !x.is_finite() => Ok(units::bare_si(*x, kind)),
            Value::Integer(_) | Value::Float(_) => {
                Err(units::missing_unit(item.place.text(), kind, &subject))
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
                let label = format!("in {}", self.title);
                self.notes.push(error.at(&item.place).label(label));
                None
            }
        }
    }

    /// The bare number in `item`.
    pub fn number_of(&mut self, key: &str, item: &Item, range: Range) -> Option<f64> {
        let value = match item.value {
            Value::Integer(n) => n as f64,
            Value::Float(x) => x,
            _ => return self.wrong_type(key, item, "a bare number"),
        };
        self.in_range(key, item, value, range, "a bare number")
    }

    fn in_range(
        &mut self,
        key: &str,
        item: &Item,
        value: f64,
        range: Range,
        takes: &str,
    ) -> Option<f64> {
        let Some(why) = range.refuses(value) else {
            return Some(value);
        };
        let written = units::shortened(item.place.text());
        let message = format!("`{key}` {why}, and is {written}");
        let hint = format!("`{key}` takes {takes}");
        self.refuse(Code::OutOfRange, message, &item.place, &hint);
        None
    }

    fn count_of(&mut self, key: &str, item: &Item, low: u32, high: u32) -> Option<u32> {
        let takes = format!("whole numbers from {low} to {high}");
        let count = match item.value {
            Value::Integer(n) => u32::try_from(n).ok().filter(|n| (low..=high).contains(n)),
            Value::Float(_) => None,
            _ => return self.wrong_type(key, item, &takes),
        };
        if count.is_none() {
            let message = format!("`{key}` cannot be {}", units::shortened(item.place.text()));
            let hint = format!("`{key}` takes {takes}");
            self.refuse(Code::OutOfRange, message, &item.place, &hint);
        }
        count
    }

    /// Notes a value of the wrong type.
    pub fn wrong_type<T>(&mut self, key: &str, item: &Item, takes: &str) -> Option<T> {
        let message = format!("`{key}` is {}", item.value.name());
        let hint = format!("`{key}` takes {takes}");
        self.refuse(Code::WrongType, message, &item.place, &hint);
        None
    }
}
