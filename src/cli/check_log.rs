//! `geardyn check LOG`: what was understood of a log, before it is used.

use std::path::Path;

use serde_json::{Value, json};

use super::args::LogArgs;
use super::{epilogue, files, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors, Warning};
use crate::recording::raw::{Raw, Repair};
use crate::recording::settings::{RateSource, Settings};
use crate::recording::survey::{Survey, survey};
use crate::recording::{faults, settle};
use crate::report;
use crate::scene;

/// A log as understood: for a terminal and as JSON.
pub struct Understood {
    /// The table.
    pub text: String,
    /// The document.
    pub json: Value,
    /// Doubts and repairs, as text.
    pub doubts: String,
}

/// Reads and surveys a log; `write` also writes its sidecar.
///
/// # Errors
/// Whatever is wrong with the log, the flags or the sidecar.
pub fn check(path: &Path, args: &LogArgs, write: bool) -> Result<Understood, Errors> {
    let target = scene::log::beside(path);
    if write && target.symlink_metadata().is_ok() {
        let message = format!("{} exists and would be overwritten", target.display());
        return Err(Error::new(Code::Usage, message)
            .hint("correct it as it is, or move it away first")
            .into());
    }
    let settings = args.settings(path)?.0;
    let mut raw = progress::open(path, &settings, false)?;
    let written: Vec<(String, String)> = raw
        .groups
        .iter()
        .flat_map(|g| &g.channels)
        .map(|c| (c.name.clone(), c.unit.clone()))
        .collect();
    let mut understood = settings.clone();
    if write {
        understand(&mut understood, &raw);
    }
    let (responses, spectra) = (raw.responses.take(), std::mem::take(&mut raw.spectra));
    let over_frequency = report::log_tables::over_frequency(responses.as_ref(), &spectra);
    let (mut found, rate_hz) = match raw.groups.is_empty() && !over_frequency.is_empty() {
        true => {
            let found = Understood {
                text: format!("{}   {}\n", raw.path, raw.dialect),
                json: report::recording::without_channels(&raw),
                doubts: doubts(&raw.repairs, &raw.warnings),
            };
            (found, None)
        }
        false => {
            let mut recording = settle::settle(raw, &settings)?;
            let surveys = recording
                .channels
                .iter()
                .map(|c| survey(&recording, c))
                .collect::<Result<Vec<Survey>, Error>>()?;
            let all: Vec<usize> = (0..recording.channels.len()).collect();
            let stuck = faults::find_stuck(&recording, &all)?;
            let stuck = stuck.stuck_warnings(&recording, false);
            recording.warnings.extend(stuck);
            let found = Understood {
                text: report::log_tables::survey(&recording, &surveys),
                json: report::recording::json(&recording, &surveys),
                doubts: doubts(&recording.repairs, &recording.warnings),
            };
            (found, Some(recording.rate_hz))
        }
    };
    found.text += &over_frequency;
    if let Value::Object(map) = &mut found.json {
        map.shift_insert(0, "geardyn".to_string(), report::json::log_header(&[]));
        let responses = responses.as_ref().map(report::recording::responses);
        map.insert("responses".to_string(), json!(responses));
        let spectra = report::recording::spectra(&spectra);
        map.insert("spectra".to_string(), spectra);
    }
    if write {
        let text = scene::log::write(&understood, rate_hz, &written);
        files::write_one(&target, text.as_bytes())?;
        found.doubts += &format!("wrote {}\n", target.display());
    }
    Ok(found)
}

/// What was found of a log, beside what was said of it.
fn understand(settings: &mut Settings, raw: &Raw) {
    let (said, found) = (&mut settings.dialect, &raw.layout);
    said.delimiter = said.delimiter.or(found.delimiter);
    said.decimal = said.decimal.or(found.decimal);
    said.encoding = said.encoding.take().or(found.encoding.clone());
    said.header_lines = said.header_lines.or(found.header_lines);
    // Of a text; other formats say themselves which numbers are times.
    let one = raw
        .groups
        .first()
        .filter(|_| raw.groups.len() == 1 && found.decimal.is_some());
    let Some(clock) = one.map(|group| &group.clock) else {
        return;
    };
    let Some(stamps) = &clock.stamps else {
        return;
    };
    if stamps.unit != "samples" {
        settings
            .time_column
            .get_or_insert_with(|| stamps.name.clone());
        settings.rate.get_or_insert(RateSource::Time);
    }
    if stamps.unit != "date-time" && stamps.unit != "samples" {
        settings
            .time_unit
            .get_or_insert_with(|| stamps.unit.clone());
    }
}

/// What was done to the data, and what is in doubt.
fn doubts(repairs: &[Repair], warnings: &[Warning]) -> String {
    epilogue::repairs(repairs) + &epilogue::warnings(warnings)
}
