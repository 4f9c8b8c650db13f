//! `geardyn check LOG`: what was detected in a log.

use std::path::Path;

use serde_json::json;

use super::args::LogArgs;
use super::{files, footer, output, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::numeric::parallel;
use crate::recording::channel_statistics::channel_statistics;
use crate::recording::raw::RawLog;
use crate::recording::read_options::{RateSource, ReadOptions};
use crate::recording::sidecar;
use crate::recording::{faults, preprocess};
use crate::report::check::FileSummary;
use crate::report::recording;

/// Reads and surveys a log; `write` also writes its sidecar.
///
/// # Errors
/// Whatever is wrong with the log, the flags or the sidecar.
pub fn check(path: &Path, args: &LogArgs, write: bool) -> Result<FileSummary, Errors> {
    let target = sidecar::sidecar_path(path);
    if write && target.symlink_metadata().is_ok() {
        let message = format!("{} exists and would be overwritten", target.display());
        return Err(Error::new(Code::Usage, message)
            .with_hint("correct it as it is, or move it away first")
            .into());
    }
    let options = args.options(path)?.0;
    let mut log = progress::open(path, &options, false)?;
    let written: Vec<(String, String)> = log
        .groups
        .iter()
        .flat_map(|g| &g.channels)
        .map(|c| (c.name.clone(), c.unit.clone()))
        .collect();
    let mut understood = options.clone();
    if write {
        fill_detected_settings(&mut understood, &log);
    }
    let (responses, spectra) = (log.responses.take(), std::mem::take(&mut log.spectra));
    let over_frequency = recording::frequency_data_table(responses.as_ref(), &spectra);
    let (mut found, rate_hz) = match log.groups.is_empty() && !over_frequency.is_empty() {
        true => {
            let found = FileSummary {
                text: format!("{}   {}\n", log.path, log.dialect),
                body: json!({ "file": log.path, "dialect": log.dialect }),
                repairs: Some(log.repairs),
                warnings: log.diagnostics,
                ..FileSummary::default()
            };
            (found, None)
        }
        false => {
            let mut log = preprocess::preprocess(log, &options)?;
            let surveys = parallel::try_map(&log.channels, |c| channel_statistics(&log, c))?;
            let all: Vec<usize> = (0..log.channels.len()).collect();
            let stuck = faults::find_stuck(&log, &all)?.stuck_warnings(&log, false);
            log.diagnostics.extend(stuck);
            let found = FileSummary {
                text: recording::survey(&log, &surveys),
                body: recording::json(&log, &surveys),
                repairs: Some(log.repairs),
                warnings: log.diagnostics,
                ..FileSummary::default()
            };
            (found, Some(log.rate_hz))
        }
    };
    found.text += &over_frequency;
    found.body["responses"] = json!(responses.as_ref().map(recording::responses));
    found.body["spectra"] = recording::spectra(&spectra);
    if write {
        let text = sidecar::write(&understood, rate_hz, &written);
        files::write_one(&target, text.as_bytes())?;
        output::print_note(&footer::written_files(&[target]));
    }
    Ok(found)
}

/// Findings about a log, next to what its sidecar states.
fn fill_detected_settings(options: &mut ReadOptions, log: &RawLog) {
    let (said, found) = (&mut options.dialect, &log.text_dialect);
    said.delimiter = said.delimiter.or(found.delimiter);
    said.decimal = said.decimal.or(found.decimal);
    said.encoding = said.encoding.take().or(found.encoding.clone());
    said.header_lines = said.header_lines.or(found.header_lines);
    // Of a text; other formats say themselves which numbers are times.
    let one = log
        .groups
        .first()
        .filter(|_| log.groups.len() == 1 && found.decimal.is_some());
    let Some(clock) = one.map(|group| &group.timing) else {
        return;
    };
    let Some(stamps) = &clock.stamps else {
        return;
    };
    if stamps.unit != "samples" {
        options
            .time_column
            .get_or_insert_with(|| stamps.name.clone());
        options.rate.get_or_insert(RateSource::TimeStamps);
    }
    if stamps.unit != "date-time" && stamps.unit != "samples" {
        options.time_unit.get_or_insert_with(|| stamps.unit.clone());
    }
}
