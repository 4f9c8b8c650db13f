//! `geardyn simulate`: motion in time.

use super::args::SimulateArgs;
use super::present::Outputs;
use super::{interrupt, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::simulate::SimulationResult;
use crate::report::simulation::SimulationReport;
use crate::scene::study::{ReadStudy, SimulateStudy};
use crate::scene::{self, Scene};

/// Integrates and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the motion.
pub fn run(args: &SimulateArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let flags = &args.study.flags;
    let study: SimulateStudy = scene.study(flags)?;
    if !study.running.history && (args.out.csv.is_some() || args.out.svg.is_some()) {
        let error = Error::new(
            Code::Conflict,
            "--csv and --svg need the history, which the study does not keep",
        );
        return Err(error
            .with_hint("omit --no-history (history = \"none\" in the study), or --csv and --svg")
            .into());
    }
    let outputs = Outputs::check(&args.out, &[""], &[], &scene.files())?;
    let machine = PreparedMachine::new(&scene.model)?;
    let report = report(&scene, &machine, &study, args.out.quiet).map_err(|e| {
        match SimulateStudy::listed(&scene, flags) {
            // What a scene alone asks for is refused at its study.
            Some(study) if flags.is_empty() && e.span.is_none() && e.code.exit_code() == 2 => {
                e.with_span(&study.span)
            }
            _ => e,
        }
    })?;
    outputs.present(&report)
}

/// The motion; at a terminal it says how far it is.
///
/// # Errors
/// Whatever is wrong with the machine or the motion.
pub fn report<'a>(
    scene: &'a Scene,
    machine: &'a PreparedMachine,
    study: &SimulateStudy,
    quiet: bool,
) -> Result<SimulationReport<'a>, Error> {
    let bar = progress::progress_bar("integrating", quiet);
    let cancel = interrupt::cancel_on_ctrl_c();
    let result =
        SimulationResult::simulate(scene, machine, study, &cancel, &|share| bar(Some(share)));
    bar(None);
    let result = result?;
    Ok(SimulationReport { scene, result })
}
