//! `geardyn check`: is a file what it means to be?

use std::path::Path;
use std::sync::Arc;

use serde_json::{Value, json};

use super::args::CheckArgs;
use super::{check_log, diagnostic, epilogue, output};
use crate::base::error::{Errors, Warning};
use crate::base::load;
use crate::base::place::Source;
use crate::plan;
use crate::plan::prepared::Prepared;
use crate::report;
use crate::scene;

/// Checks every file; 2 where one is wrong.
///
/// # Errors
/// Standard output cannot be written.
pub fn run(args: &CheckArgs) -> Result<u8, Errors> {
    let (mut exit, mut documents) = (0, Vec::new());
    for path in &args.files {
        match understood(path, args) {
            Ok((_, document, _)) if args.json => documents.push(document),
            Ok((text, _, doubts)) => {
                output::print(&text)?;
                output::tell(&doubts);
            }
            Err(errors) => {
                let worst = errors.list().iter().map(|e| e.code.exit()).max();
                exit = exit.max(worst.unwrap_or(2));
                match args.json {
                    true => documents.push(refused(path, &errors)),
                    false => output::tell(&diagnostic::errors(&errors, diagnostic::colour())),
                }
            }
        }
    }
    if args.json {
        let document = match documents.len() {
            1 => documents.remove(0),
            _ => {
                json!({ "geardyn": report::json::log_header(&[]), "files": documents, "warnings": [] })
            }
        };
        output::document(&document)?;
    }
    Ok(exit)
}

/// The errors of a file, with its name.
fn refused(path: &Path, errors: &Errors) -> Value {
    let mut document = diagnostic::json(errors);
    if let Value::Object(map) = &mut document {
        let at = usize::from(map.contains_key("geardyn"));
        map.shift_insert(at, "file".to_string(), json!(path));
    }
    document
}

/// What a file is understood as: for a terminal, as JSON, and the doubts about it.
fn understood(path: &Path, args: &CheckArgs) -> Result<(String, Value, String), Errors> {
    if path.extension().is_none_or(|e| e != "toml") {
        let log = check_log::check(path, &args.log, args.write)?;
        return Ok((log.text, log.json, log.doubts));
    }
    let source = load::load(path)?;
    if scene::log::is_sidecar(&source) {
        let settings = scene::log::read(&source)?;
        let text = format!(
            "{}   sidecar of a log, {} channels\n",
            path.display(),
            settings.channels.len()
        );
        let document = json!({ "geardyn": report::json::header(&[source], &[]), "file": path, "sidecar": true,
            "channels": settings.channels.len(), "warnings": [] });
        return Ok((text, document, String::new()));
    }
    if scene::measured::is_measured(&source) {
        return measured(path, &source);
    }
    let found = check(path)?;
    let doubts = epilogue::warnings(&found.warnings);
    Ok((found.line(), found.json(), doubts))
}

/// A measured gear is checked by evaluating it: its columns are read, nothing is held against limits.
fn measured(path: &Path, source: &Arc<Source>) -> Result<(String, Value, String), Errors> {
    let gear = scene::measured::read(source)?;
    let answer = plan::measure::run::run(&gear)?;
    let (charts, values) = (gear.charts.len(), answer.rows.len());
    let text = format!(
        "{}   {}\n  measured gear of {} teeth, {charts} charts, {values} values\n",
        path.display(),
        diagnostic::harmless(&gear.title),
        gear.gear.teeth
    );
    let document = json!({ "geardyn": report::json::header(&answer.sources, &[]), "file": path, "title": gear.title,
        "measured_gear": true, "teeth": gear.gear.teeth, "charts": charts, "values": values,
        "warnings": report::json::warnings(&answer.warnings) });
    Ok((text, document, epilogue::warnings(&answer.warnings)))
}

struct Found {
    header: Value,
    path: String,
    title: String,
    freedoms: usize,
    stay: usize,
    elements: usize,
    rigid: usize,
    studies: usize,
    warnings: Vec<Warning>,
}

fn check(path: &Path) -> Result<Found, Errors> {
    let scene = scene::read(path)?;
    let prepared = Prepared::new(&scene.model)?;
    Errors::or(crate::study::check::refusals(&scene, &prepared), || ())?;
    Ok(Found {
        header: report::json::header(&scene.sources, &[]),
        path: path.display().to_string(),
        title: scene.model.title.clone(),
        freedoms: prepared.machine.freedoms.len(),
        stay: prepared.linear.n,
        elements: prepared.machine.elements.len(),
        rigid: prepared.linear.rigid.len(),
        studies: scene.studies.len(),
        warnings: prepared.warnings(),
    })
}

impl Found {
    fn line(&self) -> String {
        let joints = match self.freedoms - self.stay {
            0 => String::new(),
            _ => format!(", {} after rigid joints", self.stay),
        };
        let studies = if self.studies > 0 {
            format!(", {} studies", self.studies)
        } else {
            String::new()
        };
        format!(
            "{}   {}\n  {} elements, {} freedoms{joints}, {} rigid-body {}{studies}\n",
            self.path,
            diagnostic::harmless(&self.title),
            self.elements,
            self.freedoms,
            self.rigid,
            if self.rigid == 1 { "mode" } else { "modes" },
        )
    }

    fn json(&self) -> Value {
        json!({
            "geardyn": self.header,
            "file": self.path,
            "title": self.title,
            "elements": self.elements,
            "freedoms": self.freedoms,
            "freedoms_after_rigid_joints": self.stay,
            "rigid_body_modes": self.rigid,
            "studies": self.studies,
            "warnings": report::json::warnings(&self.warnings),
        })
    }
}
