//! `geardyn check`: validates models, scenes, sidecars and measured gears.

use std::path::Path;
use std::sync::Arc;

use serde_json::{Value, json};

use super::args::CheckArgs;
use super::{check_log, footer, output, render};
use crate::base::error::{Diagnostic, Errors};
use crate::base::load;
use crate::base::source_span::SourceFile;
use crate::plan;
use crate::plan::prepared_machine::PreparedMachine;
use crate::report;
use crate::report::presentation::Provenance;
use crate::scene;

/// Checks every file; 2 where one is wrong.
///
/// # Errors
/// Standard output cannot be written.
pub fn run(args: &CheckArgs) -> Result<u8, Errors> {
    let (mut exit, mut documents) = (0, Vec::new());
    for path in &args.files {
        match summarise(path, args) {
            Ok((_, document, _)) if args.json => documents.push(document),
            Ok((text, _, doubts)) => {
                output::print(&text)?;
                output::print_note(&doubts);
            }
            Err(errors) => {
                let worst = errors.as_slice().iter().map(|e| e.code.exit_code()).max();
                exit = exit.max(worst.unwrap_or(2));
                match args.json {
                    true => documents.push(with_file_name(path, &errors)),
                    false => {
                        output::print_note(&render::render_errors(&errors, render::use_colour()))
                    }
                }
            }
        }
    }
    if args.json {
        let document = match documents.len() {
            1 => documents.remove(0),
            _ => {
                json!({ "geardyn": Provenance::default().header(), "files": documents, "warnings": [] })
            }
        };
        output::document(&document)?;
    }
    Ok(exit)
}

/// The errors of a file, with its name.
fn with_file_name(path: &Path, errors: &Errors) -> Value {
    let mut document = render::json(errors);
    if let Value::Object(map) = &mut document {
        let at = usize::from(map.contains_key("geardyn"));
        map.shift_insert(at, "file".to_string(), json!(path));
    }
    document
}

/// What a file is understood as: for a terminal, as JSON, and the warnings about it.
fn summarise(path: &Path, args: &CheckArgs) -> Result<(String, Value, String), Errors> {
    if path.extension().is_none_or(|e| e != "toml") {
        let log = check_log::check(path, &args.log, args.write)?;
        return Ok((log.text, log.json, log.diagnostics));
    }
    let source = load::load(path)?;
    if scene::sidecar::is_sidecar(&source) {
        let settings = scene::sidecar::read(&source)?;
        let text = format!(
            "{}   sidecar of a log, {} channels\n",
            path.display(),
            settings.channels.len()
        );
        let document = json!({ "geardyn": Provenance::of_plan(&[source], &[], &[]).header(), "file": path, "sidecar": true,
            "channels": settings.channels.len(), "warnings": [] });
        return Ok((text, document, String::new()));
    }
    if scene::measured_gear::is_measured_gear(&source) {
        return summarise_measured_gear(path, &source);
    }
    let result = check(path)?;
    let doubts = footer::warnings(&result.diagnostics);
    Ok((result.line(), result.json(), doubts))
}

/// A measured gear is checked by evaluating it: its columns are read, nothing is held against limits.
fn summarise_measured_gear(
    path: &Path,
    source: &Arc<SourceFile>,
) -> Result<(String, Value, String), Errors> {
    let gear = scene::measured_gear::read(source)?;
    let answer = plan::measure::run::run(&gear)?;
    let (charts, values) = (gear.charts.len(), answer.rows.len());
    let text = format!(
        "{}   {}\n  measured gear of {} teeth, {charts} charts, {values} values\n",
        path.display(),
        render::sanitise(&gear.title),
        gear.gear.teeth
    );
    let document = json!({ "geardyn": Provenance::of_plan(&answer.sources, &[], &[]).header(), "file": path, "title": gear.title,
        "measured_gear": true, "teeth": gear.gear.teeth, "charts": charts, "values": values,
        "warnings": report::json::warnings(&answer.diagnostics) });
    Ok((text, document, footer::warnings(&answer.diagnostics)))
}

struct SceneSummary {
    header: Value,
    path: String,
    title: String,
    dofs: usize,
    stay: usize,
    elements: usize,
    rigid: usize,
    studies: usize,
    diagnostics: Vec<Diagnostic>,
}

fn check(path: &Path) -> Result<SceneSummary, Errors> {
    let scene = scene::read(path)?;
    let machine = PreparedMachine::new(&scene.model)?;
    Errors::into_result(crate::study::check::refusals(&scene, &machine), || ())?;
    Ok(SceneSummary {
        header: Provenance::of_plan(&scene.sources, &[], &[]).header(),
        path: path.display().to_string(),
        title: scene.model.title.clone(),
        dofs: machine.machine.dofs.len(),
        stay: machine.model.n,
        elements: machine.machine.elements.len(),
        rigid: machine.model.rigid.len(),
        studies: scene.studies.len(),
        diagnostics: machine.warnings(),
    })
}

impl SceneSummary {
    fn line(&self) -> String {
        let joints = match self.dofs - self.stay {
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
            render::sanitise(&self.title),
            self.elements,
            self.dofs,
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
            "freedoms": self.dofs,
            "freedoms_after_rigid_joints": self.stay,
            "rigid_body_modes": self.rigid,
            "studies": self.studies,
            "warnings": report::json::warnings(&self.diagnostics),
        })
    }
}
