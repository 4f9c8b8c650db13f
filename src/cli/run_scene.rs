//! `geardyn run`: every study a scene lists.

use serde_json::{Value, json};

use super::accuracy::Measured;
use super::args::RunArgs;
use super::harmonic_balance::Balanced;
use super::response::Linear;
use super::run_up::Raised;
use super::te::Traced;
use super::{interrupt, modes, output, progress, simulate, stability};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::plan::prepared::Prepared;
use crate::plan::run;
use crate::plan::stages::Plan;
use crate::report;
use crate::report::json::Detail;
use crate::scene::study::{ModesStudy, StudyKind};
use crate::scene::{self, Scene};

/// What one study gave.
struct Done {
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
        return Err(error.hint("write [[study]] and below it kind = \"modes\", \"simulate\", \"accuracy\", \"stability\", \"response\", \"run_up\", \"te\" or \"harmonic_balance\"; or call the command of the analysis").into());
    }
    let stop = interrupt::stop();
    let mut documents = Vec::new();
    let mut exit = 0;
    let quiet = args.quiet || args.json;
    let title = &scene.model.title;
    if !args.json && !title.is_empty() {
        output::print(&format!("{title}\n\n"))?;
    }
    for study in &scene.studies {
        let (name, done) = match &study.kind {
            StudyKind::Modes(study) => ("modes", natural(&scene, study, quiet)),
            StudyKind::Simulate(study) => (
                "simulate",
                simulate::moved(&scene, study, &stop, quiet).map(|moved| Done {
                    text: simulate::text(&moved),
                    json: simulate::json(&moved, &scene),
                    epilogue: simulate::epilogue(&moved),
                    exit: simulate::exit(&moved),
                }),
            ),
            StudyKind::Accuracy(study) => (
                "accuracy",
                Measured::new(&scene, study, quiet, &stop).map(|measured| Done {
                    text: measured.text(),
                    json: measured.json(&scene),
                    epilogue: measured.epilogue().to_string(),
                    exit: measured.exit(),
                }),
            ),
            StudyKind::Response(study) => (
                "response",
                Linear::new(&scene, study, false, quiet).map(|found| Done {
                    text: found.text(),
                    json: found.json(&scene),
                    epilogue: found.epilogue(),
                    exit: 0,
                }),
            ),
            StudyKind::HarmonicBalance(study) => (
                "harmonic_balance",
                Balanced::new(&scene, study, quiet).map(|found| Done {
                    text: found.text(),
                    json: found.json(&scene),
                    epilogue: found.epilogue(),
                    exit: 0,
                }),
            ),
            StudyKind::RunUp(study) => (
                "run_up",
                Raised::new(&scene, study).map(|found| Done {
                    text: found.text(),
                    json: found.json(&scene),
                    epilogue: found.epilogue(),
                    exit: 0,
                }),
            ),
            StudyKind::Transmission(study) => (
                "te",
                Traced::new(&scene, study, quiet).map(|traced| Done {
                    text: traced.text(),
                    json: traced.json(&scene),
                    epilogue: traced.epilogue(),
                    exit: 0,
                }),
            ),
            StudyKind::Stability(study) => (
                "stability",
                stability::study_of(&scene, study, quiet, &stop).map(|found| Done {
                    text: report::stability_table::table(&found),
                    json: report::stability::json(&scene.sources, &found),
                    epilogue: stability::epilogue(&found),
                    exit: stability::exit(&found),
                }),
            ),
        };
        let done = done.map_err(|e| match e.place {
            Some(_) => e,
            None => e.at(&study.place),
        })?;
        if !args.json {
            output::print(&format!(
                "{}── {name}\n",
                if documents.is_empty() { "" } else { "\n" }
            ))?;
            output::print(&done.text)?;
            if !args.quiet {
                output::tell(&done.epilogue);
            }
        }
        documents.push(json!({ "study": name, "answer": done.json }));
        exit = exit.max(done.exit);
        if interrupt::is_raised() {
            exit = interrupt::INTERRUPTED;
            break;
        }
    }
    if args.json {
        let document = json!({ "geardyn": report::json::header(&scene.sources, &[]), "title": title, "studies": documents, "warnings": [] });
        output::document(&document)?;
    }
    Ok(exit)
}

fn natural(scene: &Scene, study: &ModesStudy, quiet: bool) -> Result<Done, Error> {
    let prepared = Prepared::new(&scene.model)?;
    let plan = Plan::modes(&prepared, study);
    let answer = progress::busy("finding modes", quiet, || run::run(&prepared, study, &plan))?;
    Ok(Done {
        text: report::table::modes(&prepared, &answer),
        json: report::json::modes(&scene.sources, &prepared, &answer, Detail::default()),
        epilogue: modes::epilogue(&plan, &answer, &[]),
        exit: 0,
    })
}
