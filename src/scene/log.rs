//! `[log]`: the sidecar of a recording, which says what its file does not. A sidecar has the log's name and ends in `.toml`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::tables::{each, one};
use crate::base::error::Errors;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::load;
use crate::base::notes::{Notes, Range};
use crate::base::place::{Place, Source};
use crate::base::toml::{self, Item, Value};
use crate::recording::raw::Repair;
use crate::recording::settings::{
    ChannelSettings, DialectSettings, Gaps, RateSource, Roving, Settings,
};

/// Where the sidecar of a log lies: `run.csv` → `run.toml`.
pub fn beside(log: &Path) -> PathBuf {
    log.with_extension("toml")
}

/// Whether a TOML file is a sidecar.
pub fn is_sidecar(source: &Arc<Source>) -> bool {
    let root = toml::parse(source).root;
    root.get("log").is_some() || root.get("channel").is_some()
}

/// The sidecar beside a log, where there is one; a file of another kind under its name is passed over, and this is noted.
///
/// # Errors
/// Everything wrong in it; that it is no TOML.
pub fn read_beside(log: &Path) -> Result<Option<Settings>, Errors> {
    let path = beside(log);
    if !path.is_file() || path == log {
        return Ok(None);
    }
    let source = load::load(&path)?;
    let broken = toml::parse(&source).broken;
    let is_other = broken.is_none() && !is_sidecar(&source);
    let (mut settings, message) = match is_other {
        true => (
            Settings::default(),
            format!(
                "{} holds neither [log] nor [[channel]] and is passed over",
                path.display()
            ),
        ),
        false => (read(&source)?, format!("read {}", path.display())),
    };
    settings.notes.push(Repair {
        kind: "sidecar",
        message,
    });
    Ok(Some(settings))
}

/// The settings of a file that lists the logs of one test, their paths from its own folder; `None` where it is no such file.
///
/// # Errors
/// Everything wrong in it.
pub fn read_list(path: &Path) -> Result<Option<Settings>, Errors> {
    if path.extension().is_none_or(|e| e != "toml") || !path.is_file() {
        return Ok(None);
    }
    let source = load::load(path)?;
    if toml::parse(&source).broken.is_none() && !is_sidecar(&source) {
        return Ok(None);
    }
    let mut settings = read(&source)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    for file in &mut settings.files {
        *file = folder.join(&file);
    }
    Ok(Some(settings).filter(|s| !s.files.is_empty()))
}

/// Reads a sidecar.
///
/// # Errors
/// Everything wrong in it.
pub fn read(source: &Arc<Source>) -> Result<Settings, Errors> {
    let document = toml::parse(source);
    let mut notes = Notes::default();
    let units = document.root.get("units").map(|entry| &entry.item.value);
    if matches!(units, Some(Value::Text(text)) if text == "SI") {
        notes.bare_si.push(document.source.path.clone());
    }
    let place = Place::new(document.source.clone(), 0..0);
    let mut f = Fields::new(&document.root, place, "the sidecar", &mut notes);
    for said in ["title", "source"] {
        f.optional_text(said);
    }
    f.item("units", "the text \"SI\"");
    f.item(
        "truth",
        "a table of what is known of a simulated recording, read by nobody here",
    );
    let mut settings = one(&mut f, "log", log).unwrap_or_default();
    settings.channels = each(&mut f, "channel", channel);
    f.ends();
    let mut errors = notes.errors;
    errors.extend(document.broken);
    Errors::or(errors, || settings)
}

fn log(f: &mut Fields) -> Settings {
    let character = |text: Option<&str>| text.and_then(|t| t.chars().next());
    let dialect = DialectSettings {
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
    let stated = f.optional_quantity("rate", Kind::Frequency, Range::Positive);
    let from = f.choice(
        "rate_from",
        &[("time", RateSource::Time), ("header", RateSource::Header)],
    );
    let hertz = stated.map(|omega| RateSource::Hertz(omega / std::f64::consts::TAU));
    Settings {
        dialect,
        rate: hertz.or(from),
        time_column: f.optional_text("time").map(str::to_string),
        time_unit: f.optional_text("time_unit").map(str::to_string),
        channels: Vec::new(),
        only: Vec::new(),
        gaps: f
            .choice("gaps", &[("split", Gaps::Split), ("fill", Gaps::Fill)])
            .unwrap_or_default(),
        from_s: f.optional_quantity("after", Kind::Time, Range::NotNegative),
        to_s: f.optional_quantity("before", Kind::Time, Range::Positive),
        trigger: None,
        files: files(f),
        roving: f.choice(
            "roving",
            &[("input", Roving::Input), ("output", Roving::Output)],
        ),
        notes: Vec::new(),
    }
}

/// The logs of one test, as written.
fn files(f: &mut Fields) -> Vec<PathBuf> {
    const TAKES: &str = "a list of files, such as [\"hit_1.csv\", \"hit_2.csv\"]";
    let Some(item) = f.item("files", TAKES) else {
        return Vec::new();
    };
    let path = |item: &Item| match &item.value {
        Value::Text(text) if !text.is_empty() => Some(PathBuf::from(text)),
        _ => None,
    };
    let all: Option<Vec<PathBuf>> = match &item.value {
        Value::List(list) if !list.is_empty() => list.iter().map(path).collect(),
        _ => None,
    };
    all.unwrap_or_else(|| f.wrong_type("files", item, TAKES).unwrap_or_default())
}

fn channel(f: &mut Fields) -> ChannelSettings {
    f.need("name");
    let mut text = |key: &str| f.optional_text(key).map(str::to_string);
    ChannelSettings {
        name: text("name").unwrap_or_default(),
        rename: text("rename"),
        unit: text("unit"),
        sensitivity: text("sensitivity"),
        overload: f.optional_number("overload", Range::Positive),
    }
}

/// A sidecar that says what was understood of a log, for somebody to correct.
pub fn write(settings: &Settings, rate_hz: Option<f64>, channels: &[(String, String)]) -> String {
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
    text += &match settings.rate {
        Some(RateSource::Time) => "rate_from = \"time\"\n".to_string(),
        Some(RateSource::Header) => "rate_from = \"header\"\n".to_string(),
        Some(RateSource::Hertz(rate)) => format!("rate = \"{rate} Hz\"\n"),
        None => rate_hz.map_or(String::new(), |rate| format!("rate = \"{rate} Hz\"\n")),
    };
    if let (Some(RateSource::Time | RateSource::Header), Some(rate)) = (settings.rate, rate_hz) {
        text += &format!("# {rate} Hz\n");
    }
    for (key, value) in [
        ("time", &settings.time_column),
        ("time_unit", &settings.time_unit),
        ("encoding", &settings.dialect.encoding),
    ] {
        if let Some(value) = value {
            text += &format!("{key} = {}\n", quoted(value));
        }
    }
    if let Some(delimiter) = settings.dialect.delimiter {
        let word = match delimiter {
            '\t' => "tab".to_string(),
            ' ' => "space".to_string(),
            other => other.to_string(),
        };
        text += &format!("delimiter = \"{word}\"\n");
    }
    if let Some(decimal) = settings.dialect.decimal {
        text += &format!("decimal = \"{decimal}\"\n");
    }
    if let Some(lines) = settings.dialect.header_lines {
        text += &format!("header_lines = {lines}\n");
    }
    if let Some(day_first) = settings.dialect.day_first {
        text += &format!(
            "dates = \"{}-first\"\n",
            if day_first { "day" } else { "month" }
        );
    }
    if settings.gaps == Gaps::Fill {
        text += "gaps = \"fill\"\n";
    }
    for (key, time) in [("after", settings.from_s), ("before", settings.to_s)] {
        if let Some(time) = time {
            text += &format!("{key} = \"{time} s\"\n");
        }
    }
    for (name, unit) in channels {
        let said = settings.channels.iter().find(|c| c.name == *name);
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

    fn parsed(text: &str) -> Result<Settings, Errors> {
        read(&load::source("log.toml".into(), text))
    }

    /// What is written is read again the same.
    #[test]
    fn law_round_trip() {
        let settings = Settings {
            rate: Some(RateSource::Hertz(331.4)),
            time_column: Some("t \"x\"".into()),
            dialect: DialectSettings {
                delimiter: Some('\t'),
                decimal: Some(','),
                ..DialectSettings::default()
            },
            gaps: Gaps::Fill,
            from_s: Some(0.5),
            channels: vec![ChannelSettings {
                name: "ax".into(),
                unit: Some("mV".into()),
                sensitivity: Some("100 mV/g".into()),
                overload: Some(5.0),
                ..ChannelSettings::default()
            }],
            ..Settings::default()
        };
        let text = write(&settings, Some(331.4), &[("ax".into(), "V".into())]);
        let mut again = parsed(&text).unwrap();
        if let Some(RateSource::Hertz(rate)) = &mut again.rate {
            assert!((*rate - 331.4).abs() < 1e-12);
            *rate = 331.4;
        }
        assert_eq!(again, settings);
    }

    #[test]
    fn refuses_what_it_does_not_know() {
        let errors = parsed("[log]\nrat = \"5 kHz\"\n").unwrap_err();
        assert!(errors.to_string().contains("rate"), "{errors}");
        assert!(parsed("[log]\nrate = \"5 kHz\"\nrate_from = \"time\"\n").is_err());
    }
}
