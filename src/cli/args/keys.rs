//! Command-line flags that set keys of a study: each row of a table holds a flag, its help text and the key that it sets.

use std::marker::PhantomData;
use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches, value_parser};

use crate::base::flags::{Flag, Flags};
use crate::base::table_reader::Word;

/// A flag of the command line that sets a key of a study.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// Name of the flag without leading dashes.
    pub(super) flag: &'static str,
    /// Key that the flag sets; default: the name of the flag.
    target: Option<&'static str>,
    /// Former name of the flag, still accepted.
    former: Option<&'static str>,
    value_name: &'static str,
    help: &'static str,
    form: Form,
    is_required: bool,
}

/// Type of the value.
#[derive(Debug, Clone, Copy)]
enum Form {
    /// Number, quantity or range; may begin with a minus sign.
    Number,
    Text,
    /// Comma-separated texts.
    List,
    /// One text per occurrence of the flag.
    Repeated,
    Word(fn() -> Vec<PossibleValue>),
    /// Flag without a value; sets the key to this value.
    Switch(&'static str),
    /// Output file; sets the key to true.
    File,
}

const fn key(flag: &'static str, value_name: &'static str, help: &'static str, form: Form) -> Key {
    Key {
        flag,
        target: None,
        former: None,
        value_name,
        help,
        form,
        is_required: false,
    }
}

/// Flag with a number, a quantity or a range.
pub const fn number(flag: &'static str, value_name: &'static str, help: &'static str) -> Key {
    key(flag, value_name, help, Form::Number)
}

/// Flag with a text.
pub const fn text(flag: &'static str, value_name: &'static str, help: &'static str) -> Key {
    key(flag, value_name, help, Form::Text)
}

/// Flag with comma-separated texts.
pub const fn list(flag: &'static str, value_name: &'static str, help: &'static str) -> Key {
    key(flag, value_name, help, Form::List)
}

/// Flag with a text, repeatable.
pub const fn repeated(flag: &'static str, value_name: &'static str, help: &'static str) -> Key {
    key(flag, value_name, help, Form::Repeated)
}

/// Flag with one of the words of `T`.
pub const fn word<T: Word>(flag: &'static str, name: &'static str, help: &'static str) -> Key {
    key(flag, name, help, Form::Word(words::<T>))
}

/// Flag without a value, which sets its key to true.
pub const fn switch(flag: &'static str, help: &'static str) -> Key {
    key(flag, "", help, Form::Switch("true"))
}

/// Flag with the path of an output file, which sets its key to true.
pub const fn file(flag: &'static str, help: &'static str) -> Key {
    key(flag, "FILE", help, Form::File)
}

/// Value parser for the words of `T`.
pub fn word_parser<T: Word + Send + Sync>() -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(words::<T>()).try_map(|text| {
        let entry = T::WORDS.iter().find(|(word, ..)| *word == text);
        entry.map(|(_, value, _)| *value).ok_or("no such word")
    })
}

fn words<T: Word>() -> Vec<PossibleValue> {
    let value = |w: &(&'static str, T, &'static str)| PossibleValue::new(w.0).help(w.2);
    T::WORDS.iter().map(value).collect()
}

impl Key {
    /// Sets the key, where its name is not that of the flag.
    pub const fn sets(self, key: &'static str) -> Key {
        Key {
            target: Some(key),
            ..self
        }
    }

    /// Changes the flag to one without a value, which sets its key to `value`.
    pub const fn to(self, value: &'static str) -> Key {
        Key {
            form: Form::Switch(value),
            ..self
        }
    }

    /// Makes the flag mandatory.
    pub const fn required(self) -> Key {
        Key {
            is_required: true,
            ..self
        }
    }

    /// Accepts the flag under its former name too.
    pub const fn formerly(self, name: &'static str) -> Key {
        Key {
            former: Some(name),
            ..self
        }
    }

    pub(super) fn key(&self) -> String {
        self.target.unwrap_or(self.flag).replace('-', "_")
    }

    fn arg(&self) -> Arg {
        let arg = Arg::new(self.flag)
            .long(self.flag)
            .help(self.help)
            .required(self.is_required);
        let arg = match self.form {
            Form::Switch(_) => return arg.action(ArgAction::SetTrue),
            Form::Number => arg.allow_hyphen_values(true),
            Form::Text => arg,
            Form::List => arg.action(ArgAction::Append).value_delimiter(','),
            Form::Repeated => arg.action(ArgAction::Append),
            Form::Word(words) => arg.value_parser(PossibleValuesParser::new(words())),
            Form::File => arg.value_parser(value_parser!(PathBuf)),
        };
        match self.former {
            Some(former) => arg.alias(former).value_name(self.value_name),
            None => arg.value_name(self.value_name),
        }
    }

    /// The flag with its values, if it is on the command line.
    fn flag_value(&self, matches: &ArgMatches) -> Option<Flag> {
        if matches.value_source(self.flag) != Some(ValueSource::CommandLine) {
            return None;
        }
        let raw = matches.get_raw(self.flag).unwrap_or_default();
        let values = raw
            .map(|value| value.to_string_lossy().into_owned())
            .collect();
        Some(Flag {
            name: format!("--{}", self.flag),
            key: self.key(),
            values: match self.form {
                Form::Switch(value) => vec![value.to_string()],
                Form::File => vec!["true".to_string()],
                _ => values,
            },
            is_list: matches!(self.form, Form::List | Form::Repeated),
            is_switch: matches!(self.form, Form::Switch(_) | Form::File),
        })
    }
}

/// Keys in help order, by heading.
pub type KeyGroups = &'static [(Option<&'static str>, &'static [Key])];

/// Command whose flags are keys of a study.
pub trait KeyTable {
    /// Keys by heading.
    const KEYS: KeyGroups;
}

/// Flags of a [`KeyTable`] present on the command line.
#[derive(Debug, Clone)]
pub struct KeyFlags<K> {
    /// Flags as a table that overrides the table of a file.
    pub flags: Flags,
    names: Vec<&'static str>,
    files: Vec<(&'static str, PathBuf)>,
    keys: PhantomData<K>,
}

impl<K: KeyTable> KeyFlags<K> {
    /// Whether the flag is on the command line.
    pub fn has(&self, flag: &str) -> bool {
        self.names.contains(&flag)
    }

    /// Path given with a file flag.
    pub fn file(&self, flag: &str) -> Option<PathBuf> {
        let entry = self.files.iter().find(|(name, _)| *name == flag);
        entry.map(|(_, path)| path.clone())
    }
}

impl<K: KeyTable> Args for KeyFlags<K> {
    fn augment_args(command: Command) -> Command {
        let keys = || K::KEYS.iter().flat_map(|(_, keys)| *keys);
        let arg = |key: &Key| {
            // Two flags that set one key exclude each other.
            let rivals = keys().filter(|other| other.flag != key.flag && other.key() == key.key());
            key.arg().conflicts_with_all(rivals.map(|other| other.flag))
        };
        let command = K::KEYS.iter().fold(command, |command, (heading, keys)| {
            let command = command.next_help_heading(*heading);
            command.args(keys.iter().map(arg))
        });
        command.next_help_heading(None::<&str>)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<K: KeyTable> FromArgMatches for KeyFlags<K> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let keys = || K::KEYS.iter().flat_map(|(_, keys)| *keys);
        let flags: Vec<(&Key, Flag)> = keys()
            .filter_map(|key| Some((key, key.flag_value(matches)?)))
            .collect();
        let path = |key: &Key| match key.form {
            Form::File => Some((key.flag, matches.get_one::<PathBuf>(key.flag)?.clone())),
            _ => None,
        };
        Ok(KeyFlags {
            names: flags.iter().map(|(key, _)| key.flag).collect(),
            files: flags.iter().filter_map(|(key, _)| path(key)).collect(),
            flags: Flags::new(&flags.into_iter().map(|(_, flag)| flag).collect::<Vec<_>>()),
            keys: PhantomData,
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
