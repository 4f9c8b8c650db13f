//! Reads and writes `[log]`, the TOML sidecar of a recording.
//!
//! A sidecar has the log's name and ends in `.toml`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::tables::{read_table, read_tables};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::{ErrorCollector, ValueRange};
use crate::base::load;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::TableReader;
use crate::base::text::pluralise;
use crate::base::toml::{self, Item, Value};
use crate::recording::raw::Repair;
use crate::recording::read_options::{
    ChannelOptions, DialectOptions, GapPolicy, RateSource, ReadOptions, Roving,
};

/// Path of a log's sidecar: `run.csv` → `run.toml`.
pub fn sidecar_path(log: &Path) -> PathBuf {
    log.with_extension("toml")
}

/// Whether a TOML file is a sidecar.
pub fn is_sidecar(source: &Arc<SourceFile>) -> bool {
    let root = toml::parse(source).root;
    root.get("log").is_some() || root.get("channel").is_some()
}

/// The sidecar next to a log, where there is one; a file of another kind under its name is passed over, and this is noted.
///
/// # Errors
/// Everything wrong in it; that it is no TOML; that it lists the files of a test, of which the log is one.
pub fn read_for_log(log: &Path) -> Result<Option<ReadOptions>, Errors> {
    let path = sidecar_path(log);
    if !path.is_file() || path == log {
        return Ok(None);
    }
    let source = load::load(&path)?;
    let broken = toml::parse(&source).syntax_error;
    let is_other = broken.is_none() && !is_sidecar(&source);
    let (mut options, message) = match is_other {
        true => (
            ReadOptions::default(),
            format!(
                "{} holds neither [log] nor [[channel]] and is passed over",
                path.display()
            ),
        ),
        false => (read(&source)?, format!("read {}", path.display())),
    };
    if !options.files.is_empty() {
        let message = format!(
            "the sidecar of {} lists {} of a test",
            log.display(),
            pluralise(options.files.len(), "file")
        );
        let hint = format!(
            "name the list in place of the log, {}, or pass --no-sidecar",
            path.display()
        );
        return Err(Error::new(Code::Conflict, message).with_hint(hint).into());
    }
    options.sidecar_reports.push(Repair {
        kind: "sidecar",
        message,
    });
    Ok(Some(options))
}

/// The settings of a file that lists the logs of one test, their paths from its own folder; `None` where it is no such file.
///
/// # Errors
/// Everything wrong in it.
pub fn read_list(path: &Path) -> Result<Option<ReadOptions>, Errors> {
    if path.extension().is_none_or(|e| e != "toml") || !path.is_file() {
        return Ok(None);
    }
    let source = load::load(path)?;
    if toml::parse(&source).syntax_error.is_none() && !is_sidecar(&source) {
        return Ok(None);
    }
    let mut options = read(&source)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    for file in &mut options.files {
        *file = folder.join(&file);
    }
    Ok(Some(options).filter(|s| !s.files.is_empty()))
}

/// Reads a sidecar.
///
/// # Errors
/// Everything wrong in it.
pub fn read(source: &Arc<SourceFile>) -> Result<ReadOptions, Errors> {
    let document = toml::parse(source);
    let mut notes = ErrorCollector::default();
    let units = document.root.get("units").map(|entry| &entry.item.value);
    if matches!(units, Some(Value::String(text)) if text == "SI") {
        notes.bare_si.push(document.source.path.clone());
    }
    let span = SourceSpan::new(document.source.clone(), 0..0);
    let mut f = TableReader::new(&document.root, span, "the sidecar", &mut notes);
    for said in ["title", "source"] {
        f.optional_text(said);
    }
    f.item("units", "the text \"SI\"");
    f.item(
        "truth",
        "a table of what is known of a simulated recording, read by nobody here",
    );
    let mut options = read_table(&mut f, "log", log).unwrap_or_default();
    options.channels = read_tables(&mut f, "channel", channel);
    f.finish();
    let mut errors = notes.errors;
    errors.extend(document.syntax_error);
    Errors::into_result(errors, || options)
}

fn log(f: &mut TableReader) -> ReadOptions {
    let character = |text: Option<&str>| text.and_then(|t| t.chars().next());
    let dialect = DialectOptions {
        delimiter: f.choice(
            "delimiter",
            &[
                (",", ','),
                (";", ';'),
                ("tab", '\t'),
                ("space", ' '),
                ("|", '|'),
            ],
        ),
        decimal: character(f.choice("decimal", &[(".", "."), (",", ",")])),
        encoding: f.optional_text("encoding").map(str::to_string),
        header_lines: f
            .optional_count("header_lines", 0, 100_000)
            .map(|n| n as usize),
        day_first: f.choice("dates", &[("day-first", true), ("month-first", false)]),
    };
    f.exclusive("rate", "rate_from");
    let stated = f.optional_quantity("rate", QuantityKind::Frequency, ValueRange::Positive);
    let from = f.choice(
        "rate_from",
        &[
            ("time", RateSource::TimeStamps),
            ("header", RateSource::Header),
        ],
    );
    let hertz = stated.map(|omega| RateSource::Hertz(omega / std::f64::consts::TAU));
    ReadOptions {
        dialect,
        rate: hertz.or(from),
        time_column: f.optional_text("time").map(str::to_string),
        time_unit: f.optional_text("time_unit").map(str::to_string),
        channels: Vec::new(),
        keep_channels: Vec::new(),
        gaps: f
            .choice(
                "gaps",
                &[("split", GapPolicy::Split), ("fill", GapPolicy::Fill)],
            )
            .unwrap_or_default(),
        from_s: f.optional_quantity("after", QuantityKind::Time, ValueRange::NotNegative),
        to_s: f.optional_quantity("before", QuantityKind::Time, ValueRange::Positive),
        trigger: None,
        files: files(f),
        roving: f.choice(
            "roving",
            &[("input", Roving::Input), ("output", Roving::Output)],
        ),
        sidecar_reports: Vec::new(),
    }
}

/// The logs of one test, as written.
fn files(f: &mut TableReader) -> Vec<PathBuf> {
    const TAKES: &str = "a list of files, such as [\"hit_1.csv\", \"hit_2.csv\"]";
    let Some(item) = f.item("files", TAKES) else {
        return Vec::new();
    };
    let path = |item: &Item| match &item.value {
        Value::String(text) if !text.is_empty() => Some(PathBuf::from(text)),
        _ => None,
    };
    let all: Option<Vec<PathBuf>> = match &item.value {
        Value::List(list) if !list.is_empty() => list.iter().map(path).collect(),
        _ => None,
    };
    all.unwrap_or_else(|| f.wrong_type("files", item, TAKES).unwrap_or_default())
}

fn channel(f: &mut TableReader) -> ChannelOptions {
    f.require("name");
    let mut text = |key: &str| f.optional_text(key).map(str::to_string);
    ChannelOptions {
        name: text("name").unwrap_or_default(),
        rename: text("rename"),
        unit: text("unit"),
        sensitivity: text("sensitivity"),
        overload: f.optional_number("overload", ValueRange::Positive),
    }
}

/// A sidecar that says what was understood of a log, for somebody to correct.
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
        "# What was understood of the log beside this file. Correct what is wrong; what is left out is found from the log. Channels also\n# take `sensitivity`, `rename` and `overload`, the log `gaps`, `after`, `before`, `dates` (docs/reference/logs.md).\n\n[log]\n",
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
            other => other.to_string(),
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
        let said = options.channels.iter().find(|c| c.name == *name);
        text += &format!("\n[[channel]]\nname = {}\n", quoted(name));
        let unit = said.and_then(|s| s.unit.as_ref()).unwrap_or(unit);
        text += &match unit.is_empty() {
            true => "# unit = \"\"         # not stated\n".to_string(),
            false => format!("unit = {}\n", quoted(unit)),
        };
        if let Some(sensitivity) = said.and_then(|s| s.sensitivity.as_ref()) {
            text += &format!("sensitivity = {}\n", quoted(sensitivity));
        }
        if let Some(rename) = said.and_then(|s| s.rename.as_ref()) {
            text += &format!("rename = {}\n", quoted(rename));
        }
        if let Some(overload) = said.and_then(|s| s.overload) {
            text += &format!("overload = {overload:?}\n");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<ReadOptions, Errors> {
        read(&load::source_from_text("log.toml".into(), text))
    }

    /// Written laws are read back unchanged.
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
        let mut again = parsed(&text).unwrap();
        if let Some(RateSource::Hertz(rate)) = &mut again.rate {
            assert!((*rate - 331.4).abs() < 1e-12);
            *rate = 331.4;
        }
        assert_eq!(again, options);
    }

    #[test]
    fn refuses_what_it_does_not_know() {
        let errors = parsed("[log]\nrat = \"5 kHz\"\n").unwrap_err();
        assert!(errors.to_string().contains("rate"), "{errors}");
        assert!(parsed("[log]\nrate = \"5 kHz\"\nrate_from = \"time\"\n").is_err());
    }
}
