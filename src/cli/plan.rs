//! `geardyn plan`: what would be computed.

use std::path::Path;

use super::args::StudyArgs;
use super::{output, study};
use crate::base::error::Errors;
use crate::plan::prepared::Prepared;
use crate::plan::stages::Plan;
use crate::report;
use crate::scene;

/// Prints the plan of a study of modes.
///
/// # Errors
/// Whatever is wrong with the file or the flags.
pub fn run(model: &Path, args: &StudyArgs, as_json: bool) -> Result<u8, Errors> {
    let study = study::of(args)?;
    let scene = scene::read(model)?;
    let prepared = Prepared::new(&scene.model)?;
    let plan = Plan::modes(&prepared, &study);
    if as_json {
        let document = report::json::plan(&scene.sources, &plan, &prepared.warnings());
        output::print(&format!("{document:#}\n"))?;
    } else {
        output::print(&report::table::plan(&plan))?;
    }
    Ok(0)
}
