//! `geardyn check LOG`: what was understood of a log, before it is used.

use std::path::Path;

use serde_json::{Value, json};

use super::log_args::LogArgs;
use super::{diagnostic, output, progress};
use crate::base::error::{Error, Errors};
use crate::recording::settle;
use crate::recording::survey::{Survey, survey};
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
    let (settings, sidecar) = args.settings(path)?;
    let raw = progress::open(path, &settings, false)?;
    let written: Vec<(String, String)> = raw
        .groups
        .iter()
        .flat_map(|g| &g.channels)
        .map(|c| (c.name.clone(), c.unit.clone()))
        .collect();
    if raw.groups.is_empty()
        && let Some(responses) = &raw.responses
    {
        return Ok(Understood {
            text: report::log_tables::responses(&raw.path, &raw.dialect, responses),
            json: json!({ "geardyn": report::json::log_header(&[]), "file": raw.path, "dialect": raw.dialect,
                "responses": report::recording::responses(responses), "warnings": report::json::warnings(&raw.warnings) }),
            doubts: raw
                .warnings
                .iter()
                .map(|w| diagnostic::warning(w, diagnostic::colour()))
                .collect(),
        });
    }
    let recording = settle::settle(raw, &settings)?;
    let surveys = recording
        .channels
        .iter()
        .map(|c| survey(&recording, c))
        .collect::<Result<Vec<Survey>, Error>>()?;
    let mut doubts = String::new();
    for repair in &recording.repairs {
        doubts += &format!(
            "{}: {}\n",
            repair.kind,
            diagnostic::harmless(&repair.message)
        );
    }
    for warning in &recording.warnings {
        doubts += &diagnostic::warning(warning, diagnostic::colour());
    }
    if let Some(sidecar) = sidecar {
        doubts += &format!("read {}\n", sidecar.display());
    }
    if write {
        let target = scene::log::beside(path);
        output::check(std::slice::from_ref(&target), &[path.to_path_buf()])?;
        output::write(
            &target,
            scene::log::write(&settings, recording.rate_hz, &written).as_bytes(),
        )?;
        doubts += &format!("wrote {}\n", target.display());
    }
    let mut document = report::recording::json(&recording, &surveys);
    if let Value::Object(map) = &mut document {
        map.shift_insert(0, "geardyn".to_string(), report::json::log_header(&[]));
    }
    Ok(Understood {
        text: report::log_tables::survey(&recording, &surveys),
        json: document,
        doubts,
    })
}
