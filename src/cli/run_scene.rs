//! The command `geardyn run`: all studies of a scene.

use std::path::PathBuf;

use serde_json::json;

use super::args::RunArgs;
use super::files::{self, OutputFiles};
use super::{
    accuracy, browser, footer, interrupt, modes, output, present, response, simulate, stability, te,
};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::plan::prepared_machine::PreparedMachine;
use crate::report::page::{Section, page};
use crate::report::presentation::{Presentation, Provenance, document};
use crate::scene::study::StudyKind;
use crate::scene::{self, Scene};

/// Runs the studies of a scene in the order of the file and returns the exit code.
///
/// # Errors
/// Errors of the scene file, of a study or of the output files.
pub fn run(args: &RunArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    if scene.studies.is_empty() {
        let error = Error::new(
            Code::MissingKey,
            format!("{} lists no [[study]]", args.scene.display()),
        );
        return Err(error.with_hint("write [[study]] and below it kind = \"modes\", \"simulate\", \"accuracy\", \"stability\", \"response\", \"run_up\", \"te\" or \"harmonic_balance\"; or call the command of the analysis").into());
    }
    let html: Vec<PathBuf> = browser::check(&args.page)?.into_iter().cloned().collect();
    // The names of the figures follow from the results; a placeholder checks that the folder is writable before the studies run.
    let drawings = args.svg.iter().map(|folder| folder.join("1.svg"));
    let planned: Vec<PathBuf> = html.iter().cloned().chain(drawings).collect();
    let mut files = OutputFiles::new(&planned, std::slice::from_ref(&args.scene))?;
    // From here on the first interrupt ends the current study, and the remaining ones are not started.
    let cancel = interrupt::cancel_on_ctrl_c();
    let (mut documents, mut sections, mut exit_code) = (Vec::new(), Vec::new(), 0);
    let mut drawings: Vec<(PathBuf, String)> = Vec::new();
    let title = &scene.model.title;
    if !args.json && !title.is_empty() {
        output::print(&format!("{title}\n\n"))?;
    }
    let machine = PreparedMachine::new(&scene.model)?;
    let figures = !html.is_empty() || args.svg.is_some();
    for study in &scene.studies {
        let outcome = report(
            &scene,
            &machine,
            &study.kind,
            figures,
            args.quiet || args.json,
        );
        let (name, result) = match outcome {
            Ok(report) => report,
            // Studies finished before an interrupt are reported; without any, the interrupt is returned as the error.
            Err(e) if e.code == Code::Interrupted && !documents.is_empty() => break,
            Err(e) if e.span.is_some() => return Err(e.into()),
            Err(e) => return Err(e.with_span(&study.span).into()),
        };
        let result = &*result;
        if !args.json {
            let gap = if documents.is_empty() { "" } else { "\n" };
            output::print(&format!("{gap}── {name}\n{}", result.text()))?;
            if !args.quiet {
                output::print_note(&footer::notes(result));
            }
        }
        if !html.is_empty() {
            sections.push(Section::new(name, result, result.figures()?));
        }
        if let Some(folder) = &args.svg {
            let path = folder.join(format!("{}-{name}.svg", documents.len() + 1));
            for figure in result.figures()? {
                drawings.push((files::sibling_path(&path, figure.suffix), figure.svg()));
            }
        }
        documents.push(json!({ "study": name, "result": document(result)? }));
        exit_code = exit_code.max(present::exit_code(result));
        if cancel.is_cancelled() {
            break;
        }
    }
    let is_complete = !cancel.is_cancelled();
    if !is_complete {
        exit_code = interrupt::EXIT_INTERRUPTED;
    }
    for path in html.iter().filter(|_| is_complete) {
        let command = present::command_line();
        let title = if title.is_empty() { &command } else { title };
        files.write(path, page(title, &command, &sections).as_bytes())?;
    }
    for (path, svg) in drawings.iter().filter(|_| is_complete) {
        files.write(path, svg.as_bytes())?;
    }
    let written = files.finish()?;
    if is_complete {
        browser::open(&args.page)?;
    }
    if args.json {
        let sources = &scene.sources;
        let provenance = Provenance::of_plan(sources, &[], &[]);
        let document = json!({ "geardyn": provenance.header(), "title": title, "studies": documents, "interrupted": !is_complete, "warnings": [] });
        output::document(&document)?;
    }
    if !args.quiet {
        let finished = documents.len();
        let missing = scene.studies.len() - finished;
        let status = match missing {
            0 => String::new(),
            _ => format!(
                "interrupted: {finished} of {} studies finished\n",
                scene.studies.len()
            ),
        };
        let note = footer::written_files(&written) + &footer::not_written(&planned, is_complete);
        output::print_note(&(status + &note));
    }
    Ok(exit_code)
}

/// Runs a study: name of its kind and result; `figures` requests the data of its figures.
fn report<'a>(
    scene: &'a Scene,
    machine: &'a PreparedMachine,
    study: &StudyKind,
    figures: bool,
    quiet: bool,
) -> Result<(&'static str, Box<dyn Presentation + 'a>), Error> {
    Ok(match study {
        StudyKind::Modes(study) => (
            "modes",
            Box::new(modes::report(scene, machine, study, quiet)?),
        ),
        StudyKind::Simulate(study) => (
            "simulate",
            Box::new(simulate::report(scene, machine, study, quiet)?),
        ),
        StudyKind::Accuracy(study) => ("accuracy", accuracy::report(scene, machine, study, quiet)?),
        StudyKind::Response(study) => (
            "response",
            Box::new(response::over_frequency(
                scene, machine, study, figures, quiet,
            )?),
        ),
        StudyKind::HarmonicBalance(study) => (
            "harmonic_balance",
            Box::new(response::periodic(scene, machine, study, quiet)?),
        ),
        StudyKind::RunUp(study) => (
            "run_up",
            Box::new(response::over_speed(scene, machine, study, quiet)?),
        ),
        StudyKind::Transmission(study) => {
            ("te", Box::new(te::report(scene, machine, study, quiet)?))
        }
        StudyKind::Stability(study) => (
            "stability",
            Box::new(stability::report(scene, machine, study, quiet)?),
        ),
    })
}
