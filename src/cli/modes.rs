//! `geardyn modes`: the natural modes of a machine.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::args::ModesArgs;
use super::files::{self, OutputFiles};
use super::{footer, modes_study, output, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::modes::state_space::StateSpace;
use crate::plan::modes_run::{self, ModesResult};
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::stages::{ModesPlan, StageDecision};
use crate::report;
use crate::report::json::ShapeDetail;
use crate::scene;

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the solution.
pub fn run(args: &ModesArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.model)?;
    let study = modes_study::from_args(&args.study, &scene)?;
    let inputs: Vec<PathBuf> = scene.files();
    let mut files = OutputFiles::new(&outputs(args)?, &inputs)?;
    let machine = PreparedMachine::new(&scene.model)?;
    let plan = ModesPlan::plan_modes(&machine, &study);
    let result = progress::with_spinner("finding modes", args.out.quiet, || {
        modes_run::run(&machine, &study, &plan)
    })?;
    let chosen = selected_mode(args, &result)?;
    if let Some(path) = &args.out.csv {
        files.write(path, report::modes_csv::modes(&machine, &result).as_bytes())?;
    }
    if let Some(path) = &args.out.svg {
        for (path, plot) in draw_plots(path, &machine, &result) {
            files.write(&path, plot.as_bytes())?;
        }
    }
    if let (Some(path), Some((space, _))) = (&args.study.state_space, &result.state_space) {
        files.write(path, &state_space(path, space)?)?;
    }
    let written = files.finish()?;
    if args.out.json {
        let document = report::json::modes(
            &scene.sources,
            &machine,
            &result,
            ShapeDetail { top: args.top },
        );
        output::document(&document)?;
        return Ok(0);
    }
    let text = match (chosen, &result.campbell) {
        (Some(k), _) => report::modes_table::mode(&machine, &result, k),
        (None, Some(found)) => report::modes_table::crossings(found, machine.model.rigid.len()),
        (None, None) => report::modes_table::modes(&machine, &result),
    };
    let mut text = text;
    if let Some((space, parts)) = &result.state_space {
        text += &report::state_space_tables::participation(space, parts);
    }
    if let Some(reduction) = &result.reduction {
        text += &report::state_space_tables::reduction(reduction);
    }
    output::print(&text)?;
    if !args.out.quiet {
        output::print_note(&epilogue(&plan, &result, &written));
    }
    Ok(0)
}

/// Every file this command will write, with names that say their format.
fn outputs(args: &ModesArgs) -> Result<Vec<PathBuf>, Error> {
    let mut all: Vec<PathBuf> = args.out.csv.iter().cloned().collect();
    if let Some(path) = &args.out.svg {
        files::ends(path, &["svg"])?;
        all.push(path.clone());
        all.extend(
            args.study
                .campbell
                .is_none()
                .then(|| files::sibling_path(path, "energies")),
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

fn selected_mode(args: &ModesArgs, result: &ModesResult) -> Result<Option<usize>, Error> {
    let Some(number) = args.mode else {
        return Ok(None);
    };
    if (1..=result.modes.len()).contains(&number) {
        return Ok(Some(number - 1));
    }
    let message = format!(
        "there is no mode {number}: the answer holds modes 1 to {}",
        result.modes.len()
    );
    Err(Error::new(Code::OutOfRange, message))
}

/// Modes drawn at once.
const PANELS: usize = 8;

/// Rows of the plot of energies.
const ROWS: usize = 20;

/// The plots of an answer and where each goes.
fn draw_plots(
    path: &Path,
    machine: &PreparedMachine,
    result: &ModesResult,
) -> Vec<(PathBuf, String)> {
    if let Some(found) = &result.campbell {
        return vec![(
            path.to_path_buf(),
            report::campbell::draw(found, machine.model.rigid.len()),
        )];
    }
    vec![
        (
            path.to_path_buf(),
            report::mode_shape_plot::draw_mode_shapes(machine, result, PANELS),
        ),
        (
            files::sibling_path(path, "energies"),
            report::energy_matrix_plot::draw_energy_matrix(machine, result, ROWS),
        ),
    ]
}

/// What was done and left out, warnings, and what was written.
pub fn epilogue(plan: &ModesPlan, result: &ModesResult, written: &[PathBuf]) -> String {
    let mut text = String::from("\n");
    for (_, name, decision) in &plan.stages {
        match (*name, decision) {
            (
                "undamped modes" | "few modes" | "complex modes" | "operating point"
                | "rigid joints",
                StageDecision::Runs(what),
            ) => {
                text += &format!("{name}: {what}\n");
            }
            ("operating point" | "complex modes", StageDecision::LeftOut(why)) => {
                text += &format!("left out {name}: {why}\n")
            }
            _ => {}
        }
    }
    text += &footer::warnings(&result.diagnostics);
    text += &footer::written_files(written);
    text
}
