//! `geardyn modes`: the natural modes of a machine.

use std::io::Write;
use std::path::Path;

use super::args::ModesArgs;
use super::present::Outputs;
use super::{destination, files, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::modes::state_space::StateSpace;
use crate::plan::modes_run::{self, ModesResult};
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::stages::ModesPlan;
use crate::report::modes::{ModesReport, ShapeDetail};
use crate::scene::study::ModesStudy;
use crate::scene::{self, Scene};

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the solution.
pub fn run(args: &ModesArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.model)?;
    let study: ModesStudy = scene.study(&args.study.flags)?;
    let space = &args.study.file("state-space");
    if let Some(path) = space {
        files::check_extension(path, &["json", "csv", "mat"])?;
    }
    let figures: &[&str] = match study.campbell {
        Some(_) => &[""],
        None => &["", "energies"],
    };
    let mut outputs = Outputs::check(&args.out, figures, &[space], &scene.files())?;
    let machine = PreparedMachine::new(&scene.model)?;
    let mut report = report(&scene, &machine, &study, args.out.quiet)?;
    report.detail = ShapeDetail { top: args.top };
    report.mode = selected_mode(args, &report.result)?;
    if let (Some(path), Some((space, _))) = (space, &report.result.state_space) {
        outputs.write(path, |to| write_state_space(path, space, to))?;
    }
    outputs.present(&report)
}

/// The modes.
///
/// # Errors
/// Whatever is wrong with the machine or the solution.
pub fn report<'a>(
    scene: &'a Scene,
    machine: &'a PreparedMachine,
    study: &ModesStudy,
    quiet: bool,
) -> Result<ModesReport<'a>, Error> {
    let plan = ModesPlan::plan_modes(machine, study);
    let result = progress::with_spinner("computing modes", quiet, || {
        modes_run::run(machine, study, &plan)
    })?;
    Ok(ModesReport {
        scene,
        machine,
        plan,
        result,
        detail: ShapeDetail::default(),
        mode: None,
    })
}

/// Writes the state-space form in the format that the file's name asks for.
fn write_state_space(path: &Path, space: &StateSpace, mut to: &mut dyn Write) -> Result<(), Error> {
    let written = match path.extension().and_then(|e| e.to_str()) {
        Some("json") => write!(to, "{:#}", space.to_json()),
        Some("csv") => space.write_csv(&mut to),
        _ => space.write_mat(&mut to),
    };
    written.map_err(|e| destination::output_error(path, &e))
}

fn selected_mode(args: &ModesArgs, result: &ModesResult) -> Result<Option<usize>, Error> {
    let Some(number) = args.mode else {
        return Ok(None);
    };
    if (1..=result.modes.len()).contains(&number) {
        return Ok(Some(number - 1));
    }
    let message = format!(
        "there is no mode {number}; the result has modes 1 to {}",
        result.modes.len()
    );
    Err(Error::new(Code::OutOfRange, message))
}
