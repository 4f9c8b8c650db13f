//! Reader and writer of the TOML sidecar of a recording, with tables `[log]` and `[[channel]]`.
//!
//! A sidecar has the name of the log with the extension `.toml`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::{ErrorCollector, ValueRange};
use crate::base::flags::Flags;
use crate::base::load;
use crate::base::quantity::truncate;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::{TableReader, Word};
use crate::base::tables::{read_table, read_tables};
use crate::base::text::pluralise;
use crate::base::toml::{self, Item, Value};
use crate::recording::geometry::{ChannelPlace, Geometry};
use crate::recording::raw::Repair;
use crate::recording::read_options::{
    ChannelOptions, DialectOptions, GapPolicy, RateSource, ReadOptions, Roving, Trigger,
};
use crate::recording::sidecar_geometry::{read_geometry, read_place};

/// Path of a log's sidecar: `run.csv` → `run.toml`.
pub fn sidecar_path(log: &Path) -> PathBuf {
    log.with_extension("toml")
}

/// Whether a TOML file is a sidecar: it has a table `log` or `channel`.
pub fn is_sidecar(source: &Arc<SourceFile>) -> bool {
    let root = toml::parse(source).root;
    root.get("log").is_some() || root.get("channel").is_some()
}

/// Reads the options of a log, with flags taking precedence over its sidecar, and the path of the sidecar, if there is one.
/// A TOML file without the tables of a sidecar is skipped with a report.
///
/// # Errors
/// All errors of the sidecar and of the flags; invalid TOML; a sidecar that lists several logs.
pub fn read_for_log(log: &Path, flags: &Flags) -> Result<(ReadOptions, Option<PathBuf>), Errors> {
    let path = sidecar_path(log);
    if !path.is_file() || path == log {
        return Ok((from_flags(flags)?, None));
    }
    let source = load::load(&path)?;
    let syntax_error = toml::parse(&source).syntax_error;
    let is_other = syntax_error.is_none() && !is_sidecar(&source);
    let (mut options, message) = match is_other {
        true => (
            from_flags(flags)?,
            format!(
                "{} contains neither [log] nor [[channel]] and is ignored",
                path.display()
            ),
        ),
        false => (read(&source, flags)?, format!("read {}", path.display())),
    };
    if !options.files.is_empty() {
        let files = pluralise(options.files.len(), "file");
        let message = format!("the sidecar of {} lists {files} of a test", log.display());
        let path = path.display();
        let hint = format!("name the list in place of the log, {path}, or pass --no-sidecar");
        return Err(Error::new(Code::Conflict, message).with_hint(hint).into());
    }
    options.sidecar_reports.push(Repair {
        kind: "sidecar",
        message,
    });
    Ok((options, Some(path)))
}

/// Reads the options of a log without a sidecar.
///
/// # Errors
/// All errors of the flags.
pub fn from_flags(flags: &Flags) -> Result<ReadOptions, Errors> {
    read(&load::source_from_text(String::new(), ""), flags)
}

/// Reads a file that lists the logs of one test, with paths relative to its folder; `None` if it is not such a file.
///
/// # Errors
/// All errors of the file and of the flags; every listed file that does not exist.
pub fn read_list(path: &Path, flags: &Flags) -> Result<Option<ReadOptions>, Errors> {
    if path.extension().is_none_or(|e| e != "toml") || !path.is_file() {
        return Ok(None);
    }
    let source = load::load(path)?;
    if toml::parse(&source).syntax_error.is_none() && !is_sidecar(&source) {
        return Ok(None);
    }
    let mut options = read(&source, flags)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    for file in &mut options.files {
        *file = folder.join(&file);
    }
    let missing = options.files.iter().filter(|file| !file.exists());
    let error = |file: &PathBuf| {
        let message = format!("{} is listed but does not exist", file.display());
        Error::new(Code::FileMissing, message)
            .with_hint("give paths relative to the folder of the list")
            .with_file(&path.display().to_string())
    };
    Errors::into_result(missing.map(error).collect(), || ())?;
    Ok(Some(options).filter(|s| !s.files.is_empty()))
}

/// Reads a sidecar; flags take precedence over its `[log]`.
///
/// # Errors
/// All errors of the sidecar and of the flags.
pub fn read(source: &Arc<SourceFile>, flags: &Flags) -> Result<ReadOptions, Errors> {
    let document = toml::parse(source);
    let mut notes = ErrorCollector::default();
    notes.record_units(&document);
    let span = SourceSpan::new(document.source.clone(), 0..0);
    let mut f = TableReader::new(&document.root, span, "the sidecar", &mut notes);
    for key in ["title", "source"] {
        f.optional_text(key);
    }
    f.item("units", "the text \"SI\"");
    f.item(
        "truth",
        "the known answer of a simulated recording, which geardyn does not read",
    );
    let mut options = read_table(&mut f, "log", read_log).unwrap_or_default();
    let mut geometry = read_geometry(&mut f);
    let channels = read_tables(&mut f, "channel", |f| channel(f, &geometry));
    f.finish();
    let mut errors = notes.errors;
    errors.extend(document.syntax_error.clone());
    Errors::into_result(errors, || ())?;
    options = flags.read_over(&document, "log", &notes.bare_si, options, read_log)?;
    let (channels, places): (Vec<_>, Vec<_>) = channels.into_iter().unzip();
    options.channels = merge(channels, options.channels);
    geometry.channels = places.into_iter().flatten().collect();
    options.geometry = geometry;
    Ok(options)
}

/// Overrides the properties of channels by those stated in flags or in `[log]`.
fn merge(mut channels: Vec<ChannelOptions>, updates: Vec<ChannelOptions>) -> Vec<ChannelOptions> {
    for update in updates {
        match channels.iter_mut().find(|c| c.name == update.name) {
            Some(channel) => {
                channel.unit = update.unit.or(channel.unit.take());
                channel.sensitivity = update.sensitivity.or(channel.sensitivity.take());
                channel.overload = update.overload.or(channel.overload);
            }
            None => channels.push(update),
        }
    }
    channels
}

impl Word for RateSource {
    const WORDS: &'static [(&'static str, RateSource, &'static str)] = &[
        ("time", RateSource::TimeStamps, "The time stamps"),
        ("header", RateSource::Header, "The header"),
    ];
}

impl Word for Roving {
    const WORDS: &'static [(&'static str, Roving, &'static str)] = &[
        ("input", Roving::Input, "The force"),
        ("output", Roving::Output, "The sensor of the response"),
    ];
}

/// Delimiters between cells, by name.
const DELIMITERS: &[(&str, char)] = &[
    (",", ','),
    (";", ';'),
    ("tab", '\t'),
    ("space", ' '),
    ("|", '|'),
    ("comma", ','),
    ("semicolon", ';'),
    ("\t", '\t'),
    (" ", ' '),
];

fn read_log(f: &mut TableReader) -> ReadOptions {
    let text = |f: &mut TableReader, key: &str| f.optional_text(key).map(str::to_string);
    let time = |f: &mut TableReader, key: &str, range: ValueRange| {
        f.optional_quantity(key, QuantityKind::Time, range)
    };
    let header_lines = f.optional_count("header_lines", 0, 100_000);
    let dialect = DialectOptions {
        delimiter: f.choice("delimiter", DELIMITERS),
        decimal: f.choice("decimal", &[(".", '.'), (",", ',')]),
        encoding: text(f, "encoding"),
        header_lines: header_lines.map(|n| n as usize),
        day_first: f.choice("dates", &[("day-first", true), ("month-first", false)]),
    };
    f.exclusive("rate", "rate_from");
    let stated = f.optional_quantity("rate", QuantityKind::Frequency, ValueRange::Positive);
    let source = f.word("rate_from");
    let hertz = stated.map(|omega| RateSource::Hertz(omega / std::f64::consts::TAU));
    let gaps = [("split", GapPolicy::Split), ("fill", GapPolicy::Fill)];
    f.requires("pre_trigger", "trigger");
    let before_s = time(f, "pre_trigger", ValueRange::NotNegative).unwrap_or(0.0);
    let trigger = f.parsed("trigger", parse_level);
    ReadOptions {
        dialect,
        rate: hertz.or(source),
        time_column: text(f, "time"),
        time_unit: text(f, "time_unit"),
        channels: stated_channels(f),
        geometry: Geometry::default(),
        keep_channels: Vec::new(),
        gaps: f.choice("gaps", &gaps).unwrap_or_default(),
        from_s: time(f, "after", ValueRange::NotNegative),
        to_s: time(f, "before", ValueRange::Positive),
        trigger: trigger.map(|(channel, level)| Trigger {
            channel,
            level,
            before_s,
        }),
        files: read_files(f),
        roving: f.word("roving"),
        sidecar_reports: Vec::new(),
    }
}

/// Reads channel properties stated as `ax=g`, one property each.
fn stated_channels(f: &mut TableReader) -> Vec<ChannelOptions> {
    let mut channels = Vec::new();
    for key in ["unit", "sensitivity", "overload"] {
        for text in f.texts(key) {
            match parse_channel(key, &text) {
                Ok(channel) => channels.push(channel),
                Err(error) => {
                    let span = f.span_of(key).clone();
                    f.push(error, &span);
                }
            }
        }
    }
    channels
}

fn parse_channel(key: &str, text: &str) -> Result<ChannelOptions, Error> {
    let subject = format!("`{key}`");
    let (name, value) = parse_pair(text, &subject)?;
    let mut channel = ChannelOptions {
        name: name.to_string(),
        ..ChannelOptions::default()
    };
    match key {
        "unit" => channel.unit = Some(value.to_string()),
        "sensitivity" => channel.sensitivity = Some(value.to_string()),
        _ => channel.overload = Some(parse_level(text, &subject)?.1),
    }
    Ok(channel)
}

/// Parses a channel and a positive level, `force=5`.
fn parse_level(text: &str, subject: &str) -> Result<(String, f64), Error> {
    let (name, level) = parse_pair(text, subject)?;
    let level = level
        .parse()
        .ok()
        .filter(|l: &f64| *l > 0.0 && l.is_finite());
    match level {
        Some(level) => Ok((name.to_string(), level)),
        None => {
            let message = format!("\"{}\" names no level above zero", truncate(text));
            let hint = format!("{subject} takes a channel and a level, such as force=5");
            Err(Error::new(Code::Usage, message).with_hint(hint))
        }
    }
}

fn parse_pair<'t>(text: &'t str, subject: &str) -> Result<(&'t str, &'t str), Error> {
    // Channel names may contain an equals sign, units do not.
    let pair = text
        .rsplit_once('=')
        .map(|(name, value)| (name.trim(), value.trim()));
    let complete = pair.filter(|(name, value)| !name.is_empty() && !value.is_empty());
    complete.ok_or_else(|| {
        let message = format!(
            "\"{}\" does not name a channel and its property",
            truncate(text)
        );
        let hint =
            format!("{subject} takes channel=value, such as ax=g, \"ax=100 mV/g\" or force=5");
        Error::new(Code::Usage, message).with_hint(hint)
    })
}

/// Reads the paths of the logs of one test, as written.
fn read_files(f: &mut TableReader) -> Vec<PathBuf> {
    const TAKES: &str = "a list of files, such as [\"hit_1.csv\", \"hit_2.csv\"]";
    let Some(item) = f.item("files", TAKES) else {
        return Vec::new();
    };
    let path = |item: &Item| match &item.value {
        Value::String(text) if !text.is_empty() => Some(PathBuf::from(text)),
        _ => None,
    };
    let paths: Option<Vec<PathBuf>> = match &item.value {
        Value::List(list) if !list.is_empty() => list.iter().map(path).collect(),
        _ => None,
    };
    paths.unwrap_or_else(|| f.wrong_type("files", item, TAKES).unwrap_or_default())
}

fn channel(f: &mut TableReader, geometry: &Geometry) -> (ChannelOptions, Option<ChannelPlace>) {
    f.require("name");
    let place = read_place(f, geometry);
    let mut text = |key: &str| f.optional_text(key).map(str::to_string);
    let options = ChannelOptions {
        name: text("name").unwrap_or_default(),
        rename: text("rename"),
        unit: text("unit"),
        sensitivity: text("sensitivity"),
        overload: f.optional_number("overload", ValueRange::Positive),
    };
    (options, place)
}

/// Writes a sidecar with the options detected in a log, for correction by the user; `channels` are names and units.
pub fn write(options: &ReadOptions, rate_hz: Option<f64>, channels: &[(String, String)]) -> String {
    let quoted = |text: &str| {
        format!(
            "\"{}\"",
            text.replace('\\', "\\\\")
                .replace('"', "\\\"")
                .replace(['\n', '\r', '\t'], " ")
        )
    };
    let mut text = String::from(
        "# How geardyn read the log of this name. Correct what is wrong; keys that are omitted are detected from the log. Channels also\n# take `sensitivity`, `rename` and `overload`, the log `gaps`, `after`, `before`, `dates` (docs/reference/logs.md).\n\n[log]\n",
    );
    text += &match options.rate {
        Some(RateSource::TimeStamps) => "rate_from = \"time\"\n".to_string(),
        Some(RateSource::Header) => "rate_from = \"header\"\n".to_string(),
        Some(RateSource::Hertz(rate)) => format!("rate = \"{rate} Hz\"\n"),
        None => rate_hz.map_or(String::new(), |rate| format!("rate = \"{rate} Hz\"\n")),
    };
    if let (Some(RateSource::TimeStamps | RateSource::Header), Some(rate)) = (options.rate, rate_hz)
    {
        text += &format!("# {rate} Hz\n");
    }
    for (key, value) in [
        ("time", &options.time_column),
        ("time_unit", &options.time_unit),
        ("encoding", &options.dialect.encoding),
    ] {
        if let Some(value) = value {
            text += &format!("{key} = {}\n", quoted(value));
        }
    }
    if let Some(delimiter) = options.dialect.delimiter {
        let word = match delimiter {
            '\t' => "tab".to_string(),
            ' ' => "space".to_string(),
            mark => mark.to_string(),
        };
        text += &format!("delimiter = \"{word}\"\n");
    }
    if let Some(decimal) = options.dialect.decimal {
        text += &format!("decimal = \"{decimal}\"\n");
    }
    if let Some(lines) = options.dialect.header_lines {
        text += &format!("header_lines = {lines}\n");
    }
    if let Some(day_first) = options.dialect.day_first {
        text += &format!(
            "dates = \"{}-first\"\n",
            if day_first { "day" } else { "month" }
        );
    }
    if options.gaps == GapPolicy::Fill {
        text += "gaps = \"fill\"\n";
    }
    for (key, time) in [("after", options.from_s), ("before", options.to_s)] {
        if let Some(time) = time {
            text += &format!("{key} = \"{time} s\"\n");
        }
    }
    for (name, unit) in channels {
        let stated = options.channels.iter().find(|c| c.name == *name);
        text += &format!("\n[[channel]]\nname = {}\n", quoted(name));
        let unit = stated.and_then(|s| s.unit.as_ref()).unwrap_or(unit);
        text += &match unit.is_empty() {
            true => "# unit = \"\"         # not stated\n".to_string(),
            false => format!("unit = {}\n", quoted(unit)),
        };
        if let Some(sensitivity) = stated.and_then(|s| s.sensitivity.as_ref()) {
            text += &format!("sensitivity = {}\n", quoted(sensitivity));
        }
        if let Some(rename) = stated.and_then(|s| s.rename.as_ref()) {
            text += &format!("rename = {}\n", quoted(rename));
        }
        if let Some(overload) = stated.and_then(|s| s.overload) {
            text += &format!("overload = {overload:?}\n");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<ReadOptions, Errors> {
        read(
            &load::source_from_text("log.toml".into(), text),
            &Flags::default(),
        )
    }

    /// Written sidecars are read back unchanged.
    #[test]
    fn law_round_trip() {
        let options = ReadOptions {
            rate: Some(RateSource::Hertz(331.4)),
            time_column: Some("t \"x\"".into()),
            dialect: DialectOptions {
                delimiter: Some('\t'),
                decimal: Some(','),
                ..DialectOptions::default()
            },
            gaps: GapPolicy::Fill,
            from_s: Some(0.5),
            channels: vec![ChannelOptions {
                name: "ax".into(),
                unit: Some("mV".into()),
                sensitivity: Some("100 mV/g".into()),
                overload: Some(5.0),
                ..ChannelOptions::default()
            }],
            ..ReadOptions::default()
        };
        let text = write(&options, Some(331.4), &[("ax".into(), "V".into())]);
        let mut reread = parsed(&text).unwrap();
        if let Some(RateSource::Hertz(rate)) = &mut reread.rate {
            assert!((*rate - 331.4).abs() < 1e-12);
            *rate = 331.4;
        }
        assert_eq!(reread, options);
    }

    #[test]
    fn refuses_what_it_does_not_know() {
        let errors = parsed("[log]\nrat = \"5 kHz\"\n").unwrap_err();
        assert!(errors.to_string().contains("rate"), "{errors}");
        assert!(parsed("[log]\nrate = \"5 kHz\"\nrate_from = \"time\"\n").is_err());
    }
}
