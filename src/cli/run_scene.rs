//! `geardyn run`: all studies listed in a scene.

use serde_json::{Value, json};

use super::accuracy::AccuracyReport;
use super::args::RunArgs;
use super::harmonic_balance::HarmonicBalanceReport;
use super::response::ResponseReport;
use super::run_up::RunUpReport;
use super::te::TransmissionReport;
use super::{interrupt, modes, output, progress, simulate, stability};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::plan::modes_run;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::stages::ModesPlan;
use crate::report;
use crate::report::json::ShapeDetail;
use crate::scene::study::{ModesStudy, StudyKind};
use crate::scene::{self, Scene};

/// What one study gave.
struct StudyReport {
    text: String,
    json: Value,
    epilogue: String,
    exit: u8,
}

/// Carries out every study in its order.
///
/// # Errors
/// Whatever is wrong with the file or a study.
pub fn run(args: &RunArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    if scene.studies.is_empty() {
        let error = Error::new(
            Code::MissingKey,
            format!("{} lists no [[study]]", args.scene.display()),
        );
        return Err(error.with_hint("write [[study]] and below it kind = \"modes\", \"simulate\", \"accuracy\", \"stability\", \"response\", \"run_up\", \"te\" or \"harmonic_balance\"; or call the command of the analysis").into());
    }
    let stop = interrupt::cancel_on_ctrl_c();
    let mut documents = Vec::new();
    let mut exit = 0;
    let quiet = args.quiet || args.json;
    let title = &scene.model.title;
    if !args.json && !title.is_empty() {
        output::print(&format!("{title}\n\n"))?;
    }
    for study in &scene.studies {
        let (name, done) = match &study.kind {
            StudyKind::Modes(study) => ("modes", run_modes(&scene, study, quiet)),
            StudyKind::Simulate(study) => (
                "simulate",
                simulate::simulate(&scene, study, &stop, quiet).map(|result| StudyReport {
                    text: simulate::text(&result),
                    json: simulate::json(&result, &scene),
                    epilogue: simulate::epilogue(&result),
                    exit: simulate::exit_code(&result),
                }),
            ),
            StudyKind::Accuracy(study) => (
                "accuracy",
                AccuracyReport::new(&scene, study, quiet, &stop).map(|measured| StudyReport {
                    text: measured.text(),
                    json: measured.json(&scene),
                    epilogue: measured.epilogue().to_string(),
                    exit: measured.exit_code(),
                }),
            ),
            StudyKind::Response(study) => (
                "response",
                ResponseReport::new(&scene, study, false, quiet).map(|found| StudyReport {
                    text: found.text(),
                    json: found.json(&scene),
                    epilogue: found.epilogue(),
                    exit: 0,
                }),
            ),
            StudyKind::HarmonicBalance(study) => (
                "harmonic_balance",
                HarmonicBalanceReport::new(&scene, study, quiet).map(|found| StudyReport {
                    text: found.text(),
                    json: found.json(&scene),
                    epilogue: found.epilogue(),
                    exit: 0,
                }),
            ),
            StudyKind::RunUp(study) => (
                "run_up",
                RunUpReport::new(&scene, study).map(|found| StudyReport {
                    text: found.text(),
                    json: found.json(&scene),
                    epilogue: found.epilogue(),
                    exit: 0,
                }),
            ),
            StudyKind::Transmission(study) => (
                "te",
                TransmissionReport::new(&scene, study, quiet).map(|traced| StudyReport {
                    text: traced.text(),
                    json: traced.json(&scene),
                    epilogue: traced.epilogue(),
                    exit: 0,
                }),
            ),
            StudyKind::Stability(study) => (
                "stability",
                stability::run_study(&scene, study, quiet, &stop).map(|found| StudyReport {
                    text: report::stability_table::table(&found),
                    json: report::stability::json(&scene.sources, &found),
                    epilogue: stability::epilogue(&found),
                    exit: stability::exit_code(&found),
                }),
            ),
        };
        let done = done.map_err(|e| match e.span {
            Some(_) => e,
            None => e.with_span(&study.span),
        })?;
        if !args.json {
            output::print(&format!(
                "{}── {name}\n",
                if documents.is_empty() { "" } else { "\n" }
            ))?;
            output::print(&done.text)?;
            if !args.quiet {
                output::print_note(&done.epilogue);
            }
        }
        documents.push(json!({ "study": name, "answer": done.json }));
        exit = exit.max(done.exit);
        if interrupt::is_raised() {
            exit = interrupt::EXIT_INTERRUPTED;
            break;
        }
    }
    if args.json {
        let document = json!({ "geardyn": report::json::header(&scene.sources, &[]), "title": title, "studies": documents, "warnings": [] });
        output::document(&document)?;
    }
    Ok(exit)
}

fn run_modes(scene: &Scene, study: &ModesStudy, quiet: bool) -> Result<StudyReport, Error> {
    let machine = PreparedMachine::new(&scene.model)?;
    let plan = ModesPlan::plan_modes(&machine, study);
    let answer = progress::with_spinner("finding modes", quiet, || {
        modes_run::run(&machine, study, &plan)
    })?;
    Ok(StudyReport {
        text: report::modes_table::modes(&machine, &answer),
        json: report::json::modes(&scene.sources, &machine, &answer, ShapeDetail::default()),
        epilogue: modes::epilogue(&plan, &answer, &[]),
        exit: 0,
    })
}
