//! The command `geardyn check`: validates models, scenes, gear files, sidecars, logs and measured gears.

use std::path::Path;
use std::sync::Arc;

use serde_json::{Value, json};

use super::args::CheckArgs;
use super::{check_log, footer, output, render};
use crate::base::error::Errors;
use crate::base::flags::Flags;
use crate::base::load;
use crate::base::source_span::SourceFile;
use crate::base::text::pluralise;
use crate::plan;
use crate::plan::prepared_machine::PreparedMachine;
use crate::recording::sidecar;
use crate::report::check::FileSummary;
use crate::report::presentation::{Presentation, Provenance, document};
use crate::scene;
use crate::scene::gear_kind::PairKind;

/// Checks every file and returns the exit code: 0, or the highest of the errors.
///
/// # Errors
/// Standard output cannot be written.
pub fn run(args: &CheckArgs) -> Result<u8, Errors> {
    let (mut exit_code, mut documents) = (0, Vec::new());
    for path in &args.files {
        match summarise(path, args) {
            Ok(summary) if args.json => documents.push(document(&summary)?),
            Ok(summary) => {
                output::print(&summary.text())?;
                output::print_note(&footer::notes(&summary));
            }
            Err(errors) => {
                let highest = errors.as_slice().iter().map(|e| e.code.exit_code()).max();
                exit_code = exit_code.max(highest.unwrap_or(2));
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
    Ok(exit_code)
}

/// Errors of a file as JSON, with its path.
fn with_file_name(path: &Path, errors: &Errors) -> Value {
    let mut document = render::json(errors);
    if let Value::Object(map) = &mut document {
        let index = usize::from(map.contains_key("geardyn"));
        map.shift_insert(index, "file".to_string(), json!(path));
    }
    document
}

/// Summarises a file by its type.
fn summarise(path: &Path, args: &CheckArgs) -> Result<FileSummary, Errors> {
    if path.extension().is_none_or(|e| e != "toml") {
        return check_log::check(path, &args.log, args.write);
    }
    let source = load::load(path)?;
    if sidecar::is_sidecar(&source) {
        return summarise_sidecar(path, source, args);
    }
    if scene::gear_readings::is_readings_file(&source) {
        return summarise_readings(path, source);
    }
    if scene::measured_gear::is_measured_gear(&source) {
        return summarise_measured_gear(path, &source);
    }
    match scene::gear_kind::is_gear_file(&source) {
        true => summarise_gears(path, source),
        false => summarise_scene(path),
    }
}

/// Checks a sidecar by reading it; the listed logs must exist.
fn summarise_sidecar(
    path: &Path,
    source: Arc<SourceFile>,
    args: &CheckArgs,
) -> Result<FileSummary, Errors> {
    let flags = &args.log.keys.flags;
    let channels = sidecar::read(&source, flags)?.channels.len();
    let listed = sidecar::read_list(path, flags)?.map(|list| list.files);
    let of = match &listed {
        None => "a log".to_string(),
        Some(files) => pluralise(files.len(), "listed log"),
    };
    Ok(FileSummary {
        sources: vec![source],
        text: format!(
            "{}   sidecar of {of}, {channels} channels\n",
            path.display()
        ),
        body: json!({ "file": path, "sidecar": true, "channels": channels, "files": listed }),
        ..FileSummary::default()
    })
}

/// Checks the geometry of a gear pair, without load.
fn summarise_gears(path: &Path, source: Arc<SourceFile>) -> Result<FileSummary, Errors> {
    let flags = Flags::default();
    let mut sources = vec![source.clone()];
    let (title, what, teeth, warnings) = match scene::gear_kind::pair_kind(&source)? {
        PairKind::Cylindrical => {
            let mut file = scene::gear_file::read(&source, &flags)?;
            file.mesh.torques.clear();
            let result = plan::gear::run::run(&file)?;
            let teeth = file.members.map(|m| m.gear.teeth);
            (
                file.title,
                "cylindrical gears",
                Some(teeth),
                result.diagnostics,
            )
        }
        PairKind::NonCircular => {
            let file = scene::non_circular_file::read(&source, &flags)?;
            let result = plan::gear::non_circular::run(&file)?;
            sources = file.sources;
            (
                file.title,
                "non-circular gears",
                file.teeth,
                result.diagnostics,
            )
        }
        PairKind::Bevel => {
            let file = scene::bevel_file::read(&source, &flags)?;
            let result = plan::gear::bevel::run(&file)?;
            let teeth = file.members.each_ref().map(|m| m.teeth);
            (file.title, "bevel gears", Some(teeth), result.diagnostics)
        }
        kind @ (PairKind::Worm | PairKind::Crossed | PairKind::Helicoid) => {
            let sheet = plan::gear::space::run(kind, &source, &flags)?;
            (sheet.title, sheet.what, sheet.teeth, sheet.diagnostics)
        }
    };
    let (name, shown) = (path.display(), render::sanitise(&title));
    let of_teeth = teeth.map_or(String::new(), |[z1, z2]| format!(" of {z1} and {z2} teeth"));
    Ok(FileSummary {
        text: format!("{name}   {shown}\n  {what}{of_teeth}\n"),
        body: json!({ "file": path, "title": title, "gears": true, "teeth": teeth }),
        sources,
        warnings,
        ..FileSummary::default()
    })
}

/// Checks the measurements of an unknown gear by determining its candidates.
fn summarise_readings(path: &Path, source: Arc<SourceFile>) -> Result<FileSummary, Errors> {
    let file = scene::gear_readings::read(&source)?;
    let result = plan::gear::reversal::run(&file)?;
    let (teeth, candidates) = (file.readings.teeth, result.reversal.candidates.len());
    let (name, title) = (path.display(), render::sanitise(&file.title));
    Ok(FileSummary {
        text: format!(
            "{name}   {title}\n  readings of an unknown gear of {teeth} teeth, {}\n",
            pluralise(candidates, "candidate")
        ),
        body: json!({ "file": path, "title": file.title, "readings": true, "teeth": teeth, "candidates": candidates }),
        sources: vec![source],
        warnings: result.diagnostics,
        ..FileSummary::default()
    })
}

/// Checks a measured gear by evaluating its charts, without comparing the values with limits.
fn summarise_measured_gear(path: &Path, source: &Arc<SourceFile>) -> Result<FileSummary, Errors> {
    let gear = scene::measured_gear::read(source)?;
    let evaluation = plan::measure::run::run(&gear)?;
    let (teeth, charts, values) = (gear.gear.teeth, gear.charts.len(), evaluation.rows.len());
    let (name, title) = (path.display(), render::sanitise(&gear.title));
    Ok(FileSummary {
        text: format!(
            "{name}   {title}\n  measured gear of {teeth} teeth, {charts} charts, {values} values\n"
        ),
        body: json!({ "file": path, "title": gear.title, "measured_gear": true, "teeth": teeth,
            "charts": charts, "values": values }),
        sources: evaluation.sources,
        warnings: evaluation.diagnostics,
        ..FileSummary::default()
    })
}

/// Checks a model or a scene by preparing its machine and every study.
fn summarise_scene(path: &Path) -> Result<FileSummary, Errors> {
    let scene = scene::read(path)?;
    let machine = PreparedMachine::new(&scene.model)?;
    Errors::into_result(crate::study::check::refusals(&scene, &machine), || ())?;
    let (dofs, stay) = (machine.machine.dofs.len(), machine.model.n);
    let (elements, rigid) = (machine.machine.elements.len(), machine.model.rigid.len());
    let joints = match dofs - stay {
        0 => String::new(),
        _ => format!(", {stay} after rigid joints"),
    };
    let studies = match scene.studies.len() {
        0 => String::new(),
        n => format!(", {n} studies"),
    };
    let (name, title) = (path.display(), render::sanitise(&scene.model.title));
    let modes = if rigid == 1 { "mode" } else { "modes" };
    Ok(FileSummary {
        text: format!(
            "{name}   {title}\n  {elements} elements, {dofs} degrees of freedom{joints}, {rigid} rigid-body {modes}{studies}\n"
        ),
        body: json!({
            "file": path,
            "title": scene.model.title,
            "elements": elements,
            "dofs": dofs,
            "dofs_after_rigid_joints": stay,
            "rigid_body_modes": rigid,
            "studies": scene.studies.len(),
        }),
        sources: scene.sources,
        warnings: machine.warnings(),
        ..FileSummary::default()
    })
}
