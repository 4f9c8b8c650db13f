//! `geardyn modes`: the natural modes of a machine.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::args::ModesArgs;
use super::files::{self, Files};
use super::{epilogue, output, progress, study};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::modes::state_space::StateSpace;
use crate::plan::prepared::Prepared;
use crate::plan::run::{self, Answer};
use crate::plan::stages::{Plan, Verdict};
use crate::report;
use crate::report::json::Detail;
use crate::scene;

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the solution.
pub fn run(args: &ModesArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.model)?;
    let study = study::of(&args.study, &scene)?;
    let inputs: Vec<PathBuf> = scene.files();
    let mut files = Files::new(&outputs(args)?, &inputs)?;
    let prepared = Prepared::new(&scene.model)?;
    let plan = Plan::modes(&prepared, &study);
    let answer = progress::busy("finding modes", args.quiet, || {
        run::run(&prepared, &study, &plan)
    })?;
    let chosen = chosen(args, &answer)?;
    if let Some(path) = &args.csv {
        files.write(path, report::csv::modes(&prepared, &answer).as_bytes())?;
    }
    if let Some(path) = &args.svg {
        for (path, picture) in pictures(path, &prepared, &answer) {
            files.write(&path, picture.as_bytes())?;
        }
    }
    if let (Some(path), Some((space, _))) = (&args.study.state_space, &answer.state_space) {
        files.write(path, &state_space(path, space)?)?;
    }
    let written = files.finish()?;
    if args.json {
        let document =
            report::json::modes(&scene.sources, &prepared, &answer, Detail { top: args.top });
        output::document(&document)?;
        return Ok(0);
    }
    let text = match (chosen, &answer.campbell) {
        (Some(k), _) => report::table::mode(&prepared, &answer, k),
        (None, Some(found)) => report::table::crossings(found, prepared.linear.rigid.len()),
        (None, None) => report::table::modes(&prepared, &answer),
    };
    let mut text = text;
    if let Some((space, parts)) = &answer.state_space {
        text += &report::system_tables::participation(space, parts);
    }
    if let Some(reduction) = &answer.reduction {
        text += &report::system_tables::reduction(reduction);
    }
    output::print(&text)?;
    if !args.quiet {
        output::tell(&epilogue(&plan, &answer, &written));
    }
    Ok(0)
}

/// Every file this command will write, with names that say their format.
fn outputs(args: &ModesArgs) -> Result<Vec<PathBuf>, Error> {
    let mut all: Vec<PathBuf> = args.csv.iter().cloned().collect();
    if let Some(path) = &args.svg {
        files::ends(path, &["svg"])?;
        all.push(path.clone());
        all.extend(
            args.study
                .campbell
                .is_none()
                .then(|| files::beside(path, "energies")),
        );
    }
    if let Some(path) = &args.study.state_space {
        files::ends(path, &["json", "csv", "mat"])?;
        all.push(path.clone());
    }
    Ok(all)
}

/// The state-space form in the format that the file's name asks for.
fn state_space(path: &Path, space: &StateSpace) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    let written = match path.extension().and_then(|e| e.to_str()) {
        Some("json") => write!(bytes, "{:#}", space.to_json()),
        Some("csv") => space.write_csv(&mut bytes),
        _ => space.write_mat(&mut bytes),
    };
    let failed = |e| {
        Error::new(
            Code::OutputFailed,
            format!("{} could not be written: {e}", path.display()),
        )
    };
    written.map(|()| bytes).map_err(failed)
}

fn chosen(args: &ModesArgs, answer: &Answer) -> Result<Option<usize>, Error> {
    let Some(number) = args.mode else {
        return Ok(None);
    };
    if (1..=answer.modes.len()).contains(&number) {
        return Ok(Some(number - 1));
    }
    let message = format!(
        "there is no mode {number}: the answer holds modes 1 to {}",
        answer.modes.len()
    );
    Err(Error::new(Code::OutOfRange, message))
}

/// Modes drawn at once.
const PANELS: usize = 8;

/// Rows of the picture of energies.
const ROWS: usize = 20;

/// The pictures of an answer and where each goes.
fn pictures(path: &Path, prepared: &Prepared, answer: &Answer) -> Vec<(PathBuf, String)> {
    if let Some(found) = &answer.campbell {
        return vec![(
            path.to_path_buf(),
            report::campbell::picture(found, prepared.linear.rigid.len()),
        )];
    }
    vec![
        (
            path.to_path_buf(),
            report::shapes::mode_shapes(prepared, answer, PANELS),
        ),
        (
            files::beside(path, "energies"),
            report::energy_bars::energy_matrix(prepared, answer, ROWS),
        ),
    ]
}

/// What was done and left out, doubts, and what was written.
pub fn epilogue(plan: &Plan, answer: &Answer, written: &[PathBuf]) -> String {
    let mut text = String::from("\n");
    for (_, name, verdict) in &plan.steps {
        match (*name, verdict) {
            (
                "undamped modes" | "few modes" | "complex modes" | "operating point"
                | "rigid joints",
                Verdict::Runs(what),
            ) => {
                text += &format!("{name}: {what}\n");
            }
            ("operating point" | "complex modes", Verdict::LeftOut(why)) => {
                text += &format!("left out {name}: {why}\n")
            }
            _ => {}
        }
    }
    text += &epilogue::warnings(&answer.warnings);
    text += &epilogue::written(written);
    text
}
